"""Precompressed, settled, preconditioned and repeatedly hit packings, against closed forms."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import pytest

from granwave.analysis.figures.style import save, style
from granwave.analysis.reports.inputs import Point, Scan, read_inputs
from granwave.analysis.reports.sections.studies import studies_of
from granwave.analysis.studies.chains.runs import ChainRun
from granwave.analysis.studies.precompression import hits
from granwave.analysis.studies.precompression.runs import DentedRun
from granwave.analysis.studies.precompression.settled import contacts_a_sphere
from granwave.analysis.studies.runs import FinishedRun, grouped
from granwave.analysis.studies.study import Row, Study, make_studies
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.planning.timestep import auto_timestep
from granwave.workflows import load_case, load_scan, run_case

FEW = {"run.frames": 2}
SCANS = (
    "precompressed-packings", "precompressed-impact", "settled-packings", "preconditioned-chain-force", "preconditioned-packing",
)  # fmt: skip


def run(directory: Path, name: str, changes: dict[str, Any]) -> DentedRun:
    outcome = run_case(load_case(name, FEW | changes), directory, figures=False)
    return DentedRun(directory.name, directory, load_case(directory / "case.toml"), outcome.summary)


def made(name: str, *runs: FinishedRun) -> Study:
    (study,) = make_studies({name: runs})
    return study


def row(study: Study, start: str) -> Row:
    (found,) = [row for row in study.rows if row.quantity.startswith(start)]
    return found


def test_impact_on_top_of_pressure(tmp_path: Path) -> None:
    changes = {"packing.size": [6, 6, 4], "run.end_time": 1.5e-4}
    pressed = {"precompression.kind": "uniform", "precompression.pressure": 1e5}
    runs = [run(tmp_path / "0", "fcc-small", changes), run(tmp_path / "1", "fcc-small", changes | pressed)]
    study = made("precompressed-impact", *runs)
    without, under = runs
    assert len(study.tables[0].rows) == 2
    assert 0.5 < under.dissipated < 0.95
    assert under.arrival < without.arrival
    assert under.summary["energy_balance_error"] < 1e-5
    assert study.text.startswith("FCC packing of 6 x 6 x 4 brass spheres of 10 mm, free sides, elasto-plastic contacts")
    assert "More than 100 %" not in study.text + study.verdict[0]


def test_more_than_the_input_is_dissipated(tmp_path: Path) -> None:
    """A weak impact on contacts near yield causes the packing to settle under its load, as stated in the study."""
    changes = {"packing.size": [5, 5, 3], "run.end_time": 2e-4, "load.velocity": 0.2, "precompression.kind": "uniform"}
    runs = [run(tmp_path / f"{p:g}", "fcc-small", changes | {"precompression.pressure": p}) for p in (1e4, 1.4e5)]
    assert runs[1].dissipated > 1 > runs[0].dissipated
    assert runs[1].summary["energy_elastic_J"] < 0 and runs[1].summary["energy_balance_error"] < 1e-5
    study = made("precompressed-impact", *runs)
    assert "More than 100 %" in study.text and "More than 100 %" in study.verdict[0]


# ---------------------------------------------------------------------- settled


def test_settled_packing_beside_the_same_as_placed(tmp_path: Path) -> None:
    """Packings settled without friction have about three contacts per sphere, including those with the bottom."""
    changes = {"packing.size": [5, 6, 5], "run.end_time": 2e-4}
    runs = [run(tmp_path / "settled", "settled-fcc", changes)]
    placed = dataclasses.replace(runs[0].case, precompression=None)
    ideal = dataclasses.replace(placed, packing=dataclasses.replace(placed.packing, diameter_scatter=0.0, seed=None))
    for name, case in (("placed", placed), ("ideal", ideal)):
        outcome = run_case(case, tmp_path / name, figures=False)
        runs.append(DentedRun(name, tmp_path / name, case, outcome.summary))
    settled, placed_run, ideal_run = runs
    assert settled.of_static_stage("residual") < 1e-6
    assert 2.5 < contacts_a_sphere(settled) < 5
    assert max(settled.arrival, ideal_run.arrival) < placed_run.arrival
    study = made("settled-packing", *runs)
    assert [cells[0].text for cells in study.tables[0].rows] == [
        "like spheres, as placed", "scattered, as placed", "scattered, settled under 100 kPa on top",
    ]  # fmt: skip
    assert len(study.verdict) == 1


# ---------------------------------------------------------------------- dents


def test_preconditioned_chain_is_elastic_up_to_its_level(tmp_path: Path) -> None:
    changes = {"packing.size": 40, "run.end_time": 5e-4}
    runs = [
        run(tmp_path / f"{level}-{velocity}", "preconditioned-chain",
            changes | {"load.velocity": velocity, "contact.initial_overlap": {"force": level} if level else 0.0})
        for level, velocity in ((0, 2.0), (2e3, 1.0), (2e3, 2.0), (2e3, 10.0))
    ]  # fmt: skip
    fresh, slow, elastic, losing = runs
    assert [one.level for one in runs] == pytest.approx([0, 2e3, 2e3, 2e3], rel=1e-9)
    assert fresh.dissipated > 0.5
    assert max(slow.dissipated, elastic.dissipated) < 1e-9
    assert elastic.summary["peak_force_N"] < 2e3 < losing.summary["peak_force_N"]
    assert losing.dissipated > 0.1
    study = made("preconditioned", *runs)
    assert row(study, "Largest force without").ours < 1 < row(study, "Smallest force with").ours
    peaks = elastic.seen_as(ChainRun).of_contacts("peak_force")
    assert peaks[25] == pytest.approx(peaks[12], rel=0.02)
    assert len(study.pictures) == 2


def test_timestep_counts_the_slope_of_dents(tmp_path: Path) -> None:
    """Unloading is steeper: with dents far beyond the peak overlap the balance closes as well as without."""
    changes = {"packing.size": 30, "run.end_time": 2e-4}
    one = run(tmp_path / "run", "preconditioned-chain", changes | {"contact.initial_overlap": {"force": 1e4}})
    fresh = load_case("preconditioned-chain", changes | {"contact.initial_overlap": 0.0})
    small = load_case("preconditioned-chain", changes | {"contact.initial_overlap": {"force": 1.0}})
    from_file = load_case("preconditioned-chain", changes | {"contact.initial_overlap": str(one.directory)})
    assert auto_timestep(one.case) < 0.6 * auto_timestep(fresh)
    assert auto_timestep(small) == auto_timestep(fresh)
    assert auto_timestep(from_file) == pytest.approx(auto_timestep(one.case), rel=0.11)  # two digits
    assert one.summary["energy_balance_error"] < one.case.run.energy_tolerance


@pytest.mark.parametrize(
    ("dents", "message"),
    [({"overlap": 1e-6, "low": [0, 0, 0.02], "high": [1, 1, 0.01]}, "expected low of a box of dents below its high"),
     ({"overlap": 1e-6, "low": [1, 1, 1]}, r"found no contact in the box \{low = \[1.0, 1.0, 1.0\]\}, expected")],
)  # fmt: skip
def test_boxes_of_dents_that_hold_nothing(dents: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message) as refused:
        load_case("fcc-small", {"contact.initial_overlap": dents})
    assert len(refused.value.errors) == 1


def test_pair_without_materials() -> None:
    with pytest.raises(InputError, match=r"pair.1.materials: missing; expected the names of two"):
        load_case("fcc-small", {"pair": [{"friction": 0.1}]})


def test_packing_hit_three_times(tmp_path: Path) -> None:
    """A hit starts from the dents of the previous one, and dissipates less, farther away from the struck sphere."""
    changes: dict[str, Any] = {"packing.size": [6, 6, 4], "run.end_time": 3e-4}
    runs = [run(tmp_path / "hit1", "fcc-small", changes)]
    for n in (2, 3):
        dents = {"contact.initial_overlap": str(runs[-1].directory / "result.h5")}
        runs.append(run(tmp_path / f"hit{n}", "fcc-small", changes | dents))
    assert [[one.label for one in series] for series in hits.select(runs[::-1])] == [["hit1", "hit2", "hit3"]]
    first, second, third = (one.dissipated for one in runs)
    assert third < second < 0.9 * first
    study = made("repeated-hits", *runs)
    assert len(study.tables[0].rows) == 3
    with style():
        save(study.pictures[0].drawing, tmp_path / "figure", formats=())


def test_a_report_shows_the_studies_of_its_runs(tmp_path: Path) -> None:
    changes = {"packing.size": [4, 4, 3], "run.end_time": 1e-4}
    first = run(tmp_path / "hit1", "fcc-small", changes)
    run(tmp_path / "hit2", "fcc-small", changes | {"contact.initial_overlap": str(first.directory)})
    inputs = read_inputs([tmp_path / "hit1", tmp_path / "hit2"], tmp_path / "report.html")
    assert studies_of(inputs) == []
    assert "repeated-hits" in [study.name for study in studies_of(inputs, ["repeated-hits"])]
    points = tuple(Point(None, "", one) for one in inputs.runs)
    scans = (Scan("dents", None, points, ("preconditioned",)), Scan("hits", None, points, ("repeated-hits",)))
    found = studies_of(dataclasses.replace(inputs, items=scans))  # runs that two scans share
    assert [study.name for study in found] == ["repeated-hits"]


# ---------------------------------------------------------------------- finding runs, built-in studies


def test_twins_differ_in_what_is_named_alone() -> None:
    case = load_case("settled-fcc")
    other = load_case("settled-fcc", {"precompression.pressure": 1e4, "run.end_time": 1e-3})
    faster = load_case("settled-fcc", {"load.velocity": 10.0})

    runs = [DentedRun("", Path(), one, {}) for one in (case, other, faster)]
    assert [len(group) for group in grouped(runs, "precompression")] == [2, 1]
    assert [len(group) for group in grouped(runs, "precompression", "load.velocity")] == [3]
    assert [len(group) for group in grouped(runs)] == [1, 1, 1]


@pytest.mark.parametrize("name", SCANS)
def test_built_in_scans_can_be_read(name: str) -> None:
    assert load_scan(name).points
