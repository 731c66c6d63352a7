"""Study of tolerances: what is left of an ideal packing's performance where it is imperfect."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from granwave.analysis.document.model import BLANK, Cell, Column, Table
from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.figures.scales import not_to_scale, numbered_map, spread_scales, ticks_at
from granwave.analysis.figures.series import COLOURS, label, legend_outside, panels
from granwave.analysis.figures.style import BLUE, GREY, ORANGE, Drawing
from granwave.analysis.formatting.numbers import number, with_interval
from granwave.analysis.measures.target import reached
from granwave.analysis.result.reader import Result
from granwave.analysis.statistics import (
    Estimate,
    crossing,
    differ_significantly,
    exactly,
    growing,
    half_width,
    seeds_needed,
)
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, numeric, table_of
from granwave.analysis.studies.tolerance.packings import (
    ARRIVAL,
    AXES,
    CONTACTS,
    DEPTH,
    DISSIPATED,
    FORCE,
    FRICTION,
    IDEAL,
    PLASTIC,
    REDUCTION,
    SPHERES,
    VOLUME,
    Packing,
    Quantity,
    Setting,
    imperfections,
    select,
)

TEXT = (
    "Means over the seeds and their 95 % confidence intervals (Student). Values without an interval are of "
    "packings in which nothing is random, or of a single seed. With a diameter scatter, diameters lie between the "
    "nominal one and so much less. A lower peak force and a larger dissipated share protect better."
)
KEPT = 0.9  # of the ideal packing's performance: how large may a tolerance be?
_SAME = 0.005
_MOST_NAMED = 6  # pairs that cannot be told apart
_PRECISE = 0.1  # of the mean: the half-width that a number of seeds is told for
_LATE = 0.05  # of a run
_MARKERS = "os^DvP*"
_ACROSS = 2  # panels
_WIDTH = 7.0  # inches: two columns of a journal
_FEWEST_SEEDS = 4  # whose convergence is worth a figure
_FEWEST_SHOWN = 3  # the interval of two is thirteen standard deviations wide
_LOOKS = (("black", "o"), (BLUE, "s"), (ORANGE, "^"))
_TICKS = (3, 4, 5, 6, 8, 10, 12, 16, 20, 30, 50, 100)
_ALL = (FORCE, REDUCTION, DISSIPATED, PLASTIC, FRICTION, CONTACTS, SPHERES, VOLUME, DEPTH, ARRIVAL)
_PERFORMANCE = (FORCE, DISSIPATED, PLASTIC)  # how much of it is left is told
_PANELS = (FORCE, DISSIPATED, PLASTIC, FRICTION, SPHERES, ARRIVAL)

__all__ = ["select"]


def name(packing: Packing) -> str:
    """``tolerances``, ``tolerances-2``."""
    return packing.name


def title(packing: Packing) -> str:
    """Title with packing and impact."""
    return f"Tolerances: {packing.title}" + ("" if packing.label in packing.title else packing.suffix)


def verdict(packing: Packing) -> Iterator[str]:
    """Say what is left at worst, which differences the seeds do not resolve, and how many seeds would.

    Without the ideal packing there is nothing to compare with, and nothing is said.
    """
    if IDEAL not in packing.runs:
        return
    if parts := [_at_worst(packing, one) for one in packing.shown(_PERFORMANCE) if len(packing.left(one)) > 1]:
        yield f"Against the ideal packing {'; '.join(parts)}."
    for quantity in (FORCE, DISSIPATED):
        if alike := list(_alike(packing, quantity)):
            more = f"; and {len(alike) - _MOST_NAMED} more" if len(alike) > _MOST_NAMED else ""
            named = "; ".join(alike[:_MOST_NAMED]) + more
            yield f"By {quantity.words} these cannot be told apart with the seeds there are: {named}."
    if short := sum(_cut_short(run) for runs in packing.runs.values() for run in runs):
        yield (
            f"In {short} runs the force on the bottom was largest at their very end, so that it may have grown on: "
            "follow them longer (run.end_time)."
        )
    if known := {s: one for s, one in packing.means(FORCE).items() if one.n > 1 and one.mean and one.deviation > 0}:
        setting = max(known, key=lambda one: (known[one].deviation / abs(known[one].mean), one))
        value = known[setting]
        n = seeds_needed(value.deviation, _PRECISE * abs(value.mean))
        enough = "which there are" if n <= value.n else f"there are {value.n}"
        yield (
            f"The {FORCE.words} differs most from seed to seed at {_told(setting)}: by {number(value.deviation)} N "
            f"(standard deviation); its mean to ± {100 * _PRECISE:.0f} % takes {n} seeds, {enough}."
        )


def missing(packing: Packing, undone: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Say that the ideal packing has not finished, where a point of a scan asked for it."""
    fixed = imperfections(packing.case)["setting"]
    asked = (not any(labels.get(axis.key, getattr(fixed, axis.name)) for axis in AXES) for labels in undone)
    if IDEAL not in packing.runs and any(asked):
        yield (
            "The ideal packing (no scatter, no friction) has not finished, so that it cannot be said how much of its "
            "performance is left."
        )


