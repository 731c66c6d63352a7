"""Particles of MFiX (``particle_input.dat``).

From version 2.0 on, a head has the number of particles, and for each variable whether it has
columns or one value for all. Older files have no head: x, y, z, radius, density and velocity,
or x, y, radius, density and velocity in two dimensions; packing.format names them.

https://mfix.netl.doe.gov/doc/mfix/latest/html/reference/particle_input.html
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping, Sequence

import numpy as np

from granwave.lammps_inputs.readers.columns import (
    DIAMETER,
    PLACE,
    RADIUS,
    TYPE,
    VELOCITIES,
    ColumnReader,
    find_columns,
)
from granwave.lammps_inputs.readers.grain_table import GrainTable
from granwave.lammps_inputs.readers.source import GrainSource
from granwave.lammps_inputs.tables.layout import BLANKS, Layout, is_number, with_plain_exponents
from granwave.lammps_inputs.tables.text_table import table_of
from granwave.lammps_inputs.tables.units import in_si

NAME = "mfix"
LABEL = "MFiX"
_HEAD = re.compile(r"Version[ \t]+[0-9.]+[ \t]*\n[ \t]*={10,}")
_COUNT = re.compile(r"^Particles:?[ \t]+([0-9]+)[ \t]*$", re.MULTILINE)
_PLANE = re.compile(r"^Dimension:?[ \t]+2[ \t]*$", re.MULTILINE)
_VARIABLE = re.compile(r"^(\w+):?[ \t]+([TF])\b(.*)$", re.MULTILINE)
_RULE = re.compile(r"^={10,}[ \t]*$", re.MULTILINE)
_IN_SPACE = ("x", "y", "z")
_IN_PLANE = ("x", "y")
_OLD = {8: [*PLACE, RADIUS, "density", *VELOCITIES], 6: ["x", "y", RADIUS, "density", "vx", "vy"]}
_TRUE = "T"
_NOTE_ON_PLANE = "particles in two dimensions; read as spheres with their centres at z = 0"


def recognises(source: GrainSource) -> bool:
    """Return True for the head of version 2.0 or later."""
    return bool(_HEAD.match(source.head))


def read(source: GrainSource) -> GrainTable:
    """Read the particles.

    Raises
    ------
    ValueError
        The file is truncated, or its particles have no diameters.
    """
    if not _HEAD.match(source.text):
        return _read_old(source)
    text = source.text
    count = _COUNT.search(text)
    variables = {match[1].lower(): match for match in _VARIABLE.finditer(text)}
    if count is None or "coordinates" not in variables:
        raise ValueError(
            "found no line Particles: N and no line Coordinates: T, expected both; the file may be "
            "truncated"
        )
    last = max(match.end() for match in variables.values())
    rules = list(_RULE.finditer(text, last))
    start = rules[1].end() if len(rules) > 1 else len(text)
    n_rows = int(count[1])
    first_line = text.count("\n", 0, start) + 2
    rows = text[start + 1 :].splitlines()[:n_rows]
    if len(rows) < n_rows or not rows:
        raise ValueError(f"found {len(rows)} of {n_rows} particles: the file is truncated")
    is_plane = bool(_PLANE.search(text))
    flags = {name: match[2] == _TRUE for name, match in variables.items()}
    defaults = {name: match[3].split() for name, match in variables.items() if not flags[name]}
    heads = list(source.options.heads) or _heads(flags, is_plane=is_plane)
    return _grains(source, rows, first_line, heads, defaults)


def _read_old(source: GrainSource) -> GrainTable:
    """Read a file without a head."""
    lines = source.text.splitlines()
    rows = [line for line in lines if line.strip()]
    n_columns = len(rows[0].split()) if rows else 0
    if n_columns not in _OLD and not source.options.heads:
        raise ValueError(
            f"line 1: found {n_columns} values, expected 8 (x, y, z, radius, density, velocity), "
            "or 6 in two dimensions"
        )
    return _grains(source, rows, 1, list(source.options.heads) or _OLD[n_columns], {})


def _heads(flags: Mapping[str, bool], *, is_plane: bool) -> list[str]:
    """Return the names of the columns of the variables that have columns."""
    axes = _IN_PLANE if is_plane else _IN_SPACE
    heads = list(axes)
    for name, columns in (
        ("phase_id", [TYPE]),
        ("diameter", [DIAMETER]),
        ("density", ["density"]),
        ("velocity", [f"v{axis}" for axis in axes]),
    ):
        if flags.get(name):
            heads += columns
    return heads


def _grains(
    source: GrainSource,
    rows: Sequence[str],
    first_line: int,
    heads: list[str],
    defaults: Mapping[str, Sequence[str]],
) -> GrainTable:
    """Return the particles of some rows.

    Parameters
    ----------
    defaults
        Values of all particles, by variable.
    """
    notes: list[str] = []
    if "z" not in heads:
        heads = [*heads[:2], "z", *heads[2:]]
        rows = [_with_depth(row) for row in rows]
        notes.append(_NOTE_ON_PLANE)
    options = source.options
    usual = _number(defaults.get("diameter", ()))
    if usual is not None and options.diameter is None:
        options = dataclasses.replace(options, diameter=in_si(usual, options.power()))
    plain = with_plain_exponents(list(rows))
    layout = Layout(range(first_line, first_line + len(rows)), plain, BLANKS, ".")
    n_columns = len(layout.cells(0))
    heads = heads[:n_columns] + [""] * (n_columns - len(heads))
    table = table_of(layout, heads, first_line)
    columns = find_columns(table, options, notes)
    if RADIUS not in columns and DIAMETER not in columns and options.diameter is None:
        raise ValueError("found no diameters, expected the variable Diameter, or packing.diameter")
    grains = ColumnReader(table, columns, options).grains(LABEL, notes)
    if grains.radius is None and options.diameter is not None:
        grains.radius = np.full(len(grains), options.diameter / 2)
    density = _number(defaults.get("density", ()))
    if density is not None:
        grains.density = np.full(len(grains), density)
    speed = [_number([word]) for word in defaults.get("velocity", ())[: len(PLACE)]]
    if len(speed) == len(PLACE) and any(speed):
        parts = np.array(speed, dtype=np.float64)
        grains.velocity = in_si(np.tile(parts, (len(grains), 1)), options.power())
    return grains


def _with_depth(row: str) -> str:
    """Return the values of a particle in two dimensions with z = 0 after its position."""
    words = row.split()
    return " ".join([*words[:2], "0", *words[2:]])


def _number(words: Sequence[str]) -> float | None:
    """Return the first of some words as a number; None if it is not a number."""
    if not words or not is_number(words[0]):
        return None
    return float(words[0])
