"""Drawing of the figures of a scan: curves with error bars, bars by category, and maps."""

from __future__ import annotations

import dataclasses
import math
import re
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.figures.scales import not_to_scale
from granwave.analysis.figures.style import BLANK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, WIDTH, Drawing, new_figure
from granwave.analysis.measures.zone_size import Mark
from granwave.analysis.scans.axes import (
    AXIS,
    CHARACTER,
    draw_marks,
    even_in_log,
    fit,
    is_wide,
    log_ticks,
    marked_fill,
    marked_marker,
    marks_of,
    scale_abscissae,
    scale_values,
)
from granwave.analysis.scans.keys import Key, shown

YELLOW = "#E69F00"
_COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY, YELLOW, GREY, "black")
_MARKERS = "os^DvPX*"
_LINES = ("-", "--", ":", "-.", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)))
_HATCHES = ("", "////", "....")
_SCALE_MAP = "viridis"
_HEIGHT = 2.3  # inches, without the legend
_LINE = 0.17  # inches, height of a line of the legend
_BAR = 0.24 * WIDTH  # inches, width of a colour scale
_LONG = 12  # characters of a category beyond which bars are horizontal
_TURNED = 0.16  # inches, width of a rotated name along the axis
_LINE_OF_NAME = 28  # characters of a line beside a horizontal bar
_MOST_ANNOTATED = 8  # columns and rows of a map with numbers in its cells
_MOST_MARKED = 60  # points of a curve with markers

Titles = tuple[str, str]


@dataclasses.dataclass(frozen=True, eq=False)
class Series:
    """Points of one curve.

    Attributes
    ----------
    row
        Row of one of its points in the scan.
    x, mean, deviation, half_width, count
        Abscissae, and mean, standard deviation, half-width of the 95 % confidence interval of the mean and number of
        the values at each: (n,). Deviation and half-width are NaN for a single value.
    marks
        `Mark` of each point, for quantities of a plastic zone: (n,); None for others.
    """

    label: str
    row: int
    x: NDArray[np.float64]
    mean: NDArray[np.float64]
    deviation: NDArray[np.float64]
    half_width: NDArray[np.float64]
    count: NDArray[np.int64]
    marks: NDArray[np.int64] | None = None


def draw_curves(
    series: Sequence[Series],
    x_title: str,
    y_title: str,
    others: Sequence[Key],
    columns: Titles,
    *,
    scale: float = 1.0,
    joined: bool = True,
    chosen: bool = True,
) -> Drawing:
    """Draw curves with markers and a legend above, or a colour scale if there are many curves.

    Points of plastic zones that reach a boundary are open, half open if a wave returned from one.

    Parameters
    ----------
    others
        Keys that distinguish the curves.
    columns
        Names of the columns of abscissa and value in the CSV file.
    scale
        Unit of the abscissa in SI units.
    joined
        True to join the points of a curve.
    chosen
        True if the abscissae are values of a key, False if they are results.
    """
    along = _scale_key(series, others)
    rest = [key for key in others if key is not along]
    labels = [", ".join(key.text(curve.row) for key in rest) for curve in series]
    kinds = list(dict.fromkeys(labels))
    entries = _wrapped(kinds) if len(kinds) <= len(_COLOURS) * len(_LINES) and kinds != [""] else []
    figure = new_figure(_HEIGHT + _legend_height([*entries, *marks_of([curve.marks for curve in series]).values()]))
    axes = figure.subplots()
    norm = _norm(along, series) if along else None
    for curve, label in zip(series, labels, strict=True):
        kind = kinds.index(label)
        n, turn = kind % len(_COLOURS), kind // len(_COLOURS)
        if norm is not None and along is not None:
            colour = mpl.colormaps[_SCALE_MAP](0.92 * norm(along.values[curve.row]))
            n, line = kind % len(_MARKERS), _LINES[kind % len(_LINES)]
        else:
            colour, line = _COLOURS[n], _LINES[(n + turn) % len(_LINES)]
        axes.errorbar(
            curve.x,
            curve.mean,
            yerr=curve.half_width if np.any(np.isfinite(curve.half_width)) else None,
            color=colour,
            linestyle=line if joined else "none",
            marker=_MARKERS[n] if len(curve.x) <= _MOST_MARKED or not joined else None,
            markersize=_marker_size(kind, len(kinds)),
            markeredgewidth=0.3,
            markeredgecolor="white",
            capsize=2,
            elinewidth=0.8,
        )
        draw_marks(axes, curve.x, curve.mean, curve.marks, _MARKERS[n], _marker_size(kind, len(kinds)), colour)
    room = AXIS - (_BAR if along is not None else 0.0)
    scale_abscissae(axes, np.concatenate([curve.x for curve in series]), room, chosen=chosen)
    scale_values(axes, np.concatenate([c.mean for c in series]), np.concatenate([c.half_width for c in series]))
    axes.set_xlabel(x_title)
    axes.set_ylabel(y_title)
    if along is not None and norm is not None:
        _colour_scale(figure, axes, norm, along)
    _legend(figure, entries, coloured=along is None, joined=joined, marks=marks_of([curve.marks for curve in series]))
    return Drawing(figure, _columns(series, others, columns, np.concatenate([curve.x for curve in series]) * scale))


