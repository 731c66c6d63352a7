"""Grains at places of their own: the rows of ``packing.file``, or of the same text in
``packing.grains``.

    x, y, z, diameter                    m; depth is +z
    shape, length                        sphere or cylinder, and the length of this, m
    axis                                 direction of the axis of a cylinder: x, y (the default) or z; or
    axis_x, axis_y, axis_z               any direction
    material                             name of a preset or of a [materials.NAME]; by default that of the packing
    group                                a word, for [[hold]]
    vx, vy, vz                           initial velocity, m/s

Columns stand in any order under a line of their names. Other formats are read by ASE, in metres,
with diameters (or radii) and materials from arrays of these names.
"""

from __future__ import annotations

import dataclasses
import math
from bisect import bisect_right
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.hints import POSSIBLE, plain
from granwave.lammps_inputs.case.material import AXIS_COLUMNS, Shape, read_shapes, shape_columns
from granwave.lammps_inputs.case.schema import LABEL_FORM, LARGEST_COUNT, show
from granwave.lammps_inputs.files import csv_cell, csv_rows, read_number, read_regular, read_text

_PLACE = ("x", "y", "z")
_VELOCITY = ("vx", "vy", "vz")
_NUMBERS = (*_PLACE, "diameter", "length", *AXIS_COLUMNS, *_VELOCITY)
_WORDS = ("material", "group")
COLUMNS = (*_PLACE, "diameter", "shape", "length", "axis", *AXIS_COLUMNS, *_WORDS, *_VELOCITY)
_RADIUS = "radius"  # column in place of the diameter
_TABLES = (".csv", ".txt", ".dat")  # suffixes of files that are tables; ASE reads the rest
_SIZES = ("diameter", "length")
_UNITS = {**dict.fromkeys((*_PLACE, *_SIZES), "m"), **dict.fromkeys(_VELOCITY, "m/s")}
_STRAIGHT = 1e-9  # components of the edges of a box across its axes, over its largest edge


@dataclasses.dataclass(eq=False)
class Grains:
    """Grains in the order of their ids, which count from 1; equal if their text is equal.

    Attributes
    ----------
    position
        Centres: (n, 3), m.
    diameter
        (n,), m.
    material
        Names of the materials; empty for that of the packing: (n,).
    group
        Names of the groups; empty for none: (n,).
    velocity
        Initial velocities: (n, 3), m/s.
    shape
        Shapes: (n,); by default all are spheres.
    period
        Periods along x and y of the file that they come from, m; None if it has none. Not part of
        the table, as the four below.
    file
        Name of the file that they come from; empty if from no file.
    lines
        Lines of the file, from 1, of those that come from a table: (at most n,).
    added_from
        First id of each entry of ``[[grains]]``.
    found
        The grains as they were found, of those that were moved until they touch.
    """

    position: NDArray[np.float64]
    diameter: NDArray[np.float64]
    material: Sequence[str]
    group: Sequence[str]
    velocity: NDArray[np.float64]
    shape: Sequence[Shape] = ()
    period: tuple[float, float] | None = None
    file: str = ""
    lines: Sequence[int] = ()
    added_from: Sequence[int] = ()
    found: Grains | None = None

    def __post_init__(self) -> None:
        """Make the columns tuples."""
        self.material, self.group = tuple(self.material), tuple(self.group)
        self.shape = tuple(self.shape) or (None,) * len(self)

    def __len__(self) -> int:
        return len(self.diameter)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Grains) and self.text == other.text

    def __hash__(self) -> int:
        return hash(self.text)

    @cached_property
    def text(self) -> str:
        """The grains as a table, with only the columns that are used; numbers keep all their
        digits.
        """
        columns: dict[str, Iterable[str]] = {
            **{
                name: map(repr, values)
                for name, values in zip(_PLACE, self.position.T.tolist(), strict=True)
            },
            "diameter": map(repr, self.diameter.tolist()),
        }
        columns |= shape_columns(self.shape)
        named = (("material", self.material), ("group", self.group))
        columns |= {name: map(csv_cell, words) for name, words in named if any(words)}
        if self.velocity.any():
            columns |= {
                name: map(repr, v)
                for name, v in zip(_VELOCITY, self.velocity.T.tolist(), strict=True)
            }
        lines = [",".join(columns), *(",".join(row) for row in zip(*columns.values(), strict=True))]
        return "\n".join(lines) + "\n"

    @property
    def usual_diameter(self) -> float:
        """Most frequent diameter, the larger one of several, m."""
        diameters, counts = np.unique(self.diameter, return_counts=True)
        return float(diameters[counts == counts.max()].max())

    def key(self, *ids: int) -> str:
        """Return the key of a case that gave some grains, of the last of them that were added."""
        if entry := bisect_right(self.added_from, max(ids)):
            return f"grains.{entry}"
        return "packing.file" if self.file else "packing.grains"

    def called(self, number: int) -> str:
        """Return the id of a grain, with its line in the file."""
        in_table = self.file and number <= len(self.lines)
        return f"{number} (line {self.lines[number - 1]})" if in_table else f"{number}"

    def of_group(self, name: str) -> tuple[int, ...]:
        """Return the ids of the grains of a group."""
        return tuple(number for number, group in enumerate(self.group, start=1) if group == name)


