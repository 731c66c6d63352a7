"""Figures of parts of a packing: force at depths, energy in regions."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from granwave.analysis.figures.impact_arrow import impact_arrow
from granwave.analysis.figures.series import (
    LINES,
    against_time,
    are_relative,
    is_overlaid,
    label,
    panels,
    scale_by_peaks,
    time_axis,
)
from granwave.analysis.figures.style import GREY, ORANGE, Drawing, legend_above
from granwave.analysis.figures.user_axes import user_figure
from granwave.analysis.formatting.numbers import quantity_in
from granwave.analysis.measures.depths import ForceAtDepth, depth_range, forces_at_depths
from granwave.analysis.measures.regions import (
    DISSIPATED,
    OTHERS,
    WALLS,
    energy_of_regions,
    usual_regions,
)
from granwave.analysis.measures.signals import Array
from granwave.analysis.result.reader import Result

logger = logging.getLogger(__name__)

_MICRO = 1e6  # microseconds in a second
_MILLI = 1e3  # millimetres in a metre
_KILO = 1e-3  # kilonewtons in a newton
_LARGE = 1e4  # N from which on forces are in kN
_ABOVE_ONE = 1.05  # end of the axis of relative forces
_BOTTOM = "bottom"
_REACHED = 1e-4  # fraction of the largest force: depths that the wave has reached
_FEW = 60  # instants up to which each has a mark
_LIGHT = 0.85  # part of the colour map: last depth
_DEPTH_MAP = "viridis"
_REGION_MAP = "Blues"
_PALEST = 0.3  # part of the colour map of regions: farthest from the load
_DARKEST = 0.95  # nearest to it
_OTHER_COLOURS = {DISSIPATED: ORANGE, WALLS: GREY, OTHERS: "#d9d9d9", "plate": "#3a3a3a"}
_HATCHES = {
    DISSIPATED: "////", WALLS: "....", "rotation": "xxxx", "support": "----", "bar": "\\\\\\\\",
    "incident bar": "||||",
}  # fmt: skip
_EDGE = 0.5  # points: white lines between regions
_COLUMNS = 2  # columns of the legend of regions
_MOST = 0.5  # dissipated fraction of the input above which the rest has its own panel
_LEAST_SHOWN = 1e-3  # fraction of the input that a part exceeds at some time, or is not drawn
_LEAST_LEFT = 1e-12  # fraction of the input, rounding of an energy that is completely dissipated
_FEWEST_SHIFTED = 4  # fewest curves that oscillate and are shifted
_MANY_PEAKS = 3  # median number of peaks of curves that are shifted
_PART_OF_SHIFT = 0.6  # shift / largest force
_LOW_FIGURE = 2.9  # height of a figure with one panel, inches
_TALL_FIGURE = 4.4  # with two panels
_LONG = 24  # characters of a name, beyond which the legend has one column


def force_at_depths(result: Result) -> Drawing | None:
    """Draw the force through planes at depths against time, and the force on the bottom."""
    depths = result.figure_options.depths
    forces = forces_at_depths(result, depths)
    if depths is not None:
        _warn_of_depths(result, depths)
    if not forces:
        return None
    figure, axes = panels(2.8)
    curves = {_depth_name(part.depth): (part.time, part.force) for part in forces}
    columns: dict[str, ArrayLike] = {"time_s": forces[0].time}
    columns |= {f"force_at_{part.depth * _MILLI:.4g}_mm_N": part.force for part in forces}
    looks = [_look(number, forces) for number in range(len(forces))]
    if "walls/bottom" in result:
        time = result["walls/bottom/time"]
        force = result["walls/bottom/force"]
        curves[_BOTTOM] = (time, force)
        looks.append({"color": "black", "linewidth": 0.6})
        columns |= {"bottom_time_s": time, "bottom_force_N": force}
    _draw_forces(axes, curves, looks)
    time_axis(axes, result["energy/time"])
    return Drawing(figure, columns)


def _depth_name(depth: float) -> str:
    """Return the name of a plane at a depth below the centre of the impacted sphere, m."""
    words = f"{abs(depth) * _MILLI:.4g} mm"
    return f"{words} above" if depth < 0 else words


def _draw_forces(
    axes: Axes, curves: dict[str, tuple[Array, Array]], looks: list[dict[str, Any]]
) -> None:
    """Draw forces against time, and label their axis. If their peaks differ much, each is divided
    by its peak, which the legend gives. Curves that oscillate are shifted.

    Parameters
    ----------
    curves
        Times, s, and forces, N, by name: (n_times,) each.
    looks
        Colours and lines of the curves.
    """
    peaks = {name: float(force.max(initial=0.0)) for name, (_, force) in curves.items()}
    largest = max(float(np.abs(force).max(initial=0.0)) for _, force in curves.values())
    scale, unit = (_KILO, "kN") if largest >= _LARGE else (1.0, "N")
    of_planes = [peak for name, peak in peaks.items() if name != _BOTTOM]
    is_relative = are_relative(of_planes)
    shift = _shift([force for _, force in curves.values()], 1.0 if is_relative else scale * largest)
    for number, ((name, (time, force)), look) in enumerate(zip(curves.items(), looks, strict=True)):
        text = name
        size = scale
        if is_relative:
            is_reached = peaks[name] > _REACHED * largest
            text = f"{name}: {quantity_in(peaks[name], 'N') if is_reached else 'not reached'}"
            size = 1 / (peaks[name] if is_reached else largest)
        against_time(axes, time, force * size + shift * number, label=text, **look)
    shifted = ""
    if shift:
        by = f"{shift:.4g}" if is_relative else f"{shift:.4g} {unit}"
        shifted = f",\ncurves shifted by {by} each"
    if is_relative:
        limits = (None, _ABOVE_ONE + shift * (len(curves) - 1))
        label(axes, y=f"Force through the plane / its peak{shifted}", ylim=limits)
        legend_above(axes, 2, title="Depth: peak force", handlelength=2.2)
        return
    label(axes, y=f"Force through the plane ({unit}){shifted}")
    if not shift:
        scale_by_peaks(axes, [scale * peak for peak in of_planes])
    legend_above(axes, 3, title="Depth", handlelength=2.2)


def _shift(forces: Sequence[Array], largest: float) -> float:
    """Return the shift between the curves of forces that oscillate, which would cover each other;
    0 for curves of few peaks, and for curves of two runs.

    Parameters
    ----------
    largest
        Largest value of the axis of unshifted curves.
    """
    if len(forces) < _FEWEST_SHIFTED or is_overlaid():
        return 0.0
    n_peaks = [_n_peaks(force) for force in forces]
    if np.median(n_peaks) < _MANY_PEAKS:
        return 0.0
    return float(f"{_PART_OF_SHIFT * largest:.1g}")


def _n_peaks(force: Array) -> int:
    """Return how often a force rises through half its largest value."""
    is_high = force > 0.5 * force.max(initial=0.0)
    return int(np.count_nonzero(is_high[1:] & ~is_high[:-1]))


def _look(number: int, forces: list[ForceAtDepth]) -> dict[str, Any]:
    """Return colour and line of a depth, with marks where there are few instants."""
    part = number / max(len(forces) - 1, 1)
    look: dict[str, Any] = {
        "color": colormaps[_DEPTH_MAP](_LIGHT * part),
        "line": LINES[number % len(LINES)],
        "linewidth": 1.0,
    }
    if len(forces[number].time) <= _FEW:
        look |= {"marker": "o", "markersize": 2.0}
    return look


def _warn_of_depths(result: Result, depths: tuple[float, ...]) -> None:
    """Warn of depths that have grains on one side only."""
    top, bottom = depth_range(result)
    outside = [f"{depth:g}" for depth in depths if not top < depth <= bottom]
    if outside:
        logger.warning(
            "force_at_depths: figures.depths: found %s m, expected depths from %.3g to %.3g m, "
            "between the centres of the first and the last layer; omitted",
            ", ".join(outside),
            top,
            bottom,
        )


def energy_by_region(result: Result) -> Drawing | None:
    """Draw the energy in regions of a packing as areas, one above the other, against time.

    If most of the energy is dissipated, a second panel has the fractions of the energy that is not
    yet dissipated, except in axes of the user. Parts below a thousandth of the input are not drawn.
    """
    regions = usual_regions(result, impact_arrow(result).direction)
    energy = energy_of_regions(result, regions)
    if energy is None or not energy.share:
        return None
    order = [DISSIPATED, *reversed(regions), OTHERS]
    names = sorted(
        energy.share, key=lambda name: order.index(name) if name in order else len(order)
    )
    total = np.sum([energy.share[name] for name in names], axis=0)
    lost = energy.share.get(DISSIPATED, np.zeros(len(total)))
    has_rest = user_figure() is None and float(lost.max()) > _MOST
    figure, axes, *below = panels(
        _TALL_FIGURE if has_rest else _LOW_FIGURE, rows=2 if has_rest else 1, sharex=True
    )
    shown = [name for name in names if float(energy.share[name].max()) >= _LEAST_SHOWN]
    _draw_areas(axes, energy.time, [(name, energy.share[name]) for name in shown], list(regions))
    for rest in below:
        left = np.maximum(total - lost, _LEAST_LEFT)
        parts = [(name, energy.share[name] / left) for name in shown if name != DISSIPATED]
        _draw_areas(rest, energy.time, parts, list(regions))
        label(rest, y="Fraction of the energy\nnot yet dissipated", ylim=(0, 1))
    quantity = "Kinetic energy" if energy.kinetic_only else "Energy"
    label(axes, y=f"{quantity} / energy input", ylim=(0, 1.05 * max(1.0, float(total.max()))))
    if energy.kinetic_only:
        axes.set_ylim(0, 1.05 * float(total.max()))
    time_axis(figure.axes[-1], energy.time)
    is_long = max(map(len, shown)) > _LONG
    legend_above(axes, 1 if is_long else _COLUMNS, fontsize=7, reverse=True)
    columns: dict[str, ArrayLike] = {"time_s": energy.time}
    columns |= {f"{column}_over_input": energy.share[name] for name, column in _columns(names)}
    return Drawing(figure, columns)


def _draw_areas(axes: Axes, time: Any, parts: list[tuple[str, Any]], regions: list[str]) -> None:
    """Draw fractions above each other; regions are darker nearer to the load."""
    low = np.zeros(len(time))
    for name, share in parts:
        colour: Any = _OTHER_COLOURS.get(name, GREY)
        if name in regions:
            part = 1 - regions.index(name) / max(len(regions) - 1, 1)
            colour = colormaps[_REGION_MAP](_PALEST + (_DARKEST - _PALEST) * part)
        axes.fill_between(
            time * _MICRO, low, low + share, facecolor=colour, label=name, edgecolor="white",
            linewidth=_EDGE, hatch=_HATCHES.get(name),
        )  # fmt: skip
        low = low + share


def _columns(names: list[str]) -> list[tuple[str, str]]:
    """Return the names of the regions that columns belong to."""
    return [(name, name.replace(",", "").replace(" ", "_").replace("-", "_")) for name in names]
