"""Sections through the packing: spheres drawn as discs, coloured by a quantity.

Peak forces, dissipation, and the wave at chosen times. Spheres with a
contact loaded beyond the range of the law have a ring around them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from granwave.analysis.figures.colouring import (
    Colouring,
    colour_bar,
    decades_up_to,
    dissipation_colouring,
    force_scale,
    peak_force_colouring,
)
from granwave.analysis.figures.grain_discs import (
    OUTLINE,
    disc_radii,
    draw_discs,
    sticks_of,
)
from granwave.analysis.figures.impact_arrow import draw_arrow, impact_arrow
from granwave.analysis.figures.style import (
    DENT_MAP,
    FORCE_MAP,
    WIDTH,
    Drawing,
    new_figure,
    trim_height,
)
from granwave.analysis.figures.user_axes import SCALED_TEXT
from granwave.analysis.formatting.numbers import instant
from granwave.analysis.measures.geometry import Plane, SpheresOnPlane, own_plane, planes, section
from granwave.analysis.measures.waves import front_arrivals, passage
from granwave.analysis.measures.zone_size import LAW_LIMIT
from granwave.analysis.result.reader import Result

_MILLI = 1e3  # mm in a metre
_SNAPSHOTS = 4
_TALL = 2.5  # height / width of a packing above which all snapshots are in a row ...
_BROAD = 0.35  # ... and below which they are in a column
_AROUND_ARROW = 0.3  # distance of the load's arrow from the edge of a section, diameters
_BEHIND = 0.75  # largest distance of the plane behind a section, diameters
_SAME_PLANE = 0.05  # distance of centres in one plane, diameters
_PALE = 0.55  # opacity of the colours of spheres behind a section


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
    """Draw dissipation by yielding, friction and viscous losses separately, if there are several of
    them.
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
    while the wave travels down. Spheres that the front has not reached are white, see
    `reached_by_front`.
    """
    cut = cut_of(result, "principal") or cut_of(result, "orthogonal")
    chosen = _snapshots(result)
    if cut is None or not chosen:
        return None
    scale, label, column = force_scale(result)
    radius = result["spheres/radius"][cut.index]
    times = [float(result.frame_times[number]) for number in chosen]
    is_reached = reached_by_front(result, times)
    forces = [
        np.where(behind, result.frame(number, "contact_force"), 0.0)[cut.index] / scale
        for number, behind in zip(chosen, is_reached, strict=True)
    ]
    largest = max(float(force.max()) for force in forces)
    if largest == 0:
        return None
    low, high = result.figure_options.force_limits or decades_up_to(largest, None)
    colours = result.figure_options.colour_map or FORCE_MAP
    reached = np.max(forces, axis=0) >= low
    window = window_around(cut, reached, result.case.packing.diameter)
    figure, panels, empty_panels = _panels_of_snapshots(len(chosen), _aspect(window))
    for axes, force, time in zip(panels, forces, times, strict=True):
        colouring = Colouring(force, f"Contact force {label}", column, colours, low, high)
        draw_discs(axes, cut, force, colouring, radius, sticks=sticks_of(result, cut))
        frame_axes(axes, window)
        axes.set_title(instant(time), pad=2)
    for axes in empty_panels:
        axes.set_visible(False)
    figure.supxlabel(across_title(cut.plane), fontsize=8).set_label(SCALED_TEXT)
    figure.supylabel(f"{cut.plane.down_label} (mm)", fontsize=8).set_label(SCALED_TEXT)
    blank = "0" if result.case.precompression else "not reached, or 0"
    values = np.concatenate(forces)
    colour_bar(figure, panels + empty_panels, colouring, values, location="top", blank=blank)
    trim_height(figure, panels + empty_panels)
    repeat = len(chosen)
    columns = {
        "time_s": np.repeat(times, len(cut.index)),
        "id": np.tile(result["spheres/id"][cut.index], repeat),
        "across_m": np.tile(cut.across, repeat),
        "down_m": np.tile(cut.down, repeat),
        column: np.concatenate(forces),
    }
    return Drawing(figure, columns)


def reached_by_front(result: Result, times: Sequence[float]) -> list[NDArray[np.bool_]]:
    """Return, for each time, s, True for the spheres that the wave front has reached: (n_spheres,).

    The front is at a sphere when the force of a contact first passes 10 % of its largest value, for
    contacts with at least 10 % of the largest force of the sphere, and not before it is at the
    layer of the sphere as in `granwave.analysis.measures.waves.front_arrivals`. Ahead of it forces
    are far smaller, but not zero. If contacts are loaded from the start, all spheres count.
    """
    if result.case.precompression is not None:
        return [np.ones(result.n_spheres, dtype=bool) for _ in times]
    depth, front = front_arrivals(result)
    own = result["spheres/position"][:, 2] - result.origin[2]
    middles = 0.5 * (depth[1:] + depth[:-1])
    arrival = np.fmax(result["spheres/time_first"], front[np.searchsorted(middles, own)])
    arrival[np.isnan(result["spheres/time_first"])] = np.inf
    return [arrival <= time for time in times]


def _aspect(window: tuple[float, float, float, float]) -> float:
    """Return the height of a window divided by its width."""
    left, right, top, bottom = window
    return (bottom - top) / (right - left)


def _panels_of_snapshots(number: int, aspect: float) -> tuple[Figure, list[Axes], list[Axes]]:
    """Return a figure with a panel for each snapshot, these panels, and those left empty.

    Parameters
    ----------
    aspect
        Height of a panel divided by its width.
    """
    n_columns = 2 if aspect > _BROAD else 1
    if aspect > _TALL:
        n_columns = number
    n_rows = math.ceil(number / n_columns)
    width = (WIDTH - 0.6 - 0.15 * n_columns) / n_columns
    height = width * aspect + 0.3
    figure = new_figure(min(n_rows * height + 0.95, 8.5))
    axes = figure.subplots(n_rows, n_columns, sharex=True, sharey=True, squeeze=False)
    panels = list(axes.flat)
    return figure, panels[:number], panels[number:]


def section_drawing(result: Result, name: str, *colourings: Colouring) -> Drawing | None:
    """Draw a plane through the packing, with a panel for each colouring, one above the other on a
    common scale.

    Return None if there is no such plane.

    Parameters
    ----------
    name
        Name of the plane: principal, orthogonal, or section (the plane of the case).
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
    figure = new_figure(_height_of_sections(len(colourings), _aspect(window)))
    panels = figure.subplots(len(colourings), 1, sharex=True, squeeze=False)[:, 0]
    behind = _next_plane(result, cut)
    radii = disc_radii(result, cut)
    sticks = sticks_of(result, cut)
    for axes, colouring, shown in zip(panels, colourings, values, strict=True):
        if behind is not None:
            _draw_behind(axes, result, behind, colouring)
        draw_discs(axes, cut, shown, colouring, radii, beyond, sticks)
        frame_axes(axes, window)
        axes.set_title(colouring.title, pad=2)
        if beyond.any():
            note = {"transform": axes.transAxes, "ha": "right", "va": "top", "fontsize": 6}
            axes.text(0.98, 0.985, f"black ring: overlap\nbeyond {LAW_LIMIT:g} R*", **note)
        if cut.plane.through is None:
            draw_impact(axes, result, cut, window)
    if len(panels) > 1:
        figure.supylabel(f"{cut.plane.down_label} (mm)", fontsize=8).set_label(SCALED_TEXT)
    else:
        panels[0].set_ylabel(f"{cut.plane.down_label} (mm)")
    panels[-1].set_xlabel(across_title(cut.plane))
    colour_bar(figure, list(panels), colourings[0], np.concatenate(values))
    columns = {"id": result["spheres/id"][cut.index], "across_m": cut.across, "down_m": cut.down}
    for colouring, shown in zip(colourings, values, strict=True):
        columns[colouring.column] = shown
    columns["beyond_law"] = beyond.astype(int)
    return Drawing(figure, columns)


