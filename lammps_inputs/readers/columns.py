"""Columns of a file as quantities of grains, by usual names and spellings, with their units."""

from __future__ import annotations

import dataclasses
import itertools
import re
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.message_words import show
from granwave.lammps_inputs.readers.grain_table import GrainTable
from granwave.lammps_inputs.readers.source import FileOptions
from granwave.lammps_inputs.tables.text_table import TextTable
from granwave.lammps_inputs.tables.units import (
    ANGULAR_VELOCITY,
    DENSITY,
    LENGTH,
    MASS,
    UNITS,
    VELOCITY,
    in_si,
    split_unit,
)

PLACE = ("x", "y", "z")
VELOCITIES = ("vx", "vy", "vz")
SPINS = ("omegax", "omegay", "omegaz")
AXIS_PARTS = ("axis_x", "axis_y", "axis_z")
RADIUS = "radius"
DIAMETER = "diameter"
ID = "id"
TYPE = "type"
CLUMP = "clump"
LARGEST_CLUMP = 2**31 - 1  # a molecule of LAMMPS
WORDS = ("material", "group", "shape", "axis")
KINDS: dict[str, str] = {
    **dict.fromkeys((*PLACE, DIAMETER, RADIUS, "length"), LENGTH),
    **dict.fromkeys(VELOCITIES, VELOCITY),
    **dict.fromkeys(SPINS, ANGULAR_VELOCITY),
    **dict.fromkeys((*AXIS_PARTS, ID, CLUMP), ""),
    "mass": MASS,
    "density": DENSITY,
}
QUANTITIES = (*PLACE, DIAMETER, RADIUS, "shape", "length", "axis", *AXIS_PARTS, "material",
              "group", CLUMP, *VELOCITIES, *SPINS, ID, TYPE, "mass", "density")  # fmt: skip
#: Columns of which nothing is needed, and no warning is given.
_UNUSED = re.compile(
    r"[fti][xyz]|[xyz]su?|force_[xyz012]|torque_[xyz012]|tq[xyz]|mol|element|q|mask"
)
# of spheres, and of grains in no clump
_MAY_BE_EMPTY = {"length": 0.0, **dict.fromkeys(AXIS_PARTS, 0.0), CLUMP: 0.0}
_STEMS = {
    "": ("pos", "position", "p", "coord", "coords", "coordinate", "coordinates", "center",
         "centre", "centroid", "point", "points", "c"),
    "v": ("v", "vel", "velocity", "velocities"),
    "omega": ("omega", "w", "om", "angular_velocity", "angularvelocity", "angvel", "spin"),
}  # fmt: skip
_OTHER_NAMES = {
    RADIUS: "r rad radii sphere_radius particle_radius grain_radius",
    DIAMETER: "d dia diam diameters sphere_diameter particle_diameter grain_diameter",
    ID: "ids particle_id grain_id atom_id sphere_id tag",
    TYPE: "types atom_type type_id material_id mat_id matid indspecies species phase",
    "mass": "m masses particle_mass",
    "density": "rho",
}


def _vector_names(quantity: str, letter: str, number: int) -> Iterable[str]:
    """Yield usual names of a component of a vector quantity."""
    for stem in _STEMS[quantity]:
        yield f"{stem}_{letter}"
        yield f"{letter}_{stem}"
        yield f"{stem}_{number}"
        if len(stem) > 1 or quantity:
            yield f"{stem}{letter}"


def _all_names() -> dict[str, str]:
    """Return the quantity of each usual name."""
    names: dict[str, str] = {}
    for quantity, text in _OTHER_NAMES.items():
        names |= dict.fromkeys(text.split(), quantity)
    for quantity, (number, letter) in itertools.product(_STEMS, enumerate("xyz")):
        component = f"{quantity}{letter}"
        names |= dict.fromkeys(_vector_names(quantity, letter, number), component)
    for letter in "xyz":
        names |= dict.fromkeys((f"{letter}u", f"{letter}c", f"c{letter}"), letter)
    return names | {name: name for name in QUANTITIES}


_QUANTITY_OF_NAME = _all_names()


@dataclasses.dataclass(frozen=True)
class GrainColumn:
    """Column of a table that gives a quantity of grains.

    Attributes
    ----------
    index
        Number of the column, from 0.
    head
        Its name in the file.
    unit
        Its unit in the file; empty if the file gives none.
    """

    index: int
    head: str
    unit: str = ""


