"""Sentences on values of summaries, and tables with a row for each value."""

from __future__ import annotations

import contextlib
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

from granwave.analysis.document.model import (
    BLANK,
    Cell,
    DocumentTable,
    TableColumn,
    is_number,
    value_cell,
)
from granwave.analysis.formatting.numbers import plain, range_in
from granwave.analysis.quantities import quantity
from granwave.analysis.reports.kinds import ReportRun

_SHOWN_IN = {"Hz": ("kHz", 1e-3), "Pa": ("GPa", 1e-9), "m": ("mm", 1e3)}
# fractions below are rounding errors
_PER_CENT = 100.0
_ROUNDING = 1e-9


def by_part(runs: Sequence[ReportRun]) -> list[list[ReportRun]]:
    """Return the runs without an energy balance, grouped by kind and part."""
    parts: dict[tuple[str, str], list[ReportRun]] = {}
    for run in runs:
        if not run.has_balance:
            parts.setdefault((run.kind.result_kind, run.kind.part(run)), []).append(run)
    return list(parts.values())


def value_table(runs: Sequence[ReportRun], caption: str) -> DocumentTable:
    """Make a table of the main values of runs of one kind: a row for each value that occurs, a
    column for each run.
    """
    kind = runs[0].kind
    rows = []
    for key in kind.table_keys:
        label = kind.label(runs[0], key)
        unit = quantity(key).unit
        if key in kind.in_per_cent:
            unit = "%"
            scale = _PER_CENT
        else:
            unit, scale = _SHOWN_IN.get(unit, (unit, 1.0))
        cells = [_span_cell(run.summary.get(key), scale) for run in runs]
        rows.append((Cell(label, label), *cells, Cell(unit)))
    heads = [run.label for run in runs] if len(runs) > 1 else ["Value"]
    columns = (
        TableColumn("Quantity", key=True),
        *(TableColumn(head, numeric=True) for head in heads),
        TableColumn("Unit"),
    )
    kept = tuple(row for row in rows if _has_value(row))
    return DocumentTable(caption, columns, kept, captioned=len(runs) > 1, by_row=True)


def _has_value(row: Sequence[Cell]) -> bool:
    """Return True if a row between its label and its unit is not blank."""
    return any(cell.text != BLANK for cell in row[1:-1])


def _span_cell(value: Any, scale: float) -> Cell:
    """Return the cell of a number, or of the range of several."""
    values = _numbers(value)
    if not values:
        return value_cell(None)
    if scale == _PER_CENT and 0 < max(values) < _ROUNDING:
        return Cell(f"< {plain(f'{scale * _ROUNDING:.0e}')}", max(values))
    if scale != 1:
        values = [number * scale for number in values]
    low = value_cell(min(values))
    high = value_cell(max(values))
    return low if low.text == high.text else Cell(f"{low.text} to {high.text}", low.value)


def _numbers(value: Any) -> list[Any]:
    """Return the numbers of a value, which may be a list."""
    return [one for one in (value if isinstance(value, list) else [value]) if is_number(one)]


def sentences(texts: Iterable[str], values: Mapping[str, str]) -> str:
    """Return the sentences whose values are all known, with these values."""
    known = []
    for text in texts:
        with contextlib.suppress(KeyError):
            known.append(text.format_map(values))
    return " ".join(known)


def printed(summary: Mapping[str, Any], in_per_cent: Collection[str] = ()) -> dict[str, str]:
    """Return the numbers of a summary by key, with units, shares in per cent, and lists as ranges.

    Parameters
    ----------
    in_per_cent
        Fractions that are not recognised by their names.
    """
    texts = {}
    for key, value in summary.items():
        numbers = _numbers(value)
        if not numbers:
            continue
        if key in in_per_cent or key.endswith("_fraction") or key == "transmission":
            texts[key] = " to ".join(dict.fromkeys(map(share, (min(numbers), max(numbers)))))
        else:
            texts[key] = (
                str(value) if isinstance(value, int) else range_in(numbers, quantity(key).unit)
            )
    return texts


def share(value: float) -> str:
    """Return a fraction in per cent, with three digits; 0 for rounding errors."""
    return f"{plain(f'{100 * value:.3g}')} %" if abs(value) > _ROUNDING else "0 %"
