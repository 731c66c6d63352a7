"""Runs of grains, free and loaded."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import ase
import ase.io
import numpy as np
import pytest
from scipy.optimize import brentq

from granwave._contact_laws import elliptic_radius
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.errors import InputError, RunError
from granwave.lammps_inputs.lattices import Lattice
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.workflows.run.driver import run_case
from tests.helpers.made_up.run_files import summary
from tests.helpers.made_up.small_cases import grains_at

LATTICE = Lattice("fcc", (6, 6, 4), 0.01)
RUN = {"end_time": 4e-5, "timestep": 4e-8, "frames": 5}


def result_of(directory: Path, name: str, **tables: Any) -> Result:
    """Result of a run whose energy balance closes."""
    case = case_from_dict({"name": name, "material": "brass", "run": RUN} | tables)
    assert run_case(case, directory / name, figures=False).summary["energy_balance_error"] < 1e-4
    return Result(directory / name)


def test_same_bits_as_the_lattice(tmp_path: Path) -> None:
    lattice = result_of(
        tmp_path, "lattice", packing={"kind": "fcc", "size": [6, 6, 4], "diameter": 0.01}
    )
    grains = result_of(tmp_path, "grains", packing=grains_at(LATTICE.positions(1, 144)))
    for name in (
        "contacts/peak_force",
        "contacts/dissipated_energy",
        "energy/kinetic",
        "spheres/peak_force",
    ):
        assert np.array_equal(lattice[name], grains[name])
    assert lattice["walls/bottom/force"].tolist() == grains["walls/bottom/force"].tolist()
    one, other = (summary(tmp_path / name) for name in ("lattice", "grains"))
    for name in (
        "n_contacts",
        "dissipated_fraction",
        "plastic_zone_depth_m",
        "zone_depth_90_m",
        "n_plastic_spheres",
    ):
        assert one[name] == other[name]


def test_flight_and_collision_of_grains_with_velocities(tmp_path: Path) -> None:
    text = "x,y,z,diameter,vx,vy,vz\n0,0,0,0.01,0,0,4\n0.002,0,0.0101,0.01,-1,0,-3\n"
    boundary = {"bottom": "free"}
    run = {"end_time": 1e-4, "frames": 3}
    found = result_of(
        tmp_path, "flight", packing={"kind": "file", "grains": text}, boundary=boundary, run=run
    )
    mass = found["spheres/mass"]
    momentum = mass @ found.frame(found.n_frames - 1, "velocity")
    assert momentum == pytest.approx(mass @ [[0, 0, 4], [-1, 0, -3]], rel=1e-9, abs=1e-12)
    assert found["energy/input"][-1] == pytest.approx(mass[0] / 2 * (16 + 10), rel=1e-12)
    assert found["contacts/peak_force"].max() > 0
    error = (
        found["energy/kinetic"]
        + found["energy/elastic"]
        + found["energy/dissipated"]
        - found["energy/input"]
    )
    assert np.abs(error).max() < 1e-5 * found["energy/input"][-1]


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_held_grains(tmp_path: Path, friction: float) -> None:
    """An oblique chain between a held grain and a grain that moves only along z, with and without
    rotation.
    """
    step = 0.01 * np.array([np.sin(0.3), 0.0, np.cos(0.3)])
    packing = grains_at([n * step for n in range(4)], groups=["", "slides", "", "end"])
    hold = [{"group": "end"}, {"group": "slides", "directions": "xy"}]
    common = {"packing": packing, "boundary": {"bottom": "free"}, "contact": {"friction": friction},
              "load": {"velocity": 3.0}, "run": RUN | {"timestep": "auto"}}  # fmt: skip
    found = result_of(tmp_path, "held", hold=hold, **common)
    moved = [found.frame(frame, "displacement") for frame in range(found.n_frames)]
    velocity = np.array([found.frame(frame, "velocity") for frame in range(found.n_frames)])
    assert not np.any([one[3] for one in moved])
    assert not velocity[:, 3].any()
    assert not np.any([one[1, :2] for one in moved])
    assert velocity[-1, 1, 2] != 0
    assert velocity[-1, 2, 0] != 0
    if not friction:
        return
    assert found["energy/rotational"].max() > 0
    still = [*hold, {"index": [1, 3], "directions": "none"}]  # all are kept from turning
    assert not result_of(tmp_path, "upright", hold=still, **common)["energy/rotational"].any()


def test_a_tube_that_shrinks_presses_a_ring_until_all_forces_balance(tmp_path: Path) -> None:
    """Six spheres in a tube: each is pressed by the wall and by its neighbours, with F_wall =
    F_ring (2 sin 30 deg).
    """
    d = 0.01
    shrinks = 4e-6
    ring = {"ring": {"n": 6, "radius": d, "z": 0.0}, "diameter": d}
    middle = grains_at([[0, 0, 0.05], [0, 0, 0.1]])
    found = result_of(
        tmp_path, "ring", packing=middle, grains=[ring], contact={"law": "hertz"}, load={"index": [1], "velocity": 1e-3},
        boundary={"bottom": "free", "sides": {"tube": {"radius": 1.5 * d}}}, run=RUN | {"end_time": 4e-6},
        precompression={"kind": "walls", "tube": shrinks},
    )  # fmt: skip
    modulus = 115e9 / (1 - 0.3**2)
    on_wall = 4 / 3 * modulus * np.sqrt(elliptic_radius(2 / d, 2 / d - 1 / (1.5 * d - shrinks)))
    among = 4 / 3 * modulus / 2 * np.sqrt(d / 4)
    inwards = brentq(
        lambda u: on_wall * (shrinks - u) ** 1.5 - among * u**1.5, 0, shrinks, xtol=1e-16
    )
    force = (
        among * inwards**1.5
    )  # neighbours approach by u, two of them, each at 60 deg to the radius
    assert found["contacts/force"] == pytest.approx(np.full(6, force), rel=1e-6)
    assert found["walls/tube/force"][0] == pytest.approx(6 * force, rel=1e-6)


MODULUS = 115e9 / (1 - 0.3**2) / 2  # of two like bodies
ROW = [[0.0, 0.0, 0.01 * n] for n in range(5)]
LOADED = {"end_time": 2e-6, "frames": 2}


def loaded_result(directory: Path, name: str, **tables: Any) -> Result:
    return result_of(directory, name, **{"contact": {"law": "hertz"}, "run": LOADED} | tables)


def static_forces(result: Result) -> np.ndarray:
    """Contact forces of identical grains at the start, N."""
    place = result.frame(0, "position")
    i = result["contacts/i"] - 1
    j = result["contacts/j"] - 1
    overlap = 0.01 - np.linalg.norm(place[j] - place[i], axis=1)
    return np.asarray(4 / 3 * MODULUS * 0.0025**0.5 * np.maximum(overlap, 0.0) ** 1.5)


def hertz(force: float, radius: float, modulus: float = MODULUS) -> float:
    """Overlap under a force, m."""
    return (force / (4 / 3 * modulus * radius**0.5)) ** (2 / 3)


def test_periodic_sides_are_those_of_the_lattice(tmp_path: Path) -> None:
    lattice = Lattice("fcc", (6, 6, 4), 0.01, periodic=True)
    places = lattice.positions(1, 144) + np.array([0.3, -0.2, 0.0])
    cell = [*lattice.lengths, 1.0]
    atoms = ase.Atoms("X144", positions=places, cell=cell, pbc=[True, True, False])
    atoms.set_array("radius", np.full(144, 0.005))
    ase.io.write(tmp_path / "grains.extxyz", atoms, format="extxyz")
    common = {"boundary": {"sides": "periodic"}, "run": {"end_time": 4e-5, "timestep": 4e-8, "frames": 2},
              "precompression": {"kind": "uniaxial", "force": 20.0}, "load": {"index": [15]}}  # fmt: skip
    file = loaded_result(
        tmp_path,
        "file",
        packing={"kind": "file", "file": str(tmp_path / "grains.extxyz")},
        **common,
    )
    own = loaded_result(
        tmp_path, "own", packing={"kind": "fcc", "size": [6, 6, 4], "diameter": 0.01}, **common
    )
    assert len(file["contacts/i"]) == len(own["contacts/i"]) == lattice.n_contacts
    assert file["prestage/stored"] == pytest.approx(own["prestage/stored"], rel=1e-7)
    for name in ("contacts/peak_force", "energy/kinetic"):
        assert file[name] == pytest.approx(own[name], rel=1e-5, abs=1e-6 * own[name].max())


def test_overlaps_as_precompression(tmp_path: Path) -> None:
    overlap = 3e-6
    places = np.array(ROW) * [1, 1, 1 - overlap / 0.01]
    found = loaded_result(tmp_path, "row", packing=grains_at(places), boundary={"bottom": "free"}, hold=[{"index": [1, 5]}],
                      precompression={"kind": "overlaps"}, load={"index": [2], "velocity": 1e-3})  # fmt: skip
    assert static_forces(found) == pytest.approx(
        4 / 3 * MODULUS * 0.0025**0.5 * overlap**1.5, rel=1e-6
    )


def test_force_on_the_top_of_grains(tmp_path: Path) -> None:
    """A chain that a guide keeps straight, with the last grain held."""
    found = loaded_result(tmp_path, "row", packing=grains_at(ROW), boundary={"bottom": "free"}, hold=[{"index": 5}],
                      guide=[{"free": "z"}], precompression={"kind": "uniaxial", "force": 7.0},
                      load={"index": [2], "velocity": 1e-3})  # fmt: skip
    assert static_forces(found) == pytest.approx(7.0, rel=1e-6)
    moved = found.frame(1, "displacement")
    assert moved[0, 2] == pytest.approx(4 * hertz(7.0, 0.0025), rel=1e-3)


def test_walls_that_move_to_a_force(tmp_path: Path) -> None:
    """Two grains side by side between planes, and a third grain, farther out, that the planes do
    not touch.
    """
    places = [[0, 0, 0], [0.01, 0, 0], [0.05, 0, 0.02]]
    found = loaded_result(tmp_path, "pair", packing=grains_at(places, groups=["pair", "pair", "far"]),
                      boundary={"bottom": "free", "x": "wall", "sides_touch": {"group": "pair"}},
                      precompression={"kind": "walls", "x_force": 20.0}, hold=[{"group": "far"}],
                      load={"index": [1], "velocity": 1e-4})  # fmt: skip
    between = hertz(20.0, 0.0025)
    wall = hertz(20.0, 0.005, 2 * MODULUS)
    assert static_forces(found) == pytest.approx(20.0, rel=1e-6)
    assert found["prestage/force_x"] == pytest.approx(20.0, rel=1e-8)
    assert found["prestage/moved_x"] == pytest.approx(between / 2 + wall, rel=1e-6)
    assert sorted(found["wall_contacts/id"].tolist()) == [1, 2]
    assert np.abs(found["walls/xlo/force"]).max() == pytest.approx(20.0, rel=1e-2)


def test_guide_without_rotation(tmp_path: Path) -> None:
    """A grain in a groove hits another one: it moves only along z and does not rotate."""
    places = [[0, 0, 0], [0.006, 0, 0.008], [0.006, 0.02, 0.02]]
    found = loaded_result(tmp_path, "groove", packing=grains_at(places), boundary={"bottom": "free"},
                      contact={"law": "hertz", "friction": 0.3}, guide=[{"index": 1, "free": "z", "rotation": False}],
                      load={"index": [1], "velocity": 1.0}, run={"end_time": 2e-5, "frames": 2})  # fmt: skip
    velocity = found.frame(1, "velocity")
    assert not velocity[0, :2].any() and velocity[0, 2] < 1.0
    assert velocity[1, 0] > 0 and velocity[1, 2] > 0


def test_walls_to_a_force_with_yield_are_refused(tmp_path: Path) -> None:
    tables = {"contact": {"law": "elastoplastic"}, "boundary": {"bottom": "free", "x": "wall"},
              "precompression": {"kind": "walls", "x_force": 5000.0}, "load": {"index": [1], "velocity": 1e-3}}  # fmt: skip
    with pytest.raises(
        InputError,
        match=r"x_force: found 5000 N, about 5e\+03 N on each of 1 grains, where first yield",
    ):
        loaded_result(tmp_path, "yields", packing=grains_at([[0, 0, 0], [0.01, 0, 0]]), **tables)


def test_contacts_that_yield_where_walls_do_not(tmp_path: Path) -> None:
    """The contacts with the walls do not yield, but the contacts with the small grain between the
    two others yield earlier.
    """
    text = "x,y,z,diameter\n0,0,0,0.01\n0.007,0,0,0.004\n0.014,0,0,0.01\n"
    tables = {"contact": {"law": "elastoplastic"}, "boundary": {"bottom": "free", "x": "wall"},
              "precompression": {"kind": "walls", "x_force": 4.0}, "load": {"index": [1], "velocity": 1e-3}}  # fmt: skip
    with pytest.raises(
        RunError, match="expected 4 N: their distance is computed with elastic contacts"
    ):
        loaded_result(tmp_path, "yields", packing={"kind": "file", "grains": text}, **tables)
