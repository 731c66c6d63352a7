"""Geometry files of ESyS-Particle and GenGeo (``.geo``): a head with the box, and a row ``x y z
radius id tag`` for each particle.

Tags are read as types; bonds are not read.
"""

from __future__ import annotations

import re

import numpy as np

from granwave.lammps_inputs.message_words import show
from granwave.lammps_inputs.readers.columns import (
    ID,
    PLACE,
    RADIUS,
    TYPE,
    ColumnReader,
    find_columns,
)
from granwave.lammps_inputs.readers.grain_table import GrainTable
from granwave.lammps_inputs.readers.source import GrainSource
from granwave.lammps_inputs.tables.layout import BLANKS, Layout, is_number
from granwave.lammps_inputs.tables.text_table import table_of
from granwave.lammps_inputs.tables.units import in_si

NAME = "esys"
LABEL = "ESyS-Particle geometry"
_START = "LSMGeometry"
_HEADS = [*PLACE, RADIUS, ID, TYPE]
_PARTICLES = re.compile(
    r"^BeginParticles[ \t]*\n[ \t]*(\w+)[ \t]*\n[ \t]*(\S+)[ \t]*$", re.MULTILINE
)
_BOX = re.compile(r"^BoundingBox((?:[ \t]+\S+){6})[ \t]*$", re.MULTILINE)
_PERIODS = re.compile(r"^PeriodicBoundaries[ \t]+([01])[ \t]+([01])[ \t]+([01])", re.MULTILINE)
_PLANE = re.compile(r"^Dimensions?[ \t]+2D", re.MULTILINE)
_BONDS = re.compile(r"^BeginConnect[ \t]*\n[ \t]*([0-9]+)", re.MULTILINE)
_SPHERES = "Simple"


def recognises(source: GrainSource) -> bool:
    """Return True for a geometry file."""
    return source.head.startswith(_START)


def read(source: GrainSource) -> GrainTable:
    """Read the particles.

    Raises
    ------
    ValueError
        The file is truncated, of two dimensions, or its particles are no spheres.
    """
    text = source.text
    match = _PARTICLES.search(text)
    if match is None or not match[2].isdigit():
        raise ValueError(
            "found no section BeginParticles with a type and a number of particles, expected one; "
            "the file may be truncated"
        )
    head = text[: match.start()]
    _check_kind(head, match[1])
    n_rows = int(match[2])
    first_line = text.count("\n", 0, match.end()) + 2
    rows = text[match.end() + 1 :].splitlines()[:n_rows]
    n_there = next((n for n, row in enumerate(rows) if row.startswith("End")), len(rows))
    if n_there < n_rows or not rows:
        raise ValueError(f"found {n_there} of {n_rows} particles: the file is truncated")
    layout = Layout(range(first_line, first_line + n_rows), rows, BLANKS, ".")
    table = table_of(layout, source.options.heads or _HEADS, first_line)
    notes: list[str] = []
    columns = find_columns(table, source.options, notes)
    bonds = _BONDS.search(text, match.end())
    if bonds is not None and int(bonds[1]):
        notes.append(f"{bonds[1]} bonds ignored; the grains are not bonded")
    grains = ColumnReader(table, columns, source.options).grains(LABEL, notes)
    _add_box(head, grains, source.options.power())
    return grains


def _check_kind(head: str, kind: str) -> None:
    """Raise ValueError for a plane, or for particles other than spheres."""
    if _PLANE.search(head):
        raise ValueError("found particles in two dimensions (Dimension 2D), expected three")
    if kind != _SPHERES:
        raise ValueError(f"found particles of the type {show(kind)}, expected {_SPHERES}")


def _add_box(head: str, grains: GrainTable, power: float) -> None:
    """Add the box and its periods to the grains, if the head of the file has them."""
    box = _BOX.search(head)
    if box is None or not all(map(is_number, box[1].split())):
        return
    corners = np.array(box[1].split(), dtype=np.float64)
    grains.bounds = in_si(corners.reshape(2, 3).T, power)
    flags = _PERIODS.search(head)
    if flags is not None:
        grains.periodic = flags[1] == "1", flags[2] == "1", flags[3] == "1"
