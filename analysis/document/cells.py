"""Cells and columns of values of a summary or a case: names, units, numbers as text, without clutter.

Clutter are columns and rows without a value, and digits that are nothing but rounding.

A number is rounding where it is below 1e-12 of the scale of its quantity, or below 1e-100. The scale is the largest
number of the same unit that belongs to the same run (its energies, say); where it is the only one of its unit, or has
none, the largest of all runs.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from granwave.analysis.document.model import Cell, Column, Group, Report, Table, changed
from granwave.analysis.formatting.grains import grains_called_in
from granwave.analysis.formatting.numbers import interval, plain
from granwave.analysis.formatting.units import printed_unit
from granwave.analysis.formatting.values import as_label
from granwave.analysis.quantities import ENTRIES, quantity
from granwave.analysis.quantity_notes import meaning_of
from granwave.lammps_inputs.packing.cylinders import SPHERES, in_grains

BLANK = "\u2013"  # a value that does not apply
_DIGITS = 5
_ROUNDING = 1e-12
_LEAST = 1e-100
_UNIT = "Unit"  # heading of the column that has the units where each row is a quantity
Numbers = tuple[float, ...]  # of one cell: a value, or a mean and its half-width; empty where there is none


def label_of(key: str, called: str = SPHERES) -> str:
    """Label of a value of a summary; ``called``: what the grains of its runs are called."""
    return in_grains(quantity(key).label, called)


def meaning_in(key: str, called: str = SPHERES) -> str:
    """Meaning of a value of a summary, likewise."""
    return in_grains(meaning_of(key), called)


def meanings(summaries: Sequence[Mapping[str, Any]]) -> tuple[Group, ...]:
    """Meanings of the values that any of these summaries has, folded away; nothing if there are none."""
    explained = [entry for entry in ENTRIES if entry.meaning]
    shown = [entry for entry in explained if any(summary.get(entry.name) is not None for summary in summaries)]
    if not shown:
        return ()
    title = "What these values mean"
    called = grains_called_in(summaries)
    heads = ("Quantity", "In summary.json", "Meaning")
    rows = [(in_grains(entry.label, called), entry.name, in_grains(entry.meaning, called)) for entry in shown]
    return (Group(title, (text_table(title, heads, rows, captioned=False),), folded=True),)


def text_table(caption: str, heads: Sequence[str], rows: Iterable[Sequence[str | Cell]], **options: Any) -> Table:
    """Table of texts, the first of each row its key; ``options``: as of `Table`."""
    cells = tuple(tuple(one if isinstance(one, Cell) else Cell(one) for one in row) for row in rows)
    return Table(caption, (Column(heads[0], key=True), *map(Column, heads[1:])), cells, **options)


def unit_of_value(key: str) -> str:
    """Unit of a key of a summary, empty where it has none."""
    return printed_unit(quantity(key).unit)


def value_column(key: str, called: str = SPHERES) -> Column:
    """Column of a value of the summary; ``called``: what the grains of its runs are called."""
    return Column(label_of(key, called), unit_of_value(key), numeric=True, meaning=meaning_in(key, called))


def case_column(key: str, unit: str, *, numeric: bool) -> Column:
    """Column of a key of the case, with its unit as people write it."""
    return Column(key, unit, numeric=numeric, key=True)


def show(value: Any) -> str:
    """A value of a summary or a case as text; numbers with five digits."""
    if value is None:
        return BLANK
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return _float(value)
    if isinstance(value, dict) or (isinstance(value, (list, tuple)) and any(isinstance(item, dict) for item in value)):
        return as_label(value)
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(show(item) for item in value) + "]"
    return str(value)


def named(labels: Sequence[str], most: int = 6) -> str:
    """A list of runs, cut when it is long; points of one scan are named by their numbers after the first."""
    texts, before = [], None
    for label in labels[:most]:
        scan, _, number = label.rpartition(" #")
        texts.append(f"#{number}" if scan and scan == before else label)
        before = scan
    more = f" and {len(labels) - most} more" if len(labels) > most else ""
    return ", ".join(texts) + more


def percent(value: float) -> str:
    """A difference in per cent, with its sign."""
    text = f"{value:+.2g}" if abs(value) < 1 else f"{value:+.3g}"
    return "0 %" if value == 0 else f"{plain(text)} %"


def value_cell(value: Any, **more: Any) -> Cell:
    """Cell of a value; numbers sort as such."""
    sort = value
    if isinstance(value, bool):
        sort = float(value)
    elif isinstance(value, (int, float)):
        sort = float(value) if -1e300 < value < 1e300 else None  # NaN too
    elif value is not None:
        sort = show(value)
    return Cell(show(value), sort, **more)


def spread_cell(mean: float | None, half_width: float | None) -> Cell:
    """Cell of a mean with its interval or deviation, where there is one, and no digit beyond those it tells."""
    if mean is None or not half_width or not math.isfinite(half_width):
        return value_cell(mean)
    return Cell(interval(mean, half_width), mean)


def is_number(value: Any) -> bool:
    """An integer or a float, but no truth value."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def significant(value: float, digits: int) -> str:
    """A number with so many significant digits."""
    return _float(value, digits)


