"""Nearest of a few or of many places to points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_BY_TREE = 3_000_000  # distances from which on a tree gains more than loading it takes
_BLOCK = 200_000  # distances that are computed at a time, whose numbers fit into the processor's cache


def nearest(points: NDArray[np.float64], places: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the distance from each point to its nearest place, m, and that place's row: (n_points,) each.

    Parameters
    ----------
    points, places
        (n_points, 3) and (n_places, 3), m; at least one place.
    """
    if len(points) * len(places) > _BY_TREE and len(places) > 1:
        from scipy.spatial import cKDTree  # takes longer to load than many a figure to draw

        distance, row = cKDTree(places).query(points)
        return distance, row.astype(np.int64)
    row = np.empty(len(points), dtype=np.int64)
    block = max(1, _BLOCK // len(places))
    for start in range(0, len(points), block):
        square = sum((points[start : start + block, None, axis] - places[:, axis]) ** 2 for axis in range(3))
        row[start : start + block] = np.argmin(square, axis=1)
    return np.linalg.norm(points - places[row], axis=1), row
