"""Drawing of the figures of a scan: curves with error bars, bars by category, maps, and marks of
plastic zones.

Curves and bars are drawn from a table with a row for each point. Its columns are ``curve``, the
number of the curve; ``row``, the row of a point of the curve in the scan; ``x``, the abscissa, or
for bars the position of the category; ``mean``, ``deviation`` and ``half_width`` of the 95 %
confidence interval of the mean (NaN for a single value) and the ``count`` of values; ``mark``, all
marks of the value (see `Mark`), 0 without a mark.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike, NDArray
from pandas import DataFrame

from granwave.analysis.figures.scales import not_to_scale, numbered_map, ticks_at
from granwave.analysis.figures.style import (
    BLANK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    WIDTH,
    Drawing,
    new_figure,
)
from granwave.analysis.measures.zone_size import LABELS, Mark
from granwave.analysis.scans.keys import VariedKey, shown

_COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY, "#E69F00", GREY, "black")
_MARKERS = "os^DvPX*"
_LINES = ("-", "--", ":", "-.", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)))
_HATCHES = ("", "////", "....", "xxxx", "----", "\\\\")
_SCALE_MAP = "viridis"
_HEIGHT = 2.3  # inches, without the legend
_LINE = 0.15  # inches, height of a line of names
_AXIS = 0.78 * WIDTH  # inches, length of a horizontal axis
_BAR = 0.24 * WIDTH  # inches, width of a colour scale
_CHARACTER = 0.066  # inches, approximate width of a character
_HANDLE = 5  # width of a mark in a legend, characters
_LINE_OF_NAME = 28  # longest line of a category's name, characters
_LINE_OF_LEGEND = 52  # longest line of a legend, characters
_CROSS = 2.0  # size of a cross, relative to the marker below it
_END_OF_BAR = 4.5  # size of a mark at the end of a bar, points
_ZERO_FONT = 6.5  # font size of the number of a bar without length, points
_MOST_MARKED = 60  # largest number of points of a curve with markers
_SPREAD = 30.0  # largest / smallest value above which an axis of values is logarithmic
_CROSSES = {Mark.END: "x", Mark.LAW: "+"}
_DECADE = 10.0  # largest / smallest value above which an axis may be logarithmic

Titles = tuple[str, str]


def draw_curves(
    points: DataFrame,
    x_title: str,
    y_title: str,
    others: Sequence[VariedKey],
    columns: Titles,
    *,
    scale: float = 1.0,
    joined: bool = True,
    chosen: bool = True,
) -> Drawing:
    """Draw curves with markers and a legend above, or a colour scale if there are many curves.

    Points of plastic zones that reach a boundary are open, half open if only a wave returned from a
    boundary. Values that the end of the run limits have a cross over their point, values that
    contacts beyond the range of the law determine an upright cross.

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
    along = _key_of_scale(points, others)
    norm = None if along is None else _norm(along, points)
    curves = []
    for _, part in points.groupby("curve"):
        row = part.row.iloc[0]
        label = ", ".join(key.text(row) for key in others if key is not along)
        curves.append((label, part))
    kinds = list(dict.fromkeys(label for label, _ in curves))
    figure = new_figure(_HEIGHT)
    axes = figure.subplots()
    handles = {}
    for label, part in curves:
        kind = kinds.index(label)
        look = _look(kind, len(kinds), joined=joined)
        handles[label] = Line2D([], [], **look)
        if along is not None and norm is not None:
            look["color"] = _shade(norm(along.values[part.row.iloc[0]]))
            look["linestyle"] = _LINES[kind % len(_LINES)] if joined else "none"
            handles[label] = Line2D([], [], **(look | {"color": "black"}))
        _draw_curve(axes, part, look, joined=joined)
    _scale_abscissae(axes, np.unique(points.x), chosen=chosen)
    _scale_values(axes, points)
    axes.set(xlabel=x_title, ylabel=y_title)
    if along is not None and norm is not None:
        colours = mpl.colors.ListedColormap(_shade(np.linspace(0, 1, 256)))
        bar = figure.colorbar(mpl.cm.ScalarMappable(norm, colours), ax=axes, pad=0.02)
        bar.set_label(along.title)
    if len(kinds) > len(_COLOURS) * len(_LINES) or kinds == [""]:
        handles = {}
    for mark, text in marks_of(points["mark"]).items():
        handles[text] = Line2D([], [], **marked_marker(mark, "o", 4.5, "black"))
    _legend(figure, handles)
    return Drawing(figure, _columns(points, others, columns, points.x.to_numpy() * scale))


