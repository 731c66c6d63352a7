"""Shock spectrum of a force: how far a plate on a spring moves under it, against the plate's period.

A plate much slower than the force only feels its impulse and moves by J/(M omega); one much faster follows it and
moves by F/k. In between it is an oscillator under the force on a wall that is held in place.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from granwave.analysis.measures.signals import Array, width
from granwave.analysis.measures.target.hertz_impact import after_impulse, largest_displacement
from granwave.analysis.measures.target.record import Reached, period_of
from granwave.lammps_inputs.case.boundary import Plate

_FAST, _SLOW = 0.25, 10.0  # periods at which the limits hold, over the peak's width and the time the impulse takes
_MOST_OF_IT = 0.9  # of the impulse: the time that it takes is that of this part, from its middle


@dataclasses.dataclass(frozen=True, eq=False)
class Curves:
    """Largest displacement of plates of one mass: by the oscillator and in its limits, m; all (n_periods,)."""

    period: Array
    oscillator: Array
    slow_force: Array
    short_impulse: Array


def oscillator(held: Reached, plate: Plate, end: float) -> float:
    """Largest displacement of a plate under the force on a wall, up to a time (s): m."""
    return largest_displacement(plate, held.time, held.force, end)


def expected_displacement(held: Reached, plate: Plate, end: float) -> tuple[float, str]:
    """Largest displacement of a plate that does not give way, m, and the theory that it is from.

    Parameters
    ----------
    held
        Record of the same packing on a wall.
    end
        Of the record of the plate, s.
    """
    period = period_of(plate)
    if period < _FAST * width(held.time, held.force):
        return held.peak_force / plate.stiffness, "slow force, F/k"
    part = np.array([1 - _MOST_OF_IT, 1 + _MOST_OF_IT]) / 2 * held.impulse[-1]
    lasts = float(np.diff(np.interp(part, held.impulse, held.time))[0])
    if period > _SLOW * lasts and not plate.damping:
        return after_impulse(float(held.impulse[-1]), plate.mass, plate.stiffness), "short impulse, J/(M omega)"
    return oscillator(held, plate, max(end, held.time[-1])), "oscillator"


def spectrum_curves(held: Reached, plate: Plate, period: Array) -> Curves:
    """Curves of plates like one but for the spring, at the periods (n_periods,), s."""
    springs = plate.mass * (2 * math.pi / period) ** 2
    plates = (dataclasses.replace(plate, stiffness=spring) for spring in springs)
    ends = held.time[-1] + period
    moved = np.array([oscillator(held, other, end) for other, end in zip(plates, ends, strict=True)])
    short = after_impulse(float(held.impulse[-1]), plate.mass, 1.0) / np.sqrt(springs)
    return Curves(period, moved, held.peak_force / springs, short)