def tables(packing: Packing) -> Iterator[Table]:
    """Means of all settings, those of performance against the ideal packing, and how large a tolerance may be."""
    axes = numeric(*((axis.words.capitalize(), axis.unit) for axis in packing.axes), key=True)
    for caption, quantities, of, unit, cell in (
        ("Mean and 95 % confidence interval", packing.shown(_ALL), packing.means, "", _mean_cell),
        ("Against the ideal packing", packing.shown(_PERFORMANCE), packing.over_ideal, "% of the ideal's", _share_cell),
    ):
        means = {one: found for one in quantities if (found := of(one)) and (not unit or packing.left(one))}
        columns = numeric(*((one.words.capitalize(), unit or one.unit) for one in means))
        rows = [
            (
                *(Cell(f"{axis.of(s):g}", axis.of(s)) for axis in packing.axes),
                Cell(str(len(runs)), len(runs)) if packing.random(s) else Cell("not random", 0),
                *(cell(one, found[s]) if s in found else Cell(BLANK) for one, found in means.items()),
            )
            for s, runs in packing.runs.items()
            if not unit or s != IDEAL
        ]
        if means:
            yield table_of(caption + packing.suffix, (*axes, *numeric("Seeds"), *columns), rows, sortable=True)
    kept = [
        _kept(packing, quantity, axis, along)
        for axis in packing.axes
        if IDEAL in packing.runs and (along := packing.along(axis).get(IDEAL))
        for quantity in packing.shown(_PERFORMANCE, along)
        if len(packing.left(quantity)) > 1
    ]
    if kept:
        caption = (
            f"How large each imperfection may be for {100 * KEPT:.0f} % of the ideal packing's performance or more: a "
            f"force of at most {100 / KEPT:.0f} %"
        )
        heads = ("Imperfection", "Quantity", "Ideal", "Largest tried", "There", "Of the ideal's", "Seeds", "Kept up to",
                 "With confidence up to")  # fmt: skip
        yield table_of(caption + packing.suffix, [Column(head, key=n < 2) for n, head in enumerate(heads)], kept)


