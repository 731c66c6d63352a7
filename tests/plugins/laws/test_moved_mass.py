"""Effective masses of dashpots with bodies that are held, rigid, or of a finite mass.

With the effective mass m* of two bodies along their normal, Tsuji's dashpot gives Hertz's contact one
restitution e at any speed and mass: the impulse of a collision is (1 + e) m* v. For held and guided
bodies 1/m* = n.P n/m + ..., where P projects a force onto the free directions.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from granwave._contact_laws import ContactLaw
from tests.conftest import printed, script_of
from tests.helpers.bodies.rubbing import same, state
from tests.helpers.bodies.two_spheres import BOX, MASS, PAIR, R, value
from tests.helpers.selection import with_every_test
from tests.plugins.test_going_on import resumed

HERTZ = "hertz 115e9 0.3"
FACTOR = 0.6
TWO = {"youngs_modulus": (115e9, 115e9), "poisson_ratio": (0.3, 0.3), "radius": (R, R)}
RESTITUTION = ContactLaw("hertz", **TWO, yield_strength=(1e9, 1e9)).collide(
    1.0, 1.0, loss_dashpot=FACTOR, steps=4000
)["restitution"]
# time of a contact of two spheres at 1 m/s is 45 us
STEPS = 12000


def script(places, velocities, extra: str, **options) -> str:
    text = script_of(
        places,
        style=f"{HERTZ} loss dashpot {FACTOR}",
        velocities=velocities,
        box=BOX,
        extra=f"group first id 1\ngroup other id 2\n{extra}\n",
        **options,
    )
    return text.replace("newton off", "newton off\ncomm_modify vel yes")


def head_on(extra: str) -> str:
    """Sphere that hits the other one along z at 1 m/s."""
    return script(PAIR, [(0, 0, 1.0)], extra)


HOLDS = {
    "setforce": "fix hold other setforce 0 0 0",
    "setforce along the normal": "fix hold other setforce NULL NULL 0",
    "setforce by a variable": "variable none equal 0\nfix hold other setforce 0 0 v_none",
    "setforce in a region": "region top block INF INF INF INF 0.004 INF units box\n"
    "fix hold all setforce 0 0 0 region top",
    "planeforce": "fix hold other planeforce 0 0 1",
    "lineforce across": "fix hold other lineforce 1 0 0",
    "freeze": "fix hold other freeze",
    "no integration": "unfix motion\nfix motion first nve",
    "gran/nve of the first": "unfix motion\nfix motion first gran/nve",
    "move": "unfix motion\nfix motion first nve\nfix hold other move linear 0 0 0",
    "nve/noforce": "unfix motion\nfix motion first nve\nfix hold other nve/noforce",
    "prescribed displacement": "unfix motion\nfix motion first nve\n"
    "fix hold other gran/load z displacement harmonic 1e-30 1",
}


def test_the_restitution_of_the_tests() -> None:
    assert pytest.approx(0.4849, abs=5e-5) == RESTITUTION


@pytest.mark.parametrize("name", HOLDS)
def test_a_held_sphere_is_a_wall(lammps, name) -> None:
    lmp = lammps(f"{head_on(HOLDS[name])}run {STEPS} post no")
    assert value(lmp, "vz[1]") == pytest.approx(-RESTITUTION, abs=1e-4)


@pytest.mark.parametrize("hold", ["setforce 0 0 NULL", "lineforce 0 0 1", "planeforce 1 0 0"])
def test_a_sphere_that_is_guided_along_the_normal_is_free(lammps, hold) -> None:
    lmp = lammps(f"{head_on(f'fix hold other {hold}')}run {STEPS} post no")
    assert value(lmp, "vz[1]") == pytest.approx((1 - RESTITUTION) / 2, abs=1e-4)
    assert value(lmp, "vz[2]") == pytest.approx((1 + RESTITUTION) / 2, abs=1e-4)


@pytest.mark.parametrize(
    ("hold", "left"),
    [
        ("setforce 0 0 NULL", np.diag([0, 0, 1])),
        ("setforce NULL 0 0", np.diag([1, 0, 0])),
        ("lineforce 1 0 1", np.array([[1, 0, 1], [0, 0, 0], [1, 0, 1]]) / 2),
        ("lineforce 1 0 -1", np.array([[1, 0, -1], [0, 0, 0], [-1, 0, 1]]) / 2),
        ("planeforce 0 1 1", np.eye(3) - np.array([[0, 0, 0], [0, 1, 1], [0, 1, 1]]) / 2),
    ],
)
def test_a_guided_sphere_counts_along_the_normal(lammps, hold, left) -> None:
    """Impulse of an oblique collision, so slow that the normal does not change."""
    speed = 0.01
    normal = np.array([math.sin(0.7) * math.cos(0.4), math.sin(0.7) * math.sin(0.4), math.cos(0.7)])
    places = [(0, 0, 0), tuple(2 * R * normal)]
    lmp = lammps(
        script(places, [tuple(speed * normal)], f"fix hold other {hold}\ntimestep 2e-8")
        + f"run {2 * STEPS} post no"
    )
    impulse = (1 + RESTITUTION) * speed / (1 + normal @ left @ normal)
    velocity = state(lmp, "v")["v"]
    assert velocity[0] == pytest.approx((speed - impulse) * normal, abs=2e-4 * speed)
    assert velocity[1] == pytest.approx(impulse * left @ normal, abs=2e-4 * speed)


def test_both_held_and_a_hold_that_ends(lammps) -> None:
    """Two held spheres have a finite force; when a hold ends between two runs the sphere is free."""
    lmp = lammps(
        f"{head_on('fix hold all setforce 0 0 0')}compute pair all gran/hysteretic/contact 1 2\n"
        "thermo_style custom step c_pair[*]\nrun 100 post no"
    )
    assert 0 < value(lmp, "c_pair[2]") < math.inf
    assert value(lmp, "vz[1]") == 1.0
    lmp = lammps(f"{head_on(HOLDS['setforce'])}run {STEPS} post no\nunfix hold")
    lmp.commands_string(f"set atom 1 z 0 vz 1.0\nset atom 2 z {2 * R:.17g} vz 0.0")
    lmp.command(f"run {STEPS} post no")
    assert value(lmp, "vz[1]") == pytest.approx((1 - RESTITUTION) / 2, abs=1e-4)


def test_the_force_before_a_hold_is_that_of_the_contacts(lammps) -> None:
    """The test forces that are passed to the fixes do not affect their output."""
    held = lammps(f"{head_on(HOLDS['setforce'])}thermo_style custom step f_hold[3]\nrun 500")
    still = lammps(
        f"{head_on(HOLDS['no integration'])}fix sum other ave/time 1 1 1 c_push\nrun 500".replace(
            "fix sum other", "compute push other reduce sum fz\nfix sum other"
        )
    )
    assert value(held, "f_hold[3]") == pytest.approx(value(still, "f_sum"), rel=1e-12)
    assert value(held, "f_hold[3]") > 100


def test_several_rigid_bodies_of_two_fixes(lammps) -> None:
    """Collision of two rigid pairs of spheres, by two fixes: 2 m on 2 m."""
    places = [(0, 0, -2.1 * R), (0, 0, 4.1 * R), (0, 0, 0), (0, 0, 2 * R)]
    bodies = (
        "group left id 1 3\ngroup right id 2 4\nunfix motion\nfix a left rigid single\n"
        "fix b right rigid single"
    )
    lmp = lammps(
        script(places, [(0, 0, 1.0), (0, 0, 0), (0, 0, 1.0)], bodies) + f"run {2 * STEPS} post no"
    )
    assert value(lmp, "vz[1]") == pytest.approx((1 - RESTITUTION) / 2, abs=1e-4)


# sphere and hold at the boundary between two processors, at z = R
CROSSING = {
    "held": (HOLDS["setforce"], -RESTITUTION),
    "held in motion": ("fix hold other setforce 0 0 0\nset atom 2 vz -1.0", -1 - 2 * RESTITUTION),
    "frozen": (HOLDS["freeze"], -RESTITUTION),
    "not integrated": (HOLDS["no integration"], -RESTITUTION),
    "guided": ("fix hold other setforce 0 0 NULL", (1 - RESTITUTION) / 2),
}


@pytest.mark.parametrize(
    "name",
    with_every_test(CROSSING, ["held"]),
)
def test_two_processors(log_of, name) -> None:
    hold, left = CROSSING[name]
    text = head_on(hold).replace("boundary m m m", "boundary f f f\nprocessors 1 1 *")
    text = text.replace("-0.1 0.1 units box", f"{R - 0.1:.17g} {R + 0.1:.17g} units box")
    end = f"run {STEPS} post no\nprint 'result $(vz[1]:%.17g) $(vz[2]:%.17g)'\n"
    found = [printed(log_of(text + end, ranks), "result") for ranks in (1, 2)]
    assert float(found[0][0]) == pytest.approx(left, abs=2e-4)
    assert found[0] == found[1]


@pytest.mark.parametrize("name", ["setforce", "no integration", "freeze"])
def test_restart(lammps, tmp_path, name) -> None:
    text = head_on(HOLDS[name])
    whole = lammps(f"{text}run {STEPS} post no")
    cut = lammps(f"{text}run 1500 post no\nwrite_restart {tmp_path}/r")
    assert 0.1 < value(cut, "vz[1]") < 0.95  # in contact
    again = lammps(f"{resumed(text, tmp_path / 'r')}run {STEPS - 1500} post no")
    same(*(state(lmp, "x", "v") for lmp in (whole, again)))
    assert value(again, "vz[1]") == pytest.approx(-RESTITUTION, abs=1e-4)


# ------------------------------------------------------------------------------------------ walls

STRIKE = "fix plate all wall/gran/hysteretic zplane NULL {place:.17g} hertz 115e9 0.3 loss dashpot {loss}"


def on_plate(support: str, extra: str = "", velocity=(0, 0, 1.0)) -> str:
    """Sphere that hits a plane on a support."""
    wall = STRIKE.format(place=R, loss=FACTOR)
    text = script_of([(0, 0, 0)], style=HERTZ, velocities=[velocity], box=BOX,
                     extra=f"{wall}{f' support {support}' if support else ''}\n{extra}\n")  # fmt: skip
    return f"{text}thermo_style custom step f_plate[*]\n"


@pytest.mark.parametrize("ratio", [1e6, 10.0, 1.0, 0.1])
@pytest.mark.parametrize("kind", ["spring", "free", "bar"])
def test_a_plate_counts_with_its_mass(lammps, kind, ratio) -> None:
    """Relative restitution of a sphere and a plate of any mass; a bar of one element with a free
    end is a plate of two connected halves.
    """
    mass = f"{ratio * MASS:.17g}"
    support = {
        "spring": f"{mass} 1.0 0",
        "free": f"free {mass} 0",
        "bar": f"bar 1 {mass} 1e13 free",
    }
    dt = "timestep 2e-9" if kind == "bar" else "timestep 1e-8"
    steps = 5 * STEPS if kind == "bar" else STEPS
    if kind == "bar" and ratio > 100:
        support["bar"] = f"bar 1 {mass} 1e16 free"
    lmp = lammps(f"{on_plate(support[kind], dt)}run {steps} post no")
    bounce = (value(lmp, "f_plate[11]") - value(lmp, "vz[1]")) if kind != "bar" else None
    if bounce is not None:
        assert bounce == pytest.approx(RESTITUTION, abs=2e-4)
    left = (1 - RESTITUTION * ratio) / (1 + ratio) if ratio < 1e5 else -RESTITUTION
    assert value(lmp, "vz[1]") == pytest.approx(left, abs=3e-4 if kind != "bar" else 5e-3)


@pytest.mark.parametrize(
    "support",
    ["", "1e-5 1e13 0", "1e-3 1e11 0", "0 1e12 1e6", "damper 1e6", "bar 4 0.05 1e14 fixed"],
)
def test_a_plane_that_is_held_is_a_wall(lammps, support) -> None:
    lmp = lammps(f"{on_plate(support, 'timestep 1e-9')}run 100000 post no")
    assert value(lmp, "vz[1]") == pytest.approx(-RESTITUTION, abs=2e-3)


def test_a_held_sphere_under_a_plate(lammps) -> None:
    """A free plate falls on a held sphere: its own mass is the effective one. A fix that holds the
    sphere before the wall fix does not include the force of the wall.
    """
    for hold, left in (
        ("fix hold all setforce 0 0 0", RESTITUTION),
        ("unfix motion", RESTITUTION),
        ("fix hold all setforce 0 0 NULL", -(1 - RESTITUTION) / 2),
    ):
        text = on_plate(f"free {MASS:.17g} 1.0", hold, velocity=(0, 0, 0))
        lmp = lammps(f"{text}run {STEPS} post no")
        assert value(lmp, "f_plate[11]") == pytest.approx(left, abs=1e-4), hold
    text = on_plate(f"free {MASS:.17g} 1.0", velocity=(0, 0, 0))
    text = text.replace("fix plate", "fix hold all setforce 0 0 0\nfix plate")
    lmp = lammps(f"{text}run {STEPS} post no")
    assert value(lmp, "f_plate[11]") == pytest.approx(-(1 - RESTITUTION) / 2, abs=1e-4)


def test_a_guided_sphere_in_a_tube(lammps) -> None:
    """Free only along x, at 45 degrees: the effective mass is 2 m, and half of the normal velocity
    is restored.
    """
    speed = 0.01
    place = 0.01 - R
    tube = f"fix tube all wall/gran/hysteretic tube 0.01 {HERTZ} loss dashpot {FACTOR}\n"
    slope = place / math.sqrt(2)
    text = script_of([(slope, slope, 0)], style=HERTZ, velocities=[(speed, 0, 0)], box=BOX,
                     extra=f"{tube}fix hold all setforce NULL 0 0\ntimestep 1e-8\n")  # fmt: skip
    lmp = lammps(f"{text}run {4 * STEPS} post no")
    assert value(lmp, "vx[1]") == pytest.approx(-RESTITUTION * speed, rel=2e-3)


# ------------------------------------------------------------------------------------------ timestep

TICKS = (
    "timestep 5e-9\ncompute contact all gran/hysteretic/energy\nvariable given equal 0.00222\n"
    "fix step all gran/timestep 32 3e-6 v_given first 4\nthermo_style custom step c_ke pe f_step[*]\n"
)


@pytest.mark.parametrize("name", ["no integration", "prescribed displacement"])
def test_the_error_of_the_timestep_is_of_what_moves(lammps, name) -> None:
    """A sphere that no fix integrates is not accelerated, like a sphere whose force is set to 0."""
    found = []
    for hold in (HOLDS["setforce"], HOLDS[name]):
        extra = f"group first id 1\ngroup other id 2\n{hold}\n{TICKS}"
        text = script_of(PAIR, style=HERTZ, velocities=[(0, 0, 1.0)], box=BOX, extra=extra)
        lmp = lammps(f"{text}run 12800 post no")
        found.append([value(lmp, f"f_step[{n}]") for n in range(1, 6)])
        assert value(lmp, "vz[1]") == pytest.approx(-1, abs=1e-5)
    assert found[1] == pytest.approx(found[0], rel=1e-9)


def test_forces_and_torques_on_a_sphere_that_does_not_move(lammps) -> None:
    """The error with all spheres equals the error with the group of spheres that move and
    rotate.
    """
    found = []
    for group in ("all", "first"):
        extra = (
            "group first id 1\nunfix motion\nfix motion first nve/sphere\nset atom 1 vx 1.0\n"
            f"{TICKS.replace('step all', f'step {group}')}"
        )
        text = script_of(
            PAIR, style=f"{HERTZ} friction 0.3", velocities=[(0, 0, 1.0)], box=BOX, extra=extra
        ).replace("newton off", "newton off\ncomm_modify vel yes")
        lmp = lammps(f"{text}run 12800 post no")
        assert lmp.numpy.extract_atom("omega")[0, 1] != 0
        found.append([value(lmp, f"f_step[{n}]") for n in range(1, 6)])
    assert found[1] == pytest.approx(found[0], rel=1e-9)
