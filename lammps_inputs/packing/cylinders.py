"""Distances, extents and contacts of cylinders, with the geometry of ``plugins/laws/cylinders.h``.

A sphere and the side of a cylinder touch in a point, and so do two cylinders that cross; parallel
cylinders touch along a line. The ends of a cylinder do not touch anything.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from granwave._contact_laws import CylinderPair
from granwave.lammps_inputs.case.material import Cylinder, Shape
from granwave.lammps_inputs.case.packing.grains import Grains

_NO_AXIS = (0.0, 0.0, 0.0)
_PARALLEL = 1e-9  # sine of the angle of axes up to which they count as parallel, as in the plugin


def cylinder_pair(first: Shape, second: Shape) -> CylinderPair:
    """Return the geometry of two grains, at least one of them a cylinder."""
    lengths = tuple(one.length if one else 0.0 for one in (first, second))
    axes = [one.axis if one else _NO_AXIS for one in (first, second)]
    return CylinderPair(length=lengths, first_axis=axes[0], second_axis=axes[1])


def extents(radius: NDArray[np.float64], shapes: Sequence[Shape]) -> NDArray[np.float64]:
    """Return the half-widths of grains along x, y, z: (n, 3), m."""
    found = np.repeat(radius[:, None], 3, axis=1)
    rows_of: dict[Cylinder, list[int]] = {}
    for row, shape in enumerate(shapes):
        if shape is not None:
            rows_of.setdefault(shape, []).append(row)
    for shape, rows in rows_of.items():
        along = np.abs(shape.vector)
        across = np.sqrt(np.maximum(1 - along**2, 0.0))
        found[rows] = radius[rows, None] * across + shape.length / 2 * along
    return found


def reaches(grains: Grains) -> NDArray[np.float64]:
    """Return the radii of spheres around the grains: (n,), m."""
    half = np.array([one.length / 2 if one else 0.0 for one in grains.shape])
    return np.where(half > 0, np.hypot(grains.diameter / 2, half), grains.diameter / 2)


def distances(
    position: NDArray[np.float64],
    diameter: NDArray[np.float64],
    shapes: Sequence[Shape],
    first: NDArray[np.int64],
    second: NDArray[np.int64],
    period: tuple[float, float] | None = None,
) -> NDArray[np.float64]:
    """Return the distances of centres or axes for pairs of rows, from which overlaps are computed:
    (n,), m.

    Beyond the end of a cylinder the distance of the centres is used, if the grain does not overlap
    with it.

    Parameters
    ----------
    period
        Periods along x and y, m.
    """
    centres = np.linalg.norm(nearest_image(position[second] - position[first], period), axis=1)
    if not any(shapes):
        return np.asarray(centres)
    distance, beyond = separations(position, shapes, first, second, period)
    return np.where(beyond > 0, np.maximum(centres, diameter[first] + diameter[second]), distance)


def nearest_image(
    step: NDArray[np.float64], period: tuple[float, float] | None
) -> NDArray[np.float64]:
    """Convert vectors between centres, (n, 3), to vectors to the nearest images with periods along
    x and y, m.
    """
    if period is not None:
        step[:, :2] -= period * np.round(step[:, :2] / period)
    return step


def separations(
    position: NDArray[np.float64],
    shapes: Sequence[Shape],
    first: NDArray[np.int64],
    second: NDArray[np.int64],
    period: tuple[float, float] | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the distances between the axes or centres of pairs of grains, and their distances from
    the end of a cylinder: (n,), m.

    Parameters
    ----------
    first, second
        Rows of the grains of each pair: (n,).
    period
        Periods along x and y, m.
    """
    distance = np.empty(len(first))
    beyond = np.empty(len(first))
    distinct = list(dict.fromkeys(shapes))
    kind = np.array([distinct.index(shape) for shape in shapes])
    for near, far in np.unique([kind[first], kind[second]], axis=1).T:
        rows = np.flatnonzero((kind[first] == near) & (kind[second] == far))
        between = nearest_image(position[first[rows]] - position[second[rows]], period)
        apart, beyond[rows] = nearest_vectors(between, distinct[near], distinct[far])
        distance[rows] = np.linalg.norm(apart, axis=1)
    return distance, beyond


