"""Spheres in a binary restart file of LAMMPS.

The end of such a file is, for each process that wrote it, a flag, the number of its values, and the
values: records of atoms, one after the other, and then a mark. The record of a sphere (``atom_style
sphere``) begins with its own length, place, id, type, mask, image, velocity, radius, mass and
angular velocity; what fixes keep of it follows. Integers have the bits of doubles.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.files import read_regular

_MARK = b"LammpS RestartT\x00"
_WORD = 4  # bytes of an int
_VALUE = 8  # bytes of a double
_PLACE = slice(1, 4)
_ID = 4
_TYPE = 5
_VELOCITY = slice(8, 11)
_RADIUS = 11
_MASS = 12
_SHORTEST = 16  # values of a sphere, the angular velocity last


@dataclasses.dataclass(frozen=True, eq=False)
class RestartSpheres:
    """Spheres of a restart file, in the order of their ids, which count from 1.

    Attributes
    ----------
    position, velocity
        (n, 3), m and m/s.
    radius, mass
        (n,), m and kg.
    kind
        LAMMPS types, from 1: (n,).
    """

    position: NDArray[np.float64]
    velocity: NDArray[np.float64]
    radius: NDArray[np.float64]
    mass: NDArray[np.float64]
    kind: NDArray[np.int64]


def read_restart(path: Path) -> RestartSpheres:
    """Read the spheres of a restart file in SI units.

    Raises
    ------
    ValueError
        It is no restart file of spheres whose ids are 1, 2, ...
    OSError
        It cannot be read.
    """
    content = read_regular(path)
    if not content.startswith(_MARK) or not content.endswith(_MARK):
        raise ValueError("found no restart file of LAMMPS, expected one that write_restart wrote")
    rows = _records(content)
    if not len(rows):
        raise ValueError("found no spheres, expected a restart file of atom_style sphere")
    ids = rows[:, _ID].copy().view(np.int64)
    order = np.argsort(ids)
    if not np.array_equal(ids[order], np.arange(1, len(ids) + 1)):
        raise ValueError(
            f"found ids up to {ids.max()} of {len(ids)} spheres, expected 1, 2, ...; "
            "use reset_atoms id before write_restart"
        )
    rows = rows[order]
    spheres = RestartSpheres(
        rows[:, _PLACE],
        rows[:, _VELOCITY],
        rows[:, _RADIUS],
        rows[:, _MASS],
        rows[:, _TYPE].copy().view(np.int64),
    )
    if not (spheres.radius > 0).all() or not np.isfinite(rows[:, _PLACE]).all():
        raise ValueError("found atoms without a radius, expected atom_style sphere")
    return spheres


def _records(content: bytes) -> NDArray[np.float64]:
    """Return the first values of the record of each sphere: (n, 16)."""
    end = len(content) - len(_MARK)
    found: list[NDArray[np.float64]] = []
    while (chunk := _last_chunk(content, end)) is not None:
        start, rows = chunk
        found.insert(0, rows)
        end = start
    return np.concatenate(found) if found else np.empty((0, _SHORTEST))


def _last_chunk(content: bytes, end: int) -> tuple[int, NDArray[np.float64]] | None:
    """Return where the values of a process that end there begin, with its flag, and its records."""
    words = np.frombuffer(content[end % _WORD : end], dtype="<i4")
    back = np.arange(len(words), 0, -1)  # words from each to the end
    per_value = _VALUE // _WORD
    counts = np.flatnonzero((words > 0) & (back == 1 + per_value * words.astype(np.int64)))
    for place in counts[::-1].tolist():
        n = int(words[place])
        start = end - _VALUE * n
        rows = _split(np.frombuffer(content, dtype="<f8", count=n, offset=start))
        if rows is not None:
            return start - 2 * _WORD, rows
    return None


def _split(values: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Return the first values of each record, (n, 16); None if the values are no records."""
    rows = []
    place = 0
    while place < len(values):
        length = values[place]
        if not (_SHORTEST <= length <= len(values) - place) or length != int(length):
            return None
        rows.append(values[place : place + _SHORTEST])
        place += int(length)
    return np.array(rows)