def _height_of_sections(number: int, aspect: float) -> float:
    """Return the height of a figure of sections one above the other, inches.

    Parameters
    ----------
    aspect
        Height of a section divided by its width.
    """
    height = (WIDTH - 0.6) * aspect
    if number == 1:
        return min(max(height + 1.05, 1.9), 6.0)
    with_title = height + 0.25
    return min(max(number * with_title + 1.05, 1.9), 8.0)


def _next_plane(result: Result, cut: SpheresOnPlane) -> SpheresOnPlane | None:
    """Return the spheres of the lattice plane behind the orthogonal plane, which fill the gaps
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
    """Draw the discs of spheres behind a section, paler than the discs of the section."""
    values = colouring.values[behind.index]
    discs = draw_discs(axes, behind, values, colouring, result["spheres/radius"][behind.index])
    faces = np.array(discs.get_facecolor(), dtype=np.float64)
    faces[:, :3] = 1 - _PALE * (1 - faces[:, :3])
    discs.set(facecolor=faces, edgecolor=OUTLINE, zorder=0.9)


def across_title(plane: Plane) -> str:
    """Return the title of the horizontal axis of a section, x for a layer in x and y."""
    quantity = "x" if plane.down_label == "y" else plane.across_label
    return f"{quantity} (mm)"


def draw_impact(
    axes: Axes, result: Result, cut: SpheresOnPlane, window: tuple[float, float, float, float]
) -> None:
    """Draw the arrow of the load in a section, and widen its window to show the complete arrow."""
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
    """Return the spheres on a plane; None if there is no such plane, or only a single line of
    spheres on it.
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
    """Return the plane with a label for the origin of distances, which is the impacted sphere if
    the impact axis runs between several impacted spheres.
    """
    if np.array_equal(result.impact_axis, result.origin[:2]):
        return plane
    across_label = plane.across_label.replace("impact axis", "impacted sphere")
    return replace(plane, across_label=across_label)


def frame_axes(axes: Axes, window: tuple[float, float, float, float]) -> None:
    """Set the limits of axes (left, right, top, bottom; mm), with depth downwards."""
    left, right, top, bottom = window
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    axes.set_aspect("equal")


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
    if max(-left, right) > half + 2 * margin:  # a narrow remainder is not worth a cut
        left = max(left, -half)
        right = min(right, half)
    top = min(float(cut.down[shown].min()), 0.0) - 1.6 * diameter
    bottom = min(
        max(float(cut.down[shown].max()), 3 * diameter) + margin, float(cut.down.max()) + diameter
    )
    return left * _MILLI, right * _MILLI, top * _MILLI, bottom * _MILLI


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
