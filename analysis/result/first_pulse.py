"""First pulse at a point, from its speed in time: arrival, peak and width.

The pulse arrives when the speed first exceeds 5 % of a reference speed. Its peak is the first maximum above that after
which the speed falls by 10 %; smaller ripples on the way up are no peaks. Its width is that between the half heights.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

ARRIVAL = 0.05  # of the reference speed
FALL = 0.10  # of the peak


@dataclasses.dataclass(frozen=True, eq=False)
class FirstPulses:
    """First pulses at several points; every array (n,), NaN where there is none.

    Attributes
    ----------
    arrival
        Time of arrival, s.
    peak
        Peak speed, m/s.
    time
        Time of the peak, s.
    width
        Time between the half heights about the peak, s; NaN also if the record ends before.
    row
        Row of the peak in the record; -1: none.
    """

    arrival: NDArray[np.float64]
    peak: NDArray[np.float64]
    time: NDArray[np.float64]
    width: NDArray[np.float64]
    row: NDArray[np.int64]


def first_pulses(time: NDArray[np.float64], speed: NDArray[np.float64], reference: float) -> FirstPulses:
    """Find the first pulse at each point.

    Parameters
    ----------
    time
        (n_times,), s.
    speed
        Magnitudes: (n_times, n), m/s.
    reference
        Speed that the threshold of arrival refers to, m/s.
    """
    rows = [_pulse(time, one, ARRIVAL * reference) for one in speed.T]
    table = np.array([values for values, _ in rows]).reshape(-1, 4).T
    arrival, peak, instant, width = table
    return FirstPulses(arrival, peak, instant, width, np.array([row for _, row in rows], dtype=np.int64))


def _pulse(time: NDArray[np.float64], speed: NDArray[np.float64], least: float) -> tuple[tuple[float, ...], int]:
    above = np.flatnonzero(speed > least)
    if not above.size:
        return (np.nan,) * 4, -1
    first = int(above[0])
    arrival = float(time[0]) if first == 0 else _crossing(time, speed, first, least)
    highest = np.maximum.accumulate(speed[first:])
    fallen = np.flatnonzero(speed[first:] <= (1 - FALL) * highest)
    if not fallen.size:
        return (arrival, np.nan, np.nan, np.nan), -1
    row = first + int(np.argmax(speed[first : first + int(fallen[0]) + 1]))
    half = float(speed[row]) / 2
    before = np.flatnonzero(speed[:row] <= half)
    after = np.flatnonzero(speed[row:] <= half)
    width = np.nan
    if after.size:
        start = _crossing(time, speed, int(before[-1]) + 1, half) if before.size else float(time[0])
        width = _crossing(time, speed, row + int(after[0]), half) - start
    return (arrival, float(speed[row]), float(time[row]), width), row


def _crossing(time: NDArray[np.float64], speed: NDArray[np.float64], row: int, level: float) -> float:
    """Return the time between two rows of the record at which a speed passes a level, by a straight line."""
    low, high = float(speed[row - 1]), float(speed[row])
    return float(time[row - 1] + (level - low) / (high - low) * (time[row] - time[row - 1]))
