"""Packings of MercuryDPM: ``.data`` (one or several steps) and ``.restart``.

A step of ``.data`` begins with N, time and the corners of the domain; each particle has position,
velocity, radius, angles, angular velocity and a number. Particles in two dimensions are spheres
with their centres at z = 0.

A restart file has the domain, the species, the boundaries and a line for each particle, with words
and numbers, or only numbers before version 0.10.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.message_words import show
from granwave.lammps_inputs.readers.columns import SPINS, VELOCITIES, ColumnReader, find_columns
from granwave.lammps_inputs.readers.grain_table import GrainTable
from granwave.lammps_inputs.readers.source import GrainSource
from granwave.lammps_inputs.tables.layout import BLANKS, Layout, is_number
from granwave.lammps_inputs.tables.text_table import table_of
from granwave.lammps_inputs.tables.units import in_si

NAME = "mercury"
LABEL = "MercuryDPM"
_VERSIONS = re.compile(r"restart_version[ \t]|MercuryDPM[ \t]+\S+[ \t]+name[ \t]")
_HEADS = ["x", "y", "z", *VELOCITIES, "radius", "tx", "ty", "tz", *SPINS, ""]
_N_OF_STEP = 8  # N, time, lowest and highest corner
_N_OF_PLANE = (6, 8)  # values of a step and of a particle in two dimensions
_N_OF_SHORT = 8  # values of a particle without angles: position, velocity, radius, a number
#: Numbers of values of a particle, by those of the head of its step.
_N_OF_VALUES = {_N_OF_STEP: (len(_HEADS), _N_OF_SHORT), _N_OF_PLANE[0]: (_N_OF_PLANE[1],)}
_IN_SPACE = "{} {} 0 {} {} 0 {} 0 0 {} 0 0 {} {}"  # of the values of a particle in a plane
_WITH_ANGLES = "{} {} {} {} {} {} {} 0 0 0 0 0 0 {}"  # of the values of a particle without angles
_EMPTY_STEPS = 20  # at the beginning of a file, at most
_PARTICLES = re.compile(r"^Particles[ \t]+([0-9]+)[ \t]*$", re.MULTILINE)
_DOMAIN = re.compile(r"([xyz])Min[ \t]+(\S+)[ \t]+\1Max[ \t]+(\S+)", re.IGNORECASE)
_SPECIES = re.compile(r"^Species[ \t]+([0-9]+)[ \t]*$", re.MULTILINE)
_DENSITY = re.compile(r"^.*?\b(?:density|rho)[ \t]+(\S+)", re.MULTILINE)
_PERIOD = re.compile(
    r"^(?:PeriodicBoundary\b.*?)?\bnormal[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+)\b.*?"
    r"\b(?:distance|pos|position)_?[Ll]eft[ \t]+(\S+)"
    r"[ \t]+(?:distance|pos|position)_?[Rr]ight[ \t]+(\S+)",
    re.MULTILINE,
)
_OLD_PARTICLES = ("TSP", "BP")  # of version 3, before the numbers, or nothing
_WITH_SPRINGS = "TSP"  # whose springs are behind the species
_N_OF_OLD = 16  # position, velocity, radius, angles, spin, inverse mass and inertia, species
_OTHER_SHAPES = re.compile(r"superquadric|clump|nonspherical|multiparticle", re.IGNORECASE)
_SPIN = "angularVelocity"
_N_OF_WORD = {"position": 3, "velocity": 3, "radius": 1, _SPIN: 3, "indSpecies": 1, "invMass": 1,
              "id": 1}  # fmt: skip
_BY_DEFAULT = {_SPIN: ["0", "0", "0"], "invMass": ["1"]}
_HEADS_OF_RESTART = ["x", "y", "z", *VELOCITIES, "radius", *SPINS, "type", "", "id"]
_INVERSE_MASS = _HEADS_OF_RESTART.index("")
FIXED = "fixed"


def recognises(source: GrainSource) -> bool:
    """Return True for a restart file, or for the first line of a step followed by a particle."""
    if _VERSIONS.match(source.head):
        return True
    lines = source.head.splitlines()
    rows = [line.split() for line in lines[: _EMPTY_STEPS + 1] if line.strip()]
    while len(rows) > 2 and rows[0][0] == "0" and len(rows[0]) == len(rows[1]):
        rows.pop(0)  # a step without particles
    if len(rows) < 2:
        return False
    step, particle = rows[:2]
    n_values = _N_OF_VALUES.get(len(step), ())
    if len(particle) not in n_values or not step[0].isdigit() or step[0] == "0":
        return False
    if len(particle) == len(step) and source.content.count(b"\n") not in _n_lines(step):
        return False  # rows of a table
    return all(map(is_number, [*step, *particle]))


def _n_lines(step: list[str]) -> tuple[int, int]:
    """Return the numbers of ends of lines that a file of one step may have."""
    n_particles = int(step[0])
    return n_particles, n_particles + 1


def read(source: GrainSource) -> GrainTable:
    """Read the particles of a restart file, or of a step of a data file, by default the last.

    Raises
    ------
    ValueError
        It is damaged or truncated.
    """
    if _VERSIONS.match(source.head):
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
    if not n_rows:
        filled = [str(step) for step, (_, n) in enumerate(starts) if n]
        remedy = (
            f"; packing.step = {filled[-1]} reads the last step with particles" if filled else ""
        )
        raise ValueError(
            f"line {start + 1}: found no particle in the step {chosen}, expected one or more"
            f"{remedy}"
        )
    if len(rows) < n_rows:
        raise ValueError(
            f"line {start + 1}: found {len(rows)} of {n_rows} particles: the file is truncated"
        )
    notes: list[str] = []
    head = lines[start].split()
    is_plane = len(head) == _N_OF_PLANE[0]
    if is_plane:
        rows = [_in_order(row, start + 2 + k, _IN_SPACE) for k, row in enumerate(rows)]
        notes.append("particles in two dimensions; read as spheres with their centres at z = 0")
    elif len(rows[0].split()) == _N_OF_SHORT:
        rows = [_in_order(row, start + 2 + k, _WITH_ANGLES) for k, row in enumerate(rows)]
    layout = Layout(range(start + 2, start + 2 + n_rows), rows, BLANKS, ".")
    table = table_of(layout, _HEADS, start + 1)
    columns = find_columns(table, options, notes)
    form = f"{LABEL} data, step {chosen}"
    if len(starts) > 1:
        form += f" of {len(starts)} steps"
    grains = ColumnReader(table, columns, options).grains(form, notes)
    if not is_plane:
        corners = np.array([float(word) for word in head[2:]])
        grains.bounds = in_si(corners.reshape(2, 3).T, options.power())
    return grains


def _in_order(row: str, line: int, form: str) -> str:
    """Return the eight values of a particle in two dimensions, or without angles, in the order of
    the columns.
    """
    words = row.split()
    if len(words) != _N_OF_SHORT:
        raise ValueError(
            f"line {line}: found {len(words)} values, expected {_N_OF_SHORT} as in the first row "
            "of the step"
        )
    return form.format(*words)


def _starts(lines: list[str]) -> list[tuple[int, int]]:
    """Return the first line, from 0, and the number of particles of each step."""
    starts: list[tuple[int, int]] = []
    k = 0
    while k < len(lines):
        words = lines[k].split()
        if not words:
            k += 1
            continue
        is_head = len(words) in (_N_OF_STEP, _N_OF_PLANE[0]) and words[0].isdigit()
        if not is_head or not all(map(is_number, words)):
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
    notes = _notes_on_shapes(lines)
    rows = [_row_of(line.split(), index, first_line + index) for index, line in enumerate(lines)]
    if not rows or len(rows) < n_rows:
        raise ValueError(f"found {len(rows)} of {n_rows} particles: the file is truncated")
    layout = Layout(range(first_line, first_line + n_rows), rows, BLANKS, ".")
    table = table_of(layout, _HEADS_OF_RESTART, first_line)
    columns = find_columns(table, source.options, notes)
    grains = ColumnReader(table, columns, source.options).grains(f"{LABEL} restart", notes)
    _name_fixed(grains, table.numbers(_INVERSE_MASS, "invMass") == 0)
    _add_densities(grains, text[: match.start()])
    _add_box(grains, text[: match.start()], source.options.power())
    return grains


def _notes_on_shapes(lines: Sequence[str]) -> list[str]:
    """Return a warning if some particles are not spheres."""
    shapes = [line.split(maxsplit=1)[0] for line in lines if _OTHER_SHAPES.match(line)]
    if not shapes:
        return []
    return [
        f"{len(shapes)} particles are not spheres ({shapes[0]}); read as spheres of their radius"
    ]


def _row_of(words: list[str], index: int, line: int) -> str:
    """Return the values of a particle in the order of the columns.

    Parameters
    ----------
    index
        Number of the particle, from 0, which is the id of those of old files.
    """
    if old := _old_row_of(words, index):
        return old
    values: list[str] = []
    for name, n in _N_OF_WORD.items():
        first = words.index(name) + 1 if name in words else 0
        if name == _SPIN and is_number(" ".join(words[first + n : first + n + 1])):
            first += 1  # of a quaternion, whose first part is 0
        found = words[first : first + n] if first else _BY_DEFAULT.get(name, [])
        if len(found) < n:
            raise ValueError(
                f"line {line}: found no {name} of a particle, expected one; the file is damaged "
                "or truncated"
            )
        values += found
    return " ".join(values)


def _old_row_of(words: list[str], index: int) -> str:
    """Return the values of a particle of version 3 in the order of the columns; empty if it is of
    another version.
    """
    n_names = sum(word in _OLD_PARTICLES for word in words[: len(_OLD_PARTICLES)])
    numbers = words[n_names:]
    has_species = len(numbers) == _N_OF_OLD or words[:1] == [_WITH_SPRINGS]
    numbers = numbers[:_N_OF_OLD]
    if len(numbers) != _N_OF_OLD or not all(map(is_number, numbers)):
        return ""
    place_to_radius = numbers[:7]
    spin = numbers[10:13]
    inverse_mass = numbers[13]
    species = numbers[-1] if has_species else "0"  # of version 2, which has the springs there
    return " ".join([*place_to_radius, *spin, species, inverse_mass, str(index)])


def _name_fixed(grains: GrainTable, is_fixed: NDArray[np.bool_]) -> None:
    """Make a group of the particles that are fixed, whose inverse mass is 0."""
    n_fixed = int(np.count_nonzero(is_fixed))
    if not n_fixed:
        return
    grains.words["group"] = [FIXED if fixed else "" for fixed in is_fixed.tolist()]
    grains.notes.append(
        f'{n_fixed} particles are fixed in the file (invMass 0): the group "{FIXED}"; hold them by '
        f'[[hold]] group = "{FIXED}", otherwise they move'
    )


def _add_densities(grains: GrainTable, head: str) -> None:
    """Add the densities of the species, if each particle has one."""
    start = _SPECIES.search(head)
    if start is None:
        return
    densities = _DENSITY.findall(head, start.end())[: int(start[1])]
    species = [int(name) for name in grains.types if name.isdigit()]
    if not all(map(is_number, densities)) or len(species) < len(grains):
        return
    if max(species) < len(densities):
        grains.density = np.array(densities, dtype=np.float64)[species]


def _add_box(grains: GrainTable, head: str, power: float) -> None:
    """Add the domain, and the periods along its axes, to the grains."""
    domain = {axis.lower(): (low, high) for axis, low, high in _DOMAIN.findall(head)}
    if len(domain) < len("xyz"):
        return
    box = np.array([domain[axis] for axis in "xyz"], dtype=np.float64)
    periodic = [False, False, False]
    for *normal, low, high in _PERIOD.findall(head):
        direction = np.array(normal, dtype=np.float64)
        axes = np.flatnonzero(direction)
        if len(axes) == 1 and direction[axes[0]] > 0:
            box[axes[0]] = float(low), float(high)
            periodic[axes[0]] = True
    grains.bounds = in_si(box, power)
    grains.periodic = periodic[0], periodic[1], periodic[2]
