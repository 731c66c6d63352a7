"""Blocks of time after which a run with ``run.end_time = "auto"`` may end.

A run ends after the first block that adds less than `BLOCK_THRESHOLD` of the energy input to
dissipation. A block is 50 µs long, or the smallest multiple that contains a collision of the
impacted sphere: in a shorter block of a slow collision nothing has yielded yet.
"""

from __future__ import annotations

import math

from granwave.lammps_inputs.case.run import AUTO_END_TIME
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.planning.encounters import some_encounters

BLOCK_TIME = 50e-6  # s, the shortest block
BLOCK_THRESHOLD = 1e-4  # dissipation of a block / input energy, below which it is the last


def block_time(assembly: Assembly) -> float:
    """Return the length of the blocks of a run, s."""
    n = math.ceil(collision_time(assembly) / BLOCK_TIME)
    return min(AUTO_END_TIME, BLOCK_TIME * max(1, n))


def collision_time(assembly: Assembly) -> float:
    """Return the duration of the collision that takes up the most energy, s; 0 if there is none.

    The duration is bounded by the elastic one; plastic deformation shortens it.
    """
    try:
        found = some_encounters(assembly)
    except (ArithmeticError, ValueError):  # the timestep names it
        return 0.0
    most = max(one.energy for one in found)
    return max(one.duration for one in found if one.energy == most)
