"""Damping layers and ends (fix gran/absorb): closed forms of a damped body, reflection, energy, restarts, wrong words."""

from __future__ import annotations

import numpy as np
import pytest

from tests.conftest import script_of
from tests.helpers.two_spheres import value

LAW = "hertz 210e9 0.3"
RATE = 2e3
MASS = 8500 * np.pi / 6 * 0.01**3


def lone(lammps, words, dt=1e-6):
    """One sphere that moves and turns; `words` are those of the fix."""
    lmp = lammps()
    text = script_of([(0, 0, 0)], style=LAW, velocities=[(1.0, -2.0, 3.0)], box=[-0.1, 0.1] * 3)
    turning = "unfix motion\nfix motion all nve/sphere\nset atom 1 omega 100.0 0.0 -300.0"
    lmp.commands_string(
        f"{text}\n{turning}\ntimestep {dt}\nfix calm all gran/absorb {words}\ncompute turn all erotate/sphere"
    )
    return lmp


@pytest.mark.parametrize("dt", [1e-6, 4e-6])
def test_a_damped_sphere_slows_down_exponentially(lammps, dt):
    lmp = lone(lammps, f"rate {RATE}", dt)
    lmp.command("run 0 post no")
    before = value(lmp, "c_ke+c_turn")
    lmp.command(f"run {round(1e-3 / dt)} post no")
    left = np.exp(-RATE * 1e-3)
    near = 2 * (RATE * dt) ** 2
    assert value(lmp, "vz[1]") == pytest.approx(3 * left, rel=near)
    assert value(lmp, "c_turn") == pytest.approx(0.2 * MASS * 0.005**2 * 1e5 * left**2, rel=near)
    assert value(lmp, "c_ke+c_turn+f_calm") == pytest.approx(before, rel=near)


def test_a_rate_rises_as_the_square_and_an_impedance_acts_along_its_axis(lammps):
    lmp = lone(lammps, f"rate {RATE} x -2 2")  # the sphere at 0 feels a quarter of it
    lmp.command("run 100 post no")
    assert value(lmp, "vy[1]") == pytest.approx(-2 * np.exp(-RATE / 4 * 1e-4), rel=2e-4)
    lmp = lone(lammps, f"impedance {MASS * RATE} z")
    lmp.command("run 1000 post no")
    assert value(lmp, "vx[1]") == 1.0
    assert value(lmp, "vz[1]") == pytest.approx(3 * np.exp(-RATE * 1e-3), rel=1e-5)


def test_any_rate_is_stable(lammps):
    lmp = lone(lammps, "rate 1e9")
    lmp.command("run 50 post no")
    assert abs(value(lmp, "vz[1]")) < 3 and value(lmp, "f_calm") > 0
