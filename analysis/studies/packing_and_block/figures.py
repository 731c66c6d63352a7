"""Figures of impacts on packings and on blocks: dissipated fraction and volumes involved, against the input energy."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
import pandas as pd
from pandas import DataFrame

from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, Drawing
from granwave.analysis.measures.impact import QuadraticLaw
from granwave.analysis.studies.packing_and_block.impacts import (
    SAME,
    Curves,
    Impacts,
    dissipation,
    energy_unit,
    involved,
    masses,
    variants,
)

FRACTION = "Dissipation / input energy"
GRANULAR_ENERGY = r"Input energy $e_\mathrm{in}/(F_\mathrm{y}\,\alpha_\mathrm{y})$"
CONTINUUM_ENERGY = r"Input energy $e_\mathrm{in} E/(\sigma_\mathrm{y}^2 D^3)$"

_SHOWN_SHARE = 0.95  # of the dissipation: how far curves of cumulated dissipation go
_COLOURS = ("black", BLUE, ORANGE, GREEN, PURPLE, SKY, GREY)
_MARKERS = "os^DvP*"
_OF_PACKINGS = (BLUE, SKY, "black")


def columns_of(curves: Curves, names: Sequence[str]) -> dict[str, list]:
    """Columns of all curves, for the data of a figure; ``curve`` is the name of each."""
    table = pd.concat([runs.assign(curve=name) for name, runs in curves.items()])
    return table[list(names)].to_dict("list")


def open_look(n: int) -> dict[str, Any]:
    """The reference as a line with points, the others as open marks."""
    if n == 0:
        return {"color": _COLOURS[0], "marker": ".", "linewidth": 0.8}
    return {**look(n), "markerfacecolor": "none", "linestyle": "none", "markersize": 5}


def look(n: int) -> dict[str, Any]:
    """Colour and marker of the n-th curve."""
    return {"color": _COLOURS[n % len(_COLOURS)], "marker": _MARKERS[n % len(_MARKERS)]}


def scaling(curves: Curves, title: str, scale: Literal["linear", "log"]) -> Drawing:
    """Draw the dissipated fraction against input energy, in J and normalised."""
    figure, left, right = panels(2.6, 2, sharey=True)
    for n, (name, runs) in enumerate(curves.items()):
        left.plot(runs.energy_J, runs.dissipated_fraction, label=name, **open_look(n))
        right.plot(runs.energy_normalised, runs.dissipated_fraction, **open_look(n))
    columns = columns_of(curves, ("curve", "energy_J", "energy_normalised", "dissipated_fraction"))
    label(left, "Input energy (J)", FRACTION, ylim=(0, max(1.0, 1.05 * max(columns["dissipated_fraction"]))))
    label(right, title)
    figure.legend(loc="outside upper center", ncols=2, fontsize=7, columnspacing=1.0)
    for axes in (left, right):
        axes.set_xscale(scale)
        if scale == "linear":
            axes.set_xlim(left=0)
    return Drawing(figure, columns)


def dissipated_fraction(impacts: Impacts) -> Drawing:
    """Draw the fraction against input energy of both, by sigma_y^2 D^3/E with the diameter of the punch.

    Spheres of the reference material alone are shown, by diameter: the unit is then the same for all.
    """
    first = impacts.reference.iloc[0]
    unit = energy_unit(first, impacts.continuum_reference.diameter.iloc[0])
    figure, axes = panels(2.8)
    constants = ["youngs_modulus", "poisson_ratio", "density", "yield_strength"]
    like = [runs for runs in variants(impacts).values() if runs.iloc[0][constants].equals(first[constants])]
    curves = {
        f"granular, D = {1e3 * runs.diameter.iloc[0]:.4g} mm": runs.assign(energy_normalised=runs.energy_J / unit)
        for runs in like
    }
    curves |= {f"continuum, {mass}": runs for mass, runs in masses(impacts).items()}
    for n, (name, runs) in enumerate(curves.items()):
        k = n - len(like)
        style = {"color": _OF_PACKINGS[n % 3], "marker": "os^"[n % 3]}
        if k >= 0:
            style = {"color": ORANGE, "marker": "vD*"[k % 3], "linestyle": ("-", "--", ":")[k % 3]}
        axes.plot(runs.energy_normalised, runs.dissipated_fraction, label=name, markersize=4, linewidth=0.8, **style)
    energy_axis = r"Input energy $e_\mathrm{in} E/(\sigma_\mathrm{y}^2 D_\mathrm{punch}^3)$"
    label(axes, energy_axis, FRACTION, log="x", ylim=(0, 1))
    axes.legend(loc="lower center", bbox_to_anchor=(0.58, 0.03), fontsize=6)
    return Drawing(figure, columns_of(curves, ("curve", "energy_normalised", "dissipated_fraction")))


def plastic_volume(packings: DataFrame, blocks: DataFrame) -> Drawing:
    """Draw the volume that dissipates a fraction of the input: granular curves, continuum marks."""
    unit = math.pi * blocks.diameter.iloc[0] ** 3 / 6
    figure, axes = panels(2.8)
    parts: list[tuple[str, Any, Any]] = []
    for run, colour in zip(packings.itertuples(), _OF_PACKINGS, strict=False):
        if found := involved(run):
            enough, name = found.enough(_SHOWN_SHARE) + 1, f"granular, {run.energy_J:.3g} J"
            axes.plot(found.fraction[:enough], found.volume[:enough] / unit, color=colour, label=name)
            parts.append((name, found.fraction, found.volume / unit))
    for n, one in enumerate(blocks.itertuples()):
        mark, name = _MARKERS[n % len(_MARKERS)], f"continuum, {one.energy_J:.3g} J"
        fraction, volumes = one.dissipated_fraction, (one.volume_over_sphere_volume, one.volume_ever_over_sphere_volume)
        axes.plot(fraction, volumes[0], mark, color=ORANGE, markersize=4.5, label=name)
        axes.plot(fraction, volumes[1], mark, color=ORANGE, markerfacecolor="none", markersize=4.5)
        parts += [(name, [fraction], volumes[:1]), (f"{name}, ever", [fraction], volumes[1:])]
    label(axes, FRACTION, r"Volume $/(\pi D_\mathrm{punch}^3/6)$", log="y", xlim=(0, 1))
    axes.set_title("open marks: volume that ever yielded", fontsize=7)
    axes.legend(fontsize=6, ncols=2, loc="lower right")
    names = ("curve", "dissipated_fraction", "volume_over_sphere_volume")
    return Drawing(figure, pd.concat(DataFrame(dict(zip(names, part, strict=True))) for part in parts).to_dict("list"))


def against_velocity(runs: DataFrame, fit: QuadraticLaw) -> Drawing:
    """Draw the dissipation and its fraction of the input, with the quadratic law."""
    v, lost = dissipation(runs)
    fine = np.geomspace(fit.lowest, v[-1], 200)
    figure, left, right = panels(2.6, 2)
    left.plot(fine, fit(fine), color=ORANGE, label="quadratic law")
    positive = lost > 0
    left.plot(v[positive], lost[positive], "o", color=BLUE, markersize=4, label="simulation")
    title = r"Dissipation $\bar e_\mathrm{dis}$, in units in which $\bar e_\mathrm{in} = \bar v_0^2/2$"
    label(left, r"Impact velocity $\bar v_0$", title, log="xy")
    left.yaxis.label.set_fontsize(7)
    left.legend()
    right.plot(0.5 * fine**2, fit(fine) / (0.5 * fine**2), color=ORANGE)
    right.plot(0.5 * v**2, lost / (0.5 * v**2), "o", color=BLUE, markersize=4)
    label(right, r"Input energy $\bar e_\mathrm{in} = \bar v_0^2/2$", FRACTION, log="x", ylim=(0, 1))
    columns = {"velocity_normalised": v, "dissipation_normalised": lost, "dissipated_fraction": lost / (0.5 * v**2)}
    inside = v >= fit.lowest * (1 - SAME)
    return Drawing(figure, columns | {"quadratic_law": np.where(inside, fit(v), np.nan)})


def loading_area(curves: Curves) -> Drawing:
    """Draw the dissipated fraction against input energy for 1, 3 and 7 struck spheres."""
    figure, axes = panels(2.6)
    for n, (name, runs) in enumerate(curves.items()):
        axes.plot(runs.energy_normalised, runs.dissipated_fraction, label=name, **open_look(n))
    label(axes, GRANULAR_ENERGY, FRACTION, log="x", ylim=(0, 1))
    axes.legend()
    return Drawing(figure, columns_of(curves, ("struck_spheres", "energy_normalised", "dissipated_fraction")))


def by_mass(curves: Curves) -> Drawing:
    """Draw dissipated fraction and plastic volume against input energy by mass of the punch."""
    figure, left, right = panels(2.6, 2)
    for n, (name, runs) in enumerate(curves.items()):
        style = look(n) | {"markerfacecolor": "none", "markersize": 5 if n else 3, "linewidth": 0.5 if n else 0.8}
        left.plot(runs.energy_normalised, runs.dissipated_fraction, label=name, **style)
        right.plot(runs.energy_normalised, runs.volume_over_sphere_volume, label=name, **style)
        ever = runs.volume_ever_over_sphere_volume
        right.plot(runs.energy_normalised, ever, ":", color=style["color"], linewidth=0.8)
    label(left, CONTINUUM_ENERGY, FRACTION, log="x", ylim=(0, None))
    left.legend()
    label(right, CONTINUUM_ENERGY, r"Plastic volume $/(\pi D^3/6)$", xlim=(0, None), ylim=(0, None))
    right.set_title("full: largest at one instant, dotted: that ever yielded", fontsize=7)
    volumes = ("volume_over_sphere_volume", "volume_ever_over_sphere_volume")
    return Drawing(figure, columns_of(curves, ("mass_kg", "energy_normalised", "dissipated_fraction", *volumes)))
