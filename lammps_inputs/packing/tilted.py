"""Spheres of a square packing on a slightly tilted floor: each lies on it, leaning on two neighbours or walls.

The spheres roll to a corner and come to rest one after another, so that every sphere touches the next one towards the
corner in its row and in its column, or the wall there. Sphere (a, b), counted from the corner, is where the circles of
these contacts meet; all spheres of a diagonal are placed at once. The contacts are closed and bear no force.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Cells = tuple[NDArray[np.int64], NDArray[np.int64]]  # rows and columns of arrays (ny, nx)


def lean(size: tuple[int, ...], diameter: float, diameters: Array, tilt: tuple[int, int]) -> Array:
    """Return the centres of leaning spheres: (nx ny, 3), m, ids with x fastest.

    Parameters
    ----------
    size
        Numbers of spheres along x and y.
    diameter
        Nominal diameter, m: walls and floor touch nominal spheres at the sites of the lattice.
    diameters
        Diameters of the spheres, at most the nominal one: (nx ny,), m.
    tilt
        Signs of the directions along x and y in which the spheres roll.

    Raises
    ------
    ValueError
        The spheres differ so much that one finds no place between its neighbours.
    """
    nx, ny = size[:2]
    radii = _from_corner(diameters.reshape(ny, nx) / 2, tilt)
    drop = diameter / 2 - radii  # of the centres below those of nominal spheres
    u, v = np.empty_like(radii), np.empty_like(radii)  # distances from the two walls
    u[:, 0], v[0, :] = radii[:, 0], radii[0, :]
    for diagonal in range(1, nx + ny - 1):
        b = np.arange(max(0, diagonal - nx + 1), min(ny, diagonal + 1))
        a = diagonal - b
        reach_u = _reach(radii, drop, (b, a), (b, a - 1))  # of the one in its row; no use at the wall
        reach_v = _reach(radii, drop, (b, a), (b - 1, a))
        first, last, inner = (b == 0) & (a > 0), (a == 0) & (b > 0), (a > 0) & (b > 0)
        u[b[first], a[first]] = u[0, a[first] - 1] + _side(reach_u[first], v[0, a[first]] - v[0, a[first] - 1])
        v[b[last], 0] = v[b[last] - 1, 0] + _side(reach_v[last], u[b[last], 0] - u[b[last] - 1, 0])
        i, j = b[inner], a[inner]
        beside = np.stack([u[i, j - 1], v[i, j - 1]])
        below = np.stack([u[i - 1, j], v[i - 1, j]])
        u[i, j], v[i, j] = _meet(beside, reach_u[inner], below, reach_v[inner])
    far = np.array([nx - 1, ny - 1]) * diameter + diameter / 2  # where the far walls are
    x, y = (
        far[axis] - part if sign > 0 else part - diameter / 2
        for axis, (part, sign) in enumerate(zip((u, v), tilt, strict=True))
    )
    centres = np.stack([_from_corner(part, tilt).ravel() for part in (x, y, drop)], axis=1)
    return np.asarray(centres)


def _from_corner(values: Array, tilt: tuple[int, int]) -> Array:
    """Reverse the axes of values (ny, nx) so that the first is at the corner; its own inverse."""
    return values[:: -tilt[1], :: -tilt[0]]


def _reach(radii: Array, drop: Array, one: Cells, other: Cells) -> Array:
    """Distance in the plane of the centres of two touching spheres on the floor."""
    return _side(radii[one] + radii[other], drop[one] - drop[other])


def _side(hypotenuse: Array, other: Array) -> Array:
    """Third side of a right triangle."""
    square = hypotenuse**2 - other**2
    if square.size and square.min() <= 0:
        raise ValueError("the diameters differ too much for spheres that lean on each other")
    return np.sqrt(square)


def _meet(beside: Array, reach_u: Array, below: Array, reach_v: Array) -> Array:
    """Meeting point, away from the corner, of circles about two points each: (2, n)."""
    between = below - beside
    apart = np.linalg.norm(between, axis=0)
    along = (apart**2 + reach_u**2 - reach_v**2) / (2 * apart)
    away = _side(reach_u, along)
    normal = np.stack([-between[1], between[0]]) / apart
    return np.asarray(beside + along * between / apart + away * normal)
