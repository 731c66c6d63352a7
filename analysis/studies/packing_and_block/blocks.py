"""Impacts on blocks against each other: scaling collapse, mass of the punch, taper of its edge."""

from __future__ import annotations

import dataclasses
from collections.abc import Hashable, Iterator
from functools import partial
from typing import NamedTuple

from granwave.analysis.document.cells import percent
from granwave.analysis.document.model import Cell, Column, Table
from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import Drawing
from granwave.analysis.studies.packing_and_block.curves import (
    CONTINUUM_ENERGY,
    FRACTION,
    add,
    colour_and_marker,
    draw_scaling,
)
from granwave.analysis.studies.packing_and_block.impacts import (
    SAME,
    Continuum,
    Curve,
    Impacts,
    grouped,
    largest,
    rising,
    substances,
)
from granwave.analysis.studies.study import Sketch
from granwave.analysis.studies.tables import numeric, table_of

_SCALING = (
    "Continuum: modulus and yield strength. Where similarity holds, all points lie on one curve on the normalised axis"
)
_MASS = (
    "Continuum: mass of the punch. Curves that differ at equal input tell that the velocity matters beside the energy"
)


def materials(impacts: Impacts) -> list[Curve[Continuum]]:
    """The reference and the groups that differ from it in material alone, with their names."""
    reference = impacts.continuum_reference
    return substances([run for run in impacts.continuum if run.shape == reference[0].shape], reference)


def masses(impacts: Impacts) -> list[Curve[Continuum]]:
    """Groups that differ from the reference in the mass of the punch alone, by rising mass."""

    def but_for_mass(run: Continuum) -> Hashable:
        case = run.case
        return dataclasses.replace(case.punch, mass=1.0, velocity=1.0), case.block, case.run.elements, run.substance

    first = impacts.continuum_reference[0]
    same = sorted(impacts.continuum, key=lambda run: run.case.punch.mass)
    groups = grouped([run for run in same if but_for_mass(run) == but_for_mass(first)], lambda run: run.case.punch.mass)
    return [(f"m = {mass:.4g} kg", rising(runs, lambda run: run.energy)) for mass, runs in groups.items()]


def tapers(impacts: Impacts) -> tuple[Continuum, ...]:
    """Runs that differ in the taper of the punch alone, and in the size of the elements there; by taper."""

    def but_for_taper(run: Continuum) -> Hashable:
        case = run.case
        return dataclasses.replace(case.punch, taper=0.0), case.block, case.run.elements, run.substance

    fine = [run for run in impacts.continuum if run.case.punch.taper and not isinstance(run.case.run.edge_size, str)]
    return rising(largest(fine, but_for_taper), lambda run: run.case.punch.taper)


class Difference(NamedTuple):
    """Relative differences from the reference at one normalised energy."""

    name: str
    energy: float
    fraction: float
    volume: float


def collapse(impacts: Impacts) -> list[Difference]:
    """Differences of the groups of `materials` from the reference, at each normalised energy that both have.

    With one ratio of yield strength to modulus they are equal to rounding. With another one the punch's rounded edge
    is larger or smaller beside the displacements, which matters where little more than its edge touches.
    """
    return [
        Difference(name, run.energy_normalised, run.fraction / twin.fraction - 1, run.volume / twin.volume - 1)
        for name, runs in materials(impacts)[1:]
        for run in runs
        for twin in impacts.continuum_reference
        if abs(run.energy_normalised / twin.energy_normalised - 1) < SAME and twin.fraction and twin.volume
    ]


def pictures(impacts: Impacts) -> Iterator[Sketch]:
    """Scaling and mass of the punch, where more than one substance or mass was run."""
    if not impacts.continuum_reference:
        return
    curves = materials(impacts)
    if len(curves) > 1:
        draw = partial(draw_scaling, curves, CONTINUUM_ENERGY, "linear")
        yield Sketch("continuum_scaling", _SCALING, draw)
    curves = masses(impacts)
    if len(curves) > 1:
        yield Sketch("continuum_mass", _MASS, partial(_by_mass, curves))


def tables(impacts: Impacts) -> Iterator[Table]:
    """Collapse of the scaling, and influence of the taper."""
    if impacts.continuum_reference and (found := collapse(impacts)):
        columns = (
            Column("Differs from the reference in", key=True),
            *numeric("Input over sigma_y^2 D^3/E", key=True),
            *numeric("Difference in fraction", "Difference in volume"),
        )
        rows = [(name, energy, *map(_percent, gaps)) for name, energy, *gaps in found]
        yield table_of("Continuum scaling: at equal normalised energy", columns, rows, sortable=True)
    runs = tapers(impacts)
    if len(runs) > 1:
        numbers = numeric("Dissipated fraction", ("Plastic volume", "mm³"), ("Volume that ever yielded", "mm³"))
        columns = (*numeric(("Taper", "mm"), key=True), *numbers)
        names = "plastic_zone_volume_m3", "plastic_zone_volume_ever_m3"
        rows = [(1e3 * run.case.punch.taper, run.fraction, *(1e9 * run.value(name) for name in names)) for run in runs]
        yield table_of("Continuum: taper of the punch's edge, two elements or more across it", columns, rows)


def _by_mass(curves: list[Curve[Continuum]]) -> Drawing:
    """Dissipated fraction and plastic volume against input energy by mass of the punch."""
    figure, left, right = panels(2.6, 2)
    names = (
        "mass_kg", "energy_normalised", "dissipated_fraction", "volume_over_sphere_volume",
        "volume_ever_over_sphere_volume",
    )  # fmt: skip
    columns: dict[str, list] = {name: [] for name in names}
    for n, (name, runs) in enumerate(curves):
        mass = [run.case.punch.mass for run in runs]
        energy, fraction = [run.energy_normalised for run in runs], [run.fraction for run in runs]
        volume, ever = [run.volume for run in runs], [run.volume_ever for run in runs]
        style = colour_and_marker(n) | {"markerfacecolor": "none", "markersize": 5 if n else 3}
        for axes, values in ((left, fraction), (right, volume)):
            axes.plot(energy, values, label=name, linewidth=0.5 if n else 0.8, **style)
        right.plot(energy, ever, ":", color=style["color"], linewidth=0.8)
        add(columns, mass, energy, fraction, volume, ever)
    label(left, CONTINUUM_ENERGY, FRACTION, log="x", ylim=(0, None))
    left.legend()
    label(right, CONTINUUM_ENERGY, r"Plastic volume $/(\pi D^3/6)$", xlim=(0, None), ylim=(0, None))
    right.set_title("full: largest at one instant, dotted: that ever yielded", fontsize=7)
    return Drawing(figure, columns)


def _percent(share: float) -> Cell:
    return Cell(percent(100 * share), share)
