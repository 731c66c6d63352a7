"""Runs of grains at places of their own, and of held grains."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from granwave._contact_laws import elliptic_radius
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.lattices import Lattice
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.workflows.run.driver import run_case

LATTICE = Lattice("fcc", (6, 6, 4), 0.01)
RUN = {"end_time": 4e-5, "timestep": 4e-8, "frames": 5}


class Run(Result):
    """Result of a run, with its summary."""

    summary: dict[str, Any]


def result_of(directory: Path, name: str, **tables: Any) -> Run:
    case = case_from_dict({"name": name, "material": "brass", "run": RUN} | tables)
    outcome = run_case(case, directory / name, figures=False)
    result = Run(directory / name)
    result.summary = outcome.summary
    return result


def rows_of(places: np.ndarray) -> str:
    return "".join(",".join(map(repr, place)) + "\n" for place in places.tolist())


def test_same_bits_as_the_lattice(tmp_path: Path) -> None:
    text = "x,y,z,diameter\n" + rows_of(np.column_stack([LATTICE.positions(1, 144), np.full(144, 0.01)]))
    packing = {"kind": "fcc", "size": [6, 6, 4], "diameter": 0.01}
    lattice = result_of(tmp_path, "lattice", packing=packing)
    grains = result_of(tmp_path, "grains", packing={"kind": "file", "grains": text})
    for name in ("contacts/peak_force", "contacts/dissipated_energy", "energy/kinetic", "spheres/peak_force"):
        assert np.array_equal(lattice[name], grains[name])
    assert lattice["walls/bottom/force"].tolist() == grains["walls/bottom/force"].tolist()
    same = (
        "n_contacts",
        "dissipated_fraction",
        "plastic_zone_depth_m",
        "zone_depth_90_m",
        "n_plastic_spheres",
    )
    assert {name: lattice.summary[name] for name in same} == {name: grains.summary[name] for name in same}


def test_flight_and_collision_of_grains_with_velocities(tmp_path: Path) -> None:
    text = "x,y,z,diameter,vx,vy,vz\n0,0,0,0.01,0,0,4\n0.002,0,0.0101,0.01,-1,0,-3\n"
    boundary = {"bottom": "free"}
    run = {"end_time": 1e-4, "frames": 3}
    found = result_of(tmp_path, "flight", packing={"kind": "file", "grains": text}, boundary=boundary, run=run)
    mass = found["spheres/mass"]
    momentum = mass @ found.frame(found.n_frames - 1, "velocity")
    assert momentum == pytest.approx(mass @ [[0, 0, 4], [-1, 0, -3]], rel=1e-9, abs=1e-12)
    assert found["energy/input"][-1] == pytest.approx(mass[0] / 2 * (16 + 10), rel=1e-12)
    assert found["contacts/peak_force"].max() > 0
    error = found["energy/kinetic"] + found["energy/elastic"] + found["energy/dissipated"] - found["energy/input"]
    assert np.abs(error).max() < 1e-5 * found["energy/input"][-1]


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_held_grains(tmp_path: Path, friction: float) -> None:
    """A row aslant between a held grain and one that moves along z only, with and without rotation."""
    step = 0.01 * np.array([np.sin(0.3), 0.0, np.cos(0.3)])
    text = "x,y,z,diameter,group\n" + "".join(
        ",".join(map(repr, (n * step).tolist())) + f",0.01,{group}\n"
        for n, group in enumerate(["", "slides", "", "end"])
    )
    hold = [{"group": "end"}, {"group": "slides", "directions": "xy"}]
    found = result_of(
        tmp_path, "held", packing={"kind": "file", "grains": text}, hold=hold, boundary={"bottom": "free"},
        contact={"friction": friction}, load={"velocity": 3.0}, run=RUN | {"timestep": "auto"},
    )  # fmt: skip
    moved = [found.frame(frame, "displacement") for frame in range(found.n_frames)]
    velocity = np.array([found.frame(frame, "velocity") for frame in range(found.n_frames)])
    assert not np.any([one[3] for one in moved])
    assert not velocity[:, 3].any()
    assert not np.any([one[1, :2] for one in moved])
    assert velocity[-1, 1, 2] != 0
    assert velocity[-1, 2, 0] != 0
    assert found.summary["energy_balance_error"] < 1e-5
    if not friction:
        return
    assert found["energy/rotational"].max() > 0
    still = [*hold, {"index": [1, 3], "directions": "none"}]  # all are kept from turning
    packing = {"kind": "file", "grains": text}
    upright = result_of(
        tmp_path, "upright", packing=packing, hold=still, boundary={"bottom": "free"},
        contact={"friction": friction}, load={"velocity": 3.0}, run=RUN | {"timestep": "auto"},
    )  # fmt: skip
    assert not upright["energy/rotational"].any()
    assert upright.summary["energy_balance_error"] < 1e-5


def test_a_tube_that_shrinks_presses_a_ring_until_all_forces_balance(tmp_path: Path) -> None:
    """Six spheres in a tube: each is pressed by the wall and by its neighbours, with F_wall = F_ring (2 sin 30 deg)."""
    d, shrinks = 0.01, 4e-6
    ring = {"ring": {"n": 6, "radius": d, "z": 0.0}, "diameter": d}
    middle = {"kind": "file", "grains": f"x,y,z,diameter\n0,0,0.05,{d}\n0,0,0.1,{d}\n"}
    found = result_of(
        tmp_path, "ring", packing=middle, grains=[ring], contact={"law": "hertz"}, load={"index": [1], "velocity": 1e-3},
        boundary={"bottom": "free", "sides": {"tube": {"radius": 1.5 * d}}}, run=RUN | {"end_time": 4e-6},
        precompression={"kind": "walls", "tube": shrinks},
    )  # fmt: skip
    modulus = 115e9 / (1 - 0.3**2)
    on_wall = 4 / 3 * modulus * np.sqrt(elliptic_radius(2 / d, 2 / d - 1 / (1.5 * d - shrinks)))
    among = 4 / 3 * modulus / 2 * np.sqrt(d / 4)
    inwards = brentq(lambda u: on_wall * (shrinks - u) ** 1.5 - among * u**1.5, 0, shrinks, xtol=1e-16)
    force = among * inwards**1.5  # neighbours approach by u, two of them, each at 60 deg to the radius
    assert found["contacts/force"] == pytest.approx(np.full(6, force), rel=1e-6)
    assert found["walls/tube/force"][0] == pytest.approx(6 * force, rel=1e-6)
