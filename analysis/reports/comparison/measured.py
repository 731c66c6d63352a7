"""Comparison of a measured curve with the curves of runs.

The curve is a table of text with a column of times or lengths and a column of forces or other
values, each with its unit in its name, ``time_us, force_kN`` or ``t (ms); F (N)``, or in the row
below the names, as in the files of oscilloscopes. It is shifted and scaled only on request.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np

from granwave.analysis.document.model import named
from granwave.analysis.formatting.numbers import quantity_in
from granwave.analysis.measures.signals import Array
from granwave.analysis.reports.comparison.curves import SampledCurve
from granwave.analysis.reports.sentences import share
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_user_text
from granwave.lammps_inputs.tables.encoding import decoded_table
from granwave.lammps_inputs.tables.layout import is_number
from granwave.lammps_inputs.tables.text_table import TextTable, read_text_table, table_of
from granwave.lammps_inputs.tables.units import LENGTH_UNITS, in_si, split_unit, unit_of

#: Units of the columns of a measured curve, by the SI unit: powers of ten.
UNITS: dict[str, dict[str, int]] = {
    "s": {"s": 0, "ms": -3, "us": -6, "ns": -9},
    "m": LENGTH_UNITS,
    "N": {"N": 0, "mN": -3, "kN": 3, "MN": 6},
    "1": {"1": 0, "": 0, "%": -2},
}
_JOINED = re.compile(r"(.+)_([a-zA-Zµμ]+)")  # ``time_us``
_SPELLINGS = {"µs": "us", "μs": "us"}
_LEAST_POINTS = 2
NEGLIGIBLE = 1e-4  # fraction of the measured peak below which a value counts as zero
_ENOUGH = 0.99  # fraction of the points of the run with the most points: runs that are ranked
_FEWEST_COMMON = 3  # measured points within the curve of a run that is ranked
ROUNDING = 1e-12  # rms / measured peak below which only rounding differs
_TIE = 1e-3  # relative difference of rms values below which runs are equally close
_NEAR_END = 0.01  # of the spacing of a curve: distance up to which its end has the value there
_OTHER_UNIT = 100.0  # ratio of lengths or peaks above which the unit is doubtful
#: Reasons for which a run is not ranked.
_DOUBTFUL_UNIT = "the unit of the curve is doubtful"
_FEW_COMMON = f"fewer than {_FEWEST_COMMON} common points"
_OPPOSITE = "opposite sign"
_FEWER_POINTS = "fewer points than other runs"
_BEFORE_PEAK = "ends before the measured peak"
_STILL_RISES = "still rises at its end"
_UNLIKE = "rms difference above the measured peak"
_RESEMBLES = 1.0  # rms difference / measured peak up to which a run resembles the curve
_TIMES = 10.0  # ratio above which a difference is given as a factor
_MOST_LISTED = 4  # runs that a sentence lists


@dataclass(frozen=True, eq=False)
class MeasuredCurve:
    """A measured curve, shifted and scaled as requested.

    Attributes
    ----------
    source
        Path of its file.
    columns
        Names of its two columns.
    x, y
        Rising times or lengths, and values: (n,) each, SI units.
    shift
        Shift added to ``x``, in its unit.
    scale
        Factor of ``y``.
    has_peak
        False for a curve that only rises, such as the arrivals of a front.
    """

    source: str
    columns: tuple[str, str]
    x: Array
    y: Array
    shift: float = 0.0
    scale: float = 1.0
    has_peak: bool = True

    @property
    def peak(self) -> float:
        """Largest value; the lowest value of a reversed curve."""
        return float(self.y[self._peak_row])

    @property
    def peak_at(self) -> float:
        """Time or length of this value, s or m."""
        return float(self.x[self._peak_row])

    @property
    def is_reversed(self) -> bool:
        """True if the value of the largest magnitude is negative, as of a sensor with the opposite
        sign.
        """
        return -float(self.y.min()) > float(self.y.max())

    @property
    def _peak_row(self) -> int:
        return int(np.abs(self.y).argmax() if self.is_reversed else self.y.argmax())


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


def read_measured(
    path: str | Path,
    units: tuple[str, str],
    *,
    shift: float = 0.0,
    scale: float = 1.0,
    has_peak: bool = True,
) -> MeasuredCurve:
    """Read a measured curve.

    Parameters
    ----------
    path
        Text table; the first column with each unit is used.
    units
        SI units of the compared quantities: of the axis, and of the values.
    shift
        Added to times or lengths, s or m.
    scale
        Factor of the values.
    has_peak
        As of `MeasuredCurve`.

    Raises
    ------
    InputError
        The file cannot be read, or lacks a column with such a unit.
    """
    source = str(path)
    text = read_user_text(Path(path), "table of a measured curve", decode=decoded_table)
    try:
        table = _with_units(read_text_table(text))
        numbers = _columns(table, units, source)
        x, y = (_values(table, column, power) for column, power in numbers)
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{source}: {error}") from None
    names = (table.heads[numbers[0][0]], table.heads[numbers[1][0]])
    if len(x) < _LEAST_POINTS:
        raise InputError(f"{source}: found {len(x)} row, expected at least {_LEAST_POINTS}")
    if not y.any():
        raise InputError(f"{source}: found only zeros for {names[1]}, expected measured values")
    if units[0] == "s":
        _check_order(x, names[0], source)
    order = np.argsort(x, kind="stable")
    return MeasuredCurve(
        source, names, x[order] + shift, scale * y[order], shift, scale, has_peak=has_peak
    )


def _check_order(times: Array, column: str, source: str) -> None:
    """Raise InputError for times that fall: rows in disorder, or another column than of times."""
    falls = np.flatnonzero(np.diff(times) < 0)
    if not falls.size:
        return
    row = int(falls[0])
    raise InputError(
        f"{source}: column {column}: found {quantity_in(times[row + 1], 's')} after "
        f"{quantity_in(times[row], 's')} (values {row + 1} and {row + 2}), expected rising times; "
        "sort the rows by time, or check which column holds the times"
    )


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
    if len(curve.x) < _LEAST_POINTS:
        return 0.0
    return _NEAR_END * float(np.median(np.abs(np.diff(curve.x))))


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
        return _DOUBTFUL_UNIT
    if difference.is_reversed:
        return _OPPOSITE
    if difference.n_points < _ENOUGH * most:
        return _FEWER_POINTS
    if difference.n_points < _FEWEST_COMMON:
        return _FEW_COMMON
    if not difference.covers_peak:
        return _BEFORE_PEAK
    if difference.rises_at_end:
        return _STILL_RISES
    if difference.relative_rms > _RESEMBLES:
        return _UNLIKE
    return ""


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
    if set(unranked_reasons(deviations).values()) == {_UNLIKE} and not names:
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
        return f"{name} is not compared with {measured.source}: {_DOUBTFUL_UNIT}."
    if difference.is_reversed:
        return f"{name} is not compared with {measured.source}: {_OPPOSITE}."
    if difference.n_points < _FEWEST_COMMON:
        return f"{name} is not compared with {measured.source}: {_FEW_COMMON}."
    rms = _rms_in_words(measured, difference, units)
    peaks = _peaks_in_words(measured, difference, units)
    if difference.relative_rms > _RESEMBLES:
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
        if reason not in (_STILL_RISES, _UNLIKE)
    ]
    unlike = [name for name, reason in reasons.items() if reason == _UNLIKE]
    rising = [name for name, reason in reasons.items() if reason == _STILL_RISES]
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
    end = _largest(measured.x)
    ends = [_largest(curve.x) for curve in curves.values()]
    peak = abs(measured.peak)
    peaks = [_largest(curve.y) for curve in curves.values()]
    notes: list[str] = []
    if _has_other_size(end, ends):
        own = quantity_in(end, x_unit)
        notes.append(
            f"{measured.source} {lasts} {own}, the runs {_range(ends, x_unit)}; check the unit."
        )
    if _has_other_size(peak, peaks):
        own = quantity_in(peak, y_unit)
        notes.append(
            f"The largest value of {measured.source} is {own}, of the runs "
            f"{_range(peaks, y_unit)}; check the unit."
        )
    return notes


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
    peaks = [_largest(curve.y) for curve in curves.values()]
    ends = [_largest(curve.x) for curve in curves.values()]
    end = _largest(measured.x)
    is_short = _has_other_size(end, ends) and end < min(ends)
    return is_short or _has_other_size(abs(measured.peak), peaks)


def _largest(values: Array) -> float:
    """Return the largest magnitude of some values."""
    return float(np.abs(values).max())


def _has_other_size(value: float, others: Sequence[float]) -> bool:
    """Return True if a value is much larger or much smaller than all of some positive values."""
    low = min(others)
    high = max(others)
    if low <= 0.0 or value <= 0.0:
        return False
    return value > _OTHER_UNIT * high or value < low / _OTHER_UNIT


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
            f"Points of {measured.source} beyond an end of a curve, by up to {share(_NEAR_END)} of "
            f"the {spacing}, are compared with the value at this end: {named(near, _MOST_LISTED)}."
        )
    return notes


def relative_text(ratio: float) -> str:
    """Return a ratio in words: ``12 % of``, or ``27.2 times`` if it is large."""
    return f"{share(ratio)} of" if ratio < _TIMES else f"{ratio:.3g} times"


def _within(curve: SampledCurve, points: Array, low: float, high: float) -> SampledCurve:
    """Return the part of a curve in a range, with its interpolated values at further points."""
    places = np.concatenate([curve.x, points])
    places = np.unique(places[(places >= low) & (places <= high)])
    return SampledCurve(places, np.interp(places, curve.x, curve.y))


def _with_units(table: TextTable) -> TextTable:
    """Return a table whose row of units below the names, if it has one, is part of the names."""
    units = list(table.units)
    if not units and table.heads and len(table.layout.rows) > _LEAST_POINTS:
        units = [_SPELLINGS.get(unit, unit) for unit in map(unit_of, table.layout.cells(1))]
        if not _are_units(units):
            return table
        start = len(table.layout.rows) - len(table) + 1
        table = table_of(table.layout, table.heads, table.head_line, start=start)
    if not units:
        return table
    names = zip(table.heads, units, strict=True)
    table.heads = [f"{name} ({unit})" if unit else name for name, unit in names]
    return table


def _are_units(cells: Sequence[str]) -> bool:
    """Return True for cells of units, of which some may be empty or unknown, but not all."""
    symbols = {symbol for symbol in chain.from_iterable(UNITS.values()) if symbol not in ("", "1")}
    return any(cell in symbols for cell in cells) and not any(map(is_number, cells))


def _values(table: TextTable, column: int, power: int) -> Array:
    """Return a column in its SI unit: (n,)."""
    return in_si(table.numbers(column, table.heads[column]), power)


def _columns(table: TextTable, units: tuple[str, str], source: str) -> Sequence[tuple[int, int]]:
    """Return number and power of ten of the first column of each of some SI units."""
    if not table.heads:
        raise InputError(f"{source}: line 1: found no names of columns, expected {_example(units)}")
    taken: list[tuple[int, int]] = []
    for unit in units:
        for column, head in enumerate(table.heads):
            found = _unit_of(head)
            if found in UNITS[unit] and column not in [number for number, _ in taken]:
                taken.append((column, UNITS[unit][found]))
                break
        else:
            powers = ", ".join(name for name in UNITS[unit] if name)
            raise InputError(
                f"{source}: line {table.head_line}: found the columns {', '.join(table.heads)}, "
                f"expected one in {powers}, the unit in its name, such as {_example(units)}"
            )
    return taken


def _unit_of(head: str) -> str:
    """Return the unit in the name of a column; empty if there is none."""
    _, unit = split_unit(head)
    if not unit and (match := _JOINED.fullmatch(head)):
        unit = match[2]
    return _SPELLINGS.get(unit, unit)


def _example(units: tuple[str, str]) -> str:
    names = {"s": "time_us", "m": "depth_mm", "N": "force_N", "1": "share"}
    return ", ".join(names[unit] for unit in units)
