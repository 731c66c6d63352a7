"""Reader of rows of numbers in text files, with errors that name file, line and column."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from granwave._number_reader import read_numbers
from granwave.analysis.errors import OutputFormatError

AGAIN = "run the case again with --force"
DAMAGED = f"the file is damaged, {AGAIN}"
CUT = f"the file was cut, {AGAIN}"
WHOLE = ("step", "id", "type", "i", "j")  # columns of integers


def read_rows(rows: Sequence[str], columns: Sequence[str], place: Callable[[int], str]) -> NDArray[np.float64]:
    """Read finite numbers from rows of text.

    Parameters
    ----------
    rows
        Lines of the file.
    columns
        Names of the columns.
    place
        Function that returns file and line of a row, counted from 0, for messages.

    Returns
    -------
    ndarray
        Values, (n_rows, n_columns).

    Raises
    ------
    OutputFormatError
        A row has more or fewer values, a value is not a finite number, or an id or a step is not an integer.
    """
    shape = len(rows), len(columns)
    values = read_numbers(" ".join(rows))
    if values is not None and values.size == shape[0] * shape[1]:
        table = values.reshape(shape)
        whole = [n for n, name in enumerate(columns) if name in WHOLE]
        if np.array_equal(table[:, whole], np.rint(table[:, whole])):
            return table
    for n, row in enumerate(rows):
        if fault := _fault(row.split(), columns):
            raise OutputFormatError(f"{place(n)}: {fault}; {DAMAGED}")
    raise OutputFormatError(f"{place(0)}: expected {shape[0]} rows of {shape[1]} numbers; {DAMAGED}")


def whole_number(text: str, name: str, place: str) -> int:
    """Read a count in a header, at least 0; raise as `read_rows`."""
    try:
        value = int(text)
    except ValueError:
        value = -1
    if value < 0:
        raise OutputFormatError(f"{place}: found {text.strip()!r}, expected the {name}, a whole number; {DAMAGED}")
    return value


def _fault(words: Sequence[str], columns: Sequence[str]) -> str:
    """Describe the fault in the values of a row; empty if there is none."""
    if len(words) != len(columns):
        return f"found {len(words)} values, expected {len(columns)} ({' '.join(columns)})"
    for word, name in zip(words, columns, strict=True):
        try:
            value = float(word)
        except ValueError:
            return f"found {word!r} for {name}, expected a number"
        if not math.isfinite(value):
            return f"found {word} for {name}, expected a finite number"
        if name in WHOLE and value != round(value):
            return f"found {word} for {name}, expected a whole number"
    return ""
