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
_NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w])")
# numbers that one note lists
_LEAST = 3
_MOST = 12
_IN_ORDER = "in the order of the rows with this note"
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
    return " ".join(every), _listed([_notes(remark, rows_of, every) for remark in remarks])


def _listed(notes: Sequence[Sequence[str]]) -> list[list[str]]:
    """Return the notes of each row, with one note for notes that differ by one number."""
    groups: dict[str, list[str]] = {}
    for note in itertools.chain.from_iterable(notes):
        groups.setdefault(_NUMBER.sub("{}", note), []).append(note)
    joined: dict[str, str] = {}
    for group in groups.values():
        if len(set(group)) < _LEAST or len(group) > _MOST:
            continue
        if text := _with_list(group):
            joined |= dict.fromkeys(group, text)
    listed: list[list[str]] = []
    for of_row in notes:
        listed.append([joined.get(note, note) for note in of_row])
    return listed


def _with_list(notes: Sequence[str]) -> str:
    """Return a note with the numbers of all rows where the notes differ; empty if they differ by
    several numbers.
    """
    columns = list(zip(*map(_NUMBER.findall, notes), strict=True))
    varying = [place for place, numbers in enumerate(columns) if len(set(numbers)) > 1]
    if len(varying) != 1:
        return ""
    found = list(_NUMBER.finditer(notes[0]))[varying[0]]
    numbers = ", ".join(columns[varying[0]])
    text = f"{notes[0][: found.start()]}{numbers}{notes[0][found.end() :]}"
    return f"{text.removesuffix('.')} ({_IN_ORDER})."


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
