"""Size of the plastic zone against energy, packings and continuum side by side: what holds 50, 90 and 99 %.

Lengths are in diameters, of the spheres and of the punch, volumes in pi D^3/6, energies in sigma_y^2 D^3/E.

Sizes of a plastic zone as a summary tells them, in diameters: packings and blocks can be laid side by side.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from granwave.analysis.document.cells import show, value_cell
from granwave.analysis.document.model import Cell, Column, Note, Table, Tone
from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import BLUE, ORANGE, Drawing
from granwave.analysis.measures.zone_size import Mark, bounds_in_words, mark_of
from granwave.analysis.quantities import SHARES
from granwave.analysis.scans.axes import draw_marks, log_ticks, marked_marker, marks_of
from granwave.analysis.studies.packing_and_block.curves import GRANULAR_ENERGY
from granwave.analysis.studies.packing_and_block.impacts import SAME, Continuum, Granular, Impacts, energy_unit
from granwave.analysis.studies.study import Sketch
from granwave.analysis.studies.tables import numeric, table_of

_ROOM = 1.6  # inches: length of the horizontal axis of a panel
_MARKERS = "os^"  # of the shares
_SIZES = {"depth": "Depth $/D$", "radius": "Radius $/D$", "volume": r"Volume $/(\pi D^3/6)$"}
_LOOKS: Mapping[str, tuple[str, str]] = {"packing": (BLUE, "-"), "continuum": (ORANGE, "--")}
_CUT_REMARK = (
    "Where the zone reaches a bound (open marks in the figure), or still grew when the run ended, the outermost yield "
    "lies farther out than found: ≥. What holds 50 and 90 % lies far inside: between 36 x 36 x 18 and 72 x 72 x 36 "
    "spheres, struck at 10 and 40 m/s, its depth and radius differ by a layer at most and its volume by 5 %, that of "
    "99 % by 11 %."
)
_WAVE_REMARK = (
    "Half open marks: a wave could be back from a bound while the last part of the energy was dissipated. It matters "
    "little: in a block twice as wide and high, struck by 0.1 kg at 24 m/s, depth and radius differ by an element at "
    "most, 2 %, and the volume by 0.3 %."
)


class RunZone(NamedTuple):
    """Plastic zone of a run; the energy is its input over sigma_y^2 D^3/E."""

    run: Granular | Continuum
    energy: float
    zone: Zone


def zone_of(run: Granular | Continuum) -> RunZone | None:
    """Return the plastic zone of a run; None where its summary, of an older version, does not tell."""
    zone = zone_in_diameters(run.summary, run.diameter)
    return RunZone(run, run.energy / energy_unit(run.case.material, run.diameter), zone) if zone else None


def packing_zones(impacts: Impacts) -> list[RunZone]:
    """Return the zones of the reference's spheres, one of them struck, by energy: each in the largest packing."""
    if not impacts.reference:
        return []
    first = impacts.reference[0]
    same = [
        run
        for run in impacts.granular
        if run.substance == first.substance
        and run.case.load.spheres == 1
        and run.case.packing.kind == first.case.packing.kind
        and run.case.boundary == first.case.boundary
    ]
    largest_first = sorted(same, key=lambda run: (run.energy, -run.assembly.lattice.n_spheres))
    chosen: list[RunZone] = []
    for one in filter(None, map(zone_of, largest_first)):
        if not chosen or one.energy > chosen[-1].energy * (1 + SAME):
            chosen.append(one)
    return chosen


def continuum_zones(impacts: Impacts) -> list[RunZone]:
    """Return the zones of the continuum reference, by energy."""
    return list(filter(None, map(zone_of, impacts.continuum_reference)))


def pictures(impacts: Impacts) -> Iterator[Sketch]:
    """Sizes against energy, of packings and beside them of blocks."""
    sides = {"packing": packing_zones(impacts), "continuum": continuum_zones(impacts)}
    sizes = [name for name in _SIZES if any(_in_the_figure(name, one.zone) for side in sides.values() for one in side)]
    if sizes and sides["packing"] and sum(map(len, sides.values())) > 1:
        caption = (
            "Size of the plastic zone: what holds 50, 90 and 99 % of the energy of yielding. Straight lines are powers "
            "of the input; open marks reach a bound"
        )
        yield Sketch("plastic_zone", caption, partial(_zone_sizes, sides, sizes))