def read_grains(path: Path, diameter: float | None) -> Grains:
    """Read a file of grains.

    Parameters
    ----------
    diameter
        Diameter of grains for which the file gives none, m; None: the file must give it.

    Raises
    ------
    ValueError
        The file is not a table of grains; the message says where and why.
    OSError
        It cannot be read.
    """
    is_table = path.suffix.lower() in _TABLES
    grains = parse_grains(read_text(path), diameter) if is_table else _from_ase(path, diameter)
    grains.file = str(path)
    return grains


def read_cell(path: Path) -> list[list[float]]:
    """Read the vectors after which the grains of a file of ASE repeat, m; none of a table."""
    if path.suffix.lower() in _TABLES:
        return []
    atoms = _read_ase(path)
    return [vector.tolist() for vector, repeats in zip(atoms.cell.array, atoms.pbc, strict=True)
            if repeats and vector.any()]  # fmt: skip


def parse_grains(text: str, diameter: float | None) -> Grains:
    """Read a table of grains; see `read_grains`."""
    rows = csv_rows(text)
    if not rows:
        raise ValueError(
            f"found no grain, expected a line of names ({', '.join(COLUMNS)}) and a row for each grain"
        )
    heads = [name.strip() for name in rows[0][1]]
    names = _column_names(
        ["diameter" if name == _RADIUS else name for name in heads], rows[0][0], diameter
    )
    lines = [number for number, _ in rows[1:]]
    places = [f"line {number}" for number, _ in rows[1:]]
    for place, (_, row) in zip(places, rows[1:], strict=True):
        if len(row) != len(names):
            raise ValueError(
                f"{place}: found {len(row)} values, expected {len(names)}: {', '.join(names)}"
            )
    columns = zip(*(row for _, row in rows[1:]), strict=True)
    values: dict[str, list[Any]] = {
        name: [
            (_number if name in _NUMBERS else _word)(*cell, name)
            for cell in zip(column, places, strict=True)
        ]
        for name, column in zip(names, columns, strict=False)
    }
    if _RADIUS in heads:
        values["diameter"] = [2 * radius for radius in values["diameter"]]
    grains = _grains(values, places, diameter)
    grains.lines = lines
    return grains


def _column_names(names: list[str], line: int, diameter: float | None) -> list[str]:
    for name in names:
        if name not in COLUMNS:
            raise ValueError(
                f"line {line}: found a column {show(name)}, expected names among {', '.join(COLUMNS)}"
            )
        if names.count(name) > 1:
            either = " (or radius for it)" if name == "diameter" else ""
            raise ValueError(f"line {line}: found the column {name}{either} twice")
    needed = _PLACE if diameter is not None else (*_PLACE, "diameter")
    for name in needed:
        if name not in names:
            more = ", or packing.diameter for all grains" if name == "diameter" else ""
            raise ValueError(
                f"line {line}: found no column {name}, expected {', '.join(needed)}{more}"
            )
    return names


def _number(value: str, place: str, name: str) -> float:
    if not value.strip() and name in ("length", *AXIS_COLUMNS):
        return 0.0  # of a sphere
    try:
        number = read_number(value)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ValueError(
            f"{place}: found {show(value.strip())} for {name}, expected a finite number"
        )
    return number


