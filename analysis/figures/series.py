"""Parts that figures share: panels and their labels, curves against time, legends above, names of columns."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, WIDTH, new_figure

_MICRO = 1e6  # in a second
_MOST_POINTS = 20_000  # of a curve; the CSV file has all

COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY, GREY)
MARKS = "os^Dv"
_ENERGIES = ((1.0, "J"), (1e3, "mJ"), (1e6, "µJ"), (1e9, "nJ"))
_VELOCITIES = ((1.0, "m/s"), (1e3, "mm/s"), (1e6, "µm/s"))
_LEAST_VELOCITY = 0.01  # in m/s: tenths are usual there


def energy_unit(largest: float) -> tuple[float, str]:
    """Return the unit in which energies up to ``largest`` (J) are shown: how many are a joule, and its name."""
    return next((one for one in _ENERGIES if largest * one[0] >= 1), _ENERGIES[-1])


def velocity_unit(largest: float) -> tuple[float, str]:
    """Return the unit in which velocities up to ``largest`` (m/s) are shown: how many are 1 m/s, and its name."""
    return next((one for one in _VELOCITIES if largest * one[0] >= _LEAST_VELOCITY), _VELOCITIES[-1])


def against_time(
    axes: Axes, time: NDArray[np.float64], values: NDArray[np.float64], line: str = "-", **look: Any
) -> None:
    """Draw a record against time, and label that axis.

    Of long records the lowest and the highest value of every bin are drawn, which give the same curve.
    """
    if len(values) > _MOST_POINTS:
        n_bins = _MOST_POINTS // 2
        size = len(values) // n_bins
        bins, starts = values[: n_bins * size].reshape(n_bins, size), np.arange(n_bins) * size
        rows = np.unique([*(starts + bins.argmin(axis=1)), *(starts + bins.argmax(axis=1)), len(values) - 1])
        time, values = time[rows], values[rows]
    axes.plot(time * _MICRO, values, line, **look)
    time_axis(axes, time)


def time_axis(axes: Axes, time: NDArray[np.float64]) -> None:
    """Label the axis of times, s; that of the lowest panel if several share it."""
    if axes.get_subplotspec() is None or axes.get_subplotspec().is_last_row():  # type: ignore[union-attr]
        axes.set_xlabel("Time (µs)")
    axes.set_xlim(0, float(time[-1]) * _MICRO or 1.0)


def one_panel(height: float, xlabel: str, ylabel: str, width: float = WIDTH, **settings: Any) -> tuple[Figure, Axes]:
    """Make an empty figure with one panel.

    Parameters
    ----------
    height, width
        Size of the figure, inches.
    xlabel, ylabel
        Labels of the axes.
    settings
        Further settings of the axes: ``xscale``, ``ylim``, ...
    """
    figure = new_figure(height, width)
    axes = figure.subplots()
    axes.set(xlabel=xlabel, ylabel=ylabel, **settings)
    return figure, axes


def panels(height: float, columns: int = 1, rows: int = 1, *, width: float = 0.0, **options: Any) -> tuple[Any, ...]:
    """A new figure and its axes, row by row; curves take the `COLOURS` in turn.

    Parameters
    ----------
    height, width
        Inches; the width is that of two columns of a journal for panels side by side, else of one.
    options
        Of ``Figure.subplots``.
    """
    figure = new_figure(height, width or WIDTH * min(columns, 2))
    grid = figure.subplots(rows, columns, squeeze=False, **options).ravel()
    for axes in grid:
        axes.set_prop_cycle(color=COLOURS)
    return figure, *grid


def label(axes: Axes, x: str = "", y: str = "", *, log: str = "", **settings: Any) -> None:
    """Label axes, and set what else they have.

    Parameters
    ----------
    log
        Names of logarithmic axes: ``x``, ``y`` or ``xy``.
    settings
        Of ``Axes.set``, such as ``xlim`` and ``title``.
    """
    axes.set(**{f"{name}scale": "log" for name in log})
    axes.set(xlabel=x or axes.get_xlabel(), ylabel=y or axes.get_ylabel(), **settings)


def legend_outside(figure: Figure, ncols: int = 0, *, left: bool = False, **options: Any) -> None:
    """Put the legend of the first panel above all panels.

    Parameters
    ----------
    ncols
        Columns; 0 for one row.
    left
        True to place it at the left, else in the middle.
    options
        Further options of a legend: ``fontsize``, ``title``, ...
    """
    handles, labels = figure.axes[0].get_legend_handles_labels()
    place: Any = f"outside upper {'left' if left else 'center'}"
    figure.legend(handles, labels, loc=place, ncols=ncols or len(labels), **options)


def column_name(words: str) -> str:
    """Convert text to the name of a column or a file: ``FCC, 314 µs`` becomes ``FCC_314_us``."""
    kept = "".join(letter if letter.isalnum() and letter.isascii() else "_" for letter in words.replace("µ", "u"))
    return "_".join(filter(None, kept.split("_")))
