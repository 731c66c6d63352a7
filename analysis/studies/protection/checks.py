"""Closed forms beside runs of the simplest packing, a single elastic sphere, on every kind of target."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from granwave.analysis.measures.hertz_impact import HertzImpact, after_impulse
from granwave.analysis.measures.target import period_of
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
_SHORT = 20.0  # periods in contact times from which on an impact is short
_SLOW = 0.2  # and up to which it is slow
_SLIGHT = 0.005  # of the sphere's momentum over that of a target in the same time: it hardly gives way


def select(runs: Sequence[FinishedRun]) -> list[list[TargetRun]]:
    """Elastic spheres that hit a target with no packing between, for each impact."""
    found = ([run for run in group if _alone(run)] for group in impacts(runs))
    return [alone for alone in found if alone and rows(alone)]


def title(runs: Sequence[TargetRun]) -> str:
    """By sphere and impact."""
    return f"Protected target, closed forms: {impact_title(runs[0].case)}"


def rows(runs: Sequence[TargetRun]) -> list[Row]:
    """Checks of each bottom against its closed form."""
    return [
        row for run, name in zip(runs, names(runs), strict=True) for row in _rows(run, name, HertzImpact.of(run.case))
    ]


def _alone(run: TargetRun) -> bool:
    case = run.case
    return run.assembly.lattice.n_spheres == 1 and case.contact.law == "hertz" and case.load.kind == "impact"


def _rows(run: TargetRun, name: str, theory: HertzImpact) -> Iterator[Row]:
    if not run.moves:
        yield _row(f"Peak force, {name}", "N", run.reached.peak_force, theory.force, "Hertz (1882)")
        yield _row(f"Impulse, {name}", "mN s", _MILLI * run.reached.impulse[-1], _MILLI * theory.impulse, "2 m v")
    elif run.plate:
        yield from _of_plate(run, name, theory)
    else:
        yield from _of_impedance(run, name, theory)


def _of_plate(run: TargetRun, name: str, theory: HertzImpact) -> Iterator[Row]:
    plate = run.plate
    if plate is None or plate.damping:
        return
    period, moved, what = period_of(plate), float(run.displacement.max()), f"Largest displacement, {name}"
    if period > _SHORT * theory.duration:
        impulse = theory.impulse * plate.mass / (plate.mass + theory.mass)
        expected = after_impulse(impulse, plate.mass, plate.stiffness)
        yield _row(what, "µm", _MICRO * moved, _MICRO * expected, "impulse 2 v m M/(m + M), then J/(M omega)")
    elif period < _SLOW * theory.duration:
        force = theory.on_spring(plate.stiffness)
        yield _row(what, "µm", _MICRO * moved, _MICRO * force / plate.stiffness, "a spring without mass: F/k")


def _of_impedance(run: TargetRun, name: str, theory: HertzImpact) -> Iterator[Row]:
    """A bar without an echo, or a half-space: the force is that on a rigid wall as long as it hardly gives way."""
    support, material = run.case.boundary.bottom_support, run.case.boundary.bottom_material
    assert support is not None and material is not None
    if support.half_space and (radius := support.half_space.radius) is not None:
        spring, damping = support.half_space.stiffness(material, radius), support.half_space.damping(material, radius)
    elif support.bar and support.bar.end == "infinite":
        spring, damping = 0.0, support.bar.area * math.sqrt(material.youngs_modulus * material.density)
    else:
        return
    if theory.mass > _SLIGHT * (damping + spring * theory.duration) * theory.duration:
        return
    energy = theory.energy_into(spring, damping)
    how = "spring and damper under Hertz's force" if spring else "Hertz's force, squared and summed over Z"
    yield _row(f"Energy at the target, {name}", "mJ", _MILLI * run.value("energy_target_J"), _MILLI * energy, how)


def _row(quantity: str, unit: str, ours: float, expected: float, theory: str) -> Row:
    return Row(quantity, unit, None, float(ours), theory, expected=expected)
