"""Packings of MercuryDPM: ``.data`` (one or several steps, in three dimensions) and ``.restart``.

A step of ``.data`` begins with N, time and the corners of the domain; each particle has position,
velocity, radius, angles, angular velocity and a number.
"""

from __future__ import annotations

import re

import numpy as np

from granwave.lammps_inputs.message_words import show
from granwave.lammps_inputs.readers.columns import SPINS, VELOCITIES, ColumnReader, find_columns
from granwave.lammps_inputs.readers.grain_table import GrainTable
from granwave.lammps_inputs.readers.source import GrainSource
from granwave.lammps_inputs.tables.layout import BLANKS, Layout, is_number
from granwave.lammps_inputs.tables.text_table import table_of
from granwave.lammps_inputs.tables.units import in_si

NAME = "mercury"
LABEL = "MercuryDPM"
_VERSION = "restart_version"
_HEADS = ["x", "y", "z", *VELOCITIES, "radius", "tx", "ty", "tz", *SPINS, ""]
_N_OF_STEP = 8  # N, time, lowest and highest corner
_N_OF_PLANE = (6, 8)  # values of a step and of a particle in two dimensions
_PARTICLES = re.compile(r"^Particles[ \t]+([0-9]+)[ \t]*$", re.MULTILINE)
_DOMAIN = re.compile(r"([xyz])Min[ \t]+(\S+)[ \t]+\1Max[ \t]+(\S+)", re.IGNORECASE)
_OLD_PARTICLE = "BP"  # word of version 3 before the numbers; may be missing
_N_OF_OLD = 16  # position, velocity, radius, angles, spin, inverse mass and inertia, species
_OTHER_SHAPES = re.compile(r"superquadric|clump|nonspherical|multiparticle", re.IGNORECASE)
_VALUES = {"position": 3, "velocity": 3, "radius": 1, "indSpecies": 1, "id": 1}


def recognises(source: GrainSource) -> bool:
    """Return True for a restart file, or a first line of a step above a particle."""
    if source.head.startswith(_VERSION):
        return True
    first, _, rest = source.head.partition("\n")
    step = first.split()
    particle = rest.partition("\n")[0].split()
    counts = (len(step), len(particle))
    if counts not in ((_N_OF_STEP, len(_HEADS)), _N_OF_PLANE):
        return False
    return step[0].isdigit() and all(map(is_number, [*step, *particle]))


def read(source: GrainSource) -> GrainTable:
    """Read the particles of a restart file, or of a step of a data file, by default the last.

    Raises
    ------
    ValueError
        It is truncated, or of two dimensions.
    """
    if source.head.startswith(_VERSION):
        return _read_restart(source)
    return _read_data(source)


def _read_data(source: GrainSource) -> GrainTable:
    """Read a step of a data file."""
    options = source.options
    lines = source.text.splitlines()
    starts = _starts(lines)
    chosen = len(starts) - 1 if options.step is None else options.step
    if not 0 <= chosen < len(starts):
        raise ValueError(
            f"found no step {options.step} (packing.step), expected one from 0 to {len(starts) - 1}"
        )
    start, n_rows = starts[chosen]
    rows = lines[start + 1 : start + 1 + n_rows]
    if len(rows) < n_rows or not rows:
        raise ValueError(
            f"line {start + 1}: found {len(rows)} of {n_rows} particles: the file is truncated"
        )
    layout = Layout(range(start + 2, start + 2 + n_rows), rows, BLANKS, ".")
    table = table_of(layout, _HEADS, start + 1)
    notes: list[str] = []
    columns = find_columns(table, options, notes)
    form = f"{LABEL} data, step {chosen}"
    if len(starts) > 1:
        form += f" of {len(starts)} steps"
    grains = ColumnReader(table, columns, options).grains(form, notes)
    corners = np.array([float(word) for word in lines[start].split()[2:]])
    grains.bounds = in_si(corners.reshape(2, 3).T, options.power())
    return grains


def _starts(lines: list[str]) -> list[tuple[int, int]]:
    """Return the first line, from 0, and the number of particles of each step."""
    starts: list[tuple[int, int]] = []
    k = 0
    while k < len(lines):
        words = lines[k].split()
        if not words:
            k += 1
            continue
        if len(words) == _N_OF_PLANE[0]:
            raise ValueError(f"line {k + 1}: found particles in two dimensions, expected three")
        if len(words) != _N_OF_STEP or not words[0].isdigit() or not all(map(is_number, words)):
            raise ValueError(
                f"line {k + 1}: found {show(lines[k].strip())}, expected N, time and the corners "
                "of the domain; the file is damaged or truncated"
            )
        starts.append((k, int(words[0])))
        k += 1 + int(words[0])
    return starts


def _read_restart(source: GrainSource) -> GrainTable:
    """Read the particles of a restart file."""
    text = source.text
    match = _PARTICLES.search(text)
    if match is None:
        raise ValueError("found no line Particles N, expected one; the file may be truncated")
    n_rows = int(match[1])
    first_line = text.count("\n", 0, match.end()) + 2
    lines = text[match.end() + 1 :].splitlines()[:n_rows]
    rows: list[str] = []
    notes: list[str] = []
    shapes = [line.split(maxsplit=1)[0] for line in lines if _OTHER_SHAPES.match(line)]
    if shapes:
        notes.append(
            f"{len(shapes)} particles are not spheres ({shapes[0]}); read as spheres of "
            "their radius"
        )
    for index, line in enumerate(lines):
        words = line.split()
        old = _old_row_of(words, index)
        rows.append(old or _row_of(words, first_line + index))
    if len(rows) < n_rows or not rows:
        raise ValueError(f"found {len(rows)} of {n_rows} particles: the file is truncated")
    heads = ["x", "y", "z", *VELOCITIES, "radius", "type", "id"]
    layout = Layout(range(first_line, first_line + n_rows), rows, BLANKS, ".")
    table = table_of(layout, heads, first_line)
    columns = find_columns(table, source.options, notes)
    grains = ColumnReader(table, columns, source.options).grains(f"{LABEL} restart", notes)
    domain = {axis: (low, high) for axis, low, high in _DOMAIN.findall(text[: match.start()])}
    if len(domain) == len("xyz"):
        box = np.array([domain[axis] for axis in "xyz"], dtype=np.float64)
        grains.bounds = in_si(box, source.options.power())
    return grains


def _old_row_of(words: list[str], index: int) -> str:
    """Return the values of a particle of version 3 in the order of the columns; empty if it is not.

    Parameters
    ----------
    index
        Number of the particle, from 0, which is its id.
    """
    numbers = words[words[:1] == [_OLD_PARTICLE] :]
    if len(numbers) != _N_OF_OLD or not all(map(is_number, numbers)):
        return ""
    *values, species = [*numbers[:7], numbers[-1]]
    return " ".join([*values, species, str(index)])


def _row_of(words: list[str], line: int) -> str:
    """Return the values of a particle in the order of the columns."""
    values: list[str] = []
    for name, n in _VALUES.items():
        if name not in words or words.index(name) + n >= len(words):
            raise ValueError(
                f"line {line}: found no {name} of a particle, expected one; the file is damaged "
                "or truncated"
            )
        first = words.index(name) + 1
        values += words[first : first + n]
    return " ".join(values)