def _key_of_scale(points: DataFrame, others: Sequence[VariedKey]) -> VariedKey | None:
    """Return the numeric key with most values, for the colour scale of too many curves for a
    legend; None for few curves, or without a numeric key.
    """
    if points.curve.nunique() <= len(_COLOURS):
        return None
    numeric = [key for key in others if key.numeric]
    return max(numeric, key=lambda key: len({key.values[row] for row in points.row}), default=None)


def _norm(key: VariedKey, points: DataFrame) -> Normalize:
    """Return the scale of colours over the values of a key."""
    values = np.unique([key.values[row] for row in points.row])
    scale = LogNorm if even_in_log(values) else Normalize
    return scale(float(values[0]), float(values[-1]) * (1 + 1e-12))


def _shade(place: Any) -> Any:
    """Return the colour at a position from 0 to 1 of the scale, without its palest part."""
    return mpl.colormaps[_SCALE_MAP](0.92 * place)


def _draw_curve(axes: Axes, part: DataFrame, look: dict[str, Any], *, joined: bool) -> None:
    """Draw a curve with error bars; a joined curve of many points has no markers."""
    line = dict(look)
    if joined and len(part) > _MOST_MARKED:
        line["marker"] = None
    axes.errorbar(part.x, part["mean"], **_errors(part, "yerr"), elinewidth=0.8, **line)
    style = (look["marker"], look["markersize"], look["color"])
    draw_marks(axes, part.x, part["mean"], part["mark"], *style)


def _scale_abscissae(axes: Axes, places: NDArray, *, chosen: bool) -> None:
    """Set the scale of abscissae: logarithmic for a large range; ticks at few chosen values,
    otherwise integer ticks for integers.
    """
    if even_in_log(places) or (not chosen and _is_wide(places)):
        axes.set_xscale("log")
    elif chosen and _have_room(places):
        ticks_at(axes.xaxis, places)
    elif chosen and np.all(places == np.rint(places)):
        axes.xaxis.set_major_locator(MaxNLocator("auto", integer=True))


def _have_room(places: NDArray) -> bool:
    """Return True for sorted values whose labels have room next to each other."""
    widest = max(len(f"{place:g}") for place in places)
    room = _CHARACTER * (widest + 1) / _AXIS
    steps = np.diff(places)
    return len(places) > 1 and bool(steps.min() > room * (places[-1] - places[0]))


def draw_bars(
    points: DataFrame,
    ticks: Sequence[str],
    x_title: str,
    y_title: str,
    others: Sequence[VariedKey],
    columns: Titles,
    *,
    merged: Sequence[VariedKey] = (),
) -> Drawing:
    """Draw bars by category, below each other, with a bar for each curve.

    On a logarithmic axis points are drawn instead. Bars have marks at their ends: an open circle
    for plastic zones that reach a boundary, half open if only a wave returned from a boundary, a
    cross if the end of the run limits the value, and an upright cross for contacts beyond the range
    of the law. A bar of zero is a tick with its number. The legend names keys without an effect
    (`merged`).
    """
    n_curves = points.curve.nunique()
    names = [textwrap.fill(name, _LINE_OF_NAME) for name in ticks]
    lines = max(max(name.count("\n") + 1 for name in names), 0.8 * n_curves)
    figure = new_figure(0.8 + _LINE * (lines + 0.5) * len(ticks), 1.5 * WIDTH)
    axes = figure.subplots()
    axes.set_yticks(range(len(names)), names)
    axes.tick_params(axis="y", which="both", length=0)
    axes.set(xlabel=y_title, ylabel=x_title, ylim=(len(ticks) - 0.4, -0.6))
    logarithmic = _is_wide(points["mean"].to_numpy())
    width = 0.8 / n_curves if n_curves > 1 else 0.6
    if logarithmic:
        axes.set_xscale("log")
    else:
        axes.set_xmargin(0.08)
    handles: dict[str, Any] = {}
    for m, (_, part) in enumerate(points.groupby("curve")):
        place = part.x + (m - (n_curves - 1) / 2) * width
        errors = _errors(part, "xerr")
        look = _look(m, 1, joined=False) | {"markersize": 5}
        fill = {"facecolor": look["color"], "hatch": _HATCHES[m % len(_HATCHES)]}
        if logarithmic:
            axes.errorbar(part["mean"], place, **look, **errors)
            draw_marks(axes, part["mean"], place, part["mark"], look["marker"], 5, look["color"])
        else:
            axes.barh(place, part["mean"], 0.92 * width, ecolor="black", **fill, **errors)
            draw_marks(axes, part["mean"], place, part["mark"], "o", _END_OF_BAR, "black")
            _name_zeros(axes, place[part["mean"] == 0], look["color"])
        label = ", ".join(key.text(part.row.iloc[0]) for key in others)
        if label:
            handles[label] = _handle(logarithmic, look, fill)
    for mark, text in marks_of(points["mark"]).items():
        handles[text] = Line2D([], [], **marked_marker(mark, "o", _END_OF_BAR, "black"))
    handles |= _names_of_merged(merged)
    _legend(figure, handles)
    categories = np.array([ticks[int(place)] for place in points.x])
    return Drawing(figure, _columns(points, others, columns, categories))


