"""Granular impacts against each other: scaling collapse, dissipation against velocity, loading area (thesis 5.3.1)."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.figures.style import BLUE, ORANGE, Drawing, new_figure
from granwave.analysis.studies.granular_continuum.impacts import (
    SAME,
    Granular,
    Impacts,
    differences,
    distinct,
    grouped,
    substance,
)
from granwave.analysis.studies.granular_continuum.scaling import (
    FRACTION,
    GRANULAR_ENERGY,
    draw_scaling,
    reference_and_marks,
)

SOURCE_FIT = (9.45e3, -3.04e3, 5.00e3)  # D0, D1, D2 as thesis 5.17 prints them
SOURCE_FIT_RIGHT = (9.45, -3.04, 0.500)  # in units in which the input is v0^2/2, as the thesis has it
_FEWEST_FITTED = 5
_FEWEST_CURVES = 2

Curve = tuple[str, tuple[Granular, ...]]


def variants(impacts: Impacts) -> list[Curve]:
    """The reference and the groups that differ from it in material or diameter, one sphere struck; with their names."""
    if not impacts.reference:
        return []
    single = [run for run in impacts.like_reference if run.case.load.spheres == 1]
    first = impacts.reference[0]
    curves: list[Curve] = [("reference", impacts.reference)]
    for name, runs in grouped(single, substance).items():
        if name != substance(first):
            curves.append((differences(first, runs[0]), distinct(runs, lambda run: run.energy)))
    return curves


def scaling(impacts: Impacts) -> Drawing | None:
    """Dissipated fraction against input energy, in J and normalised (thesis Fig. 5.5)."""
    return draw_scaling(variants(impacts), GRANULAR_ENERGY, "log")


@dataclasses.dataclass(frozen=True)
class Deviation:
    """How far a group is from the reference at equal normalised velocities; ``n`` is how many there were."""

    name: str
    n: int
    largest: float


def collapse(impacts: Impacts) -> list[Deviation]:
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
            found.append(Deviation(name, len(gaps), max(gaps)))
    return found


@dataclasses.dataclass(frozen=True, eq=False)
class QuadraticFit:
    """``e_dis = D0 + D1 v0 + D2 v0^2`` (thesis 5.17) in units in which the input is ``v0^2/2``; v0 is normalised.

    Attributes
    ----------
    constants, deviations
        D0, D1, D2 and their standard deviations: (3,).
    misfit
        Largest |fit / e_dis - 1| of the fitted runs.
    lowest
        Normalised velocity from which on runs were fitted.
    """

    constants: NDArray[np.float64]
    deviations: NDArray[np.float64]
    misfit: float
    lowest: float

    def __call__(self, velocity: NDArray[np.float64]) -> NDArray[np.float64]:
        """Dissipation at normalised velocities."""
        return np.asarray(np.polynomial.polynomial.polyval(velocity, self.constants), dtype=np.float64)


def quadratic_fit(impacts: Impacts) -> QuadraticFit | None:
    """Fit to the reference, every run with the same relative weight, from a tenth of its largest velocity on.

    Below that the peak forces of too many contacts are near F_y, where dissipation is not quadratic in force.
    """
    runs = impacts.reference
    fitted = [run for run in runs if run.velocity_normalised >= 0.1 * runs[-1].velocity_normalised * (1 - SAME)]
    if len(fitted) < _FEWEST_FITTED:
        return None
    v = np.array([run.velocity_normalised for run in fitted])
    lost = np.array([_dissipation(run) for run in fitted])
    matrix = np.stack([np.ones_like(v), v, v**2], axis=1) / lost[:, None]
    constants, *_ = np.linalg.lstsq(matrix, np.ones_like(v))
    residual = matrix @ constants - 1
    scatter = residual @ residual / (len(v) - len(constants))
    deviations = np.sqrt(scatter * np.diag(np.linalg.inv(matrix.T @ matrix)))
    return QuadraticFit(constants, deviations, float(np.abs(residual).max()), float(v.min()))


def dissipation_against_velocity(impacts: Impacts) -> Drawing | None:
    """Dissipation and its fraction of the input, with the quadratic law (thesis Fig. 5.6)."""
    fit, runs = quadratic_fit(impacts), impacts.reference
    if fit is None:
        return None
    v = np.array([run.velocity_normalised for run in runs])
    lost = np.array([_dissipation(run) for run in runs])
    fine = np.geomspace(fit.lowest, v[-1], 200)
    figure = new_figure(2.6, 7.0)
    left, right = figure.subplots(1, 2)
    left.plot(fine, fit(fine), color=ORANGE, label="quadratic law")
    positive = lost > 0
    left.plot(v[positive], lost[positive], "o", color=BLUE, markersize=4, label="simulation")
    left.set_xscale("log")
    left.set_yscale("log")
    left.set_xlabel(r"Impact velocity $\bar v_0$")
    left.set_ylabel(r"Dissipation $\bar e_\mathrm{dis}$, in units in which $\bar e_\mathrm{in} = \bar v_0^2/2$")
    left.yaxis.label.set_fontsize(7)
    left.legend()
    right.plot(_input(fine), fit(fine) / _input(fine), color=ORANGE)
    right.plot(_input(v), lost / _input(v), "o", color=BLUE, markersize=4)
    right.set_xscale("log")
    right.set_ylim(0, 1)
    right.set_xlabel(r"Input energy $\bar e_\mathrm{in} = \bar v_0^2/2$")
    right.set_ylabel(FRACTION)
    columns = {"velocity_normalised": v, "dissipation_normalised": lost, "dissipated_fraction": lost / _input(v)}
    inside = v >= fit.lowest * (1 - SAME)
    return Drawing(figure, columns | {"quadratic_law": np.where(inside, fit(v), np.nan)})


def loading_area(impacts: Impacts) -> Drawing | None:
    """Dissipated fraction against input energy for 1, 3 and 7 struck spheres (thesis Fig. 5.7)."""
    curves = by_area(impacts)
    if len(curves) < _FEWEST_CURVES:
        return None
    figure = new_figure(2.6)
    axes = figure.subplots()
    columns: dict[str, list] = {"struck_spheres": [], "energy_normalised": [], "dissipated_fraction": []}
    for n, (spheres, runs) in enumerate(curves.items()):
        energy, fraction = [run.energy_normalised for run in runs], [run.fraction for run in runs]
        axes.plot(energy, fraction, label=f"W = {spheres}", **reference_and_marks(n))
        columns["struck_spheres"] += [spheres] * len(runs)
        columns["energy_normalised"] += energy
        columns["dissipated_fraction"] += fraction
    axes.set_xscale("log")
    axes.set_ylim(0, 1)
    axes.set_xlabel(GRANULAR_ENERGY)
    axes.set_ylabel(FRACTION)
    axes.legend()
    return Drawing(figure, columns)


def by_area(impacts: Impacts) -> dict[int, tuple[Granular, ...]]:
    """Runs of the reference material by the number of struck spheres, in rising order of energy."""
    if not impacts.reference:
        return {}
    same = [run for run in impacts.like_reference if substance(run) == substance(impacts.reference[0])]
    counts = sorted({int(run.case.load.spheres) for run in same})
    return {w: distinct([run for run in same if run.case.load.spheres == w], lambda run: run.energy) for w in counts}


def area_table(impacts: Impacts) -> list[tuple[float, dict[int, float]]]:
    """Input energies (normalised) at which several numbers of spheres were struck, with the dissipated fractions."""
    rows = []
    curves = by_area(impacts)
    for run in curves.get(1, ()):
        found = {1: run.fraction}
        for spheres, others in curves.items():
            equal = [other for other in others if abs(other.energy / run.energy - 1) < SAME]
            if equal:
                found[spheres] = equal[0].fraction
        if len(found) > 1:
            rows.append((run.energy_normalised, found))
    return rows


def _input(velocity: NDArray[np.float64]) -> NDArray[np.float64]:
    return 0.5 * velocity**2


def _dissipation(run: Granular) -> float:
    """In units in which the input is v0^2/2."""
    return run.fraction * 0.5 * run.velocity_normalised**2
