"""Protected targets: closed forms of single spheres and oscillators, transmitted momentum and
energy, the studies.
"""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from granwave.analysis.measures.target_theory import HertzImpact, after_impulse, response
from granwave.analysis.result.reader import Result
from granwave.analysis.result.writer import BALANCE_REFUSED
from granwave.analysis.studies.protection.runs import TargetRun, impacts, names, series
from granwave.analysis.studies.runs import finished_runs
from granwave.analysis.studies.study import draw_studies, make_studies
from granwave.lammps_inputs.case.run import RunSettings
from granwave.lammps_inputs.load_case import load_case
from granwave.workflows import load_scan, run_case

pytestmark = pytest.mark.xdist_group("protection")  # its fixtures are made once

CASES = Path(__file__).parents[3] / "workflows" / "cases"
STUDIES = ("protected-height", "protected-bottoms", "protected-spectrum", "protected-checks")
CONCRETE = {"name": "concrete", "youngs_modulus": 31e9, "poisson_ratio": 0.2, "density": 2447}
PLATE = {"plate": {"mass": 0.5, "stiffness": 2e9}, "material": "steel"}
Found = list[tuple[str, Path, Any]]


def ran(case: str, directory: Path, **changes: Any) -> tuple[str, Path, Any]:
    outcome = run_case(load_case(CASES / f"{case}.toml", changes), directory, figures=False)
    assert outcome.summary["energy_balance_error"] < 1e-5
    return directory.name, directory, outcome.summary


@pytest.fixture(scope="module")
def spheres(tmp_path_factory: pytest.TempPathFactory) -> Found:
    """One elastic sphere on every kind of bottom."""
    bottoms: dict[str, Any] = {
        "wall": "wall",
        "steel": {"material": "steel"},
        "slow": {"plate": {"mass": 0.1, "stiffness": 1e5}},
        "fast": {"plate": {"mass": 0.002, "stiffness": 2e10}},
        "ground": {"half_space": {"radius": 0.05}, "material": CONCRETE},
        "bar": {"bar": {"length": 0.5, "area": 0.02}, "material": "steel"},
    }
    folder = tmp_path_factory.mktemp("spheres")
    ends = {"slow": 1.7e-3}
    return [
        ran(
            "protected-sphere",
            folder / name,
            **{"boundary.bottom": bottom, "run.end_time": ends.get(name, 1e-4)},
        )
        for name, bottom in bottoms.items()
    ]


@pytest.fixture(scope="module")
def packings(tmp_path_factory: pytest.TempPathFactory) -> Found:
    """Small packings of three heights on a rigid wall, the lowest one also on a plate and on
    concrete.
    """
    folder = tmp_path_factory.mktemp("packings")
    bottoms = {"wall": "wall", "plate": PLATE, "concrete": {"half_space": {}, "material": CONCRETE}}
    wanted = [("wall", 2), ("wall", 3), ("wall", 4), ("plate", 2), ("concrete", 2)]
    changes = [{"boundary.bottom": bottoms[name], "packing.size": [6, 6, n]} for name, n in wanted]
    return [
        ran("protected-target", folder / f"{name}{n}", **one, **{"run.end_time": 3e-4})
        for (name, n), one in zip(wanted, changes, strict=True)
    ]


def collect(found: Found) -> list[list[TargetRun]]:
    return impacts(finished_runs(found))


def work_on(run: TargetRun) -> np.ndarray:
    """Work of the force on a target along its motion, at the instants of the force, J."""
    if not run.moves:
        return np.zeros_like(run.reached.time)
    with Result(run.directory) as result:
        return cumulative_trapezoid(
            run.reached.force * result["walls/bottom/velocity"], run.reached.time, initial=0.0
        )


def test_hertz_impact_is_consistent() -> None:
    one = HertzImpact(mass=4.45e-3, velocity=1.0, stiffness=9e9)
    time, force = one.history()
    assert one.duration == pytest.approx(2.9432 * one.overlap / one.velocity, rel=1e-4)
    assert force.max() == pytest.approx(one.force, rel=1e-5)
    assert np.trapezoid(force, time) == pytest.approx(one.impulse, rel=5e-4)
    assert np.trapezoid(force**2, time) == pytest.approx(one.square, rel=1e-3)
    assert one.on_spring(1e15) == pytest.approx(one.force, rel=1e-6)
    soft = 1e4  # so soft that the energy of the contact is negligible
    assert one.on_spring(soft) == pytest.approx(math.sqrt(one.mass * soft) * one.velocity, rel=1e-2)


