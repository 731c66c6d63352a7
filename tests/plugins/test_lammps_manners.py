"""Compatibility with other LAMMPS commands, motion that is not finite, and tests of LAMMPS, YADE
and MercuryDPM.
"""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from tests.conftest import refuses, script_of
from tests.helpers.bodies.rubbing import BRASS, HERTZ, rubbing, same, state
from tests.helpers.bodies.two_spheres import BOX, PAIR, WALL, R, collide, value


def test_omp_suffix_falls_back_to_the_plain_style(lammps):
    plain = lammps()
    suffixed = lammps(options=("-sf", "omp", "-pk", "omp", "1"))
    collide(plain)
    collide(suffixed)
    assert value(suffixed, "vz[1]") == pytest.approx(value(plain, "vz[1]"), rel=1e-13)
    assert value(suffixed, "c_ep[1]") == pytest.approx(value(plain, "c_ep[1]"), rel=1e-13)


def test_frozen_sphere(lammps):
    """A fixed sphere acts as a wall of the same material: it absorbs momentum but no energy."""
    lmp = lammps()
    collide(
        lmp, speed=0.0, steps=0, extra="group held id 2\nfix hold held freeze\nset atom 1 vz 1.0"
    )
    lmp.command("run 20000")
    assert value(lmp, "vz[2]") == 0
    mass = value(lmp, "mass[1]")
    assert value(lmp, "c_ke+pe+c_ep[1]") == pytest.approx(0.5 * mass, rel=1e-6)


def test_dents_do_not_go_into_data_files(lammps, tmp_path):
    """Data files contain positions and velocities, but no dents, because LAMMPS has no section for
    them.
    """
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
    si = lammps()
    cgs = lammps()
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
    places = (
        2
        * R
        * np.array(
            [(x, y, z) for z in range(SHAPE[2]) for y in range(SHAPE[1]) for x in range(SHAPE[0])]
        )
    )
    speeds = np.zeros_like(places)
    speeds[8] = (0.1, 0.3, 2.0)
    speeds[-1] = (-1.0, 0.0, 0.5)
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
    assert 0 < np.count_nonzero(found[0]["v"].any(axis=1)) < len(found[0]["v"]), (
        "some spheres are still at rest"
    )
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
    """A sphere far from the impacts, in the middle of a block that no wave has reached."""
    found = []
    for lists in (SELDOM, EVERY_STEP):
        lmp = packing(lammps, BRASS, lists, "group pushed id 200")
        lmp.commands_string(mover + "\nrun 700 post no")
        found.append(state(lmp, *ALL))
    assert found[0]["v"][198].any(), "the neighbour was hit"
    same(*found)


# places, velocities, wall, timestep and steps: a sphere that comes from afar; a plane, on a soft
# support, thrown across several skins
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
            rubbing(places, BRASS, velocities=speeds, box=[-0.1, 0.1] * 3, extra=extra)
            + f"run {steps} post no"
        )
        by_id = np.argsort(lmp.numpy.extract_atom("id")[: len(places)])
        found.append(state(lmp, *ALL) | {"floor": lmp.numpy.extract_fix("floor", 1, 2)[by_id]})
    assert found[0]["v"][-1, 2] < 0 and found[0]["floor"][-1, 2] > 0
    same(*found)


@pytest.mark.parametrize("law", [BRASS, f"{BRASS} friction 0.3"])
@pytest.mark.parametrize("radii", [(R, R), (R, 0.999 * R)])
def test_the_order_in_memory_changes_no_bit(lammps, law, radii):
    """In the order of their IDs, rows of spheres are searched together; sorted into bins, most are
    searched one by one.
    """
    places = 2 * R * np.array([(x, y, z) for z in range(4) for y in range(5) for x in range(11)])
    rng = np.random.default_rng(1)
    speeds = rng.uniform(-0.5, 0.5, places.shape)
    radius = np.resize(radii, len(places)).tolist()
    found = []
    for sort in ("0 0", f"1 {4.2 * R}"):
        lmp = lammps()
        box = [-0.05, 0.2, -0.05, 0.1, -0.05, 0.1]
        script = rubbing(
            places, law, radius=radius, velocities=speeds, density=8500.0, box=box, extra=SELDOM
        )
        lmp.commands_string(
            script.replace("atom_modify map yes", f"atom_modify map yes sort {sort}")
        )
        lmp.command("run 1000 post no")
        ids = lmp.numpy.extract_atom("id")[: len(places)]
        assert (np.diff(ids) == 1).all() == (sort == "0 0")
        found.append(state(lmp, *ALL))
    assert found[0]["f"].any()
    same(*found)


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
    refuses(
        lmp, f"run 200 {begin}", rf"The ({where}) of sphere {ident} is not finite \((nan|-?inf) "
    )


