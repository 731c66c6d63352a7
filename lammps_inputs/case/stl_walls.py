"""Surfaces of triangles of ``[[wall]]``: the file that ``stl`` names, stored with the case."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave._contact_laws import TriangleMesh, read_stl
from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.schema import ErrorList
from granwave.lammps_inputs.errors import Mismatch
from granwave.lammps_inputs.tables.units import LENGTH_UNITS

SMOOTH_ANGLE = 30.0  # largest angle between triangles of a patch, degrees
MOST_PATCHES = 100
_SHAPES = ("region", "stl", "triangles")
_OF_TRIANGLES = ("units", "moved", "angle")
_FORM = "the path of an STL file, text or binary"
_TEXT_FORM = "the text of an STL file, from solid to endsolid"


def with_triangles(data: Mapping[str, Any], errors: ErrorList) -> dict[str, Any]:
    """Return the tables of a case with the triangles of STL files instead of the names of the
    files.

    Faults of an entry, such as a region together with a file, are added to ``errors``.
    """
    walls = data.get("wall")
    if not isinstance(walls, list | tuple):
        return dict(data)
    read = []
    for number, table in enumerate(walls, start=1):
        key = f"wall.{number}"
        if isinstance(table, Mapping) and _check_shape(table, key, errors) and "stl" in table:
            table = _with_text(table, key, errors)
        read.append(table)
    return {**data, "wall": read}


def _check_shape(table: Mapping[str, Any], key: str, errors: ErrorList) -> bool:
    """Check that an entry has one shape and only keys of this shape."""
    shapes = [name for name in _SHAPES if name in table]
    if not shapes:
        errors.add(key, "found neither region nor stl, expected one of them: the shape of the wall")
        return False
    if len(shapes) > 1:
        found = f"found {shapes[0]} and {shapes[1]}, expected one shape"
        errors.add(key, f"{found}; write a separate [[wall]] for each")
        return False
    if shapes == ["region"]:
        for name in _OF_TRIANGLES:
            if name in table:
                errors.add(f"{key}.{name}", "found this key with a region; it applies only to stl")
    return True


def _with_text(table: Mapping[str, Any], key: str, errors: ErrorList) -> Mapping[str, Any]:
    """Return an entry with the triangles of its file; without them if there is a fault."""
    corners = schema.read_named(f"{key}.stl", table["stl"], _FORM, _read_file, errors)
    rest = {name: value for name, value in table.items() if name != "stl"}
    return rest if corners is None else {"triangles": stl_text(corners), **rest}


def _read_file(path: Path) -> NDArray[np.float64]:
    """Read the corners of the triangles of an STL file: (n, 3, 3), in its unit."""
    return np.asarray(read_stl(path.read_bytes()))


def stl_text(corners: NDArray[np.float64]) -> str:
    """Return the text of an STL file of triangles with corners (n, 3, 3)."""
    lines = ["solid wall"]
    for triangle in corners.tolist():
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += [f"vertex {x!r} {y!r} {z!r}" for x, y, z in triangle]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid wall", ""])


def checked_triangles(text: str) -> str:
    """Return the text of triangles; raise `ValidationError` if it does not contain triangles."""
    try:
        TriangleMesh(read_stl(text.encode()), SMOOTH_ANGLE)
    except ValueError as error:
        raise schema.ValidationError(f"{_TEXT_FORM}; {error}") from None
    return text


def placed_triangles(
    text: str, units: str | None, moved: tuple[float, ...] | None
) -> NDArray[np.float64]:
    """Return the corners of triangles (n, 3, 3) in the coordinates of the case, m."""
    scale = 10.0 ** LENGTH_UNITS[units or "m"]
    corners = scale * np.asarray(read_stl(text.encode()))
    return corners + np.array(moved) if moved else corners


def check_triangles(entry: Any, key: str, errors: ErrorList) -> None:
    """Check that the surface of an entry has not too many smooth patches; each is a wall."""
    if entry is None or entry.triangles is None:
        return
    n_patches = TriangleMesh(entry.corners, entry.smooth_angle).n_patches
    if n_patches > MOST_PATCHES:
        angle = f"{entry.smooth_angle:g} degrees"
        found = f"a surface of {n_patches} patches, at angles above {angle}"
        expected = f"at most {MOST_PATCHES}"
        remedy = "raise angle, or remove parts that no grain reaches"
        errors.add(f"{key}.angle", Mismatch(found, expected, remedy=remedy))
