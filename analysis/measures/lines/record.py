"""Lines of grains of a finished run: front speed, decay, and how the largest speeds are distributed."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.lines.decay import Decay, fit_decay
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.packing.motion import left_out

_BESIDE = 0.5  # diameters, of a straight line
_LEAST_VALUES = 3  # that a test of normality takes


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
    """A line of grains of a run; arrays in the order of the line, NaN where a grain has no first pulse.

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
        Grains at the end that the fit of the decay leaves out.
    straight
        True for a straight line; other sets of grains have no front speed and no decay.
    """

    name: str
    distance: NDArray[np.float64]
    arrival: NDArray[np.float64]
    peak_time: NDArray[np.float64]
    width: NDArray[np.float64]
    peak_speed: NDArray[np.float64]
    largest_speed: NDArray[np.float64]
    lateral_force: NDArray[np.float64]
    left_out: int
    straight: bool = True

    @property
    def fitted(self) -> slice:
        """Grains that the fit of the decay takes."""
        return slice(0, max(len(self.distance) - self.left_out, 0))

    @property
    def front_speed(self) -> float | None:
        """Slope of distance against arrival, m/s; None for fewer than two arrivals."""
        known = np.isfinite(self.arrival)
        if not self.straight or known.sum() < 2 or np.ptp(self.arrival[known]) == 0:
            return None
        return float(np.polyfit(self.arrival[known], self.distance[known], 1)[0])

    @property
    def decay(self) -> Decay | None:
        """Decay of the peak speed in two regions; None for too few grains."""
        if not self.straight:
            return None
        return fit_decay(self.distance[self.fitted], self.peak_speed[self.fitted])

    @property
    def distribution(self) -> Distribution | None:
        """Distribution of the largest speeds; None for too few or equal values."""
        values = self.largest_speed
        if len(values) < _LEAST_VALUES or np.ptp(values) <= 1e-9 * float(np.max(values, initial=0.0)):
            return None
        from scipy.stats import shapiro, skew  # take longer to load than most commands need

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
            for field in dataclasses.fields(LineRecord)
            if field.name not in ("name", "left_out", "straight")
        }
        straight = _straight(result[f"{group}/position"], result.case.packing.diameter)
        found.append(LineRecord(name=line.name, left_out=left_out(result.assembly, line), straight=straight, **columns))
    return found


def _straight(position: NDArray[np.float64], diameter: float) -> bool:
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
        decay, spread = line.decay, line.distribution
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
