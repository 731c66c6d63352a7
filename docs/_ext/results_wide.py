"""Wide tables of the pages of results as several tables that fit into a page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from granwave.analysis.document.model import Cell, DocumentTable

MOST = 9  # columns of a table on the page of a suite


def parts_of(table: DocumentTable) -> Iterator[DocumentTable]:
    """Iterate over tables with at most `MOST` columns; each begins with the columns that tell the
    rows apart.
    """
    width = len(table.columns)
    keys = number_of_keys(table)
    rest = range(keys, width)
    if width <= MOST or keys >= MOST - 1:
        yield table
        return
    number = -(-len(rest) // (MOST - keys))  # rounded up
    size = -(-len(rest) // number)
    for part in range(number):
        columns = rest[part * size : (part + 1) * size]
        caption = f"{table.caption} ({part + 1} of {number})"
        yield table.keeping([*range(keys), *columns], caption=caption)


def number_of_keys(table: DocumentTable) -> int:
    """Return the number of first columns whose values are distinct for all rows."""
    for number in range(1, len(table.columns)):
        first = table.keeping(range(number)).rows
        if len(set(map(_texts, first))) == len(first):
            return number
    return len(table.columns)


def _texts(row: Sequence[Cell]) -> tuple[str, ...]:
    return tuple(cell.text for cell in row)