def _float(value: float, digits: int = _DIGITS) -> str:
    if math.isnan(value):
        return "not a number"
    if math.isinf(value):
        return "infinite"
    text = f"{value:.{digits}g}"
    if 1e5 <= abs(value) < 1e7:
        text = f"{float(text):.0f}"
    return plain(text)


def tidied(report: Report) -> Report:
    """The report with all its tables tidied."""
    found: Report = changed(report, Table, tidied_table)
    return found


def tidied_table(table: Table) -> Table:
    """The table without empty columns and rows, and with ``< 1e-16`` for what is rounding."""
    rows = _without_rounding(table)
    if table.by_row and (full := [row for row in rows if _has_value(table, row)]):
        rows = full
    kept = [n for n in range(len(table.columns)) if not rows or any(row[n].text not in ("", BLANK) for row in rows)]
    return dataclasses.replace(
        table,
        columns=tuple(table.columns[n] for n in kept),
        rows=tuple(tuple(row[n] for n in kept) for row in rows),
    )


def _has_value(table: Table, row: Sequence[Cell]) -> bool:
    """True if any of the numbers of a quantity is known, or there are no columns of numbers."""
    values = [cell.text for cell, column in zip(row, table.columns, strict=True) if column.numeric and not column.key]
    return not values or any(text not in ("", BLANK) for text in values)


def _without_rounding(table: Table) -> list[list[Cell]]:
    """Cells by row and column."""
    shown = [n for n, column in enumerate(table.columns) if column.numeric and not column.key]
    cells = [[row[n] for n in shown] for row in table.rows]
    units = [table.columns[n].unit for n in shown]
    if table.by_row:  # to quantities in columns, and back
        named = [n for n, column in enumerate(table.columns) if column.heading == _UNIT]
        units = [row[named[0]].text if named else "" for row in table.rows]
        cells = [list(column) for column in zip(*cells, strict=True)]
    cells = _bounded(cells, units)
    if table.by_row:
        cells = [list(column) for column in zip(*cells, strict=True)]
    rows = [list(row) for row in table.rows]
    for row, found in zip(rows, cells, strict=False):  # none without numeric columns
        for n, cell in zip(shown, found, strict=True):
            row[n] = cell
    return rows


def _bounded(cells: Sequence[Sequence[Cell]], units: Sequence[str]) -> list[list[Cell]]:
    """Cells by run and quantity, with a bound in place of each that is rounding."""
    sizes = [[max(map(abs, _numbers(cell)), default=0.0) for cell in row] for row in cells]
    largest = [max(column) for column in zip(*sizes, strict=True)]
    bounded = []
    for row, own in zip(cells, sizes, strict=True):
        found = []
        for n, cell in enumerate(row):
            alike = [size for size, unit in zip(own, units, strict=True) if unit == units[n]]
            scale = max(alike) if units[n] and len(alike) > 1 else largest[n]
            limit = max(_ROUNDING * scale, _LEAST)
            found.append(dataclasses.replace(cell, text=_bound(limit)) if 0 < own[n] < limit else cell)
        bounded.append(found)
    return bounded


def _numbers(cell: Cell) -> Numbers:
    """``0.7`` or ``0.70 ± 0.25``; nothing of any other text."""
    try:
        found = tuple(map(float, cell.text.split(" ± ")))
    except ValueError:
        return ()
    return found if all(map(math.isfinite, found)) else ()


def _bound(limit: float) -> str:
    """The power of ten above."""
    return f"< 1e{math.ceil(math.log10(limit) - 1e-9)}"
