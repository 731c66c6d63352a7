"""Remarks of rows as notes below a table: sentences that several rows share are one note, and
sentences that all rows share are above the table.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping, Sequence

from granwave.analysis.formatting.numbers import superscript

#: End of a sentence, not of an abbreviation such as "Fig."
_END = re.compile(r"(?<!\bFig)(?<!\bFigs)(?<!\bEq)(?<!\beq)(?<!\bal)(?<=[.])\s+(?=[A-Z0-9])")
#: Words that refer to the sentence before.
_REFERRING = ("It ", "Its ", "This ", "That ", "These ", "They ", "Their ", "Such ", "There ")


def sentences_of(remark: str) -> list[str]:
    """Return the sentences of a remark; a sentence that refers to the one before stays with it."""
    found: list[str] = []
    for sentence in _END.split(remark.strip()):
        if found and sentence.startswith(_REFERRING):
            found[-1] += f" {sentence}"
        elif sentence:
            found.append(sentence)
    return found


def notes_of(remarks: Sequence[str], *, above: bool = True) -> tuple[str, list[list[str]]]:
    """Return the note on all rows, empty if there is none, and the notes of each row.

    Parameters
    ----------
    remarks
        Remark of each row; empty without one.
    above
        False if there is no place for notes on all rows.
    """
    rows_of: dict[str, set[str]] = {}
    for remark in remarks:
        for sentence in sentences_of(remark):
            rows_of.setdefault(sentence, set()).add(remark)
    every: list[str] = []
    if above and len(remarks) > 1:
        distinct = set(remarks)
        every = [sentence for sentence, found in rows_of.items() if found == distinct]
    return " ".join(every), [_notes(remark, rows_of, every) for remark in remarks]


def _notes(remark: str, rows_of: Mapping[str, set[str]], left_out: Sequence[str]) -> list[str]:
    """Return the sentences of a remark, joined where the same rows have them."""
    joined: dict[frozenset[str], list[str]] = {}
    for sentence in sentences_of(remark):
        if sentence not in left_out:
            joined.setdefault(frozenset(rows_of[sentence]), []).append(sentence)
    return [" ".join(sentences) for sentences in joined.values()]


def marks_of(notes: Sequence[Sequence[str]]) -> dict[str, str]:
    """Return the mark of each note, in the order of the rows."""
    distinct = dict.fromkeys(itertools.chain.from_iterable(notes))
    return {note: superscript(place) for place, note in enumerate(distinct, 1)}


def marked(notes: Sequence[str], marks: Mapping[str, str]) -> list[str]:
    """Return the marks of the notes of a row, in ascending order."""
    return [mark for note, mark in marks.items() if note in notes]
