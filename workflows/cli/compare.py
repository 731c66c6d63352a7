"""Command that compares runs; it returns the exit status."""

from __future__ import annotations

import argparse
import re
import textwrap
from typing import TYPE_CHECKING

from granwave.workflows.cli.commands import chosen
from granwave.workflows.cli.results import as_wrong_input
from granwave.workflows.cli.terminal import columns

if TYPE_CHECKING:
    from collections.abc import Sequence

    from granwave.analysis.document.model import Cell
    from granwave.analysis.reports.comparison.compared_value import ComparedValue
    from granwave.analysis.reports.comparison.comparison import Comparison

_MOST_VALUES = 12  # rows at the terminal
_MOST_KEYS = 12
_MOST_RUNS = 6  # most runs with a column each
_WIDEST = 32  # characters of a cell
_LINE = 100  # characters of a line of the sentences
_NO_BREAK = "\u00a0"


def compare(options: argparse.Namespace) -> int:
    """Execute ``granwave compare``."""
    from granwave.analysis.reports.comparison.page import write_comparison

    with as_wrong_input():
        comparison, page = write_comparison(**chosen(options, write_comparison))
    print(text_of(comparison))
    print(page)
    return 0


def text_of(comparison: Comparison) -> str:
    """Return sentence, notes and tables for the terminal, with an empty line at the end."""
    sentences = [*comparison.paragraphs, *comparison.grouped_notes]
    parts = list(map(_wrapped, sentences))
    parts += _misfits(comparison)
    if len(comparison.runs) <= _MOST_RUNS:
        parts += [_values(comparison), _differences(comparison)]
    return "\n\n".join(part for part in parts if part) + "\n"


def _wrapped(text: str) -> str:
    """Return a paragraph in lines of at most 100 columns; no line ends between a number and its
    unit.
    """
    joined = re.sub(r"(?<=\d) (?=[^\W\d_]|[%°‡])", _NO_BREAK, text)
    lines = textwrap.wrap(joined, _LINE, break_long_words=False, break_on_hyphens=False)
    return "\n".join(lines).replace(_NO_BREAK, " ")


def _values(comparison: Comparison) -> str:
    """Return the table of the values that differ most, with their keys in the last column."""
    from granwave.analysis.reports.comparison.values import shown_values

    values = shown_values(
        comparison.values,
        _MOST_VALUES,
        asked=bool(comparison.quantities),
        stated=comparison.stated_names,
    )
    if not values:
        return ""
    names = [_cut(run.name) for run in comparison.runs]
    has_ratio = len(names) > 1
    ratio = ["ratio"] if has_ratio else []
    rows = [["quantity", "unit", *names, *ratio, "key"]]
    for value in values:
        numbers = [_number(value, place) for place in range(len(value.values))]
        ratio = [_ratio(value)] if has_ratio else []
        rows.append([value.label, value.unit, *numbers, *ratio, value.name])
    return columns(rows, left=(0, 1, len(rows[0]) - 1))


def _number(value: ComparedValue, place: int) -> str:
    """Return a value of the run at a position, with a mark if the end of the run truncates it."""
    from granwave.analysis.formatting.numbers import interval
    from granwave.analysis.measures.law_range import BEYOND_LAW
    from granwave.analysis.reports.comparison.compared_value import MARK

    number = value.values[place]
    if number is None:
        return ""
    if error := value.error_at(place):
        return interval(number, error)
    beyond = f" {BEYOND_LAW}" if place in value.beyond_law else ""
    return f"{number:.5g}{MARK if place in value.marked_places else ''}{beyond}"


def _ratio(value: ComparedValue) -> str:
    """Return the ratio of a value, or the word in its place."""
    return value.without_ratio if value.ratio is None else f"{value.ratio:.3g}"


def _differences(comparison: Comparison) -> str:
    """Return the table of the differences between the cases; of physical keys only,
    if any differ.
    """
    physical = [row for row in comparison.case_rows if not row.is_numerical]
    chosen_rows = physical or comparison.case_rows
    if not chosen_rows:
        return ""
    rows = [["in the cases", *(_cut(run.name) for run in comparison.runs)]]
    rows += [[row.what, *map(_cut, row.values)] for row in chosen_rows[:_MOST_KEYS]]
    left = len(chosen_rows) - _MOST_KEYS
    text = columns(rows, left=range(len(rows[0])))
    return f"{text}\nand {left} more, on the page" if left > 0 else text


def _misfits(comparison: Comparison) -> list[str]:
    """Return a table of the differences from each measured curve."""
    from granwave.analysis.reports.comparison.blocks import misfit_tables

    tables: list[str] = []
    for table in misfit_tables(comparison):
        heads = [table.caption, *(column.heading for column in table.columns[1:])]
        rows = [_texts(row) for row in table.rows]
        tables.append(columns([heads, *rows], left=(0,)))
    return tables


def _texts(row: Sequence[Cell]) -> list[str]:
    return [cell.text for cell in row]


def _cut(text: str) -> str:
    return text if len(text) <= _WIDEST else f"{text[: _WIDEST - 1]}…"
