"""Numbers of runs, as columns of a figure's data and of a table."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.document.cells import BLANK, value_cell
from granwave.analysis.document.model import Cell, Column, Note, Table
from granwave.analysis.formatting.numbers import with_interval
from granwave.analysis.statistics import Estimate


@dataclasses.dataclass(frozen=True)
class Quantity:
    """A number of a run.

    Attributes
    ----------
    column
        Name in the data of a figure, with the unit in SI at its end.
    heading, unit
        In a table.
    value
        Of a run, SI; NaN where it does not apply.
    per_unit
        What SI values are multiplied by for a table.
    """

    column: str
    heading: str
    unit: str
    value: Callable[[Any], float]
    per_unit: float = 1.0

    @property
    def axis(self) -> str:
        """Label of an axis."""
        return f"{self.heading} ({self.unit})" if self.unit else self.heading

    def shown(self, runs: Iterable[Any]) -> NDArray[np.float64]:
        """Values of runs in the unit: (n_runs,)."""
        return self.per_unit * np.array([self.value(run) for run in runs])


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


def of_summary(key: str) -> Callable[[Any], float]:
    """Value of a run: a number of its summary."""
    return lambda run: run.value(key)


def values_table(
    caption: str,
    runs: Sequence[Any],
    quantities: Iterable[Quantity],
    keys: Sequence[tuple[Column, Callable[[Any], Cell]]] = (),
    cell: Callable[[float], Cell] = value_cell,
) -> Table:
    """A table with a row for each run.

    Parameters
    ----------
    keys
        First columns, which say what a run is, and their cells.
    cell
        Cell of a value in its unit.
    """
    quantities = list(quantities)
    heads = (*(column for column, _ in keys), *(Column(one.heading, one.unit, numeric=True) for one in quantities))
    shown = [[one.per_unit * one.value(run) for one in quantities] for run in runs]
    rows = [
        (*(of(run) for _, of in keys), *(cell(value) if math.isfinite(value) else Cell(BLANK) for value in values))
        for run, values in zip(runs, shown, strict=True)
    ]
    return Table(caption, heads, tuple(rows), sortable=True)
