"""Two touching spheres and their LAMMPS output, for tests of the pair style and of code that uses it."""

from __future__ import annotations

from granwave._contact_laws import ContactLaw
from tests.conftest import script_of

R = 0.005
PAIR = [(0, 0, 0), (0, 0, 2 * R)]
BOX = [-0.1, 0.1] * 3
WALL = "fix floor all wall/gran/hysteretic zplane NULL {z:.17g} elastoplastic 115e9 0.3 550e6"
LAW = ContactLaw(youngs_modulus=(115e9, 115e9), poisson_ratio=(0.3, 0.3), yield_strength=(550e6, 550e6), radius=(R, R))


def value(lmp, formula: str) -> float:
    """Present value of an equal-style variable."""
    lmp.command(f"variable value_now equal {formula}")
    return lmp.extract_variable("value_now")


def collide(lmp, speed=2.0, steps=20000, **options):
    """Two touching spheres, one moving towards the other; run until they have separated."""
    lmp.commands_string(script_of(PAIR, velocities=[(0, 0, speed / 2), (0, 0, -speed / 2)], **options))
    lmp.command(f"run {steps}")


def restitution(lmp, speed=2.0) -> float:
    """Coefficient of restitution of that collision."""
    return (value(lmp, "vz[2]") - value(lmp, "vz[1]")) / speed
