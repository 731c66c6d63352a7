"""Peak reduction against the height of the packing, and what a kilogram and a metre of it do."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.ticker import ScalarFormatter

from granwave.analysis.document.model import DocumentTable
from granwave.analysis.figures.scales import ticks_at
from granwave.analysis.figures.series import column_name, legend_outside, panels
from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, Drawing
from granwave.analysis.measures.signals import Array, power
from granwave.analysis.statistics import exactly
from granwave.analysis.studies.protection.runs import TargetRun, impacts, names, series, table
from granwave.analysis.studies.runs import FinishedRun, impact_title
from granwave.analysis.studies.study import Picture, span

AllSeries = Sequence[Sequence[TargetRun]]

_COLOURS = ("black", ORANGE, BLUE, GREEN, PURPLE, SKY, GREY)  # of bottoms
# of friction
_LINES = ("-", "--", ":", "-.")
_MARKERS = "os^Dv"
_SHOWN = {
    "peak_reduction": "reduction",
    "gain_per_kg": "per_kg",
    "packing_mass_kg": "mass_kg",
}  # names of columns
TEXT = (
    "The same impact through packings of more and more layers. Reduction: the peak force of the same impact "
    "directly on the target over that on the target below the packing; also over the mass of the packing and over "
    "its height. What a kilogram adds: the reduction less 1, which is that of no packing, over the mass."
)


def select(runs: Sequence[FinishedRun]) -> list[list[list[TargetRun]]]:
    """All bottoms with a series of heights, for each impact."""
    found = [
        [
            [run for run in one if math.isfinite(run.value("peak_reduction"))]
            for one in series(group)
        ]
        for group in impacts(runs)
    ]
    long = ([one for one in group if len(one) > 2] for group in found)
    return [group for group in long if group]


def title(found: AllSeries) -> str:
    """Title with packing and impact."""
    return f"Protected target, by height: {impact_title(found[0][0].assembly, height=False)}"


def tables(found: AllSeries) -> list[DocumentTable]:
    """All runs."""
    return [table("Peak reduction by height", [run for one in found for run in one], "H")]


def verdict(found: AllSeries) -> Iterator[str]:
    """The reduction of each series."""
    for runs, name in zip(found, _names(found), strict=True):
        reduction, layers = np.array([(run.value("peak_reduction"), run.layers) for run in runs]).T
        values = {
            f"{n:g} layers": exactly(value) for n, value in zip(layers, reduction, strict=True)
        }
        exponent = power(layers, reduction).exponent
        yield f"{span(f'Peak reduction, {name}', values)} It goes about as layers^{exponent:.2g}."


def _names(found: AllSeries) -> list[str]:
    """Label each series by its bottom, and friction where that differs."""
    highest = [runs[-1] for runs in found]
    return [
        name.replace(f", {run.layers} layers", "")
        for name, run in zip(names(highest), highest, strict=True)
    ]


def pictures(found: AllSeries) -> Iterator[Picture]:
    """Reduction, and what a kilogram adds, against layers: a colour for each bottom, a mark for
    friction.
    """
    figure, *row = panels(2.9, 2, width=7.0, sharex=True)
    columns: dict[str, Array] = {}
    bottoms = list(dict.fromkeys(runs[0].bottom for runs in found))
    frictions = sorted({runs[0].friction for runs in found})
    for runs, name in zip(found, _names(found), strict=True):
        place = frictions.index(runs[0].friction)
        colour = _COLOURS[bottoms.index(runs[0].bottom) % len(_COLOURS)]
        layers = np.array([float(run.layers) for run in runs])
        values = {
            column: np.array([run.value(key) for run in runs]) for key, column in _SHOWN.items()
        }
        for axes, column in zip(row, values, strict=False):
            look = f"{_MARKERS[place % len(_MARKERS)]}{_LINES[place % len(_LINES)]}"
            (line,) = axes.plot(layers, values[column], look, color=colour, label=name)
            line.set(markersize=3.5, markerfacecolor="none" if place else colour)
        columns |= {
            f"{column_name(name)}_{column}": one
            for column, one in {"layers": layers, **values}.items()
        }
    for axes, label in zip(
        row, ("Peak reduction", "(Peak reduction - 1) per mass (1/kg)"), strict=True
    ):
        axes.set(xlabel="Layers", ylabel=label, xscale="log")
        ticks_at(axes.xaxis, sorted({run.layers for runs in found for run in runs}))
    row[0].set_yscale("log")
    row[0].yaxis.set(major_formatter=ScalarFormatter(), minor_formatter=ScalarFormatter())
    legend_outside(figure, 3, fontsize=7)
    caption = (
        "Peak force without the packing over that with it, and what a kilogram adds to it, against the number of "
        "layers. Above 1 the packing protects; where the right-hand curve is highest, its mass pays most"
    )
    yield Picture("", caption, Drawing(figure, columns))
