"""Shapes of grains: spheres, and cylinders whose axis is fixed in space."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.hints import DIAMETER
from granwave.lammps_inputs.case.material import Material, sphere_mass
from granwave.lammps_inputs.case.schema import ErrorList, ValidationError, choice, custom, finite, number

SHAPES = ("sphere", "cylinder")
AXIS_FORM = '"x", "y", "z" or a direction [ax, ay, az]'
_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_UNIT = 1e-12  # largest error of the length of a direction that counts as a unit vector already

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
        raise ValueError(f"found the axis {list(values)}, which is no direction")
    x, y, z = (one if abs(length - 1) <= _UNIT else one / length for one in values)
    return x, y, z


def parse_axis(value: Any) -> Vector:
    """Read a direction of a case file; raise `ValidationError` if it is none."""
    if isinstance(value, str) and value in _AXES:
        return _AXES[value]
    if not isinstance(value, list | tuple) or len(value) != 3:
        raise ValidationError(AXIS_FORM)
    try:
        return direction([finite(one, AXIS_FORM) for one in value])
    except ValueError:
        raise ValidationError(f"{AXIS_FORM}, not all 0") from None


def shape_field() -> Any:
    """Field of the key ``shape``."""
    return choice("shape of the grains", SHAPES, default="sphere")


def length_field() -> Any:
    """Field of the key ``length``."""
    return number("length of cylinders", unit="m", above=0, default=None, usual=DIAMETER)


def axis_field() -> Any:
    """Field of the key ``axis``."""
    return custom("direction of the axis of cylinders", parse_axis, default=None)


class HasShape(Protocol):
    """Table with the keys of a shape."""

    @property
    def shape(self) -> str:
        """``sphere`` or ``cylinder``."""

    @property
    def length(self) -> float | None:
        """Length of cylinders, m."""

    @property
    def axis(self) -> Vector | None:
        """Direction of their axis."""


def shape_of(table: HasShape, axis: Vector = _AXES["y"]) -> Shape:
    """Return the shape of a table that `check_shape` found right; ``axis`` is the usual direction."""
    if table.shape == "sphere" or table.length is None:
        return None
    return Cylinder(table.length, table.axis or axis)


def check_shape(table: HasShape, key: str, errors: ErrorList) -> None:
    """Check that cylinders have a length, and spheres neither length nor axis."""
    if table.shape == "cylinder":
        if table.length is None:
            errors.add(f"{key}.length", 'missing; a cylinder (shape = "cylinder") has a length, m')
        return
    for name in ("length", "axis"):
        if getattr(table, name) is not None:
            errors.add(f"{key}.{name}", 'found without shape = "cylinder"; give that, or take it out')


def mass_of(material: Material, radius: float, shape: Shape) -> float:
    """Return the mass of a grain, kg; radius in m."""
    return sphere_mass(material, radius) if shape is None else material.density * math.pi * radius**2 * shape.length


def density_as_sphere(density: float, diameter: float, shape: Shape) -> float:
    """Return the density at which a sphere of this diameter, m, has the mass of the grain, kg/m^3."""
    return density if shape is None else density * 1.5 * shape.length / diameter


def read_shapes(values: Mapping[str, Sequence[Any]], places: Sequence[str]) -> list[Shape]:
    """Return the shapes of grains from the columns shape, length, and axis or axis_x, axis_y, axis_z of a table.

    A grain is a cylinder if it has a length, unless its column shape says sphere.

    Parameters
    ----------
    places
        Place of each grain in the file, for messages.

    Raises
    ------
    ValueError
        A cylinder has no length or axis; the message names the place.
    """
    n = len(places)
    words, lengths = values.get("shape", [""] * n), values.get("length", [0.0] * n)
    axes = _axes_of(values, places)
    found: list[Shape] = []
    for place, word, length, axis in zip(places, words, lengths, axes.tolist(), strict=True):
        if word not in ("", *SHAPES):
            raise ValueError(f"{place}: found the shape {word!r}, expected sphere or cylinder")
        if word == "sphere" or (not word and not length):
            found.append(None)
            continue
        if not length > 0:
            raise ValueError(f"{place}: found a cylinder with a length of {length:g} m, expected one above 0")
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
        return np.array([values.get(name, [float(name == "axis_y")] * n) for name in AXIS_COLUMNS], dtype=np.float64).T
    if both := [name for name in AXIS_COLUMNS if name in values]:
        raise ValueError(f"found the columns axis and {both[0]}, expected one way to give axes")
    for place, letter in zip(places, letters, strict=True):
        if letter not in ("", *_AXES):
            raise ValueError(
                f"{place}: found the axis {letter!r}, expected x, y or z; axis_x, axis_y, axis_z take others"
            )
    return np.array([_AXES[letter or "y"] for letter in letters], dtype=np.float64).reshape(-1, 3)


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
