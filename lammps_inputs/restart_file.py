"""Spheres in a binary restart file of LAMMPS, with the contacts of pair style gran/hysteretic.

The end of such a file is, for each process that wrote it, a flag, the number of its values, and the
values: records of atoms in sequence, and then a mark. The record of a sphere (``atom_style
sphere``) begins with its length, position, id, type, mask, image, velocity, radius, mass and
angular velocity; the states of fixes follow, each preceded by its length. Integers have the bits of
doubles. The names and styles of these fixes precede the spheres.

Each state of a fix of granwave has a head (plugins/styles/restart_state.h). The state of the pair
style has a record for each contact of the sphere (kernels/contact_history.h), the state of a wall
has the reported values and the history of the contacts with the lower and the upper wall
(styles/fix_wall_gran_hysteretic.h).
"""

from __future__ import annotations

import dataclasses
import re
import struct
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.files import read_regular

_MARK = b"LammpS RestartT\x00"
_DATA_FILE = re.compile(rb"^[ \t]*[0-9]+[ \t]+atoms\b", re.MULTILINE)
_HEAD_OF_DATA = 1000  # bytes in which a data file says how many atoms it has
_WORD = 4  # bytes of an int
_VALUE = 8  # bytes of a double
_PLACE = slice(1, 4)
_ID = 4
_TYPE = 5
_VELOCITY = slice(8, 11)
_RADIUS = 11
_MASS = 12
_SPIN = slice(13, 16)
_SHORTEST = 16  # values of a sphere, the angular velocity last

NO_CLUMPS = (
    "write the file with the number of the clump of each sphere, by fix property/atom mol; if they "
    "are not clumps, settle the bed without neigh_modify exclude"
)

# fixes with states of atoms: they are in a list that begins at most this far before the history of
# contacts
_HISTORY = ("GRAN_HYSTERETIC_HISTORY", "gran/hysteretic/history")
_WALL = "wall/gran/hysteretic"
_OTHER_WALLS = "wall/"
_PROPERTIES = "property/atom"  # state of a sphere: its length, and the values
_LARGEST_NUMBER = 2**31 - 1  # largest number of a body: larger values are the bits of a double
_MOST_FIXES = 64
_LONGEST_NAME = 256
_FARTHEST = _MOST_FIXES * _LONGEST_NAME

# state of a sphere in a fix of ours, after the head
_HEAD = 7
_COUNT = 0
_BLOCK = 3
_PARTS = 4  # parts of a block after the doubles of the law; format 12 has both or neither
_BOTH = 1
_WITH_SPRING = 2
_WITH_DENTS = 3
_HAS_SUMS = 5
_RECORDS = 6
_SUMS = 15
# record of a contact, and what follows it
_PARTNER = 0
_LIVE = 3
_PEAK = 4
_RECORD = 10
_SPRING = 5  # force, compliance, loss
_STRETCH = 4  # words of a stretch: force and compliance
_DENTS = 2
# state of a sphere in a wall: reported values, times of a front, two sides of seven values
_OVERLAP = 0
_REPORTED = 18
_SIDE = 7
_DENT = 0
_PLACE_OF_DENT = slice(1, 3)  # on a plane or a tube; on a face of a region it has three numbers
_TOUCHING = 5


@dataclasses.dataclass(frozen=True, eq=False)
class RestartContacts:
    """Contacts between spheres of a restart file, each once.

    Attributes
    ----------
    pairs
        Ids, the lower id first: (n_contacts, 2).
    peak
        Largest overlaps so far: (n_contacts,), m.
    spring
        Force of the tangential spring on the first sphere, N, and its compliance, m/N:
        (n_contacts, 4).
    block
        History of laws, losses and resistances: (n_contacts, n_block).
    """

    pairs: NDArray[np.int64]
    peak: NDArray[np.float64]
    spring: NDArray[np.float64]
    block: NDArray[np.float64]


