"""Tables of studies."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from granwave.analysis.document.cells import BLANK, value_cell
from granwave.analysis.document.model import Cell, Column, Note, Table
from granwave.analysis.formatting.numbers import with_interval
from granwave.analysis.statistics import Estimate


def numeric(*heads: str | tuple[str, str], key: bool = False) -> tuple[Column, ...]:
    """Columns of numbers, by heading, or by heading and unit."""
    pairs = [(head, "") if isinstance(head, str) else head for head in heads]
    return tuple(Column(heading, unit, numeric=True, key=key) for heading, unit in pairs)


def table_of(caption: str, columns: Iterable[Column], rows: Iterable[Iterable[Any]], **options: Any) -> Table:
    """A table of values; what is a cell already stays as it is.

    Parameters
    ----------
    options
        Further fields of a table, such as ``sortable``.
    """
    cells = tuple(tuple(one if isinstance(one, Cell) else value_cell(one) for one in row) for row in rows)
    return Table(caption, tuple(columns), cells, **options)


def as_block(one: Any) -> Any:
    """Make a table of caption and columns, ``("Impacts", {"Velocity (m/s)": velocity})``, and a note of a sentence.

    Values are numbers, estimates or texts; the unit ends the heading in brackets. All else is left as it is.
    """
    if isinstance(one, str):
        return Note(one)
    if not isinstance(one, tuple):
        return one
    caption, columns = one
    heads = []
    for place, (name, values) in enumerate(columns.items()):
        heading, _, unit = name.removesuffix(")").partition(" (") if name.endswith(")") else (name, "", "")
        text = any(isinstance(value, str) for value in values)
        heads.append(Column(heading, unit, numeric=not text, key=text and not place))
    return Table(caption, tuple(heads), tuple(tuple(map(_cell, row)) for row in zip(*columns.values(), strict=True)))


def _cell(value: Any) -> Cell:
    if isinstance(value, str):
        return Cell(value, value)
    if isinstance(value, Estimate):
        if value.half_width > 0:
            return Cell(with_interval(value), value.mean)
        value = value.mean
    number = value if isinstance(value, int) else float(value)
    return value_cell(number) if math.isfinite(number) else Cell(BLANK)
