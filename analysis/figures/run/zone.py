"""Figure of the size of a plastic zone: share of the dissipation by yielding beyond a distance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from granwave.analysis.figures.style import BLUE, GREY, ORANGE, Drawing, legend_above, new_figure
from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.zone import packing_zone
from granwave.analysis.measures.zone_size import BOTTOM, SIDES, extent_holding
from granwave.analysis.quantities import SHARES
from granwave.analysis.result.reader import Result

_LEAST = 1e-5  # smallest share of the energy in the figure
_NOTHING = 1e-12  # share of the energy that is due to rounding
_STYLES = {"depth": (BLUE, "-", "o", BOTTOM, 0.97), "radius": (ORANGE, "--", "s", SIDES, 0.6)}  # height of a label last
_SAME = 1e-9  # relative difference of distances that are equal up to rounding


def plastic_zone_size(result: Result) -> Drawing | None:
    """Draw the shares of the dissipation by yielding beyond a depth and a radius, with the sizes of the zone."""
    if not result.yields:
        return None
    zone = packing_zone(result)
    distances, bounds = {}, {}
    for name, values, bound in (("depth", zone.depth, BOTTOM), ("radius", zone.radius, SIDES)):
        if values is not None:
            distances[name] = values
            if bound in zone.cut:
                bounds[bound] = float(values[zone.bounds[bound]].min())
    return draw_zone_size(zone.energy, distances, result.case.packing.diameter, "D", bounds)


def draw_zone_size(
    energy: Array, distances: Mapping[str, Array], diameter: float, unit: str, bounds: Mapping[str, float]
) -> Drawing | None:
    """Draw the share of an energy beyond a distance, on a logarithmic axis; None without energy.

    Parameters
    ----------
    energy
        Energies of the parts: (n,), J.
    distances
        ``depth`` and ``radius`` of the parts, as far as they apply: (n,), m.
    diameter
        Unit of the axis, m.
    unit
        Symbol of this unit.
    bounds
        Distances of the boundaries that the zone reaches, by name, m.
    """
    if not distances or not np.any(energy > 0):
        return None
    figure = new_figure(2.7)
    axes = figure.subplots()
    columns: dict[str, Sequence[float] | Array] = {}
    reach = 0.0
    for name, values in distances.items():
        colour, line, marker, bound, height = _STYLES[name]
        place, outside = _outside(values, energy)
        axes.step(place / diameter, np.maximum(outside, _NOTHING), line, where="post", color=colour, label=name)
        sizes = [extent_holding(values, energy, percent / 100) for percent in SHARES]
        left = [1 - percent / 100 for percent in SHARES]
        axes.plot(np.array(sizes) / diameter, left, marker, color=colour, markersize=4)
        beyond = np.flatnonzero(outside > _LEAST)  # none if all the energy is at distance 0
        reach = max(reach, float(place[beyond[-1] + 1 :].min(initial=place[-1])) if beyond.size else diameter / 2)
        if bound in bounds:
            reach = max(reach, bounds[bound])
            axes.axvline(bounds[bound] / diameter, color=colour, linestyle=":", linewidth=0.9)
            axes.annotate(
                f"cut: {bound}", (bounds[bound] / diameter, height), (-2, 0), xycoords=("data", "axes fraction"),
                textcoords="offset points", rotation=90, ha="right", va="top", color=colour, fontsize=7,
            )  # fmt: skip
        columns |= {f"{name}_m": place, f"share_beyond_{name}": outside}
        columns |= {f"{name}_holding_m": sizes, f"share_within_{name}": [percent / 100 for percent in SHARES]}
    for percent in SHARES:
        axes.axhline(1 - percent / 100, color=GREY, linestyle=":", linewidth=0.6, zorder=0)
    axes.set_yscale("log")
    axes.set_ylim(_LEAST, 1)
    axes.set_xlim(0, 1.05 * (reach or diameter) / diameter)
    words = {"depth": "depth", "radius": "distance from the impact axis"}
    title = ", or ".join(words[name] for name in distances)
    axes.set_xlabel(f"{title[:1].upper()}{title[1:]} $/{unit}$")
    axes.set_ylabel("Energy of yielding farther out\n/ whole energy of yielding")
    axes.plot([], [], "o", color=GREY, markersize=4, label="holds 50, 90, 99 %")
    legend_above(axes, 3, fontsize=7)
    return Drawing(figure, columns)


def _outside(distance: Array, energy: Array) -> tuple[Array, Array]:
    """Return distances, rising from 0, and the share of the energy that lies beyond each."""
    order = np.argsort(distance, kind="stable")
    place, held = distance[order], np.cumsum(energy[order])
    last = np.append(np.diff(place) > _SAME * place[-1], True)  # last of the parts at the same distance
    place, beyond = place[last], 1 - held[last] / held[-1]
    if place[0] > 0:
        place, beyond = np.insert(place, 0, 0.0), np.insert(beyond, 0, 1.0)
    return place, beyond
