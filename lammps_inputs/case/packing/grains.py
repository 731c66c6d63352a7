"""Grains at user-defined positions: the rows of ``packing.file``, or of the same text in
``packing.grains``.

    x, y, z, diameter       m; depth is +z
    shape, length           sphere or cylinder, and the length of a cylinder, m
    axis                    direction of the axis of a cylinder: x, y (the default) or z; or any
                            direction in three columns: axis_x, axis_y, axis_z
    material                name of a preset or of a [materials.NAME]; by default the material of
                            the packing
    group                   a word, for [[hold]]
    clump                   a number; grains with the same number move as one rigid body
    vx, vy, vz              initial velocity, m/s
    omegax, omegay, omegaz  initial angular velocity, rad/s

Columns are in any order below a line of names. Tables of other programs, and other
formats, are read by `granwave.lammps_inputs.readers`.
"""

from __future__ import annotations

import dataclasses
import math
from bisect import bisect_right
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.hints import POSSIBLE, plain
from granwave.lammps_inputs.case.material import Shape, read_shapes, shape_columns
from granwave.lammps_inputs.case.schema import LABEL_FORM, LARGEST_COUNT, show
from granwave.lammps_inputs.files import csv_cell
from granwave.lammps_inputs.readers.columns import CLUMP
from granwave.lammps_inputs.readers.grain_table import GrainTable
from granwave.lammps_inputs.readers.registry import read_grain_table
from granwave.lammps_inputs.readers.source import FileOptions, GrainSource
from granwave.lammps_inputs.readers.table import read_table_text

_PLACE = ("x", "y", "z")
_VELOCITY = ("vx", "vy", "vz")
_SPIN = ("omegax", "omegay", "omegaz")
_WORDS = ("material", "group")
_SHAPE_COLUMNS = ("shape", "axis")
_LARGEST_RATIO = 300.0  # largest ratio of a grain to the median; beyond, units may be mixed
_TYPES_IN_EXAMPLE = 2


