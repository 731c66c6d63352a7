"""Runs of a comparison that end at different times: values that the earlier end truncates."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest

from granwave.analysis.reports.comparison.blocks import value_table
from granwave.analysis.reports.comparison.compare import compare_runs
from granwave.analysis.reports.comparison.comparison import Comparison
from granwave.analysis.reports.comparison.curves import (
    SampledCurve,
    bottom_record,
    has_own_peak,
    has_peak_at_bottom,
)
from granwave.analysis.reports.comparison.ends import _is_final_at, truncated_names
from granwave.analysis.reports.comparison.subjects import compared_runs
from granwave.analysis.reports.inputs import read_inputs
from granwave.analysis.reports.results import results_section
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.workflows import load_case, run_case
from granwave.workflows.cli.compare import text_of
from tests.analysis.reports.comparison.runs import in_one_line

pytestmark = pytest.mark.xdist_group("ends of compared runs")  # its fixture is made once

SMALL = {"packing.size": [6, 6, 4]}
SLOW = {"packing.size": [6, 6, 6], "material": "ptfe", "contact.law": "hertz"}
ENDS = {"early": 4e-5, "full": 2e-4}
FINAL = 4e-4  # end at which the dissipated fractions no longer grow
#: Values of the early run that the longer run changes.
TRUNCATED = ("wall_peak_force_N", "wall_impulse_Ns", "n_plastic_spheres", "impactor_velocity_m_s")


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """One small packing, stopped before and after the wave reaches the bottom, and a faster one."""
    folder = tmp_path_factory.mktemp("ends")
    for name, end in ENDS.items():
        changes = SMALL | {"run.end_time": end}
        run_case(load_case("fcc-small", changes), folder / name, figures=False)
    fast = SMALL | {"run.end_time": ENDS["full"], "load.velocity": 10}
    run_case(load_case("fcc-small", fast), folder / "fast", figures=False)
    for name, velocity in (("final", 5), ("final-fast", 10)):
        changes = SMALL | {"run.end_time": FINAL, "load.velocity": velocity}
        run_case(load_case("fcc-small", changes), folder / name, figures=False)
    return folder


def compared(place, *names: str, **options) -> Comparison:
    return compared_in([place / name for name in names], **options)


def texts_of(row) -> list[str]:
    return [cell.text for cell in row]


def marks_of(texts) -> list[bool]:
    return [text.endswith("*") for text in texts]


def compared_in(folders, **options) -> Comparison:
    runs = []
    for folder in folders:
        runs += read_inputs([folder], folder.parent).runs
    return compare_runs(runs, **options)


def test_one_case_that_stops_earlier_is_no_comparison_of_results(place):
    """The first sentence names the ends; nothing is ranked."""
    comparison = compared(place, "early", "full")
    first = (
        "The runs have the same case and differ only in their end times "
        "(early at 40 µs, full at 200 µs). "
    )
    assert comparison.sentence.startswith(first)
    assert "main results" not in comparison.sentence
    assert "peak contact force" in comparison.sentence  # both runs contain it
    assert comparison.protection == []
    assert in_one_line(text_of(comparison)).startswith(first)
    table = comparison.table
    assert table.loc["peak_force_N", "ratio"] == pytest.approx(1.0, rel=1e-4)
    assert all(np.isnan(table.loc[name, "ratio"]) for name in TRUNCATED if name in table.index)
    ratios = {row[0].text: row[-1].text for row in value_table(comparison).rows}
    assert ratios["Peak force on the bottom"] == "truncated"
    (note,) = [note for note in comparison.notes if note.startswith("Not compared, since")]
    assert "peak force on the bottom" in note
    assert "Up to the end of each run: early at 40 µs" in comparison.caption("peak_force_field")


def test_other_cases_with_another_end_are_compared_by_complete_values(place):
    comparison = compared(place, "early", "fast")
    assert comparison.sentence.startswith(
        "Of the results that are complete in every run, the largest difference is in "
    )
    assert not any(f"{name}" in comparison.sentence for name in ("yielded", "bottom", "impacted"))
    assert "Runs end at different times: early at 40 µs, fast at 200 µs." in comparison.notes
    assert compared(place, "full", "fast").sentence.startswith("The main results differ most in ")


def test_the_velocity_at_an_arbitrary_end_is_no_main_result(place):
    """Not even with equal ends: a table of results omits it, unless it is requested."""
    names = {"Impacted sphere or striker at the end", "Kinetic energy"}
    comparison = compared(place, "full", "fast")
    assert not names & {row[0].text for row in value_table(comparison).rows}
    assert "impacted sphere" not in comparison.sentence
    asked = compared(place, "full", "fast", quantities=["impactor_velocity_m_s"])
    assert "impacted sphere or striker at the end" in asked.sentence
    early = compared(place, "early", "full", quantities=["wall_impulse_Ns"]).sentence
    assert early.endswith(
        "No requested value is complete in early and full: an earlier end truncates it."
    )


def test_a_killed_run_shows_the_time_that_it_reached(place):
    """Its case is the case of the full run."""
    full, early = read_inputs([place / "full", place / "early"], place).runs
    killed = dataclasses.replace(
        early, label="killed", case=full.case, record=early.record | {"state": "interrupted"}
    )
    comparison = compare_runs([full, killed])
    assert comparison.sentence.startswith(
        "The runs have the same case and differ only in their end times"
    )
    (row,) = comparison.case_rows
    assert row.what == "run.end_time" and not row.is_numerical  # in the table of the cases
    assert row.values == ("200 µs", "40 µs of 200 µs (interrupted)")


def test_a_run_that_settled_is_complete(place):
    """It ended by itself; the other run is complete if it no longer changes. A run of one case that
    stops earlier is not.
    """
    full, fast, early = read_inputs(
        [place / name for name in ("full", "fast", "early")], place
    ).runs
    settled = dataclasses.replace(early, summary=early.summary | {"end_reason": "settled"})
    names = ["n_plastic_spheres", "dissipated_fraction"]
    assert truncated_names(names, compared_runs([early, full])) == set(names)
    assert truncated_names(names, compared_runs([settled, full])) == set(names)
    assert truncated_names(names, compared_runs([early, fast])) == set(names)
    assert "dissipated_fraction" not in truncated_names(names, compared_runs([settled, fast]))


def test_a_value_is_final_if_it_does_not_change_after_the_earliest_end(place):
    """The longest course decides; values without a course, with unlike ends, are truncated."""
    time = np.linspace(0.0, 1.0, 101)
    assert _is_final_at(SampledCurve(time, np.minimum(time, 0.4)), 0.5)
    assert not _is_final_at(SampledCurve(time, time), 0.5)
    assert not _is_final_at(SampledCurve(time, np.where(time > 0.6, 2.0, 1.0)), 0.5)
    runs = compared(place, "early", "full").runs
    names = ["peak_force_N", "wall_peak_force_N", "energy_kinetic_J", "wave_speed_m_s"]
    assert truncated_names(names, runs) == {"wall_peak_force_N", "energy_kinetic_J"}
    assert truncated_names(names, compared(place, "fast", "full").runs) == set()


def test_a_slower_wave_in_a_longer_run_is_complete(place, tmp_path):
    """Its peak comes after the end of the other run, in the first half of its own time."""
    slow = SLOW | {"run.end_time": 1.5e-3}
    run_case(load_case("fcc-small", slow), tmp_path / "slow", figures=False)
    full, of_slow_wave = read_inputs([place / "full", tmp_path / "slow"], tmp_path).runs
    record = bottom_record(compared_runs([of_slow_wave])[0])
    assert record.time[np.argmax(record.force)] > ENDS["full"]
    (peak,) = compare_runs([full, of_slow_wave], quantities=["wall_peak_force_N"]).values
    assert peak.ratio == pytest.approx(peak.values[1] / peak.values[0])


def test_truncated_values_have_no_difference_in_the_table_of_all_values(place):
    inputs = read_inputs([place / "early", place / "full"], place)
    tables = results_section(inputs, compare_runs(inputs.runs)).blocks
    (table,) = [block for block in tables if getattr(block, "caption", "") == "Values side by side"]
    differences = {row[0].text: row[-1].text for row in table.rows}
    assert differences["Peak force on the bottom"] == "truncated"
    assert differences["Energy input"] == "0 %"


def test_one_run_beside_a_measured_curve_has_no_ratio(place, tmp_path):
    path = tmp_path / "measured.csv"
    path.write_text("time_us,force_N\n0,0\n40,200\n80,900\n120,300\n")
    comparison = compared(place, "full", quantities=["wall_peak_force_N"], measured=path)
    (value,) = comparison.values
    assert value.ratio is None
    assert "measured.csv by " in comparison.sentence
    text = text_of(comparison)
    assert "wall_peak_force_N" in text and "ratio" not in text
    table = value_table(comparison)
    assert [column.heading for column in table.columns] == ["Quantity", "Unit", "full"]
    assert table.caption == "Results"


def test_truncated_forces_are_not_ranked(place, tmp_path):
    """A force that passes its peak after the end of the other run, and shortly before its own, is
    neither compared in the table nor ranked in the first sentence, if its own record does not show
    that the peak is complete: rough sides take up momentum.
    """
    slow = SLOW | {"run.end_time": 4e-4, "boundary.sides": "wall", "contact.friction": 0.3}
    run_case(load_case("fcc-small", slow), tmp_path / "slow", figures=False)
    comparison = compared_in([place / "full", tmp_path / "slow"])
    assert all(map(has_peak_at_bottom, comparison.runs))
    assert [has_own_peak(run) for run in comparison.runs] == [True, False]
    assert comparison.without_ratio["wall_peak_force_N"] == "truncated"
    assert comparison.protection == []
    assert not any("on the bottom" in text for text in comparison.paragraphs)


def test_the_record_of_a_run_shows_that_its_peak_is_complete(place, tmp_path):
    """The force passes its peak at 282 us, after the end of the other run. With more than 80 % of
    the momentum on the bottom it is complete: a run of 1.5 ms has the same force.
    """
    for name, end in {"slow": 4e-4, "long": 1.5e-3}.items():
        slow = SLOW | {"run.end_time": end}
        run_case(load_case("fcc-small", slow), tmp_path / name, figures=False)
    comparison = compared_in([place / "full", tmp_path / "slow"])
    assert all(map(has_own_peak, comparison.runs))
    assert "wall_peak_force_N" not in comparison.without_ratio
    assert comparison.protection[0].startswith("Inputs differ; the peak force on the bottom")
    longer = compared_in([place / "full", tmp_path / "long"])
    for name in ("wall_peak_force_N", "base_arrival_s", "peak_reduction"):
        ratio = comparison.table.loc[name, "ratio"]
        assert ratio == pytest.approx(longer.table.loc[name, "ratio"], rel=1e-4)


def test_chains_of_different_speed_are_compared_at_the_bottom(tmp_path):
    """The peak in PTFE, at 1 ms, is later than the end of the chain of steel, 0.4 ms; a longer run
    of steel gives the same ratios.
    """
    chain = {"packing": {"kind": "chain", "size": 20, "diameter": 0.0095}, "load": {"velocity": 1}}
    ends = {"steel": ("stainless-steel", 4e-4), "longer": ("stainless-steel", 3e-3)}
    for name, (material, end) in (ends | {"ptfe": ("ptfe", 3e-3)}).items():
        table = {"material": material, "contact": {"law": "hertz"}, "run": {"end_time": end}}
        bottom = {"bottom": {"material": material}}
        case = case_from_dict(chain | table | {"boundary": bottom})
        run_case(case, tmp_path / name, figures=False)
    names = ["wall_peak_force_N", "base_arrival_s", "peak_reduction"]
    early = compared(tmp_path, "steel", "ptfe")
    late = compared(tmp_path, "longer", "ptfe")
    assert not set(names) & set(early.without_ratio)
    ratios = early.table.loc[names, "ratio"]
    assert ratios.to_numpy() == pytest.approx(late.table.loc[names, "ratio"].to_numpy(), rel=1e-5)
    assert "wall_impulse_Ns" in early.without_ratio
    (note,) = [note for note in early.notes if "since they depend on the end time" in note]
    assert not any(words in note for words in ("peak force", "arrival", "reduction"))


def test_a_short_run_does_not_remove_the_comparison_of_the_others(place):
    """The ratios are the ratios without it, and its values are marked in all tables."""
    pair = compared(place, "final", "final-fast")
    comparison = compared(place, "final", "early", "final-fast")
    names = ["wall_peak_force_N", "base_arrival_s", "peak_reduction", "dissipated_fraction"]
    values = {value.name: value for value in comparison.values}
    for name in names:
        assert values[name].incomplete == {1}
        ratio = pair.table.loc[name, "ratio"]
        expected = max(ratio, 1 / ratio)  # largest / smallest
        assert comparison.table.loc[name, "ratio"] == pytest.approx(expected)
    rows = {row[0].text: texts_of(row) for row in value_table(comparison).rows}
    of_force = rows["Peak force on the bottom"]
    assert marks_of(of_force[2:5]) == [False, True, False]
    assert not any(text.endswith("*") for text in rows["Peak contact force, excluding walls"])
    assert rows["Arrival at the bottom"][3] == "\N{EN DASH}"  # early: not known
    (note,) = [note for note in comparison.notes if note.startswith("Truncated by the end")]
    assert "in early: " in note and "peak force on the bottom" in note
    assert not any("since they depend on the end" in note for note in comparison.notes)
    (line,) = [line for line in text_of(comparison).splitlines() if line.endswith(names[0])]
    assert line.count("*") == 1


def test_truncated_values_are_marked_in_the_table_of_all_values(place):
    inputs = read_inputs([place / name for name in ("full", "early", "fast")], place)
    blocks = results_section(inputs, compare_runs(inputs.runs)).blocks
    (table,) = [one for one in blocks if getattr(one, "caption", "") == "Values side by side"]
    marks = {row[0].text: marks_of(texts_of(row)[2:]) for row in table.rows}
    assert marks["Peak force on the bottom"] == [False, True, False]
    assert marks["Peak force on the target"] == [False, True, False]
    assert not any(marks["Energy input"])
    assert "* Truncated by the end of the run." in table.footnotes


def test_all_sizes_of_a_limited_zone_have_no_difference_in_the_table_of_all_values(place):
    """The 50 and 99 % sizes too, which no table of results has."""
    inputs = read_inputs([place / "full", place / "fast"], place)
    comparison = compare_runs(inputs.runs)
    blocks = results_section(inputs, comparison).blocks
    (table,) = [one for one in blocks if getattr(one, "caption", "") == "Values side by side"]
    sizes = [row[-1].text for row in table.rows if re.match(r"Plastic zone, \d+ %", row[0].text)]
    assert len(sizes) > 10 and set(sizes) == {"limited"}


def test_a_value_that_most_runs_truncate_is_not_compared(place):
    """Four of six runs end early: two complete runs are no comparison of the six."""
    comparison = compared(place, *["early"] * 4, "final", "final-fast")
    values = {value.name: value for value in comparison.values}
    assert values["dissipated_fraction"].without_ratio == "truncated"
    assert len(comparison.truncated["dissipated_fraction"]) == 4
    half = compared(place, "early", "early", "final", "final-fast")
    assert "dissipated_fraction" not in half.without_ratio
