"""Precompressed, settled, preconditioned and repeatedly hit packings, against closed forms."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from granwave.analysis.figures.style import save, style
from granwave.analysis.measures.chains.hertz_chain import discrete_speed
from granwave.analysis.measures.precompressed import loaded_line as theory
from granwave.analysis.reports.inputs import Point, Scan, read_inputs
from granwave.analysis.reports.sections.studies import studies_of
from granwave.analysis.studies.chains.runs import ChainRun
from granwave.analysis.studies.precompression import hits
from granwave.analysis.studies.precompression.packing_speed import SmallWave
from granwave.analysis.studies.precompression.runs import DentedRun
from granwave.analysis.studies.precompression.settled import contacts_a_sphere
from granwave.analysis.studies.precompression.waves import ChainWave
from granwave.analysis.studies.registry import STUDIES
from granwave.analysis.studies.runs import FinishedRun, grouped
from granwave.analysis.studies.study import Row, Study, make_studies
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.planning.timestep import auto_timestep
from granwave.workflows import load_case, load_scan, run_case

FEW = {"run.frames": 2}
SCANS = (
    "precompression-force", "precompression-amplitude", "precompression-transition",
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


# ---------------------------------------------------------------------- theory


def test_limits_of_the_composite_source_equation_3() -> None:
    """Limits of the closed form: c0 for f_r to 1, equation 4 for f_r to infinity. Only a last digit is misprinted."""
    assert theory.solitary_speed(np.array([1 + 1e-9, 1 + 1e-3])) == pytest.approx([1, 1 + 1e-3 / 18], abs=1e-7)
    far = np.array([1e12])
    assert theory.solitary_speed(far) / far ** (1 / 6) == pytest.approx(math.sqrt(8 / 15), rel=1e-6)
    assert theory.PRINTED_FACTOR * math.sqrt(8 / 15) == pytest.approx(0.6802, abs=5e-5)
    assert pytest.approx(theory.PRINTED_FACTOR, rel=1e-4) == theory.EXACT_FACTOR


def test_long_waves_of_a_chain_have_the_speed_of_equation_3() -> None:
    case = load_case("precompressed-chain", {"precompression.force": 7.0})
    line = theory.line_of(case, sphere_contact(case))
    assert line.speed / theory.printed_speed(case, 7.0) == pytest.approx(theory.EXACT_FACTOR / theory.PRINTED_FACTOR)


def test_lattice_waves_lie_between_small_pulses_and_the_uncompressed_chain() -> None:
    ratio = np.array([1.0, 1.01, 1e5])
    over = theory.lattice_speed(ratio) / theory.solitary_speed(ratio)
    assert over == pytest.approx([1, 1, discrete_speed()], rel=2e-4)


def test_crests_of_a_struck_linear_line() -> None:
    """Closed form against integrated equations of motion (k = m = v = 1)."""
    n, dt = 40, 2e-3
    u, v = np.zeros(n), np.zeros(n)
    v[0] = 1.0
    times = np.arange(1, 12_000) * dt
    speeds, forces = np.empty((len(times), n)), np.empty((len(times), n - 1))
    for k in range(len(times)):
        u += dt * v / 2
        force = u[:-1] - u[1:]
        v[:-1] -= dt * force
        v[1:] += dt * force
        u += dt * v / 2
        speeds[k], forces[k] = v, u[:-1] - u[1:]
    chosen = np.array([3, 8, 15])
    assert 2 * times[speeds.argmax(axis=0)[chosen - 1]] == pytest.approx(theory.crest_times(chosen), rel=1e-3)
    assert forces.max(axis=0)[chosen - 1] == pytest.approx(theory.crest_force(chosen), rel=1e-4)


def test_contact_force_of_a_packing_is_that_of_its_mean_stress() -> None:
    """Force f = p D^2/(2 sqrt 2): uniaxial by equilibrium of a layer, uniform by the virial; flattened by fixed sides."""
    pressure = 1e4
    for kind, sides in (("uniaxial", "periodic"), ("uniform", "free")):
        case = load_case("precompressed-fcc", {"precompression.kind": kind, "precompression.pressure": pressure,
                                               "boundary.sides": sides})  # fmt: skip
        line = theory.line_of(case, sphere_contact(case))
        assert line.force == pytest.approx(pressure * case.packing.diameter**2 / math.sqrt(8), rel=1e-4)
        stiffness = 2 * 1.5 * line.force / line.overlap
        assert line.speed == pytest.approx(line.spacing * math.sqrt(stiffness / case.sphere_mass), rel=1e-4)


# ---------------------------------------------------------------------- precompressed chains


@pytest.fixture(scope="module")
def chains(tmp_path_factory: pytest.TempPathFactory) -> list[DentedRun]:
    """Steel chains of 80 beads: small pulses at three forces, and three impacts at one."""
    folder = tmp_path_factory.mktemp("chains")
    points = [(1.0, 2e-4, 3.0e-3), (10.0, 1.4e-3, 2.1e-3), (100.0, 9e-3, 1.4e-3), (10.0, 1.0, 1.5e-3), (10.0, 20.0, 9e-4),
              (0.01, 0.02, 4e-3), (1.0, 0.02, 3e-3), (100.0, 0.02, 1.4e-3)]  # fmt: skip
    found = []
    for n, (force, velocity, end) in enumerate(points):
        changes = {"precompression.force": force, "load.velocity": velocity, "run.end_time": end, "packing.size": 80,
                   "output.history": 700, "material": "steel"}  # fmt: skip
        found.append(run(folder / f"{n}", "precompressed-chain", changes))
    return found


def test_chains_follow_the_formulas(chains: list[DentedRun]) -> None:
    names = ("precompressed-small-pulses", "precompressed-waves", "precompressed-transition")
    studies = make_studies({name: chains for name in names})
    small, waves, transition = studies
    assert row(small, "Power").ours == pytest.approx(1 / 6, abs=3e-4)
    assert row(small, "Factor").ours == pytest.approx(theory.EXACT_FACTOR, rel=1e-3)
    for chain in chains:
        wave = ChainWave(chain.seen_as(ChainRun))
        if wave.ratio < 1.05:
            assert wave.long_wave_speed == pytest.approx(wave.line.speed, rel=2e-3)
            assert wave.speed == pytest.approx(wave.linear_speed, rel=2e-3)
        elif wave.steady:
            assert wave.speed == pytest.approx(
                wave.line.speed * float(theory.lattice_speed(np.array(wave.ratio))), rel=2e-3
            )
    assert len(waves.rows) >= 3
    nearly_free = row(transition, "Speed at F0 = 0.01 N over")
    assert nearly_free.ours == pytest.approx(nearly_free.theory, rel=3e-3)
    assert all(study.pictures for study in studies)


def test_precompressed_chains_are_no_runs_of_other_studies(chains: list[DentedRun]) -> None:
    """Reports show these runs in their own studies only; a chain at rest between small forces is another problem."""
    assert all(chain.case.has_initial_dents for chain in chains)
    names = [name for name, module in STUDIES.items() if module.startswith("chains.")]
    assert make_studies({name: chains for name in names}) == []


# ---------------------------------------------------------------------- precompressed packings


@pytest.mark.parametrize(
    ("kind", "how", "sides", "size"),
    [("fcc", "uniaxial", "periodic", [4, 4, 16]), ("hcp", "uniaxial", "periodic", [4, 4, 16]),
     ("fcc", "uniform", "free", [14, 16, 9])],
)  # fmt: skip
def test_speed_of_small_waves_in_packings(tmp_path: Path, kind: str, how: str, sides: str, size: list[int]) -> None:
    changes = {"packing.kind": kind, "precompression.kind": how, "boundary.sides": sides, "packing.size": size,
               "run.end_time": 2.3e-4 if how == "uniaxial" else 1.2e-4, "run.frames": 50}  # fmt: skip
    found = run(tmp_path / "run", "precompressed-fcc", changes)
    assert found.of_static_stage("residual") < 1e-6
    assert found.seen_as(SmallWave).speed == pytest.approx(theory.line_of(found.case, found.law).speed, rel=3e-3)
    study = made("precompressed-packing-speed", found)
    assert len(study.rows) == 1


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
    points = tuple(Point(SimpleNamespace(labels={}), "", one) for one in inputs.runs)
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
