"""Packings hit by strikers: lengths of pulses, sensors, directions, lighter spheres."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granwave.analysis import Result
from granwave.analysis.figures.run_figures import draw_figures
from granwave.analysis.measures import line_waves as pulses
from granwave.analysis.measures.hertz_lattices import discrete_width
from granwave.analysis.measures.waves import energy_of_spheres, spread, travelling_frame
from granwave.analysis.studies.runs import FinishedRun
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict, load_case
from granwave.workflows import run_case

CASES = Path(__file__).parents[3] / "workflows" / "cases"
STEEL = {"youngs_modulus": 193e9, "poisson_ratio": 0.3, "density": 8000.0, "yield_strength": 240e6}


def run(name: str, directory: Path, **changes: Any) -> FinishedRun:
    outcome = run_case(load_case(CASES / f"{name}.toml", changes), directory, figures=False)
    assert outcome.summary["energy_balance_error"] < 1e-5
    return FinishedRun(name, directory, load_case(directory / "case.toml"), outcome.summary)


@pytest.fixture(scope="module")
def in_plane(tmp_path_factory: pytest.TempPathFactory) -> FinishedRun:
    return run("square-in-plane", tmp_path_factory.mktemp("square") / "in")


def test_fits_of_length_are_exact_for_the_waves_of_the_theory() -> None:
    time = np.linspace(0, 1e-3, 401)
    diameter = 0.02
    speed = 500.0
    length = pulses.LENGTH * diameter
    wave = []
    for sphere in range(9):
        phase = np.pi * speed * (time - 2.5e-4 - sphere * diameter / speed) / length
        wave.append(np.cos(np.clip(phase, -np.pi / 2, np.pi / 2)) ** 4)
    found = pulses.lengths(time, np.stack(wave, axis=1), diameter)
    for name, expected in pulses.solitary_lengths().items():
        np.testing.assert_allclose(found[name][1:-1], expected, rtol=2e-3)


def test_sensors_record_the_acceleration(in_plane: FinishedRun) -> None:
    assert in_plane.summary["sensor_2D_peak_acceleration_m_s2"] == 0.0
    with Result(in_plane.directory) as result:
        time = result["probes/time"]
        force = result["probes/sphere_206_fx"]
        mass = result["spheres/mass"][205]
        gained = np.sum((force[1:] + force[:-1]) / 2 * np.diff(time)) / mass
        assert gained == pytest.approx(result["probes/sphere_206_vx"][-1], abs=1e-5)
        assert in_plane.summary["sensor_1B_peak_acceleration_m_s2"] == pytest.approx(
            np.abs(force).max() / mass, rel=1e-3
        )
    drawn = draw_figures(in_plane.directory, names=("accelerations", "directions", "probes"))
    assert [path.stem for path in drawn] == ["accelerations", "directions"]


@pytest.mark.parametrize("kind", ["fcc", "hcp"])
def test_directions_of_other_packings(kind: str, tmp_path: Path) -> None:
    changes = {
        "packing.size": [12, 12, 6],
        "packing.kind": kind,
        "striker.1.touches": [54, 55, 66],
        "run.frames": 11,
    }
    places = {"striker.2.touches": 865, "contact.law": "elastoplastic", "run.end_time": 2e-4}
    one = run("fcc-striker", tmp_path / kind, **changes, **places)
    with Result(one.directory) as result:
        energy = spread(result, energy_of_spheres(result, travelling_frame(result)))
        lost = spread(result, result["spheres/dissipated_energy"])
    assert energy is not None and lost is not None
    for found in (energy, lost):
        assert found.cells.sum() == pytest.approx(1.0)
        assert found.even < found.along <= 1
    assert lost.along > energy.along  # contacts along the directions of contacts yield first
    with Result(one.directory) as result:
        frame = travelling_frame(result)
        assert spread(result, np.zeros(result.n_spheres)) is None
        stored = result.frame(frame, "elastic_energy").sum()
        assert stored == pytest.approx(
            np.interp(result.frame_times[frame], result["energy/time"], result["energy/elastic"]),
            rel=0.02,
        )
        assert energy_of_spheres(result, frame).sum() < result.energy_input
    assert [path.stem for path in draw_figures(one.directory, names=("directions",))] == [
        "directions"
    ]


def square(**tables: Any) -> Case:
    packing = {"kind": "square", "size": [6, 6], "diameter": 0.01905}
    return case_from_dict({"name": "square", "material": STEEL, "packing": packing} | tables)


def test_a_wall_cannot_cut_a_striker_of_a_chain() -> None:
    chain = {"kind": "chain", "size": 6, "diameter": 0.01905}
    with pytest.raises(
        InputError, match=r"striker\.1: the wall at the bottom overlaps it by 0\.019"
    ):
        case_from_dict(
            {"name": "chain", "material": STEEL, "packing": chain, "striker": [{"touches": 6}]}
        )


def test_width_of_the_wave_of_the_chain_itself() -> None:
    assert discrete_width() == pytest.approx(1.5791, abs=1e-4)  # runs of chains give 1.579
