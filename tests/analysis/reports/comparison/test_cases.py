"""Labels of runs, and differences of their cases."""

from __future__ import annotations

import dataclasses

import pytest

from granwave.analysis.reports.comparison.cases import ids_in_words
from granwave.analysis.reports.comparison.compare import compare_runs
from granwave.analysis.reports.comparison.subjects import compared_runs, value_text
from granwave.analysis.reports.inputs import read_inputs
from granwave.analysis.reports.kinds import ReportKind
from tests.analysis.reports.comparison.runs import compared, drawn
from tests.helpers.made_up.synthetic_report import write_run
from tests.helpers.made_up.synthetic_scan import write_scan

pytestmark = pytest.mark.xdist_group("comparison of runs")  # its fixture is made once


class BlockKind(ReportKind):
    """Runs of a block, as provided by an extension."""

    result_kind = "block"
    noun = "continuum run"


def test_chains_to_the_bead(place):
    comparison = compared(place, "chain", "mixed")
    differences = comparison.differences
    assert "material of grains 3 to 4" in differences.index and "replace" not in differences.index
    assert differences.loc["material of grains 3 to 4", "mixed"] == "aluminium"
    assert any("end at different times" in note for note in comparison.notes)
    figures = drawn(comparison)
    axes = figures["energies"].figure.axes
    assert [panel.get_ylabel() for panel in axes] == ["Kinetic", "Elastic"]  # nothing dissipates
    assert len(figures["peak_force_depth"].figure.axes) == 1  # a layer is a bead
    assert "fronts" in figures and "bottom_force" not in figures


def test_labels_show_the_diameter(tmp_path):
    """Lattice, size and diameter differ; a fourth difference is an ellipsis, and the velocity is
    before the size.
    """
    changes = {
        "a": {"packing__kind": "fcc", "packing__size": "[8, 8, 5]"},
        "b": {"packing__kind": "hcp", "packing__size": "[9, 9, 6]", "packing__diameter": 0.006},
    }
    runs = [write_run(tmp_path / name, figures=False, **own) for name, own in changes.items()]
    assert compared_runs(read_inputs(runs, tmp_path).runs)[1].label == "b: hcp, 9 × 9 × 6, 6 mm"
    fast = changes["b"] | {"load__velocity": 9}
    runs[1] = write_run(tmp_path / "c", figures=False, **fast)
    assert compared_runs(read_inputs(runs, tmp_path).runs)[1].label == "c: hcp, 9 m/s, 9 × 9 × 6, …"


def test_labels_name_the_support_before_the_law(tmp_path):
    """Two chains that end at a wall and at a bar differ in this, whatever their law; the bottom of
    the chain on a bar is none.
    """
    bar = {"bar.length": 0.6, "bar.area": 2.8e-5, "bar.elements": 200}
    wall = {"material.name": "glass", "contact.law": "hertz", "boundary.bottom": "wall"}
    rod = {"material.name": "steel", "contact.law": "elastoplastic", "boundary.bottom": "free"}
    places = [write_run(tmp_path / name, figures=False) for name in "ab"]
    runs = [
        dataclasses.replace(run, case=run.case | case)
        for run, case in zip(read_inputs(places, tmp_path).runs, (wall, rod | bar), strict=True)
    ]
    assert [run.label for run in compared_runs(runs)] == [
        "a: glass, bottom wall, hertz",
        "b: steel, bar of 600 mm, elastoplastic",
    ]


def test_a_run_with_the_usual_values_has_a_description(tmp_path):
    """Its label has these values, unless its name has one of them."""
    changes = {"b1": {}, "fast": {"load__velocity": 9.0}, "large": {"packing__diameter": 4e-3}}
    changes["b4"] = {}
    for name, own in changes.items():
        write_run(tmp_path / name, figures=False, **own)
    runs = read_inputs([tmp_path / name for name in changes], tmp_path).runs
    first, fast, *_ = [run.label for run in compared_runs(runs)]
    assert fast == "fast: 9 m/s"
    assert first == "b1: 5 m/s, 10 mm"


