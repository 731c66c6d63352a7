"""Damping along the surface of a contact: a damped oscillation in closed form, energy, and the
tangential damping of LAMMPS's own pair style granular.
"""

from __future__ import annotations

import numpy as np
import pytest

from granwave._contact_laws import ContactLaw
from tests.helpers.bodies.rubbing import (
    BRASS,
    HERTZ,
    MU,
    NU,
    TOTAL,
    E,
    R,
    oblique,
    rubbing,
    state,
)
from tests.helpers.bodies.two_spheres import value

DENSITY = 8500.0
MASS = DENSITY * 4 / 3 * np.pi * R**3
LOSSES = {"time": 5e-6, "dashpot": 0.2}
MODELS = ("mindlin_rescale", "mindlin", "partial_slip")
OVERLAP = 1e-6
STICKING = 1e5  # coefficient of friction
SLOW = 1e-6  # m/s
BOX = [-0.1, 0.1] * 3
WHOLE = f"{TOTAL}+c_en[8]"
FLOOR = "fix floor all wall/gran/hysteretic zplane NULL {at:.17g} {law}"
AT_FLOOR = "c_ke+c_turn+f_floor+f_floor[5]+f_floor[8]+f_floor[9]+f_floor[16]"


def hertz(second: float = R) -> ContactLaw:
    """Law of two spheres, or of a sphere and a rigid wall."""
    modulus = E if np.isfinite(second) else np.inf
    return ContactLaw(
        "hertz",
        youngs_modulus=(E, modulus),
        poisson_ratio=(NU, NU),
        yield_strength=(np.inf, np.inf),
        radius=(R, second),
    )


def coefficient(law: ContactLaw, loss: str, mass: float) -> float:
    """Force of the normal damping / rate of the overlap, N s/m; `mass`: effective, kg."""
    stiffness = law.tangent_stiffness(OVERLAP, OVERLAP)
    if loss == "time":
        return LOSSES["time"] * stiffness
    return LOSSES["dashpot"] * np.sqrt(2 / 3 * mass * stiffness)


def oscillation(time, stiffness, damping, mass, speed):
    """Velocity of a damped oscillator that starts at its rest position with a speed, m/s."""
    decay = damping / (2 * mass)
    frequency = np.sqrt(stiffness / mass - decay**2)
    wave = np.cos(frequency * time) - decay / frequency * np.sin(frequency * time)
    return speed * np.exp(-decay * time) * wave


def pressed(lammps, words: str, *, wall: bool, dt: float):
    """A sphere pressed on another one or on a wall by the force of its overlap; its surface slides
    along x with the speed SLOW.
    """
    law = hertz(np.inf if wall else R)
    force = law.loading_force(OVERLAP)
    places = [(0, 0, 0)] if wall else [(0, 0, 0), (0, 0, 2 * R - OVERLAP)]
    speeds = [(SLOW, 0, 0)] if wall else [(SLOW / 2, 0, 0), (-SLOW / 2, 0, 0)]
    extra = f"group first id 1\nfix push first addforce 0 0 {force:.17g}\n"
    if wall:
        extra += FLOOR.format(at=R - OVERLAP, law=f"{HERTZ} {words}")
    else:
        extra += f"group second id 2\nfix pull second addforce 0 0 {-force:.17g}"
    lmp = lammps(rubbing(places, f"{HERTZ} {words}", velocities=speeds, extra=extra, box=BOX))
    lmp.command(f"timestep {dt}")
    return lmp


def slip_rate(lmp, wall: bool) -> float:
    """Relative tangential velocity of the surfaces along x, m/s."""
    now = state(lmp, "v", "omega")
    lever = R - OVERLAP / 2
    rate = now["v"][0, 0] + now["omega"][0, 1] * lever
    return rate if wall else rate - now["v"][1, 0] + now["omega"][1, 1] * lever


@pytest.mark.parametrize("wall", [False, True])
@pytest.mark.parametrize("loss", LOSSES)
@pytest.mark.parametrize("tangential", MODELS)
def test_a_sticking_contact_oscillates_as_the_closed_form(lammps, tangential, loss, wall):
    """m V' = -k u - x c V with m = m*/(1 + 5/2 (lever/R)^2): frequency and decay, to the second
    order of the timestep.
    """
    law = hertz(np.inf if wall else R)
    mass = MASS if wall else MASS / 2
    ratio = 0.7
    damping = ratio * coefficient(law, loss, mass)
    stiffness = law.tangential_stiffness(OVERLAP, OVERLAP)
    lever = R - OVERLAP / 2
    turned = mass / (1 + 2.5 * (lever / R) ** 2)
    assert 0.05 < damping / (2 * np.sqrt(stiffness * turned)) < 0.7
    words = f"friction {STICKING} tangential {tangential} loss {loss} {LOSSES[loss]}"
    words += f" loss_tangential {ratio}"
    period = 2 * np.pi / np.sqrt(stiffness / turned)
    errors = []
    for steps in (200, 400):
        dt = period / steps
        lmp = pressed(lammps, words, wall=wall, dt=dt)
        lmp.command("run 0 post no")
        worst = 0.0
        for n in range(1, 21):
            lmp.command(f"run {steps // 10} pre no post no")
            expected = oscillation(n * period / 10, stiffness, damping, turned, SLOW)
            worst = max(worst, abs(slip_rate(lmp, wall) - expected) / SLOW)
        errors.append(worst)
    assert errors[0] < 3e-4
    assert errors[1] < 0.4 * errors[0]  # spheres that pass each other also turn the contact


