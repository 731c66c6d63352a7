"""Random places in a column, from which grains fall."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.errors import InputError

Floats = NDArray[np.float64]

_SOLID_FRACTION = 0.2  # of the column; up to 0.3 random places are found in a few attempts
_MOST_ATTEMPTS = 10_000  # of one grain


def column_height(volume: float, area: float) -> float:
    """Return the height of the column that grains of a volume (m^3) fall from, m."""
    return volume / (_SOLID_FRACTION * area)


def insert(
    diameter: Floats,
    box: tuple[float, float],
    height: float,
    random: np.random.Generator,
    *,
    periodic: bool = False,
    tube: float | None = None,
) -> Floats:
    """Draw places of grains in a column that do not overlap: (n, 3), m, with depths from -height
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
        Radius of a tube about x = y = 0 in place of the box, m.

    Raises
    ------
    InputError
        There is no room.
    """
    places = np.empty((len(diameter), 3))
    period = np.array([*box, math.inf])
    for n, size in enumerate(diameter):
        for _ in range(_MOST_ATTEMPTS):
            place = _draw(size, box, height, random, periodic=periodic, tube=tube)
            apart = places[:n] - place
            if periodic:
                apart[:, :2] -= np.round(apart[:, :2] / period[:2]) * period[:2]
            reach = (diameter[:n] + size) / 2
            if ((apart**2).sum(axis=1) > reach**2).all():
                places[n] = place
                break
        else:
            raise InputError(f"packing.grains: found no room for grain {n + 1}; take a wider box")
    return places


def _draw(
    size: float,
    box: tuple[float, float],
    height: float,
    random: np.random.Generator,
    *,
    periodic: bool,
    tube: float | None,
) -> Floats:
    """Draw one place inside of the walls: (3,), m."""
    depth = random.uniform(-height, -size / 2)
    if tube is not None:
        radius = (tube - size / 2) * math.sqrt(random.uniform())
        angle = random.uniform(0, 2 * math.pi)
        return np.array([radius * math.cos(angle), radius * math.sin(angle), depth])
    margin = 0.0 if periodic else size / 2
    x, y = (random.uniform(margin, width - margin) for width in box)
    return np.array([x, y, depth])
