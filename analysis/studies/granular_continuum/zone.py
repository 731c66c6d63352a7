"""Size of the plastic zone against energy, packings and continuum side by side: what holds 50, 90 and 99 %.

Lengths are in diameters, of the spheres and of the punch, volumes in pi D^3/6, energies in sigma_y^2 D^3/E.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from granwave.analysis.figures.style import BLUE, ORANGE, Drawing, new_figure
from granwave.analysis.measures.zone.marks import Mark, mark_of
from granwave.analysis.quantities import SHARES
from granwave.analysis.scans.axes import log_ticks
from granwave.analysis.scans.marks import draw_marks, marked_marker, marks_of
from granwave.analysis.studies.granular_continuum.impacts import (
    SAME,
    Continuum,
    Granular,
    Impacts,
    energy_unit,
    substance,
)
from granwave.analysis.studies.granular_continuum.scaling import GRANULAR_ENERGY

_MARKERS = "os^"  # of the shares
_QUANTITIES = {"depth": "Depth $/D$", "radius": "Radius $/D$", "volume": r"Volume $/(\pi D^3/6)$"}
_LOOKS: Mapping[str, tuple[str, Literal["-", "--"]]] = {"packing": (BLUE, "-"), "continuum": (ORANGE, "--")}
_FEWEST = 2


@dataclasses.dataclass(frozen=True)
class Zone:
    """Plastic zone of one run, in diameters and in pi D^3/6.

    Attributes
    ----------
    energy
        Input over sigma_y^2 D^3/E.
    depth, radius, volume
        That hold each of `SHARES`; None where a size does not apply.
    outermost
        Depth and radius of the outermost yield; None as above.
    open_ended
        The same of both: the run ended, or a bound cut it, before the outermost yield was reached.
    """

    run: Granular | Continuum
    energy: float
    depth: tuple[float | None, ...]
    radius: tuple[float | None, ...]
    volume: tuple[float | None, ...]
    outermost: tuple[float | None, ...]
    open_ended: tuple[bool, bool]

    @property
    def mark(self) -> Mark:
        """Mark of the run."""
        return mark_of(self.run.summary)


def zone_of(run: Granular | Continuum) -> Zone | None:
    """Return the plastic zone of a run; None where its summary, of an older version, does not tell."""
    if run.summary.get(f"zone_volume_{SHARES[0]}_m3") is None:
        return None
    diameter = run.case.packing.diameter if isinstance(run, Granular) else run.case.punch.diameter

    def sizes(unit: float, *names: str) -> tuple[float | None, ...]:
        found = [run.summary.get(name) for name in names]
        return tuple(None if value is None else float(value) / unit for value in found)

    cut, growing = run.summary.get("zone_cut") or (), run.summary.get("zone_growing") or ()
    return Zone(
        run=run,
        energy=run.energy / energy_unit(run.case.material, diameter),
        depth=sizes(diameter, *(f"zone_depth_{percent}_m" for percent in SHARES)),
        radius=sizes(diameter, *(f"zone_radius_{percent}_m" for percent in SHARES)),
        volume=sizes(math.pi * diameter**3 / 6, *(f"zone_volume_{percent}_m3" for percent in SHARES)),
        outermost=sizes(diameter, "plastic_zone_depth_m", "plastic_zone_radius_m"),
        open_ended=("bottom" in cut or "depth" in growing, "sides" in cut or "radius" in growing),
    )


def packing_zones(impacts: Impacts) -> list[Zone]:
    """Return the zones of the reference's spheres, one of them struck, by energy: each in the largest packing."""
    if not impacts.reference:
        return []
    first = impacts.reference[0]
    same = [
        run
        for run in impacts.granular
        if substance(run) == substance(first)
        and run.case.load.spheres == 1
        and run.case.packing.kind == first.case.packing.kind
        and run.case.boundary == first.case.boundary
    ]
    largest_first = sorted(same, key=lambda run: (run.energy, -run.assembly.lattice.n_spheres))
    chosen: list[Zone] = []
    for zone in filter(None, map(zone_of, largest_first)):
        if not chosen or zone.energy > chosen[-1].energy * (1 + SAME):
            chosen.append(zone)
    return chosen


def continuum_zones(impacts: Impacts) -> list[Zone]:
    """Return the zones of the continuum reference, by energy."""
    return [zone for zone in map(zone_of, impacts.continuum_reference) if zone is not None]


