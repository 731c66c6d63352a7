"""Columns of a file as quantities of grains, by usual names and spellings, with their units."""

from __future__ import annotations

import dataclasses
import itertools
import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence

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
    VOLUME,
    VOXELS,
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
NO_CLUMP = -1  # clump number of other programs for grains without a clump
_AXES = 3  # axes of a volume
LARGEST_CLUMP = 2**31 - 1  # a molecule of LAMMPS
WORDS = ("material", "group", "shape", "axis")
KINDS: dict[str, str] = {
    **dict.fromkeys((*PLACE, DIAMETER, RADIUS, "length"), LENGTH),
    **dict.fromkeys(VELOCITIES, VELOCITY),
    **dict.fromkeys(SPINS, ANGULAR_VELOCITY),
    **dict.fromkeys((*AXIS_PARTS, ID, CLUMP), ""),
    "mass": MASS,
    "density": DENSITY,
    "volume": VOLUME,
}
QUANTITIES = (*PLACE, DIAMETER, RADIUS, "shape", "length", "axis", *AXIS_PARTS, "material",
              "group", CLUMP, *VELOCITIES, *SPINS, ID, TYPE, "mass", "density",
              "volume")  # fmt: skip
#: Columns that are ignored without a warning.
_UNUSED = re.compile(
    r"[fti][xyz]|[xyz]su?|force_[xyz012]|torque_[xyz012]|tq[xyz]|mol|element|q|mask"
)
# values of spheres, and of grains without a clump
_MAY_BE_EMPTY = {"length": 0.0, **dict.fromkeys(AXIS_PARTS, 0.0), CLUMP: 0.0}
_STEMS = {
    "": ("pos", "position", "p", "coord", "coords", "coordinate", "coordinates", "center",
         "centre", "centroid", "barycenter", "barycentre", "point", "points", "c", "location",
         "schwerpunkt", "mittelpunkt"),
    "v": ("v", "vel", "velo", "velocity", "velocities"),
    "omega": ("omega", "w", "om", "angular_velocity", "angularvelocity", "angvel", "spin"),
}  # fmt: skip
_OTHER_NAMES = {
    RADIUS: "r rad radii rayon",
    DIAMETER: (
        "d dia diam diameters equivalent_diameter equivalent_diameter_area "
        "equivalent_spherical_diameter equiv_diameter equivdiameter eq_diameter eqdiameter "
        "particle_size durchmesser kugeldurchmesser diametre diamètre"
    ),
    ID: "ids tag label identifier particleidentifier",
    # names in YADE, LIGGGHTS (fix multisphere) and LAMMPS (fix rigid)
    CLUMP: "clumpid clump_id id_multisphere f_id_multisphere multisphere_id body body_id",
    TYPE: (
        "types typelabel particletype atom_type type_id material_id mat_id matid indspecies "
        "species phase phase_id"
    ),
    "mass": "m masses",
    "density": "rho",
    "volume": "vol volumes volumen",
}


def _vector_names(quantity: str, letter: str, number: int) -> Iterable[str]:
    """Yield usual names of a component of a vector quantity."""
    for stem in _STEMS[quantity]:
        yield f"{stem}_{letter}"
        yield f"{letter}_{stem}"
        yield f"{stem}_{number}"
        if len(stem) > 1 or quantity:
            yield f"{stem}{letter}"
        if len(stem) > 1:
            yield f"{letter}{stem}"


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
_N_OF_MFIX = (6, 8)  # columns of the particles of MFiX, which have no names
_COMPONENTS = ("u", "v", "w")  # of the velocity, if all three are there
_BEFORE_NAME = re.compile(r"(?:q[0-9]+_)?(?:particle|grain|sphere|atom|body|ball)_")
_LARGEST_ID = 2.0**63
#: Quantities from which the volume of a grain follows, by preference; the second divides the first.
_VOLUMES = (("volume",), ("mass", "density"))
_NUMBERED = re.compile(r"(.*[^0-9])([0-3])")  # a component, such as Points_0


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
        for word in (plain, _BEFORE_NAME.sub("", plain, count=1)):
            if word in _QUANTITY_OF_NAME:
                return _QUANTITY_OF_NAME[word], unit
    return "", ""


