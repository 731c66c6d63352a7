"""Trajectories in XYZ and extended XYZ, for example of OVITO and ASE: a number of grains, a
comment, and a row for each grain.

The comment of extended XYZ names the columns (``Properties=species:S:1:pos:R:3:radius:R:1``) and
has the box (``Lattice``, ``Origin``, ``pbc``). Plain XYZ has the name of a type and x, y, z, unless
its comment is a list of names; further columns have no names.

https://www.ovito.org/manual/reference/file_formats/input/xyz.html
"""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.message_words import show
from granwave.lammps_inputs.readers.columns import (
    PLACE,
    RADIUS,
    TYPE,
    ColumnReader,
    find_columns,
    gives_sizes,
    quantity_of,
)
from granwave.lammps_inputs.readers.grain_table import GrainTable
from granwave.lammps_inputs.readers.source import GrainSource
from granwave.lammps_inputs.tables.layout import BLANKS, Layout, is_number, with_plain_exponents
from granwave.lammps_inputs.tables.text_table import table_of
from granwave.lammps_inputs.tables.units import in_si

NAME = "xyz"
LABEL = "XYZ"
_N_OF_HEAD = 2  # lines above the rows of a frame
_ENTRY = re.compile(r'(\w+)=("[^"]*"|\S+)')
_PROPERTIES = "Properties"
_PARTS_OF_PROPERTY = 3  # name, kind, number of columns
_SINGULAR = {"materials": "material", "groups": "group", "shapes": "shape", "lengths": "length"}
_FRACTION = re.compile(r"\s*[-+]?[0-9]*\.[0-9]")  # a place, in the column of the types
_TRUE = ("T", "1", "TRUE")
_STRAIGHT = 1e-9  # components of the edges of a box across its axes, over its largest edge


def recognises(source: GrainSource) -> bool:
    """Return True for a number of rows, a comment, and a row with a position."""
    lines = source.head.splitlines()[: _N_OF_HEAD + 1]
    if len(lines) <= _N_OF_HEAD or not lines[0].strip().isdigit():
        return False
    comment = lines[1].split()
    row = lines[2].split()
    if f"{_PROPERTIES}=" in lines[1]:
        return True
    is_row = len(comment) == len(row) and all(map(is_number, comment))
    return not is_row and sum(map(is_number, row)) >= len(PLACE)


def read(source: GrainSource) -> GrainTable:
    """Read a frame, by default the last; the step is its number, from 0.

    Raises
    ------
    ValueError
        There is no such frame, it is truncated, or its grains have no positions or sizes.
    """
    options = source.options
    lines = source.text.splitlines()
    starts = _starts(lines)
    chosen = len(starts) - 1 if options.step is None else options.step
    if chosen >= len(starts):
        raise ValueError(
            f"found no step {options.step} (packing.step), expected one from 0 to {len(starts) - 1}"
        )
    start = starts[chosen]
    n_rows = int(lines[start])
    first = start + _N_OF_HEAD
    rows = with_plain_exponents(lines[first : first + n_rows])
    layout = Layout(range(first + 1, first + 1 + n_rows), rows, BLANKS, ".")
    entries = dict(_ENTRY.findall(lines[start + 1]))
    heads = list(options.heads) or _heads(entries, lines[start + 1].split(), layout)
    table = table_of(layout, heads, start + _N_OF_HEAD)
    notes: list[str] = []
    columns = find_columns(table, options, notes, repeated=True)
    missing = [name for name in PLACE if name not in columns]
    if missing:
        raise ValueError(
            f"line {start + _N_OF_HEAD}: found no {missing[0]} among the columns "
            f"{' '.join(heads)}; packing.columns can name it"
        )
    if not gives_sizes(columns, options):
        raise ValueError(
            f"line {start + _N_OF_HEAD}: found no diameters among the columns {_shown(heads)}, "
            "expected a property radius or diameter, a list of all names such as "
            f"packing.columns = {show([TYPE, *PLACE, RADIUS])}, or packing.diameter for all grains"
        )
    form = f"{LABEL}, frame {chosen}"
    if len(starts) > 1:
        form += f" of {len(starts)}"
    grains = ColumnReader(table, columns, options).grains(form, notes)
    _add_box(grains, entries, options.power())
    return grains