@dataclasses.dataclass(frozen=True)
class FileReading:
    """Facts about a file of grains that was read.

    Attributes
    ----------
    format
        Name of the format, with the step.
    types
        Number of grains of each type of the file.
    bounds
        Lowest and highest x, y, z of the box: (3, 2), m; None if the file has none.
    periodic
        Axes along which the box is periodic.
    density
        Smallest and largest density in the file, kg/m^3; None if it has none.
    notes
        Warnings for the user.
    units
        Unit of the lengths as set by the user; empty if it was not set.
    """

    format: str
    types: dict[str, int]
    bounds: NDArray[np.float64] | None
    periodic: tuple[bool, bool, bool]
    density: tuple[float, float] | None
    notes: Sequence[str]
    units: str = ""


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
        Names of the materials; empty for the material of the packing: (n,).
    group
        Names of the groups; empty for none: (n,).
    velocity
        Initial velocities: (n, 3), m/s.
    shape
        Shapes: (n,); by default all are spheres.
    clump
        Numbers of clumps, 0 for grains without a clump: (n,); by default all 0.
    spin
        Initial angular velocities: (n, 3), rad/s; by default none.
    period
        Periods along x and y of the file of the grains, m; None if it has none. Not part of
        the table, as those below.
    file
        Name of the file of the grains; empty without a file.
    lines
        Lines in the file, from 1, of grains from a table: (at most n,).
    half_unit
        Half a unit of the last digit of each coordinate in the file: (at most n, 3), m.
    cell
        Vectors after which they repeat, of a file that has them, m.
    reading
        Content of the file; None without a file.
    added_from
        First id of each entry of ``[[grains]]``.
    found
        The original grains, if grains were moved until they touch.
    """

    position: NDArray[np.float64]
    diameter: NDArray[np.float64]
    material: Sequence[str]
    group: Sequence[str]
    velocity: NDArray[np.float64]
    shape: Sequence[Shape] = ()
    period: tuple[float, float] | None = None
    file: str = ""
    lines: Sequence[int] | NDArray[np.int64] = ()
    half_unit: NDArray[np.float64] = dataclasses.field(default_factory=lambda: np.zeros((0, 3)))
    cell: Sequence[Sequence[float]] = ()
    reading: FileReading | None = None
    added_from: Sequence[int] = ()
    found: Grains | None = None
    clump: NDArray[np.int64] = dataclasses.field(default_factory=lambda: np.zeros(0, np.int64))
    spin: NDArray[np.float64] = dataclasses.field(default_factory=lambda: np.zeros((0, 3)))

    def __post_init__(self) -> None:
        """Make the columns of words tuples, and give every grain a shape, a clump and a spin."""
        self.material, self.group = tuple(self.material), tuple(self.group)
        self.shape = tuple(self.shape) or (None,) * len(self)
        if not len(self.clump):
            self.clump = np.zeros(len(self), dtype=np.int64)
        if not len(self.spin):
            self.spin = np.zeros((len(self), 3))

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
        if self.clump.any():
            columns[CLUMP] = map(str, self.clump.tolist())
        for names, vectors in ((_VELOCITY, self.velocity), (_SPIN, self.spin)):
            if vectors.any():
                parts = zip(names, vectors.T.tolist(), strict=True)
                columns |= {name: map(repr, part) for name, part in parts}
        lines = [",".join(columns), *(",".join(row) for row in zip(*columns.values(), strict=True))]
        return "\n".join(lines) + "\n"

    @property
    def usual_diameter(self) -> float:
        """Most frequent diameter, m; the largest one if several are equally frequent."""
        diameters, counts = np.unique(self.diameter, return_counts=True)
        return float(diameters[counts == counts.max()].max())

    @cached_property
    def clumps(self) -> dict[int, tuple[int, ...]]:
        """Ids of the grains of each clump, by its number; a single grain is not a clump."""
        rows = np.flatnonzero(self.clump)
        order = rows[np.argsort(self.clump[rows], kind="stable")]
        numbers, first = np.unique(self.clump[order], return_index=True)
        members = np.split(1 + order, first[1:])
        parts = zip(numbers.tolist(), members, strict=True) if len(numbers) else ()
        return {number: tuple(ids.tolist()) for number, ids in parts if len(ids) > 1}

    def of_different_clumps(self, rows: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Select the pairs of rows (n, 2) of grains of different clumps: (n,)."""
        first, second = self.clump[rows].T
        return np.asarray((first == 0) | (first != second))

    def key(self, *ids: int) -> str:
        """Return the key of the case that added the last of some grains."""
        if entry := bisect_right(self.added_from, max(ids)):
            return f"grains.{entry}"
        return "packing.file" if self.file else "packing.grains"

    def called(self, number: int) -> str:
        """Return the id of a grain, with its line in the file."""
        in_table = bool(self.file) and number <= len(self.lines)
        return f"{number} (line {self.lines[number - 1]})" if in_table else f"{number}"

    def of_group(self, name: str) -> tuple[int, ...]:
        """Return the ids of the grains of a group."""
        return tuple(number for number, group in enumerate(self.group, start=1) if group == name)


@dataclasses.dataclass(frozen=True, kw_only=True)
class GrainChoices:
    """Choices of the user for the grains of a file.

    Attributes
    ----------
    materials
        Names of materials by type of the file; empty: types have no meaning.
    keeps_velocities
        False: the velocities of the file are omitted.
    up
        Direction of the file that points up, a key of `TURNS`.
    """

    materials: Mapping[str, str] = dataclasses.field(default_factory=dict)
    keeps_velocities: bool = True
    up: str = "-z"


