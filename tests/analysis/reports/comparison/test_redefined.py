"""Values that a version defined anew are not compared with those of earlier versions."""

from __future__ import annotations

import pytest

from granwave.analysis.reports.comparison.compare import compare_runs
from granwave.analysis.reports.comparison.compared_value import DIFFERENT_MEANING
from granwave.analysis.reports.inputs import read_inputs
from granwave.workflows.cli.compare import text_of
from tests.analysis.reports.comparison.runs import in_one_line
from tests.helpers.made_up.synthetic_report import write_run
from tests.helpers.made_up.synthetic_scan import write_json

SPEED = "wave_speed_m_s"


def runs_of(place, *versions: str, **values):
    runs = [
        write_run(
            place / f"run-{n}",
            figures=False,
            versions={"granwave": version} if version else {},
            wave_speed_m_s=500.0 + n,
            **values,
        )
        for n, version in enumerate(versions)
    ]
    return compare_runs(read_inputs(runs, place).runs)


@pytest.mark.parametrize(
    ("versions", "earlier"),
    [
        (("1.0.0", "1.1.0"), "run-0"),
        (("1.1.0", "0.3.0", "1.12.3"), "run-1"),
        (("2.0.0", "1.0.7", "0.2.0"), "run-1 and run-2"),
    ],
)
def test_wave_speeds_of_two_definitions_have_no_ratio(tmp_path, versions, earlier):
    comparison = runs_of(tmp_path, *versions)
    assert comparison.without_ratio[SPEED] == DIFFERENT_MEANING
    assert SPEED not in comparison.table.index
    (note,) = [note for note in comparison.notes if "wave speed" in note]
    assert note.startswith(f"The wave speed in results before version 1.1 ({earlier}) refers to")
    assert note in in_one_line(text_of(comparison))


@pytest.mark.parametrize("versions", [("1.0.0", "0.3.0"), ("1.1.0", "1.2.0"), ("", "1.1.0")])
def test_wave_speeds_of_one_definition_are_compared(tmp_path, versions):
    comparison = runs_of(tmp_path, *versions)
    assert SPEED not in comparison.without_ratio
    assert SPEED in comparison.table.index
    assert not [note for note in comparison.notes if "wave speed" in note]


def test_a_requested_value_is_shown_without_ratio(tmp_path):
    before, after = runs_of(tmp_path, "1.0.0", "1.1.0").runs
    asked = compare_runs([before.run, after.run], quantities=[SPEED])
    (value,) = asked.values
    assert value.without_ratio == DIFFERENT_MEANING and value.ratio is None
    assert any("wave speed" in note for note in asked.notes)
    other = compare_runs([before.run, after.run], quantities=["peak_force_N"])
    assert not any("wave speed" in note for note in other.notes)


@pytest.mark.needs_extension("continuum")
def test_peak_forces_on_blocks_of_two_definitions_have_no_ratio(tmp_path):
    blocks = []
    for version, force in (("1.0.0", 3003.0), ("1.1.0", 2699.0)):
        block = tmp_path / version
        block.mkdir()
        (block / "case.toml").write_text("[punch]\ndiameter = 0.010\nmass = 0.1\nvelocity = 10.0\n")
        versions = {"granwave": version}
        summary = {"name": version, "kind": "continuum", "peak_force_N": force, "end_time_s": 1e-3}
        write_json(block / "summary.json", summary | {"versions": versions, "energy_input_J": 5.0})
        blocks.append(block)
    comparison = compare_runs(read_inputs(blocks, tmp_path).runs)
    assert comparison.without_ratio["peak_force_N"] == DIFFERENT_MEANING
    (note,) = [note for note in comparison.notes if "peak force on a block" in note]
    assert "before version 1.1 (1.0.0) refers to single steps" in note
