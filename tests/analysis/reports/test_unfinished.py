"""Reports of runs that were interrupted, and of runs that end before their values are final."""

from __future__ import annotations

import dataclasses

import pytest

from granwave.analysis.reports.comparison.compare import compare_runs
from granwave.analysis.reports.inputs import ReportInputs, read_inputs
from granwave.analysis.reports.outline import build_report
from granwave.workflows import load_case, run_case
from tests.helpers.made_up.synthetic_report import blocks, notes

pytestmark = pytest.mark.xdist_group("unfinished runs")  # its fixture is made once

ASKED = 1e-3  # s


@pytest.fixture(scope="module")
def inputs(tmp_path_factory) -> ReportInputs:
    """A small packing, stopped before the wave reaches its bottom."""
    folder = tmp_path_factory.mktemp("unfinished")
    case = load_case("fcc-small", {"packing.size": [6, 6, 4], "run.end_time": 2e-5})
    run_case(case, folder / "early", figures=False)
    return read_inputs([folder / "early"], folder)


def interrupted(inputs: ReportInputs) -> ReportInputs:
    """The run as if it had been interrupted."""
    (run,) = inputs.runs
    record = run.record | {"state": "interrupted"}
    stopped = dataclasses.replace(run, record=record, case=run.case | {"run.end_time": ASKED})
    return dataclasses.replace(inputs, items=(stopped,))


def test_an_interrupted_run_is_no_finished_run(inputs):
    """The time that it reached stands first, before the values, and only once."""
    first = blocks(build_report(interrupted(inputs)), "short")
    assert first[0].tone == "bad"
    assert first[0].text == (
        "Unfinished, with values up to the last output: early (interrupted at 20 µs of 1 ms)."
    )
    assert first[1].tone == "lead" and "nfinished" not in first[1].text
    texts = [note.text for note in notes(build_report(interrupted(inputs)), "short")]
    assert ["20 µs of 1 ms" in text for text in texts].count(True) == 1
    assert not any(text.startswith("Every run finished") for text in texts)


def test_a_finished_run_shows_what_its_end_limits(inputs):
    """The wave has not reached the bottom, and the zone still grows."""
    (run,) = inputs.runs
    growing = dataclasses.replace(run, summary=run.summary | {"zone_growing": ["depth"]})
    report = build_report(dataclasses.replace(inputs, items=(growing,)))
    texts = [note.text for note in notes(report, "short")]
    unloaded = "The wave does not reach the bottom before the end of the run: at 20 µs in early."
    assert unloaded in texts
    assert any("plastic zone still grows at the end of the run: depth" in text for text in texts)
    assert not any("ranked" in text for text in texts)
    assert not any("nfinished" in text for text in texts)


def test_forces_that_still_rise_have_no_ratio_with_equal_ends(inputs, tmp_path):
    """Neither the table nor a sentence compares them, since the notes say that they are unknown."""
    (run,) = inputs.runs
    early = dataclasses.replace(run, summary=run.summary | {"zone_growing": ["depth"]})
    fast = {"packing.size": [6, 6, 4], "run.end_time": 2e-5, "load.velocity": 10}
    run_case(load_case("fcc-small", fast), tmp_path / "fast", figures=False)
    (other,) = read_inputs([tmp_path / "fast"], tmp_path).runs
    comparison = compare_runs([early, other])
    values = {value.name: value for value in comparison.values}
    for name in ("wall_peak_force_N", "wall_impulse_Ns", "plastic_zone_depth_m"):
        assert values[name].is_truncated and values[name].ratio is None
    assert values["peak_force_N"].ratio is not None
    assert "on the bottom" not in comparison.sentence
    assert "that are complete in every run" in comparison.sentence


def test_a_single_bead_has_no_contact_force(inputs, tmp_path):
    """It is not compared as a force of zero, and its missing figure has a reason in words."""
    run_case(load_case("elastic-impact", {"packing.size": 1}), tmp_path / "bead", figures=False)
    (bead,) = read_inputs([tmp_path / "bead"], tmp_path).runs
    comparison = compare_runs([bead, *inputs.runs])
    lacking = comparison.data("peak_force_depth").lacking
    assert list(lacking.values()) == ["no force reaches two layers"]
    values = {value.name: value.values for value in comparison.values}
    for name in ("peak_force_N", "peak_force_with_walls_N", "peak_overlap_m"):
        assert name not in values
    assert "0 N" not in comparison.sentence
