"""Friction of the holder of a chain (fix gran/holder), damping layers and ends (fix gran/absorb): closed forms, energy."""

from __future__ import annotations

import numpy as np
import pytest

from tests.conftest import script_of
from tests.helpers.two_spheres import value

MU, G, DENSITY = 0.3, 9.81, 8500.0
LAW = "hertz 115e9 0.3"
HOLDER = f"fix holder all gran/holder z {MU} {G}"


def beads(lammps, n=1, speed=0.0, extra=HOLDER, dt=1e-6, gap=0.0):
    """Beads in a row, the first with a speed; the energy is that of the contacts, of motion and of the holder."""
    lmp = lammps()
    places = [(0, 0, k * (0.01 + gap)) for k in range(n)]
    speeds = [(0, 0, speed)] + [(0, 0, 0)] * (n - 1)
    text = script_of(places, style=LAW, velocities=speeds, box=[-0.1, 0.1] * 3, density=DENSITY)
    lmp.commands_string(f"{text}\ntimestep {dt}\n{extra}\n")
    return lmp


@pytest.mark.parametrize("dt", [1e-6, 7e-6, 1e-4])
def test_a_sliding_bead_stops_where_it_must(lammps, dt):
    """Path v^2/(2 mu g), and all kinetic energy is taken; it then rests, exactly."""
    speed = 0.05
    lmp = beads(lammps, speed=speed, dt=dt)
    lmp.command(f"run {round(1.2 * speed / (MU * G) / dt)} post no")
    assert value(lmp, "z[1]") == pytest.approx(speed**2 / (2 * MU * G), rel=2 * (dt * MU * G / speed) ** 2 + 1e-12)
    assert value(lmp, "vz[1]") == 0.0
    assert value(lmp, "f_holder") == pytest.approx(0.5 * value(lmp, "mass[1]") * speed**2, rel=(dt * MU * G / speed))


@pytest.mark.parametrize("dt", [1e-6, 1e-5])
def test_energy_of_a_bead_that_slides_all_the_time(lammps, dt):
    """While it slides, what the holder took is what the motion lost, to rounding."""
    lmp = beads(lammps, speed=0.05, dt=dt)
    lmp.command(f"run {round(0.01 / dt)} post no")
    before, now = (0.5 * value(lmp, "mass[1]") * v**2 for v in (0.05, value(lmp, "vz[1]")))
    assert value(lmp, "vz[1]") == pytest.approx(0.05 - MU * G * 0.01, rel=1e-12)
    assert value(lmp, "f_holder") == pytest.approx(before - now, rel=1e-11)


@pytest.mark.parametrize("share", [0.0, 0.5, 0.999, 1.5])
def test_a_pulled_bead_is_held_or_slides(lammps, share):
    """Below the limit it stays exactly where it is and nothing is lost; above, it is accelerated by the difference."""
    pull = "variable pull equal {share}*{MU}*{G}*mass(all)\nfix pull all addforce 0 0 v_pull\n"
    lmp = beads(lammps, extra=pull.format(share=share, MU=MU, G=G) + HOLDER)
    lmp.command("run 5000 post no")
    way = 0.5 * max(share - 1, 0) * MU * G * 5e-3**2
    assert value(lmp, "z[1]") == pytest.approx(way, rel=1e-9)
    assert value(lmp, "f_holder") == pytest.approx(MU * G * value(lmp, "mass[1]") * way, rel=1e-6)
    if share < 1:
        assert value(lmp, "z[1]") == value(lmp, "vz[1]") == value(lmp, "f_holder") == 0.0


def test_the_energy_of_a_collision_closes(lammps):
    """Three beads, one of which hits the others after a flight: kinetic + stored + taken by the holder is the input."""
    lmp = beads(lammps, 3, speed=0.2, dt=1e-7, gap=1e-5)
    lmp.command("run 0 post no")
    for _ in range(20):
        lmp.command("run 1000 post no")
        total = value(lmp, "c_ke+pe+f_holder") / (0.5 * value(lmp, "mass[1]") * 0.2**2)
        assert total == pytest.approx(1, abs=3e-6)
    assert value(lmp, "f_holder") > 0 and value(lmp, "vz[3]") > 0.1


STEEL = "hertz 210e9 0.3"
RATE = 2e3
MASS = 8500 * np.pi / 6 * 0.01**3


def lone(lammps, words, dt=1e-6):
    """One sphere that moves and turns; `words` are those of the fix."""
    lmp = lammps()
    text = script_of([(0, 0, 0)], style=STEEL, velocities=[(1.0, -2.0, 3.0)], box=[-0.1, 0.1] * 3)
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
