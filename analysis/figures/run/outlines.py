"""Outlines of walls around a packing, for pictures in three dimensions."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

_CORNERS = 64  # of the rim of a tube; a multiple of 4


def tube_lines(radius: float, top: float, bottom: float) -> Iterator[NDArray[np.float64]]:
    """Yield the rims of a tube around the axis x = y = 0, and four lines along it.

    Parameters
    ----------
    radius, top, bottom
        Radius, and z of the rims, m.

    Yields
    ------
    ndarray
        Points of a line: (n_points, 3), m.
    """
    angle = 2 * np.pi * np.arange(_CORNERS + 1) / _CORNERS
    circle = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    for level in (top, bottom):
        yield np.column_stack([circle, np.full(len(circle), level)])
    for place in circle[: -1 : _CORNERS // 4]:
        yield np.array([[*place, top], [*place, bottom]])


def plane_lines(
    axis: int, coordinate: float, low: NDArray[np.float64], high: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the edges of a plane across an axis (0, 1, 2) between the bounds of a packing: (5, 3), m."""
    first, second = (other for other in range(3) if other != axis)
    corners = np.empty((4, 3))
    corners[:, axis] = coordinate
    corners[:, first] = [low[first], high[first], high[first], low[first]]
    corners[:, second] = [low[second], low[second], high[second], high[second]]
    return np.concatenate([corners, corners[:1]])
