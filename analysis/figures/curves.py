"""Common elements of figures with curves: colours, markers, panels, ticks, maps in space and time."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import QuadMesh
from matplotlib.ticker import FixedLocator, LogLocator, NullLocator
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, WIDTH, new_figure

COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY, GREY)
MARKS = "os^Dv"
DOUBLE = 7.0  # inches, two columns of a journal


def panels(height: float, columns: int = 1, rows: int = 1, *, width: float = 0.0, **options: Any) -> tuple[Any, ...]:
    """Make a figure; return it and its axes, row by row.

    Parameters
    ----------
    height, width
        Size of the figure, inches; the default width is one journal column for a single column of panels, else two.
    options
        Options of ``Figure.subplots``.
    """
    figure = new_figure(height, width or (DOUBLE if columns > 1 else WIDTH))
    return figure, *figure.subplots(rows, columns, squeeze=False, **options).flat


def label(axes: Axes, x: str = "", y: str = "", *, log: str = "", **settings: Any) -> None:
    """Set labels, scales and further properties of axes.

    Parameters
    ----------
    log
        Names of logarithmic axes: ``x``, ``y`` or ``xy``.
    settings
        Options of ``Axes.set``, such as ``xlim`` and ``title``.
    """
    scales = {f"{name}scale": "log" for name in log}
    axes.set(**({"xlabel": x} if x else {}), **({"ylabel": y} if y else {}), **scales, **settings)


def few_ticks(
    axis: Axis, ticks: Iterable[float] | None = None, *, subs: Sequence[float] = (), form: str = "{x:.3g}"
) -> None:
    """Set plain tick labels on a logarithmic axis with a small range.

    Parameters
    ----------
    ticks
        Positions of the ticks; None: at ``subs`` times the powers of ten.
    form
        Format of the tick labels ``x``.
    """
    axis.set_major_locator(LogLocator(subs=subs) if ticks is None else FixedLocator(list(ticks)))
    axis.set_major_formatter(form)
    axis.set_minor_locator(NullLocator())


def map_of(axes: Axes, x: ArrayLike, y: ArrayLike, values: NDArray[np.float64], **options: Any) -> QuadMesh:
    """Draw values (n_y, n_x) as colours, one cell around each point."""
    return axes.pcolormesh(x, y, values, rasterized=True, shading="nearest", **options)


def key_of_lines(axes: Axes, lines: Iterable[tuple[str, dict[str, Any]]]) -> None:
    """Add legend entries for line styles that several curves share."""
    for name, style in lines:
        axes.plot([], [], label=name, **style)