def counted_from_zero(heads: Sequence[str]) -> list[str]:
    """Return heads whose components are numbered from 1 (Centroid_1 ... 3), with numbers from 0."""
    numbers: dict[str, set[str]] = {}
    matches = [_NUMBERED.fullmatch(head) for head in heads]
    for match in matches:
        if match is not None:
            numbers.setdefault(match[1], set()).add(match[2])
    names: list[str] = []
    for head, match in zip(heads, matches, strict=True):
        if match is not None and numbers[match[1]] == {"1", "2", "3"}:
            names.append(f"{match[1]}{int(match[2]) - 1}")
        else:
            names.append(head)
    return names


def _velocities_of_components(heads: Sequence[str]) -> list[str]:
    """Return heads with vx, vy and vz in place of u, v and w, if the table has all three."""
    plain = [split_unit(head)[0].strip().lower() for head in heads]
    if not all(name in plain for name in _COMPONENTS):
        return list(heads)
    names: list[str] = []
    for head, name in zip(heads, plain, strict=True):
        is_component = name in _COMPONENTS
        unit = split_unit(head)[1] if is_component else ""
        velocity = VELOCITIES[_COMPONENTS.index(name)] if is_component else head
        names.append(f"{velocity} ({unit})" if unit else velocity)
    return names


def find_columns(
    table: TextTable, options: FileOptions, notes: list[str], *, repeated: bool = False
) -> dict[str, GrainColumn]:
    """Return the column of each quantity that a table has.

    Parameters
    ----------
    notes
        Warnings, to which columns that are omitted are added.
    repeated
        Columns that occur several times; the first is used.

    Raises
    ------
    ValueError
        A column occurs twice, or a column named by the user is missing.
    """
    columns: dict[str, GrainColumn] = {}
    unknown: list[str] = []
    names = _velocities_of_components(counted_from_zero(table.heads))
    for index, (head, name) in enumerate(zip(table.heads, names, strict=True)):
        if head.strip() in options.names.values():
            continue  # the user says what it is
        quantity, unit = quantity_of(name)
        column = GrainColumn(index, head, unit or _unit_below(table, index))
        earlier = columns.get(quantity)
        if not quantity:
            unknown.append(head)
        elif earlier is None or (quantity == head and earlier.head != head):
            columns[quantity] = column
        elif not repeated:
            _refuse_second(table, quantity, earlier, head)
            unknown.append(head)
    for size, other in ((RADIUS, DIAMETER), (DIAMETER, RADIUS)):
        if size in options.names and other not in options.names:
            columns.pop(other, None)
    columns |= _named_columns(table, options)
    unknown += _needless_volumes(columns, options)
    used = {column.head for column in columns.values()}
    needless = [head for head in unknown if not head or _UNUSED.fullmatch(head.lower())]
    if left_out := [head for head in dict.fromkeys(unknown) if head not in {*used, *needless}]:
        several = "s" if len(left_out) > 1 else ""
        notes.append(f"column{several} ignored: {', '.join(left_out)}")
    return columns


def _needless_volumes(columns: dict[str, GrainColumn], options: FileOptions) -> list[str]:
    """Remove a column of volumes that the user did not name, if there are also sizes; return its
    name.
    """
    if "volume" not in columns or "volume" in options.names or not has_sizes(columns, options):
        return []
    return [columns.pop("volume").head]


def has_sizes(quantities: Collection[str], options: FileOptions) -> bool:
    """Return True if a file gives diameters or radii, or the user a diameter of all grains."""
    return options.diameter is not None or RADIUS in quantities or DIAMETER in quantities


