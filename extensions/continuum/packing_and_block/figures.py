"""Figures of impacts on packings and on blocks against the input energy, and of peak forces.

For both: the dissipated fraction, and the volumes that dissipate. For a packing at several
velocities: the peak force of every contact, which is proportional to the impulse, and the front
before reflections from the base. The impulse is the momentum of the impacted spheres; forces are in
F_y.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import Any, Literal, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from pandas import DataFrame, Series

from granwave.analysis.document.model import DocumentTable, named, show
from granwave.analysis.figures.edges import mark_outside
from granwave.analysis.figures.series import label, legend_outside, panels
from granwave.analysis.figures.style import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    Drawing,
    legend_above,
)
from granwave.analysis.measures.geometry import layers, preferred_directions
from granwave.analysis.measures.impact import QuadraticLaw, rays
from granwave.analysis.measures.layer_peaks import layer_peaks, spheres_of_later_waves
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.study import Picture, numeric, table_of
from granwave.extensions.continuum.packing_and_block.impacts import (
    SAME,
    Curves,
    Impacts,
    dissipation,
    energy_unit,
    involved,
    masses,
    omitted_in_words,
    variants,
)
from granwave.lammps_inputs.errors import GranwaveError

FRACTION = "Dissipation / input energy"
GRANULAR_ENERGY = r"Input energy $e_\mathrm{in}/(F_\mathrm{y}\,\alpha_\mathrm{y})$"
CONTINUUM_ENERGY = r"Input energy $e_\mathrm{in} E/(\sigma_\mathrm{y}^2 D^3)$"

_SHOWN_SHARE = 0.95  # fraction of the dissipation up to which cumulated curves are drawn
_COLOURS = ("black", BLUE, ORANGE, GREEN, PURPLE, SKY, GREY)
_MARKERS = "os^DvP*"
_OF_PACKINGS = (BLUE, SKY, "black")


def columns_of(curves: Curves, names: Sequence[str]) -> dict[str, list]:
    """Columns of all curves, for the data of a figure; ``curve`` is the name of each."""
    table = pd.concat([runs.assign(curve=name) for name, runs in curves.items()])
    return table[list(names)].to_dict("list")


def look(n: int, *, lines: bool = True) -> dict[str, Any]:
    """Return colour and marker of the n-th curve. Without lines only the first curve, the
    reference, has a line; the others have open marks.
    """
    appearance: dict[str, Any] = {
        "color": _COLOURS[n % len(_COLOURS)],
        "marker": _MARKERS[n % len(_MARKERS)],
    }
    if lines:
        return appearance
    if n == 0:
        return appearance | {"marker": ".", "linewidth": 0.8}
    return appearance | {"markerfacecolor": "none", "linestyle": "none", "markersize": 5}


_LETTERS = 120  # characters of a legend across two panels
_GAP = 9  # characters that the mark and the gaps of an entry occupy


def scaling(curves: Curves, title: str, scale: Literal["linear", "log"]) -> Drawing:
    """Draw the dissipated fraction against input energy, in J and normalised."""
    figure, *row = panels(2.6, 2, sharey=True)
    columns = columns_of(curves, ("curve", "energy_J", "energy_normalised", "dissipated_fraction"))
    for axes, energy, quantity in zip(
        row, ("energy_J", "energy_normalised"), ("Input energy (J)", title), strict=True
    ):
        for n, (name, runs) in enumerate(curves.items()):
            axes.plot(
                runs[energy],
                runs.dissipated_fraction,
                label=name,
                clip_on=False,  # points on an axis are whole
                **look(n, lines=False),
            )
        label(axes, quantity, xscale=scale)
        if scale == "linear":
            axes.set_xlim(left=0)
    label(row[0], y=FRACTION, ylim=(0, max(1.0, 1.05 * max(columns["dissipated_fraction"]))))
    per_row = max(1, _LETTERS // (_GAP + max(map(len, curves))))
    legend_outside(figure, per_row, fontsize=7, columnspacing=1.0)
    return Drawing(figure, columns)


def _like_first(impacts: Impacts) -> list[DataFrame]:
    """Return the curves of packings of the reference material, by diameter and loading area."""
    constants = ["youngs_modulus", "poisson_ratio", "density", "yield_strength"]
    first = impacts.reference.iloc[0][constants]
    return [runs for runs in variants(impacts).values() if runs.iloc[0][constants].equals(first)]


def drawn_fractions(impacts: Impacts) -> DataFrame:
    """Return the runs that `dissipated_fraction` draws."""
    return pd.concat([*_like_first(impacts), *masses(impacts).values()])


def dissipated_fraction(impacts: Impacts) -> Drawing:
    """Draw the dissipated fraction of packings and blocks against the input energy in units of
    sigma_y^2 D^3/E, where D is the diameter of the punch.

    Only spheres of the reference material are shown, a curve for each diameter: the unit is then
    the same for all.
    """
    first = impacts.reference.iloc[0]
    unit = energy_unit(first, impacts.continuum_reference.diameter.iloc[0])
    figure, axes = panels(2.8)
    like = _like_first(impacts)
    curves = {
        f"granular, D = {1e3 * runs.diameter.iloc[0]:.4g} mm": runs.assign(
            energy_normalised=runs.energy_J / unit
        )
        for runs in like
    }
    curves |= {f"continuum, {mass}": runs for mass, runs in masses(impacts).items()}
    for n, (name, runs) in enumerate(curves.items()):
        k = n - len(like)
        style = {"color": _OF_PACKINGS[n % 3], "marker": "os^"[n % 3]}
        if k >= 0:
            style = {"color": ORANGE, "marker": "vD*"[k % 3], "linestyle": ("-", "--", ":")[k % 3]}
        axes.plot(
            runs.energy_normalised,
            runs.dissipated_fraction,
            label=name,
            markersize=4,
            linewidth=0.8,
            clip_on=False,
            **style,
        )
    energy_axis = r"Input energy $e_\mathrm{in} E/(\sigma_\mathrm{y}^2 D_\mathrm{punch}^3)$"
    label(axes, energy_axis, FRACTION, log="x", ylim=(0, 1))
    axes.legend(loc="lower center", bbox_to_anchor=(0.58, 0.03), fontsize=6)
    return Drawing(
        figure, columns_of(curves, ("curve", "energy_normalised", "dissipated_fraction"))
    )


def plastic_volume(packings: DataFrame, blocks: DataFrame) -> Drawing:
    """Draw the volume that dissipates a fraction of the input: granular curves, continuum marks."""
    unit = math.pi * blocks.diameter.iloc[0] ** 3 / 6
    figure, axes = panels(3.1)
    parts: list[tuple[str, Any, Any]] = []
    for run, colour in zip(packings.itertuples(), _OF_PACKINGS, strict=False):
        if elements := involved(run):
            enough = elements.enough(_SHOWN_SHARE) + 1
            name = f"granular, {run.energy_J:.3g} J"
            axes.plot(
                elements.fraction[:enough],
                elements.volume[:enough] / unit,
                color=colour,
                label=name,
            )
            parts.append((name, elements.fraction, elements.volume / unit))
    for n, block in enumerate(blocks.itertuples()):
        mark = _MARKERS[n % len(_MARKERS)]
        name = f"continuum, {block.energy_J:.3g} J"
        fraction = block.dissipated_fraction
        volumes = (block.volume_over_sphere_volume, block.volume_ever_over_sphere_volume)
        axes.plot(fraction, volumes[0], mark, color=ORANGE, markersize=4.5, label=name)
        axes.plot(fraction, volumes[1], mark, color=ORANGE, markerfacecolor="none", markersize=7)
        parts += [(name, [fraction], volumes[:1]), (f"{name}, ever", [fraction], volumes[1:])]
    label(axes, FRACTION, r"Volume $/(\pi D_\mathrm{punch}^3/6)$", log="y", xlim=(0, 1))
    if len(blocks):
        look: dict[str, Any] = {"color": GREY, "markerfacecolor": "none", "markersize": 7}
        axes.plot([], [], "o", label="large, open: ever yielded", **look)
    axes.legend(fontsize=6, ncols=2, loc="lower right")
    names = ("curve", "dissipated_fraction", "volume_over_sphere_volume")
    return Drawing(
        figure,
        pd.concat(DataFrame(dict(zip(names, part, strict=True))) for part in parts).to_dict("list"),
    )


def against_velocity(runs: DataFrame, fit: QuadraticLaw) -> Drawing:
    """Draw the dissipation and the dissipated fraction against velocity, with the quadratic law."""
    v, lost = dissipation(runs)
    fine = np.geomspace(fit.lowest, v[-1], 200)
    figure, left, right = panels(2.6, 2)
    left.plot(fine, fit(fine), color=ORANGE, label="quadratic law")
    positive = lost > 0
    left.plot(v[positive], lost[positive], "o", color=BLUE, markersize=4, label="simulation")
    title = (
        r"Dissipation $\bar e_\mathrm{dis}$, in units in which $\bar e_\mathrm{in} = \bar v_0^2/2$"
    )
    label(left, r"Impact velocity $\bar v_0$", title, log="xy")
    left.yaxis.label.set_fontsize(7)
    left.legend()
    right.plot(0.5 * fine**2, fit(fine) / (0.5 * fine**2), color=ORANGE)
    right.plot(0.5 * v**2, lost / (0.5 * v**2), "o", color=BLUE, markersize=4)
    label(
        right, r"Input energy $\bar e_\mathrm{in} = \bar v_0^2/2$", FRACTION, log="x", ylim=(0, 1)
    )
    columns = {
        "velocity_normalised": v,
        "dissipation_normalised": lost,
        "dissipated_fraction": lost / (0.5 * v**2),
    }
    inside = v >= fit.lowest * (1 - SAME)
    return Drawing(figure, columns | {"quadratic_law": np.where(inside, fit(v), np.nan)})


def loading_area(curves: Curves) -> Drawing:
    """Draw the dissipated fraction against input energy for 1, 3 and 7 impacted spheres."""
    figure, axes = panels(2.6)
    for n, (name, runs) in enumerate(curves.items()):
        axes.plot(
            runs.energy_normalised,
            runs.dissipated_fraction,
            label=name,
            clip_on=False,
            **look(n, lines=False),
        )
    label(axes, GRANULAR_ENERGY, FRACTION, log="x", ylim=(0, 1))
    axes.legend()
    return Drawing(
        figure, columns_of(curves, ("struck_spheres", "energy_normalised", "dissipated_fraction"))
    )


def by_mass(curves: Curves) -> Drawing:
    """Draw dissipated fraction and plastic volume against input energy by mass of the punch."""
    figure, left, right = panels(2.6, 2)
    for n, (name, runs) in enumerate(curves.items()):
        style = look(n) | {
            "markerfacecolor": "none",
            "markersize": 5 if n else 3,
            "linewidth": 0.5 if n else 0.8,
        }
        left.plot(runs.energy_normalised, runs.dissipated_fraction, label=name, **style)
        right.plot(runs.energy_normalised, runs.volume_over_sphere_volume, label=name, **style)
        ever = runs.volume_ever_over_sphere_volume
        right.plot(runs.energy_normalised, ever, ":", color=style["color"], linewidth=0.8)
    label(left, CONTINUUM_ENERGY, FRACTION, log="x", ylim=(0, None))
    left.legend()
    label(right, CONTINUUM_ENERGY, r"Plastic volume $/(\pi D^3/6)$", xlim=(0, None), ylim=(0, None))
    right.set_title("full: largest at one instant, dotted: that ever yielded", fontsize=7)
    volumes = ("volume_over_sphere_volume", "volume_ever_over_sphere_volume")
    return Drawing(
        figure,
        columns_of(curves, ("mass_kg", "energy_normalised", "dissipated_fraction", *volumes)),
    )


_FEWEST_RUNS = 3
_ON_RAY = (
    1,
    2,
    4,
    8,
    12,
)  # contacts of a preferred direction, from the impacted sphere, that are drawn
_LAYERS_LISTED = (1, 4, 8, 16)  # layers below the impacted one in the table of uniformity
_MOST_FRONTS = 4  # largest number of fronts
_BANDS = 5  # number of ranges of depth
_MILLI = 1e3
_LARGE_DOT = 4.0  # size of dots, points
_SMALL_DOT = 1.5
_FEW_DOTS = 500  # number of dots below which they are large
_WEAK = 1.0  # normalised force at the largest velocity below which contacts are left out
_INSIDE = -1e-6  # least coordinate along preferred directions inside the cone of these, diameters
_LAYERS = 1e3  # resolved depths in a diameter
_LATER = 0.02  # fraction of the forces of a layer that may be of later waves
_IMPULSE = (
    "Granular: peak force against impulse, at velocities from a tenth of the largest on, of "
    "contacts along a preferred direction, counted from the impacted sphere. Points on their line, "
    "and exponents of 1 at every depth, show that force is proportional to impulse"
)
_FRONT = (
    "Granular: the front by layer, before reflections from the base. Below F_y the front is "
    "elastic; the closer the mean is to the largest force of its layer, the more planar it is"
)
_SLOW = "less than a tenth of the largest velocity"
_OTHER_FRONTS = f"only {_MOST_FRONTS} velocities of the reference are drawn"
_UNREADABLE = (GranwaveError, OSError, KeyError)


class Linearity(NamedTuple):
    """Peak force against velocity, contact by contact.

    Attributes
    ----------
    velocity
        (n_runs,).
    ray
        Largest peak force of the contacts on the preferred directions: (n_contacts, n_runs).
    contacts
        ``depth`` (m), and ``exponent`` of force against velocity, a least-squares slope on
        logarithmic axes.
    """

    velocity: NDArray[np.float64]
    ray: NDArray[np.float64]
    contacts: DataFrame


def linear(runs: DataFrame) -> Linearity | None:
    """Linearity of runs by rising velocity; None for fewer than three, or if no contact counts.

    A contact counts if it lies within the cone of the preferred directions, its peak force exceeds
    F_y at the largest velocity, and it is loaded at every other velocity. Outside the cone a
    contact may be loaded only by the rebound.
    """
    if len(runs) < _FEWEST_RUNS:
        return None
    forces = []
    along = []
    try:
        for run in runs.itertuples():
            with Result(run.run.directory) as result:
                pairs = list(
                    zip(result["contacts/i"].tolist(), result["contacts/j"].tolist(), strict=True)
                )
                forces.append(
                    Series(
                        dict(
                            zip(pairs, result["contacts/peak_force"] / run.yield_force, strict=True)
                        )
                    )
                )
                along.append(
                    np.fmax.reduce(rays(result).peak_force, axis=1) / run.yield_force
                )  # NaN without a contact
                inside = np.flatnonzero(_in_cone(result)[result.ends].all(axis=1))
                middle = result["spheres/position"][result.ends, 2].mean(axis=1) - result.origin[2]
                depth = Series({pairs[k]: middle[k] for k in inside}, dtype=float)
    except _UNREADABLE:
        return None
    table = pd.concat(forces, axis=1).reindex(depth.index)
    kept = table.iloc[:, -1].gt(_WEAK) & table.gt(0).all(axis=1)
    if not kept.any():
        return None
    velocity = runs.velocity_normalised.to_numpy()
    x = np.log(velocity) - np.log(velocity).mean()
    shortest = min(map(len, along))
    ray = np.stack([ray_values[:shortest] for ray_values in along], axis=1)
    exponent = np.log(table[kept].to_numpy()) @ x / (x @ x)
    return Linearity(velocity, ray, DataFrame({"depth": depth[kept], "exponent": exponent}))


def with_runs(picture: Picture, drawn: DataFrame, omitted: str) -> Picture:
    """Add to a caption the names of the runs that the figure shows, and the omitted ones."""
    caption = f"{picture.caption}. Drawn: {named(list(dict.fromkeys(drawn['label'])))}"
    if omitted:
        caption += f". Not drawn: {omitted}"
    return dataclasses.replace(picture, caption=caption, data=None)


def front_runs(runs: DataFrame) -> DataFrame:
    """Return up to four runs that cover the range of velocities."""
    return runs.iloc[sorted({round(n) for n in np.linspace(0, len(runs) - 1, _MOST_FRONTS)})]


def fronts(runs: DataFrame) -> dict[float, DataFrame]:
    """Front of up to four runs that cover the range of velocities, by normalised velocity."""
    if not len(runs) or len(preferred_directions(runs.run.iloc[0].case.packing.kind)) != 3:
        return {}
    front_of_velocity = {}
    for run in front_runs(runs).itertuples():
        try:
            with Result(run.run.directory) as result:
                front_of_velocity[float(run.velocity_normalised)] = _front(result, run.yield_force)
        except _UNREADABLE:
            continue
    return front_of_velocity


def pictures(impacts: Impacts) -> Iterator[Picture]:
    """Peak force against impulse, and the front, of the reference."""
    if linearity := linear(impacts.fast):
        picture = Picture(
            "peak_force_impulse", _IMPULSE, partial(_peak_force_against_impulse, linearity)
        )
        yield with_runs(picture, impacts.fast, omitted_in_words(impacts, impacts.fast, _SLOW))
    if front_tables := fronts(impacts.reference):
        drawn = front_runs(impacts.reference)
        drawn = drawn[drawn.velocity_normalised.isin(list(front_tables))]
        names = dict(zip(drawn.velocity_normalised, drawn["label"], strict=True))
        picture = Picture("front", _FRONT, partial(_front_by_depth, front_tables, names))
        yield with_runs(picture, drawn, omitted_in_words(impacts, drawn, _OTHER_FRONTS))


def tables(impacts: Impacts) -> Iterator[DocumentTable]:
    """Exponents of force against impulse for each fifth of the depth, and the front."""
    if linearity := linear(impacts.fast):
        numbers = numeric(("to", "mm"), "Contacts", "5 %", "Median", "95 %")
        columns = (*numeric(("Depth from", "mm"), key=True), *numbers)
        caption = (
            "Peak force against impulse: exponent over normalised velocities from "
            f"{show(float(linearity.velocity[0]))} to {show(float(linearity.velocity[-1]))} (1: "
            "proportional)"
        )
        rows: list[tuple[Any, ...]] = []
        for top, bottom in pairwise(
            np.linspace(0, float(linearity.contacts.depth.max()), _BANDS + 1).tolist()
        ):
            exponent = linearity.contacts.exponent[linearity.contacts.depth.between(top, bottom)]
            if len(exponent):
                quantiles = exponent.quantile((0.05, 0.5, 0.95)).tolist()
                rows.append((_MILLI * top, _MILLI * bottom, len(exponent), *quantiles))
        yield table_of(caption, columns, rows)
    if front_tables := fronts(impacts.reference):
        numbers = numeric(
            ("Elastic from a depth of", "mm"), *(f"Uniformity, layer {n}" for n in _LAYERS_LISTED)
        )
        rows = []
        for velocity, front in front_tables.items():
            weak = front.depth[
                front.largest[::-1].cummax()[::-1] <= 1
            ]  # no later force is above F_y
            uniformity = [_listed(front.uniformity, n) for n in _LAYERS_LISTED]
            rows.append(
                (velocity, _MILLI * float(weak.iloc[0]) if len(weak) else None, *uniformity)
            )
        caption = "The front: mean / largest peak force of a layer, within the cone of the preferred directions"
        yield table_of(caption, (*numeric("Normalised velocity", key=True), *numbers), rows)


def _listed(uniformity: Series[float], layer: int) -> float | None:
    """Return the uniformity of a layer; None where it is not known."""
    if layer >= len(uniformity) or not np.isfinite(uniformity.iloc[layer]):
        return None
    return float(uniformity.iloc[layer])


def _front(result: Result, unit: float) -> DataFrame:
    """Return the peak forces of the layers that the first wave passed, before the reflection.

    Returns
    -------
    DataFrame
        ``depth`` below the impacted sphere, m; ``largest`` peak force of a sphere, in the unit (N),
        NaN where it is of a later wave; ``uniformity``, mean / largest: 1 where the front is
        planar, NaN where more than 2 % of the sum of the forces may be of later waves.
    """
    depth = result["spheres/position"][:, 2] - result.origin[2]
    diameter = result.case.packing.diameter
    peaks = layer_peaks(result)
    _, number = layers(depth, result["spheres/radius"], diameter)
    force = result["spheres/peak_force"] / unit
    inside = _in_cone(result)
    spheres = DataFrame(
        {
            "depth": np.rint(_LAYERS * depth / diameter) * diameter / _LAYERS,
            "force": force,
            "later": np.where(spheres_of_later_waves(result, peaks, number), force, 0.0),
            "known": peaks.is_known[number],
        }
    )[inside]
    of_layer = spheres.groupby("depth")
    front = of_layer.agg(largest=("force", "max"), mean=("force", "mean"), known=("known", "all"))
    is_first = of_layer["later"].sum() <= _LATER * of_layer["force"].sum()
    front["uniformity"] = (front["mean"] / front["largest"]).where(front["known"] & is_first)
    front = front[front["largest"] > 0]
    front["largest"] = front["largest"].where(front["known"])
    return front.reset_index()[["depth", "largest", "uniformity"]]


def _in_cone(result: Result) -> NDArray[np.bool_]:
    """True for spheres within the cone that the preferred directions span; for all unless there are
    three directions: (n_spheres,).
    """
    directions = preferred_directions(result.case.packing.kind)
    offset = result["spheres/position"] - result.origin
    if len(directions) != 3:
        return np.ones(len(offset), dtype=bool)
    return np.all(
        offset @ np.linalg.inv(directions) > _INSIDE * result.case.packing.diameter, axis=1
    )


def _peak_force_against_impulse(linearity: Linearity) -> Drawing:
    """Draw force against velocity along a preferred direction, and the exponent of every contact
    against depth.
    """
    figure, left, right = panels(2.6, 2)
    columns: dict[str, NDArray] = {"velocity_normalised": linearity.velocity}
    for k, n in enumerate(n for n in _ON_RAY if n <= len(linearity.ray)):
        values = linearity.ray[n - 1]
        style = {**look(k), "markerfacecolor": "none", "markersize": 5}
        left.plot(linearity.velocity, values, label=f"contact {n}", linestyle="none", **style)
        proportional = values[-1] * linearity.velocity / linearity.velocity[-1]
        left.plot(linearity.velocity, proportional, color=style["color"], linewidth=0.7)
        columns[f"contact_{n}_over_Fy"] = values
    label(
        left,
        r"Impact velocity $\bar v_0$, as impulse",
        r"Peak force $F_\mathrm{max}/F_\mathrm{y}$",
        log="xy",
    )
    smallest = float(np.nanmin([columns[name].min() for name in columns if "contact" in name]))
    left.set_ylim(smallest / 2, 2 * float(np.nanmax(linearity.ray)))
    legend_above(
        left,
        3,
        title="from the impacted sphere; lines: proportional",
        fontsize=7,
        title_fontsize=7,
    )
    depth = linearity.contacts.depth
    exponent = linearity.contacts.exponent
    size = _LARGE_DOT if len(exponent) < _FEW_DOTS else _SMALL_DOT
    right.plot(depth * _MILLI, exponent, ".", color=BLUE, markersize=size, rasterized=True)
    right.axhline(1, color=ORANGE, linewidth=0.8)
    low, high = exponent.quantile((0.005, 0.995))
    limits = min(low, 0.8), max(high, 1.2)
    label(right, "Depth of the contact (mm)", "Exponent of force\nagainst impulse", ylim=limits)
    n_outside = mark_outside(right, depth * _MILLI, exponent, BLUE)
    if n_outside:
        title = f"triangles: outside the axis ({n_outside} of {len(exponent)})"
        right.set_title(title, fontsize=7)
    return Drawing(figure, columns | {"depth_m": depth, "exponent": exponent})


def _front_by_depth(front_tables: dict[float, DataFrame], names: Mapping[float, str]) -> Drawing:
    """Draw the largest peak force of the first wave and its uniformity by layer: below the yield
    force the front is elastic.

    Parameters
    ----------
    names
        Names of the runs, by normalised velocity.
    """
    figure, left, right = panels(2.6, 2)
    columns: dict[str, NDArray] = {}
    for n, (velocity, front) in enumerate(front_tables.items()):
        style = {**look(n), "markersize": 3.5, "linewidth": 0.8}
        name = rf"{names[velocity]}, $\bar v_0$ = {velocity:.4g}"
        left.plot(front.depth * _MILLI, front.largest, label=name, **style)
        right.plot(front.depth * _MILLI, front.uniformity, **style)
        for name, column in zip(
            ("depth_m", "largest_over_Fy", "mean_over_largest"), front, strict=True
        ):
            columns[f"{name}_v_{velocity:.4g}"] = front[column].to_numpy()
    left.axhline(1, color=GREY, linestyle=":", linewidth=0.9)
    largest = "Largest peak force\n" + r"of a layer $/F_\mathrm{y}$"
    label(left, "Depth (mm)", largest, log="y")
    left.legend()
    label(right, "Depth (mm)", "Mean / largest\npeak force of a layer", ylim=(0, 1.05))
    return Drawing(figure, columns)
