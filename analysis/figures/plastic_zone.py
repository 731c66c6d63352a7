"""Figures of the plastic zone: its growth, and its size."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from granwave.analysis.figures.series import label, panels, time_axis
from granwave.analysis.figures.style import BLUE, GREY, ORANGE, Drawing, legend_above
from granwave.analysis.measures.impact import zone_growth
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

_MILLI = 1e3  # mm in a metre
_MICRO = 1e6  # microseconds in a second
_ON_AXIS = 1e-6  # largest distance of centres on the axis of the impact, diameters
_LEAST = 1e-5  # smallest fraction of the energy in the figure
_NOTHING = 1e-12  # fraction of the energy that is due to rounding
#: Dashes of the lines at boundaries; the dashes of one line fill the gaps of the other, so that
#: lines at the same distance are both seen.
_EDGES = {"depth": (0, (3, 3)), "radius": (3, (3, 3))}
_STYLES = {
    "depth": (BLUE, "-", BOTTOM),
    "radius": (ORANGE, "--", SIDES),
}
_MARKER = "o"  # of the sizes, on both curves
_MARKER_SIZE = 4  # points
_SAME = 1e-9  # relative difference of distances that are equal up to rounding


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

    Markers of the sizes are open if the zone reaches a boundary, which limits all of them.

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
        colour, line, bound = _STYLES[name]
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
        face = "white" if bounds else colour
        axes.plot(
            np.array(sizes) * _MILLI,
            left,
            _MARKER,
            color=colour,
            markerfacecolor=face,
            markersize=_MARKER_SIZE,
        )
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
    face = "white" if bounds else GREY
    axes.plot(
        [],
        [],
        _MARKER,
        color=GREY,
        markerfacecolor=face,
        markersize=_MARKER_SIZE,
        label="contains 50, 90, 99 %",
    )
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