def _starts(lines: list[str]) -> list[int]:
    """Return the first line, from 0, of each frame; raise ValueError if one is truncated."""
    starts: list[int] = []
    k = 0
    while k < len(lines):
        word = lines[k].strip()
        if not word:
            k += 1
            continue
        if not word.isdigit():
            raise ValueError(
                f"line {k + 1}: found {show(word)}, expected the number of grains of a frame"
            )
        n_rows = int(word)
        n_there = len(lines) - k - _N_OF_HEAD
        if n_there < n_rows or not n_rows:
            raise ValueError(
                f"line {k + 1}: found {max(n_there, 0)} of {n_rows} grains: the file is truncated"
            )
        starts.append(k)
        k += _N_OF_HEAD + n_rows
    return starts


def _heads(entries: dict[str, str], comment: list[str], layout: Layout) -> list[str]:
    """Return the names of the columns; names after the positions of plain XYZ are empty."""
    if _PROPERTIES in entries:
        return _heads_of_properties(entries[_PROPERTIES].strip('"'))
    n_columns = len(layout.cells(0))
    quantities = {quantity_of(word)[0] for word in comment}
    if len(comment) == n_columns and {*PLACE} <= quantities:
        return comment
    has_types = n_columns > len(PLACE) and not _FRACTION.match(layout.rows[0])
    heads = [TYPE, *PLACE] if has_types else list(PLACE)
    return [*heads, *[""] * (n_columns - len(heads))]


def _heads_of_properties(text: str) -> list[str]:
    """Return the names of the columns of ``name:kind:n`` for each property."""
    words = text.split(":")
    n_properties, rest = divmod(len(words), _PARTS_OF_PROPERTY)
    counts = words[2::_PARTS_OF_PROPERTY]
    if rest or not all(count.isdigit() for count in counts):
        raise ValueError(f"found {_PROPERTIES}={text}, expected name:kind:n for each property")
    heads: list[str] = []
    for k in range(n_properties):
        name = words[_PARTS_OF_PROPERTY * k]
        name = _SINGULAR.get(name, name)
        n = int(counts[k])
        letters = "xyz" if n == len(PLACE) else range(n)
        heads += [name] if n == 1 else [f"{name}_{letter}" for letter in letters]
    return heads


def _shown(heads: list[str]) -> str:
    """Return names of columns in words."""
    n_unnamed = heads.count("")
    more = f" and {n_unnamed} without a name" if n_unnamed else ""
    return " ".join(head for head in heads if head) + more


def _add_box(grains: GrainTable, entries: dict[str, str], power: float) -> None:
    """Add the vectors of the periodic cell, and the box if its edges are along the axes."""
    edges = _numbers(entries, "Lattice", 9)
    if edges is None:
        return
    cell = in_si(edges.reshape(3, 3), power)
    origin = _numbers(entries, "Origin", 3)
    low = np.zeros(3) if origin is None else in_si(origin, power)
    flags = entries.get("pbc", '"T T T"').strip('"').upper().split()
    repeats = [flag in _TRUE for flag in flags] if len(flags) == len(PLACE) else [True] * 3
    grains.cell = [
        vector.tolist()
        for vector, there in zip(cell, repeats, strict=True)
        if there and any(vector)
    ]
    slant = np.abs(cell - np.diag(np.diag(cell))).max()
    is_straight = slant <= _STRAIGHT * np.abs(cell).max()
    if all(repeats[:2]) and is_straight and min(cell[0, 0], cell[1, 1]) > 0:
        grains.bounds = np.stack([low, low + np.diag(cell)], axis=1)
        grains.periodic = repeats[0], repeats[1], repeats[2]


def _numbers(entries: dict[str, str], name: str, n: int) -> NDArray[np.float64] | None:
    """Return the numbers of an entry of the comment: (n,); None without this entry."""
    if name not in entries:
        return None
    words = entries[name].strip('"').split()
    if len(words) != n or not all(map(is_number, words)):
        raise ValueError(f"found {name}={entries[name]}, expected {n} numbers")
    return np.array(words, dtype=np.float64)
