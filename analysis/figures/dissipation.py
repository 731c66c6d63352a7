"""Figures of the dissipation of spheres: in descending order, and accumulated over their volume."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.figures.sections import spheres_beyond_law
from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import BLUE, GREEN, ORANGE, PURPLE, Drawing, legend_above
from granwave.analysis.measures.impact import cumulated, ranked
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.packing.cylinders import CYLINDERS

_RANGE = 1e-10  # smallest / largest dissipation in the ranked figure
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
