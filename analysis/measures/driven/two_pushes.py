"""A grain pushed once or twice by a table of forces: when, and the largest force of either pulse at a contact."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from granwave.analysis.measures.signals import Array, arrival

_ARRIVED = 0.2  # of the largest force
_SHARE = 0.75  # of the time between the pushes, after its arrival: what comes later is of the second pulse


def push_starts(table: Sequence[Sequence[float]] | None) -> list[float]:
    """Times at which the force of a table of rows [time, force] begins to rise from zero, s."""
    return [before[0] for before, after in pairwise(table or ()) if before[1] == 0 < after[1]]


def largest_of_pulses(time: Array, force: Array, apart: float) -> tuple[float, float]:
    """Largest force of the first and of the second pulse at a contact, N.

    Parameters
    ----------
    time, force
        Instants, s, and force, N: (n_times,).
    apart
        Time between the pushes, s.
    """
    split = arrival(time, force, _ARRIVED * float(force.max())) + _SHARE * apart
    return float(force[time < split].max(initial=0.0)), float(force[time >= split].max(initial=0.0))