def zone_sizes(impacts: Impacts) -> Drawing | None:
    """Depth, radius and volume that hold 50, 90 and 99 % of the energy of yielding against the input energy."""
    sides = {"packing": packing_zones(impacts), "continuum": continuum_zones(impacts)}
    if sum(map(len, sides.values())) < _FEWEST or not sides["packing"]:
        return None
    figure = new_figure(3.1, 7.0)
    panels = figure.subplots(1, 3)
    columns: dict[str, list] = {"what": [], "energy_normalised": [], "mark": []}
    columns |= {f"{name}_{percent}": [] for name in _QUANTITIES for percent in SHARES}
    columns |= {f"outermost_{name}": [] for name in ("depth", "depth_open_ended", "radius", "radius_open_ended")}
    for what, zones in sides.items():
        columns["what"] += [what] * len(zones)
        columns["energy_normalised"] += [zone.energy for zone in zones]
        columns["mark"] += [int(zone.mark) for zone in zones]
        for axes, name in zip(panels, _QUANTITIES, strict=True):
            for n, percent in enumerate(SHARES):
                values = [getattr(zone, name)[n] for zone in zones]
                columns[f"{name}_{percent}"] += [math.nan if value is None else value for value in values]
                _curve(axes, zones, values, n, what)
        for n, (axes, name) in enumerate(zip(panels, ("depth", "radius"), strict=False)):
            outermost = [zone.outermost[n] for zone in zones]
            columns[f"outermost_{name}"] += [math.nan if value is None else value for value in outermost]
            columns[f"outermost_{name}_open_ended"] += [int(zone.open_ended[n]) for zone in zones]
            x, y = [zone.energy for zone in zones], [value or math.nan for value in outermost]
            axes.plot(x, y, ":", color=_LOOKS[what][0], linewidth=0.9)
    for axes, title in zip(panels, _QUANTITIES.values(), strict=True):
        axes.set_xscale("log")
        axes.set_yscale("log")
        log_ticks(axes.yaxis)
        axes.set_ylabel(title)
        axes.set_xlabel(r"$e_\mathrm{in} E/(\sigma_\mathrm{y}^2 D^3)$")
    _axis_of_contacts(panels, sides["packing"][0])
    marks = marks_of([_marks(zones) for zones in sides.values()])
    handles = [
        Line2D([], [], color=colour, linestyle=line, label=what)
        for what, (colour, line) in _LOOKS.items()
        if sides[what]
    ]
    handles += [
        Line2D([], [], color="black", marker=marker, linestyle="none", markersize=4, label=f"{percent} %")
        for marker, percent in zip(_MARKERS, SHARES, strict=True)
    ]
    handles.append(Line2D([], [], color="black", linestyle=":", linewidth=0.9, label="outermost yield"))
    handles += [Line2D([], [], label=label, **marked_marker(mark, "o", 4, "black")) for mark, label in marks.items()]
    figure.legend(handles=handles, loc="outside upper center", ncols=len(handles), fontsize=6.5, columnspacing=1.0)
    return Drawing(figure, columns)


def _curve(axes: Axes, zones: Sequence[Zone], values: Sequence[float | None], n: int, what: str) -> None:
    colour, line = _LOOKS[what]
    x = np.array([zone.energy for zone in zones])
    y = np.array([value or math.nan for value in values], dtype=np.float64)  # nothing yielded: not on a log axis
    axes.plot(x, y, line, color=colour, marker=_MARKERS[n], markersize=4, linewidth=0.8)
    draw_marks(axes, x, y, _marks(zones), _MARKERS[n], 4, colour)


def _marks(zones: Sequence[Zone]) -> np.ndarray:
    return np.array([int(zone.mark) for zone in zones], dtype=np.int64)


def _axis_of_contacts(panels: Sequence[Axes], zone: Zone) -> None:
    """Give the energies of the packing in F_y alpha_y too, on top."""
    run = zone.run
    assert isinstance(run, Granular)
    factor = run.energy_normalised / zone.energy
    for axes in panels:
        axes.tick_params(axis="x", which="both", top=False)
        there, back = (lambda x: factor * np.asarray(x, float)), (lambda x: np.asarray(x, float) / factor)
        top = axes.secondary_xaxis("top", functions=(there, back))
        top.set_xlabel(GRANULAR_ENERGY.removeprefix("Input energy ") + ", packing", fontsize=7)
        top.tick_params(labelsize=7)
