"""How the figures of a scan are drawn: curves with error bars, bars by category, and maps."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullFormatter, NullLocator
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.figure_style import BLANK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, WIDTH, Drawing, new_figure
from granwave.analysis.scan_keys import Key

YELLOW = "#E69F00"
_COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY, YELLOW, GREY, "black")
_MARKERS = "os^DvPX*"
_LINES = ("-", "--", ":", "-.", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)))
_SCALE_MAP = "viridis"
_SPREAD = 1.5  # decades from which on an axis of values is logarithmic
_DECADE = 10.0
_HEIGHT = 2.3  # inches, without the legend
_LINE = 0.17  # inches, of a legend
_CHARACTER = 0.062  # inches, about
_MOST_ANNOTATED = 8  # columns and lines of a map with its numbers in it
_MOST_MARKED = 60  # points of a curve that are marked one by one
_CLOSE = 0.16  # decades between labelled ticks
_EDGE = 1.02  # room beyond the scale's ends

Titles = tuple[str, str]


@dataclasses.dataclass(frozen=True, eq=False)
class Series:
    """One curve.

    Attributes
    ----------
    row
        Of one of its points in the scan.
    x, mean, deviation, half_width, count
        By abscissa: (n,). The deviation of the values, and half the width of the 95 % confidence interval of their
        mean, are NaN where there is one value only.
    """

    label: str
    row: int
    x: NDArray[np.float64]
    mean: NDArray[np.float64]
    deviation: NDArray[np.float64]
    half_width: NDArray[np.float64]
    count: NDArray[np.int64]


def draw_curves(
    series: Sequence[Series],
    x_title: str,
    y_title: str,
    others: Sequence[Key],
    columns: Titles,
    *,
    scale: float = 1.0,
    joined: bool = True,
) -> Drawing:
    """Curves with markers; a legend above them, or a colour scale when they are many.

    Parameters
    ----------
    others
        The keys that tell the curves apart.
    columns
        Of the CSV file: abscissa and value.
    scale
        SI of one unit of the abscissa.
    joined
        Join the points of a curve.
    """
    along = _scale_key(series, others)
    rest = [key for key in others if key is not along]
    labels = [", ".join(key.text(curve.row) for key in rest) for curve in series]
    kinds = list(dict.fromkeys(labels))
    shown = kinds if len(kinds) <= len(_COLOURS) * len(_LINES) and kinds != [""] else []
    figure = new_figure(_HEIGHT + _legend_height(shown))
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
    _scale_axis(axes, np.concatenate([curve.x for curve in series]), even=joined)
    _value_axis(axes, series)
    axes.set_xlabel(x_title)
    axes.set_ylabel(y_title)
    if along is not None and norm is not None:
        _colour_scale(figure, axes, norm, along)
    _legend(figure, shown, coloured=along is None, joined=joined)
    return Drawing(figure, _columns(series, others, columns, np.concatenate([curve.x for curve in series]) * scale))


def draw_bars(
    series: Sequence[Series], ticks: Sequence[str], x_title: str, y_title: str, others: Sequence[Key], columns: Titles
) -> Drawing:
    """Bars by category (the abscissa of `Series` counts them), side by side for each series; points on a log axis."""
    shown = [curve.label for curve in series] if others else []
    rotated = sum(len(tick) + 1 for tick in ticks) * _CHARACTER > 0.8 * WIDTH
    longest = max(map(len, ticks)) if rotated else 0
    figure = new_figure(_HEIGHT + _legend_height(shown) + 0.7 * _CHARACTER * longest)
    axes = figure.subplots()
    values = np.concatenate([curve.mean for curve in series])
    logarithmic = _is_wide(values)
    width = 0.8 / len(series) if len(series) > 1 else 0.6
    for m, curve in enumerate(series):
        place = curve.x + (m - (len(series) - 1) / 2) * width
        colour, marker = _COLOURS[m % len(_COLOURS)], _MARKERS[m % len(_MARKERS)]
        error = curve.half_width if np.any(np.isfinite(curve.half_width)) else None
        if logarithmic:
            axes.errorbar(place, curve.mean, error, color=colour, marker=marker, markersize=5, ls="none", capsize=2)
        else:
            hatch = ("", "////", "....")[m // len(_COLOURS) % 3]
            axes.bar(place, curve.mean, 0.92 * width, yerr=error, color=colour, hatch=hatch, capsize=2, ecolor="black")
    axes.set_xlim(-0.6, len(ticks) - 0.4)
    axes.xaxis.set_minor_locator(NullLocator())
    axes.tick_params(axis="x", which="both", length=0)
    axes.set_xticks(range(len(ticks)), ticks)
    if rotated:
        for label in axes.get_xticklabels():
            label.set(rotation=35, ha="right")
    if logarithmic:
        axes.set_yscale("log")
        _log_ticks(axes.yaxis)
    else:
        axes.margins(y=0.08)
    axes.set_xlabel(x_title)
    axes.set_ylabel(y_title)
    if logarithmic:
        _legend(figure, shown, coloured=True, joined=False)
    elif shown:
        _place_legend(figure, [mpl.patches.Patch(color=_COLOURS[m % len(_COLOURS)]) for m in range(len(shown))], shown)
    names = np.concatenate([[ticks[int(place)] for place in curve.x] for curve in series])
    return Drawing(figure, _columns(series, others, columns, names))


def draw_map(
    table: NDArray[np.float64],
    values: tuple[Sequence[float], Sequence[float]],
    keys: tuple[Key, Key],
    title: str,
    column: str,
) -> Drawing:
    """A value by two keys, in cells of one size: (n_lines, n_columns); NaN where there is none."""
    columns, lines = values
    annotated = max(table.shape) <= _MOST_ANNOTATED
    figure = new_figure(min(max(0.34 * len(lines) + 0.7, 1.9), 3.4))
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
        step = -(-len(numbers) // _MOST_ANNOTATED)
        axis.set_ticks(range(0, len(numbers), step), [f"{number:.4g}" for number in numbers[::step]])
        axis.set_label_text(key.title)
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
    return table


def _scale_key(series: Sequence[Series], others: Sequence[Key]) -> Key | None:
    """The key that colours stand for when the curves are too many for a legend: the one with most values."""
    numeric = [key for key in others if key.numeric]
    if len(series) <= len(_COLOURS) or not numeric:
        return None
    return max(numeric, key=lambda key: len({key.values[curve.row] for curve in series}))


def _norm(key: Key, series: Sequence[Series]) -> Normalize:
    values = np.unique([key.values[curve.row] for curve in series])
    return (LogNorm if _even_in_log(values) else Normalize)(float(values[0]), float(values[-1]) * (1 + 1e-12))


def _colour_scale(figure: Figure, axes: Axes, norm: Normalize, key: Key) -> None:
    colours = mpl.colors.ListedColormap(mpl.colormaps[_SCALE_MAP](np.linspace(0, 0.92, 256)))
    bar = figure.colorbar(mpl.cm.ScalarMappable(norm, colours), ax=axes, pad=0.02)
    bar.set_label(key.title)
    if isinstance(norm, LogNorm):
        _log_ticks(bar.ax.yaxis)


def _even_in_log(values: NDArray[np.float64]) -> bool:
    """Sorted values over more than a decade, whose ratios are more alike than their differences."""
    if len(values) < 2 or values[0] <= 0 or values[-1] < _DECADE * values[0]:
        return False
    ratios, steps = np.diff(np.log(values)), np.diff(values)
    return len(values) == 2 or float(np.std(ratios) / np.mean(ratios)) < float(np.std(steps) / np.mean(steps))


def _is_wide(values: NDArray[np.float64]) -> bool:
    return bool(values.min() > 0 and values.max() > 10**_SPREAD * values.min())


def _scale_axis(axes: Axes, values: NDArray[np.float64], *, even: bool) -> None:
    """Log where the values ask for it; few values are labelled themselves."""
    axis, places = axes.xaxis, np.unique(values)
    if _even_in_log(places) or (not even and _is_wide(places)):
        axes.set_xscale("log")
        low, high = places[0], places[-1]
        room = (high / low) ** 0.05 * _EDGE
        axes.set_xlim(low / room, high * room)
        steps = np.diff(np.log10(places))
        if even and len(places) <= 8 and np.all(steps > _CLOSE * 0.5 * np.log10(high / low)):
            axis.set_major_locator(FixedLocator(places.tolist()))
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.6g}"))
            axis.set_minor_locator(NullLocator())
        else:
            _log_ticks(axis)
    elif np.all(places == np.rint(places)) and len(places) <= 8 and np.ptp(places) < 40:
        apart = np.diff(places).min() / np.ptp(places) if len(places) > 1 else 1.0
        if apart > 0.08:
            axis.set_major_locator(FixedLocator(places.tolist()))


def _value_axis(axes: Axes, series: Sequence[Series]) -> None:
    values = np.concatenate([curve.mean for curve in series])
    if _is_wide(values):
        axes.set_yscale("log")
        _log_ticks(axes.yaxis)
        return
    widths = np.nan_to_num(np.concatenate([curve.half_width for curve in series]))
    low, high = float(np.min(values - widths)), float(np.max(values + widths))
    if low >= 0 and low < 0.5 * high:
        axes.set_ylim(0, 1.08 * high)
    elif high - low < 0.02 * abs(high):  # noise is not to look like a trend
        middle = 0.5 * (low + high)
        axes.set_ylim(middle - 0.1 * abs(high), middle + 0.1 * abs(high))


def _log_ticks(axis: Axis) -> None:
    """Plain numbers at 1, 2 and 5 over little more than a decade, at the decades beyond."""
    low, high = sorted(axis.get_view_interval())
    decades = np.log10(high / low)
    if decades < 2.2:
        axis.set_major_locator(LogLocator(10, subs=(1.0, 2.0, 5.0)))
        if high < 1e5 and low > 1e-4:
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.6g}"))
        axis.set_minor_formatter(NullFormatter())


def _marker_size(kind: int, n_kinds: int) -> float:
    """Points; curves that lie on each other stay visible, the first ones below being larger."""
    return 4.0 if n_kinds == 1 else 6.5 - 2.0 * kind / (n_kinds - 1)


def _legend_columns(labels: Sequence[str]) -> int:
    longest = max(len(label.replace(r"\mathrm", "").replace("$", "")) for label in labels) + 5
    return max(1, min(len(labels), 4, int(WIDTH / (longest * _CHARACTER))))


def _legend_height(labels: Sequence[str]) -> float:
    return _LINE * -(-len(labels) // _legend_columns(labels)) if labels else 0.0


def _legend(figure: Figure, labels: Sequence[str], *, coloured: bool, joined: bool) -> None:
    handles = []
    for kind in range(len(labels)):
        n, turn = kind % len(_COLOURS), kind // len(_COLOURS)
        line = _LINES[(n + turn if coloured else kind) % len(_LINES)]
        size = _marker_size(kind, len(labels))
        colour = _COLOURS[n] if coloured else "black"
        handle = mpl.lines.Line2D([], [], color=colour, marker=_MARKERS[n], markersize=size, markeredgecolor="white")
        handle.set(linestyle=line if joined else "none", markeredgewidth=0.3)
        handles.append(handle)
    if handles:
        _place_legend(figure, handles, labels)


def _place_legend(figure: Figure, handles: list, labels: Sequence[str]) -> None:
    figure.legend(
        handles, labels, loc="outside upper center", ncols=_legend_columns(labels), columnspacing=1.2,
        handletextpad=0.5, labelspacing=0.3, borderaxespad=0.2,
    )  # fmt: skip
