"""Compatibility with other LAMMPS commands; skipping spheres at rest, and those far from the walls, changes no bit."""

from __future__ import annotations

import numpy as np
import pytest

from tests.conftest import script_of
from tests.helpers.rubbing import BRASS, HERTZ, rubbing, same, state
from tests.helpers.two_spheres import WALL, R, collide, value


def test_omp_suffix_falls_back_to_the_plain_style(lammps):
    plain, suffixed = lammps(), lammps(options=("-sf", "omp", "-pk", "omp", "1"))
    collide(plain)
    collide(suffixed)
    assert value(suffixed, "vz[1]") == pytest.approx(value(plain, "vz[1]"), rel=1e-13)
    assert value(suffixed, "c_ep[1]") == pytest.approx(value(plain, "c_ep[1]"), rel=1e-13)


@pytest.mark.parametrize(
    "every", ["every 1 delay 0 check no", "every 7 delay 0 check yes", "every 1 delay 10 check yes"]
)
def test_any_neighbour_settings(lammps, every):
    usual, other = lammps(), lammps()
    collide(usual)
    collide(other, extra=f"neigh_modify {every}")
    assert value(other, "c_ep[1]") == pytest.approx(value(usual, "c_ep[1]"), rel=1e-12)


def test_frozen_sphere(lammps):
    """A fixed sphere acts as a wall of the same material: it absorbs momentum but no energy."""
    lmp = lammps()
    collide(lmp, speed=0.0, steps=0, extra="group held id 2\nfix hold held freeze\nset atom 1 vz 1.0")
    lmp.command("run 20000")
    assert value(lmp, "vz[2]") == 0
    mass = value(lmp, "mass[1]")
    assert value(lmp, "c_ke+pe+c_ep[1]") == pytest.approx(0.5 * mass, rel=1e-6)


def test_dents_do_not_go_into_data_files(lammps, tmp_path):
    """Data files contain positions and velocities, but no dents, for which LAMMPS has no section."""
    lmp = lammps()
    collide(lmp)
    lmp.command(f"write_data {tmp_path}/all.data nocoeff")
    again = lammps(
        f"units si\natom_style sphere\natom_modify map yes\nnewton off\nboundary m m m\nread_data {tmp_path}/all.data\n"
        "pair_style gran/hysteretic 1e-3\npair_coeff * * elastoplastic 115e9 0.3 550e6\ncompute ep all pair gran/hysteretic\n"
        "thermo_style custom step c_ep[1]\nrun 0"
    )
    assert value(again, "vz[1]") == pytest.approx(value(lmp, "vz[1]"), rel=1e-12)
    assert value(again, "c_ep[1]") == 0


def test_any_consistent_units(lammps):
    """Collision in centimeters, grams and seconds agrees with that in SI units."""
    si, cgs = lammps(), lammps()
    collide(si)
    text = script_of(
        [(0, 0, 0), (0, 0, 200 * R)],
        radius=100 * R,
        density=8.5,
        velocities=[(0, 0, 100.0), (0, 0, -100.0)],
        style="elastoplastic 115e10 0.3 550e7",
        gap=0.1,
    ).replace("units si", "units cgs")
    cgs.commands_string(text)
    cgs.command("run 20000")
    assert value(cgs, "vz[1]") == pytest.approx(100 * value(si, "vz[1]"), rel=1e-9)
    assert value(cgs, "c_ep[1]") == pytest.approx(1e7 * value(si, "c_ep[1]"), rel=1e-9)


def test_only_the_group_is_reported(lammps):
    lmp = lammps(
        script_of(
            [(0, 0, 0), (0, 0, 2 * R), (0.05, 0, 0), (0.05, 0, 2 * R)],
            velocities=[(0, 0, 1.0), (0, 0, -1.0)] * 2,
            extra="group some id 1 2\ncompute dents some gran/hysteretic/local\n"
            "compute sum some reduce sum c_dents[8] inputs local\nthermo_style custom step c_sum c_ep[1]",
        )
    )
    lmp.command("run 20000")
    assert value(lmp, "c_sum") == pytest.approx(0.5 * value(lmp, "c_ep[1]"), rel=1e-12)


EVERY_STEP = "neigh_modify delay 0 every 1 check no"  # new lists, with which nothing is skipped
SELDOM = "neigh_modify delay 0 every 10 check yes"
SHAPE = (6, 6, 12)  # a layer is longer than a block
TOP = 2 * R * (SHAPE[2] - 0.5)
ALL = ("x", "v", "f", "omega", "torque")


