"""Free spheres with a load on them, and the balance of its work."""

from __future__ import annotations

import numpy as np

from tests.conftest import script_of
from tests.helpers.two_spheres import BOX, R, value

MASS = 8500 * 4 / 3 * np.pi * R**3
REPORT = "\nthermo_style custom step c_ke pe c_ep[1] f_push f_push[1] f_push[2] f_push[3]\n"
T, A = 1.0007e-5, 100.0  # 1000.7 timesteps
PAIR = [(0, 0, 0), (0, 0, 2 * R)]
DRIVEN = "group driven id 1\ngroup rest id 2\nunfix motion\nfix motion rest nve\n"


def table(path, times, values):
    path.write_text(
        "# time force\n\n" + "".join(f"{t:.17g} {v:.17g}  # a row\n" for t, v in zip(times, values, strict=True))
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