@dataclasses.dataclass(frozen=True, eq=False)
class RestartWall:
    """Contacts of spheres with one of the two walls of a fix.

    Attributes
    ----------
    fix
        ID of the fix.
    ids
        Ids of the spheres with a dent there: (n,).
    touching
        True for spheres that touch it: (n,).
    overlap
        Overlaps; the larger one for a sphere that touches both walls: (n,), m.
    peak
        Largest overlaps so far: (n,), m.
    place
        Positions of the largest overlaps along the wall: (n, 2), m.
    side
        0 for the lower wall, 1 for the upper one.
    rest
        History of springs, losses and resistances at both walls: (n, n_rest).
    """

    fix: str
    ids: NDArray[np.int64]
    touching: NDArray[np.bool_]
    overlap: NDArray[np.float64]
    peak: NDArray[np.float64]
    place: NDArray[np.float64]
    side: int
    rest: NDArray[np.float64]

    def springs(self, *, friction: bool) -> NDArray[np.float64]:
        """Return force and compliance of the tangential springs: (n, 4), N and m/N."""
        if not friction or self.rest.shape[1] < 2 * _SPRING:
            return np.zeros((len(self.ids), _STRETCH))
        first = self.side * _SPRING
        return self.rest[:, first : first + _STRETCH]

    def blocks(self, *, friction: bool) -> NDArray[np.float64]:
        """Return the history of losses and resistances: (n, n_block)."""
        rest = self.rest[:, 2 * _SPRING :] if friction else self.rest
        size = rest.shape[1] // 2
        return rest[:, self.side * size : (self.side + 1) * size]


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
    spin
        Angular velocities: (n, 3), rad/s.
    contacts
        Contacts between them; None if the file has none of pair style gran/hysteretic.
    walls
        Their contacts with walls.
    other_walls
        IDs and styles of fixes of walls whose states are not known.
    bodies
        Numbers of bodies, positive integers common to the spheres of a body (``fix property/atom
        mol``); 0 for single spheres: (n,).
    """

    position: NDArray[np.float64]
    velocity: NDArray[np.float64]
    radius: NDArray[np.float64]
    mass: NDArray[np.float64]
    kind: NDArray[np.int64]
    spin: NDArray[np.float64]
    contacts: RestartContacts | None
    walls: tuple[RestartWall, ...]
    other_walls: tuple[tuple[str, str], ...]
    bodies: NDArray[np.int64]


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
    if _DATA_FILE.search(content[:_HEAD_OF_DATA]) is not None:
        raise ValueError(
            "found a LAMMPS data file, which has no plastic indentations and springs; expected a "
            'restart file: add write_restart next to write_data, or use packing.kind = "file"'
        )
    if content.startswith(_MARK) and not content.endswith(_MARK):
        raise ValueError(
            "found a LAMMPS restart file without its end; it is truncated: copy it again"
        )
    if not content.startswith(_MARK):
        raise ValueError("found no LAMMPS restart file, expected a file written by write_restart")
    records = _records(content)
    if not records:
        raise ValueError("found no spheres, expected a restart file of atom_style sphere")
    rows = np.array([record[:_SHORTEST] for record in records])
    ids = rows[:, _ID].copy().view(np.int64)
    order = np.argsort(ids)
    if not np.array_equal(ids[order], np.arange(1, len(ids) + 1)):
        raise ValueError(
            f"found ids up to {ids.max()} of {len(ids)} spheres, expected 1, 2, ...; "
            "use reset_atoms id before write_restart"
        )
    rows = rows[order]
    fixes = _fixes(content)
    states = [list(_states(records[row], len(fixes))) for row in order.tolist()]
    lengths = [_SHORTEST + sum(map(len, of_sphere)) for of_sphere in states]
    if fixes and lengths != [len(records[row]) for row in order.tolist()]:
        raise ValueError("found atoms with additional attributes, expected atom_style sphere")
    spheres = RestartSpheres(
        rows[:, _PLACE],
        rows[:, _VELOCITY],
        rows[:, _RADIUS],
        rows[:, _MASS],
        rows[:, _TYPE].copy().view(np.int64),
        rows[:, _SPIN],
        _contacts(fixes, states),
        tuple(_walls(fixes, states)),
        tuple(
            (name, style)
            for name, style in fixes
            if style.startswith(_OTHER_WALLS) and style != _WALL
        ),
        _bodies(fixes, states),
    )
    if not (spheres.radius > 0).all() or not np.isfinite(rows[:, _PLACE]).all():
        raise ValueError("found atoms without a radius, expected atom_style sphere")
    return spheres


def _records(content: bytes) -> list[NDArray[np.float64]]:
    """Return the record of each sphere."""
    end = len(content) - len(_MARK)
    records: list[NDArray[np.float64]] = []
    while (chunk := _last_chunk(content, end)) is not None:
        start, rows = chunk
        records = rows + records
        end = start
    return records


def _last_chunk(content: bytes, end: int) -> tuple[int, list[NDArray[np.float64]]] | None:
    """Return the position where the values of a process begin, given their end, with its flag and
    its records.
    """
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


def _split(values: NDArray[np.float64]) -> list[NDArray[np.float64]] | None:
    """Return the records; None if the values are not records."""
    rows = []
    place = 0
    while place < len(values):
        length = values[place]
        if not (_SHORTEST <= length <= len(values) - place) or length != int(length):
            return None
        rows.append(values[place : place + int(length)])
        place += int(length)
    return rows


def _fixes(content: bytes) -> list[tuple[str, str]]:
    """Return IDs and styles of the fixes with states of spheres, in their order."""
    name, style = _HISTORY
    mark = _text(name) + _text(style)
    place = content.rfind(mark)
    if place < 0:
        return []
    for start in range(max(0, place - _FARTHEST), place):
        fixes = _list_of_fixes(content, start, place)
        if fixes:
            return fixes
    return []


def _text(word: str) -> bytes:
    """Return a word in the format of a restart file."""
    return struct.pack("<i", len(word) + 1) + word.encode() + b"\0"


def _list_of_fixes(content: bytes, start: int, history: int) -> list[tuple[str, str]]:
    """Return the list of fixes that starts at a position, if the fix of contacts is in it, at
    another position.
    """
    (count,) = struct.unpack_from("<i", content, start)
    if not 0 < count <= _MOST_FIXES:
        return []
    place = start + _WORD
    fixes = []
    has_history = False
    for _ in range(count):
        has_history = has_history or place == history
        name, place = _word_at(content, place)
        style, place = _word_at(content, place)
        if not name or not style:
            return []
        fixes.append((name, style))
        place += _WORD  # its largest size
    return fixes if has_history else []


def _word_at(content: bytes, place: int) -> tuple[str, int]:
    """Return the word at a position and its end; an empty word if there is none."""
    if place + _WORD > len(content):
        return "", place
    (length,) = struct.unpack_from("<i", content, place)
    text = content[place + _WORD : place + _WORD + max(length, 0)]
    if not 1 < length <= _LONGEST_NAME or text[-1:] != b"\0" or not text[:-1].isascii():
        return "", place
    word = text[:-1].decode("ascii")
    return (word if word.isprintable() else ""), place + _WORD + length


def _states(record: NDArray[np.float64], n_fixes: int) -> Iterator[NDArray[np.float64]]:
    """Yield the states of a sphere in the fixes."""
    place = _SHORTEST
    for _ in range(n_fixes):
        if place >= len(record):
            return
        size = int(record[place])
        yield record[place : place + size]
        place += max(size, 1)


_Fixes = Sequence[tuple[str, str]]
_States = Sequence[Sequence[NDArray[np.float64]]]


def _contacts(fixes: _Fixes, states: _States) -> RestartContacts | None:
    """Return the contacts between spheres, from the state of the sphere with the lower ID."""
    if _HISTORY not in fixes:
        return None
    number = fixes.index(_HISTORY)
    pairs = []
    rows = []
    block = 0
    for sphere, of_sphere in enumerate(states, start=1):
        block = max(block, int(of_sphere[number][_HEAD + _BLOCK]))
        for partner, row in _contacts_of(of_sphere[number][_HEAD:]):
            if sphere < partner:
                pairs.append((sphere, partner))
                rows.append(row)
    table = np.zeros((len(rows), 1 + _STRETCH + block))
    for place, row in enumerate(rows):
        table[place, : len(row)] = row
    ids = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    return RestartContacts(ids, table[:, 0], table[:, 1 : 1 + _STRETCH], table[:, 1 + _STRETCH :])


def _contacts_of(state: NDArray[np.float64]) -> Iterator[tuple[int, NDArray[np.float64]]]:
    """Yield the partners of a sphere, with peak, spring and block of each contact."""
    n_block = int(state[_BLOCK])
    parts = int(state[_PARTS])
    has_spring = parts in (_BOTH, _WITH_SPRING)
    has_dents = parts in (_BOTH, _WITH_DENTS)
    place = _RECORDS + (_SUMS if state[_HAS_SUMS] else 0)
    further = n_block + has_spring * _SPRING + has_dents * (_DENTS + n_block)
    for _ in range(int(state[_COUNT])):
        record = state[place : place + _RECORD]
        rest = state[place + _RECORD : place + _RECORD + further]
        place += _RECORD + further
        partner = int(record[_PARTNER : _PARTNER + 1].view(np.int64)[0])
        if not record[_LIVE : _LIVE + 1].view(np.int32)[1]:
            continue
        spring = rest[n_block : n_block + _STRETCH] if has_spring else np.zeros(_STRETCH)
        yield partner, np.concatenate([record[_PEAK : _PEAK + 1], spring, rest[:n_block]])


def _bodies(fixes: _Fixes, states: _States) -> NDArray[np.int64]:
    """Return the number of the body of each sphere, 0 for single spheres."""
    bodies = np.zeros(len(states), dtype=np.int64)
    for number, (_, style) in enumerate(fixes):
        if style != _PROPERTIES:
            continue
        table = np.array([of_sphere[number][1:] for of_sphere in states])
        for values in table.T.copy().view(np.int64):
            if not ((values >= 0) & (values <= _LARGEST_NUMBER)).all():
                continue
            _, of_each, counts = np.unique(values, return_inverse=True, return_counts=True)
            shared = (values > 0) & (counts[of_each] > 1)
            bodies = np.where(shared, values, bodies)
    return bodies


def _states_at_wall(rows: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return the states of all spheres in a wall: of a sphere that has not touched it the file
    contains only the size of the state, and its row is zero.
    """
    n_columns = max([_REPORTED + 2 * _SIDE] + [len(row) for row in rows])
    table = np.zeros((len(rows), n_columns))
    for sphere, row in enumerate(rows):
        if len(row) > 1:
            table[sphere, : len(row)] = row
    return table


def _walls(fixes: _Fixes, states: _States) -> Iterator[RestartWall]:
    """Yield the contacts with the walls of each fix."""
    for number, (name, style) in enumerate(fixes):
        if style != _WALL:
            continue
        table = _states_at_wall([of_sphere[number][_HEAD:] for of_sphere in states])
        rest = table[:, _REPORTED + 2 * _SIDE :]
        for side in range(2):
            first = _REPORTED + side * _SIDE
            own = table[:, first : first + _SIDE]
            dented = np.flatnonzero((own[:, _DENT] > 0) | (own[:, _TOUCHING] != 0))
            if not len(dented):
                continue
            yield RestartWall(
                fix=name,
                ids=dented + 1,
                touching=own[dented, _TOUCHING] != 0,
                overlap=table[dented, _OVERLAP],
                peak=own[dented, _DENT],
                place=own[dented, _PLACE_OF_DENT],
                side=side,
                rest=rest[dented],
            )
