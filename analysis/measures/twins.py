"""Scatter between two sensors at places that symmetry makes equal: arrival and height of the peak acceleration."""

from __future__ import annotations

import dataclasses

import numpy as np

from granwave.analysis.measures.sensors import sensor_accelerations
from granwave.analysis.measures.signals import Array, first_peak
from granwave.analysis.measures.waves.directions import directions
from granwave.analysis.result.reader import Result

_PEAK = 0.5  # of the largest acceleration along the chain: the first crest above it is the wave's
_SEEN = 0.1  # of the larger one of both: a lower peak is no wave


@dataclasses.dataclass(frozen=True)
class Difference:
    """Difference between twin sensors, first and second.

    Attributes
    ----------
    delay
        Time of the second's peak acceleration less that of the first's, s.
    excess
        Peak acceleration of the first over that of the second, less 1.
    arrival
        Mean time of both peaks, s.
    """

    delay: float
    excess: float
    arrival: float


def difference(result: Result, first: str, second: str) -> Difference | None:
    """Difference of two sensors by name; None if the wave has reached one of them alone, or neither."""
    found = sensor_accelerations(result)
    ways, time = directions(result), result["probes/time"]
    ids = {sensor.name: sensor.id for sensor in result.case.sensor}
    peaks = []
    for name in (first, second):
        (row,) = result.rows(np.array([ids[name]]))
        peaks.append(first_peak(time, _along(found[name], ways[row]), floor=_PEAK))
    (early, one), (late, other) = peaks
    if not np.isfinite([one, other]).all() or min(one, other) < _SEEN * max(one, other):
        return None
    if max(early, late) >= time[-2]:
        return None
    return Difference(late - early, one / other - 1, (early + late) / 2)


def _along(acceleration: Array, way: Array) -> Array:
    """Component of an acceleration (n_times, 3) along a direction (3,): (n_times,)."""
    return np.asarray(acceleration @ way)
