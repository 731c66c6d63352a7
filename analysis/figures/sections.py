"""Sections through the packing: spheres drawn as discs, coloured by a quantity.

Peak forces, dissipation, and the wave at chosen times. Spheres with a
contact loaded beyond the range of the law have a ring around them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import Collection, EllipseCollection, PolyCollection
from matplotlib.colors import LogNorm, to_rgba
from matplotlib.figure import Figure
from numpy.typing import NDArray

from granwave.analysis.figures.impact_arrow import draw_arrow, impact_arrow
from granwave.analysis.figures.style import (
    BLANK,
    DENT_MAP,
    DISSIPATION_MAP,
    FORCE_MAP,
    WIDTH,
    Drawing,
    new_figure,
)
from granwave.analysis.formatting.numbers import instant
from granwave.analysis.measures.geometry import Plane, SpheresOnPlane, own_plane, planes, section
from granwave.analysis.measures.waves import passage
from granwave.analysis.measures.zone_size import LAW_LIMIT
from granwave.analysis.result.reader import Result

DISSIPATION_LIMITS = (1e-6, 1e-1)  # of dissipation over input
_MILLI = 1e3  # mm in a metre
_SNAPSHOTS = 4
_EDGE_OF_BLANK = "#c4c4c4"
_TALL = 2.5  # height / width of a packing above which all snapshots are in a row ...
_BROAD = 0.6  # ... and below which they are one below the other
_LEAST_DECADES = 3  # default range of a logarithmic scale
_RING = 1.0  # width of the ring around a sphere beyond the range of the law, points
_AROUND_ARROW = 0.3  # distance of the load's arrow from the edge of a section, diameters
_OUTLINE = "#9a9a9a"  # colour of the outlines of grains
_OUTLINE_WIDTH = 0.35  # points
_BEHIND = 0.75  # largest distance of the plane behind a section, diameters
_SAME_PLANE = 0.05  # distance of centres in one plane, diameters
_PALE = 0.55  # strength of the colours of spheres behind a section
_DISC = 0.96  # drawn / actual diameter
_SEEN_ALONG = 0.1  # length of an axis in a section / radius below which a cylinder is seen end-on


@dataclass(frozen=True, eq=False)
class Colouring:
    """Quantity with its colour scale.

    Attributes
    ----------
    values
        Values by sphere: (n_spheres,).
    label
        Label of the colour bar.
    column
        Name of the column in the CSV file.
    map
        Name of the colour map.
    low, high
        Ends of the logarithmic scale.
    title
        Title of the panel, if there are several.
    """

    values: NDArray[np.float64]
    label: str
    column: str
    map: str
    low: float
    high: float
    title: str = ""

    @property
    def norm(self) -> LogNorm:
        """Logarithmic colour scale."""
        return LogNorm(self.low, self.high)


def force_scale(result: Result) -> tuple[float, str, str]:
    """Return the unit of forces in figures, N, the label of the ratio, and its name in CSV files.

    The unit is F_y if contacts can yield, else the largest peak force of the run.
    """
    if result.has_yield_force:
        return result.law.yield_force, r"$F/F_\mathrm{y}$", "force_over_yield_force"
    largest = float(np.max(result["contacts/peak_force"], initial=0.0)) or 1.0
    return largest, r"$F/F_\mathrm{max}$", "force_over_largest_force"


def peak_force_colouring(result: Result, decades: float | None = None) -> Colouring:
    """Return the colouring by the largest contact force of each sphere.

    Parameters
    ----------
    decades
        Range of the scale; by default from F_y upwards.
    """
    scale, label, column = force_scale(result)
    values = result["spheres/peak_force"] / scale
    options = result.figure_options
    low, high = decades_up_to(
        float(values.max(initial=0.0)), 1.0 if result.has_yield_force else None
    )
    if decades is not None:
        low = high / 10**decades
    low, high = options.force_limits or (low, high)
    return Colouring(
        values, f"Peak force {label}", f"peak_{column}", options.colour_map or FORCE_MAP, low, high
    )


def dissipation_colouring(result: Result, part: str = "") -> Colouring:
    """Return the colouring by dissipation / energy input.

    ``part``: only the dissipation by ``yielding``, ``friction`` or ``viscous`` losses.
    """
    values = result["spheres/dissipated_energy"]
    if part:
        values = result.yield_energy if part == "yielding" else result[f"spheres/{part}_energy"]
    column = f"{part}_over_input" if part else "dissipated_over_input"
    label = r"Dissipation $e_\mathrm{dis}/e_\mathrm{in}$"
    options = result.figure_options
    low, high = options.dissipation_limits or DISSIPATION_LIMITS
    colours = options.colour_map or DISSIPATION_MAP
    title = "Viscous damping" if part == "viscous" else part.capitalize()
    return Colouring(values / result.energy_input, label, column, colours, low, high, title)


def peak_force_section(result: Result, name: str) -> Drawing | None:
    """Draw peak forces on the principal or orthogonal plane."""
    if not np.any(result["spheres/peak_force"] > 0):
        return None
    return section_drawing(result, name, peak_force_colouring(result))


def dissipation_section(result: Result, name: str) -> Drawing | None:
    """Draw dissipation on the principal or orthogonal plane."""
    if not np.any(result["spheres/dissipated_energy"] > 0):
        return None
    return section_drawing(result, name, dissipation_colouring(result))


def dissipation_parts_section(result: Result, name: str) -> Drawing | None:
    """Draw dissipation by yielding, friction and viscous losses separately, as far as there are
    several of them.
    """
    parts = ["yielding"] if result.yields or result.yield_energy.any() else []
    parts += [part for part in ("friction", "viscous") if result.has(f"spheres/{part}_energy")]
    if len(parts) < 2:
        return None
    return section_drawing(result, name, *(dissipation_colouring(result, part) for part in parts))


def dents_section(result: Result, name: str) -> Drawing | None:
    """Draw the largest initial dent of each sphere on the principal or orthogonal plane."""
    if not result.has("contacts/initial_overlap"):
        return None
    unit = 1e-6
    label = "Initial indentation (µm)"
    column = "initial_overlap_um"
    if result.has_yield_force:
        unit = result.law.yield_overlap
        column = "initial_over_alpha_y"
        label = r"Initial indentation $\alpha/\alpha_\mathrm{y}$"
    values = np.zeros(result.n_spheres)
    np.maximum.at(values, result.ends, (result["contacts/initial_overlap"] / unit)[:, None])
    low, high = decades_up_to(float(values.max()), 1.0 if result.has_yield_force else None)
    colours = result.figure_options.colour_map or DENT_MAP
    return section_drawing(result, name, Colouring(values, label, column, colours, low, high))


def wave_front(result: Result) -> Drawing | None:
    """Draw the forces on the spheres of the principal plane, in which spheres touch, at four times
    while the wave travels down.
    """
    cut = cut_of(result, "principal") or cut_of(result, "orthogonal")
    chosen = _snapshots(result)
    if cut is None or not chosen:
        return None
    scale, label, column = force_scale(result)
    radius = result["spheres/radius"][cut.index]
    forces = [result.frame(number, "contact_force")[cut.index] / scale for number in chosen]
    times = [float(result.frame_times[number]) for number in chosen]
    largest = max(float(force.max()) for force in forces)
    if largest == 0:
        return None
    low, high = result.figure_options.force_limits or decades_up_to(largest, None)
    colours = result.figure_options.colour_map or FORCE_MAP
    reached = np.max(forces, axis=0) >= low
    window = window_around(cut, reached, result.case.packing.diameter)
    left, right, top, bottom = window
    aspect = (bottom - top) / (right - left)
    n_columns = 2 if aspect > _BROAD else 1
    if aspect > _TALL:
        n_columns = len(chosen)
    n_rows = math.ceil(len(chosen) / n_columns)
    panel = (WIDTH - 0.6 - 0.15 * n_columns) / n_columns * aspect + 0.3
    figure = new_figure(min(n_rows * panel + 0.95, 8.5))
    axes = figure.subplots(n_rows, n_columns, sharex=True, sharey=True, squeeze=False)
    for panel_axes, force, time in zip(axes.flat, forces, times, strict=False):
        colouring = Colouring(force, f"Contact force {label}", column, colours, low, high)
        draw_discs(panel_axes, cut, force, colouring, radius, sticks=sticks_of(result, cut))
        frame_axes(panel_axes, window)
        panel_axes.set_title(instant(time), pad=2)
    for empty in axes.flat[len(chosen) :]:
        empty.set_visible(False)
    figure.supxlabel(across_title(cut.plane), fontsize=8)
    figure.supylabel(f"{cut.plane.down_label} (mm)", fontsize=8)
    colour_bar(figure, list(axes.flat), colouring, np.concatenate(forces), location="top")
    repeat = len(chosen)
    columns = {
        "time_s": np.repeat(times, len(cut.index)),
        "id": np.tile(result["spheres/id"][cut.index], repeat),
        "across_m": np.tile(cut.across, repeat),
        "down_m": np.tile(cut.down, repeat),
        column: np.concatenate(forces),
    }
    return Drawing(figure, columns)


def section_drawing(result: Result, name: str, *colourings: Colouring) -> Drawing | None:
    """Draw a plane through the packing, with a panel for each colouring, one above the other on a
    common scale.

    Return None if there is no such plane.

    Parameters
    ----------
    name
        Name of the plane: principal, orthogonal, or section, the one of the case.
    colourings
        Quantities, with titles if there are several.
    """
    cut = cut_of(result, name)
    if cut is None:
        return None
    diameter = result.case.packing.diameter
    values = [colouring.values[cut.index] for colouring in colourings]
    beyond = spheres_beyond_law(result)[cut.index]
    window = window_around(cut, np.max(values, axis=0) >= colourings[0].low, diameter)
    aspect = (window[3] - window[2]) / (window[1] - window[0])
    height = (WIDTH - 0.6) * aspect + (0.25 if len(colourings) > 1 else 0.0)
    figure = new_figure(
        min(max(len(colourings) * height + 1.05, 1.9), 6.0 if len(colourings) == 1 else 8.0)
    )
    panels = figure.subplots(len(colourings), 1, sharex=True, squeeze=False)[:, 0]
    behind = _next_plane(result, cut)
    for axes, colouring, shown in zip(panels, colourings, values, strict=True):
        if behind is not None:
            _draw_behind(axes, result, behind, colouring)
        draw_discs(
            axes, cut, shown, colouring, disc_radii(result, cut), beyond, sticks_of(result, cut)
        )
        frame_axes(axes, window)
        axes.set_title(colouring.title, pad=2)
        if beyond.any():
            note = {"transform": axes.transAxes, "ha": "right", "va": "top", "fontsize": 6}
            axes.text(0.98, 0.985, f"black ring: overlap beyond {LAW_LIMIT:g} R*", **note)
        if cut.plane.through is None:
            draw_impact(axes, result, cut, window)
    if len(panels) > 1:
        figure.supylabel(f"{cut.plane.down_label} (mm)", fontsize=8)
    else:
        panels[0].set_ylabel(f"{cut.plane.down_label} (mm)")
    panels[-1].set_xlabel(across_title(cut.plane))
    colour_bar(figure, list(panels), colourings[0], np.concatenate(values))
    columns = {"id": result["spheres/id"][cut.index], "across_m": cut.across, "down_m": cut.down}
    columns |= {
        colouring.column: shown for colouring, shown in zip(colourings, values, strict=True)
    }
    return Drawing(figure, columns | {"beyond_law": beyond.astype(int)})


def _next_plane(result: Result, cut: SpheresOnPlane) -> SpheresOnPlane | None:
    """Return the spheres of the lattice plane behind the orthogonal one, which fill the gaps
    between its spheres; None for other planes, or without such a plane.
    """
    if cut.plane.name != "orthogonal" or not result.case.packing.rule.is_lattice:
        return None
    diameter = result.case.packing.diameter
    deeper = replace(cut.plane, tolerance=_BEHIND)
    slab = section(deeper, result["spheres/position"], result.origin, diameter)
    outside = slab.height > (cut.plane.tolerance + _SAME_PLANE) * diameter
    if not outside.any():
        return None
    first = float(slab.height[outside].min())
    rows = np.flatnonzero(outside & (slab.height < first + _SAME_PLANE * diameter))
    return SpheresOnPlane(
        cut.plane, slab.index[rows], slab.across[rows], slab.down[rows], slab.height[rows]
    )


def _draw_behind(axes: Axes, result: Result, behind: SpheresOnPlane, colouring: Colouring) -> None:
    """Draw the discs of spheres behind a section, paler than those on it."""
    values = colouring.values[behind.index]
    discs = draw_discs(axes, behind, values, colouring, result["spheres/radius"][behind.index])
    faces = np.array(discs.get_facecolor(), dtype=np.float64)
    faces[:, :3] = 1 - _PALE * (1 - faces[:, :3])
    discs.set(facecolor=faces, edgecolor=_OUTLINE, zorder=0.9)


def across_title(plane: Plane) -> str:
    """Return the title of the horizontal axis of a section, x for a layer in x and y."""
    quantity = "x" if plane.down_label == "y" else plane.across_label
    return f"{quantity} (mm)"


def draw_impact(
    axes: Axes, result: Result, cut: SpheresOnPlane, window: tuple[float, float, float, float]
) -> None:
    """Draw the arrow of the load in a section, and widen its window to show the whole of it."""
    arrow = impact_arrow(result)
    plane = np.stack([cut.plane.across, cut.plane.down])
    place = plane @ (arrow.place - result.origin) * _MILLI
    diameter = result.case.packing.diameter * _MILLI
    tail = draw_arrow(axes, place, plane @ arrow.direction, diameter)
    left, right, top, bottom = window
    margin = _AROUND_ARROW * diameter
    axes.set_xlim(min(left, tail[0] - margin), max(right, tail[0] + margin))
    axes.set_ylim(max(bottom, tail[1] + margin), min(top, tail[1] - margin))


def cut_of(result: Result, name: str) -> SpheresOnPlane | None:
    """Return the spheres on a plane; None without the plane, or with a single line of spheres on
    it.
    """
    diameter = result.case.packing.diameter
    candidates = list(planes(result.case.packing.kind))
    own = result.figure_options.plane
    if own is not None:
        largest = float(result["spheres/radius"].max(initial=0.0))
        candidates.append(own_plane(own.normal, own.through, largest / diameter))
    plane = next((candidate for candidate in candidates if candidate.name == name), None)
    if plane is None:
        return None
    plane = _from_struck_sphere(plane, result)
    cut = section(plane, result["spheres/position"], result.origin, diameter)
    if not len(cut.index):
        return None
    is_wide = np.ptp(cut.across) > diameter and np.ptp(cut.down) > diameter / 2
    return cut if is_wide else None


def _from_struck_sphere(plane: Plane, result: Result) -> Plane:
    """Return the plane with a label for the origin of distances: the impacted sphere,
    where the impact axis goes between several.
    """
    if np.array_equal(result.impact_axis, result.origin[:2]):
        return plane
    across_label = plane.across_label.replace("impact axis", "impacted sphere")
    return replace(plane, across_label=across_label)


def disc_radii(result: Result, cut: SpheresOnPlane) -> NDArray[np.float64]:
    """Return the radii of the discs of a section: radii of the spheres on a plane of the lattice,
    else of the cuts.

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
    """Return half the axis of each cylinder as seen in a section, 0 for spheres and cylinders seen
    along it: (n, 2), m.

    None if there are only spheres.
    """
    if (axes := half_axes(result, cut.index)) is None:
        return None
    half = axes @ np.stack([cut.plane.across, cut.plane.down], axis=1)
    length = np.linalg.norm(half, axis=1, keepdims=True)
    return np.where(length > _SEEN_ALONG * result["spheres/radius"][cut.index][:, None], half, 0.0)


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
        edges[ringed] = to_rgba("black")  # on the bright end of the scale, where such spheres are
    widths = np.where(ringed, _RING, 0.2) if ringed is not None else np.full(len(radius), 0.2)
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
    edges = np.tile(to_rgba(_OUTLINE), (number, 1))
    return _add_grains(axes, cut, radius, sticks, faces, edges, np.full(number, _OUTLINE_WIDTH))


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


