"""Drawing of the figures of a scan: curves with error bars, bars by category, maps, and marks of
plastic zones.

Curves and bars are drawn of a table with a row for each point: ``curve``, number of its curve;
``row`` of one of the curve's points in the scan; ``x``, abscissa, of bars the place of the
category; ``mean``, ``deviation``, ``half_width`` of the 95 % confidence interval of the mean and
``count`` of its values, deviation and half-width NaN for a single one; ``mark``, `Mark` of a
plastic zone, 0 for other quantities.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize, to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike, NDArray
from pandas import DataFrame

from granwave.analysis.figures.scales import not_to_scale, numbered_map
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
_HATCHES = ("", "////", "....")
_SCALE_MAP = "viridis"
_HEIGHT = 2.3  # inches, without the legend
_LINE = 0.15  # inches, height of a line of names
_AXIS = 0.78 * WIDTH  # inches, length of a horizontal axis
_BAR = 0.24 * WIDTH  # inches, width of a colour scale
_CHARACTER = 0.066  # inches, approximate width of a character
_HANDLE = 5  # characters that a mark in a legend takes
# characters
_LINE_OF_NAME = 28
_LINE_OF_LEGEND = 52
_MOST_MARKED = 60  # points of a curve with markers
# largest over smallest value from which an axis of values, of abscissae is logarithmic
_SPREAD = 30.0
_DECADE = 10.0

Titles = tuple[str, str]


def draw_curves(
    found: DataFrame,
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
    numeric = (
        [key for key in others if key.numeric] if found.curve.nunique() > len(_COLOURS) else []
    )
    along = max(numeric, key=lambda key: len({key.values[row] for row in found.row}), default=None)
    if along:  # too many curves for a legend: a colour scale of the key with most values
        shades = np.unique([along.values[row] for row in found.row])
        norm = (LogNorm if even_in_log(shades) else Normalize)(
            float(shades[0]), float(shades[-1]) * (1 + 1e-12)
        )
    curves = [
        (", ".join(key.text(part.row.iloc[0]) for key in others if key is not along), part)
        for _, part in found.groupby("curve")
    ]
    kinds = list(dict.fromkeys(label for label, _ in curves))
    figure = new_figure(_HEIGHT)
    axes = figure.subplots()
    handles = {}
    for label, part in curves:
        kind = kinds.index(label)
        look = _look(kind, len(kinds), joined=joined)
        if along:
            colour = mpl.colormaps[_SCALE_MAP](0.92 * norm(along.values[part.row.iloc[0]]))
            look |= {"color": colour, "linestyle": _LINES[kind % len(_LINES)] if joined else "none"}
        handles[label] = Line2D([], [], **(look | ({"color": "black"} if along else {})))
        few = {} if len(part) <= _MOST_MARKED or not joined else {"marker": None}
        axes.errorbar(part.x, part["mean"], **_errors(part, "yerr"), elinewidth=0.8, **(look | few))
        draw_marks(
            axes,
            part.x,
            part["mean"],
            part["mark"],
            look["marker"],
            look["markersize"],
            look["color"],
        )
    places = np.unique(found.x)
    if even_in_log(places) or (not chosen and _is_wide(places)):
        axes.set_xscale("log")
    elif chosen and np.all(places == np.rint(places)):
        axes.xaxis.set_major_locator(MaxNLocator("auto", integer=True))
    _scale_values(axes, found)
    axes.set(xlabel=x_title, ylabel=y_title)
    if along:
        colours = mpl.colors.ListedColormap(mpl.colormaps[_SCALE_MAP](np.linspace(0, 0.92, 256)))
        figure.colorbar(mpl.cm.ScalarMappable(norm, colours), ax=axes, pad=0.02).set_label(
            along.title
        )
    shown_kinds = handles if len(kinds) <= len(_COLOURS) * len(_LINES) and kinds != [""] else {}
    marks = {
        text: Line2D([], [], **marked_marker(mark, "o", 4.5, "black"))
        for mark, text in marks_of(found["mark"]).items()
    }
    _legend(figure, shown_kinds | marks)
    return Drawing(figure, _columns(found, others, columns, found.x.to_numpy() * scale))


def draw_bars(
    found: DataFrame,
    ticks: Sequence[str],
    x_title: str,
    y_title: str,
    others: Sequence[VariedKey],
    columns: Titles,
) -> Drawing:
    """Draw the bars of each curve by category, one below the other.

    On a logarithmic axis points are drawn instead. Bars of plastic zones that reach a boundary are
    open, pale if a wave returned from one.
    """
    n_curves = found.curve.nunique()
    names = [textwrap.fill(name, _LINE_OF_NAME) for name in ticks]
    lines = max(max(name.count("\n") + 1 for name in names), 0.8 * n_curves)
    figure = new_figure(0.8 + _LINE * (lines + 0.5) * len(ticks), 1.5 * WIDTH)
    axes = figure.subplots()
    axes.set_yticks(range(len(names)), names)
    axes.tick_params(axis="y", which="both", length=0)
    axes.set(xlabel=y_title, ylabel=x_title, ylim=(len(ticks) - 0.4, -0.6))
    logarithmic = _is_wide(found["mean"].to_numpy())
    width = 0.8 / n_curves if n_curves > 1 else 0.6
    axes.set(**({"xscale": "log"} if logarithmic else {"xmargin": 0.08}))
    handles: dict[str, Any] = {}
    for m, (_, part) in enumerate(found.groupby("curve")):
        place = part.x + (m - (n_curves - 1) / 2) * width
        errors = _errors(part, "xerr")
        look = _look(m, 1, joined=False) | {"markersize": 5}
        fill = {"facecolor": look["color"], "hatch": _HATCHES[m // len(_COLOURS) % len(_HATCHES)]}
        if logarithmic:
            axes.errorbar(part["mean"], place, **look, **errors)
            draw_marks(axes, part["mean"], place, part["mark"], look["marker"], 5, look["color"])
        else:
            bars = axes.barh(place, part["mean"], 0.92 * width, ecolor="black", **fill, **errors)
            for bar, mark in zip(bars, part["mark"], strict=True):
                bar.set(**(_marked_fill(Mark(mark), look["color"]) if mark else {}))
        label = ", ".join(key.text(part.row.iloc[0]) for key in others)
        handles |= (
            {label: Line2D([], [], **look) if logarithmic else mpl.patches.Patch(**fill)}
            if label
            else {}
        )
    for mark, text in marks_of(found["mark"]).items():
        open_marker = Line2D([], [], **marked_marker(mark, "o", 4.5, "black"))
        handles[text] = (
            open_marker if logarithmic else mpl.patches.Patch(**_marked_fill(mark, "black"))
        )
    _legend(figure, handles)
    return Drawing(
        figure, _columns(found, others, columns, np.array([ticks[int(place)] for place in found.x]))
    )


def draw_map(
    table: NDArray[np.float64],
    values: tuple[Sequence[float], Sequence[float]],
    keys: tuple[VariedKey, VariedKey],
    title: str,
    column: str,
) -> Drawing:
    """Draw a value by two keys, in cells of equal size: (n_lines, n_columns); NaN for missing ones."""
    columns, lines = values
    of_title = 0.55 + _CHARACTER * len(
        keys[1].title + not_to_scale(lines)
    )  # which must not be longer than its axis
    figure = new_figure(min(max(0.34 * len(lines) + 0.7, of_title, 1.9), 3.4))
    axes = figure.subplots()
    low = float(np.nanmin(table))
    high = float(np.nanmax(table))
    names = [[shown(number) for number in numbers] for numbers in values]
    room = int((_AXIS - _BAR) / (_CHARACTER * (max(map(len, names[0])) + 1)))
    axes.set_facecolor(BLANK)
    numbered_map(axes, table, (low, high if high > low else low + 1e-3), title, names, most=room)
    axes.set(
        xlabel=keys[0].title + not_to_scale(columns), ylabel=keys[1].title + not_to_scale(lines)
    )
    x, y = np.meshgrid(columns, lines)
    return Drawing(
        figure,
        {
            keys[0].column: x.ravel() * keys[0].naming.scale,
            keys[1].column: y.ravel() * keys[1].naming.scale,
            column: table.ravel(),
        },
    )


def even_in_log(values: NDArray[np.float64]) -> bool:
    """Return True for sorted values over more than a decade that are spaced more evenly in their
    logarithm.
    """
    if len(values) < 2 or values[0] <= 0 or values[-1] < _DECADE * values[0]:
        return False
    ratios = np.diff(np.log(values))
    steps = np.diff(values)
    return len(values) == 2 or float(np.std(ratios) / np.mean(ratios)) < float(
        np.std(steps) / np.mean(steps)
    )


def marks_of(marks: Iterable[int]) -> dict[Mark, str]:
    """Return the marks that occur, with their labels."""
    there = set(marks)
    return {mark: label for mark, label in LABELS.items() if mark in there}


def draw_marks(
    axes: Axes, x: ArrayLike, y: ArrayLike, marks: ArrayLike, marker: str, size: float, colour: Any
) -> None:
    """Draw the marked points over existing ones."""
    for mark in LABELS:
        chosen = np.asarray(marks) == mark
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
    return look | {"fillstyle": "left", "markerfacecoloralt": "white"}


def _marked_fill(mark: Mark, colour: str) -> dict[str, Any]:
    return {
        "facecolor": "white" if mark is Mark.CUT else to_rgba(colour, 0.35),
        "edgecolor": colour,
        "linewidth": 1.0,
    }


def _look(kind: int, n_kinds: int, *, joined: bool) -> dict[str, Any]:
    """Return the style of a curve; markers are larger for the first, so that coinciding ones remain
    visible.
    """
    n = kind % len(_COLOURS)
    turn = kind // len(_COLOURS)
    return {
        "color": _COLOURS[n], "linestyle": _LINES[(n + turn) % len(_LINES)] if joined else "none",
        "marker": _MARKERS[n], "markersize": 4.0 if n_kinds == 1 else 6.5 - 2.0 * kind / (n_kinds - 1),
        "markeredgewidth": 0.3, "markeredgecolor": "white",
    }  # fmt: skip


def _errors(part: DataFrame, name: str) -> dict[str, Any]:
    return {name: part.half_width if part.half_width.notna().any() else None, "capsize": 2}


def _is_wide(values: NDArray[np.float64]) -> bool:
    """Return True for positive values with a range too large for a linear axis."""
    return bool(values.min() > 0 and values.max() > _SPREAD * values.min())


def _scale_values(axes: Axes, found: DataFrame) -> None:
    """Set the scale of values: logarithmic for a large range, else from 0 if near it, never
    enlarging mere noise.
    """
    widths = found.half_width.fillna(0.0)
    low = float((found["mean"] - widths).min())
    high = float((found["mean"] + widths).max())
    if _is_wide(found["mean"].to_numpy()):
        axes.set_yscale("log")
    elif 0 <= low < 0.5 * high:
        axes.set_ylim(0, 1.08 * high)
    elif high - low < 0.02 * abs(high):
        middle = 0.5 * (low + high)
        axes.set_ylim(middle - 0.1 * abs(high), middle + 0.1 * abs(high))


def _columns(
    found: DataFrame, others: Sequence[VariedKey], columns: Titles, x: NDArray
) -> dict[str, ArrayLike]:
    table: dict[str, ArrayLike] = {columns[0]: x}
    for key in others:
        labels = [key.labels[row] for row in found.row]
        number = all(
            isinstance(label, int | float) and not isinstance(label, bool) for label in labels
        )
        table[key.column if number else key.name] = np.array(
            labels if number else [str(label) for label in labels]
        )
    table[columns[1]] = found["mean"].to_numpy()
    if (found["count"] > 1).any():
        names = {"standard_deviation": "deviation", "confidence_95": "half_width", "n": "count"}
        table |= {name: found[column].to_numpy() for name, column in names.items()}
    marks = {
        label.replace(" ", "_"): (found["mark"] == mark).astype(int)
        for mark, label in marks_of(found["mark"]).items()
    }
    return table | {name: column.to_numpy() for name, column in marks.items()}


def _legend(figure: Figure, entries: Mapping[str, Any]) -> None:
    """Put a legend above, with as many columns as there is room for; the figure grows by its
    height.
    """
    if not entries:
        return
    labels = [textwrap.fill(label, _LINE_OF_LEGEND) for label in entries]
    widest = _CHARACTER * (
        max(len(line) for label in labels for line in label.split("\n")) + _HANDLE
    )
    legend = figure.legend(
        list(entries.values()), labels, loc="outside upper center", columnspacing=1.2, handletextpad=0.5,
        labelspacing=0.3, borderaxespad=0.2, ncols=min(int(max(figure.get_figwidth() // widest, 1)), len(labels), 4),
    )  # fmt: skip
    figure.set_figheight(figure.get_figheight() + legend.get_window_extent().height / figure.dpi)