def draw_bars(
    series: Sequence[Series], ticks: Sequence[str], x_title: str, y_title: str, others: Sequence[Key], columns: Titles
) -> Drawing:
    """Draw bars by category (the abscissa of `Series` is its index), side by side for each series.

    On a logarithmic axis points are drawn instead. Bars are horizontal if categories have long names. Bars of plastic
    zones that reach a boundary are open, pale if a wave returned from one.
    """
    entries = _wrapped([curve.label for curve in series]) if others else []
    lying = max(map(len, ticks)) > _LONG and not fit(ticks, AXIS / len(ticks))
    marks = marks_of([curve.marks for curve in series])
    height = _legend_height([*entries, *marks.values()])
    figure = _figure_of_lying_bars(ticks, len(series), height) if lying else _figure_of_bars(ticks, height)
    axes = figure.axes[0]
    logarithmic = is_wide(np.concatenate([curve.mean for curve in series]))
    for m, curve in enumerate(series):
        _draw_bars_of(axes, curve, m, len(series), lying=lying, logarithmic=logarithmic)
    along, across = _axes_of(axes, lying=lying)
    along.set_label_text(x_title)
    across.set_label_text(y_title)
    if logarithmic:
        (axes.set_xscale if lying else axes.set_yscale)("log")
        log_ticks(across, 0.6 * AXIS if lying else None)
        _legend(figure, entries, coloured=True, joined=False, marks=marks)
    else:
        (axes.set_xmargin if lying else axes.set_ymargin)(0.08)
        patches = [mpl.patches.Patch(**_fill(m)) for m in range(len(entries))]
        patches += [mpl.patches.Patch(**marked_fill(mark, "black")) for mark in marks]
        _place_legend(figure, patches, [*entries, *marks.values()])
    names = np.concatenate([[ticks[int(place)] for place in curve.x] for curve in series])
    return Drawing(figure, _columns(series, others, columns, names))


