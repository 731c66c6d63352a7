"""Speed, amplitude and length of the pulse along a line of spheres, from their velocities."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq, least_squares

from granwave.analysis.measures.signals import Array, first_peak, width
from granwave.analysis.result.reader import Result

LENGTH = math.pi * math.sqrt(10) / 2  # diameters, of the solitary wave in the long-wave approximation: 4.97
MEASURES = ("fit of acceleration", "fit of velocity", "half maximum of acceleration", "half maximum of velocity")
_FINE = 4  # points between two snapshots
_GONE = 1e-3  # of its peak: the incident wave has passed
_BACK = 0.8  # part of the wave's way to the far end and back that is waited for
_LARGEST = 3 * math.sqrt(3) / 16  # of cos^3 sin


@dataclasses.dataclass(frozen=True, eq=False)
class Peaks:
    """The pulse at the spheres of a chain, struck one first; every array (n_spheres,), NaN where it did not pass.

    Attributes
    ----------
    velocity
        Largest velocity, m/s.
    time
        Of it, s.
    speed
        Of the wave, from the peaks of the two neighbours, m/s.
    """

    velocity: Array
    time: Array
    speed: Array


def line_velocity(result: Result, ids: ArrayLike) -> Array:
    """Velocities along a straight line of spheres, away from the first of them: (n_frames, n_spheres), m/s.

    Parameters
    ----------
    result
        ``run.result`` of a run as `granwave.load` gives it.
    ids
        Of the spheres, in their order along the line.
    """
    rows = result.rows(np.asarray(ids))
    way = np.subtract(*result["spheres/position"][rows[[-1, 0]]])
    return np.stack([result.frame(k, "velocity")[rows] for k in range(result.n_frames)]) @ (way / np.linalg.norm(way))


def peaks(time: Array, velocity: Array, diameter: float) -> Peaks:
    """Times at which the pulse passes each sphere of a chain.

    Parameters
    ----------
    time
        (n_times,), s.
    velocity
        Along the chain: (n_times, n_spheres), m/s.
    """
    found = [first_peak(time, one, floor=0.5) for one in velocity.T]
    when, largest = (np.array([pair[k] for pair in found]) for k in (0, 1))
    largest[when >= time[-2]] = np.nan
    when[~np.isfinite(largest)] = np.nan
    speed = np.full(len(largest), np.nan)
    speed[1:-1] = 2 * diameter / (when[2:] - when[:-2])
    speed[speed <= 0] = np.nan
    return Peaks(largest, when, speed)


def lengths(time: Array, velocity: Array, diameter: float) -> dict[str, Array]:
    """Length of the pulse at each sphere: its duration by each of `MEASURES` times the speed; (n_spheres,), diameters.

    Parameters are those of `peaks`.
    """
    found = peaks(time, velocity, diameter)
    fine = np.linspace(time[0], time[-1], _FINE * (len(time) - 1) + 1)
    known = np.where(np.isfinite(found.speed), found.time, np.nan)
    durations = [_durations(fine, CubicSpline(time, one), t) for one, t in zip(velocity.T, known, strict=True)]
    return {name: np.array(durations)[:, k] * found.speed / diameter for k, name in enumerate(MEASURES)}


def _durations(time: Array, velocity: CubicSpline, centre: float) -> tuple[float, float, float, float]:
    """Duration of a pulse by the four measures, s."""
    if not np.isfinite(centre):
        return (np.nan,) * 4
    v, a = velocity(time), velocity(time, 1)
    k = int(np.searchsorted(time, centre))
    before = a[: k + 1]
    half_a, half_v = width(time[: k + 1], before), width(time, v)
    if not np.isfinite(half_v):
        return np.nan, np.nan, half_a, half_v
    near = np.abs(time - centre) < 2 * half_v  # the pulse alone, not what follows

    def fit(values: Array, shape: Callable[[Array], Array]) -> float:
        start = (centre, 2.75 * half_v)

        def misses(x: Array) -> Array:
            return shape(np.clip(math.pi * (time[near] - x[0]) / x[1], -math.pi / 2, math.pi / 2)) - values[near]

        found = least_squares(misses, start, x_scale=(half_v, half_v))
        return float(found.x[1])

    scaled_a = -a / np.abs(a[near]).max() * _LARGEST
    return (
        fit(scaled_a, lambda x: np.cos(x) ** 3 * np.sin(x)),
        fit(v / v[near].max(), lambda x: np.cos(x) ** 4),
        half_a,
        half_v,
    )


def speed_between(found: Peaks, first: int, second: int, diameter: float) -> tuple[float, float]:
    """Mean of the largest velocities at two spheres of a line, and speed of the wave between them, m/s.

    Parameters
    ----------
    found
        From `peaks`.
    first, second
        Places of the spheres along the line, from 1.
    diameter
        Distance between neighbours, m.

    Returns
    -------
    tuple
        (NaN, NaN) where the wave did not pass from the first to the second.
    """
    ends = [first - 1, second - 1]
    if second > len(found.time) or not np.diff(found.time[ends])[0] > 0:
        return np.nan, np.nan
    return float(found.velocity[ends].mean()), float((second - first) * diameter / np.diff(found.time[ends])[0])


@cache
def theory() -> dict[str, float]:
    """Lengths of Nesterenko's solitary wave by the four measures of a pulse's length, by name, in diameters."""
    half_v = 2 * math.acos(0.5**0.25) / math.pi * LENGTH
    ends = [
        brentq(lambda x: math.cos(x) ** 3 * math.sin(x) - _LARGEST / 2, *span)
        for span in ((0.0, math.pi / 6), (math.pi / 6, math.pi / 2))
    ]
    return dict(zip(MEASURES, (LENGTH, LENGTH, (ends[1] - ends[0]) / math.pi * LENGTH, half_v), strict=True))


def reflection(time: Array, force: Array, place: int, beyond: int) -> float:
    """Largest force of what comes back to a contact of a chain, over that of the incident wave.

    Until waves from the far end can arrive; NaN where the record ends sooner, or the contact is too near an end.

    Parameters
    ----------
    time, force
        (n_times,), s, and of the contacts, (n_times, n_contacts), N.
    place
        The contact, from 0.
    beyond
        Contacts that there must be beyond it.
    """
    n = force.shape[1]
    if place < 2 or place + beyond > n:
        return np.nan
    (here, peak), (early, _), (far, _) = (first_peak(time, force[:, k], floor=0.5) for k in (place, 1, n - 1))
    period = (here - early) / (place - 1)  # from contact to contact
    gone = np.flatnonzero((time > here) & (force[:, place] < _GONE * peak))
    until = far + _BACK * (n - place) * period
    if not len(gone) or time[-1] < until:
        return np.nan
    after = force[int(gone[0]) :, place][time[int(gone[0]) :] < until]
    return float(after.max(initial=0.0) / peak)
