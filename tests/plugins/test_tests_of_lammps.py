"""Tests of LAMMPS's own: the same input under our styles, against the positions, velocities and spins that it stores.

The numbers are those of `unittest/granular/tests/*.yaml` in the repository of LAMMPS, version 4 Jul 2026; each case names
its file. The wall of LAMMPS has the material of the sphere, ours is rigid: half the modulus gives the same contact.
"""

from __future__ import annotations

import math

import pytest

from tests.conftest import script_of

WALL = "wall/gran/hysteretic zplane 0 NULL hertz {modulus} {poisson}"


def started(lmp, positions, style, radius, density, velocities, timestep, wall=None):
    """Spheres of one of those tests, ready to run."""
    text = script_of(
        positions,
        radius=radius,
        density=density,
        velocities=velocities,
        style=style,
        box=[-20 * radius, 20 * radius] * 3,
        extra=(f"fix floor all {wall}\n" if wall else "") + f"timestep {timestep:g}",
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
    lmp, wall = lammps(), WALL.format(modulus=0.5e11, poisson=0.25)
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
    lmp, wall = lammps(), WALL.format(modulus=3.5e10, poisson=0.33)
    wall += f" friction 0.092 tangential {tangential} loss dashpot {damping:.17g}"
    started(lmp, [(0, 0, 0.00255)], "hertz 7e10 0.33", 0.0025, 2700.0, [(2.5069, 0, -2.9876)], 1e-8, wall)
    assert after(lmp, steps, "v")[[0, 2]] == pytest.approx(velocity, rel=2e-4)
    assert lmp.numpy.extract_atom("omega")[0, 1] == pytest.approx(spin, rel=3e-3)
