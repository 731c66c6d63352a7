"""Figures of packings side by side: confidence by number of seeds, what reaches targets, plates on springs."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np
from matplotlib.ticker import FixedLocator, NullLocator, ScalarFormatter
from numpy.typing import NDArray

from granwave.analysis.figures.scales import ticks_at
from granwave.analysis.figures.series import column_name, legend_outside, one_panel, panels
from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, Drawing
from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.target import Reached
from granwave.analysis.measures.target_theory import Curves
from granwave.analysis.statistics import growing, half_width

_FEWEST_SHOWN = 3  # the interval of two is thirteen standard deviations wide
_LOOKS = (("black", "o"), (BLUE, "s"), (ORANGE, "^"))
_TICKS = (3, 4, 5, 6, 8, 10, 12, 16, 20, 30, 50, 100)


def convergence(title: str, quantities: Mapping[str, tuple[str, Sequence[float]]]) -> Drawing | None:
    """Half-width of the confidence interval of the first n values; None where nothing is random.

    Parameters
    ----------
    quantities
        Up to three: what each is called in the legend, and its values in the order of the seeds, by the name of its
        columns.
    """
    figure, axes = one_panel(3.0, "Seeds", "95 % half-width (% of the mean)", xscale="log", yscale="log")
    columns: dict[str, NDArray] = {}
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


_STYLES = tuple(product(("-", "--", ":"), ("black", BLUE, ORANGE, GREEN, PURPLE, SKY, GREY)))
_COLOURS = ("black", ORANGE, BLUE, GREEN, PURPLE, SKY, GREY)  # of bottoms
_LINES, _MARKERS = ("-", "--", ":", "-."), "os^Dv"  # of friction
_MICRO = 1e6


def reached_targets(targets: Mapping[str, tuple[Reached, Array, Array]]) -> Drawing:
    """Force, impulse and energy against time.

    Parameters
    ----------
    targets
        By name: record of the target, and times, s, with the work on the target by then, J, (n_instants,) each.
    """
    figure, *stack = panels(5.6, rows=3, width=4.6, sharex=True)
    columns: dict[str, Array] = {}
    for (name, (reached, ledger, energy)), (line, colour) in zip(targets.items(), _STYLES, strict=False):
        word = column_name(name)
        columns |= {f"{word}_time_s": reached.time, f"{word}_energy_time_s": ledger}
        shown = (
            ("Force (N)", reached.time, reached.force, 1.0, "force_N"),
            ("Impulse (mN s)", reached.time, reached.impulse, 1e-3, "impulse_Ns"),
            ("Energy (mJ)", ledger, energy, 1e-3, "energy_J"),
        )
        for axes, (label, time, values, unit, column) in zip(stack, shown, strict=True):
            axes.plot(_MICRO * time, values / unit, line, color=colour, linewidth=1.0, label=name)
            axes.set_ylabel(label)
            columns[f"{word}_{column}"] = values
    stack[-1].set(xlabel="Time (µs)", xlim=(0, _MICRO * max(reached.time[-1] for reached, _, _ in targets.values())))
    legend_outside(figure, 2, fontsize=7)
    return Drawing(figure, columns)


@dataclasses.dataclass(frozen=True, eq=False)
class Heights:
    """Packings of several heights on one bottom.

    Attributes
    ----------
    name
        Of the bottom, and of what else tells these packings from others.
    layers, reduction, gain_per_mass, mass
        Of each: layers, peak reduction, what a kilogram adds to it, 1/kg, and mass, kg: (n_packings,).
    """

    name: str
    bottom: str
    friction: float
    layers: Array
    reduction: Array
    gain_per_mass: Array
    mass: Array


def reductions(found: Sequence[Heights]) -> Drawing:
    """Peak reduction, and what a kilogram adds to it, against layers: a colour for each bottom, a mark for friction."""
    figure, *row = panels(2.9, 2, width=7.0, sharex=True)
    columns: dict[str, Array] = {}
    bottoms, frictions = list(dict.fromkeys(one.bottom for one in found)), sorted({one.friction for one in found})
    for one in found:
        place, colour = frictions.index(one.friction), _COLOURS[bottoms.index(one.bottom) % len(_COLOURS)]
        look = f"{_MARKERS[place % len(_MARKERS)]}{_LINES[place % len(_LINES)]}"
        for axes, values in zip(row, (one.reduction, one.gain_per_mass), strict=True):
            (line,) = axes.plot(one.layers, values, look, color=colour, label=one.name)
            line.set(markersize=3.5, markerfacecolor="none" if place else colour)
        word = column_name(one.name)
        columns |= {f"{word}_layers": one.layers, f"{word}_reduction": one.reduction}
        columns |= {f"{word}_per_kg": one.gain_per_mass, f"{word}_mass_kg": one.mass}
    ticks = sorted({float(layers) for one in found for layers in one.layers})
    for axes, label in zip(row, ("Peak reduction", "(Peak reduction - 1) per mass (1/kg)"), strict=True):
        axes.set(xlabel="Layers", ylabel=label, xscale="log")
        axes.xaxis.set(major_locator=FixedLocator(ticks), minor_locator=NullLocator())
        axes.xaxis.set_major_formatter("{x:g}")
    row[0].set_yscale("log")
    row[0].yaxis.set(major_formatter=ScalarFormatter(), minor_formatter=ScalarFormatter())
    legend_outside(figure, 3, fontsize=7)
    return Drawing(figure, columns)


@dataclasses.dataclass(frozen=True, eq=False)
class Plates:
    """Plates of one mass on springs, below a packing.

    Attributes
    ----------
    name
        Of the plates and the packing.
    period, displacement, without
        Of each: period, s, largest displacement below the packing and without it, m: (n_plates,).
    theory
        Of plates that do not give way.
    """

    name: str
    period: Array
    displacement: Array
    without: Array
    theory: Curves


def shock_spectra(found: Sequence[Plates]) -> Drawing:
    """Largest displacement of plates on springs against their period, with the theory."""
    figure, axes = one_panel(4.4, "Period of the plate (µs)", "Largest displacement (µm)", 4.6)
    axes.set(xscale="log", yscale="log")
    columns: dict[str, Array] = {}
    for one, colour, marker in zip(found, (BLUE, ORANGE, GREY), "os^", strict=False):
        period, theory, word = _MICRO * one.period, one.theory, column_name(one.name)
        points: dict[str, Any] = {"color": colour, "markersize": 4}
        curves: dict[str, Any] = {"color": colour, "linewidth": 0.9}
        label = f"below the packing: {one.name}"
        axes.plot(period, _MICRO * one.displacement, marker, label=label, **points)
        axes.plot(period, _MICRO * one.without, marker, markerfacecolor="none", label="without it", **points)
        period = _MICRO * theory.period
        axes.plot(period, _MICRO * theory.oscillator, "-", label="oscillator", **curves)
        axes.plot(period, _MICRO * theory.slow_force, ":", label="slow force, F/k", **curves)
        axes.plot(period, _MICRO * theory.short_impulse, "--", label="short impulse, J/(Mω)", **curves)
        columns |= {
            f"{word}_period_s": one.period, f"{word}_displacement_m": one.displacement,
            f"{word}_without_m": one.without, f"{word}_line_period_s": theory.period,
            f"{word}_oscillator_m": theory.oscillator, f"{word}_slow_force_m": theory.slow_force,
            f"{word}_short_impulse_m": theory.short_impulse,
        }  # fmt: skip
    axes.set_ylim(0.3 * _MICRO * min(one.displacement.min() for one in found))
    legend_outside(figure, 2, fontsize=7)
    return Drawing(figure, columns)