def packing(lammps, law: str, lists: str, extra: str = "", **options):
    """Simple cubic packing on a wall, two of whose spheres move."""
    places = 2 * R * np.array([(x, y, z) for z in range(SHAPE[2]) for y in range(SHAPE[1]) for x in range(SHAPE[0])])
    speeds = np.zeros_like(places)
    speeds[8], speeds[-1] = (0.1, 0.3, 2.0), (-1.0, 0.0, 0.5)
    box = [-0.05, 0.1, -0.05, 0.1, -0.05, 0.2]
    lmp = lammps()
    extra = f"{lists}\n{WALL.format(z=TOP)}\n{extra}"
    lmp.commands_string(rubbing(places, law, velocities=speeds, box=box, extra=extra, **options))
    return lmp


@pytest.mark.parametrize("law", [HERTZ, BRASS, f"{BRASS} friction 0.3"])
def test_the_same_as_with_new_lists_in_every_step(lammps, law):
    found = []
    for lists in (SELDOM, EVERY_STEP):
        lmp = packing(lammps, law, lists)
        lmp.command("run 4000 post no")
        found.append(state(lmp, *ALL))
    assert 0 < np.count_nonzero(found[0]["v"].any(axis=1)) < len(found[0]["v"]), "some spheres are still at rest"
    same(*found)


@pytest.mark.parametrize(
    "mover",
    [
        "fix away pushed move linear -3 0 0",
        "run 300 post no\nvelocity pushed set -3 0 0",
        "run 300 post no\ndisplace_atoms pushed move -1e-6 0 0 units box",
    ],
)
def test_a_sphere_at_rest_is_woken_by_whatever_moves_it(lammps, mover):
    """A sphere far from the impacts, in the middle of a block that nothing has reached."""
    found = []
    for lists in (SELDOM, EVERY_STEP):
        lmp = packing(lammps, BRASS, lists, "group pushed id 200")
        lmp.commands_string(mover + "\nrun 700 post no")
        found.append(state(lmp, *ALL))
    assert found[0]["v"][198].any(), "the neighbour was hit"
    same(*found)


def test_a_sphere_that_comes_from_afar_meets_the_wall(lammps):
    found = []
    for lists in (SELDOM, EVERY_STEP):
        lmp = lammps()
        wall = WALL.format(z=0.03)
        lmp.commands_string(
            rubbing([(0, 0, 0)], BRASS, velocities=[(0, 0, 20)], box=[-0.1, 0.1] * 3, extra=f"{lists}\n{wall}")
        )
        lmp.command("run 150000 post no")
        found.append((state(lmp, *ALL), lmp.numpy.extract_fix("floor", 1, 2).copy()))
    (one, wall_one), (other, wall_other) = found
    assert one["v"][0, 2] < 0 and wall_one[0, 2] > 0
    assert np.array_equal(wall_one, wall_other)
    same(one, other)


def test_a_wall_that_moves_far_meets_the_sphere(lammps):
    """The plane, on a soft support, is thrown across several skins between two lists of near spheres."""
    found = []
    for lists in (SELDOM, EVERY_STEP):
        lmp = lammps()
        wall = "fix floor all wall/gran/hysteretic zplane NULL 0.005 hertz 115e9 0.3 support 1e-2 1e4 0.0"
        places, speeds = [(0, 0, 0), (0.02, 0, -0.0017)], [(0, 0, 20), (0, 0, 0)]
        lmp.commands_string(
            rubbing(places, HERTZ, velocities=speeds, box=[-0.1, 0.1] * 3, extra=f"{lists}\n{wall}\ntimestep 1e-7")
        )
        lmp.command("run 60000 post no")
        found.append(state(lmp, *ALL))
    assert found[0]["v"][1, 2] < 0, "hit by the plane on its way back"
    same(*found)


@pytest.mark.parametrize("law", [BRASS, f"{BRASS} friction 0.3"])
@pytest.mark.parametrize("radii", [(R, R), (R, 0.999 * R)])
def test_the_order_in_memory_changes_no_bit(lammps, law, radii):
    """In the order of their IDs rows of spheres are searched together, sorted into bins most of them alone."""
    places = 2 * R * np.array([(x, y, z) for z in range(4) for y in range(5) for x in range(11)])
    rng = np.random.default_rng(1)
    speeds, radius = rng.uniform(-0.5, 0.5, places.shape), np.resize(radii, len(places)).tolist()
    found = []
    for sort in ("0 0", f"1 {4.2 * R}"):
        lmp = lammps()
        box = [-0.05, 0.2, -0.05, 0.1, -0.05, 0.1]
        script = rubbing(places, law, radius=radius, velocities=speeds, density=8500.0, box=box, extra=SELDOM)
        lmp.commands_string(script.replace("atom_modify map yes", f"atom_modify map yes sort {sort}"))
        lmp.command("run 1000 post no")
        ids = lmp.numpy.extract_atom("id")[: len(places)]
        assert (np.diff(ids) == 1).all() == (sort == "0 0")
        found.append(state(lmp, *ALL))
    assert found[0]["f"].any()
    same(*found)
