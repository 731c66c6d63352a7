"""Lines, legends and axes that the figures of a comparison share."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib.lines as mlines
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure
from matplotlib.markers import CARETRIGHTBASE

from granwave.analysis.figures.series import COLOURS, label_log_axis, panels
from granwave.analysis.figures.style import WIDTH
from granwave.analysis.figures.user_axes import user_figure
from granwave.analysis.formatting.numbers import quantity_in
from granwave.analysis.measures.signals import Array
from granwave.analysis.reports.comparison.curves import SampledCurve
from granwave.analysis.reports.comparison.measured_curve import MeasuredCurve
from granwave.analysis.reports.comparison.subjects import ComparedRun

#: Colours of the runs, a different one for each of the most runs of a figure.
_COLOURS = (*COLOURS, "#882255", "#999933", "#E69F00", "#332288", "#8C564B", "#44AA99")
_MICRO = 1e6
_KILO = 1e3
_UNLIKE = 5.0  # longest over shortest run from which on the axis of time is logarithmic
_EARLIEST = 1e-3  # earliest start of that axis / end of the shortest run
_SMALL = 0.01  # smallest change that an axis of time shows, a fraction of the range
_AFTER_CHANGE = 1.2  # end of an axis of time / time of the last such change
_START_SIZE = 4.0  # size of the marks of the values at the start, points
#: Line styles of the runs, which distinguish curves in grey prints; fits and measured curves are
#: dotted. The styles with longer gaps are drawn over the others.
_LINES: tuple[Any, ...] = (
    "-",
    (0, (9, 1.5)),
    (0, (7, 1.5, 1.5, 1.5)),
    (0, (4, 1.5)),
    (0, (6, 1.5, 1.5, 1.5, 1.5, 1.5)),
    (0, (2, 2)),
)
_ABOVE_LINES = 0.01  # step of the order of drawing from a line style to the next
_MANY_RUNS = 4  # runs of a figure that fills a row
_FULL_ROW = 2 * WIDTH  # inches
_ONE_PANEL = 2.9  # inches
_FONT = 7  # font size of legends, points
_LETTER = 0.054  # width of a letter of a legend, inches
_HANDLE = 0.65  # width of its line and gaps, inches
_HANDLE_LENGTH = 4.0  # length of its line, which shows a period of broken lines / font size
_ROW = 0.15  # height of a row of a legend, inches
_FREE_ROWS = 2  # rows of a legend for which a figure has room
_THIN = 0.9  # points
_THICK = 1.6
_MOST_WIDTHS = 6  # runs whose lines have different widths
_MARKERS = ("o", "s", "^", "D", "v", "P")
_MEASURED_SIZE = 4.5  # size of the markers of measured points, points
_MOST_MARKED = 40  # points of a curve with markers
_ROOM_ABOVE = 1.06  # upper end of a linear axis / largest value
_ROOM_OF_LOG = 1.4  # end of a logarithmic axis / largest or smallest value
_WIDE = 10.0  # highest over lowest value from which on an axis is logarithmic


def run_panels(
    n_runs: int, n_panels: int, height: float, panel_height: float = _ONE_PANEL
) -> tuple[Any, ...]:
    """Return a new figure and its axes: panels below each other in the width of a column, and for
    four and more runs side by side in a full row, where their legend has room.

    Parameters
    ----------
    height
        Height of the figure of few runs, inches.
    panel_height
        Height of the figure of many runs, inches.
    """
    if not is_in_a_row(n_runs):
        return panels(height, rows=n_panels, sharex=True)
    if n_panels == 1:
        return panels(panel_height, width=_FULL_ROW)
    return panels(panel_height, n_panels, width=_FULL_ROW)


def run_styles(runs: Sequence[ComparedRun]) -> dict[ComparedRun, dict[str, Any]]:
    """Return colour and line of each run, which are the same in all figures of a comparison.

    Of a few runs the first has the thickest line, so that it is seen below equal curves; solid
    lines are below broken lines.
    """
    widths = [_THIN] * len(runs)
    if 1 < len(runs) <= _MOST_WIDTHS:
        widths = np.linspace(_THICK, _THIN, len(runs)).tolist()
    styles: dict[ComparedRun, dict[str, Any]] = {}
    for run, width in zip(runs, widths, strict=True):
        turn, place = divmod(run.look, len(_COLOURS))
        line = (place + turn) % len(_LINES)
        styles[run] = {
            "color": _COLOURS[place],
            "linestyle": _LINES[line],
            "linewidth": width,
            "zorder": mlines.Line2D.zorder + line * _ABOVE_LINES,
            "label": run.label.replace("$", r"\$").lstrip("_") or "run",
        }
    return styles


def run_markers(run: ComparedRun, places: Array) -> dict[str, Any]:
    """Return the markers of the curve of a run; none for many points, which would hide its line.

    Markers are hollow and have different shapes, so that equal curves can be distinguished.
    """
    if len(places) > _MOST_MARKED:
        return {}
    return {
        "marker": _MARKERS[run.look % len(_MARKERS)],
        "markersize": 3.5,
        "markerfacecolor": "none",
        "markeredgewidth": 0.8,
    }


def is_in_a_row(n_runs: int) -> bool:
    """Return True if the panels of a figure of so many runs are side by side."""
    return n_runs >= _MANY_RUNS


def label_lowest(panels_of_figure: Sequence[Axes], n_runs: int, text: str) -> None:
    """Label the horizontal axes of the panels of `run_panels` that have no panel below them."""
    lowest = panels_of_figure if is_in_a_row(n_runs) else panels_of_figure[-1:]
    for axes in lowest:
        axes.set_xlabel(text)


def legend_above(figure: MatplotlibFigure) -> None:
    """Put the legend of the lines of the first panel above a figure, which grows by its rows.

    Figures of the user keep their size, and have the legend in the first panel.
    """
    axes = figure.axes[0]
    lines = [line for line in axes.lines if not str(line.get_label()).startswith("_")]
    longest = max(len(str(line.get_label())) for line in lines)
    width, height = figure.get_size_inches()
    n_columns = max(1, int(width / (_HANDLE + _LETTER * longest)))
    n_rows = math.ceil(len(lines) / n_columns)
    if user_figure() is None:
        figure.set_size_inches(width, height + _ROW * max(0, n_rows - _FREE_ROWS))
    figure.legend(
        handles=lines,
        loc="outside upper center",
        ncols=n_columns,
        fontsize=_FONT,
        handlelength=_HANDLE_LENGTH,
    )


def show_times_up_to(
    axes: Axes,
    ends: Mapping[ComparedRun, float],
    changes: Mapping[ComparedRun, float] | None = None,
    last_change: float = math.inf,
) -> None:
    """Show the longest run up to its last change; the axis is logarithmic if the lengths of the
    finished runs differ a lot, and then begins before the first change of any run.

    Parameters
    ----------
    ends
        Ends of the runs, s. A run that was stopped ends anywhere, so that it makes no axis
        logarithmic.
    changes
        Time of the first change in each run, s, as of `first_change`.
    last_change
        Time, s, after which nothing changes in any run.
    """
    end = min(max(ends.values()), _AFTER_CHANGE * last_change) * _MICRO
    if not are_times_logarithmic(ends):
        axes.set_xlim(0, end or 1.0)
        return
    axes.set_xscale("log", nonpositive="mask")
    axes.set_xlim(_log_start(ends, changes or {}) * _MICRO, end)


def are_times_logarithmic(ends: Mapping[ComparedRun, float]) -> bool:
    """Return True if the lengths of the finished runs, s, differ too much for a linear axis."""
    return 0 < _shortest(ends) * _UNLIKE < max(ends.values())


def _shortest(ends: Mapping[ComparedRun, float]) -> float:
    """Return the end of the shortest finished run, s; infinity without a finished run."""
    return min((end for run, end in ends.items() if not run.run.is_unfinished), default=math.inf)


def _log_start(ends: Mapping[ComparedRun, float], changes: Mapping[ComparedRun, float]) -> float:
    """Return the start of a logarithmic axis of times, s."""
    shortest = _shortest(ends)
    first = min([shortest / _UNLIKE**2, *changes.values()])
    return max(first, _EARLIEST * shortest)


def first_change(curve: SampledCurve) -> float:
    """Return the last sampled positive time, s, before the first change of a curve by a hundredth
    of its range.
    """
    differs = np.abs(curve.y - curve.y[0]) > _SMALL * float(np.ptp(curve.y))
    place = max(int(np.argmax(differs)) - 1, 1)
    positive = curve.x[place:][curve.x[place:] > 0]
    return float(positive[0]) if differs.any() and len(positive) else math.inf


def last_change(curve: SampledCurve, full: float) -> float:
    """Return the time, s, after which a curve is within a hundredth of ``full`` of its end."""
    differs = np.flatnonzero(np.abs(curve.y - curve.y[-1]) > _SMALL * full)
    return float(curve.x[min(differs[-1] + 1, len(curve.x) - 1)]) if len(differs) else 0.0


def mark_start(axes: Axes, value: float, colour: Any) -> None:
    """Mark the value at time 0 of a curve at the left edge of a logarithmic axis of times."""
    left = axes.get_xlim()[0]
    axes.plot(
        left,
        value,
        marker=CARETRIGHTBASE,
        color=colour,
        markersize=_START_SIZE,
        clip_on=False,
        zorder=4,
        label="_start",
    )


def start_notes(ends: Mapping[ComparedRun, float], changes: Mapping[ComparedRun, float]) -> str:
    """Return a sentence on the start of a logarithmic axis of times with marks of `mark_start`;
    empty for a linear axis.
    """
    if not are_times_logarithmic(ends):
        return ""
    start = _rounded_time(_log_start(ends, changes))
    return f"Time is logarithmic from {start} on; triangles on the left edge: values at time 0."


def end_notes(ends: Mapping[ComparedRun, float], last: float, steady: str) -> str:
    """Return a sentence on an axis of times that ends before the longest run; empty if it shows the
    complete run.

    Parameters
    ----------
    steady
        What stays constant beyond the last change, such as ``no sphere yields``.
    """
    longest = max(ends.values())
    if _AFTER_CHANGE * last >= longest:
        return ""
    end = _rounded_time(_AFTER_CHANGE * last)
    return (
        f"The axis of time ends at {end} of {_rounded_time(longest)}: {steady} after "
        f"{_rounded_time(last)}."
    )


def _rounded_time(time: float) -> str:
    """Return a time, s, with three digits and a unit."""
    return quantity_in(float(f"{time:.3g}"), "s")


def force_unit(largest: float) -> tuple[float, str]:
    """Return the unit of forces up to ``largest`` (N): the number of units in a newton, and its
    name.
    """
    return (1 / _KILO, "kN") if largest >= _KILO else (1.0, "N")


def draw_measured(
    axes: Axes, measured: Sequence[MeasuredCurve], x_scale: float, y_scale: float
) -> dict[str, Array]:
    """Draw measured curves in black, and return their columns; few points have markers."""
    columns: dict[str, Array] = {}
    for curve in measured:
        is_marked = len(curve.x) <= _MOST_MARKED
        axes.plot(
            curve.x * x_scale,
            curve.y * y_scale,
            color="black",
            linestyle=":",
            linewidth=1.4,
            marker="x" if is_marked else "",
            markersize=_MEASURED_SIZE,
            label="measured",
            zorder=3,
        )
        columns |= {"measured_x": curve.x, "measured_y": curve.y}
    return columns


def log_if_wide(*panels_of_figure: Axes) -> None:
    """Give the vertical axes of all panels one kind of scale, logarithmic if their lines together
    span more than a decade, otherwise linear from 0; each panel has limits of its own.
    """
    is_logarithmic = is_wide(np.concatenate([_drawn_values(axes) for axes in panels_of_figure]))
    for axes in panels_of_figure:
        values = _drawn_values(axes)
        positive = values[values > 0]
        if is_logarithmic and len(positive):
            axes.set_yscale("log")
            axes.set_ylim(positive.min() / _ROOM_OF_LOG, positive.max() * _ROOM_OF_LOG)
            label_log_axis(axes, positive.max() / positive.min())
        else:
            axes.set_ylim(0, _ROOM_ABOVE * values.max(initial=0.0) or 1.0)


def _drawn_values(axes: Axes) -> Array:
    """Return the finite values of the lines of axes."""
    lines = [np.asarray(line.get_ydata(), dtype=np.float64) for line in axes.lines]
    values = np.concatenate([*lines, np.empty(0)])
    return values[np.isfinite(values)]


def is_wide(values: Array) -> bool:
    """Return True for values that span more than a decade."""
    return bool(len(values) and values.max() > _WIDE * values.min())
