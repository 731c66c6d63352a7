"""Axes whose values are spread over decades, and maps that show their values as numbers."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.ticker import FixedLocator, LogLocator, NullFormatter, NullLocator
from numpy.typing import NDArray

_WIDE = 10.0  # largest over smallest value from which on an axis is logarithmic


def ticks_at(axis: Axis, places: Iterable[float]) -> None:
    """Put plain numbers at these places of a logarithmic axis, and nowhere else."""
    axis.set_major_locator(FixedLocator(list(places)))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_locator(NullLocator())


def numbered_map(axes: Axes, values: NDArray[np.float64], top: float, title: str) -> None:
    """Draw values (n_y, n_x), none negative, by colour and as numbers, a cell each, with a colour bar.

    Parameters
    ----------
    top
        Upper end of the colours, at least.
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
    """Put ticks at all places; scales become logarithmic where values are spread over decades, and 0 is kept."""
    places = sorted(set(places))
    positive = [place for place in places if place > 0]
    if len(positive) > 1 and positive[-1] >= _WIDE * positive[0]:
        axes.set_xscale("symlog", linthresh=positive[0], linscale=0.5)
    ticks_at(axes.xaxis, places)
    low, high = axes.get_ylim()
    values = np.concatenate([np.asarray(line.get_ydata(), dtype=np.float64) for line in axes.lines])
    if values.min() > 0 and values.max() > _WIDE / 2 * values.min():
        axes.set_yscale("log")
        axes.yaxis.set_major_locator(LogLocator(10, subs=(1.0, 2.0, 5.0)))
        axes.yaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_minor_formatter(NullFormatter())
    elif low < 0.5 * high:
        axes.set_ylim(0)
