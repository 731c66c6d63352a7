"""Comparison of a measured curve with the curves of runs.

The curve is a table of text with a column of times or lengths and a column of forces or other
values, each with its unit in its name, ``time_us, force_kN`` or ``t (ms); F (N)``, or in the row
below the names, as in the files of oscilloscopes. It is shifted and scaled only on request.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np

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
#: Reasons for which a run is not ranked.
_FEWER_POINTS = "fewer points than other runs"
_BEFORE_PEAK = "ends before the measured peak"
_STILL_RISES = "still rises at its end"
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
    """

    source: str
    columns: tuple[str, str]
    x: Array
    y: Array
    shift: float = 0.0
    scale: float = 1.0

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
        is reversed.
    n_points
        Number of measured points within the curve of the run.
    peak
        Largest value of the run in the measured range.
    peak_at
        Its time or length, s or m.
    outside_at
        Time or length of the largest value of the run, if it is outside the measured range; None:
        it lies inside.
    covers_peak
        True if the measured peak is within the curve of the run.
    rises_at_end
        True if the run ends within the measured range with its largest value, so that it may rise
        further.
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


def read_measured(
    path: str | Path, units: tuple[str, str], *, shift: float = 0.0, scale: float = 1.0
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
    order = np.argsort(x, kind="stable")
    return MeasuredCurve(source, names, x[order] + shift, scale * y[order], shift, scale)


def deviation(measured: MeasuredCurve, curve: SampledCurve) -> Deviation | None:
    """Return the difference of a run from a measured curve; None if they do not overlap."""
    low = max(float(curve.x.min()), float(measured.x[0]))
    high = min(float(curve.x.max()), float(measured.x[-1]))
    inside = (measured.x >= low) & (measured.x <= high)
    if not inside.any():
        return None
    difference = np.interp(measured.x[inside], curve.x, curve.y) - measured.y[inside]
    rms = float(np.sqrt(np.mean(difference**2)))
    size = float(np.abs(measured.y).max())
    covers_peak = low <= measured.peak_at <= high
    own = _within(curve, low, high)
    first = int(own.y.argmax())
    largest = float(own.y[first])
    place = int(curve.y.argmax())
    rises_at_end = place == len(curve.y) - 1 and low < curve.x[-1] <= measured.x[-1]
    has_peaks = covers_peak and not rises_at_end and not measured.is_reversed
    is_outside = not low <= curve.x[place] <= high and curve.y[place] > largest
    return Deviation(
        rms,
        rms / size,
        largest / size - 1 if has_peaks else np.nan,
        int(inside.sum()),
        peak=largest,
        peak_at=float(own.x[first]),
        outside_at=float(curve.x[place]) if is_outside else None,
        covers_peak=covers_peak,
        rises_at_end=bool(rises_at_end),
    )


def ranked(deviations: Mapping[str, Deviation]) -> list[str]:
    """Return the names of the runs whose differences from a measured curve can be ranked.

    Their differences are means over the same points: those of the run with the most points. A run
    that does not cover the measured peak is not ranked if another run covers it, nor is a run that
    ends with its largest value if another does not.
    """
    reasons = unranked_reasons(deviations)
    return [name for name in deviations if name not in reasons]


def unranked_reasons(deviations: Mapping[str, Deviation]) -> dict[str, str]:
    """Return the reasons for which runs are not ranked by their difference from a measured curve,
    by their names.
    """
    most = max((difference.n_points for difference in deviations.values()), default=0)
    any_covers = any(difference.covers_peak for difference in deviations.values())
    any_falls = any(
        difference.covers_peak and not difference.rises_at_end for difference in deviations.values()
    )
    reasons: dict[str, str] = {}
    for name, difference in deviations.items():
        if difference.n_points < _ENOUGH * most:
            reasons[name] = _FEWER_POINTS
        elif any_covers and not difference.covers_peak:
            reasons[name] = _BEFORE_PEAK
        elif any_falls and difference.rises_at_end:
            reasons[name] = _STILL_RISES
    return reasons


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
    y_unit = units[1]
    names = ranked(deviations)
    name = min(names, key=lambda other: deviations[other].rms)
    closest = deviations[name]
    size = relative_text(closest.relative_rms)
    rms = f"{quantity_in(closest.rms, y_unit)} rms, {size} the measured peak"
    if closest.n_points < len(measured.x):
        rms += f", at {closest.n_points} of {len(measured.x)} measured points"
    peaks = _peaks_in_words(measured, closest, units)
    if alone:
        return f"{name} differs from {measured.source} by {rms}; {peaks}."
    if len(names) < len(deviations) and len(names) == 1:
        return (
            f"Only {name} is compared with {measured.source}, with a difference of {rms}; {peaks}."
        )
    return f"Closest to {measured.source} is {name}, with a difference of {rms}; {peaks}."


def _peaks_in_words(measured: MeasuredCurve, closest: Deviation, units: tuple[str, str]) -> str:
    """Return the peaks of a run and of a measured curve in words."""
    x_unit, y_unit = units
    own = f"{quantity_in(closest.peak, y_unit)} at {quantity_in(closest.peak_at, x_unit)}"
    other = f"{quantity_in(measured.peak, y_unit)} at {quantity_in(measured.peak_at, x_unit)}"
    if not closest.covers_peak:
        return f"the run does not cover the measured peak, {other}"
    if closest.rises_at_end:
        return f"the curve of the run still rises at its end, {own}; the measured peak is {other}"
    if abs(closest.peak) < NEGLIGIBLE * abs(measured.peak):
        return f"it is zero in the measured range, the measured peak is {other}"
    return f"its peak in the measured range is {own}, the measured peak {other}"


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
    parts = [
        f"{name} ({deviations[name].n_points} of {len(measured.x)} points)"
        for name, reason in reasons.items()
        if reason != _STILL_RISES
    ]
    rising = [name for name, reason in reasons.items() if reason == _STILL_RISES]
    if parts:
        notes.append(
            f"Not ranked by their difference from {measured.source}, of which they cover only a "
            f"part: {_first(parts)}."
        )
    if rising:
        notes.append(
            f"Not ranked by their difference from {measured.source}, since their largest value is "
            f"at their end: {_first(rising)}."
        )
    if measured.is_reversed:
        notes.append(
            f"The largest values of {measured.source} are negative, and peaks are not compared. If "
            "the sensor has the opposite sign, multiply its values by -1: --scale -1, or scale=-1 "
            "in Python."
        )
    return notes


def _first(parts: Sequence[str]) -> str:
    """Return the first parts of a list in words, and the number of the others."""
    left = len(parts) - _MOST_LISTED
    more = f" and {left} more" if left > 0 else ""
    return f"{', '.join(parts[:_MOST_LISTED])}{more}"


def relative_text(ratio: float) -> str:
    """Return a ratio in words: ``12 % of``, or ``27.2 times`` if it is large."""
    return f"{share(ratio)} of" if ratio < _TIMES else f"{ratio:.3g} times"


def outside_notes(
    measured: MeasuredCurve, deviations: Mapping[str, Deviation], units: tuple[str, str]
) -> list[str]:
    """Return a sentence on runs whose largest value lies outside a measured range, if any does.

    Parameters
    ----------
    deviations, units
        As of `closest_sentence`.
    """
    x_unit = units[0]
    places = [
        f"{name} at {quantity_in(difference.outside_at, x_unit)}"
        for name, difference in deviations.items()
        if difference.outside_at is not None
    ]
    if not places:
        return []
    ends = [quantity_in(float(end), x_unit) for end in (measured.x[0], measured.x[-1])]
    return [
        f"Largest values outside the range of {measured.source}, {' to '.join(ends)}: "
        f"{_first(places)}. Shift the measured curve if its zero "
        "differs."
    ]


def _within(curve: SampledCurve, low: float, high: float) -> SampledCurve:
    """Return the part of a curve in a range; its interpolated start if no sample is inside."""
    inside = (curve.x >= low) & (curve.x <= high)
    if inside.any():
        return SampledCurve(curve.x[inside], curve.y[inside])
    return SampledCurve(np.array([low]), np.interp([low], curve.x, curve.y))


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