def disc_colours(
    values: NDArray[np.float64], colouring: Colouring
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the colours of discs with values (n,), and the colours of their edges: (n, 4) each."""
    mapped = colormaps[colouring.map]
    colours = mapped(colouring.norm(np.maximum(values, colouring.low)))
    coloured = (values > 0)[:, None]
    return (
        np.where(coloured, colours, to_rgba(BLANK)),
        np.where(coloured, colours, to_rgba(_EDGE_OF_BLANK)),
    )


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


def frame_axes(axes: Axes, window: tuple[float, float, float, float]) -> None:
    """Set the limits of axes (left, right, top, bottom; mm), with depth downwards."""
    left, right, top, bottom = window
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    axes.set_aspect("equal")


def colour_bar(
    figure: Figure,
    axes: list[Axes],
    colouring: Colouring,
    values: NDArray[np.float64],
    location: str = "bottom",
) -> None:
    """Draw a colour bar next to, above or below the panels, with pointed ends if values exceed the
    scale.
    """
    below = bool(np.any((values > 0) & (values < colouring.low)))
    above = bool(np.any(values > colouring.high))
    extend = {(True, True): "both", (True, False): "min", (False, True): "max"}.get(
        (below, above), "neither"
    )
    mappable = ScalarMappable(colouring.norm, colormaps[colouring.map])
    place: dict[str, Any] = {
        "ax": axes,
        "location": location,
        "fraction": 0.08 if location in ("top", "bottom") else 0.05,
    }
    figure.colorbar(
        mappable, label=colouring.label, extend=extend, aspect=28, pad=0.03, shrink=0.9, **place
    )


def window_around(
    cut: SpheresOnPlane, shown: NDArray[np.bool_], diameter: float
) -> tuple[float, float, float, float]:
    """Return left, right, top and bottom around the spheres to show, mm."""
    margin = 2 * diameter
    if not shown.any():
        shown = np.ones(len(shown), dtype=bool)
    half = max(float(np.abs(cut.across[shown]).max()), 4 * diameter) + margin
    left = float(cut.across.min()) - diameter
    right = float(cut.across.max()) + diameter
    if left < -half - margin:  # else a narrow rest would be cut off
        left = -half
    if right > half + margin:
        right = half
    top = min(float(cut.down[shown].min()), 0.0) - 1.6 * diameter
    bottom = min(
        max(float(cut.down[shown].max()), 3 * diameter) + margin, float(cut.down.max()) + diameter
    )
    return left * _MILLI, right * _MILLI, top * _MILLI, bottom * _MILLI


def decades_up_to(largest: float, low: float | None) -> tuple[float, float]:
    """Return the ends of a logarithmic scale up to the largest value, at least one decade, by
    default three.
    """
    high = 10 ** (math.ceil(2 * math.log10(largest)) / 2) if largest > 0 else 1.0
    if low is None or high < 10 * low:
        low = high / 10**_LEAST_DECADES
    return low, high


def _snapshots(result: Result) -> list[int]:
    """Select up to four snapshots, evenly spread in time until the wave has passed the packing."""
    times = result.frame_times
    moving = np.flatnonzero(times > 0)
    if not moving.size:
        return []
    even_times = passage(result) * np.arange(1, _SNAPSHOTS + 1) / _SNAPSHOTS
    nearest = np.abs(times[moving] - even_times[:, None]).argmin(axis=1)
    return moving[np.unique(nearest)].tolist()


def spheres_beyond_law(result: Result) -> NDArray[np.bool_]:
    """Return True for spheres with a contact loaded beyond the range of the law: (n_spheres,)."""
    beyond = np.zeros(result.n_spheres, dtype=bool)
    beyond[result.ends[result.beyond_law(LAW_LIMIT)]] = True
    return beyond
