"""A measured curve next to those of runs, and its difference from each.

The curve is a table of text with a column of times or lengths and one of forces or other values,
each with its unit in its name: ``time_us, force_kN`` or ``t (ms); F (N)``. It is shifted and scaled
only where that is asked for.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from granwave.analysis.measures.signals import Array
from granwave.analysis.reports.comparison.curves import SampledCurve
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_user_text
from granwave.lammps_inputs.tables.text_table import TextTable, read_text_table
from granwave.lammps_inputs.tables.units import LENGTH_UNITS, in_si, split_unit

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


@dataclass(frozen=True, eq=False)
class MeasuredCurve:
    """A measured curve, shifted and scaled as was asked for.

    Attributes
    ----------
    source
        Path of its file.
    columns
        Names of its two columns.
    x, y
        Rising times or lengths, and values: (n,) each, SI units.
    shift
        What was added to ``x``, in its unit.
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
        """Largest value."""
        return float(self.y.max())


@dataclass(frozen=True)
class Deviation:
    """Difference of a run from a measured curve, where both have values.

    Attributes
    ----------
    rms
        Root mean square of the difference at the measured points, in the unit of the curve.
    relative_rms
        That over the largest measured value.
    peak_difference
        Largest value of the run over the largest measured one, less 1, in that range.
    n_points
        Number of measured points within the curve of the run.
    """

    rms: float
    relative_rms: float
    peak_difference: float
    n_points: int


def read_measured(
    path: str | Path, units: tuple[str, str], *, shift: float = 0.0, scale: float = 1.0
) -> MeasuredCurve:
    """Read a measured curve.

    Parameters
    ----------
    path
        Table of text; the first column of each unit is taken.
    units
        SI units of what it is compared with: of the axis, and of the values.
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
    text = read_user_text(Path(path), "table of a measured curve")
    try:
        table = read_text_table(text)
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
    """Return the difference of a run from a measured curve; None where they do not overlap."""
    low = max(float(curve.x.min()), float(measured.x[0]))
    high = min(float(curve.x.max()), float(measured.x[-1]))
    inside = (measured.x >= low) & (measured.x <= high)
    if not inside.any():
        return None
    difference = np.interp(measured.x[inside], curve.x, curve.y) - measured.y[inside]
    rms = float(np.sqrt(np.mean(difference**2)))
    size = float(np.abs(measured.y).max())
    own = curve.y[(curve.x >= low) & (curve.x <= high)]
    peak = float(measured.y[inside].max())
    largest = float(own.max()) if len(own) else float(np.interp(low, curve.x, curve.y))
    return Deviation(rms, rms / size, largest / peak - 1 if peak else np.nan, int(inside.sum()))


def _values(table: TextTable, column: int, power: int) -> Array:
    """Return a column in its SI unit: (n,)."""
    return in_si(table.numbers(column, table.heads[column]), power)


def _columns(table: TextTable, units: tuple[str, str], source: str) -> Sequence[tuple[int, int]]:
    """Return number and power of ten of the columns of some SI units, the first of each."""
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
    """Return the unit in the name of a column; empty without one."""
    _, unit = split_unit(head)
    if not unit and (match := _JOINED.fullmatch(head)):
        unit = match[2]
    return _SPELLINGS.get(unit, unit)


def _example(units: tuple[str, str]) -> str:
    names = {"s": "time_us", "m": "depth_mm", "N": "force_N", "1": "share"}
    return ", ".join(names[unit] for unit in units)
