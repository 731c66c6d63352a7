"""Materials and shapes of grains.

A ``[material]`` table gives elastic constants, density and yield strength, or names a ``preset``
whose values it may override one by one. Presets are in the package (``materials.toml``) or in a
``file`` of the user with the same format. Shapes are spheres, and cylinders whose axis is fixed in
space.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.contact.law_parameters import OF_MATERIAL, with_parameters
from granwave.lammps_inputs.case.hints import DENSITY, DIAMETER, YIELD_STRENGTH, YOUNGS_MODULUS
from granwave.lammps_inputs.case.schema import (
    ErrorList,
    ValidationError,
    read_table,
    refuse_unknown,
    show,
)
from granwave.lammps_inputs.errors import InputError, Mismatch
from granwave.lammps_inputs.files import read_toml

MATERIALS = "materials"  # table of further materials of a case
_FIRST = (
    "name", "youngs_modulus", "poisson_ratio", "density", "yield_strength", "hardening",
    "rate_sensitivity", "reference_rate", "source",
)  # fmt: skip


@dataclasses.dataclass(frozen=True, kw_only=True)
@with_parameters(OF_MATERIAL, first=_FIRST)
class Material:
    """An isotropic elastic material that yields (von Mises) at ``yield_strength``.

    The parameters that laws have for each material are fields as well.
    """

    name: str | None = schema.typed(
        "name of the material in figures and tables", schema.LABEL, default=None
    )
    youngs_modulus: float = schema.number("Young's modulus", YOUNGS_MODULUS, above=0)
    poisson_ratio: float = schema.number("Poisson's ratio", above=-1, below=0.5)
    density: float = schema.number("mass density", DENSITY, above=0)
    yield_strength: float | None = schema.number(
        "uniaxial yield strength", YIELD_STRENGTH, above=0, default=None
    )
    source: str | None = schema.text("source of the values", default=None)

    FURTHER_KEYS: ClassVar[dict[str, Any]] = {
        "preset": schema.typed(
            "material that provides the values missing from the table",
            schema.TextType(expected="the name of a material"),
            default=None,
        ),
        "file": schema.path(
            "TOML file that defines the preset; default: the materials of the package",
            default=None,
        ),
    }

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...

    @property
    def rate(self) -> tuple[float, float]:
        """Rate sensitivity, and reference rate, 1/s."""
        return self.rate_sensitivity or 0.0, self.reference_rate or 1.0


SELECTORS = tuple(Material.FURTHER_KEYS)


@cache
def presets() -> dict[str, Material]:
    """Return the materials of the package, by name."""
    with resources.as_file(
        resources.files("granwave.lammps_inputs.case") / "materials.toml"
    ) as path:
        return load_materials(path)


def material(name: str) -> Material:
    """Return the preset called ``name``.

    Raises
    ------
    InputError
        There is no such preset; the message names the most similar one.
    """
    errors = ErrorList("material")
    found = _select(name, presets(), "preset", errors)
    if found is None:
        raise InputError(errors.items)
    return found


def sphere_mass(material: Material, radius: float) -> float:
    """Return the mass of a sphere, kg; radius in m."""
    return material.density * 4 / 3 * math.pi * radius**3


def load_materials(path: str | Path) -> dict[str, Material]:
    """Read a file of materials, with a table for each, or the ``[materials]`` of a case.

    Raises
    ------
    InputError
        The file cannot be read, or a table in it is not a material.
    """
    errors = ErrorList(str(path))
    read = dict[str, Material | None]()
    tables = read_toml(path)
    tables = tables.get(MATERIALS, tables)
    for name, table in tables.items():
        named = {"name": name, **table} if isinstance(table, Mapping) else table
        read[name] = read_table(Material, named, name, errors)
    if not read:
        tables_of_materials = "tables such as [my-steel] with youngs_modulus etc."
        errors.add("", Mismatch("no material", tables_of_materials))
    if errors.items:
        raise InputError(errors.items)
    return {name: entry for name, entry in read.items() if entry is not None}


def read_material(table: Any, errors: ErrorList, key: str = "material") -> Material | None:
    """Read a material of a case: the name of a preset, or a table of values, optionally with
    ``preset`` and ``file``.

    Parameters
    ----------
    key
        Dotted name of the table, for errors.
    """
    if isinstance(table, str):
        return _select(table, presets(), key, errors)
    if not isinstance(table, Mapping):
        errors.add(key, Mismatch(show(table), f'a name ("brass") or a table [{key}]'))
        return None
    own = {name: value for name, value in table.items() if name not in SELECTORS}
    if "preset" not in table:
        if "file" in table:
            errors.add(f"{key}.preset", f"missing; name a material from {key}.file")
            return None
        return read_table(Material, own, key, errors)
    base = None
    file = table.get("file")
    try:
        if file is not None and (not isinstance(file, str) or not file):
            errors.add(f"{key}.file", Mismatch(show(file), "the path of a TOML file of materials"))
        else:
            known = presets() if file is None else load_materials(file)
            base = _select(table["preset"], known, f"{key}.preset", errors, file)
    except InputError as error:
        for item in error.items:
            errors.add(f"{key}.file", str(item))
    if base is None:
        refuse_unknown(own, [field.name for field in dataclasses.fields(Material)], key, errors)
        return None
    values = {name: value for name, value in dataclasses.asdict(base).items() if value is not None}
    if own.keys() - {"name"}:
        values.pop("source", None)  # the source does not apply to changed values
    return read_table(Material, {**values, **own}, key, errors)


def _select(
    name: Any, known: Mapping[str, Material], key: str, errors: ErrorList, file: str | None = None
) -> Material | None:
    if isinstance(name, str) and name in known:
        return known[name]
    there = f" in {file}" if file else ""
    hint = schema.did_you_mean(name, known, cutoff=0.7)
    errors.add(key, Mismatch(show(name), f"one of {', '.join(known)}{there}{hint}"))
    return None


@dataclasses.dataclass(frozen=True)
class MaterialType(schema.ValueType):
    """Type of a material: a name, or a table of values."""

    expected: str = "the name of a material, or a table of its values as in [material]"

    def read(self, value: Any) -> Any:
        """Return the value; `read_material` reads it."""
        return value

    @property
    def json(self) -> dict[str, Any]:
        """A name, or a table as schemas of files have it under ``$defs``."""
        table = {"$ref": "#/$defs/material"}
        return {"anyOf": [{"enum": sorted(presets())}, {"type": "string"}, table]}

    @property
    def words(self) -> tuple[str, ...]:
        """Names of the materials of the package."""
        return tuple(presets())


MATERIAL = MaterialType()


def material_field(
    description: str = "material of this body; default: the material of the case",
) -> Any:
    """Field of the key ``material`` of a body."""
    return schema.nested(description, MATERIAL, read_material)


def read_materials(tables: Any, errors: ErrorList) -> dict[str, Material]:
    """Read the tables ``[materials.NAME]`` of a case: further materials, by name."""
    if not isinstance(tables, Mapping):
        errors.add(MATERIALS, Mismatch(show(tables), f"tables such as [{MATERIALS}.soft]"))
        return {}
    found: dict[str, Material] = {}
    for name, table in tables.items():
        try:
            schema.parse_label(name)
        except ValidationError as error:
            errors.add(MATERIALS, Mismatch(f"a table called {show(name)}", error.expected))
            continue
        material = read_material(table, errors, f"{MATERIALS}.{name}")
        if material is not None:
            found[name] = dataclasses.replace(material, name=name)
            other = isinstance(table, Mapping) and table.get("name", name) != name
            errors.check(
                (
                    other,
                    f"{MATERIALS}.{name}.name",
                    Mismatch(show(material.name), "the name of the table"),
                )
            )
    return found


def with_named_materials(value: Any, materials: Mapping[str, Material]) -> Any:
    """Copy tables of a case, with the names of further materials in ``material`` keys replaced by
    their values.
    """
    if isinstance(value, list | tuple):
        return [with_named_materials(item, materials) for item in value]
    if not isinstance(value, Mapping):
        return value
    copy = {name: with_named_materials(item, materials) for name, item in value.items()}
    if isinstance(copy.get("material"), str) and copy["material"] in materials:
        known = dataclasses.asdict(materials[copy["material"]])
        copy["material"] = {name: one for name, one in known.items() if one is not None}
    return copy


SHAPES = ("sphere", "cylinder")
AXIS_FORM = '"x", "y", "z" or a direction [ax, ay, az]'
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_UNIT = 1e-12  # largest error of the length of a unit vector

Vector: TypeAlias = tuple[float, float, float]


@dataclasses.dataclass(frozen=True)
class Cylinder:
    """A cylinder.

    Attributes
    ----------
    length
        Length, m.
    axis
        Direction of its axis, a unit vector.
    """

    length: float
    axis: Vector

    @property
    def vector(self) -> NDArray[np.float64]:
        """Direction of the axis: (3,)."""
        return np.array(self.axis)


Shape: TypeAlias = Cylinder | None  # None: a sphere


def direction(values: Sequence[float]) -> Vector:
    """Return a unit vector; raise ValueError if there is no direction."""
    length = math.hypot(*values)
    if not (0 < length < math.inf):
        raise ValueError(f"found the axis {list(values)}, which has no direction")
    x, y, z = (one if abs(length - 1) <= _UNIT else one / length for one in values)
    return x, y, z


@dataclasses.dataclass(frozen=True)
class AxisType(schema.ValueType):
    """Type of a direction: a letter, or three numbers."""

    expected: str = AXIS_FORM

    def read(self, value: Any) -> Vector:
        """Return the unit vector."""
        if isinstance(value, str) and value in AXES:
            return AXES[value]
        numbers = schema.vector_type(3, AXIS_FORM).read(value)
        try:
            return direction(numbers)
        except ValueError:
            raise ValidationError(f"{AXIS_FORM}, not all 0") from None

    @property
    def json(self) -> dict[str, Any]:
        """A letter, or three numbers."""
        return {"anyOf": [{"enum": [*AXES]}, schema.vector_type(3, AXIS_FORM).json]}

    @property
    def words(self) -> tuple[str, ...]:
        """The letters."""
        return tuple(AXES)

    def is_meant(self, value: Any) -> bool:
        """Return True for a string or a list."""
        return isinstance(value, str | list | tuple)


AXIS = AxisType()


def shape_field() -> Any:
    """Field of the key ``shape``."""
    return schema.choice("shape of the grains", SHAPES, default="sphere")


def length_field() -> Any:
    """Field of the key ``length``."""
    return schema.number("length of cylinders", DIAMETER, above=0, default=None)


def axis_field() -> Any:
    """Field of the key ``axis``."""
    return schema.typed("direction of the axis of cylinders", AXIS, default=None)


def shape_of(table: Any, axis: Vector = AXES["y"]) -> Shape:
    """Return the shape of a table with the keys shape, length and axis; ``axis`` is the usual
    direction.
    """
    if table.shape != "cylinder" or table.length is None:
        return None
    return Cylinder(table.length, table.axis or axis)


def check_shape(table: Any, key: str, errors: ErrorList) -> None:
    """Check that cylinders have a length, and spheres neither length nor axis."""
    cylinder = table.shape == "cylinder"
    errors.check(
        (
            cylinder and table.length is None,
            f"{key}.length",
            'missing; a cylinder (shape = "cylinder") requires a length (m)',
        ),
        *(
            (
                not cylinder and getattr(table, name) is not None,
                f"{key}.{name}",
                Mismatch('without shape = "cylinder"', remedy="add it, or remove this key"),
            )
            for name in ("length", "axis")
        ),
    )


def mass_of(material: Material, radius: float, shape: Shape) -> float:
    """Return the mass of a grain, kg; radius in m."""
    return (
        sphere_mass(material, radius)
        if shape is None
        else material.density * math.pi * radius**2 * shape.length
    )


def density_as_sphere(density: float, diameter: float, shape: Shape) -> float:
    """Return the density at which a sphere of this diameter, m, has the mass of the grain,
    kg/m^3.
    """
    return density if shape is None else density * 1.5 * shape.length / diameter


def read_shapes(values: Mapping[str, Sequence[Any]], places: Sequence[str]) -> list[Shape]:
    """Return the shapes of grains from the columns shape, length, and axis or axis_x, axis_y,
    axis_z of a table.

    A grain is a cylinder if it has a length, unless its shape is "sphere".

    Parameters
    ----------
    places
        Position of each grain in the file, for messages.

    Raises
    ------
    ValueError
        A cylinder has no length or axis; the message names the place.
    """
    n = len(places)
    words = values.get("shape", [""] * n)
    lengths = values.get("length", [0.0] * n)
    axes = _axes_of(values, places)
    found: list[Shape] = []
    for place, word, length, axis in zip(places, words, lengths, axes.tolist(), strict=True):
        if word not in ("", *SHAPES):
            raise ValueError(f"{place}: found the shape {word!r}, expected sphere or cylinder")
        if word == "sphere" or (not word and not length):
            found.append(None)
            continue
        if not length > 0:
            raise ValueError(
                f"{place}: found a cylinder with a length of {length:g} m, expected one above 0"
            )
        try:
            found.append(Cylinder(float(length), direction(axis)))
        except ValueError as error:
            raise ValueError(f"{place}: {error}") from None
    return found


AXIS_COLUMNS = ("axis_x", "axis_y", "axis_z")


def _axes_of(values: Mapping[str, Sequence[Any]], places: Sequence[str]) -> NDArray[np.float64]:
    """Return the axes of a table, of any length: (n, 3)."""
    n = len(places)
    letters = values.get("axis")
    if letters is None:
        return np.array(
            [values.get(name, [float(name == "axis_y")] * n) for name in AXIS_COLUMNS],
            dtype=np.float64,
        ).T
    if both := [name for name in AXIS_COLUMNS if name in values]:
        raise ValueError(f"found the columns axis and {both[0]}, expected only one of them")
    for place, letter in zip(places, letters, strict=True):
        if letter not in ("", *AXES):
            raise ValueError(
                f"{place}: found the axis {letter!r}, expected x, y or z; use axis_x, axis_y and "
                "axis_z for other directions"
            )
    return np.array([AXES[letter or "y"] for letter in letters], dtype=np.float64).reshape(-1, 3)


def shape_columns(shapes: Sequence[Shape]) -> dict[str, list[str]]:
    """Return the columns of `read_shapes` as text; none if there are only spheres."""
    if not any(shapes):
        return {}
    axes = [one.axis if one else (0.0, 0.0, 0.0) for one in shapes]
    return {
        "shape": ["cylinder" if one else "sphere" for one in shapes],
        "length": [repr(one.length if one else 0.0) for one in shapes],
        **{name: [repr(axis[k]) for axis in axes] for k, name in enumerate(AXIS_COLUMNS)},
    }