def nearest_vectors(
    between: NDArray[np.float64], first: Shape, second: Shape
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the components of vectors between centres, (n, 3), along which the distances of two
    bodies count.

    Returns
    -------
    apart
        Vectors between centres or axes at their nearest points, in the same direction: (n, 3), m.
    beyond
        Distances of those positions from the end of a cylinder, negative between its ends: (n,), m.
    """
    one = first or second
    if one is None:
        return between, np.full(len(between), -np.inf)
    across = np.zeros(3) if first is None or second is None else np.cross(first.axis, second.axis)
    sine = float(np.linalg.norm(across))
    if first is None or second is None or sine <= _PARALLEL:
        along = between @ one.vector
        lengths = [grain.length for grain in (first, second) if grain is not None]
        return between - along[:, None] * one.vector, np.abs(along) - sum(lengths) / 2
    a = between @ first.vector
    b = between @ second.vector
    cosine = float(first.vector @ second.vector)
    on_first = (cosine * b - a) / sine**2
    on_second = b + cosine * on_first
    beyond = np.maximum(np.abs(on_first) - first.length / 2, np.abs(on_second) - second.length / 2)
    return (between @ across / sine)[:, None] * (across / sine), beyond


def turning_projection(
    normal: NDArray[np.float64], first: Shape, second: Shape
) -> NDArray[np.float64]:
    """Return the projections on the motions that turn a contact with these unit vectors, (n, 3):
    (n, 3, 3).

    Every motion across the normal turns a contact of spheres. Motion along an axis does not turn a
    contact of a cylinder, and no motion turns a contact of crossed axes.
    """
    found = np.eye(3) - normal[:, :, None] * normal[:, None, :]
    axes = [one.vector for one in (first, second) if one is not None]
    if len(axes) == 2 and np.linalg.norm(np.cross(axes[0], axes[1])) > _PARALLEL:
        return np.zeros_like(found)
    return found - np.outer(axes[0], axes[0]) if axes else found


def end_contacts(grains: Grains, slack: float) -> list[tuple[int, int]]:
    """Return the pairs of ids that touch or overlap at the end of a cylinder, sorted, i < j.

    For a sphere its distance from the rim or the face is below its radius. For cylinders the
    contact of their sides is beyond an end, or parallel cylinders are side by side over only a part
    of the shorter cylinder.

    Parameters
    ----------
    slack
        Largest gap of touching grains, m.
    """
    from scipy.spatial import KDTree  # imported on demand: slow to load

    radius = grains.diameter / 2
    reach = reaches(grains)
    cylinders = [row for row, one in enumerate(grains.shape) if one is not None]
    tree = KDTree(grains.position)
    near = tree.query_ball_point(grains.position[cylinders], reach[cylinders] + reach.max() + slack)
    pairs = set[tuple[int, ...]]()
    for row, others in zip(cylinders, near, strict=True):
        pairs.update(tuple(sorted((row, other))) for other in others)
    ids = 1 + np.array(
        sorted(pair for pair in pairs if pair[0] != pair[1]), dtype=np.int64
    ).reshape(-1, 2)
    distance, beyond = separations(grains.position, grains.shape, *(ids - 1).T)
    radii = radius[ids - 1]
    parallel: dict[tuple[tuple[float, ...], ...], bool] = {}  # cached by axes; a packing has few
    found = []
    for (one, other), apart, past, (r1, r2) in zip(
        ids.tolist(), distance, beyond, radii.tolist(), strict=True
    ):
        first = grains.shape[one - 1]
        second = grains.shape[other - 1]
        if first is not None and second is not None:
            lengths = first.length, second.length
            axes = first.axis, second.axis
            if axes not in parallel:
                parallel[axes] = bool(np.linalg.norm(np.cross(*axes)) <= _PARALLEL)
            if parallel[axes]:
                meets = apart < r1 + r2 + slack and -min(lengths) + slack < past <= slack
            else:
                meets = apart < r1 + r2 + slack and 0 < past < max(r1, r2)
        else:
            sphere, cylinder = (r1, r2) if first is None else (r2, r1)
            meets = past > 0 and bool(np.hypot(max(apart - cylinder, 0.0), past) < sphere + slack)
        if meets:
            found.append((one, other))
    return found


SPHERES = "spheres"
CYLINDERS = "cylinders"
GRAINS = "grains"
_WORD = re.compile(r"\b([Ss])phere(s?)\b")


def grains_called(n_grains: int, n_cylinders: int) -> str:
    """Return ``spheres``, ``cylinders`` or ``grains``."""
    if not n_cylinders:
        return SPHERES
    return CYLINDERS if n_cylinders >= n_grains else GRAINS


def in_grains(text: str, called: str) -> str:
    """Replace the word spheres in a text by the name of the grains, in the plural."""

    def other(found: re.Match[str]) -> str:
        word = called.removesuffix("s") + found[2]
        return word.capitalize() if found[1] == "S" else word

    return text if called == SPHERES else _WORD.sub(other, text)
