"""Parts that figures of curves share: colours and marks by number, panels, ticks, maps in place and time."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import QuadMesh
from matplotlib.ticker import FixedLocator, LogLocator, NullFormatter, NullLocator
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, WIDTH, new_figure

COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY, GREY)
MARKS = "os^Dv"
DOUBLE = 7.0  # inches: two columns of a journal
_WIDE = 10.0  # largest over smallest value from which on an axis is logarithmic


def panels(height: float, columns: int = 1, rows: int = 1, *, width: float = 0.0, **options: Any) -> tuple[Any, ...]:
    """A new figure and its axes, row by row.

    Parameters
    ----------
    height, width
        Inches; the width is that of one column of a journal for one panel beside another, else of two.
    options
        Of ``Figure.subplots``.
    """
    figure = new_figure(height, width or (DOUBLE if columns > 1 else WIDTH))
    return figure, *figure.subplots(rows, columns, squeeze=False, **options).flat


def label(axes: Axes, x: str = "", y: str = "", *, log: str = "", **settings: Any) -> None:
    """Label axes, and set what else they have.

    Parameters
    ----------
    log
        Names of logarithmic axes: ``x``, ``y`` or ``xy``.
    settings
        Of ``Axes.set``, such as ``xlim`` and ``title``.
    """
    scales = {f"{name}scale": "log" for name in log}
    axes.set(**({"xlabel": x} if x else {}), **({"ylabel": y} if y else {}), **scales, **settings)


def few_ticks(
    axis: Axis, ticks: Iterable[float] | None = None, *, subs: Sequence[float] = (), form: str = "{x:.3g}"
) -> None:
    """Plain numbers at a logarithmic axis that spans little.

    Parameters
    ----------
    ticks
        Where they stand; None: at ``subs`` times the powers of ten.
    form
        Of their numbers ``x``.
    """
    axis.set_major_locator(LogLocator(subs=subs) if ticks is None else FixedLocator(list(ticks)))
    axis.set_major_formatter(form)
    axis.set_minor_locator(NullLocator())


def map_of(axes: Axes, x: ArrayLike, y: ArrayLike, values: NDArray[np.float64], **options: Any) -> QuadMesh:
    """Values (n_y, n_x) by colour, one cell around each point."""
    return axes.pcolormesh(x, y, values, rasterized=True, shading="nearest", **options)


def numbered_map(axes: Axes, values: NDArray[np.float64], top: float, title: str) -> None:
    """Values (n_y, n_x), none negative, by colour and as numbers, one cell each; with their scale beside the map.

    Parameters
    ----------
    top
        Of the colours, at least.
    """
    top = max(top, float(np.nanmax(values)))
    mesh = axes.pcolormesh(values, cmap="viridis", vmin=0, vmax=top, rasterized=True)
    for (line, place), value in np.ndenumerate(values):
        if np.isfinite(value):
            colour = "black" if value > 0.6 * top else "white"
            axes.text(place + 0.5, line + 0.5, f"{value:.0f}", ha="center", va="center", fontsize=7, color=colour)
    assert axes.figure is not None
    axes.figure.colorbar(mesh, ax=axes, pad=0.02).set_label(title)


def spread_scales(axes: Axes, places: Iterable[float]) -> None:
    """Ticks at all places, from 0 on; scales are logarithmic where values are spread over decades, and 0 is kept."""
    places = sorted(set(places))
    positive = [place for place in places if place > 0]
    if len(positive) > 1 and positive[-1] >= _WIDE * positive[0]:
        axes.set_xscale("symlog", linthresh=positive[0], linscale=0.5)
    few_ticks(axes.xaxis, places, form="{x:g}")
    low, high = axes.get_ylim()
    values = np.concatenate([np.asarray(line.get_ydata(), dtype=np.float64) for line in axes.lines])
    if values.min() > 0 and values.max() > _WIDE / 2 * values.min():
        axes.set_yscale("log")
        axes.yaxis.set_major_locator(LogLocator(10, subs=(1.0, 2.0, 5.0)))
        axes.yaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_minor_formatter(NullFormatter())
    elif low < 0.5 * high:
        axes.set_ylim(0)


def key_of_lines(axes: Axes, lines: Iterable[tuple[str, dict[str, Any]]]) -> None:
    """Entries of the legend for lines that no single curve stands for."""
    for name, style in lines:
        axes.plot([], [], label=name, **style)
