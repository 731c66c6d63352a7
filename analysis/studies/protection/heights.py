"""Peak reduction against the height of the packing, also per kilogram and per metre."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import chain

import numpy as np
from matplotlib.ticker import ScalarFormatter

from granwave.analysis.document.model import DocumentTable
from granwave.analysis.figures.scales import ticks_at
from granwave.analysis.figures.series import column_name, legend_outside, panels
from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, Drawing
from granwave.analysis.measures.signals import Array, power
from granwave.analysis.statistics import exactly
from granwave.analysis.studies.protection.runs import (
    FEWEST_HEIGHTS,
    TargetRun,
    impacts,
    names,
    series,
    table,
)
from granwave.analysis.studies.runs import FinishedRun, impact_title
from granwave.analysis.studies.study import Picture, span

AllSeries = Sequence[Sequence[TargetRun]]

NEEDS = f"packings of at least {FEWEST_HEIGHTS} heights under the same impact on the same bottom"
_COLOURS = ("black", ORANGE, BLUE, GREEN, PURPLE, SKY, GREY)  # one for each bottom
_LINES = ("-", "--", ":", "-.")  # one for each friction
_MARKERS = "os^Dv"  # one for each friction
#: Names of columns by quantity; the first ones have a panel.
_SHOWN = {"peak_reduction": "reduction", "gain_per_kg": "per_kg", "packing_mass_kg": "mass_kg"}
_LABELS = ("Peak reduction", "(Peak reduction - 1) per mass (1/kg)")
TEXT = (
    "The same impact acts on packings with an increasing number of layers. The reduction is the "
    "peak force of the same impact directly on the target, divided by the peak force on the "
    "target below the packing. It is also given per mass and per height of the packing. The "
    "gain per kilogram is the reduction minus 1 (the value without packing), divided by the "
    "mass."
)


def select(runs: Sequence[FinishedRun]) -> list[list[list[TargetRun]]]:
    """Series of heights on all bottoms, for each impact."""
    groups = []
    for impact in impacts(runs):
        reductions = [_with_reduction(candidates) for candidates in series(impact)]
        all_series = [runs for runs in reductions if len(runs) >= FEWEST_HEIGHTS]
        if all_series:
            groups.append(all_series)
    return groups


def _with_reduction(runs: Sequence[TargetRun]) -> list[TargetRun]:
    """Runs whose peak reduction is known."""
    return [run for run in runs if math.isfinite(run.value("peak_reduction"))]


def title(all_series: AllSeries) -> str:
    """Title with packing and impact."""
    return f"Protected target, by height: {impact_title(all_series[0][0].assembly, height=False)}"


def tables(all_series: AllSeries) -> list[DocumentTable]:
    """All runs."""
    return [table("Peak reduction by height", list(chain.from_iterable(all_series)), "H")]


def verdict(all_series: AllSeries) -> Iterator[str]:
    """The reduction of each series."""
    for runs, name in zip(all_series, _names(all_series), strict=True):
        reduction = np.array([run.value("peak_reduction") for run in runs])
        layers = np.array([float(run.layers) for run in runs])
        values = {
            f"{n:g} layers": exactly(value) for n, value in zip(layers, reduction, strict=True)
        }
        exponent = power(layers, reduction).exponent
        trend = f"It is about proportional to layers^{exponent:.2g}."
        yield f"{span(f'Peak reduction, {name}', values)} {trend}"


def _names(all_series: AllSeries) -> list[str]:
    """Label each series by its bottom, and by friction if it differs."""
    highest = [runs[-1] for runs in all_series]
    return [
        name.replace(f", {run.layers} layers", "")
        for name, run in zip(names(highest), highest, strict=True)
    ]


def pictures(all_series: AllSeries) -> Iterator[Picture]:
    """Reduction, and its gain per kilogram, against layers: a colour for each bottom, a mark for
    each friction.
    """
    figure, *row = panels(2.9, 2, width=7.0, sharex=True)
    columns: dict[str, Array] = {}
    bottoms = list(dict.fromkeys(runs[0].bottom for runs in all_series))
    frictions = sorted({runs[0].friction for runs in all_series})
    for runs, name in zip(all_series, _names(all_series), strict=True):
        place = frictions.index(runs[0].friction)
        colour = _COLOURS[bottoms.index(runs[0].bottom) % len(_COLOURS)]
        layers = np.array([float(run.layers) for run in runs])
        values = {}
        for key, column in _SHOWN.items():
            values[column] = np.array([run.value(key) for run in runs])
        for axes, column in zip(row, values, strict=False):
            look = f"{_MARKERS[place % len(_MARKERS)]}{_LINES[place % len(_LINES)]}"
            (line,) = axes.plot(layers, values[column], look, color=colour, label=name)
            line.set(markersize=3.5, markerfacecolor="none" if place else colour)
        columns[f"{column_name(name)}_layers"] = layers
        for column, series_values in values.items():
            columns[f"{column_name(name)}_{column}"] = series_values
    heights = sorted({run.layers for run in chain.from_iterable(all_series)})
    for axes, label in zip(row, _LABELS, strict=True):
        axes.set(xlabel="Layers", ylabel=label, xscale="log")
        ticks_at(axes.xaxis, heights)
    row[0].set_yscale("log")
    row[0].yaxis.set(major_formatter=ScalarFormatter(), minor_formatter=ScalarFormatter())
    legend_outside(figure, 3, fontsize=7)
    caption = (
        "Peak force without the packing divided by the peak force with it, and gain per "
        "kilogram, against the number of layers. Above 1 the packing protects; at the maximum "
        "of the right-hand curve its mass is most effective"
    )
    yield Picture("", caption, Drawing(figure, columns))
