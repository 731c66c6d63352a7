"""Support of a moving plane: node, damper and bar compared with the equations of motion, energy,
momentum, restart, messages.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from granwave._contact_laws import ContactLaw
from tests.conftest import script_of
from tests.helpers.bodies.two_spheres import value

R = 0.005
MASS = 8500 * 4 / 3 * np.pi * R**3
BRASS = {
    "youngs_modulus": (115e9, np.inf),
    "poisson_ratio": (0.3, 0.0),
    "yield_strength": (550e6, np.inf),
    "radius": (R, np.inf),
}
PLASTIC = "elastoplastic 115e9 0.3 550e6"
# steel bar of 10 mm diameter and 0.5 m length
AREA = np.pi * 0.005**2
LENGTH = 0.5
ELEMENTS = 400
WAVE_SPEED = np.sqrt(200e9 / 7850)
IMPEDANCE = np.sqrt(200e9 * 7850) * AREA
BAR = f"bar {ELEMENTS} {7850 * AREA * LENGTH:.17g} {200e9 * AREA * ELEMENTS / LENGTH:.17g}"
LEDGER = "c_ke+f_plate[4]+f_plate[5]+f_plate[12]+f_plate[13]"
REPORT = "thermo_style custom step c_ke f_plate f_plate[*]"


def thrown(lmp, support, speed=2.0, law=PLASTIC, timestep=1e-8, side="high", extra=""):
    """Sphere that touches the plane and moves towards it."""
    sign = 1.0 if side == "high" else -1.0
    plane = f"NULL {R:.17g}" if side == "high" else f"{-R:.17g} NULL"
    wall = f"fix plate all wall/gran/hysteretic zplane {plane} {law} support {support}\n{REPORT}\ntimestep {timestep}\n{extra}"
    lmp.commands_string(
        script_of([(0, 0, 0)], velocities=[(0, 0, sign * speed)], box=[-0.05, 0.05] * 3, extra=wall)
    )
    return lmp


def motion(law, mass, stiffness, damping, speed, time):
    """Sphere and node by scipy: x, v, u, u' (massless: x, v, u). The dent is tracked by events."""

    def forces(y, peak):
        overlap = y[0] - y[2]
        return (
            float(law.force(overlap, peak) if overlap < peak else law.loading_force(overlap))
            if overlap > 0
            else 0.0
        )

    def plane_speed(y, force):
        return y[3] if mass else (force - stiffness * y[2]) / damping

    def rate(_, y, peak):
        force = forces(y, peak)
        slow = [y[1], -force / MASS, plane_speed(y, force)]
        return [*slow, (force - stiffness * y[2] - damping * y[3]) / mass] if mass else slow

    def turns(_, y, peak):
        return y[1] - plane_speed(y, forces(y, peak))

    def rises(_, y, peak):
        return y[0] - y[2] - peak

    turns.direction = -1
    rises.direction = 1
    turns.terminal = rises.terminal = True
    state = np.array([0, speed, 0, 0] if mass else [0, speed, 0.0], float)
    now = 0.0
    peak = 0.0
    loading = True
    while now < time:
        event = turns if loading else rises
        known = 0.0 if loading else peak
        step = solve_ivp(
            rate,
            (now, time),
            state,
            "DOP853",
            rtol=1e-10,
            atol=1e-16,
            args=(known,),
            events=event,
            max_step=1e-6,
        )
        state = step.y[:, -1]
        now = step.t[-1]
        if step.status == 1:
            if loading:
                peak = max(peak, state[0] - state[2])
            loading = not loading
    return state


@pytest.mark.parametrize("side", ["low", "high"])
@pytest.mark.parametrize("mass", [1e-4, 0.02, 5.0])
def test_a_free_plate_and_a_sphere_collide_as_two_bodies(lammps, side, mass):
    law = "hertz 115e9 0.3"
    speed = 2.0
    lmp = thrown(lammps(), f"free {mass} {speed}", speed=0.0, law=law, side=side)
    lmp.command("run 1")
    given = 0.5 * mass * speed**2
    lmp.command("run 12000")
    sign = -1.0 if side == "high" else 1.0
    thrown_at = 2 * mass / (mass + MASS) * speed
    left = (mass - MASS) / (mass + MASS) * speed
    assert value(lmp, "vz[1]") == pytest.approx(sign * thrown_at, rel=1e-6)
    assert -value(lmp, "f_plate[11]") == pytest.approx(left, rel=1e-6, abs=1e-6 * speed)
    assert value(lmp, LEDGER) == pytest.approx(given, rel=1e-6)
    assert value(lmp, "f_plate[15]") == pytest.approx(
        0.5 * mass * (left**2 - speed**2), rel=1e-4
    )  # work done on it


