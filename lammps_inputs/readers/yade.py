"""Packings of YADE: ``export.text`` and ``export.textExt``, and ``SpherePack.save``.

A first line ``#format x_y_z_r`` names the columns, a line ``##PERIODIC:: x y z`` the periodic cell;
without these lines the format must be named, and the columns are x, y, z, r.
"""

from __future__ import annotations

import dataclasses
import re

import numpy as np

from granwave.lammps_inputs.readers.columns import (
    ColumnReader,
    find_columns,
    require_columns,
)
from granwave.lammps_inputs.readers.grain_table import GrainTable
from granwave.lammps_inputs.readers.source import GrainSource
from granwave.lammps_inputs.tables.layout import BLANKS, layout_of
from granwave.lammps_inputs.tables.text_table import table_of
from granwave.lammps_inputs.tables.units import in_si

NAME = "yade"
LABEL = "YADE"
_FORMAT = re.compile(r"^#[ \t]*format[ \t]+(\S*x_y_z_r\S*)", re.MULTILINE)
_PERIODIC = re.compile(r"^##PERIODIC::[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+)", re.MULTILINE)
_HEADS = ["x", "y", "z", "r"]
_CLUMP = "clumpId"


def recognises(source: GrainSource) -> bool:
    """Return True for a text with a first line of YADE."""
    return bool(_FORMAT.search(source.head) or _PERIODIC.match(source.head))


def read(source: GrainSource) -> GrainTable:
    """Read the spheres; raise ValueError with the line of the fault."""
    text = source.text
    options = source.options
    layout = dataclasses.replace(layout_of(text), separator=BLANKS, decimal=".")
    if not layout.rows:
        raise ValueError("found no sphere, expected a row x y z r for each")
    match = _FORMAT.search(source.head)
    heads = list(options.heads)
    if not heads:
        heads = match[1].split("_") if match else [*_HEADS, _CLUMP]
    n_columns = len(layout.cells(0))
    heads = heads[:n_columns] + [""] * (n_columns - len(heads))
    table = table_of(layout, heads, layout.numbers[0])
    notes: list[str] = []
    columns = find_columns(table, options, notes)
    require_columns(table, columns, options)
    grains = ColumnReader(table, columns, options).grains(LABEL, notes)
    cell = _PERIODIC.match(source.head)
    if cell is not None:
        try:
            lengths = np.array([float(word) for word in cell.groups()])
        except ValueError:
            raise ValueError("line 1: found no three numbers after ##PERIODIC::") from None
        high = in_si(lengths, options.power())
        grains.bounds = np.stack([np.zeros(3), high], axis=1)
        grains.periodic = (True, True, True)
    return grains
