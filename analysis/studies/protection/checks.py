"""Closed forms compared with runs of a single elastic sphere on all kinds of targets.

A single sphere is the simplest packing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain

from granwave.analysis.measures.target_theory import HertzImpact, after_impulse
from granwave.analysis.studies.protection.runs import TargetRun, impacts, names
from granwave.analysis.studies.runs import FinishedRun, impact_title
from granwave.analysis.studies.study import Row
from granwave.lammps_inputs.case.boundary import Boundary, Plate

TEXT = (
    "A single elastic sphere hits each bottom. The theory values are Hertz's impact on a rigid "
    "wall, a plate after a short impulse, a plate on a spring so stiff that it follows the "
    "force, and the energy that an impedance absorbs if the force is nearly unchanged."
)
NEEDS = 'impacts of a single sphere with `contact.law = "hertz"` on a target'
_MICRO = 1e6
_MILLI = 1e3
_SHORT = 20.0  # period of a plate / contact time above which an impact is short
_SLOW = 0.2  # period of a plate / contact time below which an impact is slow
_SLIGHT = 0.005  # momentum of the sphere over the momentum of a nearly rigid impedance


def select(runs: Sequence[FinishedRun]) -> list[list[TargetRun]]:
    """Elastic spheres that hit a target without a packing, for each impact."""
    elastic = [
        run for run in runs if run.case.contact.law == "hertz" and run.case.load.gives_velocity
    ]
    groups = []
    for impact in impacts(elastic):
        spheres = [run for run in impact if run.assembly.lattice.n_spheres == 1]
        if rows(spheres):
            groups.append(spheres)
    return groups


def title(runs: Sequence[TargetRun]) -> str:
    """Title with sphere and impact."""
    return f"Protected target, closed forms: {impact_title(runs[0].assembly)}"


def rows(runs: Sequence[TargetRun]) -> list[Row]:
    """Checks of each bottom against its closed form."""
    if not runs:
        return []
    return list(chain.from_iterable(map(_rows, runs, names(runs))))


def _rows(run: TargetRun, name: str) -> Iterator[Row]:
    impact = HertzImpact.of(run.case)
    if not run.moves:
        yield _row(
            f"Peak force, {name}", "N", 1.0, run.reached.peak_force, (impact.force, "Hertz (1882)")
        )
        yield _row(
            f"Impulse, {name}", "mN s", _MILLI, run.reached.impulse[-1], (impact.impulse, "2 m v")
        )
    elif run.plate:
        expected = plate_displacement(impact, run.plate)
        if expected:
            largest = run.displacement.max()
            yield _row(f"Largest displacement, {name}", "µm", _MICRO, largest, expected)
    else:
        expected = energy_into_impedance(impact, run.case.boundary)
        if expected:
            energy = run.value("energy_target_J")
            yield _row(f"Energy at the target, {name}", "mJ", _MILLI, energy, expected)


def _row(
    quantity: str, unit: str, per_unit: float, computed: float, expected: tuple[float, str]
) -> Row:
    value, theory = expected
    return Row(quantity, unit, None, float(per_unit * computed), theory, "", per_unit * value, True)


def plate_displacement(impact: HertzImpact, plate: Plate) -> tuple[float, str] | None:
    """Largest displacement of an undamped plate, m, and its theory; None between the two limits."""
    period = plate.period
    if plate.damping:
        return None
    if period > _SHORT * impact.duration:
        impulse = impact.impulse * plate.mass / (plate.mass + impact.mass)
        displacement = after_impulse(impulse, plate.mass, plate.stiffness)
        return displacement, "impulse 2 v m M/(m + M), then J/(M omega)"
    if period < _SLOW * impact.duration:
        return impact.on_spring(plate.stiffness) / plate.stiffness, "a spring without mass: F/k"
    return None


def energy_into_impedance(impact: HertzImpact, boundary: Boundary) -> tuple[float, str] | None:
    """Energy that a bar without an echo, or a half-space, absorbs, J, and its theory.

    The force is the force on a rigid wall as long as the target hardly moves; None if it moves
    more, and for other targets.
    """
    support = boundary.bottom_support
    material = boundary.bottom_material
    if support is None or material is None:
        return None
    absorber = support.absorber(material)
    if absorber is None:
        return None
    spring, damping = absorber
    if impact.mass > _SLIGHT * (damping + spring * impact.duration) * impact.duration:
        return None
    theory = "Hertz's force, squared and summed over Z"
    if spring:
        theory = "spring and damper under Hertz's force"
    return impact.energy_into(spring, damping), theory
