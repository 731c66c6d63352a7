"""Impacts on packings against each other: scaling, dissipation against velocity, loading area."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.document.cells import percent, show, spread_cell
from granwave.analysis.document.model import Column, Note, Table
from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import BLUE, ORANGE, Drawing
from granwave.analysis.measures.impact import QuadraticLaw, quadratic_law
from granwave.analysis.studies.packing_and_block.curves import (
    FRACTION,
    GRANULAR_ENERGY,
    add,
    draw_scaling,
    reference_and_marks,
)
from granwave.analysis.studies.packing_and_block.impacts import (
    SAME,
    Curve,
    Granular,
    Impacts,
    rising,
    substances,
)
from granwave.analysis.studies.study import Sketch
from granwave.analysis.studies.tables import numeric, table_of

_SCALING = (
    "Granular: diameter, density, modulus and yield strength. Where similarity holds, all points lie on the curve of "
    "the reference on the normalised axis"
)
_VELOCITY = (
    "Granular: dissipation against velocity. The curve is the quadratic law, fitted to the fast impacts; the fraction "
    "tends to 1"
)
_AREA = (
    "Granular: number of struck spheres. Points beside the curve of one sphere tell that the loading area matters at "
    "equal input"
)
_FEWEST_FITTED = 5
_FIT_REMARK = (
    "Fast impacts lose nearly all that they bring, so that D2 is 0.5; a constant whose standard deviation is as large "
    "as itself is undetermined."
)


def variants(impacts: Impacts) -> list[Curve[Granular]]:
    """The reference and the groups that differ from it in material or diameter, one sphere struck; with their names."""
    return substances([run for run in impacts.like_reference if run.case.load.spheres == 1], impacts.reference)


class Difference(NamedTuple):
    """Distance of a group from the reference at equal normalised velocities; ``n`` is how many there were."""

    name: str
    n: int
    largest: float


def collapse(impacts: Impacts) -> list[Difference]:
    """Largest difference in dissipated fraction from the reference, of each group with a normalised velocity of it."""
    found = []
    for name, runs in variants(impacts)[1:]:
        gaps = [
            abs(run.fraction - twin.fraction)
            for run in runs
            for twin in impacts.reference
            if abs(run.velocity_normalised / twin.velocity_normalised - 1) < SAME
        ]
        if gaps:
            found.append(Difference(name, len(gaps), max(gaps)))
    return found


def quadratic_fit(impacts: Impacts) -> QuadraticLaw | None:
    """Quadratic law of the fast runs of the reference, in units in which the input is ``v0^2/2``; v0 is normalised."""
    return quadratic_law(*_dissipation(impacts.fast)) if len(impacts.fast) >= _FEWEST_FITTED else None


def by_area(impacts: Impacts) -> dict[int, tuple[Granular, ...]]:
    """Runs of the reference material by the number of struck spheres, in rising order of energy."""
    same = [run for run in impacts.like_reference if run.substance == impacts.reference[0].substance]
    counts = sorted({int(run.case.load.spheres) for run in same})
    return {w: rising([run for run in same if run.case.load.spheres == w], lambda run: run.energy) for w in counts}


def area_table(curves: Mapping[int, Sequence[Granular]]) -> list[tuple[float, dict[int, float]]]:
    """Input energies (normalised) at which several numbers of spheres were struck, with the dissipated fractions."""
    rows = []
    for run in curves.get(1, ()):
        found = {
            spheres: equal[0].fraction
            for spheres, others in curves.items()
            if (equal := [other for other in others if abs(other.energy / run.energy - 1) < SAME])
        }
        if len(found) > 1:
            rows.append((run.energy_normalised, found))
    return rows


def pictures(impacts: Impacts) -> Iterator[Sketch]:
    """Scaling, velocity and loading area, as far as they were varied."""
    if not impacts.reference:
        return
    curves = variants(impacts)
    if len(curves) > 1:
        draw = partial(draw_scaling, curves, GRANULAR_ENERGY, "log")
        yield Sketch("granular_scaling", _SCALING, draw)
    fit = quadratic_fit(impacts)
    if fit is not None:
        draw = partial(_against_velocity, impacts.reference, fit)
        yield Sketch("granular_velocity", _VELOCITY, draw)
    areas = by_area(impacts)
    if len(areas) > 1:
        yield Sketch("loading_area", _AREA, partial(_loading_area, areas))


def tables(impacts: Impacts) -> Iterator[Table | Note]:
    """Quadratic law, collapse of the scaling, and loading area."""
    if not impacts.reference:
        return
    if fit := quadratic_fit(impacts):
        yield from _quadratic_law(fit)
    if found := collapse(impacts):
        numbers = numeric("Points", "Largest difference in dissipated fraction")
        columns = (Column("Differs from the reference in", key=True), *numbers)
        yield table_of("Granular scaling: at equal normalised velocity", columns, found)
    if areas := area_table(by_area(impacts)):
        yield _areas(areas)


def _quadratic_law(fit: QuadraticLaw) -> Iterator[Table | Note]:
    ours = map(spread_cell, fit.constants.tolist(), fit.deviations.tolist())
    caption = "Quadratic law of dissipation: D0 + D1 v0 + D2 v0² where the input is v0²/2"
    columns = (Column("Constant", key=True), *numeric("Value, with its standard deviation"))
    yield table_of(caption, columns, zip(("D0", "D1", "D2"), ours, strict=True), by_row=True)
    yield Note(
        f"Fitted from a normalised velocity of {show(fit.lowest)} on, with equal relative weights; the largest misfit "
        f"there is {percent(100 * fit.misfit).lstrip('+')}. {_FIT_REMARK}"
    )


def _areas(found: Sequence[tuple[float, dict[int, float]]]) -> Table:
    spheres = sorted({count for _, fractions in found for count in fractions})
    numbers = numeric(*(f"Fraction, W = {count}" for count in spheres), "Largest difference")
    rows = [
        (energy, *map(fractions.get, spheres), max(fractions.values()) - min(fractions.values()))
        for energy, fractions in found
    ]
    columns = (*numeric("Input over F_y alpha_y", key=True), *numbers)
    return table_of("Loading area: dissipated fraction at equal input energy", columns, rows)


def _against_velocity(runs: Sequence[Granular], fit: QuadraticLaw) -> Drawing:
    """Dissipation and its fraction of the input, with the quadratic law."""
    v, lost = _dissipation(runs)
    fine = np.geomspace(fit.lowest, v[-1], 200)
    figure, left, right = panels(2.6, 2)
    left.plot(fine, fit(fine), color=ORANGE, label="quadratic law")
    positive = lost > 0
    left.plot(v[positive], lost[positive], "o", color=BLUE, markersize=4, label="simulation")
    dissipation = r"Dissipation $\bar e_\mathrm{dis}$, in units in which $\bar e_\mathrm{in} = \bar v_0^2/2$"
    label(left, r"Impact velocity $\bar v_0$", dissipation, log="xy")
    left.yaxis.label.set_fontsize(7)
    left.legend()
    right.plot(_input(fine), fit(fine) / _input(fine), color=ORANGE)
    right.plot(_input(v), lost / _input(v), "o", color=BLUE, markersize=4)
    label(right, r"Input energy $\bar e_\mathrm{in} = \bar v_0^2/2$", FRACTION, log="x", ylim=(0, 1))
    columns = {"velocity_normalised": v, "dissipation_normalised": lost, "dissipated_fraction": lost / _input(v)}
    inside = v >= fit.lowest * (1 - SAME)
    return Drawing(figure, columns | {"quadratic_law": np.where(inside, fit(v), np.nan)})


def _loading_area(curves: Mapping[int, Sequence[Granular]]) -> Drawing:
    """Dissipated fraction against input energy for 1, 3 and 7 struck spheres."""
    figure, axes = panels(2.6)
    columns: dict[str, list] = {"struck_spheres": [], "energy_normalised": [], "dissipated_fraction": []}
    for n, (spheres, runs) in enumerate(curves.items()):
        energy, fraction = [run.energy_normalised for run in runs], [run.fraction for run in runs]
        axes.plot(energy, fraction, label=f"W = {spheres}", **reference_and_marks(n))
        add(columns, [spheres] * len(runs), energy, fraction)
    label(axes, GRANULAR_ENERGY, FRACTION, log="x", ylim=(0, 1))
    axes.legend()
    return Drawing(figure, columns)


def _input(velocity: NDArray[np.float64]) -> NDArray[np.float64]:
    return 0.5 * velocity**2


def _dissipation(runs: Sequence[Granular]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Normalised velocities, and dissipation in units in which the input is v0^2/2."""
    velocity = np.array([run.velocity_normalised for run in runs])
    return velocity, np.array([run.fraction for run in runs]) * _input(velocity)