def read_grains(source: GrainSource, choices: GrainChoices | None = None) -> Grains:
    """Read a file of grains.

    Parameters
    ----------
    source
        The file, with the user's settings for it.
    choices
        Treatment of its grains.

    Raises
    ------
    ValueError
        The file is no file of grains; the message says where and why.
    OSError
        It cannot be read.
    """
    choices = choices or GrainChoices()
    table = read_grain_table(source)
    if not choices.keeps_velocities:
        table.velocity = None
        table.spin = None
    if choices.materials:
        _name_materials(table, choices.materials)
    if choices.up != "-z":
        _turn(table, choices.up)
    grains = _grains(table, source.options.diameter)
    grains.file = str(source.path)
    grains.period = table.period
    grains.cell = table.cell
    reading = _reading(table, grains, choices.materials)
    grains.reading = dataclasses.replace(reading, units=source.options.units)
    return grains


def parse_grains(text: str, diameter: float | None) -> Grains:
    """Read a table of grains.

    Parameters
    ----------
    diameter
        Diameter of grains for which the table gives none, m; None: the table must give it.

    Raises
    ------
    ValueError
        It is no table of grains; the message says where and why.
    """
    return _grains(read_table_text(text, FileOptions(diameter=diameter)).in_order(), diameter)


def _turn(table: GrainTable, up: str) -> None:
    """Rotate the grains of a file until a given direction points up."""
    if "axis" in table.words or "length" in table.numbers:
        raise ValueError(
            f'found packing.up = "{up}" with cylinders, whose axes are not rotated; write their '
            "positions with the top at the lowest z"
        )
    table.turn(up)


def _name_materials(table: GrainTable, materials: Mapping[str, str]) -> None:
    """Give grains the material of their type."""
    if not table.types:
        raise ValueError("found no types of grains (packing.types), expected a column of them")
    there = dict.fromkeys(table.types)
    missing = [name for name in there if name not in materials]
    unused = [name for name in materials if name not in there]
    if missing or unused:
        what = f"no material of the type {missing[0]}" if missing else f"no type {unused[0]}"
        raise ValueError(
            f"found {what} (packing.types), expected one for each of {', '.join(there)}"
        )
    table.words["material"] = [materials[name] for name in table.types]


def _reading(table: GrainTable, grains: Grains, materials: Mapping[str, str]) -> FileReading:
    """Return the content of a file, with its warnings."""
    types = dict(Counter(table.types))
    notes = list(table.notes)
    has_materials = bool(materials) or "material" in table.words
    if len(types) > 1 and not has_materials:
        shown = _in_natural_order(types)[:_TYPES_IN_EXAMPLE]
        example = ", ".join(f'{show(name)} = "steel"' for name in shown)
        more = ", ..." if len(types) > len(shown) else ""
        notes.append(
            f"{len(types)} types of grains become one material; packing.types = "
            f"{{{example}{more}}} assigns one to each"
        )
    ratios = grains.diameter / np.median(grains.diameter)
    for row in (int(np.argmax(ratios)), int(np.argmin(ratios))):
        if not 1 / _LARGEST_RATIO < ratios[row] < _LARGEST_RATIO:
            notes.append(
                f"{table.place(row)}: a diameter of {grains.diameter[row]:g} m is "
                f"{ratios[row]:.3g} times the median; are there two units in the file?"
            )
    density = _densities(table, grains)
    bounds = None if density is None else (float(density.min()), float(density.max()))
    return FileReading(
        format=table.format,
        types=types,
        bounds=table.bounds,
        periodic=table.periodic,
        density=bounds,
        notes=notes,
    )


def _densities(table: GrainTable, grains: Grains) -> NDArray[np.float64] | None:
    """Return the densities in a file, for spheres also computed from their masses: (n,), kg/m^3;
    None without any.
    """
    if table.density is not None or table.mass is None or any(grains.shape):
        return table.density
    return np.asarray(table.mass / (math.pi / 6 * grains.diameter**3))


def _in_natural_order(names: Iterable[str]) -> list[str]:
    """Return names of types: numbers by value, then words."""
    return sorted(names, key=lambda name: (not name.isdigit(), len(name) * name.isdigit(), name))


