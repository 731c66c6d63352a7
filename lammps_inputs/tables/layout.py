"""Layout of a table of text: its rows without comments, their separator and decimal sign.

Separators are commas, semicolons, tabs or blanks; a decimal comma is distinguished from a separator
by the resulting cells. A ``#`` outside quotes begins a comment, as do ``%`` and ``//`` at the
beginning of a line. Rows that contain only separators are blank lines, and so is the line
``sep=;`` of spreadsheets. Exponents of Fortran (``1.0D-3``) and typographic minus signs are
accepted in numbers.
"""

from __future__ import annotations

import csv
import dataclasses
import io
import re
from collections.abc import Sequence
from pathlib import Path

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_number, read_user_text
from granwave.lammps_inputs.tables.encoding import decoded_table

BLANKS = " "
_SEPARATORS = (";", "\t", ",", BLANKS)  # separators; the first match is used
_BEFORE_COMMENT = re.compile(r'(?:[^"#]|"[^"]*(?:"|$))*')
_COMMENT_LINES = ("%", "//")
_DECIMAL_COMMA = re.compile(r"[-+]?[0-9]*,[0-9]+(?:[eE][-+]?[0-9]+)?")
_FORTRAN = re.compile(
    r'(?<![^\s,;"])([-+]?(?:[0-9]+\.[0-9]*|\.[0-9]+))[dD]([-+]?[0-9]+)(?![^\s,;"])'
)
_SEPARATOR_LINE = re.compile(r'"?sep=.?"?', re.IGNORECASE)  # first line written by spreadsheets
_ALL_SEPARATORS = "".join(_SEPARATORS)
_MINUS = "\u2212"  # typographic minus
_SHOWN_ROWS = 20  # rows from which separator and decimal sign are found

Row = tuple[int, list[str]]  # number of the line, and the cells


@dataclasses.dataclass(frozen=True)
class Layout:
    """Rows of a table of text.

    Attributes
    ----------
    numbers
        Line of each row, from 1.
    rows
        Text of each row, without its comment.
    separator
        Separator of the cells; `BLANKS` stands for any number of blanks and tabs.
    decimal
        Decimal sign of the numbers, ``.`` or ``,``.
    comments
        Comments before the first row, without the sign that begins them.
    """

    numbers: Sequence[int]
    rows: Sequence[str]
    separator: str
    decimal: str
    comments: Sequence[str] = ()

    def cells(self, row: int) -> list[str]:
        """Return the cells of a row, with decimal points; raise ValueError as `written_cells`."""
        cells = self.written_cells(row)
        if self.decimal == ".":
            return cells
        return [with_decimal_point(cell) for cell in cells]

    def written_cells(self, row: int) -> list[str]:
        """Return the cells of a row without conversion.

        Raises
        ------
        ValueError
            The row cannot be parsed.
        """
        try:
            return split_row(self.rows[row], self.separator)
        except csv.Error as error:
            line = self.numbers[row]
            raise ValueError(f"line {line}: found no row of a CSV file: {error}") from None


def layout_of(text: str) -> Layout:
    """Return the layout of a table of text; a row is a line, also where quotes are left open."""
    numbers: list[int] = []
    rows: list[str] = []
    comments: list[str] = []
    for number, line in enumerate(text.replace(_MINUS, "-").splitlines(), start=1):
        row = _without_comment(line)
        if number == 1 and _SEPARATOR_LINE.fullmatch(row):
            continue
        if row:
            numbers.append(number)
            rows.append(row)
        elif not rows and (comment := line.strip().lstrip("#%/").strip()):
            comments.append(comment)
    return _layout(numbers, with_plain_exponents(rows), comments)


def layout_from(layout: Layout, row: int) -> Layout:
    """Return the layout of the rows from this row on; the rows above may have another separator."""
    return _layout(layout.numbers[row:], layout.rows[row:], layout.comments)


def without_count(layout: Layout) -> Layout:
    """Return the layout without a first row that is the number of the rows below it."""
    if len(layout.rows) > 1 and layout.rows[0].strip() == str(len(layout.rows) - 1):
        return layout_from(layout, 1)
    return layout


