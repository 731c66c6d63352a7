"""Grains of a section: discs for spheres, rectangles for cylinders seen from the side."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import Collection, EllipseCollection, PolyCollection
from matplotlib.colors import to_rgba
from numpy.typing import NDArray

from granwave.analysis.figures.colouring import Colouring, disc_colours
from granwave.analysis.measures.geometry import SpheresOnPlane
from granwave.analysis.result.reader import Result

OUTLINE = "#9a9a9a"  # colour of the outlines of grains
_MILLI = 1e3  # mm in a metre
_RING = 1.0  # width of the ring around a sphere beyond the range of the law, points
_OUTLINE_WIDTH = 0.5  # points
_EDGE_WIDTH = 0.2  # width of the edge of a coloured disc, points
_DISC = 0.96  # drawn / actual diameter
_SEEN_ALONG = 0.1  # length of an axis in a section / radius below which a cylinder is seen end-on


def draw_discs(
    axes: Axes,
    cut: SpheresOnPlane,
    values: NDArray[np.float64],
    colouring: Colouring,
    radius: NDArray[np.float64],
    ringed: NDArray[np.bool_] | None = None,
    sticks: NDArray[np.float64] | None = None,
) -> EllipseCollection:
    """Draw the discs, in mm: blank without a value, rings beyond the range of the law; cylinders as
    rectangles. Return the discs.
    """
    faces, edges = disc_colours(values, colouring)
    if ringed is not None:
        edges[ringed] = to_rgba("black")  # colour at the bright end of the scale
    widths = np.where(values > 0, _EDGE_WIDTH, _OUTLINE_WIDTH)
    if ringed is not None:
        widths = np.where(ringed, _RING, widths)
    discs, *_ = _add_grains(axes, cut, radius, sticks, faces, edges, widths)
    return discs


def outline_grains(
    axes: Axes,
    cut: SpheresOnPlane,
    radius: NDArray[np.float64],
    sticks: NDArray[np.float64] | None = None,
) -> list[Collection]:
    """Draw the grains of a section as thin outlines, in mm: circles, and rectangles for cylinders.
    Return the artists.
    """
    number = len(radius)
    faces = np.tile(to_rgba("white"), (number, 1))
    edges = np.tile(to_rgba(OUTLINE), (number, 1))
    return _add_grains(axes, cut, radius, sticks, faces, edges, np.full(number, _OUTLINE_WIDTH))


def disc_radii(result: Result, cut: SpheresOnPlane) -> NDArray[np.float64]:
    """Return the radii of the discs of a section: radii of the spheres on a plane of the lattice,
    and radii of the cuts on other planes.

    Centres of scattered spheres are off the planes of the lattice by less than the tolerance of
    the plane.
    """
    radius = result["spheres/radius"][cut.index]
    if cut.plane.name != "section":
        return radius
    of_cut = np.sqrt(np.maximum(radius**2 - cut.height**2, 0.0))
    axes = half_axes(result, cut.index)
    return of_cut if axes is None else np.where(axes.any(axis=1), radius, of_cut)


def half_axes(result: Result, rows: NDArray[np.int64]) -> NDArray[np.float64] | None:
    """Return vectors from the centres of cylinders to their ends, 0 for spheres: (n_rows, 3), m;
    None without any.
    """
    if not result.assembly.has_cylinders:
        return None
    shapes = result.assembly.grain_shapes()
    axes = np.zeros((len(rows), 3))
    for axis, row in zip(axes, rows, strict=True):
        shape = shapes[row]
        if shape is not None:
            axis[:] = shape.vector * shape.length / 2
    return axes


def sticks_of(result: Result, cut: SpheresOnPlane) -> NDArray[np.float64] | None:
    """Return half the axis of each cylinder in the plane of a section, 0 for spheres and for
    cylinders along the line of sight: (n, 2), m.

    None if there are only spheres.
    """
    if (axes := half_axes(result, cut.index)) is None:
        return None
    half = axes @ np.stack([cut.plane.across, cut.plane.down], axis=1)
    length = np.linalg.norm(half, axis=1, keepdims=True)
    return np.where(length > _SEEN_ALONG * result["spheres/radius"][cut.index][:, None], half, 0.0)


def _add_grains(
    axes: Axes,
    cut: SpheresOnPlane,
    radius: NDArray[np.float64],
    sticks: NDArray[np.float64] | None,
    faces: NDArray[np.float64],
    edges: NDArray[np.float64],
    widths: NDArray[np.float64],
) -> list[Any]:
    """Add the grains of a section to axes: discs, and rectangles for cylinders seen from the side.

    Parameters
    ----------
    radius, widths
        Radii, m, and widths of the edges, points: (n,).
    sticks
        As `sticks_of` returns them.
    faces, edges
        Colours: (n, 4).

    Returns
    -------
    list
        The collection of discs; that of rectangles, if there are any.
    """
    size = _DISC * 2 * radius * _MILLI
    rectangles = []
    if sticks is not None and (long := sticks.any(axis=1)).any():
        corners = _corners(
            np.stack([cut.across, cut.down], axis=1)[long], sticks[long], size[long] / _MILLI / 2
        )
        collection = PolyCollection(
            list(corners * _MILLI),
            facecolors=faces[long],
            edgecolors=edges[long],
            linewidths=widths[long],
        )
        axes.add_collection(collection)
        rectangles.append(collection)
        size = np.where(long, 0.0, size)
    places = {
        "offsets": np.stack([cut.across, cut.down], axis=1) * _MILLI,
        "offset_transform": axes.transData,
    }
    look = {"facecolors": faces, "edgecolors": edges, "linewidths": widths}
    discs = EllipseCollection(size, size, np.zeros(len(size)), units="xy", **places, **look)
    axes.add_collection(discs)
    return [discs, *rectangles]


def _corners(
    centre: NDArray[np.float64], half: NDArray[np.float64], radius: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the corners of rectangles from half their axes and half their widths: (n, 4, 2)."""
    across = (
        half[:, ::-1]
        * np.array([-1.0, 1.0])
        / np.linalg.norm(half, axis=1, keepdims=True)
        * radius[:, None]
    )
    return np.stack(
        [centre + a * half + b * across for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))], axis=1
    )
