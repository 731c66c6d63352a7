"""Continuum impacts against each other: scaling collapse, mass of the punch, taper of its edge (thesis 5.4.1)."""

from __future__ import annotations

import dataclasses

from granwave.analysis.figures.style import Drawing, new_figure
from granwave.analysis.studies.granular_continuum.impacts import (
    SAME,
    Continuum,
    Impacts,
    differences,
    distinct,
    grouped,
    punch,
    substance,
)
from granwave.analysis.studies.granular_continuum.scaling import (
    COLOURS,
    CONTINUUM_ENERGY,
    FRACTION,
    MARKERS,
    draw_scaling,
)

_FEWEST_CURVES = 2
_MILLI = 1e3

Curve = tuple[str, tuple[Continuum, ...]]


def materials(impacts: Impacts) -> list[Curve]:
    """The reference and the groups that differ from it in material alone, with their names."""
    if not impacts.continuum_reference:
        return []
    first = impacts.continuum_reference[0]
    same = [run for run in impacts.continuum if punch(run) == punch(first)]
    return [
        (
            "reference" if name == substance(first) else differences(first, runs[0]),
            distinct(runs, lambda run: run.energy),
        )
        for name, runs in grouped(same, substance).items()
    ]


def masses(impacts: Impacts) -> list[Curve]:
    """Groups that differ from the reference in the mass of the punch alone."""
    if not impacts.continuum_reference:
        return []
    first = impacts.continuum_reference[0]

    def of_any_mass(run: Continuum) -> tuple:
        return (
            dataclasses.replace(run.case.punch, mass=1.0, velocity=1.0),
            run.case.block,
            run.case.run.elements,
            substance(run),
        )

    same = [run for run in impacts.continuum if of_any_mass(run) == of_any_mass(first)]
    groups = grouped(same, lambda run: run.case.punch.mass)
    return [
        (f"m = {mass:.4g} kg", distinct(groups[mass], lambda run: run.energy))
        for mass in sorted(groups)  # type: ignore[type-var]
    ]


def tapers(impacts: Impacts) -> list[tuple[float, Continuum]]:
    """Runs that differ in the taper of the punch alone, and in the size of the elements there: tapers (m) and runs."""

    def of_any_taper(run: Continuum) -> tuple:
        return dataclasses.replace(run.case.punch, taper=0.0), *_block(run)

    groups = grouped(
        [run for run in impacts.continuum if run.case.punch.taper and not isinstance(run.case.run.edge_size, str)],
        of_any_taper,
    )
    largest = max(groups.values(), key=len, default=())
    return [(run.case.punch.taper, run) for run in distinct(largest, lambda run: run.case.punch.taper)]


def scaling(impacts: Impacts) -> Drawing | None:
    """Dissipated fraction against input energy by material, in J and normalised (thesis Fig. 5.10)."""
    return draw_scaling(materials(impacts), CONTINUUM_ENERGY, "linear")


def by_mass(impacts: Impacts) -> Drawing | None:
    """Dissipated fraction and plastic volume against input energy by mass of the punch (thesis Figs. 5.11, 5.12)."""
    curves = masses(impacts)
    if len(curves) < _FEWEST_CURVES:
        return None
    figure = new_figure(2.6, 7.0)
    left, right = figure.subplots(1, 2)
    columns: dict[str, list] = {
        "mass_kg": [], "energy_normalised": [], "dissipated_fraction": [], "volume_over_sphere_volume": [],
        "volume_ever_over_sphere_volume": [],
    }  # fmt: skip
    for n, (name, runs) in enumerate(curves):
        energy = [run.energy_normalised for run in runs]
        left.plot(energy, [run.fraction for run in runs], label=name, **_style(n))
        right.plot(energy, [run.volume() for run in runs], label=name, **_style(n))
        right.plot(energy, [run.volume(ever=True) for run in runs], ":", color=COLOURS[n % len(COLOURS)], linewidth=0.8)
        columns["mass_kg"] += [run.case.punch.mass for run in runs]
        columns["energy_normalised"] += energy
        columns["dissipated_fraction"] += [run.fraction for run in runs]
        columns["volume_over_sphere_volume"] += [run.volume() for run in runs]
        columns["volume_ever_over_sphere_volume"] += [run.volume(ever=True) for run in runs]
    left.set_xscale("log")
    left.set_ylim(bottom=0)
    left.legend()
    left.set_ylabel(FRACTION)
    right.set_xlim(left=0)
    right.set_ylim(bottom=0)
    right.set_ylabel(r"Plastic volume $/(\pi D^3/6)$")
    right.set_title("full: largest at one instant, dotted: that ever yielded", fontsize=7)
    for axes in (left, right):
        axes.set_xlabel(CONTINUUM_ENERGY)
    return Drawing(figure, columns)


@dataclasses.dataclass(frozen=True)
class Deviation:
    """Relative differences from the reference at one normalised energy."""

    name: str
    energy: float
    fraction: float
    volume: float


def collapse(impacts: Impacts) -> list[Deviation]:
    """How far the groups of `materials` are from the reference, at each normalised energy that both have.

    With one ratio of yield strength to modulus they are equal to rounding. With another one the punch's rounded edge
    is larger or smaller beside the displacements, which matters where little more than its edge touches.
    """
    return [
        Deviation(name, run.energy_normalised, run.fraction / twin.fraction - 1, run.volume() / twin.volume() - 1)
        for name, runs in materials(impacts)
        for run in runs
        for twin in impacts.continuum_reference
        if name != "reference"
        and abs(run.energy_normalised / twin.energy_normalised - 1) < SAME
        and twin.fraction
        and twin.volume()
    ]


def _block(run: Continuum) -> tuple:
    return run.case.block, run.case.run.elements, substance(run)


def _style(n: int) -> dict:
    return {
        "color": COLOURS[n % len(COLOURS)],
        "marker": MARKERS[n % len(MARKERS)],
        "markerfacecolor": "none",
        "markersize": 5 if n else 3,
        "linewidth": 0.8 if n == 0 else 0.5,
    }
