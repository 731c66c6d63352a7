"""Data files of LAMMPS (``read_data``, ``write_data``) of ``atom_style sphere`` and its hybrids.

https://docs.lammps.org/read_data.html
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.readers.columns import (
    DIAMETER,
    SPINS,
    VELOCITIES,
    ColumnReader,
    GrainColumn,
    find_columns,
)
from granwave.lammps_inputs.readers.grain_table import GrainTable
from granwave.lammps_inputs.readers.lammps_dump import powers_of_style
from granwave.lammps_inputs.readers.source import FileOptions, GrainSource
from granwave.lammps_inputs.tables.layout import BLANKS, Layout, with_plain_exponents
from granwave.lammps_inputs.tables.text_table import table_of
from granwave.lammps_inputs.tables.units import LENGTH, in_si

NAME = "lammps-data"
LABEL = "LAMMPS data file"
NUMBER_OF_ATOMS = re.compile(r"^[ \t]*([0-9]+)[ \t]+atoms\b", re.MULTILINE)
_ATOMS = re.compile(r"^[ \t]*Atoms[ \t]*(?:#(.*))?$", re.MULTILINE)
_VELOCITIES = re.compile(r"^[ \t]*Velocities\b.*$", re.MULTILINE)
_STYLE_OF_UNITS = re.compile(r"units = (\w+)")
_BOX = re.compile(r"^[ \t]*(\S+)[ \t]+(\S+)[ \t]+([xyz])lo[ \t]+[xyz]hi", re.MULTILINE)
# edge of a box, in any direction
_EDGE = re.compile(r"^[ \t]*\S+[ \t]+\S+[ \t]+\S+[ \t]+avec\b", re.MULTILINE)
_TILTS = re.compile(r"^(.*)[ \t]xy[ \t]+xz[ \t]+yz\b", re.MULTILINE)
_PLACE = ["x", "y", "z"]
_SPHERE = ["diameter", "density"]
_IMAGES = ["ix", "iy", "iz"]
_STYLES = {
    "sphere": ["id", "type", *_SPHERE, *_PLACE],
    "granular": ["id", "type", *_SPHERE, *_PLACE],  # LIGGGHTS, and LAMMPS before 2010
    "bpm/sphere": ["id", "mol", "type", *_SPHERE, *_PLACE],
    "atomic": ["id", "type", *_PLACE],
}
#: Columns that sub-styles of a hybrid add behind the places.
_OF_HYBRID = {
    "sphere": _SPHERE,
    "granular": _SPHERE,
    "atomic": [],
    "bond": ["mol"],
    "bond/gran": ["mol"],  # of LIGGGHTS
    "angle": ["mol"],
    "molecular": ["mol"],
    "charge": ["q"],
    "full": ["mol", "q"],
    "dipole": ["q", "mux", "muy", "muz"],
}
_MOST_HEAD = 100_000  # characters before the section of the atoms


def recognises(source: GrainSource) -> bool:
    """Return True for a text with a number of atoms and bounds of a box near its beginning."""
    has_box = _BOX.search(source.head) or _EDGE.search(source.head)
    return bool(NUMBER_OF_ATOMS.search(source.head) and has_box)


def read(source: GrainSource) -> GrainTable:
    """Read the atoms of a data file.

    Raises
    ------
    ValueError
        It is truncated, or its atoms have no sizes.
    """
    text = source.text
    options = source.options
    count = NUMBER_OF_ATOMS.search(text)
    section = _ATOMS.search(text)
    if count is None or section is None:
        raise ValueError("found no section Atoms, expected one; the data file may be truncated")
    head = text[: min(section.start(), _MOST_HEAD)]
    layout = _section(text, section, int(count[1]), "Atoms")
    heads = _heads(section[1] or "", layout, options)
    table = table_of(layout, heads, layout.numbers[0] - 1)
    notes: list[str] = []
    columns = find_columns(table, options, notes, repeated=True)
    if DIAMETER not in columns and options.diameter is None:
        raise ValueError(
            f"found atoms of {' '.join(heads)}, expected atom_style sphere, which has diameters, "
            "or packing.diameter for all grains"
        )
    style = _STYLE_OF_UNITS.search(head.partition("\n")[0])
    powers = powers_of_style(style[1] if style else "", options)
    grains = ColumnReader(table, columns, options, powers).grains(LABEL, notes)
    grains.bounds = _bounds(head, powers.get(LENGTH, 0))
    _add_velocities(text, grains, powers)
    return _without_points(grains)


def _section(text: str, section: re.Match[str], n_rows: int, name: str) -> Layout:
    """Return the rows of a section; raise ValueError if some are missing."""
    first_line = text.count("\n", 0, section.end()) + 2
    numbers: list[int] = []
    rows: list[str] = []
    for number, line in enumerate(_lines_from(text, section.end() + 1), start=first_line):
        row = line.partition("#")[0].strip()
        if not row:
            continue
        if row[0].isalpha():
            break
        if len(rows) == n_rows:
            raise ValueError(
                f"line {number}: found more than {n_rows} rows in the section {name}, expected the "
                "number in the header: the data file is damaged, or that number was edited"
            )
        numbers.append(number)
        rows.append(row)
    if len(rows) != n_rows or not rows:
        raise ValueError(
            f"found {len(rows)} of {n_rows} rows in the section {name}: the data file is truncated"
        )
    return Layout(numbers, with_plain_exponents(rows), BLANKS, ".")


def _lines_from(text: str, start: int) -> Sequence[str]:
    """Return the lines of a text from a position on."""
    return text[start:].splitlines()


def _heads(comment: str, layout: Layout, options: FileOptions) -> list[str]:
    """Return the names of the columns, from the comment on the style of the atoms."""
    if options.heads:
        return list(options.heads)
    n_columns = len(layout.cells(0))
    style, _, listed = comment.strip().partition(":")
    heads = listed.split() if listed else _of_style(style.split(), n_columns)
    if n_columns == len(heads) + len(_IMAGES):
        heads = [*heads, *_IMAGES]
    if n_columns != len(heads):
        raise ValueError(
            f"line {layout.numbers[0]}: found {n_columns} values, expected {len(heads)}: "
            f"{', '.join(heads)}; or name them by packing.columns"
        )
    return heads


def _of_style(words: list[str], n_columns: int) -> list[str]:
    """Return the names of the columns of a style; for a file without a style, the columns of
    spheres, or of atoms without sizes.
    """
    n_of_atomic = len(_STYLES["atomic"])
    has_no_sizes = n_columns in (n_of_atomic, n_of_atomic + len(_IMAGES))
    style = "atomic" if has_no_sizes else "sphere"
    if words:
        style = words[0]
    if style == "hybrid":
        unknown = [word for word in words[1:] if word not in _OF_HYBRID]
        if not unknown:
            heads = ["id", "type", *_PLACE]
            for word in words[1:]:
                heads += [head for head in _OF_HYBRID[word] if head not in heads]
            return heads
        style = f"hybrid with {unknown[0]}"
    if style in _STYLES:
        return _STYLES[style]
    raise ValueError(
        f"found atom_style {style} with {n_columns} columns, expected sphere or a hybrid with it; "
        'or name the columns: packing.columns = ["id", "type", "x", "y", "z", ...]'
    )


def _bounds(head: str, power: float) -> NDArray[np.float64] | None:
    """Return the box: (3, 2), m; None if the head of the file lacks it along some axis, or if it is
    tilted.
    """
    tilts = _TILTS.search(head)
    if tilts is not None and any(word.strip("+-0.eE") for word in tilts[1].split()):
        return None
    edges = {match[3]: (match[1], match[2]) for match in _BOX.finditer(head)}
    if len(edges) < len(_PLACE):
        return None
    try:
        box = np.array([edges[axis] for axis in _PLACE], dtype=np.float64)
    except ValueError:
        return None
    return in_si(box, power)


def _add_velocities(text: str, grains: GrainTable, powers: Mapping[str, float]) -> None:
    """Add velocities and spins of the section Velocities, if there is one."""
    section = _VELOCITIES.search(text)
    if section is None or grains.ids is None:
        return
    layout = _section(text, section, len(grains), "Velocities")
    heads = ["id", *VELOCITIES, *SPINS][: len(layout.cells(0))]
    table = table_of(layout, heads, layout.numbers[0] - 1)
    columns = {head: GrainColumn(index, head) for index, head in enumerate(heads)}
    reader = ColumnReader(table, columns, FileOptions(), powers)
    ids = reader.ids()
    assert ids is not None
    order = np.argsort(ids, kind="stable")
    if not np.array_equal(ids[order], np.sort(grains.ids)):
        raise ValueError("found velocities whose ids differ from the ids of the atoms")
    rows = order[np.argsort(np.argsort(grains.ids, kind="stable"), kind="stable")]
    velocity = reader.vector(VELOCITIES)
    spin = reader.vector(SPINS)
    grains.velocity = None if velocity is None else velocity[rows]
    grains.spin = None if spin is None else spin[rows]


def _without_points(grains: GrainTable) -> GrainTable:
    """Return the grains without atoms of diameter 0, such as the nodes of a bar."""
    if grains.radius is None or (grains.radius != 0).all():
        return grains
    there = np.flatnonzero(grains.radius)
    if not len(there):
        return grains
    grains.notes.append(f"{len(grains) - len(there)} points of diameter 0 ignored")
    return grains.taken(there)