@pytest.mark.parametrize("positions, sphere", [(PAIR, 2), (ALONE, 3)])
@pytest.mark.parametrize("check", ["check yes", "check no", "delay 1000000000 check yes"])
@pytest.mark.parametrize("options", [{}, ROUGH], ids=["smooth", "rough"])
def test_a_force_that_turns_into_nan(lammps, positions, sphere, check, options):
    """LAMMPS with `check yes` does not rebuild neighbor lists for a sphere at NaN, as if it had not
    moved.
    """
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
    """Driven atoms follow their path for any force, but the work of a force that is not finite
    would be NaN.
    """
    push = f"{PUSH} displacement harmonic 1e-6 8e3\nunfix motion"
    lmp = lammps(
        foreign(script_of(PAIR, box=BOX, extra=push))
        + BAD
        + "run 7\nfix gone struck addforce 0.0 0.0 v_bad"
    )
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
        if re.search(
            r"ERROR on proc \d: The (position|velocity) of sphere 7 is not finite", texts[-1]
        ):
            return
    pytest.fail("\n".join(texts))


def dashpot(restitution: float) -> float:
    """Factor of Tsuji's dashpot with this restitution."""
    return -math.sqrt(5) * math.log(restitution) / math.hypot(math.pi, math.log(restitution))


def chung_and_ooi(tangential: str) -> dict:
    """Test 4, with a restitution of 0.98 by the same dashpot.

    Their force may be tensile at the end, damps the tangential motion too, and uses R as lever arm
    of the slip; this explains the difference, which is largest in the spin.
    """
    return {
        "positions": [(0, 0, 0.00255)], "style": "hertz 7e10 0.33", "radius": 0.0025, "density": 2700.0, "timestep": 1e-8,
        "velocities": [(2.5069, 0, -2.9876)],
        "wall": f"hertz 3.5e10 0.33 friction 0.092 tangential {tangential} loss dashpot {dashpot(0.98):.17g}",
    }  # fmt: skip


