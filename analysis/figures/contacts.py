"""Figures of the forces of all contacts: as lines in a section, and their distribution."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.figures.grain_discs import disc_radii, outline_grains, sticks_of
from granwave.analysis.figures.sections import (
    across_title,
    cut_of,
    draw_impact,
    frame_axes,
    window_around,
)
from granwave.analysis.figures.series import label, panels, with_error
from granwave.analysis.figures.style import (
    BLUE,
    GREEN,
    ORANGE,
    WIDTH,
    Drawing,
    legend_above,
    new_figure,
)
from granwave.analysis.figures.user_axes import SCALED_TEXT, user_figure
from granwave.analysis.measures.contact_forces import (
    INSTANT,
    PEAK,
    STATIC,
    ContactForces,
    ExponentialTail,
    contact_forces,
    exponential_tail,
)
from granwave.analysis.measures.geometry import SpheresOnPlane, own_plane, section
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.message_words import counted

_MILLI = 1e3  # millimetres in a metre
_KILO = 1e-3  # kilonewtons in a newton
_MANY_NEWTON = 1e3  # forces from which on they are in kN
_POINTS = 72.0  # points in an inch
_THICKEST = 0.4  # width of the thickest line, diameters
_LEAST_THICKEST = 2.0  # smallest width of the thickest line, points
_MOST_THICKEST = 9.0  # largest width of the thickest line, points
_TALL = 2.0  # height / width of a section above which it is drawn horizontally
_LONGEST = 30.0  # length of a section that is drawn horizontally, diameters
_SHOWN = 0.05  # fraction of the largest force: the window shows the contacts that carry more
_LINE = "black"
_MOST_VECTORS = 20_000  # lines and discs above which the PDF has a raster image
_TALLEST = 8.0  # inches
_LOWEST = 0.15  # smallest height of a panel, inches
_BESIDE = 0.5  # distance from the plane of a packing without planes of its own, diameters
_ROOM = 0.6  # room for labels next to the panels, inches
_ABOVE = 0.3  # room for the title above a panel, inches
_BELOW = 0.55  # room below the panels, inches

Vectors = NDArray[np.float64]
Window = tuple[float, float, float, float]  # left, right, top, bottom, mm


def contact_network(result: Result) -> Drawing | None:
    """Draw contacts as lines as thick as their force, with a panel for each state: at rest, at an
    instant, and the largest force of each contact.

    The plane is the plane of the case, or the principal plane, or y = 0 through the impact. None
    for a chain, whose network is a single line: `along_chain` draws its forces.
    """
    if result.case.packing.rule.is_chain:
        return None
    cut = _cut(result)
    if not len(cut.index):
        return None
    kept = np.zeros(result.n_spheres, dtype=bool)
    kept[cut.index] = True
    states = contact_forces(result, kept)
    if not states:
        return None
    diameter = result.case.packing.diameter
    window = window_around(cut, _loaded(result, cut, states), diameter)
    left, right, top, bottom = window
    is_lying = bottom - top > _TALL * (right - left)
    if is_lying:
        cut = _lying(cut)
        window = (top, min(bottom, top + _LONGEST * diameter * _MILLI), left, right)
    height = _height(window)
    figure = new_figure(min(len(states) * height + _BELOW, _TALLEST))
    stack = figure.subplots(len(states), 1, sharex=True, squeeze=False)[:, 0]
    columns: dict[str, ArrayLike] = {}
    width = _width_in_points(window, diameter, len(states), height)
    for axes, state in zip(stack, states, strict=True):
        ends, rows = _lines(result, cut, state)
        outlines = outline_grains(axes, cut, disc_radii(result, cut), sticks_of(result, cut))
        lines = LineCollection(
            list(ends * _MILLI),
            linewidths=width * state.force[rows] / state.force.max(),
            colors=_LINE,
            capstyle="butt",
        )
        axes.add_collection(lines)
        for artist in (lines, *outlines):
            artist.set_rasterized(max(len(ends), len(cut.index)) > _MOST_VECTORS)
        frame_axes(axes, window)
        axes.set_title(
            f"{_capital(state.title)}: thickest line {_newton(state.force.max())}", pad=2
        )
        if cut.plane.through is None:
            draw_impact(axes, result, cut, window)
        columns |= _columns_of_network(state, ends[: len(state.force)])
    if is_lying:
        for axes in stack:
            axes.set_yticks([])  # there is little room for these labels
    else:
        figure.supylabel(f"{cut.plane.down_label} (mm)", fontsize=8).set_label(SCALED_TEXT)
    stack[-1].set_xlabel(across_title(cut.plane))
    return Drawing(figure, columns)


def _height(window: Window) -> float:
    """Return the height of a panel that is as wide as the figure, with its title, inches."""
    left, right, top, bottom = window
    return max((WIDTH - _ROOM) * (bottom - top) / (right - left), _LOWEST) + _ABOVE


def _lying(cut: SpheresOnPlane) -> SpheresOnPlane:
    """Return a section with its depth from left to right, as for a column."""
    plane = replace(
        cut.plane,
        across=cut.plane.down,
        down=cut.plane.across,
        across_label=cut.plane.down_label,
        down_label="Distance across",
    )
    return replace(cut, plane=plane, across=cut.down, down=cut.across)


def _cut(result: Result) -> SpheresOnPlane:
    """Return the spheres on the plane of the case, the principal plane, or y = 0 through the
    impact.
    """
    for name in ("section", "principal"):
        cut = cut_of(result, name)
        if cut is not None:
            return cut
    diameter = result.case.packing.diameter
    largest = float(result["spheres/radius"].max(initial=0.0))
    plane = own_plane((0.0, 1.0, 0.0), None, max(largest / diameter, _BESIDE))
    return section(plane, result["spheres/position"], result.origin, diameter)


def _loaded(result: Result, cut: SpheresOnPlane, states: list[ContactForces]) -> NDArray[np.bool_]:
    """Return True for the spheres of a section with a visible contact: (n,)."""
    loaded = np.zeros(result.n_spheres, dtype=bool)
    for state in states:
        seen = state.force >= _SHOWN * state.force.max()
        loaded[result.rows(state.i[seen])] = True
        loaded[result.rows(state.j[seen])] = True
    return loaded[cut.index]


def _lines(
    result: Result, cut: SpheresOnPlane, state: ContactForces
) -> tuple[Vectors, NDArray[np.int64]]:
    """Return the ends of the lines of contacts in a section, (n_lines, 2, 2), m, and the contact of
    each, (n_lines,).

    A line goes from the centre of one grain to the centre of the other. A contact across periodic
    sides has two lines, one from each grain to the nearest image of the other; the second lines are
    last.
    """
    position = result["spheres/position"]
    first = position[result.rows(state.i)]
    second = position[result.rows(state.j)]
    step = second - first
    step[:, :2] = result.across(step[:, :2])
    plane = np.stack([cut.plane.across, cut.plane.down], axis=1)
    shift = (second - first - step) @ plane  # not zero across periodic sides
    start = (first - result.origin) @ plane
    ends = np.stack([start, start + step @ plane], axis=1)
    is_across = np.abs(shift).max(axis=1, initial=0.0) > 0.5 * result.case.packing.diameter
    images = ends[is_across] + shift[is_across][:, None]
    rows = np.arange(len(ends))
    return np.concatenate([ends, images]), np.concatenate([rows, rows[is_across]])


def _width_in_points(window: Window, diameter: float, n_panels: int, height: float) -> float:
    """Return the width of the thickest line, points."""
    left, right, _, _ = window
    across = WIDTH - _ROOM
    across *= min(1.0, (_TALLEST - _BELOW) / (n_panels * height))
    thickest = _THICKEST * diameter * _MILLI / (right - left) * across * _POINTS
    return min(max(thickest, _LEAST_THICKEST), _MOST_THICKEST)


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _newton(force: float) -> str:
    """Return a force with its unit, kN from 1000 N on."""
    if force >= _MANY_NEWTON:
        return f"{force * _KILO:.3g} kN"
    return f"{force:.3g} N"


def _columns_of_network(state: ContactForces, ends: Vectors) -> dict[str, ArrayLike]:
    """Return the data of a panel."""
    return {
        f"{state.name}_i": state.i,
        f"{state.name}_j": state.j,
        f"{state.name}_force_N": state.force,
        f"{state.name}_across_i_m": ends[:, 0, 0],
        f"{state.name}_down_i_m": ends[:, 0, 1],
        f"{state.name}_across_j_m": ends[:, 1, 0],
        f"{state.name}_down_j_m": ends[:, 1, 1],
    }


_STYLES = {STATIC: (GREEN, "s"), INSTANT: (ORANGE, "^"), PEAK: (BLUE, "o")}
_LINES = {STATIC: ":", INSTANT: "-.", PEAK: "--"}  # line styles of the mean of nearly equal forces
_FEWEST = 10  # fewest contacts of a distribution
_FEWEST_BINS = 5
_MOST_BINS = 60
_TAIL_FROM = 1.0  # start of the fitted tail / mean force
_WIDE = 20.0  # largest force / mean above which the bins widen with the force
_ALIKE = 0.06  # standard deviation / mean of nearly equal forces, which have no distribution
_FIRST_BIN = 0.25  # upper edge of the first of widening bins / mean force
_NOT_SMALL = 0.5  # smallest force / mean, above which bins begin with it
_CURVE = 200  # points of a fitted tail
_AT_EDGE = 0.92  # height of a remark at the edge / height of the panel
_BEYOND = 3.0  # ratio of the limits of the axis to the densities
_LOW_FIGURE = 2.7  # height of a figure with one panel, inches
_TALL_FIGURE = 4.6  # with two panels
_RELATIVE = r"Contact force / mean $F/\langle F\rangle$"
_DENSITY = r"$P(F/\langle F\rangle)$"


def force_distribution(result: Result) -> Drawing | None:
    """Draw the distribution of the contact forces, relative to their mean, with exponential tails.

    The states are at rest, at the instant of the largest elastic energy, and at the largest force
    of each contact. A state needs a record and at least ten contacts. Nearly equal forces are drawn
    as a band over their range. If the largest force exceeds 20 times the mean, the first panel ends
    there, and a second panel with two logarithmic axes has all forces; in axes of the user there is
    one panel with all forces. A chain has no distribution: all its contacts carry the same pulse.
    """
    if result.case.packing.rule.is_chain:
        return None
    states = [state for state in contact_forces(result) if len(state.force) >= _FEWEST]
    if not states:
        return None
    is_wide = user_figure() is None and any(_is_wide(state) for state in states)
    figure, axes, *of_all = panels(
        _TALL_FIGURE if is_wide else _LOW_FIGURE, rows=2 if is_wide else 1
    )
    all_alike = all(_is_alike(state) for state in states)
    columns: dict[str, ArrayLike] = {}
    for state in states:
        relative = state.force / state.force.mean()
        if _is_alike(state):
            columns |= _draw_alike_forces(axes, state)
        else:
            columns |= _draw_distribution(axes, state, relative)
    label(axes, _RELATIVE)
    if all_alike:
        _say_that_all_are_alike(axes)
    else:
        label(axes, y=_DENSITY, log="y")
    axes.set_xlim(left=0, right=_WIDE if is_wide else None)
    if is_wide:
        _say_that_axis_ends(axes, states)
    legend_above(axes, 1, fontsize=7)
    for beyond in of_all:
        _draw_all_forces(beyond, states)
    return Drawing(figure, columns)


def _is_wide(state: ContactForces) -> bool:
    """Return True if the largest force exceeds 20 times the mean."""
    return float(state.force.max()) > _WIDE * float(state.force.mean())


def _say_that_axis_ends(axes: Axes, states: list[ContactForces]) -> None:
    """Show at the right edge of the first panel that the second panel has larger forces."""
    largest = max(float(state.force.max() / state.force.mean()) for state in states)
    axes.annotate(
        f"up to {largest:.3g} in the lower panel ",
        xy=(1.0, _AT_EDGE),
        xytext=(0.94, _AT_EDGE),
        xycoords="axes fraction",
        ha="right",
        va="center",
        fontsize=7,
        arrowprops={"arrowstyle": "->", "linewidth": 0.8},
    )


def _draw_all_forces(axes: Axes, states: list[ContactForces]) -> None:
    """Draw the distributions of all states on two logarithmic axes, where a power law is a straight
    line.
    """
    for state in states:
        if _is_alike(state):
            continue
        relative = state.force / state.force.mean()
        centre, density, count = _histogram(relative)
        _draw_densities(axes, state, centre[count > 0], density[count > 0])
    label(axes, _RELATIVE, _DENSITY, log="xy")


def _is_alike(state: ContactForces) -> bool:
    """Return True for nearly equal forces, as in a uniform chain."""
    return float(state.force.std()) <= _ALIKE * float(state.force.mean())


def _draw_alike_forces(axes: Axes, state: ContactForces) -> dict[str, ArrayLike]:
    """Draw the range of the forces of contacts with nearly equal forces; return its data."""
    colour, _ = _STYLES[state.name]
    mean = float(state.force.mean())
    low = float(state.force.min())
    high = float(state.force.max())
    forces = f"all with {_newton(mean)}"
    if _newton(low) != _newton(high):
        forces = f"{_newton(low)} to {_newton(high)}"
    axes.axvspan(low / mean, high / mean, color=colour, alpha=0.25, linewidth=0)
    text = f"{state.title}: {_counted(state)}, {forces}"
    axes.axvline(1.0, color=colour, linestyle=_LINES[state.name], linewidth=0.9, label=text)
    return {
        f"{state.name}_mean_force_N": [mean],
        f"{state.name}_smallest_force_N": [low],
        f"{state.name}_largest_force_N": [high],
    }


def _say_that_all_are_alike(axes: Axes) -> None:
    """Show in empty axes that there is no distribution."""
    axes.set(xlim=(0, 2), ylim=(0, 1), yticks=[])
    axes.text(
        0.5,
        0.5,
        "all contacts carry nearly the same force:\nno distribution",
        transform=axes.transAxes,
        ha="center",
        va="center",
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8},
    )


def _counted(state: ContactForces) -> str:
    """Return the number of contacts of a state in words, and of all loaded contacts if some are
    left out.
    """
    number = len(state.force)
    if not state.n_left_out:
        return counted(number, "contact")
    of_all = number + state.n_left_out
    kind = "loaded contacts" if state.name == PEAK else "contacts with a force"
    return f"{number} of {of_all} {kind}\n(with at least $10^{{-4}}$ of the largest force)"


def _draw_distribution(axes: Axes, state: ContactForces, relative: Vectors) -> dict[str, ArrayLike]:
    """Draw the distribution of one state with its tail; return its data."""
    colour, _ = _STYLES[state.name]
    centre, density, count = _histogram(relative)
    filled = count > 0
    text = f"{state.title}: {_counted(state)}"
    tail = exponential_tail(relative, _TAIL_FROM)
    if tail is not None:
        decay = "not exponential"
        if tail.is_exponential:
            decay = f"decay {with_error(tail.decay, tail.error)}"
        text = f"{text};\n{tail.count} above the mean force: {decay}"
    _draw_densities(axes, state, centre[filled], density[filled], text)
    if tail is not None:
        _draw_tail(axes, tail, relative, colour)
    _widen(axes, density[filled])
    return _columns_of_distribution(state, (centre, density, count), tail)


def _draw_densities(
    axes: Axes, state: ContactForces, relative: Vectors, density: Vectors, text: str = ""
) -> None:
    """Mark the probability densities of relative forces of a state, with a text in the legend."""
    colour, marker = _STYLES[state.name]
    axes.plot(
        relative, density, marker, color=colour, markersize=3.5,
        markerfacecolor="none", markeredgewidth=0.9, label=text or None,
    )  # fmt: skip


def _widen(axes: Axes, density: Vectors) -> None:
    """Include these densities in the range of the axis; fitted tails may leave it."""
    low = float(density.min()) / _BEYOND
    high = float(density.max()) * _BEYOND
    if axes.get_autoscaley_on():
        axes.set_ylim(low, high)
        return
    bottom, top = axes.get_ylim()
    axes.set_ylim(min(low, bottom), max(high, top))


def _histogram(values: Vectors) -> tuple[Vectors, Vectors, NDArray[np.int64]]:
    """Return the centres of bins, the probability density, and the number of values of each.

    Bins of equal width reach from 0 to the largest value, or from the smallest value if it is not
    small. If the largest value exceeds 20 times the mean, bins widen by a constant factor beyond a
    quarter of the mean, so that rare large forces share bins.
    """
    number = round(2 * len(values) ** (1 / 3))
    number = min(max(number, _FEWEST_BINS), _MOST_BINS)
    largest = float(values.max())
    if largest > _WIDE * float(values.mean()):
        edges = np.geomspace(_FIRST_BIN * float(values.mean()), largest, number)
        edges[-1] = largest
        edges = np.concatenate([[0.0], edges])
    else:
        smallest = float(values.min())
        edges = np.linspace(smallest if smallest > _NOT_SMALL else 0.0, largest, number + 1)
    centre = 0.5 * (edges[1:] + edges[:-1])
    count = np.histogram(values, edges)[0]
    return centre, count / (len(values) * np.diff(edges)), count


def _draw_tail(axes: Axes, tail: ExponentialTail, relative: Vectors, colour: str) -> None:
    """Draw the fitted exponential, with the fraction of the values beyond its start below it;
    dashed if the values are not exponential.
    """
    x = np.linspace(tail.start, float(relative.max()), _CURVE)
    height = tail.count / len(relative) * tail.decay
    density = height * np.exp(-tail.decay * (x - tail.start))
    line = "-" if tail.is_exponential else "--"
    text = "exponential with the same mean above it"
    if tail.is_exponential:
        text = "fitted exponential"
    axes.plot(x, density, line, color=colour, linewidth=0.9, label=text)


def _columns_of_distribution(
    state: ContactForces,
    histogram: tuple[Vectors, Vectors, NDArray[np.int64]],
    tail: ExponentialTail | None,
) -> dict[str, ArrayLike]:
    """Return the data of a distribution."""
    centre, density, count = histogram
    columns: dict[str, ArrayLike] = {
        f"{state.name}_force_over_mean": centre,
        f"{state.name}_density": density,
        f"{state.name}_contacts": count,
        f"{state.name}_mean_force_N": [state.force.mean()],
    }
    if tail is not None:
        columns |= {
            f"{state.name}_tail_from": [tail.start],
            f"{state.name}_tail_decay": [tail.decay],
            f"{state.name}_tail_decay_error": [tail.error],
            f"{state.name}_tail_contacts": [tail.count],
            f"{state.name}_tail_is_exponential": [int(tail.is_exponential)],
        }
    return columns
