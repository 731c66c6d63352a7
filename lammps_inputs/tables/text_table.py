"""Columns of a table of text, read by pandas."""

from __future__ import annotations

import dataclasses
import io
import itertools
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.files import read_number
from granwave.lammps_inputs.message_words import counted, show
from granwave.lammps_inputs.tables.digits import half_units, sample_of
from granwave.lammps_inputs.tables.layout import (
    BLANKS,
    Layout,
    is_number,
    join_cells,
    layout_of,
    split_row,
    with_decimal_point,
    without_count,
)
from granwave.lammps_inputs.tables.units import LENGTH_UNITS, VOXELS, unit_of

if TYPE_CHECKING:
    import pandas as pd

_EXACT_BY_DEFAULT = (3, 1)  # first pandas that reads every bit by default
_THOUSANDS = re.compile(r"[-+]?[0-9]{1,3}(?:[.,' ][0-9]{3})+(?:[.,][0-9]*)?")
_UNIT_IN_BRACKETS = re.compile(r"\([^()]+\)|\[[^\[\]]+\]")
_UNIT_CELL = re.compile(r"[^0-9\s]{0,2}[^\s]{0,7}")  # short, and no number
_QUOTING_LENGTH = 100_000  # characters from which a row is taken apart by `csv`, which has a limit


