"""Packings and continuum side by side: dissipated fraction, volume involved, dissipation per mass (thesis 5.5)."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from granwave.analysis.document.cells import value_cell
from granwave.analysis.document.model import Cell, Column, Table
from granwave.analysis.figures.curves import label, panels
from granwave.analysis.figures.style import BLUE, ORANGE, SKY, Drawing
from granwave.analysis.measures.dissipation import cumulated
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.granular_continuum.blocks import masses
from granwave.analysis.studies.granular_continuum.curves import FRACTION, MARKERS, add
from granwave.analysis.studies.granular_continuum.impacts import Continuum, Granular, Impacts, constants, energy_unit
from granwave.analysis.studies.granular_continuum.packings import variants
from granwave.analysis.studies.study import Picture
from granwave.lammps_inputs.errors import GranwaveError
from granwave.lammps_inputs.lattices import KINDS
from granwave.lammps_inputs.run_directory import RESULT_FILE

SHARE = 0.9  # of the dissipation: the material that did so much of it is called involved
_SHOWN_SHARE = 0.95  # of the dissipation: how far curves of cumulated dissipation go
_COLOURS = (BLUE, SKY, "black")  # of packings
_GRANULAR_SHOWN = 3  # curves of the figure of volumes
_GRANULAR_LISTED = 6  # rows of the table


@dataclasses.dataclass(frozen=True, eq=False)
class Involved:
    """Material in descending order of its dissipation, cumulated; arrays (n,).

    Attributes
    ----------
    fraction
        Of the input, dissipated in the material so far.
    volume
        Of the solid, m^3.
    mass, bulk
        Of the solid that did `SHARE` of the dissipation, kg; and the volume it takes up, voids included, m^3.
    energy
        That this part dissipated, J.
    """

    fraction: NDArray[np.float64]
    volume: NDArray[np.float64]
    mass: float
    bulk: float
    energy: float


def involved(run: Granular | Continuum) -> Involved | None:
    """The material of a run that dissipated; None where its result cannot be read, or nothing was dissipated."""
    try:
        fraction, volume = _of_spheres(run) if isinstance(run, Granular) else _of_elements(run)
    except (GranwaveError, OSError, KeyError):
        return None
    if not len(fraction) or fraction[-1] <= 0:
        return None
    enough = int(np.searchsorted(fraction, SHARE * fraction[-1]))
    part = float(volume[enough])
    solid = KINDS[run.case.packing.kind].solid_fraction if isinstance(run, Granular) else 1.0
    return Involved(
        fraction, volume, part * run.case.material.density, part / solid, float(fraction[enough]) * run.energy
    )


def pictures(impacts: Impacts) -> Iterator[Picture]:
    """Dissipated fraction and volume involved, where packings and blocks were hit."""
    if impacts.reference and impacts.continuum_reference:
        drawing = _dissipated_fraction(impacts)
        yield Picture("dissipated_fraction", "Dissipated fraction, granular and continuum", drawing)
        shown = _dissipating(impacts.reference, _GRANULAR_SHOWN)
        if shown:
            drawing = _plastic_volume(shown, impacts.continuum_reference)
            yield Picture("plastic_volume", "Volume involved, granular and continuum", drawing)


def tables(impacts: Impacts) -> Iterator[Table]:
    """Dissipation per mass and per volume of the material involved, over the reference runs of both."""
    runs: list[Granular | Continuum] = [
        *_dissipating(impacts.reference, _GRANULAR_LISTED),
        *impacts.continuum_reference,
    ]
    rows = []
    for run in runs:
        if found := involved(run):
            per_mass, per_volume = found.energy / found.mass, found.energy / found.bulk
            values = run.energy, run.fraction, found.mass, 1e6 * found.bulk, per_mass, 1e-6 * per_volume
            rows.append((value_cell(run.label), Cell(run.what), *map(value_cell, values)))
    columns = (
        Column("Run", key=True),
        Column("What"),
        Column("Input", "J", numeric=True),
        Column("Dissipated fraction", numeric=True),
        Column("Mass involved", "kg", numeric=True),
        Column("Volume involved, voids included", "cm³", numeric=True),
        Column("Dissipated per mass", "J/kg", numeric=True),
        Column("Dissipated per volume", "MJ/m³", numeric=True),
    )
    if rows:
        caption = f"Dissipation per mass and volume of the material that does {100 * SHARE:.0f} % of it"
        yield Table(caption, columns, tuple(rows), sortable=True)


def _of_spheres(run: Granular) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    with Result(run.directory) as result:
        fraction, count = cumulated(result["spheres/dissipated_energy"], run.energy)
    return fraction, math.pi * run.diameter**3 / 6 * count


def _of_elements(run: Continuum) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    with h5py.File(run.directory / RESULT_FILE, "r") as file:
        density, volume = file["fields/plastic_energy"][()], file["element_volume"][()]
    order = np.argsort(-density, kind="stable")
    order = order[: np.count_nonzero(density > 0)]
    return np.cumsum(density[order] * volume[order]) / run.energy, np.cumsum(volume[order])


def _dissipating(reference: Sequence[Granular], most: int) -> list[Granular]:
    """Runs that dissipate, from the largest energy down, a factor of two or more apart; in rising order."""
    chosen: list[Granular] = []
    for run in reversed(reference):
        if run.fraction > 0 and len(chosen) < most and (not chosen or run.energy < 0.5 * chosen[-1].energy):
            chosen.append(run)
    return chosen[::-1]


def _dissipated_fraction(impacts: Impacts) -> Drawing:
    """Fraction against input energy of both, by sigma_y^2 D^3/E with the diameter of the punch (thesis Fig. 5.13).

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
    """Volume that dissipates a fraction of the input: granular curves, continuum marks (thesis Fig. 5.14)."""
    unit = math.pi * blocks[0].diameter ** 3 / 6
    figure, axes = panels(2.8)
    columns: dict[str, list] = {"curve": [], "dissipated_fraction": [], "volume_over_sphere_volume": []}
    for run, colour in zip(packings, _COLOURS, strict=False):
        if found := involved(run):
            enough = int(np.searchsorted(found.fraction, _SHOWN_SHARE * found.fraction[-1])) + 1
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
