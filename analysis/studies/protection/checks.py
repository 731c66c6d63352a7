"""Closed forms beside runs of the simplest packing, a single elastic sphere, on every kind of target."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from granwave.analysis.measures.target.hertz_impact import HertzImpact
from granwave.analysis.measures.target.sphere_on_target import energy_into_impedance, plate_displacement
from granwave.analysis.studies.protection.runs import TargetRun, impacts, names
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Row
from granwave.analysis.studies.titles import impact_title

TEXT = (
    "A single elastic sphere on each bottom. Theory: Hertz's impact on a rigid wall; a plate after a short "
    "impulse, or on a spring so stiff that it follows the force; what an impedance takes from a force that it "
    "hardly changes."
)
_MICRO, _MILLI = 1e6, 1e3


def select(runs: Sequence[FinishedRun]) -> list[list[TargetRun]]:
    """Elastic spheres that hit a target with no packing between, for each impact."""
    found = ([run for run in group if _alone(run)] for group in impacts(runs))
    return [alone for alone in found if alone and rows(alone)]


def title(runs: Sequence[TargetRun]) -> str:
    """By sphere and impact."""
    return f"Protected target, closed forms: {impact_title(runs[0].case)}"


def rows(runs: Sequence[TargetRun]) -> list[Row]:
    """Checks of each bottom against its closed form."""
    return [row for run, name in zip(runs, names(runs), strict=True) for row in _rows(run, name)]


def _alone(run: TargetRun) -> bool:
    case = run.case
    return run.assembly.lattice.n_spheres == 1 and case.contact.law == "hertz" and case.load.kind == "impact"


def _rows(run: TargetRun, name: str) -> Iterator[Row]:
    impact = HertzImpact.of(run.case)
    if not run.moves:
        yield _row(f"Peak force, {name}", "N", 1.0, run.reached.peak_force, (impact.force, "Hertz (1882)"))
        yield _row(f"Impulse, {name}", "mN s", _MILLI, run.reached.impulse[-1], (impact.impulse, "2 m v"))
    elif run.plate:
        if expected := plate_displacement(impact, run.plate):
            yield _row(f"Largest displacement, {name}", "µm", _MICRO, run.displacement.max(), expected)
    elif expected := energy_into_impedance(impact, run.case.boundary):
        yield _row(f"Energy at the target, {name}", "mJ", _MILLI, run.value("energy_target_J"), expected)


def _row(quantity: str, unit: str, per_unit: float, ours: float, expected: tuple[float, str]) -> Row:
    value, theory = expected
    return Row(quantity, unit, None, float(per_unit * ours), theory, "", per_unit * value, True)
