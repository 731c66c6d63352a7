"""Figures of a study of tolerances: curves by imperfection, maps of two, confidence by seeds."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from granwave.analysis import statistics
from granwave.analysis.figures.scales import not_to_scale, numbered_map, spread_scales, ticks_at
from granwave.analysis.figures.series import COLOURS, label, legend_outside, panels
from granwave.analysis.figures.style import BLUE, GREY, ORANGE, Drawing
from granwave.analysis.studies.study import Picture
from granwave.analysis.studies.tolerance.quantities import (
    AXES,
    DISSIPATED,
    FORCE,
    PANELS,
    YIELDED_SPHERES,
    Setting,
    ToleranceQuantity,
    in_words,
)
from granwave.analysis.studies.tolerance.runs import PackingRuns

_MARKERS = "os^DvP*"
_MARKER_SIZE = 3.5
_ACROSS = 2  # panels
_WIDTH = 7.0  # inches: two columns of a journal
_PANEL_HEIGHT = 1.75  # inches
_LEGEND_HEIGHT = 0.35  # inches
_MAP_ROW_HEIGHT = 0.32  # inches
_MAP_MARGIN = 1.25  # inches
_MOST_LEGEND_COLUMNS = 4
_FEWEST_SEEDS = 4  # fewest seeds whose convergence is drawn
_FEWEST_SHOWN = 3  # the confidence interval of two values is thirteen standard deviations wide
_TICKS = (3, 4, 5, 6, 8, 10, 12, 16, 20, 30, 50, 100)
_POINT_COLUMNS = (
    "quantity",
    *(axis.column for axis in AXES),
    "n",
    "mean",
    "low_95",
    "high_95",
)


def pictures(packing: PackingRuns) -> Iterator[Picture]:
    """Quantities against each imperfection, maps of two, and the confidence that the seeds give."""
    for axis in packing.axes:
        drawing = _against(packing, axis)
        if drawing:
            content = "no random quantity"
            if any(packing.random(setting) for setting in _settings_along(packing, axis)):
                content = "means, 95 % confidence bands, and single runs as dots"
            seen = (
                "An imperfection has an effect where the band differs from the value at 0, the "
                "ideal packing"
            )
            caption = f"Against {axis.words}: {content}{packing.suffix}. {seen}"
            yield Picture(f"_{axis.name}", caption, drawing)
    for across, up in itertools.combinations(packing.axes, 2):
        drawing = _left_of_ideal(packing, across, up)
        if drawing:
            caption = (
                f"{across.heading} and {up.words} combined, in per cent of the ideal "
                f"packing{packing.suffix}. If values change along both rows and columns, both "
                "imperfections have an effect"
            )
            yield Picture(f"_{across.name}_{up.name}", caption, drawing)
    drawing = _convergence(packing)
    if drawing:
        caption = (
            "Confidence interval of the mean of the first n seeds, and its estimate from the "
            f"scatter of all seeds{packing.suffix}. Once the curves have decreased to the "
            "required precision, the number of seeds is sufficient"
        )
        yield Picture("_seeds", caption, drawing)


def _settings_along(packing: PackingRuns, axis: ToleranceQuantity) -> list[Setting]:
    """All settings of the curves against an imperfection."""
    return list(itertools.chain(*packing.along(axis).values()))


def _against(packing: PackingRuns, axis: ToleranceQuantity) -> Drawing | None:
    """Every quantity against one imperfection, a curve for each setting of the others; None without
    two values.
    """
    lines = packing.along(axis)
    settings = _settings_along(packing, axis)
    quantities = packing.shown(PANELS, settings) if lines else []
    if not quantities:
        return None
    rows = -(-len(quantities) // _ACROSS)
    height = _PANEL_HEIGHT * rows
    if len(lines) > 1:
        height += _LEGEND_HEIGHT
    figure, *grid = panels(height, _ACROSS, rows, width=_WIDTH, sharex=True)
    points = []
    for axes, quantity in zip(grid, quantities, strict=False):
        for number, (base, along) in enumerate(lines.items()):
            points += _curve(
                axes, packing, quantity, axis, along, _look(packing, axis, base, number)
            )
        scale = spread_scales(axes, [axis.of(setting) for setting in settings])
        axes.set_ylabel(quantity.title, fontsize=7)
    for axes in grid[len(quantities) :]:
        axes.set_axis_off()
    for axes in grid[max(0, len(quantities) - _ACROSS) : len(quantities)]:
        axes.set_xlabel(axis.title + scale)
        axes.tick_params(labelbottom=True)
    if len(lines) > 1:
        legend_outside(figure, min(len(lines), _MOST_LEGEND_COLUMNS), fontsize=7)
    columns = [np.array(column) for column in zip(*points, strict=True)]
    return Drawing(figure, dict(zip(_POINT_COLUMNS, columns, strict=True)))


def _look(
    packing: PackingRuns, axis: ToleranceQuantity, base: Setting, number: int
) -> dict[str, Any]:
    """Return colour, marker and label of a curve: the values of the other imperfections."""
    others = [other for other in packing.axes if other is not axis]
    return {
        "color": COLOURS[number % len(COLOURS)],
        "marker": _MARKERS[number % len(_MARKERS)],
        "label": ", ".join(f"{other.words} {other.show(other.of(base))}" for other in others),
    }


def _curve(
    axes: Axes,
    packing: PackingRuns,
    quantity: ToleranceQuantity,
    axis: ToleranceQuantity,
    along: Sequence[Setting],
    look: dict[str, Any],
) -> list[tuple[Any, ...]]:
    """Draw means of a quantity with their confidence band, and single runs as dots; return the
    means as rows of `_POINT_COLUMNS`.
    """
    all_means = packing.means(quantity)
    means = {setting: all_means[setting] for setting in along if setting in all_means}
    x = np.array([axis.of(setting) for setting in means])
    y = np.array([mean.mean for mean in means.values()]) / quantity.scale
    half = np.nan_to_num([mean.half_width for mean in means.values()]) / quantity.scale
    colour = look["color"]
    axes.fill_between(x, y - half, y + half, color=colour, alpha=0.2, linewidth=0)
    axes.plot(x, y, markersize=_MARKER_SIZE, **look)
    for place, setting in zip(x, means, strict=True):
        if packing.random(setting):
            single = np.array(packing.values(quantity, setting)) / quantity.scale
            places = np.full(len(single), place)
            axes.plot(places, single, ".", color=colour, markersize=_MARKER_SIZE, alpha=0.6)
    return [
        (quantity.name, *setting, mean.n, mean.mean, mean.low, mean.high)
        for setting, mean in means.items()
    ]


def _left_of_ideal(
    packing: PackingRuns, across: ToleranceQuantity, up: ToleranceQuantity
) -> Drawing | None:
    """Maps of performance by two imperfections; None if they do not fill a grid."""
    settings = [setting for setting in packing.runs if _has_only(setting, (across, up))]
    columns = sorted({across.of(setting) for setting in settings})
    rows = sorted({up.of(setting) for setting in settings})
    is_grid = min(len(columns), len(rows)) > 1 and len(settings) == len(columns) * len(rows)
    shown = [quantity for quantity in (FORCE, DISSIPATED) if packing.left(quantity)]
    if not is_grid or not shown:
        return None
    height = _MAP_ROW_HEIGHT * len(rows) + _MAP_MARGIN
    figure, *grid = panels(height, len(shown), width=_WIDTH, sharey=True)
    names = [list(map("{:g}".format, columns)), list(map("{:g}".format, rows))]
    table = {}
    for axis in (across, up):
        table[axis.column] = np.array([getattr(setting, axis.name) for setting in settings])
    for axes, quantity in zip(grid, shown, strict=True):
        shares = _per_cent_of_ideal(packing, quantity, settings)
        ends = (0.0, max(100.0, float(np.nanmax(shares))))
        shares_by_row = shares.reshape(len(columns), len(rows)).T
        numbered_map(axes, shares_by_row, ends, "% of the ideal packing", names, ".0f")
        axes.set(xlabel=across.title + not_to_scale(columns), title=quantity.heading)
        table[f"{quantity.name}_over_ideal"] = shares / 100
    grid[0].set_ylabel(up.title + not_to_scale(rows))
    return Drawing(figure, table)


def _has_only(setting: Setting, axes: Sequence[ToleranceQuantity]) -> bool:
    """Return True if a setting has no imperfections other than these."""
    return not any(axis.of(setting) for axis in AXES if axis not in axes)


def _per_cent_of_ideal(
    packing: PackingRuns, quantity: ToleranceQuantity, settings: Sequence[Setting]
) -> NDArray[np.float64]:
    """Values of settings in per cent of the ideal packing's, NaN if there is none; shape
    (n_settings,).
    """
    ratios = packing.over_ideal(quantity)
    return np.array(
        [100 * ratios[setting].mean if setting in ratios else np.nan for setting in settings]
    )


def _convergence(packing: PackingRuns) -> Drawing | None:
    """Half-width of the confidence interval of the first n seeds of the setting with most of them;
    None for few seeds, or if nothing is random.
    """
    random = [setting for setting in packing.runs if packing.random(setting)]
    if not random:
        return None
    setting = max(random, key=lambda setting: (len(packing.runs[setting]), setting))
    figure, axes = panels(3.0)
    label(axes, "Seeds", "95 % half-width (% of the mean)", log="xy")
    columns: dict[str, Any] = {}
    looks = {FORCE: ("black", "o"), DISSIPATED: (BLUE, "s"), YIELDED_SPHERES: (ORANGE, "^")}
    for quantity, (colour, marker) in looks.items():
        values = packing.values(quantity, setting)
        if len(values) >= _FEWEST_SEEDS and np.std(values):
            columns |= _convergence_curves(axes, quantity, values, colour, marker)
    if not columns:
        return None
    axes.plot([], [], color=GREY, linewidth=0.8, label=r"$t_{n-1} s/\sqrt{n}$, $s$ of all seeds")
    axes.plot([], [], color=GREY, linewidth=0.8, linestyle=":", label=r"$1/\sqrt{n}$")
    ticks_at(axes.xaxis, [n for n in _TICKS if n <= len(packing.runs[setting])])
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set_title(in_words(setting), fontsize=7)
    legend_outside(figure, 2, fontsize=6.5)
    return Drawing(figure, columns)


def _convergence_curves(
    axes: Axes, quantity: ToleranceQuantity, values: Sequence[float], colour: str, marker: str
) -> dict[str, NDArray[Any]]:
    """Draw the half-widths of the means of the first seeds, the half-widths that the scatter of all
    seeds gives, and the slope 1/sqrt(n); return the data by column.
    """
    estimates = statistics.growing(values)[_FEWEST_SHOWN - 2 :]
    mean = estimates[-1].mean
    deviation = estimates[-1].deviation
    seeds = np.array([estimate.n for estimate in estimates])
    half = np.array([estimate.half_width for estimate in estimates])
    expected = np.array([statistics.half_width(deviation, int(n)) for n in seeds])
    slope = np.sqrt(seeds[-1] / seeds) * expected[-1]
    axes.plot(seeds, 100 * half / mean, marker, color=colour, markersize=4, label=quantity.words)
    axes.plot(seeds, 100 * expected / mean, color=colour, linewidth=0.8)
    axes.plot(seeds, 100 * slope / mean, color=colour, linewidth=0.8, linestyle=":")
    return {
        "n": seeds,
        f"{quantity.name}_half_width": half,
        f"{quantity.name}_expected": expected,
    }