def _word(value: str, place: str, name: str) -> str:
    word = value.strip()
    if not word.isprintable():
        raise ValueError(f"{place}: found {show(word)} for {name}, expected {LABEL_FORM}")
    return word


def _grains(
    values: Mapping[str, list[Any]], places: Sequence[str], diameter: float | None
) -> Grains:
    """Make the grains of columns of values; ``places`` names the place of each grain in the file."""
    n = len(places)
    if not n:
        raise ValueError("found no grain, expected a row for each below the line of names")
    if n > LARGEST_COUNT:
        raise ValueError(f"found {n} grains, expected at most {LARGEST_COUNT}")
    sizes = np.array(values.get("diameter", [diameter] * n), dtype=np.float64)
    if not (sizes > 0).all():
        first = int(np.argmin(sizes > 0))
        raise ValueError(
            f"{places[first]}: found a diameter of {sizes[first]:g} m, expected one above 0"
        )
    for name, unit in _UNITS.items():
        low, high = (
            POSSIBLE[unit] if name in _SIZES else (0.0, POSSIBLE[unit][1])
        )  # rounding may leave places off 0
        for place, value in zip(places, values.get(name, ()), strict=False):
            if value and not low <= abs(value) <= high:
                expected = f"expected a magnitude from {plain(low)} to {plain(high)} {unit}"
                raise ValueError(f"{place}: found {value:g} {unit} for {name}, {expected}")
    position, velocity = (np.array([values.get(name, [0.0] * n) for name in names], dtype=np.float64).T.copy()
                          for names in (_PLACE, _VELOCITY))  # fmt: skip
    material, group = (values.get(name, [""] * n) for name in _WORDS)
    return Grains(position, sizes, material, group, velocity, read_shapes(values, places))


def _read_ase(path: Path) -> Any:
    """Read the last frame of a file by ASE."""
    import ase.io  # takes longer to load than most commands need

    read_regular(path)  # raises if it is missing, or no file
    try:
        return ase.io.read(path, index=-1)
    except Exception as error:  # ASE raises exceptions of all kinds
        reason = " ".join(str(error).split()) or type(error).__name__
        tables = ", ".join(_TABLES)
        raise ValueError(
            f"ASE cannot read it ({reason}); expected a format of ASE, or a table ({tables})"
        ) from None


def _from_ase(path: Path, diameter: float | None) -> Grains:
    """Read the last frame of a file by ASE, whose lengths are taken as metres."""
    atoms = _read_ase(path)
    if "momenta" in atoms.arrays and atoms.get_momenta().any():
        raise ValueError(
            "found momenta, whose units are those of atoms; give vx, vy, vz (m/s) in a table"
        )
    places = [f"grain {number}" for number in range(1, len(atoms) + 1)]
    columns: dict[str, Any] = dict(zip(_PLACE, atoms.positions.T, strict=True))
    for name in ("diameter", _RADIUS, "shape", "length", "axis", *AXIS_COLUMNS, *_WORDS):
        for one in ("radii" if name == _RADIUS else f"{name}s", name):
            if one in atoms.arrays:
                columns[name] = atoms.arrays[one]
    if _RADIUS in columns:
        columns["diameter"] = 2 * np.asarray(columns.pop(_RADIUS))
    if "diameter" not in columns and diameter is None:
        raise ValueError(
            "found no diameters, expected an array diameter or radius, or packing.diameter for all grains"
        )
    values: dict[str, list[Any]] = {}
    for name, column in columns.items():
        if name not in _NUMBERS:
            values[name] = [
                _word(str(word), place, name) for place, word in zip(places, column, strict=True)
            ]
            continue
        values[name] = np.asarray(column, dtype=np.float64).tolist()
        if name != "diameter" and not np.isfinite(values[name]).all():
            first = int(np.argmin(np.isfinite(values[name])))
            raise ValueError(f"found {name} of {places[first]} that is no number")
    grains = _grains(values, places, diameter)
    cell = np.asarray(atoms.cell)
    slant = np.abs(cell - np.diag(np.diag(cell))).max()
    if (
        atoms.pbc[:2].all()
        and slant <= _STRAIGHT * np.abs(cell).max()
        and min(cell[0, 0], cell[1, 1]) > 0
    ):
        grains.period = float(cell[0, 0]), float(cell[1, 1])  # a box along x, y and z
    return grains
