"""Closed forms of a single elastic sphere that hits a target: displacement of a plate, energy into an impedance."""

from __future__ import annotations

import math

from granwave.analysis.measures.target.hertz_impact import HertzImpact, after_impulse
from granwave.analysis.measures.target.record import period_of
from granwave.lammps_inputs.case.boundary import Boundary, Plate

_SHORT = 20.0  # periods in contact times from which on an impact is short
_SLOW = 0.2  # and up to which it is slow
_SLIGHT = 0.005  # of the sphere's momentum over that of a target in the same time: it hardly gives way


def plate_displacement(impact: HertzImpact, plate: Plate) -> tuple[float, str] | None:
    """Largest displacement of an undamped plate, m, and the theory that it is from; None between the two limits."""
    period = period_of(plate)
    if plate.damping:
        return None
    if period > _SHORT * impact.duration:
        impulse = impact.impulse * plate.mass / (plate.mass + impact.mass)
        return after_impulse(impulse, plate.mass, plate.stiffness), "impulse 2 v m M/(m + M), then J/(M omega)"
    if period < _SLOW * impact.duration:
        return impact.on_spring(plate.stiffness) / plate.stiffness, "a spring without mass: F/k"
    return None


def energy_into_impedance(impact: HertzImpact, boundary: Boundary) -> tuple[float, str] | None:
    """Energy that a bar without an echo, or a half-space, takes, J, and the theory that it is from.

    The force is that on a rigid wall as long as the target hardly gives way; None where it does, and of other targets.
    """
    support, material = boundary.bottom_support, boundary.bottom_material
    if support is None or material is None:
        return None
    if support.half_space and (radius := support.half_space.radius) is not None:
        spring, damping = support.half_space.stiffness(material, radius), support.half_space.damping(material, radius)
    elif support.bar and support.bar.end == "infinite":
        spring, damping = 0.0, support.bar.area * math.sqrt(material.youngs_modulus * material.density)
    else:
        return None
    if impact.mass > _SLIGHT * (damping + spring * impact.duration) * impact.duration:
        return None
    how = "spring and damper under Hertz's force" if spring else "Hertz's force, squared and summed over Z"
    return impact.energy_into(spring, damping), how
