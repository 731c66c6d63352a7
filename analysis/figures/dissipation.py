"""Figures of dissipation in space: by sphere, by depth, in the plastic zone, by direction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import wrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.figures.colouring import force_scale
from granwave.analysis.figures.sections import spheres_beyond_law
from granwave.analysis.figures.series import (
    label,
    label_log_axis,
    panels,
    time_axis,
    with_error,
)
from granwave.analysis.figures.style import (
    BLUE,
    DISSIPATION_MAP,
    FORCE_MAP,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    WIDTH,
    Drawing,
    legend_above,
)
from granwave.analysis.formatting.numbers import instant
from granwave.analysis.measures import waves
from granwave.analysis.measures.beads import beads_on_axis
from granwave.analysis.measures.dynamic_force import has_static_forces
from granwave.analysis.measures.force_decay import (
    ForceDecay,
    LayerPeaks,
    PowerDecay,
    accepted,
    both_decays,
    layer_peaks,
    reason_against,
)
from granwave.analysis.measures.geometry import preferred_directions
from granwave.analysis.measures.impact import (
    cumulated,
    peak_force_by_depth,
    ranked,
    rays,
    zone_growth,
)
from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.zone_size import (
    BOTTOM,
    SIDES,
    bounds_in_words,
    cut_of,
    extent_holding,
    packing_zone,
)
from granwave.analysis.quantities import SHARES
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.packing.cylinders import CYLINDERS

_MILLI = 1e3  # mm in a metre
_MICRO = 1e6  # microseconds in a second
_RANGE = 1e-10  # smallest / largest dissipation in the ranked figure
_POINTS_OF_FIT = 50
_MARGIN = 1.03  # end of the axis of depths / depth of the last layer
_MOST_MARKED = 60  # largest number of layers with a marker each
# smallest force of a layer that the wave has not passed / of the layers that it has passed: lower
# ones are at the foot of the wave, and would only stretch the axis
_LEAST_RISING = 0.3
_FEWEST = 2  # fewest layers and loaded contacts of a course of forces
_ON_AXIS = 1e-6  # largest distance of centres on the axis of the impact, diameters
_LONG_VALUE = 12  # letters of a fitted value beyond which its misfit has a line of the legend
_LETTERS = 36  # most letters of a line of a legend
_ALL = {2: "both", 3: "all"}  # label of the sum, by number of kinds of dissipation


def dissipation_ranked(result: Result) -> Drawing | None:
    """Draw the dissipation of the spheres in descending order, with rings beyond the law's range.

    With friction, dissipation by yielding and by friction is drawn too, each in descending order.
    """
    dissipated = result["spheres/dissipated_energy"]
    rows = ranked(dissipated)
    if not len(rows) or not result.has_yield_force:
        return None
    law = result.law
    unit = law.yield_force * law.yield_overlap
    values = dissipated[rows] / unit
    rank = np.arange(1, len(rows) + 1)
    beyond = spheres_beyond_law(result)[rows]
    figure, axes = panels(2.4)
    parts = _parts(result)
    axes.loglog(rank, values, color=BLUE, linewidth=0.8, label=_ALL.get(len(parts)))
    axes.plot(rank[~beyond], values[~beyond], "o", color=BLUE, markersize=2.5, markeredgewidth=0)
    if beyond.any():
        axes.plot(
            rank[beyond], values[beyond], "o", color=BLUE, markersize=4, markeredgecolor="black", markeredgewidth=0.8,
            label=r"contact beyond 0.2 $R^*$",
        )  # fmt: skip
    columns = {"rank": rank, "id": result["spheres/id"][rows], "dissipated_J": dissipated[rows]}
    columns |= {"dissipated_over_Fy_alpha_y": values, "beyond_law": beyond.astype(int)}
    for part, (share, colour, line) in parts.items():
        own = share[ranked(share)]
        axes.loglog(
            np.arange(1, len(own) + 1), own / unit, line, color=colour, linewidth=1.0, label=part
        )
        columns[f"{part}_in_descending_order_J"] = own
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="lower left")
    axes.set_ylim(bottom=max(float(values.min()), float(values[0]) * _RANGE) / 2)
    quantity = r"Dissipation $e_\mathrm{dis}/(F_\mathrm{y}\,\alpha_\mathrm{y})$"
    label(axes, "Dissipating spheres, in descending order", quantity)
    return Drawing(figure, columns)


def dissipation_cumulated(result: Result) -> Drawing | None:
    """Draw the fraction of the input dissipated by a volume of spheres, in descending order of
    dissipation.

    With friction, also for dissipation by yielding only and by friction only.
    """
    if not np.any(result["spheres/dissipated_energy"] > 0):
        return None
    in_plane = result.assembly.grains_called == CYLINDERS  # cylinders of equal length
    volumes = (2 * result["spheres/radius"] / result.case.packing.diameter) ** (
        2 if in_plane else 3
    )
    fraction, volume = cumulated(result["spheres/dissipated_energy"], result.energy_input, volumes)
    figure, axes = panels(2.4)
    parts = _parts(result)
    axes.plot(
        volume,
        fraction,
        "-o",
        color=BLUE,
        markersize=2.5,
        label=_ALL.get(len(parts)),
    )
    axes.axhline(
        fraction[-1],
        color="black",
        linestyle=":",
        linewidth=0.8,
        label=_number_dissipating(result, len(volume)),
    )
    columns = {"dissipated_over_input": fraction, "volume_over_sphere_volume": volume}
    for part, (share, colour, line) in parts.items():
        own, spheres = cumulated(share, result.energy_input, volumes)
        axes.plot(spheres, own, line, color=colour, label=part)
        columns |= {f"{part}_over_input": own, f"{part}_volume_over_sphere_volume": spheres}
    legend_above(axes, 2)
    quantity = "Volume / cylinder volume" if in_plane else r"Volume / ($\pi D^3/6$)"
    label(axes, quantity, "Dissipation / energy input", log="x", ylim=(0, 1))
    return Drawing(figure, columns)


def _number_dissipating(result: Result, n_dissipating: int) -> str:
    """Return the number of spheres that dissipated energy, and of yielded spheres if it differs."""
    text = f"all {n_dissipating}\ndissipating spheres"
    n_yielded = int(np.count_nonzero(result["spheres/contacts_yielded"]))
    return f"{text}\n({n_yielded} yielded)" if n_yielded not in (0, n_dissipating) else text


def _parts(result: Result) -> dict[str, tuple[NDArray[np.float64], str, str]]:
    """Return the dissipation by yielding, friction and damping, with colour and line; empty for a
    single kind.
    """
    parts = {}
    if result.yields or result.yield_energy.any():
        parts["yielding"] = (result.yield_energy, ORANGE, "--")
    for part, name, colour, line in (
        ("friction", "friction", GREEN, ":"),
        ("viscous losses", "viscous", PURPLE, "-."),
    ):
        if result.has(f"spheres/{name}_energy"):
            parts[part] = (result[f"spheres/{name}_energy"], colour, line)
    return parts if len(parts) > 1 else {}


def plastic_zone_growth(result: Result) -> Drawing | None:
    """Draw the number of yielded contacts and spheres, and depth and radius of the outermost
    yielded sphere, against time; without the radius if all yielded spheres are on the axis.

    The title names the boundaries that the zone reaches.
    """
    growth = zone_growth(result)
    if not len(growth.time):
        return None
    end = float(result["energy/time"][-1])
    time = np.concatenate([[0.0], growth.time, [end]])
    figure, upper, lower = panels(3.2, rows=2, sharex=True)
    if cut := cut_of(packing_zone(result)):
        names = bounds_in_words(cut, periodic=result.case.boundary.periodic)
        upper.set_title(f"the zone reaches a boundary: {names}", fontsize=7)
    extents = {"depth": growth.depth * _MILLI}
    extent = "Depth of plastic zone (mm)"
    if growth.radius.max() > _ON_AXIS * result.case.packing.diameter:
        extents["radius"] = growth.radius * _MILLI
        extent = "Extent of plastic zone (mm)"
    for axes, quantity, curves in (
        (upper, "Number yielded", {"contacts": growth.contacts, "spheres": growth.spheres}),
        (lower, extent, extents),
    ):
        for (name, values), line in zip(curves.items(), ("-", "--"), strict=False):
            axes.step(
                time * _MICRO,
                np.concatenate([[0], values, values[-1:]]),
                line,
                where="post",
                label=name,
            )
        label(axes, y=quantity)
        axes.set_ylim(bottom=0)
        if len(curves) > 1:
            axes.legend(loc="lower right")
    time_axis(lower, time)
    columns = {"time_s": growth.time, "contacts": growth.contacts, "spheres": growth.spheres}
    return Drawing(figure, columns | {"depth_m": growth.depth, "radius_m": growth.radius})


def peak_force_depth(result: Result) -> Drawing | None:
    """Draw the decay of the peak force: largest of each layer with the law that is fitted to it, a
    marker for each layer of contacts along the preferred directions, at the depth of their lower
    sphere, and bars over the range of these directions.

    The forces are those of the first wave. Layers whose largest force occurred when the reflection
    from the base may have arrived have hollow markers, and are not fitted. Under a load that keeps
    oscillating the forces are the largest of the run.

    Under a static load the fitted force is the largest dynamic force of each layer, above the
    static force; a line shows the largest total force of the run. Where no law describes the
    forces, the legend gives the reason.

    Layers that the wave has not reached are not drawn. Beads of a chain and grains that were added
    next to them are separate curves.
    """
    is_bead = beads_on_axis(result)
    if is_bead is not None:
        return _peak_force_of_beads(result, is_bead)
    depth, force = peak_force_by_depth(result)
    n_loaded = np.count_nonzero(result["contacts/peak_force"] > 0)
    # a single contact has no course of forces, and a chain has a figure of its own
    if len(depth) < _FEWEST or n_loaded < _FEWEST or "chain" in result:
        return None
    scale, unit, name = force_scale(result)
    peaks = layer_peaks(result)
    along = rays(result)
    n_contacts, n_rays = along.peak_force.shape
    pitch = result.case.packing.diameter * along.directions[0, 2] if n_rays else 0.0
    middle = (np.arange(n_contacts) + 0.5) * pitch  # depth of the contact points
    figure, axes = panels(3.2)
    if n_rays > 1 and _have_lines(along.peak_force):
        arrival = np.interp(middle, depth, peaks.reflection)
        is_first = along.time_peak < arrival[:, None]
        lower = (np.arange(n_contacts) + 1.0) * pitch  # as the layers, whose peaks they are
        _mark_directions(axes, lower * _MILLI, np.where(is_first, along.peak_force, 0.0) / scale)
    is_pressed = has_static_forces(result)
    if is_pressed:
        total = "largest of the layer in the run, with static force"
        axes.plot(depth * _MILLI, force / scale, "-.", color=GREEN, label=total, zorder=1)
    _draw_layers(axes, peaks, scale)
    decay = _draw_fit(axes, result, peaks, scale)
    _label_depths(axes, peaks, unit, is_pressed=is_pressed)
    columns: dict[str, ArrayLike] = {
        "layer_depth_m": depth,
        f"layer_peak_{name}": force / scale,
        "layer_peak_after_reflection": peaks.is_later.astype(int),
        "layer_still_rises": _still_rising(peaks).astype(int),
        "of_first_wave": [int(peaks.of_first_wave)],
        "contact_depth_m": middle,
    }
    if is_pressed:
        columns[f"layer_dynamic_{name}"] = peaks.largest / scale
    if decay is not None:
        columns |= _columns_of_decay(decay)
    columns |= {
        f"direction_{n + 1}_{name}": values / scale for n, values in enumerate(along.peak_force.T)
    }
    return Drawing(figure, columns)


def words_on_depths(_: Result, table: Path) -> tuple[str, str]:
    """Return caption and look of `peak_force_depth` of a run.

    Parameters
    ----------
    table
        Path of the data of the figure, CSV.
    """
    data = np.genfromtxt(table, delimiter=",", names=True, ndmin=1)
    names = data.dtype.names or ()
    look = ["A straight line is exponential."]
    if "bead_depth_m" in names:
        caption = (
            "Peak force of the contacts between beads, and of the grains next to them, against "
            "depth, excluding walls"
        )
        look.append("Beads that the wave has not reached are not drawn.")
        later = data["bead_peak_after_reflection"]
    else:
        is_first = "of_first_wave" not in names or data["of_first_wave"][0] > 0
        part = "first wave" if is_first else "run"
        caption = f"Peak contact force of the {part} against depth, excluding walls"
        later = data["layer_peak_after_reflection"]
    if np.any(later > 0):
        look.append("Squares: after a reflection.")
    rising = [name for name in names if name.endswith("_still_rises")]
    if any(np.any(data[name] > 0) for name in rising):
        look.append("Crosses: still rising at the end.")
    directions = [name for name in names if name.startswith("direction_")]
    if len(directions) > 1 and np.any([data[name][1:2] > 0 for name in directions]):
        look.append("Circles: contacts, at their lower sphere.")
    return caption, " ".join(look)


def _peak_force_of_beads(result: Result, is_bead: NDArray[np.bool_]) -> Drawing | None:
    """Draw the peak forces of the beads of a chain with the fitted decay, and those of the grains
    that were added next to them.
    """
    beads = layer_peaks(result, is_bead)
    added = layer_peaks(result, ~is_bead & result.in_packing)
    if np.count_nonzero(beads.is_known) < _FEWEST:
        return None
    scale, unit, name = force_scale(result)
    figure, axes = panels(3.2)
    _draw_layers(axes, beads, scale, "between beads")
    shown = added.is_known | added.is_later
    axes.plot(
        added.depth[shown] * _MILLI,
        added.largest[shown] / scale,
        "--",
        color=ORANGE,
        linewidth=1.0,
        label="largest of the grains next to the beads",
    )
    decay = _draw_fit(axes, result, beads, scale)
    _label_depths(axes, beads, unit, is_pressed=has_static_forces(result))
    columns = {
        "bead_depth_m": beads.depth,
        f"bead_peak_{name}": beads.largest / scale,
        "bead_peak_is_known": beads.is_known.astype(int),
        "bead_still_rises": _still_rising(beads).astype(int),
        "bead_peak_after_reflection": beads.is_later.astype(int),
        "added_depth_m": added.depth,
        f"added_peak_{name}": added.largest / scale,
        "added_peak_is_known": added.is_known.astype(int),
    }
    if decay is not None:
        columns |= _columns_of_decay(decay)
    return Drawing(figure, columns)


def _draw_fit(
    axes: Axes, result: Result, peaks: LayerPeaks, scale: float
) -> ForceDecay | PowerDecay | None:
    """Draw the decay that is fitted to layers, or give the reason why there is none in the legend;
    return the decay.

    Parameters
    ----------
    scale
        Unit of the forces of the figure, N.
    """
    fits = both_decays(result, peaks)
    decay = accepted(fits)
    if decay is None:
        axes.plot([], [], " ", label=_wrapped(reason_against(fits)))
    else:
        _draw_decay(axes, decay, scale)
    return decay


def _label_depths(axes: Axes, peaks: LayerPeaks, unit: str, *, is_pressed: bool) -> None:
    """Label the axes of peak forces against depth, which end at the last layer that the wave
    reached, and draw the legend.

    Parameters
    ----------
    unit
        Label of the unit of the forces.
    is_pressed
        True for the rise of forces above static ones.
    """
    kind = "Dynamic peak force" if is_pressed else "Peak force"
    part = "first wave" if peaks.of_first_wave else "run"
    last = peaks.depth[-1]
    if np.any(peaks.is_reached):
        last = peaks.depth[peaks.is_reached][-1]
    limits = (0, _MARGIN * last * _MILLI)
    label(axes, "Depth (mm)", f"{kind} of the {part} {unit}", log="y", xlim=limits)
    lowest, highest = axes.get_ylim()
    label_log_axis(axes, highest / lowest)
    legend_above(axes, 1, fontsize=8)


def _have_lines(force: Array) -> bool:
    """Return True if a second contact of the preferred directions is loaded: in hcp the grains are
    not on a line beyond the first contact.

    Parameters
    ----------
    force
        Forces, 0 or NaN without contact: (n_contacts, n_directions), N.
    """
    return len(force) >= _FEWEST and bool(np.any(force[1] > 0))


def _draw_layers(
    axes: Axes, peaks: LayerPeaks, scale: float, name: str = "largest of the layer"
) -> None:
    """Draw the largest force of each layer: of the first wave as a line, of later times and of
    layers that it has reached and not passed as markers.

    Parameters
    ----------
    scale
        Unit of the forces of the figure, N.
    name
        Of the forces in the legend.
    """
    depth = peaks.depth * _MILLI
    force = peaks.largest / scale
    others = _still_rising(peaks)
    marker = "." if len(depth) <= _MOST_MARKED else ""
    look: dict[str, Any] = {
        "color": BLUE, "markerfacecolor": "none", "markersize": 4, "zorder": 1.5
    }  # fmt: skip
    for chosen, signs, text in (
        (peaks.is_known, f"{marker}-", name),
        (peaks.is_later, "s", f"{name}, after the reflection (not fitted)"),
        (others, "x", f"{name}, still rising at the end"),
    ):
        if np.any(chosen):
            axes.plot(depth[chosen], force[chosen], signs, label=text, **look)


def _still_rising(peaks: LayerPeaks) -> NDArray[np.bool_]:
    """Return True for layers whose force still rises at the end, and is not far below those of the
    layers that the wave has passed: (n_layers,).
    """
    others = ~peaks.is_known & ~peaks.is_later & peaks.is_reached
    passed = peaks.largest[peaks.is_known | peaks.is_later]
    lowest = passed.min(initial=float(peaks.largest.max(initial=0.0)))
    return others & (peaks.largest > _LEAST_RISING * lowest)


def _wrapped(reason: str) -> str:
    """Return the reason why no decay is drawn, in lines of a legend."""
    text = reason if reason.startswith("no decay") else f"no fit: {reason}"
    return "\n".join(wrap(text, _LETTERS))


def _draw_decay(axes: Axes, decay: ForceDecay | PowerDecay, scale: float) -> None:
    """Draw a fitted decay over the layers of the fit.

    Parameters
    ----------
    scale
        Unit of the forces of the figure, N.
    """
    if isinstance(decay, ForceDecay):
        first, last = decay.depth[[0, -1]]
        value = with_error(decay.rate, decay.error)
        law = rf"$\exp(-bz)$, $b$ = {value} per m"
    else:
        first = decay.first
        last = decay.last
        value = with_error(decay.exponent, decay.error)
        law = rf"$z^{{-n}}$, $n$ = {value}"
    separator = "\n" if len(value) > _LONG_VALUE else " "
    depth = np.linspace(first, last, _POINTS_OF_FIT)
    axes.plot(
        depth * _MILLI,
        decay(depth) / scale,
        "--",
        color="black",
        linewidth=0.9,
        label=f"fitted {law},{separator}rms {100 * decay.misfit:.2g} %\n"
        f"({decay.n_layers} layers, without the impacted and the last layer)",
    )


def _columns_of_decay(decay: ForceDecay | PowerDecay) -> dict[str, NDArray[np.float64]]:
    """Return the constants of a fitted decay as columns."""
    if isinstance(decay, ForceDecay):
        values = {"decay_per_m": decay.rate, "decay_error_per_m": decay.error}
    else:
        values = {"decay_exponent": decay.exponent, "decay_exponent_error": decay.error}
    values["decay_misfit"] = decay.misfit
    return {name: np.array([value]) for name, value in values.items()}


def _mark_directions(axes: Axes, depth: Array, force: Array) -> None:
    """Mark the median force of contacts along the preferred directions, with bars over their range.

    Parameters
    ----------
    depth
        Depths of the contacts: (n_contacts,), mm.
    force
        Forces in the unit of the figure, 0 without contact: (n_contacts, n_directions).
    """
    loaded = np.flatnonzero(np.all(force > 0, axis=1))
    if not len(loaded):
        return
    middle = np.median(force[loaded], axis=1)
    below = middle - force[loaded].min(axis=1)
    above = force[loaded].max(axis=1) - middle
    axes.errorbar(
        depth[loaded],
        middle,
        yerr=np.stack([below, above]),
        fmt="o",
        color=ORANGE,
        markerfacecolor="none",
        markersize=4,
        markeredgewidth=0.8,
        elinewidth=0.8,
        capsize=2,
        label=f"contacts along {force.shape[1]} preferred directions",
    )


_LEAST = 1e-5  # smallest fraction of the energy in the figure
_NOTHING = 1e-12  # fraction of the energy that is due to rounding
#: Dashes of the lines at boundaries; the dashes of one line fill the gaps of the other, so that
#: lines at the same distance are both seen.
_EDGES = {"depth": (0, (3, 3)), "radius": (3, (3, 3))}
_STYLES = {
    "depth": (BLUE, "-", "o", BOTTOM),
    "radius": (ORANGE, "--", "s", SIDES),
}
_SAME = 1e-9  # relative difference of distances that are equal up to rounding


def plastic_zone_size(result: Result) -> Drawing | None:
    """Draw the fractions of the dissipation by yielding beyond a depth and a radius, with the
    sizes of the zone.
    """
    if not result.yields:
        return None
    zone = packing_zone(result)
    distances = {}
    bounds = {}
    for name, values, bound in (
        ("depth", zone.get("depth"), BOTTOM),
        ("radius", zone.get("radius"), SIDES),
    ):
        if values is not None:
            distances[name] = values
            if bound in cut_of(zone):
                bounds[bound] = float(values[zone[bound]].min())
    periodic = result.case.boundary.periodic
    diameter = result.case.packing.diameter
    return draw_zone_size(zone["energy"], distances, diameter, "D", bounds, periodic=periodic)


def draw_zone_size(
    energy: Array,
    distances: Mapping[str, Array],
    diameter: float,
    unit: str,
    bounds: Mapping[str, float],
    *,
    periodic: bool = False,
) -> Drawing | None:
    """Draw the fraction of an energy beyond a distance, on a logarithmic axis; None without energy.

    Parameters
    ----------
    energy
        Energies of the parts: (n,), J.
    distances
        ``depth`` and ``radius`` of the parts, as far as they apply: (n,), m.
    diameter
        Diameter of the spheres or of the punch, which the title of the axis gives, m.
    unit
        Symbol of this diameter.
    bounds
        Distances of the boundaries that the zone reaches, by name, m.
    periodic
        True if the sides are periodic.
    """
    if not distances or not np.any(energy > 0):
        return None
    figure, axes = panels(2.9)
    columns: dict[str, Sequence[float] | Array] = {}
    reach = 0.0
    for name, values in distances.items():
        colour, line, marker, bound = _STYLES[name]
        place, outside = _outside(values, energy)
        axes.step(
            place * _MILLI,
            np.maximum(outside, _NOTHING),
            line,
            where="post",
            color=colour,
            label=name,
        )
        sizes = [extent_holding(values, energy, percent / 100) for percent in SHARES]
        left = [1 - percent / 100 for percent in SHARES]
        axes.plot(np.array(sizes) * _MILLI, left, marker, color=colour, markersize=4)
        beyond = np.flatnonzero(outside > _LEAST)  # all energy is at distance 0
        reach = max(
            reach,
            float(place[beyond[-1] + 1 :].min(initial=place[-1])) if beyond.size else diameter / 2,
        )
        if bound in bounds:
            shown = bounds_in_words([bound], periodic=periodic)
            reach = max(reach, bounds[bound])
            axes.axvline(
                bounds[bound] * _MILLI,
                color=colour,
                linestyle=_EDGES[name],
                linewidth=0.9,
                label=f"zone reaches the {shown}",
            )
        columns |= {f"{name}_m": place, f"share_beyond_{name}": outside}
        columns |= {
            f"{name}_holding_m": sizes,
            f"share_within_{name}": [percent / 100 for percent in SHARES],
        }
    for percent in SHARES:
        axes.axhline(1 - percent / 100, color=GREY, linestyle=":", linewidth=0.6, zorder=0)
    title = " or ".join(distances)
    limits = {"xlim": (0, 1.05 * (reach or diameter) * _MILLI), "ylim": (_LEAST, 1)}
    outside_of_all = "Plastic dissipation\nbeyond / total"
    title = f"{title[:1].upper()}{title[1:]} (mm), ${unit}$ = {diameter * _MILLI:.4g} mm"
    label(axes, title, outside_of_all, log="y", **limits)
    axes.plot([], [], "o", color=GREY, markersize=4, label="contains 50, 90, 99 %")
    legend_above(axes, 2, fontsize=7)  # three columns are wider than the figure
    return Drawing(figure, columns)


def _outside(distance: Array, energy: Array) -> tuple[Array, Array]:
    """Return distances, rising from 0, and the fraction of the energy that lies beyond each."""
    order = np.argsort(distance, kind="stable")
    place = distance[order]
    enclosed = np.cumsum(energy[order])
    last = np.append(
        np.diff(place) > _SAME * place[-1], True
    )  # last of the parts at the same distance
    place = place[last]
    beyond = 1 - enclosed[last] / enclosed[-1]
    if place[0] > 0:
        place = np.insert(place, 0, 0.0)
        beyond = np.insert(beyond, 0, 1.0)
    return place, beyond


_LEAST_SPHERES = 8
_TITLE_HEIGHT = 0.7  # inches
_LEAST_OF_EVEN = 0.1  # fraction relative to isotropic, at the dark end of the scale


def directions(result: Result) -> Drawing | None:
    """Draw the fractions of travelling energy and dissipation by direction: polar for a layer, else
    stereographic.

    Crystals in the x-z plane have no such figure: their grains do not surround the impact in a
    layer, and would be on a line in a stereographic view.
    """
    if not result.case.packing.rule.has_faces:
        return None
    if result.n_spheres < _LEAST_SPHERES or result.n_frames < 2:
        return None
    frame = waves.travelling_frame(result)
    time = result.frame_times[frame]
    spreads = {
        f"Energy at {instant(time)}": waves.spread(result, waves.energy_of_spheres(result, frame)),
        "Dissipation": waves.spread(result, result["spheres/dissipated_energy"]),
    }
    shown = {name: spread for name, spread in spreads.items() if spread is not None}
    if not shown:
        return None
    layer = waves.is_layer(result)
    height = (
        (WIDTH / 2 if len(shown) > 1 else 0.7 * WIDTH) + _TITLE_HEIGHT + (0.0 if layer else 0.5)
    )
    polar = {"projection": "polar"}
    figure, *row = panels(height, len(shown), width=WIDTH, subplot_kw=polar)
    draw = _draw_layer if layer else _draw_half_sphere
    columns: dict[str, NDArray] = {}
    for axes, (name, spread), colours in zip(
        row, shown.items(), ((BLUE, FORCE_MAP), (ORANGE, DISSIPATION_MAP)), strict=False
    ):
        title = f"{name}\n{100 * spread.along:.0f} % along contacts\n(isotropic: {100 * spread.even:.0f} %)"
        columns |= draw(result, axes, spread, *colours)
        axes.set_title(title)
        axes.set_xticks(np.deg2rad([0, 90, 180, 270]), ["x", "y", "", ""])
        columns[f"{name.split()[0].lower()}_share"] = spread.cells.ravel()
    return Drawing(figure, columns)


def _draw_layer(
    _: Result, axes: Any, spread: waves.Spread, colour: str, __: str
) -> dict[str, NDArray]:
    """Draw the fractions of a layer as bars; return the columns of the directions."""
    angle = np.arange(waves.LAYER_BINS) * 360 / waves.LAYER_BINS - 180
    axes.bar(
        np.deg2rad(angle), 100 * spread.cells, np.deg2rad(360 / waves.LAYER_BINS), color=colour
    )
    axes.yaxis.set_major_formatter("{x:.0f} %")
    axes.yaxis.get_major_locator().base.set_params(nbins=3)
    return {"angle_deg": angle}


def _draw_half_sphere(
    result: Result, axes: Any, spread: waves.Spread, _: str, colours: str
) -> dict[str, NDArray]:
    """Draw the fractions below the impact in a stereographic view; return the columns of the
    directions.
    """
    edges = np.deg2rad(
        np.arange(waves.PER_RING + 1) * 360 / waves.PER_RING - 180 - 180 / waves.PER_RING
    )
    depth = 1 - np.arange(waves.RINGS + 1) / waves.RINGS  # cosine of the angle to the impact axis
    axis = preferred_directions(result.case.packing.kind)
    norm = LogNorm(_LEAST_OF_EVEN, max(float(spread.relative.max()), 1 / _LEAST_OF_EVEN))
    colours = result.figure_options.colour_map or colours
    radius = 2 * np.tan(np.arccos(depth) / 2)
    shown = np.maximum(spread.relative, _LEAST_OF_EVEN)
    mesh = axes.pcolormesh(edges, radius, shown, cmap=colours, norm=norm, rasterized=True)
    ring: dict[str, Any] = {"markerfacecolor": "none", "markeredgecolor": "white", "markersize": 9}
    axes.plot(
        np.arctan2(axis[:, 1], axis[:, 0]), 2 * np.tan(np.arccos(axis[:, 2]) / 2), "o", **ring
    )
    axes.set_yticks(2 * np.tan(np.deg2rad([30, 60]) / 2), ["30°", "60°"], color="white")
    axes.set_rlabel_position(90)
    axes.grid(alpha=0.3)
    axes.figure.colorbar(
        mesh,
        ax=axes,
        orientation="horizontal",
        label="Relative to isotropic",
        pad=0.12,
        extend="min",
    )
    return {
        "axis_angle_deg": np.repeat(
            np.rad2deg(np.arccos((depth[1:] + depth[:-1]) / 2)), waves.PER_RING
        ),
        "azimuth_deg": np.tile(np.rad2deg((edges[1:] + edges[:-1]) / 2), waves.RINGS),
    }
