"""Compatibility with other LAMMPS commands, motion that is not finite, and tests of LAMMPS, YADE and MercuryDPM."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from tests.conftest import refuses, script_of
from tests.helpers.rubbing import BRASS, HERTZ, rubbing, same, state
from tests.helpers.two_spheres import BOX, PAIR, WALL, R, collide, value


def test_omp_suffix_falls_back_to_the_plain_style(lammps):
    plain, suffixed = lammps(), lammps(options=("-sf", "omp", "-pk", "omp", "1"))
    collide(plain)
    collide(suffixed)
    assert value(suffixed, "vz[1]") == pytest.approx(value(plain, "vz[1]"), rel=1e-13)
    assert value(suffixed, "c_ep[1]") == pytest.approx(value(plain, "c_ep[1]"), rel=1e-13)


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


# places, velocities, wall, timestep and steps: a sphere that comes from afar; a plane, on a soft support, thrown across several skins
FAR = {
    "sphere": ([(0, 0, 0)], [(0, 0, 20)], WALL.format(z=0.03), 1e-8, 150000),
    "plane": ([(0, 0, 0), (0.02, 0, -0.0017)], [(0, 0, 20), (0, 0, 0)],
              f"fix floor all wall/gran/hysteretic zplane NULL 0.005 {HERTZ} support 1e-2 1e4 0.0", 1e-7, 60000),
}  # fmt: skip


@pytest.mark.parametrize("what", FAR)
def test_walls_and_spheres_from_afar_meet(lammps, what):
    places, speeds, wall, timestep, steps = FAR[what]
    found = []
    for lists in (SELDOM, EVERY_STEP):
        extra = f"{lists}\n{wall}\ntimestep {timestep}\n"
        lmp = lammps(
            rubbing(places, BRASS, velocities=speeds, box=[-0.1, 0.1] * 3, extra=extra) + f"run {steps} post no"
        )
        by_id = np.argsort(lmp.numpy.extract_atom("id")[: len(places)])
        found.append(state(lmp, *ALL) | {"floor": lmp.numpy.extract_fix("floor", 1, 2)[by_id]})
    assert found[0]["v"][-1, 2] < 0 and found[0]["floor"][-1, 2] > 0
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


FLOOR = "wall/gran/hysteretic zplane 0 NULL hertz {modulus} {poisson}"


def started(lmp, positions, style, radius, density, velocities, timestep, wall=None, extra=""):
    """Spheres of one of those tests, ready to run."""
    text = script_of(
        positions,
        radius=radius,
        density=density,
        velocities=velocities,
        style=style,
        box=[-20 * radius, 20 * radius] * 3,
        extra=(f"fix floor all {wall}\n" if wall else "") + f"{extra}\ntimestep {timestep:g}",
    )
    text = text.replace("newton off", "newton off\ncomm_modify vel yes")
    lmp.commands_string(text.replace("fix motion all nve\n", "fix motion all nve/sphere\n"))


def after(lmp, steps, name):
    """Array of the first sphere after further steps."""
    lmp.command(f"run {steps}")
    return lmp.numpy.extract_atom(name)[0].copy()


def test_two_spheres_of_a_material(lammps):
    """dem02-hertzmaterial-twosphere-3d-si.yaml: 20 m/s, up to the largest overlap and beyond."""
    lmp, away = lammps(), 0.0101
    started(lmp, [(-away, 0, 0), (away, 0, 0)], "hertz 4.8e10 0.2", 0.01, 2800.0, [(10, 0, 0), (-10, 0, 0)], 2e-8)
    stored = [(500, -9.9999999999997261e-03, 10.0), (1008, -9.8629436766014371e-03, 8.8698006865996614e-03),
              (1000, -9.9982054989131309e-03, -9.9999015644864890)]  # fmt: skip
    for steps, place, velocity in stored:
        assert after(lmp, steps, "x")[0] == pytest.approx(place, rel=1e-10)
        assert lmp.numpy.extract_atom("v")[0, 0] == pytest.approx(velocity, rel=1e-10)


def test_sphere_on_a_wall(lammps):
    """dem03-hertzmaterial-wall-3d-si.yaml: 3.9 m/s."""
    lmp, wall = lammps(), FLOOR.format(modulus=0.5e11, poisson=0.25)
    started(lmp, [(0, 0, 0.00255)], "hertz 1e11 0.25", 0.0025, 7000.0, [(0, 0, -3.9)], 1e-8, wall)
    stored = [(1300, 2.4993000166951712e-03, -3.8996733776535106), (838, 2.4773193534324612e-03, 9.2814738217408040e-04),
              (900, 2.5017266363104966e-03, 3.9000000198738074)]  # fmt: skip
    for steps, place, velocity in stored:
        assert after(lmp, steps, "x")[2] == pytest.approx(place, rel=1e-10)
        assert lmp.numpy.extract_atom("v")[0, 2] == pytest.approx(velocity, rel=1e-9)


@pytest.mark.parametrize(
    ("tangential", "steps", "velocity", "spin"),
    [
        ("mindlin_rescale", 1724 + 1593, (1.9626341306396919, 2.9278423115198366), 5.4426586936030731e02),
        ("mindlin", 1700 + 1600, (1.9626341996620487, 2.9278423105668629), 5.4426580033795710e02),
    ],
)
def test_oblique_impact(lammps, tangential, steps, velocity, spin):
    """dem04-mindlinrescaleforce-oblique-3d-si.yaml and dem04-mindlinforce-oblique-3d-si.yaml: test 4 of Chung and Ooi.

    Restitution 0.98 by the same dashpot. Theirs may pull at the end, damps the tangential motion too and takes R as lever
    arm of the slip: that makes the difference, which is largest in the spin.
    """
    damping = -math.sqrt(5) * math.log(0.98) / math.hypot(math.pi, math.log(0.98))
    lmp, wall = lammps(), FLOOR.format(modulus=3.5e10, poisson=0.33)
    wall += f" friction 0.092 tangential {tangential} loss dashpot {damping:.17g}"
    started(lmp, [(0, 0, 0.00255)], "hertz 7e10 0.33", 0.0025, 2700.0, [(2.5069, 0, -2.9876)], 1e-8, wall)
    assert after(lmp, steps, "v")[[0, 2]] == pytest.approx(velocity, rel=2e-4)
    assert lmp.numpy.extract_atom("omega")[0, 1] == pytest.approx(spin, rel=3e-3)


ALONE = [*PAIR, (0.1, 0, 0)]  # the third has no other sphere within reach
ROUGH = {"style": "elastoplastic 115e9 0.3 550e6 friction 0.3", "extra": "comm_modify vel yes"}
BAD = "variable bad equal exp(1000)-exp(1000)\n"  # NaN: not a valid word in LAMMPS


def foreign(text: str) -> str:
    """Input script with a pair style of LAMMPS that exerts no force."""
    text = re.sub("pair_style.*", "pair_style zero 0.02", text)
    text = re.sub("pair_coeff.*", "pair_coeff * *", text)
    return re.sub("compute ep.*\nthermo_style.*\n", "", text)


def spoil(lmp, name: str, ident: int, amount: float, axis: int = 0) -> None:
    ids = lmp.numpy.extract_atom("id")
    lmp.numpy.extract_atom(name)[np.flatnonzero(ids == ident)[0]][axis] = amount


@pytest.mark.parametrize("amount", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("name, meaning", [("x", "position"), ("v", "velocity")])
@pytest.mark.parametrize("ident", [1, 3], ids=["of a pair", "alone"])
@pytest.mark.parametrize("begin", ["", "pre no"])
def test_not_finite_at_the_start_of_a_run(lammps, amount, name, meaning, ident, begin):
    lmp = lammps(script_of(ALONE))
    if begin:
        lmp.command("run 7")  # an odd step: detected nevertheless
    spoil(lmp, name, ident, amount)
    where = "position|velocity" if begin else meaning
    refuses(lmp, f"run 200 {begin}", rf"The ({where}) of sphere {ident} is not finite \((nan|-?inf) ")


@pytest.mark.parametrize("positions, sphere", [(PAIR, 2), (ALONE, 3)])
@pytest.mark.parametrize("check", ["check yes", "check no", "delay 1000000000 check yes"])
@pytest.mark.parametrize("options", [{}, ROUGH], ids=["smooth", "rough"])
def test_a_force_that_turns_into_nan(lammps, positions, sphere, check, options):
    """LAMMPS with `check yes` does not rebuild neighbor lists for a sphere at NaN, as if it had not moved."""
    lmp = lammps(script_of(positions, **options) + BAD)
    lmp.commands_string(
        f"neigh_modify every 1 {check}\nrun 250\ngroup hit id {sphere}\n"
        "fix gone hit addforce v_bad 0.0 0.0\nthermo 1000000"
    )
    refuses(lmp, "run 20000", rf"The position of sphere {sphere} is not finite \(nan 0 ")


PUSH = "group struck id 1\nfix push struck gran/load z"
WALLED = "fix floor all wall/gran/hysteretic zplane {} elastoplastic 115e9 0.3 550e6"
# script, array that is spoiled, ID and axis, what is run then, what the error says
SPOILED = {
    "spin": (script_of(ALONE, **ROUGH), "omega", 2, 1, "run 200", r"The angular velocity of sphere 2 is not finite \(0 nan 0\)"),
    "minimization": (script_of(PAIR, style=HERTZ) + "min_style fire\n", "x", 2, 0, "minimize 0 1e-9 500 500", "position of sphere 2"),
    "node of a bar": (  # which has radius 0 and may touch nothing at all
        script_of([*PAIR, (0, 0, 0.03)], radius=[R, R, 1e-3]) + "set atom 3 diameter 0 mass 1e-4\nrun 7\n",
        "v", 3, 2, "run 200 pre no", r"The position of sphere 3 is not finite \(0 0 nan\)",
    ),
    "force by itself": (
        foreign(script_of(PAIR, box=BOX, extra=f"{PUSH} force half-sine 100 1e-5")) + "run 7",
        "v", 1, 2, "run 200 pre no", r"The position of sphere 1 is not finite \(0 0 nan\)",
    ),
} | {
    f"walls {planes} by themselves": (
        foreign(script_of([(0, 0, 0)], box=BOX, extra=WALLED.format(planes))) + "run 7",
        "x", 1, 2, "run 200 pre no", r"The position of sphere 1 is not finite \(0 0 nan\)",
    )
    for planes in (f"NULL {R}", f"-{R} NULL", f"-{R} {R}")
}  # fmt: skip


@pytest.mark.parametrize("what", SPOILED)
def test_what_is_spoiled_is_found(lammps, what):
    script, name, ident, axis, command, message = SPOILED[what]
    lmp = lammps(script)
    spoil(lmp, name, ident, np.nan, axis)
    refuses(lmp, command, message)


def test_nan_is_found_before_it_is_reported(lammps):
    """Positions set after a run are not included in any sum, row or dump."""
    dents = "compute dents all gran/hysteretic/local\ncompute sum all reduce sum c_dents[4] inputs local\n"
    lmp = lammps(f"{script_of(ALONE)}{dents}run 7")
    spoil(lmp, "x", 3, np.nan)
    lmp.command("variable force equal c_sum")
    with pytest.raises(Exception, match="The position of sphere 3 is not finite"):
        lmp.extract_variable("force")


def test_a_prescribed_displacement_by_itself(lammps):
    """Driven atoms follow their path for any force, but the work of a force that is not finite would be NaN."""
    push = f"{PUSH} displacement harmonic 1e-6 8e3\nunfix motion"
    lmp = lammps(foreign(script_of(PAIR, box=BOX, extra=push)) + BAD + "run 7\nfix gone struck addforce 0.0 0.0 v_bad")
    refuses(lmp, "run 200", "Fix gran/load push: the force on its atoms is not finite")


@pytest.mark.parametrize(
    "spoiled", ["velocity struck set v_bad NULL NULL\n", "fix gone struck addforce v_bad 0.0 0.0\n"]
)
def test_on_two_ranks(lmp, tmp_path, spoiled):
    """An error on either rank stops both."""
    script = tmp_path / "in.nan"
    row = [(0, 0, 2 * R * k) for k in range(8)]
    script.write_text(
        script_of(row).replace("units si", "units si\nprocessors 1 1 2")
        + BAD
        + "group struck id 7\n"
        + (spoiled if "velocity" in spoiled else f"run 100\n{spoiled}")
        + "run 20000\nprint 'finished'\n"
    )
    texts = []
    for _ in range(3):  # MPI may end both ranks before it has handed on what one of them said
        done = lmp(script, ranks=2, timeout=60, screen=True)
        assert done.returncode != 0 and "finished" not in done.stdout
        texts.append(done.stdout + done.stderr)
        if re.search(r"ERROR on proc \d: The (position|velocity) of sphere 7 is not finite", texts[-1]):
            return
    pytest.fail("\n".join(texts))


def test_spring_and_dashpot_of_yade(lammps):
    """YADE, scripts/checks-and-tests/checks/checkViscElPM.py: stiffness and dashpot of a restitution of 0.3 and a contact time of 0.2 s; displacement at 0.05 s.

    At a quarter of their 2 m/s, at which the spheres would be pressed to half their size: everything is linear.
    """
    radius, density, time, restitution, speed = 0.1, 2000.0, 0.2, 0.3, 0.5
    mass = 4 / 3 * math.pi * radius**3 * density
    stiffness = mass / time**2 * (math.pi**2 + math.log(restitution) ** 2) / 2  # of two springs in a row
    rate = -math.log(restitution) / time
    law = f"power 1e9 0.3 constant {stiffness:.17g} exponent 1 loss time {rate * mass / stiffness:.17g}"
    lmp = lammps()
    started(lmp, [(0, 0, 0), (2 * radius, 0, 0)], law, radius, density, [(speed, 0, 0), (-speed, 0, 0)], 1e-5)
    lmp.command("run 5000 post no")
    analytical = speed * time / math.pi * math.exp(-0.05 * rate) * math.sin(0.05 * math.pi / time)
    assert lmp.numpy.extract_atom("x")[0, 0] == pytest.approx(analytical, rel=1e-4)


def test_restitution_of_mercury(lammps):
    """MercuryDPM, Drivers/UnitTests/HertzContactRestitutionUnitTest.cpp: Hertz's law with a dashpot, 2 m/s between spheres, restitution 0.8."""
    damping = -math.sqrt(5) * math.log(0.8) / math.hypot(math.pi, math.log(0.8))
    lmp, density = lammps(), 6 / math.pi / 8
    style = f"hertz 40000 0 loss dashpot {damping:.17g}"
    started(lmp, [(0, 0, 0), (3, 0, 0)], style, 1.0, density, [(1, 0, 0), (-1, 0, 0)], 1e-4)
    lmp.command("run 15000 post no")
    assert np.abs(lmp.numpy.extract_atom("v")[:2, 0]) == pytest.approx([0.8, 0.8], abs=1e-2)


def test_sphere_on_an_inclined_plane_of_mercury(lammps):
    """MercuryDPM, Drivers/UnitTests/InclinedPlaneUnitTest.cpp: it rolls without slip and hops on its spring; 1.81167 and 0.00234107 m/s after 1 s."""
    radius, density, angle = 0.005, 2000.0, math.radians(15)
    wall = "wall/gran/hysteretic zplane 0 NULL power 1e9 0.3 constant 10000 exponent 1 friction 0.5"
    weight = f"fix weight all gravity 9.8 vector {math.sin(angle):.17g} 0 {-math.cos(angle):.17g}"
    lmp = lammps()
    started(lmp, [(0, 0, radius)], "hertz 1e9 0.3", radius, density, [(0, 0, 0)], 2e-6, wall, weight)
    lmp.command("run 500000 post no")
    across, up = lmp.numpy.extract_atom("v")[0, [0, 2]]
    assert across == pytest.approx(1.81167, abs=2e-4)
    assert abs(up) < 9.8 * math.cos(angle) * math.sqrt(4 / 3 * math.pi * radius**3 * density / 10000)
