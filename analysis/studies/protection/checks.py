"""Closed forms beside runs of the simplest packing, a single elastic sphere, on every kind of target."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.measures.target import period_of
from granwave.analysis.studies.protection.runs import TargetRun, names
from granwave.analysis.studies.protection.theory import HertzImpact, after_impulse, response
from granwave.analysis.studies.study import Row, Study
from granwave.analysis.studies.titles import impact_words
from granwave.lammps_inputs.contact.law import flat_contact

_MICRO, _MILLI = 1e6, 1e3
_SHORT = 20.0  # periods in contact times from which on an impact is short
_SLOW = 0.2  # and up to which it is slow
_SLIGHT = 0.005  # of the sphere's momentum over that of a target in the same time: it hardly gives way


def checks(runs: Sequence[TargetRun], suffix: str) -> Iterator[Study]:
    """One study of the elastic spheres that hit a target with no packing between."""
    alone = [
        run
        for run in runs
        if run.assembly.lattice.n_spheres == 1 and run.case.contact.law == "hertz" and run.case.load.kind == "impact"
    ]
    rows = [row for run, name in zip(alone, names(alone) if alone else [], strict=True) for row in _rows(run, name)]
    if rows:
        yield Study(
            f"protected-checks{suffix}",
            f"Protected target, closed forms: {impact_words(alone[0].case)}",
            "A single elastic sphere on each bottom. Theory: Hertz's impact on a rigid wall; a plate after a short "
            "impulse, or on a spring so stiff that it follows the force; what an impedance takes from a force that it "
            "hardly changes.",
            tuple(rows),
        )


def _rows(run: TargetRun, name: str) -> Iterator[Row]:
    theory = hertz(run)
    if not run.moves:
        yield _row(f"Peak force, {name}", "N", run.reached.peak_force, theory.force, "Hertz (1882)")
        yield _row(f"Impulse, {name}", "mN s", _MILLI * run.reached.impulse[-1], _MILLI * theory.impulse, "2 m v")
    elif run.plate:
        yield from _of_plate(run, name, theory)
    else:
        yield from _of_impedance(run, name, theory)


def _of_plate(run: TargetRun, name: str, theory: HertzImpact) -> Iterator[Row]:
    plate = run.plate
    assert plate is not None
    period = period_of(plate)
    moved, what = float(run.displacement.max()), f"Largest displacement, {name}"
    if plate.damping:
        return
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
    if support.half_space:
        radius = support.half_space.radius
        if radius is None:
            return
        spring, damping = support.half_space.stiffness(material, radius), support.half_space.damping(material, radius)
    elif support.bar and support.bar.end == "infinite":
        spring, damping = 0.0, support.bar.area * math.sqrt(material.youngs_modulus * material.density)
    else:
        return
    if theory.mass > _SLIGHT * (damping + spring * theory.duration) * theory.duration:
        return
    time, force = theory.history()
    if spring:
        speed = np.gradient(response(time, force, 0.0, spring, damping), time)
        energy, how = float(np.trapezoid(force * speed, time)), "spring and damper under Hertz's force"
    else:
        energy, how = theory.square / damping, "Hertz's force, squared and summed over Z"
    yield _row(f"Energy at the target, {name}", "mJ", _MILLI * run.value("energy_target_J"), _MILLI * energy, how)


def hertz(run: TargetRun) -> HertzImpact:
    """The impact of the run's sphere on its bottom, held in place."""
    case = run.case
    law = flat_contact(case, 1, case.boundary.bottom_material)
    stiffness = 4 / 3 * law.effective_modulus * math.sqrt(law.effective_radius)
    return HertzImpact(case.sphere_mass, case.load.velocity * math.cos(math.radians(case.load.angle)), stiffness)


def _row(quantity: str, unit: str, ours: float, expected: float, theory: str) -> Row:
    return Row(quantity, unit, None, float(ours), theory, expected=expected)
