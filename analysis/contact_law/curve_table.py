"""Tables of measured curves from testing machines and spreadsheets.

Titles may be above the names of the columns, a row of units below these; a unit may also be in the
name: ``overlap_um``, ``Displacement (mm)``, ``Load [kN]``.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from granwave.lammps_inputs.tables.layout import (
    Layout,
    Row,
    is_number,
    layout_from,
    read_layout,
    rows_of,
)
from granwave.lammps_inputs.tables.units import split_unit, unit_of

_QUANTITIES = {
    "overlap": "overlap",
    "displacement": "displacement",
    "extension": "displacement",
    "force": "force",
    "load": "force",
}
_LENGTHS = ("overlap", "displacement")
_LARGEST_TITLE = 20  # rows that may be above the names of the columns


def read_curve_rows(path: Path) -> list[Row]:
    """Read the rows of a curve; the first has the names of the columns with their units, such as
    ``displacement_mm``; other names are unchanged.

    Raises
    ------
    InputError
        The file cannot be read, is not text, or has a line that cannot be parsed.
    """
    rows = _rows_from_names(read_layout(path), path)
    if not rows:
        return []
    line, heads = rows[0]
    units = _units_below(rows)
    names = [_name_with_unit(head, unit) for head, unit in zip(heads, units, strict=True)]
    if any(names.count(name) > 1 for name in names if name not in heads):
        names = [head.strip() for head in heads]  # two columns match
    return [(line, names), *rows[1 + int(any(units)) :]]


def _rows_from_names(layout: Layout, path: Path) -> list[Row]:
    """Return the rows from the first row that names a length and a force; all rows if none does."""
    for row in range(min(len(layout.rows), _LARGEST_TITLE)):
        below = layout_from(layout, row)
        try:
            words = [
                _quantity(head.partition("_")[0]) or _quantity(head) for head in below.cells(0)
            ]
        except ValueError:  # rows that are not CSV are rejected by the reader
            continue
        if "force" in words and not set(words).isdisjoint(_LENGTHS):
            return rows_of(below, path)
    return rows_of(layout, path)


def _quantity(head: str) -> str:
    """Return the quantity of a column; empty for other quantities."""
    return _QUANTITIES.get(split_unit(head.strip())[0].strip().lower(), "")


def _units_below(rows: Sequence[Row]) -> list[str]:
    """Return the units in a row below the names; empty units without such a row."""
    heads = rows[0][1]
    cells = rows[1][1] if len(rows) > 1 else []
    if len(cells) != len(heads) or any(map(is_number, cells)):
        return [""] * len(heads)
    has_unit = [
        bool(_quantity(head)) and bool(unit_of(cell))
        for head, cell in zip(heads, cells, strict=True)
    ]
    if sum(has_unit) < 2 or any(split_unit(head)[1] for head in heads):
        return [""] * len(heads)
    return [unit_of(cell) for cell in cells]


def _name_with_unit(head: str, unit: str) -> str:
    """Return the name of a column with its unit, of a length or a force."""
    head = head.strip()
    quantity = _quantity(head)
    unit = split_unit(head)[1] or unit
    if not quantity or not unit:
        return head
    return f"{quantity}_{unit}"