def pictures(packing: Packing) -> Iterator[Picture]:
    """Quantities against each imperfection, maps of two, and the confidence that the seeds give."""
    for axis in packing.axes:
        if drawing := _against(packing, axis):
            random = any(packing.random(setting) for along in packing.along(axis).values() for setting in along)
            what = "means, 95 % confidence bands, and single runs as dots" if random else "nothing is random here"
            seen = "An imperfection matters from where a band leaves the value at 0, which is the ideal packing's"
            yield Picture(f"_{axis.name}", f"Against {axis.words}: {what}{packing.suffix}. {seen}", drawing)
    for across, up in itertools.combinations(packing.axes, 2):
        if drawing := _left_of_ideal(packing, across, up):
            caption = f"{across.words.capitalize()} and {up.words} together, in per cent of the ideal packing's"
            seen = "Numbers that change along rows and columns alike tell that both imperfections matter"
            yield Picture(f"_{across.name}_{up.name}", f"{caption}{packing.suffix}. {seen}", drawing)
    seeded = [setting for setting in packing.runs if packing.random(setting)]
    most = max(seeded, key=lambda one: (len(packing.runs[one]), one), default=None)
    if most and len(packing.runs[most]) >= _FEWEST_SEEDS:
        found = {one.name: (one.words, packing.values(one, most)) for one in (FORCE, DISSIPATED, SPHERES)}
        enough = {key: part for key, part in found.items() if len(part[1]) >= _FEWEST_SEEDS}
        if drawing := convergence(_told(most), enough):
            caption = "Confidence of the mean of the first n seeds, and what the scatter of all of them makes of n"
            seen = "Where the curves have fallen to the precision that is wanted, there are seeds enough"
            yield Picture("_seeds", f"{caption}{packing.suffix}. {seen}", drawing)


def _told(setting: Setting) -> str:
    """Return a setting in words, such as ``diameter scatter 5 µm, friction coefficient 0.1``."""
    parts = [f"{axis.words} {axis.show(axis.of(setting))}" for axis in AXES if axis.of(setting)]
    return ", ".join(parts) or "ideal"


def _mean_cell(quantity: Quantity, value: Estimate) -> Cell:
    return Cell(with_interval(value, quantity.scale), value.mean)


def _share_cell(quantity: Quantity, share: Estimate) -> Cell:
    alike = not share.exact and differ_significantly(exactly(1.0), share) is False
    return Cell(with_interval(share.over(0.01)) + (", not to be told from it" if alike else ""), 100 * share.mean)


def _at_worst(packing: Packing, quantity: Quantity) -> str:
    """Say how far a quantity goes from the ideal packing's: ``from 1680 N to 1010 N (60 %, at ...)``."""
    means, left = packing.means(quantity), packing.left(quantity)
    del left[IDEAL]
    worst, best = (choose(left, key=lambda setting: left[setting].mean) for choose in (min, max))
    never = left[worst].mean >= 1 or differ_significantly(means[IDEAL], means[worst]) is False
    setting = best if never else worst
    first, last = (with_interval(means[one], quantity.scale, quantity.unit) for one in (IDEAL, setting))
    share = with_interval(packing.over_ideal(quantity)[setting].over(0.01), unit="%")
    how, end = ("", f" and is nowhere {quantity.worse}") if never else (" at worst", "")
    return f"the {quantity.words} goes from {first} to {last}{how} ({share}, at {_told(setting)}){end}"


def _kept(packing: Packing, quantity: Quantity, axis: Quantity, along: Sequence[Setting]) -> Iterator[str | Cell]:
    """Make a row: values without and with most of an imperfection, and up to which nearly all performance is kept."""
    means, left = packing.means(quantity), {s: one for s, one in packing.left(quantity).items() if s in along}
    last = [setting for setting in along if setting in means][-1]
    n = len(packing.runs[last])
    sure = {setting: one for setting, one in left.items() if math.isfinite(one.half_width)}
    place = crossing([axis.of(s) for s in left], [one.mean for one in left.values()], KEPT)
    surely = crossing([axis.of(s) for s in sure], [one.low for one in sure.values()], KEPT)
    yield from (axis.words.capitalize(), quantity.words.capitalize())
    yield with_interval(means[IDEAL], quantity.scale, quantity.unit)
    yield axis.show(axis.of(last))
    yield with_interval(means[last], quantity.scale, quantity.unit)
    yield with_interval(packing.over_ideal(quantity)[last].over(0.01), unit="%")
    yield "not random" if not packing.random(last) else str(n) if n > 1 else "1: its confidence is not known"
    if place is None:
        nowhere = surely is None and min(one.mean for one in left.values()) >= 1
        yield f"everywhere; nowhere {quantity.worse} than the ideal's" if nowhere else "every value tried"
    else:
        tried = [axis.of(setting) for setting in along]
        below = max((value for value in tried if value <= place), default=0.0)
        above = min((value for value in tried if value > place), default=tried[-1])
        yield f"about {axis.show(place)} (between {below:g} and {axis.show(above)})"
    less = surely is not None and (place is None or surely < place * (1 - _SAME))
    yield axis.show(surely) if less and surely is not None else Cell(BLANK)