def draw_map(
    table: NDArray[np.float64],
    values: tuple[Sequence[float], Sequence[float]],
    keys: tuple[Key, Key],
    title: str,
    column: str,
) -> Drawing:
    """Draw a value by two keys, in cells of equal size: (n_lines, n_columns); NaN for missing ones."""
    columns, lines = values
    annotated = max(table.shape) <= _MOST_ANNOTATED
    of_title = 0.55 + CHARACTER * len(keys[1].title + not_to_scale(lines))  # which must not be longer than its axis
    figure = new_figure(min(max(0.34 * len(lines) + 0.7, of_title, 1.9), 3.4))
    axes = figure.subplots()
    axes.set_facecolor(BLANK)
    low, high = float(np.nanmin(table)), float(np.nanmax(table))
    mesh = axes.pcolormesh(
        np.arange(len(columns) + 1) - 0.5, np.arange(len(lines) + 1) - 0.5, table, cmap=_SCALE_MAP,
        vmin=low, vmax=high if high > low else low + 1e-3, rasterized=True,
    )  # fmt: skip
    if annotated:
        for (line, place), value in np.ndenumerate(table):
            if np.isfinite(value):
                bright = (value - low) / (high - low or 1.0) > 0.6
                axes.text(
                    place, line, f"{value:.3g}", ha="center", va="center", fontsize=6.5,
                    color="black" if bright else "white",
                )  # fmt: skip
    for axis, numbers, key in ((axes.xaxis, columns, keys[0]), (axes.yaxis, lines, keys[1])):
        names = [shown(number) for number in numbers]
        step = -(-len(names) // _MOST_ANNOTATED)
        room = (AXIS - _BAR) / len(names)
        while axis is axes.xaxis and step < len(names) and not fit(names[::step], step * room):
            step += 1
        axis.set_ticks(range(0, len(names), step), names[::step])
        axis.set_label_text(key.title + not_to_scale(numbers))
    axes.tick_params(length=0)
    figure.colorbar(mesh, ax=axes, pad=0.02).set_label(title)
    place = [(line, spot) for line in range(len(lines)) for spot in range(len(columns))]
    return Drawing(
        figure,
        {
            keys[0].column: np.array([columns[spot] * keys[0].naming.scale for _, spot in place]),
            keys[1].column: np.array([lines[line] * keys[1].naming.scale for line, _ in place]),
            column: table.ravel(),
        },
    )


def _figure_of_bars(ticks: Sequence[str], legend: float) -> Figure:
    """Make a figure of vertical bars with names below, rotated if they would touch, and only some of very many."""
    turned = not fit(ticks, AXIS / len(ticks))
    figure = new_figure(_HEIGHT + legend + (0.7 * CHARACTER * max(map(len, ticks)) if turned else 0.0))
    axes = figure.subplots()
    axes.set_xlim(-0.6, len(ticks) - 0.4)
    _name_categories(axes.xaxis, ticks, math.ceil(len(ticks) * _TURNED / AXIS) if turned else 1)
    if turned:
        for label in axes.get_xticklabels():
            label.set(rotation=35, ha="right")
    return figure


def _figure_of_lying_bars(ticks: Sequence[str], n_series: int, legend: float) -> Figure:
    """Make a figure of horizontal bars with names beside them, the first category at the top."""
    names = [textwrap.fill(name, _LINE_OF_NAME) for name in ticks]
    lines = max(max(name.count("\n") + 1 for name in names), 0.8 * n_series)
    figure = new_figure(0.6 + 0.9 * _LINE * (lines + 0.5) * len(ticks) + legend, 1.5 * WIDTH)
    axes = figure.subplots()
    axes.set_ylim(len(ticks) - 0.4, -0.6)
    _name_categories(axes.yaxis, names, 1)
    return figure


def _name_categories(axis: Axis, names: Sequence[str], step: int) -> None:
    axis.set_minor_locator(NullLocator())
    axis.set_tick_params(which="both", length=0)
    axis.set_ticks(range(0, len(names), step), list(names[::step]))


def _axes_of(axes: Axes, *, lying: bool) -> tuple[Axis, Axis]:
    """Return the axes of the categories and of the values."""
    return (axes.yaxis, axes.xaxis) if lying else (axes.xaxis, axes.yaxis)


def _draw_bars_of(axes: Axes, curve: Series, m: int, n_series: int, *, lying: bool, logarithmic: bool) -> None:
    """Draw the bars of one of several series, or its points on a logarithmic axis."""
    width = 0.8 / n_series if n_series > 1 else 0.6
    place = curve.x + (m - (n_series - 1) / 2) * width
    error = curve.half_width if np.any(np.isfinite(curve.half_width)) else None
    errors: dict[str, Any] = {"xerr" if lying else "yerr": error, "capsize": 2}
    if logarithmic:
        x, y = (curve.mean, place) if lying else (place, curve.mean)
        marker = _MARKERS[m % len(_MARKERS)]
        axes.errorbar(x, y, color=_COLOURS[m % len(_COLOURS)], marker=marker, markersize=5, ls="none", **errors)
        draw_marks(axes, x, y, curve.marks, marker, 5, _COLOURS[m % len(_COLOURS)])
    else:
        bars = (axes.barh if lying else axes.bar)(place, curve.mean, 0.92 * width, ecolor="black", **_fill(m), **errors)
        for bar, mark in zip(bars, [] if curve.marks is None else curve.marks, strict=curve.marks is not None):
            if mark:
                bar.set(**marked_fill(Mark(mark), _COLOURS[m % len(_COLOURS)]))


def _fill(m: int) -> dict[str, Any]:
    """Return colour and hatch of the bars of a series."""
    return {"facecolor": _COLOURS[m % len(_COLOURS)], "hatch": _HATCHES[m // len(_COLOURS) % len(_HATCHES)]}


def _columns(series: Sequence[Series], others: Sequence[Key], columns: Titles, x: NDArray) -> dict[str, ArrayLike]:
    counts = [len(curve.x) for curve in series]
    table: dict[str, ArrayLike] = {columns[0]: x}
    for key in others:
        labels = [key.labels[curve.row] for curve in series]
        number = all(isinstance(label, int | float) and not isinstance(label, bool) for label in labels)
        values = np.array(labels if number else [str(label) for label in labels])
        table[key.column if number else key.name] = np.repeat(values, counts)
    table[columns[1]] = np.concatenate([curve.mean for curve in series])
    if any(np.any(curve.count > 1) for curve in series):
        table["standard_deviation"] = np.concatenate([curve.deviation for curve in series])
        table["confidence_95"] = np.concatenate([curve.half_width for curve in series])
        table["n"] = np.concatenate([curve.count for curve in series])
    for mark, label in marks_of([curve.marks for curve in series]).items():
        marked = [np.zeros(len(curve.x)) if curve.marks is None else curve.marks == mark for curve in series]
        table[label.replace(" ", "_")] = np.concatenate(marked).astype(int)
    return table


def _scale_key(series: Sequence[Series], others: Sequence[Key]) -> Key | None:
    """Return the key for a colour scale, the one with most values, if the curves are too many for a legend."""
    numeric = [key for key in others if key.numeric]
    if len(series) <= len(_COLOURS) or not numeric:
        return None
    return max(numeric, key=lambda key: len({key.values[curve.row] for curve in series}))


def _norm(key: Key, series: Sequence[Series]) -> Normalize:
    values = np.unique([key.values[curve.row] for curve in series])
    return (LogNorm if even_in_log(values) else Normalize)(float(values[0]), float(values[-1]) * (1 + 1e-12))


def _colour_scale(figure: Figure, axes: Axes, norm: Normalize, key: Key) -> None:
    colours = mpl.colors.ListedColormap(mpl.colormaps[_SCALE_MAP](np.linspace(0, 0.92, 256)))
    bar = figure.colorbar(mpl.cm.ScalarMappable(norm, colours), ax=axes, pad=0.02)
    bar.set_label(key.title)
    if isinstance(norm, LogNorm):
        log_ticks(bar.ax.yaxis)


def _marker_size(kind: int, n_kinds: int) -> float:
    """Return the marker size in points, larger for the first curves, so that coinciding ones remain visible."""
    return 4.0 if n_kinds == 1 else 6.5 - 2.0 * kind / (n_kinds - 1)


def _wrapped(labels: Sequence[str]) -> list[str]:
    """Break the labels of a legend into lines that fit the width of the figure."""
    wrapped = []
    for label in labels:
        lines = [""]
        for part in label.split(", "):
            longer = f"{lines[-1]}, {part}" if lines[-1] else part
            if lines[-1] and _characters(longer) * CHARACTER > WIDTH:
                lines[-1] += ","
                lines.append(part)
            else:
                lines[-1] = longer
        wrapped.append("\n".join(lines))
    return wrapped


def _characters(label: str) -> int:
    """Return the number of characters of the longest line of an entry, including its marker."""
    seen = re.sub(r"\\[A-Za-z]+", "x", re.sub(r"\\mathrm|[${}_]", "", label))
    return max(map(len, seen.split("\n"))) + 5


def _legend_columns(labels: Sequence[str]) -> int:
    return max(1, min(len(labels), 4, int(WIDTH / (max(map(_characters, labels)) * CHARACTER))))


def _legend_height(labels: Sequence[str]) -> float:
    if not labels:
        return 0.0
    lines = -(-len(labels) // _legend_columns(labels))
    return _LINE * (lines + sum(label.count("\n") for label in labels))


def _legend(figure: Figure, labels: Sequence[str], *, coloured: bool, joined: bool, marks: Mapping[Mark, str]) -> None:
    handles = []
    for kind in range(len(labels)):
        n, turn = kind % len(_COLOURS), kind // len(_COLOURS)
        line = _LINES[(n + turn if coloured else kind) % len(_LINES)]
        size = _marker_size(kind, len(labels))
        colour = _COLOURS[n] if coloured else "black"
        handle = mpl.lines.Line2D([], [], color=colour, marker=_MARKERS[n], markersize=size, markeredgecolor="white")
        handle.set(linestyle=line if joined else "none", markeredgewidth=0.3)
        handles.append(handle)
    handles += [mpl.lines.Line2D([], [], **marked_marker(mark, "o", 4.5, "black")) for mark in marks]
    _place_legend(figure, handles, [*labels, *marks.values()])


def _place_legend(figure: Figure, handles: list, labels: Sequence[str]) -> None:
    if not labels:
        return
    figure.legend(
        handles, labels, loc="outside upper center", ncols=_legend_columns(labels), columnspacing=1.2,
        handletextpad=0.5, labelspacing=0.3, borderaxespad=0.2,
    )  # fmt: skip