def _names_of_merged(keys: Sequence[VariedKey]) -> dict[str, Line2D]:
    """Return entries of a legend without a mark that name keys without an effect."""
    entries = {}
    for key in keys:
        n_values = len(set(key.values))
        how_many = "both" if n_values == 2 else f"all {n_values}"
        entries[f"the same at {how_many} values of {key.words}"] = Line2D([], [], linestyle="none")
    return entries


def _name_zeros(axes: Axes, places: Iterable[float], colour: Any) -> None:
    """Draw a tick and the number 0 in place of bars without length."""
    for place in places:
        axes.plot(0, place, "|", color=colour, markersize=_END_OF_BAR + 2, clip_on=False)
        axes.annotate(
            "0", (0, place), (6, 0), textcoords="offset points", va="center", fontsize=_ZERO_FONT
        )


def _handle(as_marker: bool, look: dict[str, Any], fill: dict[str, Any]) -> Any:
    """Return the entry of a legend: a marker, or a filled patch."""
    return Line2D([], [], **look) if as_marker else mpl.patches.Patch(**fill)


def draw_map(
    table: NDArray[np.float64],
    values: tuple[Sequence[float], Sequence[float]],
    keys: tuple[VariedKey, VariedKey],
    title: str,
    column: str,
) -> Drawing:
    """Draw values over two keys in cells of equal size.

    Parameters
    ----------
    table
        Values, NaN for missing points: (n_lines, n_columns).
    values
        Values of both keys: (n_columns,) and (n_lines,).
    keys
        Keys of the columns and of the lines.
    """
    columns, lines = values
    key_of_columns, key_of_lines = keys
    x_title = key_of_columns.title + not_to_scale(columns)
    y_title = key_of_lines.title + not_to_scale(lines)
    height_of_title = 0.55 + _CHARACTER * len(y_title)
    figure = new_figure(min(max(0.34 * len(lines) + 0.7, height_of_title, 1.9), 3.4))
    axes = figure.subplots()
    low = float(np.nanmin(table))
    high = float(np.nanmax(table))
    names = [[shown(column) for column in columns], [shown(line) for line in lines]]
    room = int((_AXIS - _BAR) / (_CHARACTER * (max(map(len, names[0])) + 1)))
    axes.set_facecolor(BLANK)
    numbered_map(axes, table, (low, high if high > low else low + 1e-3), title, names, most=room)
    axes.set(xlabel=x_title, ylabel=y_title)
    x, y = np.meshgrid(columns, lines)
    data = {
        key_of_columns.column: x.ravel() * key_of_columns.naming.scale,
        key_of_lines.column: y.ravel() * key_of_lines.naming.scale,
        column: table.ravel(),
    }
    return Drawing(figure, data)


def even_in_log(values: NDArray[np.float64]) -> bool:
    """Return True for sorted values over more than a decade whose logarithms are spaced more evenly
    than the values.
    """
    if len(values) < 2 or values[0] <= 0 or values[-1] < _DECADE * values[0]:
        return False
    ratios = np.diff(np.log(values))
    steps = np.diff(values)
    if len(values) == 2:
        return True
    return bool(np.std(ratios) / np.mean(ratios) < np.std(steps) / np.mean(steps))


def marks_of(marks: Iterable[int]) -> dict[Mark, str]:
    """Return the marks that are drawn for points with these marks, with their labels."""
    points = list(marks)
    return {mark: label for mark, label in LABELS.items() if any(_drawn(points, mark))}


def _drawn(marks: Iterable[int], mark: Mark) -> list[bool]:
    """Return True for each point at which a mark is drawn: not a half-open marker where the point
    is open.
    """
    hiding = Mark.CUT if mark is Mark.WAVE else Mark.NONE
    return [bool(of_point & mark) and not of_point & hiding for of_point in marks]


def draw_marks(
    axes: Axes, x: ArrayLike, y: ArrayLike, marks: ArrayLike, marker: str, size: float, colour: Any
) -> None:
    """Draw the marked points over existing ones."""
    for mark in LABELS:
        chosen = np.array(_drawn(np.asarray(marks).tolist(), mark), dtype=bool)
        if chosen.any():
            look = marked_marker(mark, marker, size, colour)
            axes.plot(np.asarray(x)[chosen], np.asarray(y)[chosen], zorder=3, **look)


