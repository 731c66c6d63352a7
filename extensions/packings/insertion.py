"""Random positions in a box or a column, at which grains start."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.errors import InputError

Floats = NDArray[np.float64]

# initial solid fraction; up to 0.3, random positions are found in a few attempts
SOLID_FRACTION = 0.2
_MOST_ATTEMPTS = 10_000  # most attempts for one grain


def column_height(volume: float, area: float) -> float:
    """Return the height of the column from which grains of a total volume (m^3) fall, m."""
    return volume / (SOLID_FRACTION * area)


def insert(
    diameter: Floats,
    box: tuple[float, float],
    height: float,
    random: np.random.Generator,
    *,
    periodic: bool = False,
    tube: float | None = None,
) -> Floats:
    """Draw positions of grains in a column that do not overlap: (n, 3), m, with depths from -height
    to 0.

    Parameters
    ----------
    diameter
        (n,), m.
    box
        Widths along x and y, from 0, m.
    periodic
        True if the column is periodic along x and y.
    tube
        Radius of a tube about x = y = 0 instead of the box, m.

    Raises
    ------
    InputError
        There is no room.
    """

    def draw(size: float) -> Floats:
        return _draw(size, box, height, random, periodic=periodic, tube=tube)

    period = [*box, math.inf] if periodic else [math.inf] * 3
    return _apart(diameter, draw, period)


def scatter(
    diameter: Floats,
    lengths: Sequence[float] | Floats,
    periodic: Sequence[bool],
    random: np.random.Generator,
) -> Floats:
    """Draw positions of grains that do not overlap in a box with a corner at 0: (n, 3), m.

    Parameters
    ----------
    diameter
        (n,), m.
    lengths
        Lengths of the box along x, y and z, m.
    periodic
        True for the axes along which the box is periodic; the other axes have walls.

    Raises
    ------
    InputError
        There is no room.
    """

    def draw(size: float) -> Floats:
        margin = np.where(periodic, 0.0, size / 2)
        return random.uniform(margin, lengths - margin)

    return _apart(diameter, draw, np.where(periodic, lengths, math.inf))


def _apart(
    diameter: Floats, draw: Callable[[float], Floats], period: Sequence[float] | Floats
) -> Floats:
    """Draw a position for each grain until it overlaps no earlier grain: (n, 3), m."""
    places = np.empty((len(diameter), 3))
    for n, size in enumerate(diameter):
        for _ in range(_MOST_ATTEMPTS):
            place = draw(size)
            apart = places[:n] - place
            apart -= nearest_image(apart, period)
            reach = (diameter[:n] + size) / 2
            if ((apart**2).sum(axis=1) > reach**2).all():
                places[n] = place
                break
        else:
            raise InputError(f"packing.grains: found no space for grain {n + 1}; use a wider box")
    return places


def nearest_image(apart: Floats, period: Sequence[float] | Floats) -> Floats:
    """Return the multiples of the periods to subtract from differences of positions, for the
    nearest image: (n, 3), m.

    Parameters
    ----------
    apart
        Differences of positions: (n, 3), m.
    period
        Periods along x, y and z, infinite along axes that are not periodic: (3,), m.
    """
    finite = np.isfinite(period)
    length = np.where(finite, period, 1.0)
    return np.asarray(np.where(finite, np.round(apart / length) * length, 0.0))


def _draw(
    size: float,
    box: tuple[float, float],
    height: float,
    random: np.random.Generator,
    *,
    periodic: bool,
    tube: float | None,
) -> Floats:
    """Draw one position inside the walls: (3,), m."""
    depth = random.uniform(-height, -size / 2)
    if tube is not None:
        radius = (tube - size / 2) * math.sqrt(random.uniform())
        angle = random.uniform(0, 2 * math.pi)
        return np.array([radius * math.cos(angle), radius * math.sin(angle), depth])
    margin = 0.0 if periodic else size / 2
    x, y = (random.uniform(margin, width - margin) for width in box)
    return np.array([x, y, depth])
