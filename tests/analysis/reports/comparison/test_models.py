"""Comparisons of one packing under several contact laws, and of packings with unlike laws."""

from __future__ import annotations

import pytest

from granwave.analysis.reports.comparison.compare import compare_runs
from granwave.analysis.reports.comparison.comparison import Comparison
from granwave.analysis.reports.inputs import read_inputs
from tests.helpers.made_up.synthetic_report import write_run

LAW = "contact.law"
FACTOR = "the yield factor of the contact law (1.6 in a, 2.8 in b)"


def comparison_of(tmp_path, *cases) -> Comparison:
    """Comparison of made-up runs: a has a peak force of 1.5 kN, b of 1.2 kN, c of 3 kN."""
    forces = {"a": 1500.0, "b": 1200.0, "c": 3000.0}
    runs = []
    for (name, force), case in zip(forces.items(), cases, strict=False):
        values = {
            "wall_peak_force_N": force,
            "energy_input_J": 0.05,
            "zone_depth_90_interpolated_m": force * 1e-5,
            "zone_cut": [],
        }
        labels = {key.replace(".", "__"): value for key, value in case.items()}
        runs.append(write_run(tmp_path / name, figures=False, **labels, **values))
    return compare_runs(list(read_inputs(runs, tmp_path).runs))


@pytest.mark.parametrize(
    ("key", "values", "words"),
    [
        (LAW, ("hertz", "bilinear"), "the contact law (hertz in a, bilinear in b)"),
        ("contact.yield_factor", (1.6, 2.8), FACTOR),
        ("run.timestep", (2e-8, 1e-8), "the timestep (20 ns in a, 10 ns in b)"),
    ],
)  # fmt: skip
def test_a_model_of_one_packing_protects_nothing(tmp_path, key, values, words):
    first, second = values
    comparison = comparison_of(tmp_path, {key: first}, {key: second})
    assert comparison.protection == [
        f"The peak force on the bottom depends on {words}: it is 1.2 kN in b, compared with 1.5 kN "
        "in a (1.25 times as high).",
        "The 90 % depth of the plastic zone, interpolated between layers, depends on "
        f"{words}: it is 12 mm in b, compared with 15 mm in a (1.25 times as deep).",
    ]


def test_three_models(tmp_path):
    laws = ("hertz", "bilinear", "thornton")
    comparison = comparison_of(tmp_path, *({LAW: law} for law in laws))
    assert comparison.protection[0] == (
        "The peak force on the bottom depends on the contact law (hertz in a, bilinear in b, "
        "thornton in c): it is 1.2 kN in b, compared with 1.5 kN in a (1.25 times as high) and "
        "3 kN in c (2.5 times as high)."
    )


def test_packings_under_unlike_laws_are_ranked_with_a_caveat(tmp_path):
    comparison = comparison_of(
        tmp_path,
        {LAW: "hertz", "packing.size": [4, 4, 3]},
        {LAW: "bilinear", "packing.size": [4, 4, 6]},
    )
    first, depth = comparison.protection
    assert first.startswith("b protects the bottom better: its peak force is 1.2 kN")
    assert first.endswith(
        " The runs also differ in the contact law (hertz in a, bilinear in b), which may change "
        "the order: compare the packings with one model."
    )
    assert "contact law" not in depth


def test_friction_is_a_property_of_the_packing(tmp_path):
    comparison = comparison_of(tmp_path, {"contact.friction": 0.2}, {"contact.friction": 0.4})
    assert comparison.protection[0].startswith("b protects the bottom better")
    assert "also differ" not in comparison.protection[0]


def test_names_of_runs_may_have_braces(tmp_path):
    runs = []
    for name, law in (("{a}", "hertz"), ("b{", "bilinear")):
        values = {"wall_peak_force_N": 1000.0 + 500.0 * len(runs), "energy_input_J": 0.05}
        runs.append(write_run(tmp_path / name, figures=False, contact__law=law, **values))
    comparison = compare_runs(list(read_inputs(runs, tmp_path).runs))
    assert comparison.protection[0] == (
        "The peak force on the bottom depends on the contact law (hertz in {a}, bilinear in b{): "
        "it is 1 kN in {a}, compared with 1.5 kN in b{ (1.5 times as high)."
    )
