"""Differences of the curves of runs from a measured curve, and the order of the runs by them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from granwave.analysis.measures.signals import Array
from granwave.analysis.reports.comparison.curves import SampledCurve
from granwave.analysis.reports.comparison.measured_curve import LEAST_POINTS, MeasuredCurve

NEGLIGIBLE = 1e-4  # fraction of the measured peak below which a value counts as zero
_ENOUGH = 0.99  # fraction of the points of the run with the most points: runs that are ranked
FEWEST_COMMON = 3  # measured points within the curve of a run that is ranked
ROUNDING = 1e-12  # rms / measured peak below which only rounding differs
NEAR_END = 0.01  # of the spacing of a curve: distance up to which its end has the value there
_OTHER_UNIT = 100.0  # ratio of lengths or peaks above which the unit is doubtful
#: Reasons for which a run is not ranked.
DOUBTFUL_UNIT = "the unit of the curve is doubtful"
FEW_COMMON = f"fewer than {FEWEST_COMMON} common points"
OPPOSITE = "opposite sign"
_FEWER_POINTS = "fewer points than other runs"
_BEFORE_PEAK = "ends before the measured peak"
STILL_RISES = "still rises at its end"
UNLIKE = "rms difference above the measured peak"
RESEMBLES = 1.0  # rms difference / measured peak up to which a run resembles the curve


@dataclass(frozen=True)
class Deviation:
    """Difference of a run from a measured curve, where both have values.

    Attributes
    ----------
    rms
        Root mean square of the difference at the measured points, in the unit of the curve.
    relative_rms
        This root mean square / largest measured value.
    peak_difference
        Largest value of the run in the measured range / largest measured value, minus 1; NaN if
        the run does not cover the measured peak, still rises at its end, or if the measured curve
        is reversed or has no peak.
    n_points
        Number of measured points within the curve of the run.
    peak
        Largest value of the run in the measured range, interpolated at the measured points; NaN
        without a peak.
    peak_at
        Its time or length, s or m; NaN without a peak.
    outside_at
        Time or length of the largest value of the run, if it is outside the measured range; None:
        it lies inside.
    covers_peak
        True if the measured peak is within the curve of the run.
    rises_at_end
        True if the run ends within the measured range with its largest value, so that it may rise
        further.
    is_reversed
        True if the measured curve has the opposite sign.
    n_near_end
        Number of these points that lie slightly beyond an end of the curve of the run, and are
        compared with its value there.
    has_doubtful_unit
        True if the measured curve has values of another size than all runs, or is much shorter.
    """

    rms: float
    relative_rms: float
    peak_difference: float
    n_points: int
    peak: float
    peak_at: float
    outside_at: float | None = None
    covers_peak: bool = True
    rises_at_end: bool = False
    is_reversed: bool = False
    n_near_end: int = 0
    has_doubtful_unit: bool = False


def deviation(
    measured: MeasuredCurve, curve: SampledCurve, *, has_doubtful_unit: bool = False
) -> Deviation | None:
    """Return the difference of a run from a measured curve; None if they do not overlap.

    A measured point beyond an end of the curve, by up to 1 % of the median spacing of its points,
    is compared with the value at this end: measured depths are rounded. A point of the curve beyond
    an end of the measured range by as much lies in this range.

    Parameters
    ----------
    has_doubtful_unit
        As of `Deviation`.
    """
    near = _near_end(curve)
    low = max(float(curve.x.min()), float(measured.x[0])) - near
    high = min(float(curve.x.max()), float(measured.x[-1])) + near
    inside = (measured.x >= low) & (measured.x <= high)
    if not inside.any():
        return None
    difference = np.interp(measured.x[inside], curve.x, curve.y) - measured.y[inside]
    rms = float(np.sqrt(np.mean(difference**2)))
    size = float(np.abs(measured.y).max())
    beyond = (measured.x[inside] < curve.x.min()) | (measured.x[inside] > curve.x.max())
    simple = Deviation(
        rms,
        rms / size,
        np.nan,
        int(inside.sum()),
        peak=np.nan,
        peak_at=np.nan,
        is_reversed=measured.is_reversed,
        n_near_end=int(beyond.sum()),
        has_doubtful_unit=has_doubtful_unit,
    )
    return _with_peak(simple, measured, curve, low, high) if measured.has_peak else simple


def _with_peak(
    difference: Deviation, measured: MeasuredCurve, curve: SampledCurve, low: float, high: float
) -> Deviation:
    """Return a difference from a measured curve with the largest values of both in their common
    range, from ``low`` to ``high``.
    """
    own = _within(curve, measured.x, low, high)
    first = int(own.y.argmax())
    largest = float(own.y[first])
    place = int(curve.y.argmax())
    covers_peak = low <= measured.peak_at <= high
    rises_at_end = place == len(curve.y) - 1 and low < curve.x[-1] <= measured.x[-1]
    has_peaks = covers_peak and not rises_at_end and not measured.is_reversed
    is_outside = not low <= curve.x[place] <= high and curve.y[place] > largest
    size = float(np.abs(measured.y).max())
    return dataclasses.replace(
        difference,
        peak_difference=largest / size - 1 if has_peaks else np.nan,
        peak=largest,
        peak_at=float(own.x[first]),
        outside_at=float(curve.x[place]) if is_outside else None,
        covers_peak=bool(covers_peak),
        rises_at_end=bool(rises_at_end),
    )


def _near_end(curve: SampledCurve) -> float:
    """Return the distance beyond the ends of a curve within which its end has the value, s or m."""
    if len(curve.x) < LEAST_POINTS:
        return 0.0
    return NEAR_END * float(np.median(np.abs(np.diff(curve.x))))


def ranked(deviations: Mapping[str, Deviation]) -> list[str]:
    """Return the names of the runs whose differences from a measured curve can be ranked.

    Their differences are means over the same points, at least three: those of the run with the
    most points. A run is not ranked if it does not cover the measured peak, if it ends with its
    largest value, if its rms difference exceeds the measured peak, or if the measured curve has the
    opposite sign or a doubtful unit.
    """
    reasons = unranked_reasons(deviations)
    return [name for name in deviations if name not in reasons]


def unranked_reasons(deviations: Mapping[str, Deviation]) -> dict[str, str]:
    """Return the reasons for which runs are not ranked by their difference from a measured curve,
    by their names.
    """
    most = max((difference.n_points for difference in deviations.values()), default=0)
    reasons: dict[str, str] = {}
    for name, difference in deviations.items():
        if reason := _unranked_reason(difference, most):
            reasons[name] = reason
    return reasons


def _unranked_reason(difference: Deviation, most: int) -> str:
    """Return the reason for which a run is not ranked; empty if it is ranked.

    Parameters
    ----------
    most
        Number of points of the run with the most points.
    """
    if difference.has_doubtful_unit:
        return DOUBTFUL_UNIT
    if difference.is_reversed:
        return OPPOSITE
    if difference.n_points < _ENOUGH * most:
        return _FEWER_POINTS
    if difference.n_points < FEWEST_COMMON:
        return FEW_COMMON
    if not difference.covers_peak:
        return _BEFORE_PEAK
    if difference.rises_at_end:
        return STILL_RISES
    if difference.relative_rms > RESEMBLES:
        return UNLIKE
    return ""


def is_unit_doubtful(measured: MeasuredCurve, curves: Mapping[str, SampledCurve]) -> bool:
    """Return True if no run can be ranked by a measured curve, since its values have another size
    than those of all runs, or since it is much shorter than all runs.

    A record that is much longer than the runs is usual, and compared where they have values.

    Parameters
    ----------
    curves
        As of `unit_notes`.
    """
    if not curves:
        return False
    peaks = [largest_magnitude(curve.y) for curve in curves.values()]
    ends = [largest_magnitude(curve.x) for curve in curves.values()]
    end = largest_magnitude(measured.x)
    is_short = has_other_size(end, ends) and end < min(ends)
    return is_short or has_other_size(abs(measured.peak), peaks)


def largest_magnitude(values: Array) -> float:
    """Return the largest magnitude of some values."""
    return float(np.abs(values).max())


def has_other_size(value: float, others: Sequence[float]) -> bool:
    """Return True if a value is much larger or much smaller than all of some positive values."""
    low = min(others)
    high = max(others)
    if low <= 0.0 or value <= 0.0:
        return False
    return value > _OTHER_UNIT * high or value < low / _OTHER_UNIT


def _within(curve: SampledCurve, points: Array, low: float, high: float) -> SampledCurve:
    """Return the part of a curve in a range, with its interpolated values at further points."""
    places = np.concatenate([curve.x, points])
    places = np.unique(places[(places >= low) & (places <= high)])
    return SampledCurve(places, np.interp(places, curve.x, curve.y))