def gives_sizes(quantities: Collection[str], options: FileOptions) -> bool:
    """Return True if the diameters of all grains are known, or follow from other quantities."""
    return has_sizes(quantities, options) or bool(_sources_of_volume(quantities))


def _sources_of_volume(quantities: Collection[str]) -> tuple[str, ...]:
    """Return the quantities from which the volumes of spheres follow; empty without such
    quantities.
    """
    if "length" in quantities:  # cylinders
        return ()
    for names in _VOLUMES:
        if all(name in quantities for name in names):
            return names
    return ()


def diameters_of(
    values: Mapping[str, NDArray[np.float64]],
    place: Callable[[int], str],
    heads: Mapping[str, str],
    notes: list[str],
) -> NDArray[np.float64] | None:
    """Return the diameters of spheres that have given volumes, or masses and densities: (n,), m.

    Parameters
    ----------
    values
        Quantities of the grains by name: (n,) each, in SI units.
    place
        Place in the file of a row.
    heads
        Names of the columns in the file by quantity.
    notes
        Warnings, to which a line on the diameters is added.

    Raises
    ------
    ValueError
        A value is not above 0.
    """
    names = _sources_of_volume(values)
    if not names:
        return None
    for name in names:
        wrong = np.flatnonzero(~(values[name] > 0))
        if len(wrong):
            row = int(wrong[0])
            raise ValueError(
                f"{place(row)}: found {values[name][row]:g} for {name}, expected a number above 0, "
                "from which the diameter follows"
            )
    volume = values[names[0]]
    if len(names) > 1:
        volume = volume / values[names[1]]
    diameter: NDArray[np.float64] = np.cbrt(6 / np.pi * volume)
    columns = " and ".join(heads[name] for name in names)
    low = f"{diameter.min():.4g}"
    high = f"{diameter.max():.4g}"
    sizes = low
    if low != high:
        sizes = f"{low} to {high}"
    several = "s" if len(names) > 1 else ""
    notes.append(
        f"no column of diameters; computed for spheres from the column{several} {columns}: {sizes} "
        "m"
    )
    return diameter


def _refuse_second(table: TextTable, quantity: str, earlier: GrainColumn, head: str) -> None:
    """Raise ValueError for a second column of a quantity, unless the first has exactly its name."""
    place = f"line {table.head_line}"
    if head == earlier.head:
        raise ValueError(f"{place}: found the column {head} twice")
    if earlier.head != quantity:
        raise ValueError(
            f"{place}: found the columns {earlier.head} and {head} for {quantity}; choose one: "
            f"packing.columns = {{{quantity} = {show(head)}}}"
        )


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
        unit = split_unit(head)[1] if heads else ""
        columns[quantity] = GrainColumn(index, head, unit or _unit_below(table, index))
    return columns


def _unit_below(table: TextTable, index: int) -> str:
    """Return the unit of a column in the row below the names; empty if there is none."""
    return table.units[index] if index < len(table.units) else ""


def require_columns(
    table: TextTable, columns: dict[str, GrainColumn], options: FileOptions
) -> None:
    """Raise ValueError unless a table has positions and, without a usual diameter, sizes."""
    place = f"line {table.head_line}"
    if not table.heads and not columns:
        raise ValueError(f"{place}: {_unnamed(table.frame.shape[1], options)}")
    if DIAMETER in columns and RADIUS in columns:
        head = show(columns[DIAMETER].head)
        raise ValueError(
            f"{place}: found the column diameter (or radius for it) twice; choose one: "
            f"packing.columns = {{{DIAMETER} = {head}}}"
        )
    needed = PLACE if options.diameter is not None else (*PLACE, DIAMETER)
    for name in needed:
        if name in columns or (name == DIAMETER and gives_sizes(columns, options)):
            continue
        more = ""
        if name == DIAMETER:
            more = " (or radius, volume, or mass with density), or packing.diameter for all grains"
        heads = ", ".join(table.heads)
        raise ValueError(
            f"{place}: found no column {name}, expected {', '.join(needed)}{more}; there are "
            f"{heads}, of which packing.columns can name it"
        )