def with_plain_exponents(rows: list[str]) -> list[str]:
    """Convert Fortran exponents, such as 1.0D-3, to C."""
    if not any(map(_FORTRAN.search, rows[:_SHOWN_ROWS])):
        return rows
    return [_FORTRAN.sub(r"\1e\2", row) for row in rows]


def split_row(row: str, separator: str) -> list[str]:
    """Return the cells of a row, without blanks around them; raise `csv.Error` if that fails."""
    if separator == BLANKS:
        row = row.replace("\t", BLANKS)
    if '"' not in row and len(row) < csv.field_size_limit():
        cells = row.split() if separator == BLANKS else row.split(separator)
    else:
        cells = next(csv.reader([row], delimiter=separator, skipinitialspace=True))
    return [cell.strip() for cell in cells]


def join_cells(cells: Sequence[str], separator: str) -> str:
    """Return cells as a row that `split_row` and pandas split into the same cells."""
    text = io.StringIO()
    csv.writer(text, delimiter=separator, lineterminator="").writerow(cells)
    return text.getvalue()


def is_number(cell: str) -> bool:
    """Return True if a cell is a number with a decimal point."""
    try:
        read_number(cell)
    except ValueError:
        return False
    return True


def with_decimal_point(cell: str) -> str:
    """Return a number with a decimal comma as a number with a point; other cells are unchanged."""
    return cell.replace(",", ".") if _DECIMAL_COMMA.fullmatch(cell) else cell


def read_layout(path: Path) -> Layout:
    """Read the layout of a table; raise InputError if the file cannot be read or is no text."""
    return layout_of(read_user_text(path, "CSV file", decode=decoded_table))


def read_rows(path: Path) -> list[Row]:
    """Read the rows of a small table, with decimal points.

    Raises
    ------
    InputError
        The file cannot be read, is not text, or has a line that cannot be parsed.
    """
    return rows_of(read_layout(path), path)


def rows_of(layout: Layout, path: Path) -> list[Row]:
    """Return the rows of a layout, with decimal points; raise InputError as `read_rows`."""
    try:
        return [(number, layout.cells(row)) for row, number in enumerate(layout.numbers)]
    except ValueError as error:
        raise InputError(f"{path}: {error}") from None


def _layout(numbers: Sequence[int], rows: Sequence[str], comments: Sequence[str]) -> Layout:
    """Return the layout of rows, with the separator and the decimal sign that they have."""
    separator = _separator(rows[:_SHOWN_ROWS])
    return Layout(numbers, rows, separator, _decimal(rows, separator), comments)


def _without_comment(line: str) -> str:
    """Return a line without its comment and without blanks around it."""
    if "#" in line:
        match = _BEFORE_COMMENT.match(line)
        line = match[0] if match else line
    line = line.strip(" \r\n\f\v")
    return "" if line.startswith(_COMMENT_LINES) or not line.strip(_ALL_SEPARATORS) else line


def _separator(rows: Sequence[str]) -> str:
    """Return the separator of the rows of a table."""
    return next((sign for sign in _SEPARATORS if _separates(sign, rows)), BLANKS)


def _separates(sign: str, rows: Sequence[str]) -> bool:
    """Return True if a sign separates cells, none of which holds several numbers."""
    if sign == BLANKS or not rows or not all(sign in row for row in rows):
        return False
    for row in rows:
        try:
            cells = split_row(row, sign)
        except csv.Error:
            continue
        if any(_holds_numbers(cell) for cell in cells):
            return False
    return True


def _holds_numbers(cell: str) -> bool:
    """Return True if a cell consists of several numbers with blanks between them."""
    words = cell.split()
    return len(words) > 1 and all(is_number(with_decimal_point(word)) for word in words)


def _decimal(rows: Sequence[str], separator: str) -> str:
    """Return the decimal sign of the rows of a table."""
    if separator == ",":
        return "."
    for row in rows:
        if "," not in row:
            continue
        try:
            cells = split_row(row, separator)
        except csv.Error:  # the reader rejects this row
            continue
        if any(map(_DECIMAL_COMMA.fullmatch, cells)):
            return ","
    return "."
