"""Figures of tolerances: quantities against each imperfection with confidence bands, maps of two, and seeds needed."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis as Scale
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullFormatter, NullLocator
from numpy.typing import NDArray

from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, Drawing, new_figure
from granwave.analysis.statistics import Estimate, growing, half_width
from granwave.analysis.studies.tolerance.axes import AXES, Axis, axes_of, told
from granwave.analysis.studies.tolerance.quantities import (
    ARRIVAL,
    DISSIPATED,
    FORCE,
    FRICTION,
    PLASTIC,
    SPHERES,
    Measured,
    Quantity,
)
from granwave.analysis.studies.tolerance.runs import Setting

PANELS = (FORCE, DISSIPATED, PLASTIC, FRICTION, SPHERES, ARRIVAL)
_COLOURS = ("black", BLUE, ORANGE, GREEN, PURPLE, SKY, GREY)
_MARKERS = "os^DvP*"
_ACROSS = 2
_WIDE = 10.0  # largest over smallest value from which on an axis is logarithmic
_FEWEST_SEEDS = 4  # whose convergence is worth a figure
_FEWEST_SHOWN = 3  # in it: the interval of two is thirteen standard deviations wide
_CONVERGED = (FORCE, DISSIPATED, SPHERES)

Columns = dict[str, NDArray]


def against(measured: Measured, axis: Axis) -> Drawing | None:
    """Every quantity against one imperfection, a curve for each setting of the others; None without two values."""
    bases = axis.bases(measured.packing)
    settings = axis.tried(measured.packing)
    quantities = measured.shown(PANELS, settings)
    if not bases or not quantities:
        return None
    rows = -(-len(quantities) // _ACROSS)
    figure = new_figure(1.75 * rows + 0.35 * (len(bases) > 1), 7.0)
    panels: list[Axes] = figure.subplots(rows, _ACROSS, squeeze=False, sharex=True).ravel().tolist()
    others = [one for one in axes_of(measured.packing) if one is not axis]
    table: list[list[float]] = []
    for axes, quantity in zip(panels, quantities, strict=False):
        for n, base in enumerate(bases):
            table += _curve(axes, measured, quantity, axis, base, n, _label(base, others))
        _scale(axes, [axis.of(setting) for setting in settings])
        axes.set_ylabel(quantity.title, fontsize=7)
    for axes in panels[len(quantities) :]:
        axes.set_axis_off()
    for axes in panels[max(0, len(quantities) - _ACROSS) : len(quantities)]:
        axes.set_xlabel(axis.title)
        axes.tick_params(labelbottom=True)
    handles, labels = panels[0].get_legend_handles_labels()
    if len(bases) > 1:
        figure.legend(handles, labels, loc="outside upper center", ncols=min(len(labels), 4), fontsize=7)
    return Drawing(figure, _columns(table))


def left_of_ideal(measured: Measured, across: Axis, up: Axis) -> Drawing | None:
    """Maps of what is left by two imperfections; None where they do not fill a grid."""
    packing = measured.packing
    fixed = [axis for axis in AXES if axis not in (across, up)]
    settings = [setting for setting in packing.settings if not any(axis.of(setting) for axis in fixed)]
    columns = sorted({across.of(setting) for setting in settings})
    lines = sorted({up.of(setting) for setting in settings})
    if min(len(columns), len(lines)) < 2 or len(settings) != len(columns) * len(lines):
        return None
    shown = [one for one in (FORCE, DISSIPATED) if any(measured.left(one, setting) for setting in settings)]
    if not shown:
        return None
    figure = new_figure(0.32 * len(lines) + 1.25, 7.0)
    panels: list[Axes] = figure.subplots(1, len(shown), squeeze=False, sharey=True).ravel().tolist()
    table: Columns = {
        across.column: np.array([getattr(setting, across.name) for setting in settings]),
        up.column: np.array([getattr(setting, up.name) for setting in settings]),
    }
    for axes, quantity in zip(panels, shown, strict=True):
        ideal = measured.of(quantity, Setting())
        values = [measured.of(quantity, setting) for setting in settings]
        shares = [100 * one.mean / ideal.mean if one and ideal else math.nan for one in values]
        grid = np.full((len(lines), len(columns)), np.nan)
        for setting, share in zip(settings, shares, strict=True):
            grid[lines.index(up.of(setting)), columns.index(across.of(setting))] = share
        top = max(100.0, float(np.nanmax(grid)))
        mesh = axes.pcolormesh(grid, cmap="viridis", vmin=0, vmax=top, rasterized=True)
        for (line, place), share in np.ndenumerate(grid):
            if np.isfinite(share):
                colour = "black" if share > 0.6 * top else "white"
                axes.text(place + 0.5, line + 0.5, f"{share:.0f}", ha="center", va="center", fontsize=7, color=colour)
        axes.set_xticks(np.arange(len(columns)) + 0.5, [f"{value:g}" for value in columns])
        axes.set_yticks(np.arange(len(lines)) + 0.5, [f"{value:g}" for value in lines])
        axes.tick_params(which="both", length=0)
        axes.set_xlabel(across.title)
        axes.set_title(quantity.title.partition(" (")[0])
        figure.colorbar(mesh, ax=axes, pad=0.02).set_label("% of the ideal packing's")
        table[f"{quantity.name}_over_ideal"] = np.array(shares) / 100
    panels[0].set_ylabel(up.title)
    return Drawing(figure, table)


def convergence(measured: Measured) -> Drawing | None:
    """Half-width of the confidence interval against the number of seeds, at the setting with most of them."""
    packing = measured.packing
    setting = max(measured.random, key=lambda one: (measured.seeds(one), one), default=None)
    if setting is None or measured.seeds(setting) < _FEWEST_SEEDS:
        return None
    figure = new_figure(3.0)
    axes = figure.subplots()
    table: Columns = {}
    for n, quantity in enumerate(_CONVERGED):
        values = measured.values.get(quantity.name, {}).get(setting, ())
        if len(values) < _FEWEST_SEEDS or not np.std(values):
            continue
        found = growing(values)[_FEWEST_SHOWN - 2 :]
        mean, seeds = found[-1].mean, np.array([one.n for one in found])
        half = np.array([one.half_width for one in found])
        expected = np.array([half_width(found[-1].deviation, int(one)) for one in seeds])
        colour = _COLOURS[n]
        axes.plot(seeds, 100 * half / mean, _MARKERS[n], color=colour, markersize=4, label=quantity.words)
        axes.plot(seeds, 100 * expected / mean, color=colour, linewidth=0.8)
        root = np.sqrt(seeds[-1] / seeds) * expected[-1]
        axes.plot(seeds, 100 * root / mean, color=colour, linewidth=0.8, linestyle=":")
        table |= {"n": seeds, f"{quantity.name}_half_width": half, f"{quantity.name}_expected": expected}
    if not table:
        return None
    axes.plot([], [], color=GREY, linewidth=0.8, label=r"$t_{n-1} s/\sqrt{n}$, $s$ of all seeds")
    axes.plot([], [], color=GREY, linewidth=0.8, linestyle=":", label=r"$1/\sqrt{n}$")
    axes.set_xscale("log")
    axes.set_yscale("log")
    ticks = [n for n in (3, 4, 5, 6, 8, 10, 12, 16, 20, 30, 50, 100) if n <= measured.seeds(setting)]
    _plain(axes.xaxis, ticks)
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.set_xlabel("Seeds")
    axes.set_title(told(setting, axes_of(packing)), fontsize=7)
    axes.set_ylabel("95 % half-width (% of the mean)")
    figure.legend(loc="outside upper center", fontsize=6.5, ncols=2)
    return Drawing(figure, table)


def _curve(
    axes: Axes, measured: Measured, quantity: Quantity, axis: Axis, base: Setting, n: int, label: str
) -> list[list[float]]:
    """Draw one curve with its band and the single runs; returns its rows for the CSV file, SI."""
    colour = _COLOURS[n % len(_COLOURS)]
    found = [(setting, measured.of(quantity, setting)) for setting in axis.along(measured.packing, base)]
    there: list[tuple[Setting, Estimate]] = [(setting, value) for setting, value in found if value is not None]
    x = np.array([axis.of(setting) for setting, _ in there])
    mean = np.array([value.mean for _, value in there]) / quantity.scale
    half = np.nan_to_num([value.half_width for _, value in there]) / quantity.scale
    axes.fill_between(x, mean - half, mean + half, color=colour, alpha=0.2, linewidth=0)
    axes.plot(x, mean, color=colour, marker=_MARKERS[n % len(_MARKERS)], markersize=3.5, label=label)
    for place, (setting, _) in zip(x, there, strict=True):
        if setting in measured.random:
            single = np.array(measured.values[quantity.name][setting]) / quantity.scale
            axes.plot(np.full(len(single), place), single, ".", color=colour, markersize=3.5, alpha=0.6)
    return [[PANELS.index(quantity), *setting, value.n, value.mean, value.low, value.high] for setting, value in there]


def _label(base: Setting, others: Sequence[Axis]) -> str:
    """The other imperfections of a curve, also where they are zero."""
    return ", ".join(f"{axis.words} {axis.show(axis.of(base))}" for axis in others)


def _columns(table: list[list[float]]) -> Columns:
    """One row for each point of each panel."""
    numbers = np.array(table)
    columns: Columns = {"quantity": np.array([PANELS[int(row[0])].name for row in table])}
    columns |= {axis.column: numbers[:, 1 + n] for n, axis in enumerate(AXES)}
    columns["n"] = numbers[:, 4].astype(np.int64)
    return columns | {name: numbers[:, 5 + n] for n, name in enumerate(("mean", "low_95", "high_95"))}


def _scale(axes: Axes, places: Sequence[float]) -> None:
    """Zero has its place on the abscissa, also where the rest is spread over decades."""
    places = sorted(set(places))
    positive = [place for place in places if place > 0]
    if len(positive) > 1 and positive[-1] >= _WIDE * positive[0]:
        axes.set_xscale("symlog", linthresh=positive[0], linscale=0.5)
    _plain(axes.xaxis, places)
    low, high = axes.get_ylim()
    means = np.concatenate([np.asarray(line.get_ydata(), dtype=np.float64) for line in axes.lines])
    if means.min() > 0 and means.max() > _WIDE / 2 * means.min():
        axes.set_yscale("log")
        axes.yaxis.set_major_locator(LogLocator(10, subs=(1.0, 2.0, 5.0)))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.yaxis.set_minor_formatter(NullFormatter())
    elif low < 0.5 * high:
        axes.set_ylim(0)


def _plain(axis: Scale, places: Sequence[float]) -> None:
    """Ticks at these places alone."""
    axis.set_major_locator(FixedLocator(list(places)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_locator(NullLocator())