def _unnamed(n_columns: int, options: FileOptions) -> str:
    """Return the quantities that a table lacks, with an example for its columns."""
    usual = [*PLACE, RADIUS]
    example = usual[:n_columns]
    columns = show(example)
    if n_columns > len(usual):
        numbers = [f"{name} = {number}" for number, name in enumerate(example, start=1)]
        columns = f"{{{', '.join(numbers)}}} (numbers of columns)"
    more = ""
    if n_columns < len(usual) and options.diameter is None:
        more = " with packing.diameter for all grains"
    if n_columns in _N_OF_MFIX:
        more = ', or packing.format = "mfix" for particles of MFiX'
    return (
        f"found {n_columns} columns without names, expected a line of names, or "
        f"packing.columns = {columns}{more}"
    )


def _is_in_voxels(unit: str, kind: str) -> bool:
    """Return True for the unit of a length or a volume in voxels, such as ``vox^3``."""
    plain = unit.lower()
    if kind == VOLUME:
        plain = re.sub(r"(?:\^|\*\*)?[3³]$", "", plain)
    return plain in VOXELS and kind in (LENGTH, VOLUME)


def from_one(numbers: NDArray[np.int64], head: str) -> NDArray[np.int64]:
    """Return numbers of clumps of a column, 0 for none.

    Programs other than granwave write -1 for none, and then count from 0.
    """
    if head.strip().lower() != CLUMP and (numbers == NO_CLUMP).any():
        return numbers + 1
    return numbers


