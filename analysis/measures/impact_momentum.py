"""Momentum of an impact, which the bottom of a packing takes up.

Momentum balance along z, with the impulse J on the bottom above the static force:

    momentum of the grains = P - J

Grains cannot remain in the bottom: J ends at P (1 + e'), where e' >= 0 describes the rebound of the
grains. As long as J is smaller than P, at least P - J has yet to reach the bottom.
"""

from __future__ import annotations

import math

from granwave.lammps_inputs.case.precompression import Gravity
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.motion import velocities_of

_DOWN = 2  # axis z of a velocity
_AXIS = "z"


def impact_momentum(assembly: Assembly) -> float | None:
    """Return the momentum of an impact towards the bottom, kg m/s; None if other bodies than the
    bottom can take it up or add to it, and if nothing moves downwards at the start.
    """
    if _has_other_forces(assembly):
        return None
    velocities = velocities_of(assembly)
    momentum = math.fsum(
        assembly.mass_of(sphere) * velocity[_DOWN] for sphere, velocity in velocities.items()
    )
    return momentum if momentum > 0 else None


def _has_other_forces(assembly: Assembly) -> bool:
    """Return True if a load, held grains, walls, bars or a sponge layer change the momentum along
    z. Gravity does not, since the static force on the bottom balances it.
    """
    case = assembly.case
    static = case.precompression
    is_loaded = static is not None and static.kind != Gravity.name
    is_held = any(_AXIS in hold.axes for hold in case.held.values())
    has_rough_sides = case.boundary.sides_rule.has_planes and case.has_friction
    return bool(
        case.load.driven
        or case.load.plate is not None
        or is_loaded
        or is_held
        or has_rough_sides
        or case.wall
        or case.absorb
        or case.incident_bar
    )
