"""Removal of clutter from tables: columns and rows without a value, and digits that are nothing but rounding.

A number is rounding where it is below 1e-12 of the scale of its quantity, or below 1e-100. The scale is the largest
number of the same unit that belongs to the same run (its energies, say); where it is the only one of its unit, or has
none, the largest of all runs.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

from granwave.analysis.document.cells import BLANK
from granwave.analysis.document.model import Beside, Block, Cell, Group, Part, Report, Table

_ROUNDING = 1e-12
_LEAST = 1e-100
_UNIT = "Unit"  # heading of the column that has the units where each row is a quantity

Numbers = tuple[float, ...]  # of one cell: a value, or a mean and its half-width; empty where there is none


def tidied(report: Report) -> Report:
    """The report with all its tables tidied."""
    sections = (dataclasses.replace(section, blocks=tuple(map(_block, section.blocks))) for section in report.sections)
    return dataclasses.replace(report, sections=tuple(sections))


def _block(block: Block) -> Block:
    if isinstance(block, Group):
        return dataclasses.replace(block, blocks=tuple(map(_part, block.blocks)))
    return _part(block)


def _part(part: Part) -> Part:
    if isinstance(part, Beside):
        return dataclasses.replace(part, table=tidied_table(part.table))
    return tidied_table(part) if isinstance(part, Table) else part


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