def test_labels_name_a_plate_and_an_early_end(tmp_path):
    """The table of a plate is longer than a label; an early end is named without another
    difference.
    """
    plate = '{plate = {mass = 0.5, stiffness = 2e7}, material = "steel"}'
    changes = {"a": {}, "b": {"boundary__bottom": plate}, "c": {"run__end_time": 8e-5}}
    for name, own in changes.items():
        write_run(tmp_path / name, figures=False, **own)
    runs = read_inputs([tmp_path / name for name in changes], tmp_path).runs
    labels = [run.label for run in compared_runs(runs)]
    assert labels == ["a: bottom wall", "b: bottom plate", "c: until 80 µs"]


def test_a_point_without_scatter_is_named_by_its_scatter(tmp_path):
    """The seed has no effect without scatter; runs with names of their own keep them."""
    points = [
        {"packing.diameter_scatter": scatter, "packing.seed": seed}
        for scatter, seed in ((0, 1), (2e-6, 1), (2e-6, 2), (5e-6, 1))
    ]
    scan = write_scan(tmp_path / "scand", points)
    runs = list(read_inputs([scan], tmp_path).results())
    labels = [run.label for run in compared_runs(runs)]
    assert labels[0] == "scand #1: diameter scatter 0"
    assert labels[2] == "scand #3: diameter scatter 2 µm, seed 2"
    named = [dataclasses.replace(run, label=f"run-{n}") for n, run in enumerate(runs)]
    assert compared_runs(named)[0].label == "run-0"


def test_keys_that_a_law_does_not_use_are_no_difference(tmp_path):
    """Elastic contacts have neither a yield strength nor a yield factor; the difference of the laws
    is listed.
    """
    laws = {"soft": "hertz", "strong": "hertz", "yielding": "elastoplastic"}
    strengths = {"soft": 1e8, "strong": 5e8, "yielding": 5e8}
    runs = {
        name: write_run(
            tmp_path / name,
            figures=False,
            contact__law=law,
            contact__yield_factor=1.6 if name == "soft" else 1.7,
            material__yield_strength=strengths[name],
        )
        for name, law in laws.items()
    }
    inputs = read_inputs([runs["soft"], runs["strong"]], tmp_path)
    assert compare_runs(inputs.runs).case_rows == []
    inputs = read_inputs([runs["soft"], runs["yielding"]], tmp_path)
    rows = {row.what: row.values for row in compare_runs(inputs.runs).case_rows}
    assert rows == {"contact.law": ("hertz", "elastoplastic")}


def test_no_initial_indentation_is_none():
    assert value_text("contact.initial_overlap", {"contact.initial_overlap": 0.0}) == "none"
    assert value_text("contact.initial_overlap", {"contact.initial_overlap": 2e-6}) == "2 µm"
    assert value_text("load.velocity", {"load.velocity": 0.0}) == "0 m/s"


@pytest.mark.parametrize(
    ("ids", "words"),
    [
        ([4], "grain 4"),
        ([3, 4, 5], "grains 3 to 5"),
        ([1, 2, 7], "grains 1 to 2, 7"),
        ([2, 4, 6, 8, 10], "grains 2, 4, … 10 (every 2nd)"),
        ([1, 4, 7, 10, 13], "grains 1, 4, … 13 (every 3rd)"),
        ([1, 3, 7, 12, 20], "5 grains (1, 3, 7, 12, …)"),
    ],
)
def test_ids_in_words(ids, words):
    assert ids_in_words(ids) == words


def test_unlike_kinds_say_what_they_are(place):
    """Keys that only one of packing and block has are not compared."""
    runs = list(read_inputs([place / "fcc", place / "hcp"], place).results())
    case = {"punch.mass": 1.0}
    other = dataclasses.replace(runs[1], label="block", kind=BlockKind(), case=case)
    comparison = compare_runs([runs[0], other])
    assert list(comparison.differences.index) == ["kind of run", "setting"]
    assert "Not drawn: block (it is a continuum run, without grains)." in comparison.caption(
        "peak_force_depth"
    )
    assert "Not drawn: block (the force on its bottom is not recorded)." in comparison.caption(
        "bottom_force"
    )
