"""``packing.springs``: tangential springs of the contacts of a settled bed.

    first, second       ids of two spheres, or a wall (bottom, tube, xlo, xhi, ylo, yhi) and the
                        id of a sphere
    fx, fy, fz          force on the first sphere, or on the sphere at a wall, N
    compliance          displacement / force of the spring, m/N

A bed that is supported by friction, and returns to equilibrium, starts with them.
"""

from __future__ import annotations

import csv
import dataclasses
import math
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.schema import ValidationError
from granwave.lammps_inputs.restart_file import RestartSpheres

WALL_NAMES = ("bottom", "tube", "xlo", "xhi", "ylo", "yhi")
_COLUMNS = ("first", "second", "fx", "fy", "fz", "compliance")
_FORM = f"a table of springs as text, with the columns {', '.join(_COLUMNS)}"
_NO_PATH = f"{_FORM}; the text of the file, between triple quotes, and not its path"
_NUMBERS = 4


@dataclasses.dataclass(frozen=True)
class ContactSpring:
    """Tangential spring of a contact.

    Attributes
    ----------
    first
        Id of a sphere, or name of a wall.
    second
        Id of the other sphere.
    force
        Force on the first sphere, or on the sphere at a wall: (3,), N.
    compliance
        Displacement / force, m/N.
    """

    first: int | str
    second: int
    force: tuple[float, float, float]
    compliance: float


def parse_springs(text: str) -> tuple[ContactSpring, ...]:
    """Read a table of springs.

    Raises
    ------
    ValueError
        It is none; the message says where and why.
    """
    head, *rows = csv.reader(text.splitlines()) if text.strip() else [[]]
    if tuple(head) != _COLUMNS:
        raise ValueError(f"found the columns {', '.join(head) or 'none'}")
    return tuple(_spring(row, line) for line, row in enumerate(rows, start=2))


def _is_path(text: str) -> bool:
    """Return True for one line of text without a comma."""
    line = text.strip()
    return bool(line) and len(line.splitlines()) == 1 and "," not in line


def _spring(row: list[str], line: int) -> ContactSpring:
    """Return the spring of a row."""
    try:
        first, second, *words = row
        numbers = [float(word) for word in words]
        wall = first in WALL_NAMES
        spring = ContactSpring(
            first if wall else int(first),
            int(second),
            (numbers[0], numbers[1], numbers[2]),
            numbers[3],
        )
    except (ValueError, IndexError):
        raise ValueError(f"line {line}: found {','.join(row)}") from None
    sound = all(math.isfinite(number) for number in numbers) and numbers[3] >= 0
    lower = isinstance(spring.first, str) or 0 < spring.first < spring.second
    if len(numbers) != _NUMBERS or not sound or not lower or spring.second < 1:
        raise ValueError(f"line {line}: found {','.join(row)}")
    return spring


def springs_table(spheres: RestartSpheres, walls: Mapping[tuple[str, int], str]) -> str:
    """Return the tangential springs of a restart file as a table.

    Parameters
    ----------
    walls
        Names of walls by fix and side: 0 for the lower wall, 1 for the upper one. Springs at other
        walls are omitted.
    """
    return "\n".join([",".join(_COLUMNS), *_rows(spheres, walls)]) + "\n"


def _rows(spheres: RestartSpheres, walls: Mapping[tuple[str, int], str]) -> Iterator[str]:
    """Return the rows of the springs with a force."""
    if spheres.contacts is not None:
        for pair, spring in zip(spheres.contacts.pairs, spheres.contacts.spring, strict=True):
            if spring.any():
                first, second = pair.tolist()
                yield f"{first},{second},{','.join(map(repr, spring.tolist()))}"
    for wall in spheres.walls:
        name = walls.get((wall.fix, wall.side))
        if name is None:
            continue
        for sphere, spring in zip(wall.ids.tolist(), wall.springs(friction=True), strict=True):
            if spring.any():
                yield f"{name},{sphere},{','.join(map(repr, spring.tolist()))}"


@dataclasses.dataclass(frozen=True)
class SpringsType(schema.ValueType):
    """Type of a table of springs, which stays text."""

    expected: str = _FORM
    kind: ClassVar[str] = "string"

    def read(self, value: Any) -> str:
        """Return the text."""
        schema.refuse_if(not isinstance(value, str), self.expected)
        schema.refuse_if(_is_path(value), _NO_PATH)
        try:
            parse_springs(value)
        except ValueError as error:
            raise ValidationError(f"{self.expected}; {error}") from None
        return str(value)

    @property
    def json(self) -> dict[str, Any]:
        """A string."""
        return {"type": "string"}