def quantity_of(head: str) -> tuple[str, str]:
    """Return quantity and unit of the head of a column; the quantity is empty if unknown."""
    for name, unit in ((head, ""), split_unit(head)):
        plain = re.sub(r"[\s:.\-]+", "_", name.strip().strip("'\"").lower()).strip("_")
        if plain in _QUANTITY_OF_NAME:
            return _QUANTITY_OF_NAME[plain], unit
    return "", ""


def find_columns(
    table: TextTable, options: FileOptions, notes: list[str], *, repeated: bool = False
) -> dict[str, GrainColumn]:
    """Return the column of each quantity that a table has.

    Parameters
    ----------
    notes
        Warnings, to which columns that are left out are added.
    repeated
        The first of several columns of one name counts.

    Raises
    ------
    ValueError
        A column is there twice, or is not there although the user named it.
    """
    place = f"line {table.head_line}"
    columns: dict[str, GrainColumn] = {}
    unknown: list[str] = []
    for index, head in enumerate(table.heads):
        quantity, unit = quantity_of(head)
        if not quantity:
            if head and not _UNUSED.fullmatch(head.lower()):
                unknown.append(head)
            continue
        earlier = columns.get(quantity)
        if earlier is None or (quantity == head and earlier.head != head):
            columns[quantity] = GrainColumn(index, head, unit)
        elif not repeated and head == earlier.head:
            raise ValueError(f"{place}: found the column {head} twice")
        elif not repeated and earlier.head != quantity:
            raise ValueError(
                f"{place}: found the columns {earlier.head} and {head} for {quantity}; choose one: "
                f"packing.columns = {{{quantity} = {show(head)}}}"
            )
    columns |= _named_columns(table, options)
    used = {column.head for column in columns.values()}
    if left_out := [head for head in dict.fromkeys(unknown) if head not in used]:
        several = "s" if len(left_out) > 1 else ""
        notes.append(f"column{several} left out: {', '.join(left_out)}")
    return columns


def _named_columns(table: TextTable, options: FileOptions) -> dict[str, GrainColumn]:
    """Return the columns that the user named."""
    columns: dict[str, GrainColumn] = {}
    heads = [head.strip() for head in table.heads]
    n_columns = table.frame.shape[1]
    for quantity, name in options.names.items():
        if isinstance(name, int):
            there = 1 <= name <= n_columns
            index = name - 1
        else:
            there = name in heads
            index = heads.index(name) if there else -1
        if not there:
            raise ValueError(
                f"line {table.head_line}: found no column {show(name)} for {quantity}, expected "
                f"one of {', '.join(heads) or f'1 to {n_columns}'}"
            )
        head = heads[index] if heads else str(name)
        columns[quantity] = GrainColumn(index, head, split_unit(head)[1] if heads else "")
    return columns


def require_columns(
    table: TextTable, columns: dict[str, GrainColumn], diameter: float | None
) -> None:
    """Raise ValueError unless a table has places and, without a usual diameter, sizes."""
    place = f"line {table.head_line}"
    if not table.heads and not columns:
        n_columns = table.frame.shape[1]
        example = ["x", "y", "z", RADIUS][:n_columns]
        raise ValueError(
            f"{place}: found {n_columns} columns without names, expected a line of names, or "
            f"packing.columns = {show(example)}"
        )
    if DIAMETER in columns and RADIUS in columns:
        raise ValueError(f"{place}: found the column diameter (or radius for it) twice")
    needed = PLACE if diameter is not None else (*PLACE, DIAMETER)
    for name in needed:
        if name in columns or (name == DIAMETER and RADIUS in columns):
            continue
        more = ", or packing.diameter for all grains" if name == DIAMETER else ""
        heads = ", ".join(table.heads)
        raise ValueError(
            f"{place}: found no column {name}, expected {', '.join(needed)}{more}; there are "
            f"{heads}, of which packing.columns can name it"
        )


