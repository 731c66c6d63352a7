"""Numbers of runs, as columns of a figure's data and of a table."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.document.cells import BLANK, value_cell
from granwave.analysis.document.model import Cell, Column, Table


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


def of_summary(key: str) -> Callable[[Any], float]:
    """Value of a run: a number of its summary."""
    return lambda run: run.value(key)


def columns_of(runs: Iterable[Any], quantities: Iterable[Quantity]) -> dict[str, list[float]]:
    """Data of a figure: quantities of all runs, SI, by name of the column."""
    runs = list(runs)
    return {one.column: [one.value(run) for run in runs] for one in quantities}


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