def tables(impacts: Impacts) -> Iterator[Table | Note]:
    """Sizes of all runs, and remarks on those that a bound or the end of the run decides."""
    found = [*packing_zones(impacts), *continuum_zones(impacts)]
    if not found:
        return
    columns = (
        Column("Run", key=True),
        Column("What", key=True),
        *numeric("Input over sigma_y^2 D^3/E", key=True),
        *numeric(*((f"Depth {percent} %", "D") for percent in SHARES), ("Outermost depth", "D")),
        *numeric(*((f"Radius {percent} %", "D") for percent in SHARES), ("Outermost radius", "D")),
        *numeric(*((f"Volume {percent} %", "pi D^3/6") for percent in SHARES)),
        Column("Zone reaches"),
        *numeric("Dissipated after waves came back"),
    )
    caption = "Plastic zone: what holds 50, 90 and 99 % of the energy of yielding, and the outermost yield"
    yield table_of(caption, columns, map(_row, found), sortable=True)
    if any(any(one.zone.open_ended) for one in found):
        yield Note(_CUT_REMARK, "note")
    if any(one.zone.mark is Mark.WAVE and isinstance(one.run, Continuum) for one in found):
        yield Note(_WAVE_REMARK, "note")


def _row(one: RunZone) -> Iterator[Cell]:
    summary, zone = one.run.summary, one.zone
    tone: Tone = "note" if zone.mark else ""
    yield from (value_cell(one.run.label), Cell(one.run.what), value_cell(one.energy))
    for sizes, outermost, open_ended in zip((zone.depth, zone.radius), zone.outermost, zone.open_ended, strict=True):
        yield from (_size(size, tone) for size in sizes)
        yield _size(outermost, tone, "≥ " if open_ended else "")
    yield from (_size(size, tone) for size in zone.volume)
    yield Cell(bounds_in_words(summary.get("zone_cut")), tone=tone)
    yield value_cell(summary.get("wave_return_share"), tone=tone)


def _size(value: float, tone: Tone, before: str = "") -> Cell:
    """Cell of a size with four digits."""
    return value_cell(None) if math.isnan(value) else Cell(before + show(float(f"{value:.4g}")), value, tone)


def _in_the_figure(name: str, zone: Zone) -> bool:
    """Return True if a size has a value above 0; one layer of spheres has no depth."""
    return any(value > 0 for value in getattr(zone, name))


def _zone_sizes(sides: Mapping[str, Sequence[RunZone]], sizes: Sequence[str]) -> Drawing:
    """Depth, radius and volume that hold 50, 90 and 99 % of the energy of yielding against the input energy."""
    figure, *axes_of_sizes = panels(3.1, len(sizes))
    for axes, name in zip(axes_of_sizes, sizes, strict=True):
        for what, zones in sides.items():
            _curves(axes, name, zones, *_LOOKS[what])
        label(axes, r"$e_\mathrm{in} E/(\sigma_\mathrm{y}^2 D^3)$", _SIZES[name], log="xy")
        log_ticks(axes.xaxis, _ROOM)
        log_ticks(axes.yaxis)
        _axis_of_contacts(axes, sides["packing"][0])
    lines: list[dict[str, Any]] = [
        {"color": colour, "linestyle": line, "label": what} for what, (colour, line) in _LOOKS.items() if sides[what]
    ]
    lines += [
        {"color": "black", "marker": marker, "linestyle": "none", "markersize": 4, "label": f"{percent} %"}
        for marker, percent in zip(_MARKERS, SHARES, strict=True)
    ]
    lines.append({"color": "black", "linestyle": ":", "linewidth": 0.9, "label": "outermost yield"})
    marks = marks_of([_marks(zones) for zones in sides.values()])
    lines += [{"label": text, **marked_marker(mark, "o", 4, "black")} for mark, text in marks.items()]
    handles = [Line2D([], [], **line) for line in lines]
    figure.legend(handles=handles, loc="outside upper center", ncols=len(handles), fontsize=6.5, columnspacing=1.0)
    return Drawing(figure, _columns(sides))