def test_a_free_plate_waits_for_the_run(lammps):
    lmp = thrown(lammps(), "free 0.02 3.0", speed=0.0, law="hertz 115e9 0.3")
    lmp.commands_string("min_style fire\nminimize 0 1e-9 100 100")
    assert value(lmp, "f_plate[10]") == 0.0 and value(lmp, "f_plate[11]") == -3.0


def state_of(lmp):
    return np.array([value(lmp, f) for f in ("z[1]", "vz[1]", "f_plate[10]", "f_plate[11]")])


@pytest.mark.parametrize(
    ("mass", "stiffness", "damping"),
    [(0.02, 1e9, 500.0), (0.01, 2e8, 0.0), (0, 0, 3000.0), (0, 5e7, 2000.0)],
)
@pytest.mark.parametrize("side", ["low", "high"])
def test_sphere_and_node_move_as_their_equations_say(lammps, mass, stiffness, damping, side):
    lmp = thrown(lammps(), f"{mass} {stiffness} {damping}", side=side)
    lmp.command("run 3500")
    expected = motion(ContactLaw(**BRASS), mass, stiffness, damping, 2.0, 3.5e-5)
    found = state_of(lmp)
    if side == "low":
        found[:2] *= -1
    assert found[: len(expected)] == pytest.approx(expected, rel=2e-5)
    assert value(lmp, LEDGER) == pytest.approx(0.5 * MASS * 4, rel=1e-6)
    assert value(lmp, "f_plate[15]-f_plate[12]-f_plate[13]") == pytest.approx(
        0, abs=1e-6 * 0.5 * MASS * 4
    )
    assert value(lmp, "f_plate[14]") == pytest.approx(
        stiffness * found[2] + damping * found[3], rel=1e-12
    )


@pytest.mark.parametrize("support", ["0.02 1e9 500", "0 5e7 2000"])
def test_the_error_falls_with_the_square_of_the_timestep(lammps, support):
    ends = []
    for halving in range(4):
        lmp = thrown(lammps(), support, law="hertz 115e9 0.3", timestep=4e-8 / 2**halving)
        lmp.command(f"run {250 * 2**halving}")
        ends.append(state_of(lmp)[:3])
    differences = np.abs(np.diff(ends, axis=0))
    assert np.log2(differences[:-1] / differences[1:]) == pytest.approx(2.0, abs=0.35)


def test_massless_plane_closed_form(lammps):
    """A linear contact spring on a damper is a linear system: exp(A t)."""
    stiffness = 18.5 * 550e6 * R
    damping = 2000.0
    lmp = thrown(lammps(), f"0 0 {damping}", law="bilinear 115e9 0.3 550e6 beta 0", timestep=1e-9)
    lmp.command("run 10000")
    system = np.array(
        [
            [0, 1, 0],
            [-stiffness / MASS, 0, stiffness / MASS],
            [stiffness / damping, 0, -stiffness / damping],
        ]
    )
    expected = expm(system * 1e-5) @ [0.0, 2.0, 0.0]
    assert state_of(lmp)[:3] == pytest.approx(expected, rel=1e-6)


def test_momentum_goes_to_the_ground(lammps):
    lmp = thrown(lammps(), "0.02 1e8 300")
    lmp.command("fix ground all ave/time 1 4000 4000 f_plate[14] ave one")
    lmp.command("run 4000")
    # trapezoidal rule: the mean of 1 ... N minus half the difference between the last value and the
    # first, which is 0
    impulse = (value(lmp, "f_ground") * 4000 - 0.5 * value(lmp, "f_plate[14]")) * 1e-8
    assert MASS * value(lmp, "vz[1]") + 0.02 * value(lmp, "f_plate[11]") + impulse == pytest.approx(
        MASS * 2, rel=1e-6
    )


