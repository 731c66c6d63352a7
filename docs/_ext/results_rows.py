"""Stored rows in tables of Markdown: values, differences, bounds and remarks."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from results_chosen import CHOSEN
from results_stored import row_of

from granwave.analysis.document.model import (
    percent,
    significant,
)
from granwave.analysis.formatting.numbers import superscript
from granwave.analysis.formatting.values import ratio_in_words, with_unit
from granwave.analysis.studies.study import Row

_ROUNDING = 1e-12  # relative
_LOWER = ("at least", "more than", "Well over")  # words of a bound below
_MOST_FACTOR = 1000.0  # ratio beyond which its size says nothing
LARGE = 10.0  # deviation from which on a ratio says more than per cent
KINDS = {
    "source": "source",
    "theory": "theory",
    "verification": "verification",
    "alone": "granwave only",
}


def beyond(row: Row) -> float:
    """Return by which fraction of a bound our value exceeds it; 0 within the bound.

    A bound is an upper bound of the magnitude, unless the quantity or the remark calls it a lower
    bound.
    """
    against = row.theory if row.source is None else row.source
    if not row.bound or row.ours is None or not against:
        return 0.0
    over = abs(row.ours / against) - 1
    return max(-over if is_lower_bound(row) else over, 0.0)


def is_lower_bound(row: Row) -> bool:
    """Return True if the quantity or the remark of a row calls its bound a lower bound."""
    return any(words in f"{row.quantity} {row.remark}" for words in _LOWER)


def flagged(row: Row) -> Row:
    """Return a row whose remark states whether the value exceeds its bound."""
    over = beyond(row)
    if not over:
        return row
    return dataclasses.replace(row, remark=f"{row.remark} Beyond the bound by {excess(over)}.")


def excess(over: float) -> str:
    return f"{float(f'{100 * over:.2g}'):g} %" if over < LARGE else factor(over)


def difference(row: Row) -> str:
    """Return the deviation of our value as text; differences by rounding only are omitted."""
    off = row.deviation
    return "-" if off is None else percent(100 * off if abs(off) > _ROUNDING else 0)


def factor(off: float) -> str:
    """Return the text of a very large ratio of our value to the other value."""
    if off + 1 > _MOST_FACTOR:
        return f"more than times {_MOST_FACTOR:g}"
    return f"times {significant(off + 1, 2)}"


def escaped(text: str) -> str:
    """Escape characters with a meaning in tables of Markdown."""
    return re.sub(r"([\\`*_\[\]|~#$<>])", r"\\\1", text)


def chosen_rows(
    stored: Mapping[str, Any], chosen: Sequence[tuple[str, str, str, tuple[str, ...]]] = CHOSEN
) -> Iterator[tuple[str, list[Row]]]:
    """Name and rows of each line of a table; no rows if one of them is missing in the stored
    results.
    """
    for before, suite, study, starts in chosen:
        records = stored["suites"].get(suite, {}).get("studies", {}).get(study, {}).get("rows", ())
        first_rows = [_first_row(records, start) for start in starts]
        rows = [row for row in first_rows if row is not None and row.ours is not None]
        whole = before.endswith(": ") or not before  # then what the quantity is called follows
        name = before + rows[0].quantity if whole and len(starts) == 1 and rows else before
        name = ratio_in_words(name)
        yield name, rows if len(rows) == len(starts) else []


def _first_row(records: Iterable[Mapping[str, Any]], start: str) -> Row | None:
    """Return the first row whose quantity begins with a text; None without one."""
    for record in records:
        if record["quantity"].startswith(start):
            return row_of(record)
    return None


def table_of(lines: Iterable[tuple[str, list[Row]]], links: Sequence[str] = ()) -> str:
    """Return chosen rows as a table, with their remarks as notes below it.

    Parameters
    ----------
    links
        Page to which the quantity of each line is linked.
    """
    heads = ("quantity", "compared with", "value", "granwave", "difference")
    text = [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    remarks: list[str] = []
    for number, (name, rows) in enumerate(lines):
        if rows:
            against = [row.theory if row.source is None else row.source for row in rows]
            values = ", ".join("-" if one is None else significant(one, 5) for one in against)
            ours = ", ".join(significant(row.ours, row.digits) for row in rows)
            off = ", ".join(map(difference, rows))
            unit = rows[0].unit
            what = f"{KINDS[rows[0].kind]}: {rows[0].where}".removesuffix(": ")
            shown = f"[{escaped(name)}]({links[number]})" if links else escaped(name)
            remark = _remark(rows)
            if remark:
                remarks.append(remark)
                off = f"{off} {superscript(len(remarks))}"
            cells = [shown, what, with_unit(values, unit), with_unit(ours, unit), off]
            text.append(f"| {' | '.join(cells)} |")
    for place, remark in enumerate(remarks, 1):
        text += ["", f"{superscript(place)} {escaped(remark)}"]
    return "\n".join(text) + "\n"


def _remark(rows: Sequence[Row]) -> str:
    """Return the remarks of several rows as one remark that contains each sentence once."""
    sentences: list[str] = []
    for row in rows:
        if row.remark:
            sentences += row.remark.removesuffix(".").split(". ")
    return " ".join(f"{sentence}." for sentence in dict.fromkeys(sentences))
