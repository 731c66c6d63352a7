"""Peak reduction against the height of the packing, and what a kilogram and a metre of it do."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.ticker import FixedLocator, NullLocator, ScalarFormatter
from numpy.typing import NDArray

from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, Drawing, new_figure
from granwave.analysis.formatting.numbers import number
from granwave.analysis.measures.signals import power
from granwave.analysis.studies.protection import tables
from granwave.analysis.studies.protection.runs import TargetRun, names, series, slug
from granwave.analysis.studies.study import Picture, Study
from granwave.analysis.studies.titles import impact_words

_COLOURS = ("black", ORANGE, BLUE, GREEN, PURPLE, SKY, GREY)
_LINES, _MARKERS = ("-", "--", ":", "-."), "os^Dv"
_COLUMNS = (
    tables.HEIGHT, tables.MASS, tables.FORCE, tables.UNPROTECTED, tables.REDUCTION, tables.PER_MASS, tables.PER_HEIGHT,
    tables.GAIN_PER_MASS, tables.IMPULSE, tables.ENERGY,
)  # fmt: skip


def heights(runs: Sequence[TargetRun], suffix: str) -> Iterator[Study]:
    """One study of all bottoms with a series of heights."""
    found = [[run for run in one if math.isfinite(run.value("peak_reduction"))] for one in series(runs)]
    found = [one for one in found if len(one) > 2]
    if not found:
        return
    every = [run for one in found for run in one]
    caption = "Peak force without the packing over that with it, and what a kilogram adds to it, by layers"
    yield Study(
        f"protected-height{suffix}",
        f"Protected target, by height: {impact_words(every[0].case, height=False)}",
        "The same impact through packings of more and more layers. Reduction: the peak force of the same impact "
        "directly on the target over that on the target below the packing; also over the mass of the packing and over "
        "its height. What a kilogram adds: the reduction less 1, which is that of no packing, over the mass.",
        pictures=(Picture(f"protected_height{suffix.replace('-', '_')}", caption, _draw(found)),),
        tables=(tables.table("Peak reduction by height", every, _COLUMNS),),
        verdict=tuple(map(_verdict, found)),
    )


def _verdict(runs: Sequence[TargetRun]) -> str:
    reduction = np.array([run.value("peak_reduction") for run in runs])
    gained = [tables.GAIN_PER_MASS.value(run) for run in runs]
    layers = np.array([float(run.layers) for run in runs])
    fit, best = power(layers, reduction), runs[int(np.argmax(gained))]
    friction = f", friction {runs[0].friction:g}" if runs[0].case.rubs else ""
    bottom = runs[0].bottom[:1].upper() + runs[0].bottom[1:]
    return (
        f"{bottom}{friction}: from {runs[0].layers} to {runs[-1].layers} layers "
        f"the peak reduction goes from {number(reduction[0])} to {number(reduction[-1])} times, about as "
        f"layers^{fit.exponent:.2g}; a kilogram adds most in {best.layers} layers "
        f"({number(max(gained))} times a kg)."
    )


def _draw(found: Sequence[Sequence[TargetRun]]) -> Drawing:
    figure = new_figure(2.9, 7.0)
    left, right = figure.subplots(1, 2, sharex=True)
    columns: dict[str, NDArray[np.float64]] = {}
    bottoms = list(dict.fromkeys(runs[0].bottom for runs in found))
    frictions = sorted({runs[0].friction for runs in found})
    for runs, name in zip(found, names([runs[-1] for runs in found]), strict=True):
        name = name.replace(f", {runs[-1].layers} layers", "")
        layers = np.array([float(run.layers) for run in runs])
        place = frictions.index(runs[0].friction)
        look = dict(
            color=_COLOURS[bottoms.index(runs[0].bottom) % len(_COLOURS)],
            linestyle=_LINES[place % len(_LINES)],
            marker=_MARKERS[place % len(_MARKERS)],
            markersize=3.5,
            markerfacecolor="none" if place else None,
        )
        word = slug(name)
        columns[f"{word}_layers"] = layers
        panels = ((left, "reduction", tables.REDUCTION), (right, "per_kg", tables.GAIN_PER_MASS))
        for axes, key, quantity in panels:
            values = np.array([quantity.value(run) for run in runs])
            axes.plot(layers, values, label=name, **look)
            columns[f"{word}_{key}"] = values
        columns[f"{word}_mass_kg"] = np.array([run.value("packing_mass_kg") for run in runs])
    ticks = sorted({run.layers for runs in found for run in runs})
    for axes, label in ((left, "Peak reduction"), (right, "(Peak reduction - 1) per mass (1/kg)")):
        axes.set_xlabel("Layers")
        axes.set_ylabel(label)
        axes.set_xscale("log")
        axes.xaxis.set_major_locator(FixedLocator(ticks))
        axes.xaxis.set_minor_locator(NullLocator())
        axes.xaxis.set_major_formatter(ScalarFormatter())
    handles, labels = left.get_legend_handles_labels()
    left.set_yscale("log")
    left.yaxis.set_major_formatter(ScalarFormatter())
    left.yaxis.set_minor_formatter(ScalarFormatter())
    figure.legend(handles, labels, loc="outside upper center", ncols=3, fontsize=7)
    return Drawing(figure, columns)
