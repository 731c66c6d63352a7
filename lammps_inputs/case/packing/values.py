"""Types of the values of ``[packing]``: size, gaps, cell, vacancies, tilt, grains and enclosure."""

from __future__ import annotations

import dataclasses
import math
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.packing.grains import Grains, parse_grains
from granwave.lammps_inputs.case.schema import ValidationError

LARGEST_ID = schema.LARGEST_COUNT
_WAYS_FORM = (
    "[1, 1], [1, -1], [-1, 1] or [-1, -1]: the directions along x and y in which the spheres roll"
)
_SIZE_FORM = (
    "whole numbers from 1 up: [nx, ny, nz], [nx, ny] (square), [nx, nz] (crystals in the plane) or "
    "n (chain)"
)
_VACANCIES_FORM = "a fraction of the spheres, 0 or more and below 1, or a list of ids"
_GAPS_FORM = "a list of [sphere, width], such as [[14, 3e-4], [15, 3e-4]], each sphere once"
_RANGE_FORM = "[from, to] in m, the second one larger"
_RANGE = schema.vector_type(2, _RANGE_FORM, lambda low, high: low < high)
ENCLOSURE_FORM = "{x = [0.0, 0.1], y = [0.0, 0.1], bottom = 0.05}, each of which is optional"
_CELL_FORM = "one, two or three vectors [x, y, z] in m that point in different directions"
_GRAINS_FORM = "a table of grains as text, in the format of packing.file"


def _both_ways(ways: tuple[float, float]) -> tuple[int, int]:
    x, y = ways
    schema.refuse_if(abs(x) != 1 or abs(y) != 1, _WAYS_FORM)
    return int(x), int(y)


def _size(counts: tuple[int, ...]) -> tuple[int, ...]:
    is_too_large = math.prod(counts) > LARGEST_ID
    schema.refuse_if(is_too_large, f"at most {LARGEST_ID} spheres in all")
    return counts


def _different_ids(ids: tuple[int, ...]) -> tuple[int, ...]:
    return tuple(sorted(set(ids)))


@dataclasses.dataclass(frozen=True)
class GapType(schema.ValueType):
    """Type of a gap of a chain: the sphere before it and its width."""

    expected: str = _GAPS_FORM

    def read(self, value: Any) -> tuple[int, float]:
        """Return sphere and width, m."""
        is_pair = isinstance(value, list | tuple) and len(value) == 2
        schema.refuse_if(not is_pair, self.expected)
        sphere, width = value
        return schema.whole(sphere, self.expected), schema.finite(width, self.expected)

    @property
    def json(self) -> dict[str, Any]:
        """A list of two numbers."""
        return schema.vector_type(2, self.expected).json


def _gaps(gaps: tuple[tuple[int, float], ...]) -> tuple[tuple[int, float], ...]:
    spheres = {sphere for sphere, _ in gaps}
    schema.refuse_if(len(spheres) < len(gaps), _GAPS_FORM)
    return gaps


def _cell(
    vectors: tuple[tuple[float, float, float], ...],
) -> tuple[tuple[float, float, float], ...]:
    lengths = [math.hypot(*vector) for vector in vectors]
    schema.refuse_if(not all(lengths), _CELL_FORM)
    directions = np.array(vectors) / np.array(lengths)[:, None]
    schema.refuse_if(np.linalg.matrix_rank(directions) < len(vectors), _CELL_FORM)
    return vectors


def _read_text(text: str) -> Grains:
    try:
        return parse_grains(text, None)
    except ValueError as error:
        raise ValidationError(f"{_GRAINS_FORM}: {error}") from None


@dataclasses.dataclass(frozen=True)
class GrainsType(schema.ValueType):
    """Type of a table of grains: its text, or the grains that were read of a file."""

    expected: str = _GRAINS_FORM
    kind: ClassVar[str] = "string"

    def read(self, value: Any) -> Grains:
        """Return the grains."""
        if isinstance(value, Grains):
            return value
        schema.refuse_if(not isinstance(value, str), self.expected)
        return _read_text(value)

    @property
    def json(self) -> dict[str, Any]:
        """A string."""
        return {"type": "string"}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Enclosure:
    """Planes of the walls around grains of a file."""

    x: tuple[float, float] | None = schema.typed(
        "planes of the walls across x", _RANGE, unit="m", default=None
    )
    y: tuple[float, float] | None = schema.typed(
        "planes of the walls across y", _RANGE, unit="m", default=None
    )
    bottom: float | None = schema.number("depth of the bottom plane", "m", default=None)

    def around(self, faces: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the planes; by default they touch the outermost grains: (2, 3), m.

        Parameters
        ----------
        faces
            Lowest and highest coordinates of surfaces of grains: (2, 3), m.
        """
        planes = faces.copy()
        for axis, ends in enumerate((self.x, self.y)):
            if ends is not None:
                planes[:, axis] = ends
        if self.bottom is not None:
            planes[1, 2] = self.bottom
        return planes


SIZE = schema.ListType(
    item=schema.CountType(form=_SIZE_FORM),
    expected=_SIZE_FORM,
    at_most=3,
    alone=True,
    finish=_size,
)
GAPS = schema.ListType(item=GapType(), expected=_GAPS_FORM, finish=_gaps)
CELL = schema.ListType(
    item=schema.vector_type(3, _CELL_FORM), expected=_CELL_FORM, at_most=3, finish=_cell
)
VACANCIES = schema.EitherType(
    types=(
        schema.ListType(
            item=schema.CountType(form=_VACANCIES_FORM),
            expected=_VACANCIES_FORM,
            at_least=0,
            finish=_different_ids,
        ),
        schema.NumberType(at_least=0, below=1, form=_VACANCIES_FORM),
    ),
    form=_VACANCIES_FORM,
)
WAYS = schema.ListType(
    item=schema.NumberType(form=_WAYS_FORM),
    expected=_WAYS_FORM,
    at_least=2,
    at_most=2,
    finish=_both_ways,
)
