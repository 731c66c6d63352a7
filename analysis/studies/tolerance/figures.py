"""Figures of tolerances: quantities against each imperfection with confidence bands, maps of two, and seeds needed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from granwave.analysis.figures.packings import convergence
from granwave.analysis.figures.scales import not_to_scale, numbered_map, spread_scales
from granwave.analysis.figures.series import legend_outside
from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, Drawing, new_figure
from granwave.analysis.studies.tolerance.packings import Packing
from granwave.analysis.studies.tolerance.quantities import (
    ARRIVAL,
    DISSIPATED,
    FORCE,
    FRICTION,
    PLASTIC,
    SPHERES,
    Quantity,
)
from granwave.analysis.studies.tolerance.settings import AXES, IDEAL, Axis, Setting, told

_PANELS = (FORCE, DISSIPATED, PLASTIC, FRICTION, SPHERES, ARRIVAL)
_COLOURS = ("black", BLUE, ORANGE, GREEN, PURPLE, SKY, GREY)
_MARKERS = "os^DvP*"
_ACROSS = 2
_WIDTH = 7.0  # inches: two columns of a journal
_FEWEST_SEEDS = 4  # whose convergence is worth a figure
_CONVERGED = (FORCE, DISSIPATED, SPHERES)


def against(packing: Packing, axis: Axis) -> Drawing | None:
    """Every quantity against one imperfection, a curve for each setting of the others; None without two values."""
    bases, settings = packing.bases(axis), packing.tried(axis)
    quantities = packing.shown(_PANELS, settings)
    if not bases or not quantities:
        return None
    rows = -(-len(quantities) // _ACROSS)
    figure = new_figure(1.75 * rows + 0.35 * (len(bases) > 1), _WIDTH)
    panels: list[Axes] = figure.subplots(rows, _ACROSS, squeeze=False, sharex=True).ravel().tolist()
    others = [one for one in packing.axes if one is not axis]
    points: list[tuple[str, Setting, float, float, float, float]] = []
    for axes, quantity in zip(panels, quantities, strict=False):
        for n, base in enumerate(bases):
            label = ", ".join(f"{other.words} {other.show(other.of(base))}" for other in others)
            points += _curve(axes, packing, quantity, axis, packing.along(axis, base), n, label)
        scale = spread_scales(axes, [axis.of(setting) for setting in settings])
        axes.set_ylabel(quantity.title, fontsize=7)
    for axes in panels[len(quantities) :]:
        axes.set_axis_off()
    for axes in panels[max(0, len(quantities) - _ACROSS) : len(quantities)]:
        axes.set_xlabel(axis.title + scale)
        axes.tick_params(labelbottom=True)
    if len(bases) > 1:
        legend_outside(figure, min(len(bases), 4), fontsize=7)
    names, places, *values = zip(*points, strict=True)
    columns = {"quantity": np.array(names)}
    columns |= {one.column: np.array([getattr(place, one.name) for place in places]) for one in AXES}
    return Drawing(figure, columns | dict(zip(("n", "mean", "low_95", "high_95"), map(np.array, values), strict=True)))


def left_of_ideal(packing: Packing, across: Axis, up: Axis) -> Drawing | None:
    """Maps of what is left by two imperfections; None where they do not fill a grid."""
    fixed = [axis for axis in AXES if axis not in (across, up)]
    settings = [setting for setting in packing.settings if not any(axis.of(setting) for axis in fixed)]
    columns = sorted({across.of(setting) for setting in settings})
    lines = sorted({up.of(setting) for setting in settings})
    if min(len(columns), len(lines)) < 2 or len(settings) != len(columns) * len(lines):
        return None
    shown = [one for one in (FORCE, DISSIPATED) if any(packing.left(one, setting) for setting in settings)]
    if not shown:
        return None
    figure = new_figure(0.32 * len(lines) + 1.25, _WIDTH)
    panels: list[Axes] = figure.subplots(1, len(shown), squeeze=False, sharey=True).ravel().tolist()
    table = {axis.column: np.array([getattr(setting, axis.name) for setting in settings]) for axis in (across, up)}
    for axes, quantity in zip(panels, shown, strict=True):
        found = [packing.over_ideal(quantity, setting) for setting in settings]
        shares = np.array([100 * share.mean if share else np.nan for share in found])
        numbered_map(axes, shares.reshape(len(columns), len(lines)).T, 100.0, "% of the ideal packing's")
        axes.set_xticks(np.arange(len(columns)) + 0.5, [f"{value:g}" for value in columns])
        axes.set_yticks(np.arange(len(lines)) + 0.5, [f"{value:g}" for value in lines])
        axes.tick_params(which="both", length=0)
        axes.set_xlabel(across.title + not_to_scale(columns))
        axes.set_title(quantity.words.capitalize())
        table[f"{quantity.name}_over_ideal"] = shares / 100
    panels[0].set_ylabel(up.title + not_to_scale(lines))
    return Drawing(figure, table)


def seeds(packing: Packing) -> Drawing | None:
    """Half-width of the confidence interval against the number of seeds, at the setting with most of them."""
    random = [setting for setting in packing.settings if packing.random(setting)]
    setting = max(random, key=lambda one: (packing.seeds(one), one), default=IDEAL)
    if not random or packing.seeds(setting) < _FEWEST_SEEDS:
        return None
    found = {one.name: (one.words, packing.values(one, setting)) for one in _CONVERGED}
    return convergence(told(setting), {name: part for name, part in found.items() if len(part[1]) >= _FEWEST_SEEDS})


def _curve(
    axes: Axes, packing: Packing, quantity: Quantity, axis: Axis, along: Sequence[Setting], n: int, label: str
) -> list[tuple[str, Setting, float, float, float, float]]:
    """Draw one curve with its band and the single runs.

    Returns
    -------
    list
        For each point the quantity, the setting, the number of seeds, the mean and the ends of its interval, SI.
    """
    colour = _COLOURS[n % len(_COLOURS)]
    found = {setting: value for setting in along if (value := packing.of(quantity, setting))}
    x = np.array([axis.of(setting) for setting in found])
    mean = np.array([value.mean for value in found.values()]) / quantity.scale
    half = np.nan_to_num([value.half_width for value in found.values()]) / quantity.scale
    axes.fill_between(x, mean - half, mean + half, color=colour, alpha=0.2, linewidth=0)
    axes.plot(x, mean, color=colour, marker=_MARKERS[n % len(_MARKERS)], markersize=3.5, label=label)
    for place, setting in zip(x, found, strict=True):
        if packing.random(setting):
            single = np.array(packing.values(quantity, setting)) / quantity.scale
            axes.plot(np.full(len(single), place), single, ".", color=colour, markersize=3.5, alpha=0.6)
    return [(quantity.name, setting, one.n, one.mean, one.low, one.high) for setting, one in found.items()]
