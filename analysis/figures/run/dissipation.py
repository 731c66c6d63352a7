"""Figures of dissipation by sphere, growth of the plastic zone, and decay of peak forces."""

from __future__ import annotations

import numpy as np
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from granwave.analysis.figures.run.sections import force_scale, spheres_beyond_law
from granwave.analysis.figures.style import BLUE, GREEN, ORANGE, PURPLE, Drawing, new_figure
from granwave.analysis.measures.impact import cumulated, peak_force_by_depth, ranked, rays, zone_growth
from granwave.analysis.measures.zone import packing_zone
from granwave.analysis.measures.zone_size import bounds_in_words
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.packing.cylinders import CYLINDERS

_MILLI = 1e3  # mm in a metre
_MICRO = 1e6  # microseconds in a second
_SHOWN_SHARE = 0.95  # share of the dissipation up to which the cumulated figure goes
_RANGE = 1e-10  # smallest over largest dissipation in the ranked figure
_ALL = {2: "both", 3: "all"}  # label of the sum, by number of kinds of dissipation


def dissipation_ranked(result: Result) -> Drawing | None:
    """Draw the dissipation of the spheres in descending order, with rings beyond the law's range.

    With friction, also that by yielding and by friction, each in its own descending order.
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
    figure = new_figure(2.4)
    axes = figure.subplots()
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
        axes.loglog(np.arange(1, len(own) + 1), own / unit, line, color=colour, linewidth=1.0, label=part)
        columns[f"{part}_in_descending_order_J"] = own
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="lower left")
    axes.set_ylim(bottom=max(float(values.min()), float(values[0]) * _RANGE) / 2)
    axes.set_xlabel("Number of spheres, in descending order")
    axes.set_ylabel(r"Dissipation $e_\mathrm{dis}/(F_\mathrm{y}\,\alpha_\mathrm{y})$")
    return Drawing(figure, columns)


def dissipation_cumulated(result: Result) -> Drawing | None:
    """Draw the volume of the spheres that dissipate a given share of the input.

    With friction, also for dissipation by yielding and by friction alone.
    """
    if not np.any(result["spheres/dissipated_energy"] > 0):
        return None
    in_plane = result.assembly.grains_called == CYLINDERS  # of one length
    volumes = (2 * result["spheres/radius"] / result.case.packing.diameter) ** (2 if in_plane else 3)
    fraction, volume = cumulated(result["spheres/dissipated_energy"], result.energy_input, volumes)
    enough = int(np.searchsorted(fraction, _SHOWN_SHARE * fraction[-1])) + 1
    figure = new_figure(2.4)
    axes = figure.subplots()
    parts = _parts(result)
    axes.plot(fraction[:enough], volume[:enough], "-o", color=BLUE, markersize=2.5, label=_ALL.get(len(parts)))
    axes.axvline(fraction[-1], color="black", linestyle=":", linewidth=0.8)
    columns = {"dissipated_over_input": fraction, "volume_over_sphere_volume": volume}
    top = float(volume[min(enough, len(volume)) - 1])
    for part, (share, colour, line) in parts.items():
        own, spheres = cumulated(share, result.energy_input, volumes)
        last = int(np.searchsorted(own, _SHOWN_SHARE * own[-1])) + 1 if len(own) else 0
        axes.plot(own[:last], spheres[:last], line, color=colour, label=part)
        top = max([top, *spheres[:last][-1:]])
        columns |= {f"{part}_over_input": own, f"{part}_volume_over_sphere_volume": spheres}
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="best")
    axes.set_xlim(0, 1)
    axes.set_ylim(0, max(1.05 * top, 2))
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    axes.text(
        fraction[-1] + 0.01, 0.97, f"all {len(volume)} spheres", rotation=90, ha="left", va="top",
        transform=axes.get_xaxis_transform(),
    )  # fmt: skip
    axes.set_xlabel("Dissipation / energy input")
    axes.set_ylabel("Volume / that of a cylinder" if in_plane else r"Volume / ($\pi D^3/6$)")
    return Drawing(figure, columns)


def _parts(result: Result) -> dict[str, tuple[NDArray[np.float64], str, str]]:
    """Return the dissipation by yielding, friction and losses, with colour and line; empty if there is one kind."""
    styles = {"friction": ("friction_energy", GREEN, ":"), "viscous losses": ("viscous_energy", PURPLE, "-.")}
    others = {
        part: (result[f"spheres/{name}"], colour, line)
        for part, (name, colour, line) in styles.items()
        if result.has(f"spheres/{name}")
    }
    yielding = result.yield_energy
    if result.yields or yielding.any():
        others = {"yielding": (yielding, ORANGE, "--")} | others
    return others if len(others) > 1 else {}


def plastic_zone_growth(result: Result) -> Drawing | None:
    """Draw the number of yielded contacts and spheres, and depth and radius of the outermost, against time.

    The title names the boundaries that the zone reaches.
    """
    growth = zone_growth(result)
    if not len(growth.time):
        return None
    end = float(result["energy/time"][-1])

    def to_end(values: np.ndarray) -> np.ndarray:
        return np.concatenate([[0], values, values[-1:]])

    time = np.concatenate([[0.0], growth.time, [end]]) * _MICRO
    figure = new_figure(3.2)
    upper, lower = figure.subplots(2, 1, sharex=True)
    if cut := packing_zone(result).cut:
        upper.set_title(f"the zone reaches a bound: {bounds_in_words(cut)}", fontsize=7)
    upper.step(time, to_end(growth.contacts), where="post", color=BLUE, label="contacts")
    upper.step(time, to_end(growth.spheres), where="post", color=ORANGE, linestyle="--", label="spheres")
    upper.set_ylabel("Number yielded")
    upper.set_ylim(bottom=0)
    lower.step(time, to_end(growth.depth) * _MILLI, where="post", color=BLUE, label="depth")
    lower.step(time, to_end(growth.radius) * _MILLI, where="post", color=ORANGE, linestyle="--", label="radius")
    lower.set_ylabel("Outermost yield (mm)")
    lower.set_ylim(bottom=0)
    lower.set_xlabel("Time (µs)")
    lower.set_xlim(0, end * _MICRO)
    for axes in (upper, lower):
        axes.legend(loc="lower right")
    columns = {"time_s": growth.time, "contacts": growth.contacts, "spheres": growth.spheres}
    return Drawing(figure, columns | {"depth_m": growth.depth, "radius_m": growth.radius})


def peak_force_depth(result: Result) -> Drawing | None:
    """Draw the decay of the peak force: largest of each layer, and along the preferred directions."""
    depth, force = peak_force_by_depth(result)
    if len(depth) < 2 or not np.any(force > 0) or "chain" in result:  # a chain has a figure of its own
        return None
    scale, label, name = force_scale(result)
    along = rays(result)
    n_contacts, n_rays = along.peak_force.shape
    pitch = result.case.packing.diameter * along.directions[0, 2] if n_rays else 0.0
    middle = (np.arange(n_contacts) + 0.5) * pitch  # depth of the contact points
    figure = new_figure(2.4)
    axes = figure.subplots()
    if n_rays > 1 and n_contacts > 1:
        colours = (ORANGE, GREEN, "black", ORANGE)
        for n, (marker, colour, values) in enumerate(zip("o^vs", colours, along.peak_force.T, strict=False)):
            axes.plot(
                middle * _MILLI, values / scale, marker, color=colour, markerfacecolor="none",
                markersize=5 - 0.5 * n, markeredgewidth=0.8, label=f"preferred direction {n + 1}",
            )  # fmt: skip
    axes.plot(depth * _MILLI, force / scale, "-", color=BLUE, label="largest of the layer", zorder=1)
    axes.set_yscale("log")
    axes.set_xlim(0, depth[-1] * _MILLI)
    axes.set_xlabel("Depth (mm)")
    axes.set_ylabel(f"Peak force {label}")
    axes.legend(fontsize=8)
    columns = {"layer_depth_m": depth, f"layer_peak_{name}": force / scale, "contact_depth_m": middle}
    columns |= {f"direction_{n + 1}_{name}": values / scale for n, values in enumerate(along.peak_force.T)}
    return Drawing(figure, columns)
