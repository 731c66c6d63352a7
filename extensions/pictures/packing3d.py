"""Images of the packing in three dimensions with a quarter cut away, coloured by a quantity."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from weakref import WeakKeyDictionary

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from numpy.typing import NDArray

from granwave.analysis.figures.colouring import (
    Colouring,
    colour_bar,
    dissipation_colouring,
    peak_force_colouring,
)
from granwave.analysis.figures.grain_discs import half_axes
from granwave.analysis.figures.impact_arrow import draw_arrow, impact_arrow
from granwave.analysis.figures.run_figures import RunFigure
from granwave.analysis.figures.style import BLANK, GREY, WIDTH, Drawing, new_figure
from granwave.analysis.result.reader import Result
from granwave.extensions.pictures.sphere_renderer import (
    Camera,
    RenderedSpheres,
    lit_surface,
    painted,
)
from granwave.lammps_inputs.packing.walls import walls

_PIXELS = 1000  # width of the picture, about that of the figure at its resolution
_HIGHEST = 6.5  # inches, of the picture
# degrees
AZIMUTH = -58.0
ELEVATION = 30.0
_MILLI = 1e3  # mm in a metre
_ARROW = 0.1  # length of the arrow of the load over the width of the picture
_AROUND_ARROW = 0.01  # between the arrow and the edge, over the width of the picture
_CUT = 0.3  # diameters: spheres that extend beyond the cutting planes by less are kept
_BELOW = 0.3  # margin of the image below a tube, widths
_LEAST_SPHERES = 8
_ROUND_LENGTHS = (1, 2, 5)
_SURFACES: WeakKeyDictionary[Result, tuple[NDArray[np.intp], RenderedSpheres]] = WeakKeyDictionary()
_CAMERA = Camera.looking(AZIMUTH, ELEVATION, np.array([0.0, 0.0, -1.0]))  # depth goes down


def packing_3d(result: Result) -> Drawing | None:
    """Draw the cut packing, coloured by peak force."""
    if not np.any(result["spheres/peak_force"] > 0):
        return None
    return draw_packing(result, peak_force_colouring(result))


def packing_3d_dissipation(result: Result) -> Drawing | None:
    """Draw the cut packing, coloured by dissipation."""
    if not np.any(result["spheres/dissipated_energy"] > 0):
        return None
    return draw_packing(result, dissipation_colouring(result))


def draw_packing(
    result: Result, colouring: Colouring, size: tuple[float, float] | None = None
) -> Drawing | None:
    """Draw the cut packing in any colouring; return None for a chain, for which curves are clearer.

    Parameters
    ----------
    size
        Width and height of the figure, inches; by default a column, as high as the packing needs.
    """
    if not can_be_cut(result):
        return None
    positions = result["spheres/position"]
    kept, surface = _surface_of(result)
    values = colouring.values[kept]
    left, right, bottom, top = (edge * _MILLI for edge in surface.extent)
    figure = new_figure(min((WIDTH - 0.1) * (top - bottom) / (right - left), _HIGHEST) + 0.75)
    if size is not None:
        figure.set_size_inches(size)
    axes = figure.subplots()
    outlined = _has_outlines(result)
    axes.imshow(
        packing_pixels(result, colouring),
        extent=(left, right, bottom, top),
        interpolation="antialiased",
    )
    axes.set_axis_off()
    if outlined:
        _draw_walls(axes, result, _CAMERA)
        bottom -= _BELOW * (right - left)  # for the scale bar
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    wanted = 0.2 * (right - left)  # a scale bar of a round length, mm, in the lower left corner
    power = 10 ** np.floor(np.log10(wanted))
    length = power * max(step for step in _ROUND_LENGTHS if step * power <= wanted)
    start = left + 0.02 * (right - left)
    axes.plot(
        [start, start + length],
        [bottom, bottom],
        color="black",
        linewidth=1.5,
        solid_capstyle="butt",
    )
    axes.annotate(
        f"{length:g} mm",
        (start + length / 2, bottom),
        (0, 3),
        textcoords="offset points",
        ha="center",
        va="bottom",
    )
    arrow = impact_arrow(result)
    place, beyond = _CAMERA.project(np.array([arrow.place, arrow.place + arrow.direction]))[:, :2]
    diameter = result.case.packing.diameter * _MILLI
    length = max(_ARROW * (right - left) / diameter, 1.0)
    tail = draw_arrow(axes, place * _MILLI, beyond - place, diameter, length)
    margin = _AROUND_ARROW * (right - left)
    axes.set_xlim(min(left, tail[0] - margin), max(right, tail[0] + margin))
    axes.set_ylim(min(bottom, tail[1] - margin), max(top, tail[1] + margin))
    seen = values[surface.visible]
    shown = np.where(seen < colouring.low, 0.0, seen)
    colour_bar(figure, [axes], colouring, shown, bar_location(size), "below the scale")
    rows = kept[surface.visible]
    columns = {"id": result["spheres/id"][rows]}
    columns |= {f"{axis}_m": place for axis, place in zip("xyz", positions[rows].T, strict=True)}
    return Drawing(figure, columns | {colouring.column: colouring.values[rows]})


def packing_pixels(result: Result, colouring: Colouring) -> NDArray[np.uint8]:
    """Return the image of the cut packing in red, green, blue and opacity: (height, width, 4)."""
    kept, surface = _surface_of(result)
    values = colouring.values[kept]
    colours = colormaps[colouring.map](
        colouring.norm(np.clip(values, colouring.low, colouring.high))
    )[:, :3]
    colours[values < colouring.low] = to_rgb(BLANK)
    image = painted(surface, colours)
    if not _has_outlines(result):  # on white, as no lines behind are visible: files are smaller
        alpha = image[..., 3:]
        image = np.concatenate([image[..., :3] * alpha + (1 - alpha), np.ones_like(alpha)], axis=-1)
    return np.rint(image * 255).astype(np.uint8)


def _has_outlines(result: Result) -> bool:
    """Return True if walls are drawn before and behind the packing."""
    return any(wall.tube or wall.plate for wall in walls(result.assembly))


def _surface_of(result: Result) -> tuple[NDArray[np.intp], RenderedSpheres]:
    """Return the rows of the visible spheres and the rendered spheres, common to all images of a
    result.
    """
    if result not in _SURFACES:
        positions = result["spheres/position"]
        beyond = (positions - result.origin)[:, :2]
        towards = np.sign(_CAMERA.towards[:2])
        # the quarter that is cut away; a single layer is not cut, as it hides nothing
        facing = np.all(beyond * towards > _CUT * result.case.packing.diameter, axis=1)
        one_layer = _is_one_layer(positions, result)
        kept = np.flatnonzero(~facing | one_layer)
        places = positions[kept]
        radii = result["spheres/radius"][kept]
        across, up = np.ptp(_CAMERA.project(places)[:, :2], axis=0) + 2 * radii.max()
        pixels = round(_PIXELS * min(_HIGHEST / WIDTH * across / up, 1.0))
        axes = half_axes(result, kept)
        _SURFACES[result] = kept, lit_surface(places, radii, _CAMERA, pixels, axes)
    return _SURFACES[result]


def _is_one_layer(positions: NDArray[np.float64], result: Result) -> bool:
    """Return True for spheres at positions, (n_spheres, 3), m, in a layer, which is not cut."""
    return bool(np.ptp(positions[:, 2]) < _CUT * result.case.packing.diameter)


def bar_location(size: tuple[float, float] | None) -> str:
    """Return the position of the colour bar: to the right in a figure that is wider than high."""
    return "right" if size is not None and size[0] > size[1] else "bottom"


def can_be_cut(result: Result) -> bool:
    """Return True for a packing that extends along x and y; chains are shown by curves."""
    positions = result["spheres/position"]
    return len(positions) >= _LEAST_SPHERES and bool(np.min(np.ptp(positions, axis=0)[:2]) > 0)


def _draw_walls(axes: Axes, result: Result, camera: Camera) -> None:
    """Draw the outlines of a tube, and of a plate on the top: thick behind the packing, and thin in
    front of it.
    """
    radius = float(result["spheres/radius"].max())
    low, high = result.assembly.lattice_bounds()
    low = low - radius
    high = high + radius
    for wall in walls(result.assembly):
        lines = []
        if wall.tube:
            lines = list(tube_lines(wall.coordinate, low[2], high[2]))
        elif wall.plate is not None:
            lines = [plane_lines(wall.axis, wall.coordinate, low, high)]
        for line in lines:
            seen = camera.project(line)
            before = ((line[:-1] + line[1:] - low - high)[:, :2] @ camera.towards[:2]) > 0
            for start, end, is_before in zip(
                seen[:-1] * _MILLI, seen[1:] * _MILLI, before, strict=True
            ):
                width, order = (0.4, 3) if is_before else (0.8, -1)
                pair = zip(start[:2], end[:2], strict=True)
                axes.plot(*pair, color=GREY, clip_on=False, linewidth=width, zorder=order)


_CORNERS = 64  # corners of the rim of a tube; a multiple of 4


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
    """Return the edges of a plane across an axis (0, 1, 2) between the bounds of a packing: (5, 3),
    m.
    """
    first, second = (other for other in range(3) if other != axis)
    corners = np.empty((4, 3))
    corners[:, axis] = coordinate
    corners[:, first] = [low[first], high[first], high[first], low[first]]
    corners[:, second] = [low[second], low[second], high[second], high[second]]
    return np.concatenate([corners, corners[:1]])


_QUARTER = "A quarter is cut away at the impact; "
_SCALE = "White: below the scale, or none."


def _uncut(caption: str, look: str, result: Result, _: Path) -> tuple[str, str]:
    """Return caption and look of a figure of a run, without a cut for a packing of one layer."""
    if not _is_one_layer(result["spheres/position"], result):
        return f"Packing cut open, {caption}", f"{_QUARTER}{look} {_SCALE}"
    return f"Packing of one layer, {caption}", f"{look[:1].upper()}{look[1:]} {_SCALE}"


_FORCE = ("peak contact force, excluding walls", "bright spheres carried the largest forces.")
_LOSS = ("dissipation", "bright spheres dissipated the most energy.")
#: Figures of a run; the two share the selection of visible spheres.
PEAK_FORCE = RunFigure(
    f"Packing cut open, {_FORCE[0]}",
    packing_3d,
    f"{_QUARTER}{_FORCE[1]} {_SCALE}",
    shares_work_with=("packing_3d_dissipation",),
    takes_long=True,
    words=partial(_uncut, *_FORCE),
)
DISSIPATION = RunFigure(
    f"Packing cut open, {_LOSS[0]}",
    packing_3d_dissipation,
    f"{_QUARTER}{_LOSS[1]} {_SCALE}",
    shares_work_with=("packing_3d",),
    takes_long=True,
    words=partial(_uncut, *_LOSS),
)