def marked_marker(mark: Mark, marker: str, size: float, colour: Any) -> dict[str, Any]:
    """Return the style of a marked point."""
    look = {
        "marker": marker,
        "markersize": size,
        "color": colour,
        "markeredgewidth": 0.9,
        "linestyle": "none",
    }
    if mark is Mark.CUT:
        return look | {"markerfacecolor": "white"}
    if mark in _CROSSES:
        marker = _CROSSES[mark]
        return look | {"marker": marker, "markersize": _CROSS * size, "markeredgewidth": 1.1}
    return look | {"fillstyle": "left", "markerfacecoloralt": "white"}


def _look(kind: int, n_kinds: int, *, joined: bool) -> dict[str, Any]:
    """Return the style of a curve; earlier curves have larger markers, so that coinciding points
    remain visible.
    """
    n = kind % len(_COLOURS)
    turn = kind // len(_COLOURS)
    return {
        "color": _COLOURS[n],
        "linestyle": _LINES[(n + turn) % len(_LINES)] if joined else "none",
        "marker": _MARKERS[n],
        "markersize": 4.0 if n_kinds == 1 else 6.5 - 2.0 * kind / (n_kinds - 1),
        "markeredgewidth": 0.3,
        "markeredgecolor": "white",
    }


def _errors(part: DataFrame, name: str) -> dict[str, Any]:
    return {name: part.half_width if part.half_width.notna().any() else None, "capsize": 2}


def _is_wide(values: NDArray[np.float64], spread: float = _SPREAD) -> bool:
    """Return True for positive values with a range too large for a linear axis.

    Parameters
    ----------
    spread
        Largest value divided by the smallest one on a linear axis.
    """
    return bool(values.min() > 0 and values.max() > spread * values.min())


def _scale_values(axes: Axes, points: DataFrame) -> None:
    """Set the scale of values: logarithmic for a large range, or for more than a decade against
    logarithmic abscissae, whose powers are then straight lines; from 0 if 0 is close, and without
    enlarging noise.
    """
    widths = points.half_width.fillna(0.0)
    low = float((points["mean"] - widths).min())
    high = float((points["mean"] + widths).max())
    is_log = axes.get_xscale() == "log"
    if _is_wide(points["mean"].to_numpy(), _DECADE if is_log else _SPREAD):
        axes.set_yscale("log")
    elif 0 <= low < 0.5 * high:
        axes.set_ylim(0, 1.08 * high)
    elif high - low < 0.02 * abs(high):
        middle = 0.5 * (low + high)
        axes.set_ylim(middle - 0.1 * abs(high), middle + 0.1 * abs(high))


def _columns(
    points: DataFrame, others: Sequence[VariedKey], columns: Titles, x: NDArray
) -> dict[str, ArrayLike]:
    """Return the columns of data: abscissa, other keys, mean with its deviations, and marks."""
    abscissa, ordinate = columns
    table: dict[str, ArrayLike] = {abscissa: x}
    for key in others:
        labels = [key.labels[row] for row in points.row]
        if all(isinstance(label, int | float) and not isinstance(label, bool) for label in labels):
            table[key.column] = np.array(labels)
        else:
            table[key.name] = np.array(list(map(str, labels)))
    table[ordinate] = points["mean"].to_numpy()
    if (points["count"] > 1).any():
        names = {"standard_deviation": "deviation", "confidence_95": "half_width", "n": "count"}
        table |= {name: points[column].to_numpy() for name, column in names.items()}
    for mark, label in LABELS.items():
        has_mark = (points["mark"] & int(mark)) > 0
        if has_mark.any():
            table[label.replace(" ", "_")] = has_mark.astype(int).to_numpy()
    return table


def _legend(figure: Figure, entries: Mapping[str, Any]) -> None:
    """Put a legend above, with as many columns as fit, at most 4; the figure grows by the height of
    the legend.
    """
    if not entries:
        return
    labels = [textwrap.fill(label, _LINE_OF_LEGEND) for label in entries]
    longest = max(map(len, "\n".join(labels).split("\n")))
    width = _CHARACTER * (longest + _HANDLE)  # width of a column
    fitting = int(max(figure.get_figwidth() // width, 1))
    legend = figure.legend(
        list(entries.values()),
        labels,
        loc="outside upper center",
        columnspacing=1.2,
        handletextpad=0.5,
        labelspacing=0.3,
        borderaxespad=0.2,
        ncols=min(fitting, len(labels), 4),
    )
    figure.set_figheight(figure.get_figheight() + legend.get_window_extent().height / figure.dpi)
