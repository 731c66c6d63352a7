"""Rows of CSV files: read with the numbers of their lines, where a # outside quotes begins a comment; and written."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable
from pathlib import Path
from typing import TextIO

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_text

_BEFORE_COMMENT = re.compile(r'(?:[^"#]|"[^"]*(?:"|$))*')
_SPECIAL = re.compile('[,"#]')

Row = tuple[int, list[str]]  # number of the line, and the cells
_FORMULA = ("=", "+", "-", "@", "\t", "\r")  # first characters of what spreadsheets compute


def csv_rows(text: str) -> list[Row]:
    """Return the rows of a text that are no comments; a row is a line, also where quotes are left open.

    Raises
    ------
    ValueError
        A line cannot be taken apart.
    """
    found = []
    for number, line in enumerate(text.splitlines(), start=1):
        filled = _BEFORE_COMMENT.match(line)[0]  # type: ignore[index]  # it matches always
        if not filled.strip():
            continue
        try:
            found.append((number, next(csv.reader([filled], skipinitialspace=True))))
        except csv.Error as error:
            raise ValueError(f"line {number}: found no row of a CSV file: {error}") from None
    return found


def csv_cell(word: str) -> str:
    """Return a word without line breaks as a cell that `csv_rows` reads, in quotes if they are needed."""
    return '"' + word.replace('"', '""') + '"' if _SPECIAL.search(word) else word


def read_csv_rows(path: Path) -> list[Row]:
    """Read the rows of a CSV file.

    Raises
    ------
    InputError
        The file cannot be read, is not UTF-8, or has a line that cannot be taken apart.
    """
    try:
        return csv_rows(read_text(path))
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise InputError(f"{path}: found a directory, expected a CSV file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise InputError(f"{path}: {error}") from None


def write_csv_rows(file: TextIO, rows: Iterable[Iterable[object]]) -> None:
    """Write rows as CSV; text that a spreadsheet would take for a formula gets an apostrophe before it."""
    csv.writer(file, lineterminator="\n").writerows([_no_formula(cell) for cell in row] for row in rows)


def _no_formula(cell: object) -> object:
    if not isinstance(cell, str) or cell[:1] not in _FORMULA or len(cell) < 2:
        return cell
    try:
        float(cell)
    except ValueError:
        return f"'{cell}"
    return cell
