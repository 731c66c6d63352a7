"""Rows of numbers in the text files of a run: what is no number is refused, with its file, line and column."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.errors import OutputFormatError

AGAIN = "run the case again with --force"
DAMAGED = f"the file is damaged, {AGAIN}"
CUT = f"the file was cut, {AGAIN}"
_WHOLE = ("step", "id", "type", "i", "j")  # columns of counts and names


def read_rows(rows: Sequence[str], columns: Sequence[str], place: Callable[[int], str]) -> NDArray[np.float64]:
    """Finite numbers in rows of text.

    Parameters
    ----------
    rows
        Lines of the file.
    columns
        Their names.
    place
        The file and line of a row, counted from 0, for the message.

    Returns
    -------
    ndarray
        (n_rows, n_columns).

    Raises
    ------
    OutputFormatError
        A row has more or fewer values, or one is no finite number; or an id or a step is not whole.
    """
    shape = len(rows), len(columns)
    values = _parsed(rows)
    if values is not None and values.size == shape[0] * shape[1] and np.isfinite(values).all():
        table = values.reshape(shape)
        whole = [n for n, name in enumerate(columns) if name in _WHOLE]
        if np.array_equal(table[:, whole], np.rint(table[:, whole])):
            return table
    for n, row in enumerate(rows):
        if fault := _fault(row.split(), columns):
            raise OutputFormatError(f"{place(n)}: {fault}; {DAMAGED}")
    raise OutputFormatError(f"{place(0)}: expected {shape[0]} rows of {shape[1]} numbers; {DAMAGED}")


def whole_number(text: str, name: str, place: str) -> int:
    """A count in a header, at least 0; raises as `read_rows`."""
    try:
        value = int(text)
    except ValueError:
        value = -1
    if value < 0:
        raise OutputFormatError(f"{place}: found {text.strip()!r}, expected the {name}, a whole number; {DAMAGED}")
    return value


def _parsed(rows: Sequence[str]) -> NDArray[np.float64] | None:
    """All numbers of the text in a row; None, or those up to there, where something else is among them."""
    text = " ".join(rows)
    if not text.strip():
        return np.empty(0)  # of nothing at all numpy makes one number
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # older numpy, of text that is no number
            return np.fromstring(text, dtype=float, sep=" ")  # the fastest reader of text that numpy has
    except ValueError:
        return None


def _fault(words: Sequence[str], columns: Sequence[str]) -> str:
    """Why the words of a row are not these columns; empty where they are."""
    if len(words) != len(columns):
        return f"found {len(words)} values, expected {len(columns)} ({' '.join(columns)})"
    for word, name in zip(words, columns, strict=True):
        try:
            value = float(word)
        except ValueError:
            return f"found {word!r} for {name}, expected a number"
        if not math.isfinite(value):
            return f"found {word} for {name}, expected a finite number"
        if name in _WHOLE and value != round(value):
            return f"found {word} for {name}, expected a whole number"
    return ""
