"""Peak forces on a vertical section of several packings side by side, on one colour scale, and the
difference of corresponding grains.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection
from matplotlib.colors import SymLogNorm
from matplotlib.figure import Figure as MatplotlibFigure

from granwave.analysis.figures.colouring import Colouring, colour_bar, decades_up_to
from granwave.analysis.figures.grain_discs import disc_radii, draw_discs, sticks_of
from granwave.analysis.figures.sections import cut_of, frame_axes, window_around
from granwave.analysis.figures.series import column_name
from granwave.analysis.figures.style import (
    BOTH_SIDES_MAP,
    FORCE_MAP,
    WIDTH,
    Drawing,
    new_figure,
    trim_height,
)
from granwave.analysis.figures.user_axes import SCALED_TEXT
from granwave.analysis.measures.dynamic_force import dynamic_peak_forces, has_static_forces
from granwave.analysis.measures.geometry import SpheresOnPlane
from granwave.analysis.measures.signals import Array
from granwave.analysis.reports.comparison.subjects import ComparedRun, LackingError
from granwave.lammps_inputs.lattices import INCLINED

Window = tuple[float, float, float, float]  # left, right, top, bottom; mm

_PLANES = ("principal", "orthogonal")  # the first that a packing has; spheres of it touch
_SAME_PLANE = 0.05  # distance of centres in one plane, diameters
_CUT = 0.5  # tolerance from which a section has all spheres that its plane cuts, diameters
_ACROSS = 3  # most panels in a row ...
_UNLIKE_SIZES = 2.0  # largest over smallest section from which on each has its own scale
_IN_PAIRS = 2  # ... and panels in a row of four
MOST_PANELS = 6
_MILLI = 1e3
_TOP = "N"  # anchor of panels, whose sections begin at one height in a row
_FONT = 8  # font size of the labels of the axes, points
_TALLEST = 8.0  # inches
_ROOM_OF_TITLE = 0.35  # height of title and numbers of a panel, inches
_ROOM_OF_BAR = 0.95  # height of the colour bar and of the common titles, inches
_SAME_PLACE = 1e-3  # distance between corresponding grains, diameters
_LINEAR = 1e-2  # fraction of the largest difference within which its scale is linear
_LINEAR_PART = 0.4  # length of the linear part of that scale on each side, decades
_DECADE = (
    10.0  # upper part of the usual scale of the smallest forces that a common scale leaves out
)
_TICKS = 2  # powers of ten on each side of zero
_NEAR_END = 0.25  # largest power of ten that has room next to the end of the scale / end
_MOST_PLAIN = 3  # largest power of ten, and its inverse, that is a plain number
_MINUS = "\N{MINUS SIGN}"
_DISC = 0.96  # ratio of drawn to actual diameter
_NO_EDGE = 0.2  # width of edges, points
_MARKED = 0.1  # fraction of the linear part from which on a lower force is marked
_MARK = 0.3  # diameter of the dot in a grain whose force is lower, grain diameters
_DARK = 0.5  # brightness of a disc below which its dot is white
_BRIGHTNESS = np.array([0.299, 0.587, 0.114])  # weights of red, green and blue
_MARKS_ON_BAR = 5  # dots on the lower half of the colour bar


@dataclass(frozen=True, eq=False)
class ForceField:
    """Peak forces of the grains on a section.

    Attributes
    ----------
    cut
        Grains on the plane.
    force
        Largest contact force of each, above the static force of the contact, N: (n,).
    ids
        Their ids: (n,).
    radius
        Of their discs, m: (n,).
    sticks
        Half axes of cylinders, as of `granwave.analysis.figures.grain_discs.sticks_of`.
    diameter
        Nominal, m.
    has_static
        True if contacts carried a static force, which is subtracted.
    """

    cut: SpheresOnPlane
    force: Array
    ids: Array
    radius: Array
    sticks: Array | None
    diameter: float
    has_static: bool = False

    @property
    def plane(self) -> str:
        """Plane of the section in words."""
        plane = self.cut.plane
        is_flat = bool(np.all(np.abs(self.cut.height) <= _SAME_PLANE * self.diameter))
        if plane.down_label == INCLINED:
            return "inclined lattice plane of touching spheres"
        if is_flat:
            return "vertical lattice plane of touching spheres"
        if plane.tolerance < _CUT:
            return "zigzag rows of touching spheres, projected onto a vertical plane"
        return "spheres at a vertical plane, projected"

    def window(self, least: float) -> Window:
        """Return the part of the plane where forces are not below ``least``, N."""
        return window_around(self.cut, self.force >= least, self.diameter)


def force_field(run: ComparedRun) -> ForceField:
    """Return the peak forces of a run on its vertical section."""
    with run.opened() as result:
        cut = next(filter(None, (cut_of(result, name) for name in _PLANES)), None)
        if cut is None:
            raise LackingError("it has no vertical section of several rows")
        force = dynamic_peak_forces(result)[cut.index]
        ids = result["spheres/id"][cut.index]
        radius = disc_radii(result, cut)
        sticks = sticks_of(result, cut)
        diameter = result.case.packing.diameter
        has_static = has_static_forces(result)
    if not force.any():
        raise LackingError("no contact carried a force")
    return ForceField(cut, force, ids, radius, sticks, diameter, has_static)


def draw_fields(fields: Mapping[ComparedRun, ForceField]) -> Drawing:
    """Draw the sections of several runs side by side, on one scale of colours, and on one scale of
    lengths unless a section is much smaller than another.
    """
    runs = list(fields)[:MOST_PANELS]
    largest = max(float(fields[run].force.max()) for run in runs)
    least = min(float(fields[run].force.max()) for run in runs)
    low, high = decades_up_to(largest, None)
    low = min(low, decades_up_to(least, None)[0] * _DECADE)
    windows = [fields[run].window(low) for run in runs]
    is_shared = not _differ_in_size([fields[run].window(0.0) for run in runs])
    if is_shared:
        windows = [_joint(windows)] * len(runs)
    depth_labels = [f"{fields[run].cut.plane.down_label} (mm)" for run in runs]
    figure, panels = _panels(windows, depth_labels, shared=is_shared)
    columns: dict[str, Array] = {}
    is_dynamic = any(fields[run].has_static for run in runs)
    title = "Peak dynamic force (N)" if is_dynamic else "Peak force (N)"
    for axes, run, window in zip(panels, runs, windows, strict=True):
        field = fields[run]
        colouring = Colouring(field.force, title, "peak_force_N", FORCE_MAP, low, high)
        draw_discs(axes, field.cut, field.force, colouring, field.radius, sticks=field.sticks)
        frame_axes(axes, window)
        axes.set_anchor(_TOP)
        axes.set_title(run.label, pad=2, fontsize=7).set_label(SCALED_TEXT)
        columns |= _columns(run, field, "peak_force_N", field.force)
    forces = np.concatenate([fields[run].force for run in runs])
    colour_bar(figure, panels, colouring, forces, location="top")
    trim_height(figure, panels)
    return Drawing(figure, columns)


def plane_notes(fields: Mapping[ComparedRun, ForceField]) -> str:
    """Return a sentence on the planes of the sections, with their runs where they differ."""
    names: dict[str, list[str]] = {}
    for run, field in fields.items():
        names.setdefault(field.plane, []).append(run.name)
    if len(names) == 1:
        return f"Section: {next(iter(names))}."
    parts = [f"{plane} ({', '.join(runs)})" for plane, runs in names.items()]
    return f"Sections: {'; '.join(parts)}."


def scale_notes(fields: Mapping[ComparedRun, ForceField]) -> str:
    """Return a sentence if the sections are not on one scale of lengths."""
    windows = [field.window(0.0) for field in fields.values()]
    if not _differ_in_size(windows):
        return ""
    return "Each section is cropped to its packing, and has its own scale of lengths."


def _differ_in_size(windows: Sequence[Window]) -> bool:
    """Return True if the sizes of the sections differ too much for one scale."""
    sizes = [max(right - left, bottom - top) for left, right, top, bottom in windows]
    return max(sizes) > _UNLIKE_SIZES * min(sizes)


def corresponding(first: ForceField, other: ForceField) -> bool:
    """Return True if two sections have the same grains at the same positions."""
    if not np.array_equal(first.ids, other.ids):
        return False
    apart = np.hypot(first.cut.across - other.cut.across, first.cut.down - other.cut.down)
    return bool(np.all(apart <= _SAME_PLACE * first.diameter))


def draw_difference(fields: Mapping[ComparedRun, ForceField]) -> Drawing | None:
    """Draw the peak force of each run minus the peak force of the first, for runs with the same
    grains.

    None if no run corresponds to the first, or if none differs from it.
    """
    reference, *others = list(fields)[:MOST_PANELS]
    first = fields[reference]
    changes = {
        run: fields[run].force - first.force for run in others if corresponding(first, fields[run])
    }
    largest = max((float(np.abs(change).max()) for change in changes.values()), default=0.0)
    if not largest:
        return None
    norm = SymLogNorm(_LINEAR * largest, linscale=_LINEAR_PART, vmin=-largest, vmax=largest)
    window = first.window(decades_up_to(float(first.force.max()), None)[0])
    depth_label = f"{first.cut.plane.down_label} (mm)"
    figure, panels = _panels([window] * len(changes), [depth_label] * len(changes))
    columns: dict[str, Array] = {}
    for axes, (run, change) in zip(panels, changes.items(), strict=True):
        _draw_changes(axes, first, change, norm)
        frame_axes(axes, window)
        axes.set_title(run.label, pad=2, fontsize=7).set_label(SCALED_TEXT)
        columns |= _columns(run, first, "peak_force_difference_N", change)
    mappable = ScalarMappable(norm, colormaps[BOTH_SIDES_MAP])
    bar = figure.colorbar(mappable, ax=panels, location="top", aspect=28, shrink=0.9)
    is_dynamic = first.has_static or any(fields[run].has_static for run in changes)
    force = "Peak dynamic force" if is_dynamic else "Peak force"
    bar.set_label(f"{force} minus {reference.name} (N); dots: lower")
    ticks = _ticks(largest)
    bar.set_ticks(ticks, labels=[_tick_label(tick, largest) for tick in ticks])
    bar.minorticks_off()
    _mark_lower_half(bar.ax, norm)
    trim_height(figure, panels)
    return Drawing(figure, columns)


def _ticks(largest: float) -> list[float]:
    """Return the ends of a scale up to ``largest`` on both sides of zero, and the powers of ten
    between them that are not close to an end.
    """
    power = math.floor(math.log10(largest))
    powers = [10.0 ** (power - n) for n in range(_TICKS)]
    positive = [largest]
    positive += [tick for tick in powers if _LINEAR * largest < tick < _NEAR_END * largest]
    return [*(-tick for tick in positive), 0.0, *reversed(positive)]


def _tick_label(tick: float, largest: float) -> str:
    """Return the label of a tick: a number with two digits at the ends, else a power of ten."""
    if abs(tick) == largest:
        return f"{float(f'{tick:.2g}'):g}".replace("-", _MINUS)
    if not tick:
        return "0"
    power = round(math.log10(abs(tick)))
    sign = _MINUS if tick < 0 else ""
    return f"{sign}$10^{{{power}}}$" if abs(power) > _MOST_PLAIN else f"{sign}{abs(tick):g}"


def difference_notes(fields: Mapping[ComparedRun, ForceField]) -> str:
    """Return a sentence on the runs whose grains do not correspond to the grains of the first
    run.
    """
    reference, *others = list(fields)
    unlike = [run.name for run in others if not corresponding(fields[reference], fields[run])]
    if not unlike:
        return ""
    return f"Without {', '.join(unlike)}: the grains differ from those of {reference.name}."


def _draw_changes(axes: Axes, field: ForceField, change: Array, norm: SymLogNorm) -> None:
    """Draw differences as discs, in mm."""
    size = _DISC * 2 * field.radius * _MILLI
    centres = np.stack([field.cut.across, field.cut.down], axis=1) * _MILLI
    colours = colormaps[BOTH_SIDES_MAP](norm(change))
    discs = EllipseCollection(
        size,
        size,
        np.zeros(len(size)),
        units="xy",
        offsets=centres,
        offset_transform=axes.transData,
        facecolors=colours,
        edgecolors="#c4c4c4",
        linewidths=_NO_EDGE,
    )
    axes.add_collection(discs)
    lower = change < -_MARKED * norm.linthresh
    dots = EllipseCollection(
        _MARK * size[lower],
        _MARK * size[lower],
        np.zeros(np.count_nonzero(lower)),
        units="xy",
        offsets=centres[lower],
        offset_transform=axes.transData,
        facecolors=_colours_of_marks(colours[lower]),
        linewidths=0,
    )
    axes.add_collection(dots)


def _colours_of_marks(colours: Array) -> list[str]:
    """Return black for marks on bright colours (n, 4), white for marks on dark ones."""
    brightness = colours[:, :3] @ _BRIGHTNESS
    return ["white" if dark else "black" for dark in brightness < _DARK]


def _mark_lower_half(axes: Axes, norm: SymLogNorm) -> None:
    """Draw the dots of lower forces on the colour bar, so that grey prints show the sign."""
    zero = float(norm(-_MARKED * norm.linthresh))
    places = (np.arange(_MARKS_ON_BAR) + 0.5) / _MARKS_ON_BAR * zero
    colours = _colours_of_marks(colormaps[BOTH_SIDES_MAP](places))
    axes.scatter(
        places, np.full(_MARKS_ON_BAR, 0.5), s=4, c=colours, lw=0, transform=axes.transAxes
    )


def _panels(
    windows: Sequence[Window], depth_labels: Sequence[str], *, shared: bool = True
) -> tuple[MatplotlibFigure, list[Axes]]:
    """Return a figure with a panel for each section, with common axes if they are shared; rows of
    panels are as high as their highest section. Depths, and depths along inclined planes, are no
    common axis: each panel has its label.
    """
    is_one_depth = len(set(depth_labels)) == 1
    number = len(windows)
    across = _IN_PAIRS if number == _IN_PAIRS**2 else min(number, _ACROSS)
    width = WIDTH if number == 1 else 2 * WIDTH
    panel_width = (width - 0.6 - 0.2 * across) / across
    ratios = [(bottom - top) / (right - left) for left, right, top, bottom in windows]
    heights = [
        panel_width * max(ratios[start : start + across]) + _ROOM_OF_TITLE
        for start in range(0, number, across)
    ]
    figure = new_figure(min(sum(heights) + _ROOM_OF_BAR, _TALLEST), width)
    grid = figure.subplots(
        len(heights),
        across,
        sharex=shared,
        sharey=shared and is_one_depth,
        squeeze=False,
        gridspec_kw={"height_ratios": heights},
    )
    for empty in grid.flat[number:]:
        empty.set_visible(False)
    panels = list(grid.flat[:number])
    across_title = figure.supxlabel("Distance from the impact axis (mm)", fontsize=_FONT)
    across_title.set_label(SCALED_TEXT)
    if is_one_depth:
        figure.supylabel(depth_labels[0], fontsize=_FONT).set_label(SCALED_TEXT)
    else:
        for axes, depth_label in zip(panels, depth_labels, strict=True):
            axes.set_ylabel(depth_label)
    return figure, panels


def _joint(windows: Sequence[Window]) -> Window:
    """Return the smallest window that contains several windows."""
    left, right, top, bottom = zip(*windows, strict=True)
    return min(left), max(right), min(top), max(bottom)


def _columns(run: ComparedRun, field: ForceField, name: str, values: Array) -> dict[str, Array]:
    start = column_name(run.label)
    return {
        f"{start}_id": field.ids,
        f"{start}_across_m": field.cut.across,
        f"{start}_down_m": field.cut.down,
        f"{start}_{name}": values,
    }
