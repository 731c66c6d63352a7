"""Molecule templates of LAMMPS (``molecule``), with positions and diameters.

https://docs.lammps.org/molecule.html
"""

from __future__ import annotations

import re

from granwave.lammps_inputs.readers.columns import (
    DIAMETER,
    ID,
    PLACE,
    TYPE,
    ColumnReader,
    find_columns,
)
from granwave.lammps_inputs.readers.grain_table import GrainTable
from granwave.lammps_inputs.readers.lammps_data import NUMBER_OF_ATOMS
from granwave.lammps_inputs.readers.source import GrainSource
from granwave.lammps_inputs.tables.layout import BLANKS, Layout, with_plain_exponents
from granwave.lammps_inputs.tables.text_table import table_of

NAME = "lammps-molecule"
LABEL = "LAMMPS molecule template"
_PLACES = "Coords"
_COORDS = re.compile(rf"^[ \t]*{_PLACES}\b", re.MULTILINE)
_BOX = re.compile(r"\bxlo[ \t]+xhi\b|\bavec\b")  # bounds of the box in a data file
#: Columns of a section, behind the id.
_SECTIONS = {
    _PLACES: list(PLACE),
    "Types": [TYPE],
    "Diameters": [DIAMETER],
    "Masses": ["mass"],
    "Molecules": ["mol"],
}


def recognises(source: GrainSource) -> bool:
    """Return True for a text with a number of atoms and a section of positions, but no box."""
    has_atoms = NUMBER_OF_ATOMS.search(source.head) and _COORDS.search(source.head)
    return bool(has_atoms) and not _BOX.search(source.head)


def read(source: GrainSource) -> GrainTable:
    """Read the atoms of a template.

    Raises
    ------
    ValueError
        It is truncated, or its atoms have no sizes.
    """
    options = source.options
    lines = source.text.splitlines()
    count = NUMBER_OF_ATOMS.search(source.text)
    if count is None:
        raise ValueError("found no line N atoms, expected a molecule template of LAMMPS")
    n_atoms = int(count[1])
    first_line, rows = _section(lines, _PLACES, n_atoms)
    heads = [ID, *_SECTIONS[_PLACES]]
    for name, columns in _SECTIONS.items():
        if name == _PLACES or not _starts(lines, name):
            continue
        heads += columns
        _, further = _section(lines, name, n_atoms)
        missing = [atom for atom in rows if atom not in further]
        if missing:
            raise ValueError(f"found no atom {missing[0]} in the section {name}, expected all")
        rows = {atom: [*values, *further[atom]] for atom, values in rows.items()}
    texts = with_plain_exponents([" ".join([atom, *values]) for atom, values in rows.items()])
    layout = Layout(range(first_line, first_line + n_atoms), texts, BLANKS, ".")
    table = table_of(layout, heads, first_line - 1)
    notes: list[str] = []
    columns_of = find_columns(table, options, notes)
    if DIAMETER not in columns_of and options.diameter is None:
        raise ValueError(
            "found no section Diameters, expected one, or packing.diameter for all grains"
        )
    return ColumnReader(table, columns_of, options).grains(LABEL, notes)


def _starts(lines: list[str], name: str) -> list[int]:
    """Return the numbers of the lines, from 0, that begin a section."""
    return [k for k, line in enumerate(lines) if line.split("#")[0].split() == [name]]


def _section(lines: list[str], name: str, n_atoms: int) -> tuple[int, dict[str, list[str]]]:
    """Return the first line, from 1, and the values by atom of a section."""
    starts = _starts(lines, name)
    rows: dict[str, list[str]] = {}
    first_line = 0
    for number, line in enumerate(lines[starts[0] + 1 :], start=starts[0] + 2):
        words = line.split("#")[0].split()
        if not words:
            continue
        if words[0][0].isalpha() or len(rows) == n_atoms:
            break
        first_line = first_line or number
        atom, *values = words
        if len(values) != len(_SECTIONS[name]):
            raise ValueError(
                f"line {number}: found {len(values)} values in the section {name}, expected "
                f"{len(_SECTIONS[name])}: {', '.join(_SECTIONS[name])}"
            )
        if atom in rows:
            raise ValueError(f"line {number}: found the atom {atom} twice in the section {name}")
        rows[atom] = values
    if len(rows) != n_atoms:
        raise ValueError(
            f"found {len(rows)} of {n_atoms} atoms in the section {name}: the file is truncated"
        )
    return first_line, rows