@pytest.mark.parametrize("tangential", MODELS)
@pytest.mark.parametrize("loss", LOSSES)
@pytest.mark.parametrize("speed", [0.1, 1.0, 4.0])
def test_energy_of_an_oblique_impact(lammps, speed, loss, tangential):
    """Kinetic, stored and dissipated energy sum to the input within 1e-6; more is dissipated than
    without.
    """
    words = f"friction {MU} tangential {tangential} loss {loss} {LOSSES[loss]}"
    lmp = oblique(lammps, speed, law=f"{BRASS} {words} loss_tangential 1", steps=20000)
    assert value(lmp, "c_en") == 0 and value(lmp, "c_en[6]") == 0
    assert abs(value(lmp, f"({WHOLE})/v_start-1")) < 1e-6
    plain = oblique(lammps, speed, law=f"{BRASS} {words}", steps=20000)
    assert value(lmp, "c_en[8]") > value(plain, "c_en[8]")


@pytest.mark.parametrize("tangential", MODELS)
def test_energy_at_a_wall(lammps, tangential):
    """The same for a sphere that rebounds obliquely from a wall, with the columns of the wall."""
    words = f"friction {MU} tangential {tangential} loss dashpot 0.2 loss_tangential 1"
    floor = FLOOR.format(at=R, law=f"{BRASS} {words}")
    lmp = lammps(rubbing([(0, 0, 0)], HERTZ, velocities=[(0.3, 0.2, 1.0)], extra=floor, box=BOX))
    lmp.commands_string("thermo_style custom step c_ke c_turn f_floor f_floor[*]\nrun 0 post no")
    start = value(lmp, AT_FLOOR)
    lmp.command("run 20000 post no")
    assert value(lmp, "f_floor") == 0 and value(lmp, "vz[1]") < 0
    assert value(lmp, AT_FLOOR) == pytest.approx(start, rel=1e-6)
    assert value(lmp, "f_floor[9]") >= 0 and value(lmp, "f_floor[16]") > 0


def test_steady_sliding_is_lost_by_friction(lammps):
    """A sphere dragged along another one at a constant speed: the dissipation is the work of
    Coulomb's limit, and almost none is due to damping.
    """
    words = f"friction {MU} loss dashpot 0.2 loss_tangential 1"
    held = "unfix motion\nfix motion all nve/noforce"
    speeds = [(0.1, 0, 0), (0, 0, 0)]
    places = [(0, 0, 0), (0, 0, 2 * R - OVERLAP)]
    lmp = lammps(rubbing(places, f"{HERTZ} {words}", velocities=speeds, extra=held))
    lmp.command("run 1000 post no")
    before = [value(lmp, f"c_en[{n}]") for n in (7, 8)]
    lmp.command("run 100 post no")
    friction, viscous = (
        value(lmp, f"c_en[{n}]") - old for n, old in zip((7, 8), before, strict=True)
    )
    assert friction == pytest.approx(MU * hertz().loading_force(OVERLAP) * 0.1 * 1e-6, rel=5e-3)
    assert abs(viscous) < 1e-3 * friction


def test_a_ratio_of_zero_changes_no_bit(lammps):
    law = f"{BRASS} friction {MU} loss time 1e-6"
    found = [
        state(oblique(lammps, 0.5, law=f"{law}{words}"), "x", "v", "omega")
        for words in ("", " loss_tangential 0")
    ]
    for name, values in found[0].items():
        assert np.array_equal(values, found[1][name])


def tsuji(restitution: float) -> float:
    """Factor of Tsuji's dashpot: the polynomial of LAMMPS's damping tsuji."""
    powers = (1.2728, -4.2783, 11.087, -22.348, 27.467, -18.022, 4.8218)
    return sum(c * restitution**n for n, c in enumerate(powers))


@pytest.mark.parametrize("model", ["mindlin_rescale", "mindlin"])
@pytest.mark.parametrize("across", [0.3, 1.0, 3.0])
def test_against_the_damping_of_lammps(lammps, across, model):
    """Forces during an oblique impact agree with pair style granular within 0.1 % of the largest,
    velocities after it within 5e-4 and spins within 0.3 %; without the damping along the surface
    the spins differ by more than 5 %.
    """
    own = (
        f"pair_style granular\npair_coeff * * hertz/material {E} 0.7 {NU} tangential {model}/force "
        f"NULL 1.0 {MU} damping tsuji limit_damping"
    )
    law = f"{HERTZ} friction {MU} tangential {model} loss dashpot {tsuji(0.7):.17g}"
    theirs = oblique(lammps, across, own=own, steps=0)
    ours = oblique(lammps, across, law=f"{law} loss_tangential 1", steps=0)
    plain = oblique(lammps, across, law=law, steps=8000)
    limit = 0.0
    worst = 0.0
    for _ in range(40):
        forces = []
        for lmp in (ours, theirs):
            lmp.command("run 100 pre no post no")
            forces.append(state(lmp, "f")["f"])
        limit = max(limit, abs(forces[1]).max())
        worst = max(worst, abs(forces[0] - forces[1]).max())
    for lmp in (ours, theirs):
        lmp.command("run 4000 pre no post no")
    spins = [state(lmp, "omega")["omega"][0, 1] for lmp in (ours, theirs, plain)]
    speeds = [state(lmp, "v")["v"] for lmp in (ours, theirs)]
    assert worst < 1e-3 * limit
    assert speeds[0] == pytest.approx(speeds[1], abs=5e-4)
    # LAMMPS has the full radius as the lever arm of the slip
    assert spins[0] == pytest.approx(spins[1], rel=3e-3)
    if across < 3.0:  # beyond, the contact slides throughout
        assert abs(spins[2] / spins[1] - 1) > 0.05
