"""A measured curve, read from a table of text.

The table has a column of times or lengths and a column of forces or other values, each with its
unit in its name, ``time_us, force_kN`` or ``t (ms); F (N)``, or in the row below the names, as in
the files of oscilloscopes. The curve is shifted and scaled only on request.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np

from granwave.analysis.formatting.numbers import quantity_in
from granwave.analysis.measures.signals import Array
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
LEAST_POINTS = 2


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
    if len(x) < LEAST_POINTS:
        raise InputError(f"{source}: found {len(x)} row, expected at least {LEAST_POINTS}")
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


def _with_units(table: TextTable) -> TextTable:
    """Return a table whose row of units below the names, if it has one, is part of the names."""
    units = list(table.units)
    if not units and table.heads and len(table.layout.rows) > LEAST_POINTS:
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
