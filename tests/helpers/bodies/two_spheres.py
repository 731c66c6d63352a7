"""Two touching spheres and their LAMMPS output; free spheres under a load, and its energy
balance.
"""

from __future__ import annotations

import numpy as np

from granwave._contact_laws import ContactLaw
from tests.conftest import script_of

R = 0.005
PAIR = [(0, 0, 0), (0, 0, 2 * R)]
BOX = [-0.1, 0.1] * 3
WALL = "fix floor all wall/gran/hysteretic zplane NULL {z:.17g} elastoplastic 115e9 0.3 550e6"
LAW = ContactLaw(
    youngs_modulus=(115e9, 115e9),
    poisson_ratio=(0.3, 0.3),
    yield_strength=(550e6, 550e6),
    radius=(R, R),
)


def value(lmp, formula: str) -> float:
    """Present value of an equal-style variable."""
    lmp.command(f"variable value_now equal {formula}")
    return lmp.extract_variable("value_now")


def collide(lmp, speed=2.0, steps=20000, **options):
    """Two touching spheres, one moving towards the other; run until they have separated."""
    lmp.commands_string(
        script_of(PAIR, velocities=[(0, 0, speed / 2), (0, 0, -speed / 2)], **options)
    )
    lmp.command(f"run {steps}")


def restitution(lmp, speed=2.0) -> float:
    """Coefficient of restitution of the collision of the two spheres."""
    return (value(lmp, "vz[2]") - value(lmp, "vz[1]")) / speed


MASS = 8500 * 4 / 3 * np.pi * R**3
REPORT = "\nthermo_style custom step c_ke pe c_ep[1] f_push f_push[1] f_push[2] f_push[3]\n"
# 1000.7 timesteps
T = 1.0007e-5
A = 100.0
DRIVEN = "group driven id 1\ngroup rest id 2\nunfix motion\nfix motion rest nve\n"


def table(path, times, values):
    path.write_text(
        "# time force\n\n"
        + "".join(f"{t:.17g} {v:.17g}  # a row\n" for t, v in zip(times, values, strict=True))
    )
    return path


def pushed(lmp, load, positions=((0, 0, 0),), extra="", **options):
    """Free spheres with a load on all of them, or on the group in `load`."""
    group, _, rest = load.rpartition("|")
    fix = f"{extra}\nfix push {group or 'all'} gran/load z {rest}{REPORT}"
    lmp.commands_string(script_of(list(positions), box=BOX, extra=fix, **options))
    return lmp


def balance(lmp) -> float:
    """Ratio of kinetic, stored and dissipated energy to the work."""
    return value(lmp, "(c_ke+pe+c_ep[1])/f_push")
