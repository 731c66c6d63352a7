"""Sentences and notes on the differences of runs from a measured curve."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from granwave.analysis.document.model import named
from granwave.analysis.formatting.numbers import quantity_in
from granwave.analysis.reports.comparison.curves import SampledCurve
from granwave.analysis.reports.comparison.deviations import (
    DOUBTFUL_UNIT,
    FEW_COMMON,
    FEWEST_COMMON,
    NEAR_END,
    NEGLIGIBLE,
    OPPOSITE,
    RESEMBLES,
    ROUNDING,
    STILL_RISES,
    UNLIKE,
    Deviation,
    has_other_size,
    largest_magnitude,
    ranked,
    unranked_reasons,
)
from granwave.analysis.reports.comparison.measured_curve import MeasuredCurve
from granwave.analysis.reports.sentences import share

_TIE = 1e-3  # relative difference of rms values below which runs are equally close
_TIMES = 10.0  # ratio above which a difference is given as a factor
_MOST_LISTED = 4  # runs that a sentence lists


def closest_sentence(
    measured: MeasuredCurve,
    deviations: Mapping[str, Deviation],
    units: tuple[str, str],
    *,
    alone: bool,
) -> str:
    """Return a sentence on the run that is closest to a measured curve.

    Parameters
    ----------
    deviations
        By the names of the runs that have a common range with the curve.
    units
        SI units of the curve.
    alone
        True if there is only one run.
    """
    if not deviations:
        return f"No run has a common range with {measured.source}."
    if alone:
        (name,) = deviations
        return _sentence_on_one_run(measured, name, deviations[name], units)
    names = ranked(deviations)
    if set(unranked_reasons(deviations).values()) == {UNLIKE} and not names:
        return _sentence_on_unlike_runs(measured, deviations, units)
    if not names:
        return f"No run is ranked by its difference from {measured.source}: {_reasons(deviations)}."
    least = min(deviations[name].rms for name in names)
    closest_names = [name for name in names if deviations[name].rms <= least * (1 + _TIE)]
    name = closest_names[0]
    closest = deviations[name]
    rms = _rms_in_words(measured, closest, units)
    if len(closest_names) > 1:
        return (
            f"Equally close to {measured.source}: {named(closest_names, _MOST_LISTED)}, with {rms}."
        )
    peaks = _peaks_in_words(measured, closest, units)
    if len(names) < len(deviations) and len(names) == 1:
        return f"Only {name} is compared with {measured.source}, with a difference of {rms}{peaks}."
    return f"Closest to {measured.source} is {name}, with a difference of {rms}{peaks}."


def _sentence_on_unlike_runs(
    measured: MeasuredCurve, deviations: Mapping[str, Deviation], units: tuple[str, str]
) -> str:
    """Return a sentence on runs of which none resembles a measured curve, with the smallest
    difference.
    """
    name = min(deviations, key=lambda each: deviations[each].rms)
    rms = _rms_in_words(measured, deviations[name], units)
    peaks = _peaks_in_words(measured, deviations[name], units)
    return (
        f"No run resembles {measured.source}: the smallest difference, of {name}, is {rms}{peaks}."
    )


def _sentence_on_one_run(
    measured: MeasuredCurve, name: str, difference: Deviation, units: tuple[str, str]
) -> str:
    """Return a sentence on the difference of a single run from a measured curve, or on the reason
    for which they are not compared: a doubtful unit, the opposite sign, or too few points.
    """
    if difference.has_doubtful_unit:
        return f"{name} is not compared with {measured.source}: {DOUBTFUL_UNIT}."
    if difference.is_reversed:
        return f"{name} is not compared with {measured.source}: {OPPOSITE}."
    if difference.n_points < FEWEST_COMMON:
        return f"{name} is not compared with {measured.source}: {FEW_COMMON}."
    rms = _rms_in_words(measured, difference, units)
    peaks = _peaks_in_words(measured, difference, units)
    if difference.relative_rms > RESEMBLES:
        return f"{name} does not resemble {measured.source}: the difference is {rms}{peaks}."
    return f"{name} differs from {measured.source} by {rms}{peaks}."


def _reasons(deviations: Mapping[str, Deviation]) -> str:
    """Return the reasons for which runs are not ranked, in words, with the runs of each."""
    names: dict[str, list[str]] = {}
    for name, reason in unranked_reasons(deviations).items():
        names.setdefault(reason, []).append(name)
    return "; ".join(f"{reason} ({named(runs, _MOST_LISTED)})" for reason, runs in names.items())


def _rms_in_words(measured: MeasuredCurve, closest: Deviation, units: tuple[str, str]) -> str:
    """Return the root mean square difference of a run in words."""
    size = relative_text(closest.relative_rms)
    largest = "measured peak" if measured.has_peak else "largest measured value"
    rms = f"{quantity_in(closest.rms, units[1])} rms, {size} the {largest}"
    if closest.relative_rms < ROUNDING:
        rms = "rounding only"
    if closest.n_points < len(measured.x):
        rms += f", at {closest.n_points} of {len(measured.x)} measured points"
    return rms


def _peaks_in_words(measured: MeasuredCurve, closest: Deviation, units: tuple[str, str]) -> str:
    """Return a clause on the peaks of a run and of a measured curve; empty without peaks."""
    if not measured.has_peak:
        return ""
    x_unit, y_unit = units
    own = f"{quantity_in(closest.peak, y_unit)} at {quantity_in(closest.peak_at, x_unit)}"
    other = f"{quantity_in(measured.peak, y_unit)} at {quantity_in(measured.peak_at, x_unit)}"
    if not closest.covers_peak:
        return f"; the run does not cover the measured peak, {other}"
    if closest.rises_at_end:
        return f"; the curve of the run still rises at its end, {own}; the measured peak is {other}"
    if abs(closest.peak) < NEGLIGIBLE * abs(measured.peak):
        return f"; it is zero in the measured range, the measured peak is {other}"
    return f"; its peak in the measured range is {own}, the measured peak {other}"


def coverage_notes(measured: MeasuredCurve, deviations: Mapping[str, Deviation]) -> list[str]:
    """Return sentences on runs that are not ranked, since they cover fewer points of a measured
    curve or still rise at their end, and on a curve of the opposite sign; empty if none applies.

    Parameters
    ----------
    deviations
        As of `closest_sentence`.
    """
    notes: list[str] = []
    reasons = unranked_reasons(deviations)
    if not ranked(deviations):
        reasons = {}  # the sentence has the reasons
    parts = [
        f"{name} ({deviations[name].n_points} of {len(measured.x)} points)"
        for name, reason in reasons.items()
        if reason not in (STILL_RISES, UNLIKE)
    ]
    unlike = [name for name, reason in reasons.items() if reason == UNLIKE]
    rising = [name for name, reason in reasons.items() if reason == STILL_RISES]
    if parts:
        notes.append(
            f"Not ranked by their difference from {measured.source}, of which they cover only a "
            f"part: {named(parts, _MOST_LISTED)}."
        )
    if rising:
        notes.append(
            f"Not ranked by their difference from {measured.source}, since their largest value is "
            f"at their end: {named(rising, _MOST_LISTED)}."
        )
    if unlike:
        notes.append(
            f"Not ranked by their difference from {measured.source}, since its root mean square "
            f"exceeds the measured peak: {named(unlike, _MOST_LISTED)}."
        )
    if measured.is_reversed:
        remedy = (
            "If the sensor has the opposite sign, multiply its values by -1: --scale -1, or "
            "scale=-1 in Python."
        )
        if measured.scale < 0.0:
            remedy = f"The scale {measured.scale:g} reverses them; use a positive scale."
        notes.append(
            f"The largest values of {measured.source} are negative, and no run is ranked. {remedy}"
        )
    return notes


def unit_notes(
    measured: MeasuredCurve, curves: Mapping[str, SampledCurve], units: tuple[str, str]
) -> list[str]:
    """Return sentences on a measured curve that is much longer, or has much larger values, than
    the curves of all runs, or the reverse, as with a wrong unit.

    Parameters
    ----------
    curves
        Curves of the runs, by their names.
    units
        SI units of the curve.
    """
    if not curves:
        return []
    x_unit, y_unit = units
    lasts = "lasts" if x_unit == "s" else "extends to"
    end = largest_magnitude(measured.x)
    ends = [largest_magnitude(curve.x) for curve in curves.values()]
    peak = abs(measured.peak)
    peaks = [largest_magnitude(curve.y) for curve in curves.values()]
    notes: list[str] = []
    if has_other_size(end, ends):
        own = quantity_in(end, x_unit)
        notes.append(
            f"{measured.source} {lasts} {own}, the runs {_range(ends, x_unit)}; check the unit."
        )
    if has_other_size(peak, peaks):
        own = quantity_in(peak, y_unit)
        notes.append(
            f"The largest value of {measured.source} is {own}, of the runs "
            f"{_range(peaks, y_unit)}; check the unit."
        )
    return notes


def _range(values: Sequence[float], unit: str) -> str:
    """Return a range of values with the unit; one value if all have the same text."""
    ends = [quantity_in(value, unit) for value in (min(values), max(values))]
    return " to ".join(dict.fromkeys(ends))


def range_notes(
    measured: MeasuredCurve, deviations: Mapping[str, Deviation], units: tuple[str, str]
) -> list[str]:
    """Return sentences on the ranges of a measured curve and of the runs, where they apply: on
    largest values of runs outside the measured range, and on measured points slightly beyond the
    ends of curves.

    Parameters
    ----------
    deviations, units
        As of `closest_sentence`.
    """
    x_unit = units[0]
    outside = [
        f"{name} at {quantity_in(difference.outside_at, x_unit)}"
        for name, difference in deviations.items()
        if difference.outside_at is not None
    ]
    near = [name for name, difference in deviations.items() if difference.n_near_end]
    notes: list[str] = []
    if outside:
        ends = [quantity_in(float(end), x_unit) for end in (measured.x[0], measured.x[-1])]
        notes.append(
            f"Largest values outside the range of {measured.source}, {' to '.join(ends)}: "
            f"{named(outside, _MOST_LISTED)}. Shift the measured curve if its zero differs."
        )
    if near:
        spacing = "layer spacing" if x_unit == "m" else "spacing of the points of a run"
        notes.append(
            f"Points of {measured.source} beyond an end of a curve, by up to {share(NEAR_END)} of "
            f"the {spacing}, are compared with the value at this end: {named(near, _MOST_LISTED)}."
        )
    return notes


def relative_text(ratio: float) -> str:
    """Return a ratio in words: ``12 % of``, or ``27.2 times`` if it is large."""
    return f"{share(ratio)} of" if ratio < _TIMES else f"{ratio:.3g} times"