YADE = {
    "mass": 8 / 3 * math.pi,
    "rate": -math.log(0.3) / 0.2,
}  # restitution 0.3, contact time 0.2 s
YADE["stiffness"] = (
    YADE["mass"] / 0.2**2 * (math.pi**2 + math.log(0.3) ** 2) / 2
)  # of two springs in a row
TILT = math.radians(15)
HOP = (
    9.8 * math.cos(TILT) * math.sqrt(2000 * 4 / 3 * math.pi * 0.005**3 / 10000)
)  # of a sphere on its spring
# tests of LAMMPS, YADE and MercuryDPM: spheres; then the first one's array and component after
# further steps, and how near it must be
PUBLISHED = {
    "LAMMPS, dem02-hertzmaterial-twosphere-3d-si.yaml: 20 m/s": (
        {"positions": [(-0.0101, 0, 0), (0.0101, 0, 0)], "style": "hertz 4.8e10 0.2", "radius": 0.01, "density": 2800.0,
         "velocities": [(10, 0, 0), (-10, 0, 0)], "timestep": 2e-8},
        [(500, "x", 0, -9.9999999999997261e-03, {"rel": 1e-10}), (0, "v", 0, 10.0, {"rel": 1e-10}),
         (1008, "x", 0, -9.8629436766014371e-03, {"rel": 1e-10}), (0, "v", 0, 8.8698006865996614e-03, {"rel": 1e-10}),
         (1000, "x", 0, -9.9982054989131309e-03, {"rel": 1e-10}), (0, "v", 0, -9.9999015644864890, {"rel": 1e-10})],
    ),
    "LAMMPS, dem03-hertzmaterial-wall-3d-si.yaml: 3.9 m/s": (
        {"positions": [(0, 0, 0.00255)], "style": "hertz 1e11 0.25", "radius": 0.0025, "density": 7000.0,
         "velocities": [(0, 0, -3.9)], "timestep": 1e-8, "wall": "hertz 0.5e11 0.25"},
        [(1300, "x", 2, 2.4993000166951712e-03, {"rel": 1e-10}), (0, "v", 2, -3.8996733776535106, {"rel": 1e-9}),
         (838, "x", 2, 2.4773193534324612e-03, {"rel": 1e-10}), (0, "v", 2, 9.2814738217408040e-04, {"rel": 1e-9}),
         (900, "x", 2, 2.5017266363104966e-03, {"rel": 1e-10}), (0, "v", 2, 3.9000000198738074, {"rel": 1e-9})],
    ),
    "LAMMPS, dem04-mindlinrescaleforce-oblique-3d-si.yaml": (
        chung_and_ooi("mindlin_rescale"),
        [(3317, "v", 0, 1.9626341306396919, {"rel": 2e-4}), (0, "v", 2, 2.9278423115198366, {"rel": 2e-4}),
         (0, "omega", 1, 5.4426586936030731e02, {"rel": 3e-3})],
    ),
    "LAMMPS, dem04-mindlinforce-oblique-3d-si.yaml": (
        chung_and_ooi("mindlin"),
        [(3300, "v", 0, 1.9626341996620487, {"rel": 2e-4}), (0, "v", 2, 2.9278423105668629, {"rel": 2e-4}),
         (0, "omega", 1, 5.4426580033795710e02, {"rel": 3e-3})],
    ),
    # at a quarter of their 2 m/s, at which the spheres would be pressed to half their size:
    # everything is linear
    "YADE, scripts/checks-and-tests/checks/checkViscElPM.py: displacement at 0.05 s": (
        {"positions": [(0, 0, 0), (0.2, 0, 0)], "radius": 0.1, "density": 2000.0, "velocities": [(0.5, 0, 0), (-0.5, 0, 0)], "timestep": 1e-5,
         "style": "power 1e9 0.3 constant {stiffness:.17g} exponent 1 loss time {time:.17g}".format(
             **YADE, time=YADE["rate"] * YADE["mass"] / YADE["stiffness"])},
        [(5000, "x", 0, 0.1 / math.pi * math.exp(-0.05 * YADE["rate"]) * math.sin(0.25 * math.pi), {"rel": 1e-4})],
    ),
    "MercuryDPM, Drivers/UnitTests/HertzContactRestitutionUnitTest.cpp: 2 m/s, restitution 0.8": (
        {"positions": [(0, 0, 0), (3, 0, 0)], "style": f"hertz 40000 0 loss dashpot {dashpot(0.8):.17g}", "radius": 1.0,
         "density": 6 / math.pi / 8, "velocities": [(1, 0, 0), (-1, 0, 0)], "timestep": 1e-4},
        [(15000, "v", 0, -0.8, {"abs": 1e-2})],
    ),
    "MercuryDPM, Drivers/UnitTests/InclinedPlaneUnitTest.cpp: it rolls without slip, and hops on its spring": (
        {"positions": [(0, 0, 0.005)], "style": "hertz 1e9 0.3", "radius": 0.005, "density": 2000.0, "velocities": [(0, 0, 0)],
         "timestep": 2e-6, "wall": "power 1e9 0.3 constant 10000 exponent 1 friction 0.5",
         "extra": f"fix weight all gravity 9.8 vector {math.sin(TILT):.17g} 0 {-math.cos(TILT):.17g}"},
        [(500000, "v", 0, 1.81167, {"abs": 2e-4}), (0, "v", 2, 0.0, {"abs": HOP})],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", PUBLISHED)
def test_published_values(lammps, name):
    spheres = dict(PUBLISHED[name][0])
    stored = PUBLISHED[name][1]
    wall, extra, timestep = (spheres.pop(key, "") for key in ("wall", "extra", "timestep"))
    floor = f"fix floor all wall/gran/hysteretic zplane 0 NULL {wall}\n" if wall else ""
    text = script_of(
        **spheres,
        box=[-20 * spheres["radius"], 20 * spheres["radius"]] * 3,
        extra=f"{floor}{extra}\ntimestep {timestep}",
    )
    text = text.replace("newton off", "newton off\ncomm_modify vel yes").replace(
        "all nve\n", "all nve/sphere\n"
    )
    lmp = lammps(text)
    for steps, array, component, expected, near in stored:
        lmp.command(f"run {steps} post no")
        assert lmp.numpy.extract_atom(array)[0, component] == pytest.approx(expected, **near), array
