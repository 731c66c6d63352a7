"""Stored rows in tables of Markdown: values, differences, bounds and remarks."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from results_chosen import CHOSEN
from results_notes import marked, marks_of, notes_of
from results_sources import linked, named
from results_stored import row_of

from granwave.analysis.document.model import (
    percent,
    significant,
)
from granwave.analysis.formatting.numbers import plain
from granwave.analysis.formatting.values import ratio_in_words, with_unit
from granwave.analysis.studies.study import Row

_ROUNDING = 1e-12  # relative
_LOWER = ("at least", "more than", "Well over", "well above")  # words of a bound below
_MOST_FACTOR = 1000.0  # ratio beyond which its size says nothing
_DIGITS = 5  # of a value of a source
_MOST_SHOWN = 4  # digits of our value that are added to show its deviation
_SHOWN = 0.05  # largest error of the deviation of the rounded value, relative to the deviation
_SMALL = 0.01  # relative; smaller deviations are shown to a quarter of themselves
_SHOWN_OF_SMALL = 0.25
_PLAIN = 1e7  # from which on a number has a power of ten
_WITH_POWER = re.compile(r"-?[\d.]+e\+?\d+")
_INTERVAL = re.compile(r"measured \w+ is (?:[\d.]+ )?± (\d+(?:\.\d+)?)")
#: Quantities with values on both sides of zero, where a relative difference has no meaning.
_OF_BOTH_SIGNS = re.compile(r"\brebound\b|\brestitution of the surface\b", re.IGNORECASE)
#: Sentences of remarks that a name with these words makes superfluous.
_IN_NAME = {"The value was measured on glass.": " on glass"}
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


def holds(row: Row) -> bool:
    """Return True if our value lies within the bound of a row."""
    return not beyond(row)


def excess(over: float) -> str:
    return f"{float(f'{100 * over:.2g}'):g} %" if over < LARGE else factor(over)


def difference(row: Row) -> str:
    """Return the deviation of our value as text; differences by rounding only are omitted.

    For a bound the text states whether our value lies within it. If the source states the error of
    its value, the text compares the difference with the error. A quantity with values on both sides
    of zero has an absolute difference, in its unit.
    """
    if row.bound and row.ours is not None:
        return "within" if holds(row) else f"beyond by {excess(beyond(row))}"
    off = row.deviation
    if off is None:
        return "-"
    if has_both_signs(row.quantity):
        return absolute_difference(row)
    if off > LARGE:
        return factor(off)
    text = percent(100 * off if abs(off) > _ROUNDING else 0)
    error = interval_of(row)
    if not error or row.ours is None or row.source is None:
        return text
    ratio = abs(row.ours - row.source) / float(error)
    if ratio <= 1:
        return f"{text} (within the error)"
    return f"{text} ({significant(ratio, 2)} times the error)"


def has_both_signs(quantity: str) -> bool:
    """Return True for a quantity with values on both sides of zero, such as a rebound angle."""
    return bool(_OF_BOTH_SIGNS.search(quantity))


def absolute_difference(row: Row) -> str:
    """Return our value minus the reference, with its sign and unit, or with a word in place of a
    unit.
    """
    against = row.theory if row.source is None else row.source
    assert row.ours is not None and against is not None
    text = plain(f"{row.ours - against:+.3g}")
    return with_unit(text, row.unit) if row.unit else f"{text} (absolute)"


def factor(off: float) -> str:
    """Return the text of a very large ratio of our value to the other value."""
    if off + 1 > _MOST_FACTOR:
        return f"more than {_MOST_FACTOR:g} times"
    return f"{significant(off + 1, 2)} times"


def interval_of(row: Row) -> str:
    """Return the half-width of the error of the source, as printed; empty if it states none."""
    found = _INTERVAL.search(row.remark or "")
    return found[1] if found and row.source is not None else ""


def reference_text(row: Row) -> str:
    """Return the value of the source, with its error, or of theory."""
    against = row.theory if row.source is None else row.source
    if against is None:
        return "-"
    if error := interval_of(row):
        decimals = len(error.partition(".")[2])
        return f"{against:.{decimals}f} ± {error}"
    return without_power(significant(against, _DIGITS))


def ours_text(row: Row) -> str:
    """Return our value with its meaningful digits, or with as many more as show its deviation."""
    assert row.ours is not None
    return without_power(significant(row.ours, shown_digits(row)))


def shown_digits(row: Row) -> int:
    """Return the number of digits of our value with which it shows its deviation.

    With few digits the rounded value can contradict the deviation, as 1 and +0.7 % do. Deviations
    that only more than `_MOST_SHOWN` digits would show are left to the text of the difference.
    """
    off = row.deviation
    against = row.theory if row.source is None else row.source
    if off is None or against is None or row.ours is None:
        return row.digits
    error = _SHOWN if abs(off) > _SMALL else _SHOWN_OF_SMALL
    for digits in range(row.digits, _MOST_SHOWN + 1):
        shown = float(f"{row.ours:.{digits}g}") / against - 1
        if abs(shown - off) <= error * abs(off):
            return digits
    return row.digits


def without_power(text: str) -> str:
    """Return a number from 1 to 1e7 without a power of ten."""
    if _WITH_POWER.fullmatch(text) and abs(float(text)) < _PLAIN:
        return f"{float(text):.0f}"
    return text


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


def _remark(name: str, row: Row) -> str:
    """Return the remark of a row without sentences that only repeat its name."""
    remark = row.remark
    for sentence, words in _IN_NAME.items():
        if words in name:
            remark = remark.replace(sentence, "").strip()
    return remark


def table_of(
    lines: Iterable[tuple[str, list[Row]]], links: Sequence[str] = (), sources: str = ""
) -> str:
    """Return chosen rows as a table, with their remarks as notes below it.

    Parameters
    ----------
    links
        Page to which the quantity of each line is linked.
    sources
        Page with the bibliography, to which the names of sources are linked; empty for the same
        page.
    """
    heads = ("quantity", "compared with", "value", "granwave", "difference")
    text = [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    entries: list[tuple[int, str, Row]] = []
    for number, (name, rows) in enumerate(lines):
        entries += [(number, name, row) for row in rows]
    _, notes = notes_of([_remark(name, row) for _, name, row in entries], above=False)
    marks = marks_of(notes)
    for (number, name, row), of_row in zip(entries, notes, strict=True):
        place = linked(named(row.where), sources)
        what = f"{KINDS[row.kind]}: {place}".removesuffix(": ")
        shown = f"[{escaped(name)}]({links[number]})" if links else escaped(name)
        values = [with_unit(value, row.unit) for value in (reference_text(row), ours_text(row))]
        off = " ".join([difference(row), *marked(of_row, marks)])
        text.append(f"| {' | '.join([shown, what, *values, off])} |")
    for note, mark in marks.items():
        text += ["", f"{mark} {escaped(note)}"]
    return "\n".join(text) + "\n"