def _columns(sides: Mapping[str, Sequence[RunZone]]) -> dict[str, list]:
    zones = [one for side in sides.values() for one in side]
    columns: dict[str, list] = {
        "what": [what for what, side in sides.items() for _ in side],
        "energy_normalised": [one.energy for one in zones],
        "mark": [int(one.zone.mark) for one in zones],
    }
    for name in _SIZES:
        for n, percent in enumerate(SHARES):
            columns[f"{name}_{percent}"] = [getattr(one.zone, name)[n] for one in zones]
    for n, name in enumerate(("depth", "radius")):
        columns[f"outermost_{name}"] = [one.zone.outermost[n] for one in zones]
        columns[f"outermost_{name}_open_ended"] = [int(one.zone.open_ended[n]) for one in zones]
    return columns


def _curves(axes: Axes, name: str, zones: Sequence[RunZone], colour: str, line: str) -> None:
    """Draw one size of the zones of packings or blocks, with the outermost yield."""
    x = np.array([one.energy for one in zones])
    for n, marker in enumerate(_MARKERS):
        y = _positive([getattr(one.zone, name)[n] for one in zones])
        axes.plot(x, y, linestyle=line, color=colour, marker=marker, markersize=4, linewidth=0.8)
        draw_marks(axes, x, y, _marks(zones), marker, 4, colour)
    if name != "volume":
        outermost = _positive([one.zone.outermost[name == "radius"] for one in zones])
        axes.plot(x, outermost, ":", color=colour, linewidth=0.9)


def _positive(values: Sequence[float]) -> np.ndarray:
    """Values with gaps where nothing yielded, which has no place on a logarithmic axis."""
    return np.array([value or math.nan for value in values], dtype=np.float64)


def _marks(zones: Sequence[RunZone]) -> np.ndarray:
    return np.array([int(one.zone.mark) for one in zones], dtype=np.int64)


def _axis_of_contacts(axes: Axes, one: RunZone) -> None:
    """Give the energies of the packing in F_y alpha_y too, on top."""
    factor = one.run.energy_normalised / one.energy
    axes.tick_params(axis="x", which="both", top=False)
    there, back = (lambda x: factor * np.asarray(x, float)), (lambda x: np.asarray(x, float) / factor)
    top = axes.secondary_xaxis("top", functions=(there, back))
    top.set_xlabel(GRANULAR_ENERGY.removeprefix("Input energy ") + ", packing", fontsize=7)
    top.tick_params(labelsize=7)
    low, high = there(axes.get_xlim())
    top.xaxis.set_view_interval(low, high, ignore=True)  # else it has that of the axis below only when it is drawn
    log_ticks(top.xaxis, _ROOM)


@dataclasses.dataclass(frozen=True)
class Zone:
    """Plastic zone of one run: lengths in diameters, of the spheres or of the punch, volumes in pi D^3/6.

    Attributes
    ----------
    depth, radius, volume
        That hold each of `SHARES`; NaN where a size does not apply.
    outermost
        Depth and radius of the outermost yield; NaN as above.
    open_ended
        The same of both: the run ended, or a bound cut it, before the outermost yield was reached.
    mark
        Influence of the finite packing or block.
    """

    depth: tuple[float, ...]
    radius: tuple[float, ...]
    volume: tuple[float, ...]
    outermost: tuple[float, ...]
    open_ended: tuple[bool, bool]
    mark: Mark


def zone_in_diameters(summary: Mapping[str, Any], diameter: float) -> Zone | None:
    """Return the plastic zone of a run; None where its summary, of an older version, does not tell."""
    if summary.get(f"zone_volume_{SHARES[0]}_m3") is None:
        return None

    def sizes(unit: float, *names: str) -> tuple[float, ...]:
        found = [summary.get(name) for name in names]
        return tuple(math.nan if value is None else float(value) / unit for value in found)

    cut, growing = summary.get("zone_cut") or (), summary.get("zone_growing") or ()
    return Zone(
        depth=sizes(diameter, *(f"zone_depth_{percent}_m" for percent in SHARES)),
        radius=sizes(diameter, *(f"zone_radius_{percent}_m" for percent in SHARES)),
        volume=sizes(math.pi * diameter**3 / 6, *(f"zone_volume_{percent}_m3" for percent in SHARES)),
        outermost=sizes(diameter, "plastic_zone_depth_m", "plastic_zone_radius_m"),
        open_ended=("bottom" in cut or "depth" in growing, "sides" in cut or "radius" in growing),
        mark=mark_of(summary),
    )
