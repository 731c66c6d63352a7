"""Conclusions at the top of the pages of results: the text of ``reproductions/conclusions.md``,
whose numbers come from the stored rows, and the numbers of rows that agree.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator, Mapping
from typing import Any

from results_rows import KINDS, beyond, excess, holds, reference_text, without_power
from results_stored import ROOT, row_of

from granwave.analysis.document.model import significant
from granwave.analysis.formatting.values import with_unit
from granwave.analysis.studies.study import Row

FILE = ROOT / "reproductions" / "conclusions.md"
CLOSE = 0.1  # largest relative deviation that counts as agreement
_COLUMNS = 100
_DIGITS = 4  # of a number in a conclusion
_BEFORE_UNIT = re.compile(r"(?<=\d) (?=\S)")
_FIELD = re.compile(r"\{(?P<word>\w+) (?P<rest>[^{}]+)\}")
_OF_KINDS = {
    "source": "rows with a value of the source",
    "theory": "rows with a value of theory",
    "verification": "verifications of the code",
}


def read_conclusions() -> dict[str, str]:
    """Return the text of each suite, with its fields."""
    _, *sections = re.split(r"^## ", FILE.read_text(encoding="utf-8"), flags=re.MULTILINE)
    parts = [section.partition("\n") for section in sections]
    return {name.strip(): text.strip() for name, _, text in parts}


def conclusion_of(name: str, suite: Mapping[str, Any]) -> str:
    """Return the conclusion of a suite with its numbers, and the numbers of rows that agree."""
    text = _FIELD.sub(lambda field: _filled(field, suite), read_conclusions()[name])
    return "\n\n".join(_wrapped(part) for part in (text, agreement_of(suite)) if part)


def _wrapped(text: str) -> str:
    """Return a paragraph in lines that do not end between a number and its unit."""
    kept = _BEFORE_UNIT.sub("\0", text)
    filled = textwrap.fill(kept, _COLUMNS, break_long_words=False, break_on_hyphens=False)
    return filled.replace("\0", " ")


def agreement_of(suite: Mapping[str, Any]) -> str:
    """Return the numbers of rows within 10 %, and of bounds that hold; empty without any."""
    parts = []
    for kind, words in _OF_KINDS.items():
        if deviations := _deviations(suite, kind):
            parts.append(f"{_within(deviations)} {words}")
    sentences = [f"Within 10 %: {', '.join(parts)}."] if parts else []
    if bounds := bounds_of(suite):
        sentences.append(f"Bounds that hold: {sum(map(holds, bounds))} of {len(bounds)}.")
    return " ".join(sentences)


def bounds_of(suite: Mapping[str, Any]) -> list[Row]:
    """Return the rows of a suite with a bound in place of a value."""
    return [row for _, row in _rows(suite) if row.bound]


def _rows(suite: Mapping[str, Any]) -> Iterator[tuple[str, Row]]:
    """Iterate over the names of studies with their rows."""
    for name, study in suite["studies"].items():
        for record in study["rows"]:
            yield name, row_of(record)


def _deviations(suite: Mapping[str, Any], kind: str, study: str = "") -> list[float]:
    """Return the magnitude of the deviation of each row of a kind, of one study if it is named."""
    if kind not in KINDS or study not in ("", *suite["studies"]):
        raise ValueError(f"found {kind} {study}, expected a kind of rows and a study of the suite")
    rows = [row for name, row in _rows(suite) if row.kind == kind and study in ("", name)]
    return [abs(row.deviation) for row in rows if row.deviation is not None]


def _within(deviations: list[float]) -> str:
    """Return the number of deviations that count as agreement, of all."""
    return f"{sum(off <= CLOSE for off in deviations)} of {len(deviations)}"


def _filled(field: re.Match[str], suite: Mapping[str, Any]) -> str:
    """Return the text of a field."""
    if field["word"] == "within":
        return _within(_deviations(suite, *field["rest"].split()))
    if field["word"] == "most":
        return _percent(max(_deviations(suite, *field["rest"].split())))
    study, _, start = field["rest"].partition(" | ")
    row = _first(suite, study, start)
    if field["word"] == "ours":
        assert row.ours is not None
        digits = min(row.digits, _DIGITS)
        return with_unit(without_power(significant(row.ours, digits)), row.unit)
    if field["word"] == "reference":
        return with_unit(reference_text(row).partition(" ±")[0], row.unit)
    if field["word"] == "off":
        return excess(beyond(row)) if row.bound else _percent(abs(row.deviation or 0.0))
    raise ValueError(f"found {field[0]}, expected within, most, ours, reference or off")


def _first(suite: Mapping[str, Any], study: str, start: str) -> Row:
    """Return the first row whose quantity begins with a text, with a source rather than theory, and
    with theory rather than a verification.
    """
    rows = [row for name, row in _rows(suite) if name == study and row.quantity.startswith(start)]
    if not rows:
        raise ValueError(f"found no row {start!r} in the study {study}")
    return min(rows, key=lambda row: list(KINDS).index(row.kind))


def _percent(off: float) -> str:
    """Return a deviation in per cent with two digits."""
    return f"{without_power(significant(100 * off, 2))} %"
