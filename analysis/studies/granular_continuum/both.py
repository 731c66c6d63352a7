"""Granular against continuum: dissipated fraction, volume involved, dissipation per mass and volume (thesis 5.5)."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from granwave.analysis.figures.style import BLUE, ORANGE, SKY, Drawing, new_figure
from granwave.analysis.measures.dissipation import cumulated
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.granular_continuum.continuum import masses
from granwave.analysis.studies.granular_continuum.granular import variants
from granwave.analysis.studies.granular_continuum.impacts import Continuum, Granular, Impacts, constants, energy_unit
from granwave.analysis.studies.granular_continuum.scaling import FRACTION, MARKERS
from granwave.lammps_inputs.errors import GranwaveError
from granwave.lammps_inputs.lattices import KINDS
from granwave.lammps_inputs.run_directory import RESULT_FILE

SHARE = 0.9  # of the dissipation: the material that did so much of it is called involved
_SHOWN_SHARE = 0.95  # of the dissipation: how far curves of cumulated dissipation go
_LINES = ("-", "--", ":")
_GRANULAR_SHOWN = 3  # curves of the figure of volumes


def dissipated_fraction(impacts: Impacts) -> Drawing | None:
    """Fraction against input energy of both, by sigma_y^2 D^3/E with the diameter of the punch (thesis Fig. 5.13).

    Spheres of the reference material alone are shown, by diameter: the unit is then the same for all.
    """
    if not impacts.reference or not impacts.continuum_reference:
        return None
    diameter = impacts.continuum_reference[0].case.punch.diameter
    reference = impacts.reference[0].case.material
    figure = new_figure(2.8)
    axes = figure.subplots()
    columns: dict[str, list] = {"curve": [], "energy_normalised": [], "dissipated_fraction": []}

    def add(name: str, energy: list[float], fraction: list[float], **style: Any) -> None:
        axes.plot(energy, fraction, label=name, markersize=4, linewidth=0.8, **style)
        columns["curve"] += [name] * len(energy)
        columns["energy_normalised"] += energy
        columns["dissipated_fraction"] += fraction

    shown = 0
    for _, runs in variants(impacts):
        if constants(runs[0]) == constants(impacts.reference[0]):
            unit = energy_unit(reference, diameter)
            name = f"granular, D = {1e3 * runs[0].case.packing.diameter:.4g} mm"
            energy, fraction = [run.energy / unit for run in runs], [run.fraction for run in runs]
            add(name, energy, fraction, color=(BLUE, SKY, "black")[shown % 3], marker="os^"[shown % 3])
            shown += 1
    for n, (name, group) in enumerate(masses(impacts)):
        energy, fraction = [run.energy_normalised for run in group], [run.fraction for run in group]
        add(
            f"continuum, {name}", energy, fraction, color=ORANGE, marker="vD*"[n % 3], linestyle=("-", "--", ":")[n % 3]
        )
    axes.set_xscale("log")
    axes.set_ylim(0, 1)
    axes.set_xlabel(r"Input energy $e_\mathrm{in} E/(\sigma_\mathrm{y}^2 D_\mathrm{punch}^3)$")
    axes.set_ylabel(FRACTION)
    axes.legend(loc="lower center", bbox_to_anchor=(0.58, 0.03), fontsize=6)
    return Drawing(figure, columns)


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
        if isinstance(run, Granular):
            with Result(run.directory) as result:
                fraction, count = cumulated(result["spheres/dissipated_energy"], run.energy)
            each = math.pi * run.case.packing.diameter**3 / 6
            volume, solid = each * count.astype(np.float64), KINDS[run.case.packing.kind].solid_fraction
        else:
            fraction, volume, solid = *_of_elements(run), 1.0
    except (GranwaveError, OSError, KeyError):
        return None
    if not len(fraction) or fraction[-1] <= 0:
        return None
    enough = int(np.searchsorted(fraction, SHARE * fraction[-1]))
    part = float(volume[enough])
    energy = float(fraction[enough]) * run.energy
    return Involved(fraction, volume, part * run.case.material.density, part / solid, energy)


def _of_elements(run: Continuum) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    with h5py.File(run.directory / RESULT_FILE, "r") as file:
        density, volume = file["fields/plastic_energy"][()], file["element_volume"][()]
    order = np.argsort(-density, kind="stable")
    order = order[: np.count_nonzero(density > 0)]
    return np.cumsum(density[order] * volume[order]) / run.energy, np.cumsum(volume[order])


def plastic_volume(impacts: Impacts) -> Drawing | None:
    """Volume that dissipates a fraction of the input: granular curves, continuum marks (thesis Fig. 5.14)."""
    chosen = _granular_shown(impacts)
    if not chosen or not impacts.continuum_reference:
        return None
    diameter = impacts.continuum_reference[0].case.punch.diameter
    unit = math.pi * diameter**3 / 6
    figure = new_figure(2.8)
    axes = figure.subplots()
    columns: dict[str, list] = {"curve": [], "dissipated_fraction": [], "volume_over_sphere_volume": []}

    def note(name: str, fraction: NDArray[np.float64] | list[float], volume: NDArray[np.float64] | list[float]) -> None:
        columns["curve"] += [name] * len(fraction)
        columns["dissipated_fraction"] += list(fraction)
        columns["volume_over_sphere_volume"] += list(volume)

    top = 0.0
    for n, run in enumerate(chosen):
        found = involved(run)
        if found is None:
            continue
        enough = int(np.searchsorted(found.fraction, _SHOWN_SHARE * found.fraction[-1])) + 1
        name = f"granular, {run.energy:.3g} J"
        axes.plot(found.fraction[:enough], found.volume[:enough] / unit, color=(BLUE, SKY, "black")[n % 3], label=name)
        note(name, found.fraction, found.volume / unit)
        top = max(top, float(found.volume[enough - 1]) / unit)
    for n, one in enumerate(impacts.continuum_reference):
        mark, name = MARKERS[n % len(MARKERS)], f"continuum, {one.energy:.3g} J"
        axes.plot(one.fraction, one.volume(), mark, color=ORANGE, markersize=4.5, label=name)
        axes.plot(one.fraction, one.volume(ever=True), mark, color=ORANGE, markerfacecolor="none", markersize=4.5)
        note(name, [one.fraction], [one.volume()])
        note(f"{name}, ever", [one.fraction], [one.volume(ever=True)])
    axes.set_xlim(0, 1)
    axes.set_yscale("log")
    axes.set_xlabel(FRACTION)
    axes.set_ylabel(r"Volume $/(\pi D_\mathrm{punch}^3/6)$")
    axes.set_title("open marks: volume that ever yielded", fontsize=7)
    axes.legend(fontsize=6, ncols=2, loc="lower right")
    return Drawing(figure, columns)


@dataclasses.dataclass(frozen=True)
class Specific:
    """Draw the dissipated energy of runs against the material that is deformed."""

    label: str
    what: str
    energy: float
    fraction: float
    mass: float
    bulk: float
    per_mass: float
    per_volume: float


def specific(impacts: Impacts) -> list[Specific]:
    """Dissipation per mass and per volume of the material involved, over the reference runs of both."""
    rows = []
    runs: list[Granular | Continuum] = [*_granular_shown(impacts, most=6), *impacts.continuum_reference]
    for run in runs:
        found = involved(run)
        if found is not None:
            what = "granular" if isinstance(run, Granular) else "continuum"
            rows.append(
                Specific(
                    run.label,
                    what,
                    run.energy,
                    run.fraction,
                    found.mass,
                    found.bulk,
                    found.energy / found.mass,
                    found.energy / found.bulk,
                )
            )
    return rows


def _granular_shown(impacts: Impacts, most: int = _GRANULAR_SHOWN) -> list[Granular]:
    """Runs of the reference that dissipate, from the largest energy down, a factor of two or more apart."""
    chosen: list[Granular] = []
    for run in reversed(impacts.reference):
        if run.fraction > 0 and len(chosen) < most and (not chosen or run.energy < 0.5 * chosen[-1].energy):
            chosen.append(run)
    return chosen[::-1]
