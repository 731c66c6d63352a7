"""Lines of grains of a run: front speed, decay, distribution of the largest speeds; and its
sensors.

Decay of a peak along a line: a continuous, piecewise linear fit of its logarithm, and the position
where two lines diverge.

ln(peak) = c - a1 x up to the border b, and with the slope -a2 beyond it. For a given border the fit
is linear, so that only the border is searched: over each interval between grains that has at least
two grains on either side.

A sensor reads the mean of the forces of its bead's two contacts in a chain, its acceleration
elsewhere: a transducer glued between the halves of a bead measures the force between them, which
for slow pulses is about that mean. At an end of the chain, with a single contact, it reads half of
the force of this contact.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from granwave.analysis.measures.signals import Array
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.packing.motion import left_out

Arrays = dict[str, Array]

_BESIDE = 0.5  # tolerance of a straight line, diameters
_FEWEST_VALUES = 3  # fewest values of a test of normality

_LEAST = 2  # points on each side of the interface
_TRIALS = 60  # interfaces tried in each interval before the best is refined
PARTED = 0.03  # fraction of the peak speed above which two crystals differ


@dataclasses.dataclass(frozen=True)
class Distribution:
    """Distribution of the largest speeds of the grains of a line.

    Attributes
    ----------
    mean, deviation
        Mean and standard deviation (over n - 1), m/s.
    skewness
        Skewness, corrected for the number of values.
    normal_p
        p-value of Shapiro and Wilk's test: small where they are not normally distributed.
    """

    mean: float
    deviation: float
    skewness: float
    normal_p: float


@dataclasses.dataclass(frozen=True, eq=False)
class LineRecord:
    """A line of grains of a run; arrays in the order of the line, NaN for grains without a first
    pulse.

    Attributes
    ----------
    name
        Name of the line.
    distance
        From the first grain, m.
    arrival, peak_time, width
        s.
    peak_speed, largest_speed
        m/s.
    lateral_force
        N.
    left_out
        Grains at the end that are excluded from the fit of the decay.
    straight
        True for a straight line; other sets of grains have no front speed and no decay.
    """

    name: str
    distance: Array
    arrival: Array
    peak_time: Array
    width: Array
    peak_speed: Array
    largest_speed: Array
    lateral_force: Array
    left_out: int
    straight: bool = True

    @property
    def fitted(self) -> slice:
        """Grains in the fit of the decay."""
        return slice(0, max(len(self.distance) - self.left_out, 0))

    @property
    def front_speed(self) -> float | None:
        """Slope of distance against arrival, m/s; None for fewer than two arrivals."""
        known = np.isfinite(self.arrival)
        if not self.straight or known.sum() < 2 or np.ptp(self.arrival[known]) == 0:
            return None
        return float(np.polyfit(self.arrival[known], self.distance[known], 1)[0])

    @property
    def decay(self) -> TwoRegionDecay | None:
        """Decay of the peak speed in two regions; None for too few grains."""
        if not self.straight:
            return None
        return fit_decay(self.distance[self.fitted], self.peak_speed[self.fitted])

    @property
    def distribution(self) -> Distribution | None:
        """Distribution of the largest speeds; None for too few or equal values."""
        values = self.largest_speed
        if len(values) < _FEWEST_VALUES or np.ptp(values) <= 1e-9 * float(
            np.max(values, initial=0.0)
        ):
            return None
        from scipy.stats import shapiro, skew  # imported on demand: slow to load

        return Distribution(
            float(values.mean()),
            float(values.std(ddof=1)),
            float(skew(values, bias=False)),
            float(shapiro(values).pvalue),
        )


def lines_of(result: Result) -> list[LineRecord]:
    """Return the lines of grains of a run, ``[[line]]`` of its case, in their order.

    Parameters
    ----------
    result
        ``run.result`` of a run as `granwave.load` gives it.
    """
    found = []
    for line in result.case.line:
        group = f"lines/{line.name}"
        columns = {
            field.name: result[f"{group}/{field.name}"]
            for field in dataclasses.fields(LineRecord)[1:-2]
        }
        straight = _straight(result[f"{group}/position"], result.case.packing.diameter)
        found.append(
            LineRecord(
                name=line.name,
                left_out=left_out(result.assembly, line),
                straight=straight,
                **columns,
            )
        )
    return found


def _straight(position: Array, diameter: float) -> bool:
    """Return True if the grains follow each other within half a diameter of a straight line."""
    way = position[-1] - position[0]
    length = float(np.linalg.norm(way))
    if not length:
        return False
    along = (position - position[0]) @ way / length
    beside = np.linalg.norm(position - position[0] - along[:, None] * way / length, axis=1)
    return bool(beside.max() <= _BESIDE * diameter and np.all(np.diff(along) > 0))


def line_summary(result: Result) -> dict[str, Any]:
    """Return the part of the summary that is about lines of grains."""
    found: dict[str, Any] = {}
    for line in lines_of(result):
        decay = line.decay
        spread = line.distribution
        peaks = line.peak_speed[np.isfinite(line.peak_speed)]
        values = {
            "front_speed_m_s": line.front_speed,
            "peak_first_m_s": float(peaks[0]) if len(peaks) and line.straight else None,
            "peak_last_m_s": float(peaks[-1]) if len(peaks) and line.straight else None,
            "decay_first_per_m": decay and decay.first,
            "decay_second_per_m": decay and decay.second,
            "decay_border_m": decay and decay.border,
            "decay_per_m": decay and decay.single,
            "largest_speed_mean_m_s": spread and spread.mean,
            "largest_speed_deviation_m_s": spread and spread.deviation,
            "largest_speed_skewness": spread and spread.skewness,
            "largest_speed_normal_p": spread and spread.normal_p,
        }
        found |= {f"line_{line.name}_{name}": value for name, value in values.items()}
    return found


@dataclasses.dataclass(frozen=True)
class TwoRegionDecay:
    """Decay in two regions.

    Attributes
    ----------
    first, second
        Rates of the decay before and beyond the border, 1/m.
    border
        Where the second begins, m.
    single
        Rate of a single straight line through all points, 1/m.
    points
        Number of points.
    """

    first: float
    second: float
    border: float
    single: float
    points: int


def fit_decay(distance: ArrayLike, peak: ArrayLike) -> TwoRegionDecay | None:
    """Fit the broken line to peaks at distances (m); None for fewer than four.

    Parameters
    ----------
    distance, peak
        (n,); points without a known positive peak do not count.
    """
    distance = np.asarray(distance, dtype=np.float64)
    peak = np.asarray(peak, dtype=np.float64)
    known = np.isfinite(peak) & (peak > 0)
    x = distance[known]
    y = np.log(peak[known])
    if len(x) < 2 * _LEAST:
        return None

    def misfit(border: float) -> float:
        columns = _broken_line(x, border)
        difference = columns @ _least_squares(columns, y) - y
        return float(np.sum(difference**2))

    candidates = _possible_borders(x)
    border = min(candidates.tolist(), key=misfit)
    if len(candidates) > 1:
        refined = _refined(border, candidates, misfit)
        if misfit(refined) < misfit(border):
            border = refined
    _, slope, bend = _least_squares(_broken_line(x, border), y)
    single = float(np.polyfit(x, y, 1)[0])
    return TwoRegionDecay(-float(slope), -float(slope + bend), border, -single, len(x))


def _broken_line(x: Array, border: float) -> Array:
    """Return the functions whose sum is a line that bends at a border: (n, 3)."""
    beyond = np.maximum(x - border, 0.0)
    return np.stack([np.ones_like(x), x, beyond], axis=1)


def _least_squares(columns: Array, y: Array) -> Array:
    """Return the coefficients of columns whose sum fits y best."""
    coefficients, *_ = np.linalg.lstsq(columns, y, rcond=None)
    return np.asarray(coefficients)


def _possible_borders(x: Array) -> Array:
    """Return borders to try, which leave enough points on each side."""
    low = x[_LEAST - 1]
    high = x[-_LEAST]
    if low == high:
        return np.array([low])
    inside = x[(x >= low) & (x <= high)]
    intervals = [np.linspace(start, end, _TRIALS) for start, end in pairwise(inside)]
    return np.unique(np.concatenate(intervals))


def _refined(border: float, candidates: Array, misfit: Callable[[float], float]) -> float:
    """Return the border of least misfit between the neighbours of a candidate."""
    from scipy.optimize import minimize_scalar  # imported on demand: slow to load

    at = int(np.searchsorted(candidates, border))
    lower = candidates[max(at - 1, 0)]
    upper = candidates[min(at + 1, len(candidates) - 1)]
    found = minimize_scalar(misfit, bounds=(lower, upper), method="bounded")
    return float(found.x)


def parted_at(
    distance: ArrayLike, peak: ArrayLike, wide: ArrayLike, share: float = PARTED
) -> float | None:
    """Return the distance of the first grain with a peak that differs by a fraction from its peak
    in a wider crystal, m; None if there is no such grain.

    Parameters
    ----------
    distance, peak, wide
        Distances, m, and peaks of the corresponding grains in both crystals, m/s: (n,); grains
        without a peak do not count.
    """
    distance = np.asarray(distance, dtype=np.float64)
    peak = np.asarray(peak, dtype=np.float64)
    wide = np.asarray(wide, dtype=np.float64)
    known = np.isfinite(peak) & np.isfinite(wide) & (wide > 0)
    apart = np.flatnonzero(known & (np.abs(peak / np.where(known, wide, 1.0) - 1) > share))
    return float(distance[apart[0]]) if len(apart) else None


def sensor_forces(result: Result) -> Arrays:
    """Force of every sensor of a run at the instants of ``/chain/time``, by its name: (n_times,),
    N.
    """
    ends = result["chain/contact_i"], result["chain/contact_j"]
    force = result["chain/contact_force"]
    return {
        sensor.name: 0.5 * force[:, (ends[0] == sensor.id) | (ends[1] == sensor.id)].sum(axis=1)
        for sensor in result.case.sensor
    }


def sensor_accelerations(result: Result) -> Arrays:
    """Acceleration of every sensor of a packing, by its name: (n_times, 3), m/s^2.

    Parameters
    ----------
    result
        Of a run, ``run.result``, whose ``["probes/time"]`` are the instants.
    """
    found = _probed(result, "f")
    for sensor in [sensor for sensor in result.case.sensor if sensor.name in found]:
        row = int(result.rows(sensor.id))
        found[sensor.name] = (
            found[sensor.name] / result.read("spheres/mass", slice(row, row + 1))[0]
        )
    return found


def sensor_velocities(result: Result) -> Arrays:
    """Velocity of every sensor of a packing, by its name: (n_times, 3), m/s.

    Parameters
    ----------
    result
        Of a run, ``run.result``, whose ``["probes/time"]`` are the instants.
    """
    return _probed(result, "v")


def _probed(result: Result, quantity: str) -> Arrays:
    return {
        sensor.name: np.stack(
            [result[f"probes/sphere_{sensor.id}_{quantity}{axis}"] for axis in "xyz"], axis=1
        )
        for sensor in result.case.sensor
        if f"probes/sphere_{sensor.id}_{quantity}x" in result
    }
