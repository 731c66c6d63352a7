"""Packings and continuum side by side: dissipated fraction, volume involved, dissipation per mass."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

from granwave.analysis.document.model import Cell, Column, Table
from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import BLUE, ORANGE, SKY, Drawing
from granwave.analysis.measures.impact import Involved, elements_involved, spheres_involved
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.packing_and_block.blocks import masses
from granwave.analysis.studies.packing_and_block.curves import FRACTION, MARKERS, add
from granwave.analysis.studies.packing_and_block.impacts import Continuum, Granular, Impacts, constants, energy_unit
from granwave.analysis.studies.packing_and_block.packings import variants
from granwave.analysis.studies.study import Sketch
from granwave.analysis.studies.tables import numeric, table_of
from granwave.lammps_inputs.errors import GranwaveError
from granwave.lammps_inputs.lattices import kind_of
from granwave.lammps_inputs.run_directory import RESULT_FILE

_FRACTION = "Dissipated fraction, granular and continuum. At equal input the higher curve dissipates a larger share"
_VOLUME = (
    "Volume involved, granular and continuum. At equal dissipated fraction the curve that lies higher spreads the "
    "dissipation over more material"
)
SHARE = 0.9  # of the dissipation: the material that did so much of it is called involved
_SHOWN_SHARE = 0.95  # of the dissipation: how far curves of cumulated dissipation go
_COLOURS = (BLUE, SKY, "black")  # of packings
_GRANULAR_SHOWN = 3  # curves of the figure of volumes
_GRANULAR_LISTED = 6  # rows of the table


def involved(run: Granular | Continuum) -> Involved | None:
    """The material of a run that dissipated; None where its result cannot be read, or nothing was dissipated."""
    try:
        if isinstance(run, Continuum):
            found = elements_involved(run.directory / RESULT_FILE, run.energy)
        else:
            with Result(run.directory) as result:
                found = spheres_involved(result, run.energy)
    except (GranwaveError, OSError, KeyError):
        return None
    return found if len(found.fraction) and found.fraction[-1] > 0 else None


def pictures(impacts: Impacts) -> Iterator[Sketch]:
    """Dissipated fraction and volume involved, where packings and blocks were hit."""
    if impacts.reference and impacts.continuum_reference:
        draw = partial(_dissipated_fraction, impacts)
        yield Sketch("dissipated_fraction", _FRACTION, draw)
        shown = _dissipating(impacts.reference, _GRANULAR_SHOWN)
        if shown:
            draw = partial(_plastic_volume, shown, impacts.continuum_reference)
            yield Sketch("plastic_volume", _VOLUME, draw)


def tables(impacts: Impacts) -> Iterator[Table]:
    """Dissipation per mass and per volume of the material involved, over the reference runs of both."""
    listed: list[Granular | Continuum] = [*_dissipating(impacts.reference, _GRANULAR_LISTED)]
    listed += impacts.continuum_reference
    rows = []
    for run in listed:
        if found := involved(run):
            fraction, volume = found.part(SHARE)
            solid = kind_of(run.case.packing.kind).solid_fraction if isinstance(run, Granular) else 1.0
            energy, mass, bulk = fraction * run.energy, volume * run.case.material.density, volume / solid
            values = run.energy, run.fraction, mass, 1e6 * bulk, energy / mass, 1e-6 * (energy / bulk)
            rows.append((run.label, Cell(run.what), *values))
    numbers = numeric(
        ("Input", "J"), "Dissipated fraction", ("Mass involved", "kg"), ("Volume involved, voids included", "cm³"),
        ("Dissipated per mass", "J/kg"), ("Dissipated per volume", "MJ/m³"),
    )  # fmt: skip
    if rows:
        caption = f"Dissipation per mass and volume of the material that does {100 * SHARE:.0f} % of it"
        yield table_of(caption, (Column("Run", key=True), Column("What"), *numbers), rows, sortable=True)


def _dissipating(reference: Sequence[Granular], most: int) -> list[Granular]:
    """Runs that dissipate, from the largest energy down, a factor of two or more apart; in rising order."""
    chosen: list[Granular] = []
    for run in reversed(reference):
        if run.fraction > 0 and len(chosen) < most and (not chosen or run.energy < 0.5 * chosen[-1].energy):
            chosen.append(run)
    return chosen[::-1]


def _dissipated_fraction(impacts: Impacts) -> Drawing:
    """Fraction against input energy of both, by sigma_y^2 D^3/E with the diameter of the punch.

    Spheres of the reference material alone are shown, by diameter: the unit is then the same for all.
    """
    material = impacts.reference[0].case.material
    unit = energy_unit(material, impacts.continuum_reference[0].diameter)
    figure, axes = panels(2.8)
    columns: dict[str, list] = {"curve": [], "energy_normalised": [], "dissipated_fraction": []}

    def curve(name: str, energy: list[float], fraction: list[float], **look: Any) -> None:
        axes.plot(energy, fraction, label=name, markersize=4, linewidth=0.8, **look)
        add(columns, [name] * len(energy), energy, fraction)

    like = [runs for _, runs in variants(impacts) if constants(runs[0].case.material) == constants(material)]
    for n, spheres in enumerate(like):
        name = f"granular, D = {1e3 * spheres[0].diameter:.4g} mm"
        look = {"color": _COLOURS[n % 3], "marker": "os^"[n % 3]}
        curve(name, [run.energy / unit for run in spheres], [run.fraction for run in spheres], **look)
    for n, (mass, blocks) in enumerate(masses(impacts)):
        look = {"color": ORANGE, "marker": "vD*"[n % 3], "linestyle": ("-", "--", ":")[n % 3]}
        energy, fraction = [run.energy_normalised for run in blocks], [run.fraction for run in blocks]
        curve(f"continuum, {mass}", energy, fraction, **look)
    energy_axis = r"Input energy $e_\mathrm{in} E/(\sigma_\mathrm{y}^2 D_\mathrm{punch}^3)$"
    label(axes, energy_axis, FRACTION, log="x", ylim=(0, 1))
    axes.legend(loc="lower center", bbox_to_anchor=(0.58, 0.03), fontsize=6)
    return Drawing(figure, columns)


def _plastic_volume(packings: Sequence[Granular], blocks: Sequence[Continuum]) -> Drawing:
    """Volume that dissipates a fraction of the input: granular curves, continuum marks."""
    unit = math.pi * blocks[0].diameter ** 3 / 6
    figure, axes = panels(2.8)
    columns: dict[str, list] = {"curve": [], "dissipated_fraction": [], "volume_over_sphere_volume": []}
    for run, colour in zip(packings, _COLOURS, strict=False):
        if found := involved(run):
            enough = found.enough(_SHOWN_SHARE) + 1
            name = f"granular, {run.energy:.3g} J"
            axes.plot(found.fraction[:enough], found.volume[:enough] / unit, color=colour, label=name)
            add(columns, [name] * len(found.fraction), found.fraction, found.volume / unit)
    for n, one in enumerate(blocks):
        mark, name = MARKERS[n % len(MARKERS)], f"continuum, {one.energy:.3g} J"
        axes.plot(one.fraction, one.volume, mark, color=ORANGE, markersize=4.5, label=name)
        axes.plot(one.fraction, one.volume_ever, mark, color=ORANGE, markerfacecolor="none", markersize=4.5)
        add(columns, [name, f"{name}, ever"], [one.fraction] * 2, [one.volume, one.volume_ever])
    label(axes, FRACTION, r"Volume $/(\pi D_\mathrm{punch}^3/6)$", log="y", xlim=(0, 1))
    axes.set_title("open marks: volume that ever yielded", fontsize=7)
    axes.legend(fontsize=6, ncols=2, loc="lower right")
    return Drawing(figure, columns)