@dataclasses.dataclass(eq=False)
class TextTable:
    """Table of text.

    Attributes
    ----------
    heads
        Names of the columns as they are written; empty if the table has none.
    head_line
        Line of the names, from 1; without names the line of the first row.
    lines
        Line of each row, from 1: (n,).
    layout
        Layout of the text.
    frame
        Cells, in columns numbered from 0.
    units
        Units of the columns in a separate row below the names; empty if there is none.
    """

    heads: Sequence[str]
    head_line: int
    lines: NDArray[np.int64]
    layout: Layout
    frame: pd.DataFrame
    units: Sequence[str] = ()

    def __len__(self) -> int:
        return len(self.lines)

    def place(self, row: int) -> str:
        """Return the place of a row in words."""
        return f"line {self.lines[row]}"

    def numbers(self, column: int, name: str, empty: float | None = None) -> NDArray[np.float64]:
        """Return a column of finite numbers: (n,).

        Parameters
        ----------
        name
            Name of the column in messages.
        empty
            Value of an empty cell; None: there must be none.

        Raises
        ------
        ValueError
            A cell is no finite number; the message names its line.
        """
        cells = self.frame[column]
        if cells.dtype.kind in "iuf":
            values = np.asarray(cells, dtype=np.float64)
            first_row = len(self.layout.rows) - len(self)
            for row in np.flatnonzero(~np.isfinite(values)).tolist():  # pandas reads inf
                cell = self.layout.cells(first_row + row)[column]
                values[row] = self._number(cell.strip(), row, name, empty)
            return values
        values = np.empty(len(cells))
        for row, cell in enumerate(cells):
            values[row] = self._number(str(cell).strip(), row, name, empty)
        return values

    def _number(self, cell: str, row: int, name: str, empty: float | None) -> float:
        """Return the number in a cell."""
        if not cell and empty is not None:
            return empty
        has_comma = self.layout.decimal == ","
        number = np.nan
        if not (has_comma and _THOUSANDS.fullmatch(cell)):
            try:
                number = read_number(with_decimal_point(cell) if has_comma else cell)
            except ValueError:
                number = np.nan
        if not np.isfinite(number):
            where = self.place(row)
            more = ", without a thousands separator" if _THOUSANDS.fullmatch(cell) else ""
            raise ValueError(
                f"{where}: found {show(cell)} for {name}, expected a finite number{more}"
            )
        return number

    def words(self, column: int) -> list[str]:
        """Return a column of words, without blanks around them: (n,)."""
        return [str(word).strip() for word in self.frame[column].tolist()]

    def half_units(
        self, columns: Sequence[int], values: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return half a unit of the last digit of each number of some columns: (n, n_columns)."""
        first = len(self.layout.rows) - len(self)
        texts: list[str] = []
        for row in sample_of(len(self)).tolist():
            cells = self.layout.cells(first + row)
            texts += [cells[column] for column in columns]
        return half_units(texts, values)


def read_text_table(
    text: str, heads: Sequence[str] = (), nothing: str = "found nothing, expected a table"
) -> TextTable:
    """Read a table of text.

    Parameters
    ----------
    heads
        Names of the columns, for a table without names, or to replace its names.
    nothing
        Message if there is no row.

    Raises
    ------
    ValueError
        It is none; the message names the line.
    """
    layout = without_count(layout_of(text))
    if not layout.rows:
        raise ValueError(nothing)
    return text_table_of(layout, heads)


def text_table_of(layout: Layout, heads: Sequence[str] = ()) -> TextTable:
    """Return the table of a layout, which may begin with a row of names and a row of units.

    Parameters
    ----------
    heads
        Names of the columns, for a table without names, or to replace its names.

    Raises
    ------
    ValueError
        It is none; the message names the line.
    """
    first = layout.cells(0)
    if layout.separator == BLANKS:
        first = _with_units(first)
    is_headed = not any(map(is_number, first))
    names = list(heads)
    if is_headed and not names:
        names = first
    elif not names:
        names = _heads_in_comment(layout, len(first))
    units = _units_below(layout) if is_headed else []
    start = int(is_headed) + int(bool(units))
    table = table_of(layout, names, layout.numbers[0], start=start)
    table.units = units
    return table


def table_of(layout: Layout, heads: Sequence[str], head_line: int, *, start: int = 0) -> TextTable:
    """Return the table of the rows of a layout from ``start`` on.

    Raises
    ------
    ValueError
        A row has more or fewer cells than there are names, or than the first row without names.
    """
    expected = list(heads) or [f"column {n + 1}" for n in range(len(layout.cells(0)))]
    rows = _checked_rows(layout, start, expected)
    lines = np.array(layout.numbers[start:], dtype=np.int64)
    return TextTable(heads, head_line, lines, layout, _frame(layout, rows, len(expected)))


def _with_units(words: Sequence[str]) -> list[str]:
    """Return names that are separated by blanks; a unit in brackets is joined to its name: ``x
    (mm)``.
    """
    names: list[str] = []
    for word in words:
        if names and _UNIT_IN_BRACKETS.fullmatch(word):
            names[-1] = f"{names[-1]} {word}"
        else:
            names.append(word)
    return names


def _units_below(layout: Layout) -> list[str]:
    """Return the units in the row below the names; none without a unit of length among them."""
    if len(layout.rows) < 3:
        return []
    cells = layout.cells(1)
    if any(map(is_number, cells)) or not all(map(_UNIT_CELL.fullmatch, cells)):
        return []
    units = [unit_of(cell) for cell in cells]
    return units if any(unit in LENGTH_UNITS or unit in VOXELS for unit in units) else []


def _heads_in_comment(layout: Layout, n: int) -> list[str]:
    """Return the names of ``n`` columns in the last comment before the rows; none without such a
    comment.
    """
    if not layout.comments:
        return []
    line = layout.comments[-1]
    words = line.split(layout.separator) if layout.separator in line.strip() else line.split()
    if layout.separator == BLANKS:
        words = _with_units(split_row(line, BLANKS))
    has_names = len(words) == n and not any(map(is_number, words))
    return [word.strip() for word in words] if has_names else []


def _checked_rows(layout: Layout, start: int, names: Sequence[str]) -> Sequence[str]:
    """Return the rows from this row on, after a check that they have as many cells as there are
    names.
    """
    sign = layout.separator
    expected = len(names)
    rows = list(layout.rows[start:])
    for k, row in enumerate(rows):
        is_plain = '"' not in row and len(row) < _QUOTING_LENGTH
        if is_plain:
            n_cells = len(row.split()) if sign == BLANKS else row.count(sign) + 1
        else:
            cells = layout.written_cells(start + k)
            n_cells = len(cells)
            rows[k] = join_cells(cells, sign)
        if n_cells == expected + 1 and rows[k].endswith(sign) and sign != BLANKS:
            rows[k] = rows[k].removesuffix(sign)  # a row that ends with a separator
            n_cells = expected
        if n_cells != expected:
            line = layout.numbers[start + k]
            hint = _hint_at_cells(layout, start + k, n_cells, expected)
            raise ValueError(
                f"line {line}: found {counted(n_cells, 'value')}, expected {expected}: "
                f"{', '.join(names)}{hint}"
            )
    return rows


def _hint_at_cells(layout: Layout, row: int, n_cells: int, expected: int) -> str:
    """Return a hint at the reason why a row has another number of cells; empty if there is none."""
    if n_cells < expected and row > 1 and row == len(layout.rows) - 1:
        return "; the file may be truncated"
    if n_cells > expected and layout.separator == ",":
        return "; decimal commas need semicolons, tabs or blanks between the columns"
    return ""


def _frame(layout: Layout, rows: Sequence[str], n_columns: int) -> pd.DataFrame:
    """Return the cells of rows that have been checked."""
    import pandas  # imported on demand: slow to load

    if not rows:
        return pandas.DataFrame({column: [] for column in range(n_columns)}, dtype=np.float64)
    exact: dict[str, Any] = {}
    version = tuple(map(int, itertools.islice(pandas.__version__.split("."), 2)))
    if version < _EXACT_BY_DEFAULT:
        exact["float_precision"] = "round_trip"
    return pandas.read_csv(
        io.StringIO("\n".join(rows)),
        sep=r"\s+" if layout.separator == BLANKS else layout.separator,
        decimal=layout.decimal,
        header=None,
        names=range(n_columns),
        index_col=False,
        keep_default_na=False,
        na_filter=False,
        skipinitialspace=True,
        skip_blank_lines=False,
        low_memory=False,
        **exact,
    )