def test_oscillator_between_its_limits() -> None:
    mass = 2.0
    spring = 3e6
    duration = 1e-5
    time = np.linspace(0, 8e-3, 80001)
    force = np.where(time < duration, 100 * np.sin(np.pi * time / duration), 0.0)
    impulse = 200 * duration / np.pi
    assert response(time, force, mass, spring).max() == pytest.approx(
        after_impulse(impulse, mass, spring), rel=1e-4
    )
    step = np.full_like(time, 100.0)
    assert response(time, step, mass, spring).max() == pytest.approx(
        2 * 100 / spring, rel=1e-6
    )  # twice the static one
    massless = response(time, step, 0.0, spring, 1e3)
    np.testing.assert_allclose(
        massless, 100 / spring * (1 - np.exp(-spring / 1e3 * time)), rtol=1e-9, atol=1e-15
    )


def test_single_spheres_obey_the_closed_forms(spheres: Found) -> None:
    (group,) = collect(spheres)
    (found,) = make_studies({"protected-checks": group})
    assert len(found.rows) == 8 and found.title.endswith(
        ": Brass sphere of 10 mm, elastic contacts, 1 m/s"
    )
    assert {row.where for row in found.rows} >= {"Hertz (1882)", "2 m v"} and not any(
        row.remark for row in found.rows
    )
    for row in found.rows:
        assert row.theory is not None
        assert row.ours == pytest.approx(row.theory, rel=1e-2), row.quantity
    exact = [row for row in found.rows if row.quantity.startswith(("Peak", "Impulse"))]
    assert [row.ours for row in exact] == pytest.approx([row.theory for row in exact], rel=3e-4)
    assert not make_studies({"protected-bottoms": group})  # a single sphere is not a packing


def test_momentum_and_energy_that_arrive(packings: Found) -> None:
    runs = {run.label: run for run in collect(packings)[0]}
    assert list(runs) == ["wall2", "wall3", "wall4", "plate2", "concrete2"]
    for run in runs.values():
        assert run.momentum == pytest.approx(5.0 * run.case.sphere_mass)
        assert run.reached.impulse[-1] == pytest.approx(run.summary["wall_impulse_Ns"], rel=1e-6)
        time, energy = run.energy
        assert energy[-1] == run.summary["energy_target_J"]
        work = np.interp(
            time, run.reached.time, work_on(run)
        )  # force times velocity, as recorded at the wall
        np.testing.assert_allclose(energy, work, atol=3e-4 * energy.max())
        assert 0 < run.value("largest_of_one_N") < run.reached.peak_force
        assert run.summary["peak_reduction"] == pytest.approx(
            run.summary["unprotected_peak_force_N"] / run.reached.peak_force, rel=1e-6
        )
    plate = runs["plate2"]
    assert plate.energy[1][-1] == pytest.approx(plate.summary["support_energy_J"], rel=1e-3)
    moved = response(plate.reached.time, plate.reached.force, 0.5, 2e9)
    np.testing.assert_allclose(plate.displacement, moved, atol=2e-4 * moved.max())
    first = runs["wall2"].reached
    last = runs["wall4"].reached
    assert (
        first.peak_force > last.peak_force
        and runs["concrete2"].reached.peak_force < first.peak_force
    )


def test_studies_of_bottoms_and_heights(packings: Found, tmp_path: Path) -> None:
    (group,) = collect(packings)
    assert names(group)[0] == "rigid wall, 2 layers" and group[-1].bottom == "concrete half-space"
    ((*heights,),) = series(group)
    assert [run.layers for run in heights] == [2, 3, 4]
    found = {study.name: study for study in make_studies({name: group for name in STUDIES})}
    assert list(found) == ["protected-height", "protected-bottoms"]
    (table,) = found["protected-bottoms"].tables
    assert [row[0].text for row in table.rows] == [
        "rigid wall",
        "plate of 0.5 kg, 99.3 µs",
        "concrete half-space",
    ]
    assert found["protected-bottoms"].verdict[0].startswith("Peak reduction: from ")
    assert "to layers^" in found["protected-height"].verdict[0]
    drawn = draw_studies(list(found.values()), tmp_path)
    assert [path.stem for path in drawn] == ["protected_height", "protected_bottoms"]
    header = (
        (tmp_path / "figures" / "protected_bottoms.csv")
        .read_text(encoding="utf-8")
        .partition("\n")[0]
    )
    assert "rigid_wall_force_N" in header and "concrete_half_space_energy_J" in header
    titles = [study.title.partition(": ")[2] for study in found.values()]
    assert (
        titles[0]
        == "FCC packing of 6 × 6 brass spheres of 10 mm a layer, elasto-plastic contacts, 5 m/s"
    )
    assert (
        titles[1]
        == "FCC packing of 6 × 6 × 2 brass spheres of 10 mm, elasto-plastic contacts, 5 m/s"
    )