class ColumnReader:
    """Quantities of the grains of a table, in SI units.

    Parameters
    ----------
    table
        The table.
    columns
        Columns by quantity.
    options
        The user's settings for the file.
    powers
        Powers of ten of the units of the file by kind of quantity, if neither the user nor the name
        of the column gives them.
    """

    def __init__(
        self,
        table: TextTable,
        columns: dict[str, GrainColumn],
        options: FileOptions,
        powers: Mapping[str, float] | None = None,
    ) -> None:
        self.table = table
        self.columns = columns
        self.powers: dict[str, float] = dict(powers or {})
        self.options = options
        self.has_voxels = options.has_voxels
        if options.units:
            self.powers |= dict.fromkeys((LENGTH, VELOCITY), options.power())
        if LENGTH in self.powers:
            self.powers[VOLUME] = _AXES * self.powers[LENGTH]

    def scale(self, quantity: str) -> float:
        """Return the power of ten of the unit of a quantity."""
        kind = KINDS[quantity]
        unit = self.columns[quantity].unit
        units = UNITS.get(kind, {})
        head = self.columns[quantity].head
        if _is_in_voxels(unit, kind):
            if self.has_voxels:
                return self.powers[kind]
            raise ValueError(
                f"line {self.table.head_line}: found the column {show(head)} in voxels, expected "
                'their size, such as packing.units = "0.012 mm"'
            )
        if unit and unit not in units:
            raise ValueError(
                f"line {self.table.head_line}: found the unit {show(unit)} of the column "
                f"{show(head)}, expected {', '.join(units) or 'none'}"
            )
        if unit:
            return units[unit]
        return self.powers.get(kind, 0)

    def numbers(self, quantity: str) -> NDArray[np.float64] | None:
        """Return a quantity: (n,); None if there is none."""
        if quantity not in self.columns:
            return None
        index = self.columns[quantity].index
        empty = _MAY_BE_EMPTY.get(quantity)
        values = self.table.numbers(index, quantity, empty)
        return in_si(values, self.scale(quantity))

    def vector(self, quantities: Sequence[str]) -> NDArray[np.float64] | None:
        """Return a vector quantity: (n, 3), 0 along axes that are omitted; None without any."""
        parts = [self.numbers(quantity) for quantity in quantities]
        if all(part is None for part in parts):
            return None
        zeros = np.zeros(len(self.table))
        return np.stack([zeros if part is None else part for part in parts], axis=1)

    def half_units(self) -> NDArray[np.float64]:
        """Return half a unit of the last digit of each coordinate: (n, 3), m."""
        columns = [self.columns[quantity].index for quantity in PLACE]
        values = [
            self.table.numbers(column, quantity)
            for column, quantity in zip(columns, PLACE, strict=True)
        ]
        half = self.table.half_units(columns, np.stack(values, axis=1))
        for axis, quantity in enumerate(PLACE):
            half[:, axis] = in_si(half[:, axis], self.scale(quantity))
        return half

    def radius(self, notes: list[str]) -> NDArray[np.float64] | None:
        """Return the radii: (n,), m; None if the table has no radii, diameters or volumes."""
        if not has_sizes(self.columns, self.options):
            diameter = self._diameters_of_volumes(notes)
        else:
            diameter = self.numbers(DIAMETER)
        return self.numbers(RADIUS) if diameter is None else diameter / 2

    def _diameters_of_volumes(self, notes: list[str]) -> NDArray[np.float64] | None:
        """Return the diameters that follow from volumes, or masses and densities: (n,), m."""
        values: dict[str, NDArray[np.float64]] = {}
        for name in _sources_of_volume(self.columns):
            numbers = self.numbers(name)
            assert numbers is not None
            values[name] = numbers
        heads = {name: self.columns[name].head for name in values}
        return diameters_of(values, self.table.place, heads, notes)

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
        broken = np.flatnonzero((values != np.round(values)) | (np.abs(values) >= _LARGEST_ID))
        if len(broken):
            row = int(broken[0])
            place = self.table.place(row)
            raise ValueError(
                f"{place}: found {values[row]:g} for {quantity}, expected a whole number"
            )
        return values.astype(np.int64)

    def clumps(self) -> NDArray[np.int64] | None:
        """Return the numbers of the clumps, 0 for none: (n,); None if the table has none.

        Other programs write -1 for grains in no clump, and then count their clumps from 0.
        """
        numbers = self.whole_numbers(CLUMP)
        if numbers is None:
            return None
        numbers = from_one(numbers, self.columns[CLUMP].head)
        wrong = np.flatnonzero((numbers < 0) | (numbers > LARGEST_CLUMP))
        if len(wrong):
            row = int(wrong[0])
            raise ValueError(
                f"{self.table.place(row)}: found {numbers[row]} for {CLUMP}, expected a number "
                f"from 1 to {LARGEST_CLUMP} of grains that move as one body, or 0 for none"
            )
        return numbers

    def _note_units(self, notes: list[str]) -> None:
        """Note lengths without a unit next to lengths with a unit, unless the user sets the
        unit.
        """
        names = [name for name in (*PLACE, RADIUS, DIAMETER, "volume") if name in self.columns]
        without = [self.columns[name].head for name in names if not self.columns[name].unit]
        if without and len(without) < len(names) and LENGTH not in self.powers:
            several = "s" if len(without) > 1 else ""
            notes.append(
                f"column{several} without a unit ({', '.join(without)}), although other columns "
                "have one; read in metres, or in packing.units"
            )

    def grains(self, form: str, notes: list[str]) -> GrainTable:
        """Return the grains of the table, for the format ``form``."""
        position = self.vector(PLACE)
        assert position is not None
        self._note_units(notes)
        words = {name: self.words(name) for name in WORDS if name in self.columns}
        further = ("length", *AXIS_PARTS)
        numbers = {name: self.numbers(name) for name in further}
        return GrainTable(
            format=form,
            position=position,
            half_unit=self.half_units(),
            radius=self.radius(notes),
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
