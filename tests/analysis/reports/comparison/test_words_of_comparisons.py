"""Words of comparisons: lists, reasons, order of requested values, loads in labels, lines."""

from __future__ import annotations

import pytest

from granwave.analysis.reports.comparison.compare import compare_runs
from granwave.analysis.reports.comparison.compared_value import ComparedValue
from granwave.analysis.reports.comparison.ends import truncated_runs
from granwave.analysis.reports.comparison.energy_inputs import inputs_in_words
from granwave.analysis.reports.comparison.subjects import by_reason, compared_runs
from granwave.analysis.reports.comparison.value_words import partial_note, sentence
from granwave.analysis.reports.inputs import read_inputs
from granwave.analysis.reports.report import html_page, lead
from granwave.analysis.reports.setting import setting_of
from granwave.workflows.cli.compare import text_of
from tests.helpers.made_up.synthetic_report import build, write_run

CHAIN = {
    "packing.kind": "chain",
    "packing.size": 8,
    "packing.diameter": 0.01,
    "material.name": "brass",
    "load.kind": "striker",
}
STRIKER = {"diameter": 0.02, "velocity": [0.0, 0.0, 1.0], "material": {"name": "steel"}}


def subjects(tmp_path, *runs):
    """Made-up runs a, b and so on, with these values of the summary and labels."""
    folders = [
        write_run(tmp_path / name, figures=False, **values)
        for name, values in zip("abcdef", runs, strict=False)
    ]
    return compared_runs(read_inputs(folders, tmp_path).runs)


def test_truncated_values_are_listed_by_their_runs():
    numbers = (1.0, 2.0, 3.0)
    values = [
        ComparedValue("wall_peak_force_N", numbers, "Peak force", "N", incomplete=frozenset({2})),
        ComparedValue("zone_depth_90_m", numbers, "Zone, depth", "m", incomplete=frozenset({0, 1})),
        ComparedValue("base_arrival_s", numbers, "Arrival", "s", incomplete=frozenset({2})),
    ]
    assert partial_note(values, ["a", "b", "c"]) == (
        "Truncated by the end of the run (* in tables), and not part of ratios, in c: peak force; "
        "arrival. In a, b: zone, depth."
    )


def test_requested_values_are_in_the_order_of_their_ratios(tmp_path):
    runs = subjects(tmp_path, {}, {})
    values = [
        ComparedValue("wall_peak_force_N", (1.0, 1.1), "Peak force", "N"),
        ComparedValue("base_arrival_s", (1.0, 2.0), "Arrival", "s"),
    ]
    assert sentence(values, runs, asked=True) == (
        "The requested values differ most in arrival, 1 s (a) and 2 s (b), a ratio of 2; peak "
        "force, 1 N (a) and 1.1 N (b), a ratio of 1.1."
    )


def test_a_reason_of_several_runs_is_in_the_plural(tmp_path):
    first, second = subjects(tmp_path, {}, {})
    why = "it has no vertical section of several rows"
    assert by_reason({first: why}) == f"a ({why})"
    assert by_reason({first: why, second: why}) == (
        "a, b (they have no vertical section of several rows)"
    )
    contacts = "its contacts are loaded from the start"
    assert by_reason(dict.fromkeys((first, second), contacts)).endswith(
        "(their contacts are loaded from the start)"
    )


@pytest.mark.parametrize(
    ("strikers", "words"),
    [
        ([STRIKER], "struck by steel, 20 mm, 1 m/s"),
        ([STRIKER, STRIKER], "struck by 2 × steel, 20 mm, 1 m/s"),
        ([{"velocity": [0.0, 0.0, 2.0]}], "struck by brass, 10 mm, 2 m/s"),
        ([STRIKER, STRIKER | {"velocity": [0.0, 0.0, 3.0]}], "struck by 2 spheres at up to 3 m/s"),
    ],
)
def test_strikers_are_named(strikers, words):
    setting = setting_of(CHAIN | {"striker": strikers})
    assert setting == f"chain of 8, brass, 10 mm, {words}"


def test_mass_and_velocity_of_strikers_and_their_labels(tmp_path):
    striker = {"touches": [1], "diameter": 0.02, "material": "steel", "velocity": [0, 0, 2.0]}
    first, second = subjects(tmp_path, {"energy_input_J": 0.05}, {"energy_input_J": 0.08})
    second.run.case.update({"load.kind": "striker", "striker": [striker]})
    assert inputs_in_words([second]) == "80 mJ (40 g at 2 m/s) in b"
    _, label = [run.label for run in compared_runs([first.run, second.run])]
    assert label == "b: struck by steel, 20 mm, 2 m/s"


def test_labels_have_material_and_velocity_before_the_size(tmp_path):
    labels = [
        {"packing__size": "[4,4,4]", "material": "brass", "load__velocity": 1},
        {"packing__size": "[5,5,5]", "material": "steel", "load__velocity": 2},
    ]
    first, second = [run.label for run in subjects(tmp_path, *labels)]
    assert (first, second) == ("a: brass, 1 m/s, 4 × 4 × 4", "b: steel, 2 m/s, 5 × 5 × 5")


def test_friction_of_a_frictionless_run_is_complete_at_any_end(tmp_path):
    """The energy and its fraction are complete in the same runs."""
    names = ["friction_fraction", "energy_dissipated_friction_J"]
    rough = dict.fromkeys(names, 0.2)
    runs = subjects(
        tmp_path,
        {"end_time_s": 1e-3} | dict.fromkeys(names, 0.0),
        {"end_time_s": 2e-3, "contact__friction": 0.3} | rough,
        {"end_time_s": 3e-3, "contact__friction": 0.3} | rough,
    )
    fraction, energy = [truncated_runs([name], runs).get(name, frozenset()) for name in names]
    assert fraction == energy and runs[1] in fraction and runs[0] not in fraction


def test_headline_and_lines_at_the_terminal(tmp_path):
    runs = subjects(
        tmp_path,
        {"wall_peak_force_N": 1500.0, "energy_input_J": 0.05, "contact__friction": 0.1},
        {"wall_peak_force_N": 1200.0, "energy_input_J": 0.05, "contact__friction": 0.2},
    )
    comparison = compare_runs([run.run for run in runs])
    assert comparison.headline == comparison.paragraphs[0]
    assert comparison.headline.startswith("b protects the bottom better")
    text = text_of(comparison)
    sentences, _, tables = text.partition("quantity ")
    assert max(map(len, sentences.splitlines())) <= 100
    assert comparison.headline in " ".join(sentences.split())
    (row,) = [row for row in tables.splitlines() if row.endswith("wall_peak_force_N")]
    assert row.startswith("Peak force on the bottom")


def test_values_that_still_grow_are_marked_in_reports(tmp_path):
    """The columns of six runs are narrow; the word for a packing without faults is explained."""
    growing = {"incomplete_values": ["n_plastic_contacts"], "n_plastic_contacts": 12}
    folders = [write_run(tmp_path / name, figures=False, **growing) for name in "abcdef"]
    page = html_page(build(folders, tmp_path))
    assert 'title="Truncated by the end of the run.">12*</span>' in page
    assert "* Truncated by the end of the run.</p>" in page
    assert '<table class="many">' in page
    assert 'title="identical spheres' in lead("fcc 4 × 4 × 3, brass, ideal")
    assert "title" not in lead("run ideal-1, brass, ideal shape")