def _words_of(table: GrainTable, name: str) -> list[str]:
    """Return a column of words: (n,); empty words if the table has no such column."""
    words = table.words.get(name)
    if words is None:
        return [""] * len(table)
    for row, word in enumerate(words):
        if not word.isprintable():
            raise ValueError(
                f"{table.place(row)}: found {show(word)} for {name}, expected {LABEL_FORM}"
            )
    return words


def _check_magnitudes(
    table: GrainTable, name: str, values: NDArray[np.float64], unit: str, *, is_size: bool
) -> None:
    """Raise ValueError if a value is impossible in its unit; small positions may be rounding."""
    low, high = POSSIBLE[unit]
    low = low if is_size else 0.0
    size = np.abs(values)
    wrong = ~np.isfinite(values) | ((size > 0) & ((size < low) | (size > high)))
    if not wrong.any():
        return
    row = int(np.argmax(wrong))
    if not np.isfinite(values[row]):
        raise ValueError(
            f"{table.place(row)}: found {values[row]:g} for {name}, expected a finite number"
        )
    expected = f"expected a magnitude from {plain(low)} to {plain(high)} {unit}"
    raise ValueError(f"{table.place(row)}: found {values[row]:g} {unit} for {name}, {expected}")


def _diameters(table: GrainTable, diameter: float | None) -> NDArray[np.float64]:
    """Return the diameters of the grains: (n,), m."""
    if table.radius is not None:
        return 2 * table.radius
    if diameter is None:
        raise ValueError(
            "found no diameters; add a column of diameters, or set packing.diameter for all grains"
        )
    return np.full(len(table), diameter)


def _grains(table: GrainTable, diameter: float | None) -> Grains:
    """Make the grains from the result of a reader."""
    n = len(table)
    if not n:
        raise ValueError("found no grain, expected a row for each below the line of names")
    if n > LARGEST_COUNT:
        raise ValueError(f"found {n} grains, expected at most {LARGEST_COUNT}")
    sizes = _diameters(table, diameter)
    if not (sizes > 0).all() and np.isfinite(sizes).all():
        first = int(np.argmin(sizes > 0))
        raise ValueError(
            f"{table.place(first)}: found a diameter of {sizes[first]:g} m, expected one above 0"
        )
    for name, values in zip(_PLACE, table.position.T, strict=True):
        _check_magnitudes(table, name, values, "m", is_size=False)
    _check_magnitudes(table, "diameter", sizes, "m", is_size=True)
    if "length" in table.numbers:
        _check_magnitudes(table, "length", table.numbers["length"], "m", is_size=True)
    velocity = np.zeros((n, 3)) if table.velocity is None else table.velocity
    for name, values in zip(_VELOCITY, velocity.T, strict=True):
        _check_magnitudes(table, name, values, "m/s", is_size=False)
    spin = np.zeros((n, 3)) if table.spin is None else table.spin
    for name, values in zip(_SPIN, spin.T, strict=True):
        _check_magnitudes(table, name, values, "rad/s", is_size=False)
    return Grains(
        position=table.position.copy(),
        diameter=sizes,
        material=_words_of(table, "material"),
        group=_words_of(table, "group"),
        velocity=velocity.copy(),
        shape=_shapes(table),
        lines=() if table.lines is None else table.lines,
        half_unit=table.half_unit,
        clump=np.zeros(n, dtype=np.int64) if table.clump is None else table.clump.copy(),
        spin=spin.copy(),
    )


def _shapes(table: GrainTable) -> list[Shape]:
    """Return the shapes of the grains: (n,); none if all are spheres."""
    words = {name: _words_of(table, name) for name in _SHAPE_COLUMNS if name in table.words}
    numbers = {name: values.tolist() for name, values in table.numbers.items()}
    values: dict[str, Sequence[Any]] = {**words, **numbers}
    if not values:
        return []
    places = [table.place(row) for row in range(len(table))]
    return read_shapes(values, places)