class ColumnReader:
    """Quantities of the grains of a table, in SI units.

    Parameters
    ----------
    table
        The table.
    columns
        Columns by quantity.
    options
        What the user said of the file.
    power
        Power of ten of the lengths of the file, if neither the user nor the name of the column
        gives it.
    """

    def __init__(
        self,
        table: TextTable,
        columns: dict[str, GrainColumn],
        options: FileOptions,
        power: int = 0,
    ) -> None:
        self.table = table
        self.columns = columns
        self.power = options.power(power)

    def scale(self, quantity: str) -> int:
        """Return the power of ten of the unit of a quantity."""
        kind = KINDS[quantity]
        unit = self.columns[quantity].unit
        units = UNITS.get(kind, {})
        if unit and unit not in units:
            head = self.columns[quantity].head
            raise ValueError(
                f"line {self.table.head_line}: found the unit {show(unit)} of the column "
                f"{show(head)}, expected {', '.join(units) or 'none'}"
            )
        if unit:
            return units[unit]
        return self.power if kind in (LENGTH, VELOCITY) else 0

    def numbers(self, quantity: str) -> NDArray[np.float64] | None:
        """Return a quantity: (n,); None if there is none."""
        if quantity not in self.columns:
            return None
        index = self.columns[quantity].index
        empty = _MAY_BE_EMPTY.get(quantity)
        values = self.table.numbers(index, quantity, empty)
        return in_si(values, self.scale(quantity))

    def vector(self, quantities: Sequence[str]) -> NDArray[np.float64] | None:
        """Return a vector quantity: (n, 3), 0 along axes that are left out; None without any."""
        parts = [self.numbers(quantity) for quantity in quantities]
        if all(part is None for part in parts):
            return None
        zeros = np.zeros(len(self.table))
        return np.stack([zeros if part is None else part for part in parts], axis=1)

    def half_units(self) -> NDArray[np.float64]:
        """Return half a unit of the last place of each coordinate: (n, 3), m."""
        columns = [self.columns[quantity].index for quantity in PLACE]
        values = [
            self.table.numbers(column, quantity)
            for column, quantity in zip(columns, PLACE, strict=True)
        ]
        half = self.table.half_units(columns, np.stack(values, axis=1))
        for axis, quantity in enumerate(PLACE):
            half[:, axis] = in_si(half[:, axis], self.scale(quantity))
        return half

    def radius(self) -> NDArray[np.float64] | None:
        """Return the radii: (n,), m; None if the table has neither these nor diameters."""
        diameter = self.numbers(DIAMETER)
        return self.numbers(RADIUS) if diameter is None else diameter / 2

    def words(self, quantity: str) -> list[str]:
        """Return a column of words: (n,); empty if there is none."""
        if quantity not in self.columns:
            return []
        return self.table.words(self.columns[quantity].index)

    def ids(self) -> NDArray[np.int64] | None:
        """Return the ids: (n,); None if the table has none."""
        return self.whole_numbers(ID)

    def whole_numbers(self, quantity: str) -> NDArray[np.int64] | None:
        """Return a quantity of whole numbers: (n,); None if the table has none."""
        values = self.numbers(quantity)
        if values is None:
            return None
        broken = np.flatnonzero(values != np.round(values))
        if len(broken):
            row = int(broken[0])
            place = self.table.place(row)
            raise ValueError(
                f"{place}: found {values[row]:g} for {quantity}, expected a whole number"
            )
        return values.astype(np.int64)

    def clumps(self) -> NDArray[np.int64] | None:
        """Return the numbers of the clumps, 0 for none: (n,); None if the table has none."""
        numbers = self.whole_numbers(CLUMP)
        if numbers is None:
            return None
        wrong = np.flatnonzero((numbers < 0) | (numbers > LARGEST_CLUMP))
        if len(wrong):
            row = int(wrong[0])
            raise ValueError(
                f"{self.table.place(row)}: found {numbers[row]} for {CLUMP}, expected a number "
                f"from 1 to {LARGEST_CLUMP} of grains that move as one body, or 0 for none"
            )
        return numbers

    def grains(self, form: str, notes: list[str]) -> GrainTable:
        """Return the grains of the table, of a format that is called ``form``."""
        position = self.vector(PLACE)
        assert position is not None
        words = {name: self.words(name) for name in WORDS if name in self.columns}
        further = ("length", *AXIS_PARTS)
        numbers = {name: self.numbers(name) for name in further}
        return GrainTable(
            format=form,
            position=position,
            half_unit=self.half_units(),
            radius=self.radius(),
            ids=self.ids(),
            types=self.words(TYPE),
            density=self.numbers("density"),
            mass=self.numbers("mass"),
            velocity=self.vector(VELOCITIES),
            spin=self.vector(SPINS),
            clump=self.clumps(),
            words=words,
            numbers={name: values for name, values in numbers.items() if values is not None},
            lines=self.table.lines,
            notes=notes,
        )
