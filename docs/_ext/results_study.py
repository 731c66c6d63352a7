"""Tables of the rows of a study on the page of its suite: bounds, errors of the source, and shared
notes, in addition to what the tables of a report have.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

from results_notes import marked, marks_of, notes_of
from results_rows import KINDS, difference, interval_of, ours_text, reference_text
from results_sources import named

from granwave.analysis.document.model import Cell, DocumentTable, Note
from granwave.analysis.reports.studies import row_tables
from granwave.analysis.studies.study import Row, Study

_CAPTIONS = {
    "source against ours": "compared with the source",
    "theory against ours": "compared with theory",
}
_HEADINGS = {"Ours": "granwave", "Must be": "Reference"}
_OF_ALL = "All rows of this table: "
_NO_PLACE = "ours"  # of a row without a place in a source


def tables_of(study: Study) -> Iterator[DocumentTable | Note]:
    """Iterate over the tables of a study, one for each kind, with the notes on all rows above."""
    bare = tuple(dataclasses.replace(row, remark="") for row in study.rows)
    blocks = row_tables(dataclasses.replace(study, rows=bare))
    tables = [block for block in blocks if isinstance(block, DocumentTable)]
    present = {row.kind for row in study.rows}
    kinds = [kind for kind in KINDS if kind in present]
    for kind, table in zip(kinds, tables, strict=True):
        rows = [row for row in study.rows if row.kind == kind]
        every, notes = notes_of([row.remark for row in rows])
        if every:
            yield Note(f"{_OF_ALL}{every[:1].lower()}{every[1:]}" if _is_short(every) else every)
        yield _completed(table, rows, notes)


def _is_short(text: str) -> bool:
    """Return True for one sentence that can follow a colon in lower case."""
    return text.count(". ") == 0 and text.startswith(("The ", "According ", "In "))


def _completed(
    table: DocumentTable, rows: Sequence[Row], notes: Sequence[Sequence[str]]
) -> DocumentTable:
    """Return a table with the texts of its rows, and with its notes."""
    marks = marks_of(notes)
    headings = [column.heading for column in table.columns]
    cells = []
    for row, of_row, before in zip(rows, notes, table.rows, strict=True):
        found = dict(zip(headings, before, strict=True))
        found |= _texts(row, found)
        name = found["Quantity"].text
        shown = " ".join([name, *marked(of_row, marks)])
        found["Quantity"] = Cell(shown, name)
        cells.append(tuple(found[heading] for heading in headings))
    columns = tuple(
        dataclasses.replace(column, heading=_HEADINGS.get(column.heading, column.heading))
        for column in table.columns
    )
    caption = table.caption
    for before_words, words in _CAPTIONS.items():
        caption = caption.replace(before_words, words)
    footnotes = tuple(f"{mark} {note}" for note, mark in marks.items())
    return dataclasses.replace(
        table, caption=caption, columns=columns, rows=tuple(cells), footnotes=footnotes
    )


def _texts(row: Row, found: dict[str, Cell]) -> dict[str, Cell]:
    """Return the cells of a row that differ from a report: bounds, errors, digits and places."""
    texts: dict[str, Cell] = {}
    if row.ours is not None:
        texts["Ours"] = Cell(ours_text(row), row.ours)
        if row.bound or row.deviation is not None:
            texts["Difference"] = Cell(difference(row), row.deviation)
    if interval_of(row):
        texts["Source"] = Cell(reference_text(row), row.source)
    if "Where" in found:
        texts["Where"] = Cell("" if row.where == _NO_PLACE else named(row.where))
    return texts