@pytest.mark.parametrize("support", ["0.02 1e9 500", "0 5e7 2000", f"{BAR} free"])
def test_balance_with_friction(lammps, support):
    """The plane moves along its normal, without slip."""
    spin = "set atom 1 vx 0.7 omega 10 50 -30\nunfix motion\nfix motion all nve/sphere\ncompute spin all erotate/sphere"
    lmp = thrown(
        lammps(),
        support,
        law=f"{PLASTIC} friction 0.2",
        extra=f"{spin}\nthermo_style custom step c_ke c_spin f_plate f_plate[*]",
    )
    lmp.command("run 0")
    given = value(lmp, "c_ke+c_spin")
    for _ in range(8):
        lmp.command("run 500")
        assert value(lmp, f"{LEDGER}+c_spin+f_plate[8]+f_plate[9]") == pytest.approx(
            given, rel=1e-6
        )
    assert value(lmp, "f_plate[9]") > 1e-3 * given


# --------------------------------------------------------------------------- bars


def test_impact_on_a_long_bar(lammps):
    """Before a reflection returns a bar acts as its impedance: F = Z u' at its end (d'Alembert)."""
    lmp = thrown(lammps(), f"{BAR} {IMPEDANCE:.17g}", law="hertz 115e9 0.3", timestep=2e-8)
    rigid = ContactLaw("hertz", **{**BRASS, "yield_strength": (np.inf, np.inf)})
    for steps, time in ((500, 1e-5), (1250, 3.5e-5)):
        lmp.command(f"run {steps}")
        expected = motion(rigid, 0, 0, IMPEDANCE, 2.0, time)
        found = state_of(lmp)
        assert found[1] == pytest.approx(expected[1], rel=2e-3)
        assert found[2] == pytest.approx(expected[2], rel=2e-3)
    assert value(lmp, LEDGER) == pytest.approx(0.5 * MASS * 4, rel=1e-6)


def velocities(lmp, steps, every=20):
    """Velocity of the plane by step; the sphere is stopped after separation."""
    found = []
    for _ in range(steps // every):
        lmp.command(f"run {every} pre no post no")
        found.append(value(lmp, "f_plate[11]"))
    return np.array(found)


@pytest.mark.parametrize(
    ("end", "amplitude"), [("free", 2.0), ("fixed", -2.0), (f"{IMPEDANCE:.17g}", 0.0)]
)
def test_echo_of_a_bar(lammps, end, amplitude):
    lmp = thrown(lammps(), f"{BAR} {end}", law="hertz 115e9 0.3", timestep=1e-7)
    lmp.command("run 0")
    found = velocities(lmp, 2600, every=10)
    times = 1e-6 * np.arange(1, len(found) + 1)
    sent = times < 1e-4
    back = times > 1.5e-4
    largest = found[sent].max()
    echo = found[back][np.abs(found[back]).argmax()]
    assert echo / largest == pytest.approx(amplitude, abs=0.01 if amplitude == 0 else 0.03)
    if amplitude:
        delay = times[back][np.abs(found[back]).argmax()] - times[sent][found[sent].argmax()]
        assert delay == pytest.approx(2 * LENGTH / WAVE_SPEED, rel=0.01)
    assert value(lmp, LEDGER) == pytest.approx(0.5 * MASS * 4, rel=2e-5)


# --------------------------------------------------------------------------- statics and messages


@pytest.mark.parametrize("support", ["0.02 1e7 500", f"{BAR} fixed", "0.02 0 500"])
def test_a_minimisation_ends_in_static_balance(lammps, support):
    lmp = thrown(
        lammps(),
        support,
        speed=0.0,
        law="hertz 115e9 0.3",
        extra="fix pull all addforce 0 0 50\nmin_style fire",
    )
    lmp.command("minimize 0 1e-8 20000 20000")
    assert value(lmp, "f_plate[3]") == pytest.approx(50, rel=1e-6)
    stiffness = {"0.02 1e7 500": 1e7, f"{BAR} fixed": 200e9 * AREA / LENGTH}.get(support, np.inf)
    assert value(lmp, "f_plate[10]") == pytest.approx(50 / stiffness, rel=1e-6)
    lmp.commands_string("velocity all set 0 0 0\nrun 1000")
    assert value(lmp, "c_ke") < 1e-12 * value(lmp, "f_plate[4]") or support.endswith("0 500")
