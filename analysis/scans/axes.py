"""Axes and marks of figures of scans: scales, tick labels that do not overlap, points and bars of plastic zones."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import to_rgba
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullFormatter, NullLocator
from numpy.typing import NDArray

from granwave.analysis.figures.style import WIDTH
from granwave.analysis.formatting.numbers import tick
from granwave.analysis.measures.zone_size import LABELS, Mark

AXIS = 0.78 * WIDTH  # inches, length of a horizontal axis
CHARACTER = 0.066  # inches, approximate width of a character
_SPREAD = 1.5  # decades from which on an axis of values is logarithmic
_DECADE = 10.0
_MOST_LABELLED = 8  # values that are labelled individually
_DECADES = 2.2  # decades from which on a logarithmic axis has ticks at the decades
_STEPS = ((1.0, 2.0, 5.0), (1.0, 3.0), (1.0,))  # multiples of the ticks otherwise
_FEWEST_TICKS = 2
_EDGE = 1.02  # margin beyond the ends of a logarithmic scale


def even_in_log(values: NDArray[np.float64]) -> bool:
    """Return True for sorted values over more than a decade that are spaced more evenly in their logarithm."""
    if len(values) < 2 or values[0] <= 0 or values[-1] < _DECADE * values[0]:
        return False
    ratios, steps = np.diff(np.log(values)), np.diff(values)
    return len(values) == 2 or float(np.std(ratios) / np.mean(ratios)) < float(np.std(steps) / np.mean(steps))


def is_wide(values: NDArray[np.float64]) -> bool:
    """Return True for positive values with a range too large for a linear axis."""
    return bool(values.min() > 0 and values.max() > 10**_SPREAD * values.min())


def fit(labels: Sequence[str], inches: float) -> bool:
    """Return True if labels at this spacing do not touch."""
    return max(map(_width, labels)) <= inches


def scale_abscissae(axes: Axes, values: NDArray[np.float64], room: float, *, chosen: bool) -> None:
    """Set the scale of abscissae: logarithmic if suitable; label few ``chosen`` values individually if they fit.

    Parameters
    ----------
    room
        Length of the axis, inches.
    """
    axis, places = axes.xaxis, np.unique(values)
    if even_in_log(places) or (not chosen and is_wide(places)):
        axes.set_xscale("log")
        low, high = places[0], places[-1]
        beyond = (high / low) ** 0.05 * _EDGE
        axes.set_xlim(low / beyond, high * beyond)
        inches = room * np.log(places / low) / np.log(high * beyond**2 / low)
        if not chosen or not _label_each(axis, places, inches):
            log_ticks(axis, room)
    elif chosen and np.all(places == np.rint(places)) and np.ptp(places) < 40:
        _label_each(axis, places, room * (places - places[0]) / (1.1 * np.ptp(places) or 1.0))


def scale_values(axes: Axes, values: NDArray[np.float64], half_widths: NDArray[np.float64]) -> None:
    """Set the scale of values: logarithmic for a large range, else from 0 if near it, never enlarging mere noise.

    Parameters
    ----------
    values, half_widths
        Values and half-widths of intervals of all curves: (n,); half-widths may be NaN.
    """
    if is_wide(values):
        axes.set_yscale("log")
        log_ticks(axes.yaxis)
        return
    widths = np.nan_to_num(half_widths)
    low, high = float(np.min(values - widths)), float(np.max(values + widths))
    if low >= 0 and low < 0.5 * high:
        axes.set_ylim(0, 1.08 * high)
    elif high - low < 0.02 * abs(high):
        middle = 0.5 * (low + high)
        axes.set_ylim(middle - 0.1 * abs(high), middle + 0.1 * abs(high))


def log_ticks(axis: Axis, room: float | None = None) -> None:
    """Set plain tick labels: at 1, 2 and 5, or fewer, for a small range, at the decades for a large one.

    Parameters
    ----------
    room
        Length of a horizontal axis, inches, on which labels must not touch; None: not checked.
    """
    low, high = sorted(axis.get_view_interval())
    if low <= 0:
        return  # there are no values to label
    decades = np.log10(high / low)
    if decades >= _DECADES:
        return
    for steps in _STEPS:
        places = _at(steps, low, high)
        if room is None or len(places) <= _FEWEST_TICKS or _apart(places, np.log10(places / low) / decades * room):
            break
    axis.set_major_locator(LogLocator(10, subs=steps))
    axis.set_major_formatter(FuncFormatter(lambda value, _: tick(value)))
    axis.set_minor_formatter(NullFormatter())


def _label_each(axis: Axis, places: NDArray[np.float64], inches: NDArray[np.float64]) -> bool:
    """Label each value, at positions in inches along the axis; return False if they are too many or too dense."""
    if len(places) > _MOST_LABELLED or not _apart(places, inches):
        return False
    axis.set_major_locator(FixedLocator(places.tolist()))
    axis.set_major_formatter(FuncFormatter(lambda value, _: tick(value)))
    logarithmic = axis.get_scale() == "log"  # shown by ticks without labels between
    axis.set_minor_locator(LogLocator(10, subs=range(1, 10)) if logarithmic else NullLocator())
    axis.set_minor_formatter(NullFormatter())
    return True


def _apart(places: NDArray[np.float64], inches: NDArray[np.float64]) -> bool:
    """Return True if the labels of values at positions in inches along an axis do not touch."""
    widths = np.array([_width(tick(place)) for place in places])
    return bool(np.all(np.diff(inches) >= 0.5 * (widths[1:] + widths[:-1])))


def _width(label: str) -> float:
    """Return the width of a label and the gap to the next, inches."""
    return CHARACTER * (len(label) + 1)


def _at(steps: Sequence[float], low: float, high: float) -> NDArray[np.float64]:
    """Return the multiples ``steps`` of powers of ten between two numbers."""
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    places = np.array([step * 10.0**power for power in powers for step in steps])
    return places[(places >= low) & (places <= high)]


Marks = NDArray[np.int64] | None  # `Mark` of each point: (n,); None for quantities without marks


def marks_of(series: Sequence[Marks]) -> dict[Mark, str]:
    """Return the marks that occur in several series, with their labels."""
    there = {mark for marks in series if marks is not None for mark in np.unique(marks).tolist()}
    return {mark: label for mark, label in LABELS.items() if mark in there}


def draw_marks(axes: Axes, x: NDArray, y: NDArray, marks: Marks, marker: str, size: float, colour: Any) -> None:
    """Draw the marked points over existing ones."""
    for mark in LABELS:
        shown = np.zeros(len(x), dtype=bool) if marks is None else marks == mark
        if shown.any():
            axes.plot(np.asarray(x)[shown], np.asarray(y)[shown], zorder=3, **marked_marker(mark, marker, size, colour))


def marked_marker(mark: Mark, marker: str, size: float, colour: Any) -> dict[str, Any]:
    """Return the style of a marked point."""
    look = {"marker": marker, "markersize": size, "color": colour, "markeredgewidth": 0.9, "linestyle": "none"}
    if mark is Mark.CUT:
        return look | {"markerfacecolor": "white"}
    return look | {"fillstyle": "left", "markerfacecoloralt": "white"}


def marked_fill(mark: Mark, colour: str) -> dict[str, Any]:
    """Return the style of a marked bar."""
    return {"facecolor": "white" if mark is Mark.CUT else to_rgba(colour, 0.35), "edgecolor": colour, "linewidth": 1.0}