def _alike(packing: Packing, quantity: Quantity) -> Iterator[str]:
    """Neighbouring settings whose means may be equal."""
    means = packing.means(quantity)
    for axis in packing.axes:
        for base, along in packing.along(axis).items():
            beside = "" if base == IDEAL else f" at {_told(base)}"
            for first, second in itertools.pairwise(setting for setting in along if setting in means):
                if differ_significantly(means[first], means[second]) is False:
                    yield f"{axis.words} {axis.of(first):g} and {axis.show(axis.of(second))}{beside}"


def _cut_short(run: FinishedRun) -> bool:
    """True if the force on the bottom was largest in the last part of the run, so that it may have grown on."""
    try:
        with Result(run.directory) as result:
            found = reached(result)
    except (MissingOutputError, OutputFormatError):  # only the summary was kept
        return False
    return found is not None and bool(found.time[found.force.argmax()] > (1 - _LATE) * found.time[-1])


def _against(packing: Packing, axis: Quantity) -> Drawing | None:
    """Every quantity against one imperfection, a curve for each setting of the others; None without two values."""
    lines = packing.along(axis)
    settings = [setting for along in lines.values() for setting in along]
    quantities = packing.shown(_PANELS, settings) if lines else []
    if not quantities:
        return None
    rows = -(-len(quantities) // _ACROSS)
    figure, *grid = panels(1.75 * rows + 0.35 * (len(lines) > 1), _ACROSS, rows, width=_WIDTH, sharex=True)
    others = [one for one in packing.axes if one is not axis]
    points = []
    for axes, quantity in zip(grid, quantities, strict=False):
        means = packing.means(quantity)
        for n, (base, along) in enumerate(lines.items()):
            colour = COLOURS[n % len(COLOURS)]
            found = {setting: means[setting] for setting in along if setting in means}
            x = np.array([axis.of(setting) for setting in found])
            mean = np.array([one.mean for one in found.values()]) / quantity.scale
            half = np.nan_to_num([one.half_width for one in found.values()]) / quantity.scale
            axes.fill_between(x, mean - half, mean + half, color=colour, alpha=0.2, linewidth=0)
            called = ", ".join(f"{other.words} {other.show(other.of(base))}" for other in others)
            axes.plot(x, mean, color=colour, marker=_MARKERS[n % len(_MARKERS)], markersize=3.5, label=called)
            for place, setting in zip(x, found, strict=True):
                single = np.array(packing.values(quantity, setting)) / quantity.scale
                if packing.random(setting):
                    axes.plot(np.full(len(single), place), single, ".", color=colour, markersize=3.5, alpha=0.6)
            points += [(quantity.name, *s, one.n, one.mean, one.low, one.high) for s, one in found.items()]
        scale = spread_scales(axes, [axis.of(setting) for setting in settings])
        axes.set_ylabel(quantity.title, fontsize=7)
    for axes in grid[len(quantities) :]:
        axes.set_axis_off()
    for axes in grid[max(0, len(quantities) - _ACROSS) : len(quantities)]:
        axes.set_xlabel(axis.title + scale)
        axes.tick_params(labelbottom=True)
    if len(lines) > 1:
        legend_outside(figure, min(len(lines), 4), fontsize=7)
    heads = ("quantity", *(one.column for one in AXES), "n", "mean", "low_95", "high_95")
    return Drawing(figure, dict(zip(heads, map(np.array, zip(*points, strict=True)), strict=True)))


def _left_of_ideal(packing: Packing, across: Quantity, up: Quantity) -> Drawing | None:
    """Maps of what is left by two imperfections; None where they do not fill a grid."""
    fixed = [axis for axis in AXES if axis not in (across, up)]
    settings = [setting for setting in packing.runs if not any(axis.of(setting) for axis in fixed)]
    columns, lines = (sorted({axis.of(setting) for setting in settings}) for axis in (across, up))
    if min(len(columns), len(lines)) < 2 or len(settings) != len(columns) * len(lines):
        return None
    shown = [one for one in (FORCE, DISSIPATED) if packing.left(one)]
    if not shown:
        return None
    figure, *row = panels(0.32 * len(lines) + 1.25, len(shown), width=_WIDTH, sharey=True)
    table = {axis.column: np.array([getattr(setting, axis.name) for setting in settings]) for axis in (across, up)}
    for axes, quantity in zip(row, shown, strict=True):
        found = packing.over_ideal(quantity)
        shares = np.array([100 * found[setting].mean if setting in found else np.nan for setting in settings])
        numbered_map(axes, shares.reshape(len(columns), len(lines)).T, 100.0, "% of the ideal packing's")
        axes.set_xticks(np.arange(len(columns)) + 0.5, [f"{value:g}" for value in columns])
        axes.set_yticks(np.arange(len(lines)) + 0.5, [f"{value:g}" for value in lines])
        axes.tick_params(which="both", length=0)
        axes.set_xlabel(across.title + not_to_scale(columns))
        axes.set_title(quantity.words.capitalize())
        table[f"{quantity.name}_over_ideal"] = shares / 100
    row[0].set_ylabel(up.title + not_to_scale(lines))
    return Drawing(figure, table)


def convergence(title: str, quantities: Mapping[str, tuple[str, Sequence[float]]]) -> Drawing | None:
    """Half-width of the confidence interval of the first n values; None where nothing is random.

    Parameters
    ----------
    quantities
        Up to three: what each is called in the legend, and its values in the order of the seeds, by the name of its
        columns.
    """
    figure, axes = panels(3.0)
    label(axes, "Seeds", "95 % half-width (% of the mean)", log="xy")
    columns: dict[str, Any] = {}
    for (name, (words, values)), (colour, marker) in zip(quantities.items(), _LOOKS, strict=False):
        if len(values) < _FEWEST_SHOWN or not np.std(values):
            continue
        found = growing(values)[_FEWEST_SHOWN - 2 :]
        mean, seeds = found[-1].mean, np.array([one.n for one in found])
        half = np.array([one.half_width for one in found])
        expected = np.array([half_width(found[-1].deviation, int(n)) for n in seeds])
        axes.plot(seeds, 100 * half / mean, marker, color=colour, markersize=4, label=words)
        axes.plot(seeds, 100 * expected / mean, color=colour, linewidth=0.8)
        root = np.sqrt(seeds[-1] / seeds) * expected[-1]
        axes.plot(seeds, 100 * root / mean, color=colour, linewidth=0.8, linestyle=":")
        columns |= {"n": seeds, f"{name}_half_width": half, f"{name}_expected": expected}
    if not columns:
        return None
    axes.plot([], [], color=GREY, linewidth=0.8, label=r"$t_{n-1} s/\sqrt{n}$, $s$ of all seeds")
    axes.plot([], [], color=GREY, linewidth=0.8, linestyle=":", label=r"$1/\sqrt{n}$")
    most = max(len(values) for _, values in quantities.values())
    ticks_at(axes.xaxis, [n for n in _TICKS if n <= most])
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set_title(title, fontsize=7)
    legend_outside(figure, 2, fontsize=6.5)
    return Drawing(figure, columns)
