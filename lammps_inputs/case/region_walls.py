"""``[[wall]]``: walls that are faces of a region, in the words of the command ``region`` of LAMMPS.

    region = "plane 0 0 0.05 0 0 -1"                     a point, and the normal to the grains, m
    region = "block -0.02 0.02 -0.02 0.02 0 0.1"         bounds along x, y and z
    region = "sphere 0 0 0 0.05"                         centre and radius
    region = "cylinder z 0 0 0.05 0 0.1"                 axis, its place, radius, ends
    region = "cone z 0 0 0.05 0.01 0 0.1 open 1 open 2"  the same with the radii at both ends

Grains are inside the region; ``side out`` puts them outside of a sphere, or of a cylinder with
the bounds INF INF. An open face and a bound INF have no wall.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.hints import LENGTH
from granwave.lammps_inputs.case.material import Material, material_field
from granwave.lammps_inputs.case.stl_walls import (
    SMOOTH_ANGLE,
    checked_triangles,
    placed_triangles,
)
from granwave.lammps_inputs.tables.units import LENGTH_UNITS

WHOLE = "all"  # the one face of a plane, of a sphere, and of the outside of a cylinder
SIDE = "side"
_ENDS = ("lo", "hi")
_FACES_OF_BLOCK = ("xlo", "xhi", "ylo", "yhi", "zlo", "zhi")
#: Number of values of each style, after its axis if it has one.
_VALUES = {"plane": 6, "sphere": 4, "block": 6, "cylinder": 5, "cone": 6}
_WITH_AXIS = ("cylinder", "cone")
_FACES = {
    "plane": (WHOLE,),
    "sphere": (WHOLE,),
    "block": _FACES_OF_BLOCK,
    "cylinder": (*_ENDS, SIDE),
    "cone": (*_ENDS, SIDE),
}
_FORM = (
    'arguments of the LAMMPS region command (m), such as "plane 0 0 0.05 0 0 -1", "sphere 0 0 0 '
    '0.05", "block -0.1 0.1 -0.1 0.1 0 0.2", "cylinder z 0 0 0.05 0 0.1" or "cone z 0 0 0.05 0.01 '
    '0 0.1 open 1 open 2"'
)
_INFINITE = "INF"  # as a lower bound it means minus infinity


@dataclasses.dataclass(frozen=True)
class RegionShape:
    """Shape of a region.

    Attributes
    ----------
    style
        Style of LAMMPS.
    axis
        x, y or z, of cylinders and cones; empty for others.
    values
        Its numbers, m; the normal of a plane last.
    is_inside
        True if grains are inside.
    open_faces
        Numbers of faces without a wall, from 1.
    """

    style: str
    axis: str
    values: tuple[float, ...]
    is_inside: bool = True
    open_faces: tuple[int, ...] = ()

    @property
    def faces(self) -> tuple[str, ...]:
        """Names of the faces that are walls."""
        if not self.is_inside:
            return (WHOLE,)
        bounds = self.bounds
        return tuple(
            name
            for number, name in enumerate(_FACES[self.style], start=1)
            if number not in self.open_faces and math.isfinite(bounds.get(name, 0.0))
        )

    @property
    def bounds(self) -> dict[str, float]:
        """Coordinates of the flat faces across an axis, m, by name."""
        if self.style == "block":
            return dict(zip(_FACES_OF_BLOCK, self.values, strict=True))
        if self.style in _WITH_AXIS:
            return dict(zip(_ENDS, self.values[-2:], strict=True))
        return {}


def read_shape(text: str) -> RegionShape:
    """Read the words of a region; raise `ValidationError` if they are not a region."""
    style, *words = text.split() or [""]
    schema.refuse_if(style not in _VALUES, _FORM)
    axis = words.pop(0) if style in _WITH_AXIS and words else ""
    schema.refuse_if(style in _WITH_AXIS and axis not in ("x", "y", "z"), _FORM)
    n_values = _VALUES[style]
    schema.refuse_if(len(words) < n_values, _FORM)
    values = _numbers(words[:n_values], style)
    side, open_faces = _options(words[n_values:])
    shape = RegionShape(style, axis, values, side == "in", open_faces)
    _check_shape(shape)
    return shape


def _numbers(words: Sequence[str], style: str) -> tuple[float, ...]:
    """Return the numbers of a region of a style."""
    lower = {"block": (0, 2, 4), "cylinder": (3,)}.get(style, ())
    numbers = []
    for place, word in enumerate(words):
        try:
            number = math.inf if word == _INFINITE else float(word)
        except ValueError:
            raise schema.ValidationError(_FORM) from None
        schema.refuse_if(word != _INFINITE and not math.isfinite(number), _FORM)
        numbers.append(-number if word == _INFINITE and place in lower else number)
    return tuple(numbers)


def _options(words: Sequence[str]) -> tuple[str, tuple[int, ...]]:
    """Return the side and the numbers of the open faces from the words after the numbers."""
    schema.refuse_if(len(words) % 2, _FORM)
    side = "in"
    open_faces = []
    for keyword, value in zip(words[::2], words[1::2], strict=True):
        schema.refuse_if(
            keyword not in ("side", "open"), f"{_FORM}; the only options are side and open"
        )
        if keyword == "side":
            schema.refuse_if(value not in ("in", "out"), "side in or side out")
            side = value
        else:
            schema.refuse_if(not value.isdigit(), "open with the number of a face, from 1")
            open_faces.append(int(value))
    return side, tuple(open_faces)


def _check_shape(shape: RegionShape) -> None:
    """Raise `ValidationError` unless a shape has a size, and faces that can be walls."""
    values = shape.values
    low_and_high = [values[k : k + 2] for k in (0, 2, 4)] if shape.style == "block" else []
    low_and_high += [values[-2:]] if shape.axis else []
    schema.refuse_if(
        not all(low < high for low, high in low_and_high), "bounds in increasing order"
    )
    sizes = {"sphere": values[3:], "cylinder": values[2:3], "cone": values[2:4]}
    radii = sizes.get(shape.style, (1.0,))
    schema.refuse_if(min(radii) < 0 or not 0 < max(radii) < math.inf, "radii above 0")
    points = {"plane": values, "sphere": values, "cylinder": values[:3], "cone": values}
    is_finite = all(map(math.isfinite, points.get(shape.style, ())))
    schema.refuse_if(
        not is_finite, "finite numbers; INF is only allowed for bounds of a block or a cylinder"
    )
    schema.refuse_if(shape.style == "plane" and not any(values[3:]), "a normal that is not zero")
    last = len(_FACES[shape.style]) if shape.style in ("block", *_WITH_AXIS) else 0
    schema.refuse_if(
        any(not 1 <= face <= last for face in shape.open_faces),
        f"open faces from 1 to {last}" if last else f"no open face for a {shape.style}",
    )
    _check_outside(shape)
    schema.refuse_if(not shape.faces, "a region with a face that is neither open nor at INF")


def _check_outside(shape: RegionShape) -> None:
    """Raise `ValidationError` if the outside of a region has faces of several curvatures."""
    if shape.is_inside:
        return
    is_endless = shape.style == "cylinder" and not any(map(math.isfinite, shape.values[-2:]))
    schema.refuse_if(
        shape.style != "sphere" and not is_endless,
        "side out of a sphere, or of a cylinder with the bounds INF INF",
    )


def _checked(text: str) -> str:
    read_shape(text)
    return " ".join(text.split())


@dataclasses.dataclass(frozen=True, kw_only=True)
class RegionWall:
    """``[[wall]]``: faces of a LAMMPS region, or a surface of triangles, that hold the grains."""

    region: str | None = schema.typed(
        "shape: style, numbers (m) and the options side and open of the LAMMPS region command; "
        "each face that is neither open nor at INF is a wall",
        schema.TextType(expected=_FORM, finish=_checked),
        default=None,
    )
    stl: str | None = schema.path(
        "triangulated surface instead of a region: an STL file, text or binary", default=None
    )
    triangles: str | None = schema.typed(
        "the triangles of an STL file as text; the case.toml of a run stores them in this form",
        schema.TextType(expected="the text of an STL file", finish=checked_triangles),
        default=None,
    )
    units: str | None = schema.typed(
        "unit of the lengths of the STL file; metres by default",
        schema.ChoiceType(tuple(LENGTH_UNITS)),
        default=None,
    )
    moved: tuple[float, float, float] | None = schema.typed(
        "displacement of the surface from its position in the STL file",
        schema.vector_type(3, "[x, y, z] in m"),
        unit=LENGTH,
        default=None,
    )
    angle: float | None = schema.number(
        "largest angle between neighbouring triangles of a smooth patch (degrees); each patch is "
        f"a wall; default: {SMOOTH_ANGLE:g}",
        at_least=0,
        below=90,
        default=None,
    )
    material: Material | None = material_field()
    friction: float | None = schema.number(
        "coefficient of friction of the wall; default: the contact friction",
        at_least=0,
        default=None,
    )

    @property
    def shape(self) -> RegionShape:
        """Shape of the region."""
        return read_shape(str(self.region))

    @property
    def smooth_angle(self) -> float:
        """Largest angle between the normals of adjacent triangles of a patch, degrees."""
        return SMOOTH_ANGLE if self.angle is None else self.angle

    @property
    def corners(self) -> NDArray[np.float64]:
        """Corners of the triangles: (n, 3, 3), m; empty for a region."""
        if self.triangles is None:
            return np.empty((0, 3, 3))
        return placed_triangles(self.triangles, self.units, self.moved)

    @property
    def key_of_shape(self) -> str:
        """Key of the shape, for messages."""
        return "stl" if self.region is None else "region"

    @property
    def label(self) -> str:
        """The shape in messages."""
        if self.region is not None:
            return schema.show(self.region)
        return f"a surface of {len(self.corners)} triangles"