@pytest.mark.validation
def test_spectrum_follows_the_oscillator(tmp_path: Path) -> None:
    """Heavy plates below three elastic spheres do not change the force and respond to it as
    oscillators.
    """
    more = {"packing.size": 3, "packing.kind": "chain", "run.end_time": 1.2e-3}
    found = [ran("protected-sphere", tmp_path / "wall", **{"boundary.bottom": "wall"}, **more)]
    for n, stiffness in enumerate((2e13, 1e11, 5e9, 5e8)):
        bottom = {"plate": {"mass": 10.0, "stiffness": stiffness}}
        found.append(
            ran("protected-sphere", tmp_path / str(n), **{"boundary.bottom": bottom}, **more)
        )
    (group,) = collect(found)
    (study,) = make_studies({"protected-spectrum": group})
    rows = study.rows
    assert len(rows) == 4 and "slow force" in rows[0].where and "short impulse" in rows[-1].where
    for row in rows:
        assert row.ours == pytest.approx(row.theory, rel=0.03), row.quantity
    assert [path.stem for path in draw_studies([study], tmp_path)] == ["protected_spectrum"]


def test_only_runs_that_compare_make_a_study(packings: Found, tmp_path: Path) -> None:
    by_name = {label: (label, path, summary) for label, path, summary in packings}
    assert collect([by_name["wall2"]]) == []
    assert (
        collect([by_name["wall2"], by_name["wall3"]]) == []
    )  # a series needs more than two heights on a rigid wall
    assert len(collect([by_name["wall2"], by_name["plate2"]])) == 1
    _, path, summary = by_name["wall2"]
    shorter = dataclasses.replace(load_case(path / "case.toml"), run=RunSettings(end_time=1e-4))
    (tmp_path / "case.toml").write_text(shorter.to_toml(), encoding="utf-8")
    (group,) = collect([("shorter", tmp_path, {**summary, "end_time_s": 1e-4}), *packings])
    assert [run.label for run in group] == [
        label for label, _, _ in packings
    ]  # the longest run of equal cases
    refused = [
        (label, path, {**summary, "end_reason": BALANCE_REFUSED})
        for label, path, summary in packings
    ]
    assert collect(refused) == []


def test_hertz_of_a_run(spheres: Found) -> None:
    runs = {run.label: run for run in collect(spheres)[0]}
    wall: TargetRun = runs["wall"]
    assert HertzImpact.of(wall.case).force == pytest.approx(
        wall.summary["unprotected_peak_force_N"], rel=1e-6
    )
    for name in (
        "slow",
        "fast",
        "ground",
        "bar",
    ):  # no spheres in between: the run is the impact without a packing
        assert runs[name].summary["peak_reduction"] == pytest.approx(1, abs=1e-3)


def test_a_report_shows_them(packings: Found, granwave, tmp_path: Path) -> None:
    studies = ("--study", "protected-bottoms", "--study", "protected-height")
    done = granwave("report", *(path for _, path, _ in packings), *studies, "-o", tmp_path / "r.md")
    assert done.returncode == 0, done.stderr
    text = (tmp_path / "r.md").read_text(encoding="utf-8")
    assert "Protected target, by bottom" in text and "Peak reduction by height" in text


def test_builtin_scans_are_whole() -> None:
    sizes = {
        name: len(load_scan(f"protected-{name}").points)
        for name in ("bottoms", "height", "spectrum", "sphere")
    }
    assert sizes == {"bottoms": 16, "height": 42, "spectrum": 21, "sphere": 10}
