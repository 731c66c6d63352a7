"""Advice on contacts of grains at user-defined positions: the effect of each value of
``packing.contacts`` on the packing.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from granwave.lammps_inputs.case.case import Case, WrongTable
from granwave.lammps_inputs.case.packing.contact_ways import (
    DAMPED,
    KEEP,
    KEY,
    OVERLAPS,
    RELAX,
    RELAXATION,
    TOLERANCE,
    TOUCH,
)
from granwave.lammps_inputs.case.packing.grains import Grains
from granwave.lammps_inputs.contact.law import law_between
from granwave.lammps_inputs.packing.touching import (
    GrainGaps,
    Period,
    fit_touching,
    gaps_up_to,
    rounding_of,
    tolerance_of,
)
from granwave.lammps_inputs.packing_kind import TOUCHING
from granwave.lammps_inputs.readers.columns import CLUMP

# pairs with the largest forces, by overlap and radius, for which laws are evaluated
_MOST_LAWS = 100
_DEEP = 0.2  # overlap divided by the diameter that is too large for a contact


@dataclasses.dataclass(frozen=True)
class ContactAdvice:
    """Contacts of grains as they were found.

    Attributes
    ----------
    last_place
        Unit of the last place of the numbers of the file, m.
    tolerance
        Touch tolerance, m.
    n_within
        Number of pairs that touch within it.
    n_beyond
        Number of pairs that overlap by more.
    n_overlapping
        Number of pairs that overlap by more than 1e-6 of the nominal diameter.
    largest_overlap
        Largest overlap, m.
    moved
        Largest displacement of a grain by which these pairs would just touch, m.
    remaining
        Largest gap or overlap that would be left of them, m.
    largest_force
        Largest contact force of the original grains, N; None if the law is unknown.
    has_friction
        True if the contacts of the case have friction, which only a damped search keeps.
    has_springs
        True if the case has their tangential springs.
    relative_overlap
        Largest overlap / diameter of the smaller grain of the pair.
    """

    last_place: float
    tolerance: float
    n_within: int
    n_beyond: int
    n_overlapping: int
    largest_overlap: float
    moved: float
    remaining: float
    largest_force: float | None
    has_friction: bool = False
    has_springs: bool = False
    relative_overlap: float = 0.0

    @property
    def choices(self) -> list[str]:
        """Phrase on the effect of each way."""
        pressed = "" if self.largest_force is None else f", with up to {self.largest_force:.3g} N"
        nearby = (
            f'"{OVERLAPS.name}" presses the grains{pressed}, and lets them move to an '
            "equilibrium nearby"
        )
        anywhere = f'"{RELAX.name}" finds an equilibrium at any distance'
        kept = f'"{KEEP.name}" starts from the file, out of equilibrium'
        if self.has_friction:
            nearby += ", without friction"
            anywhere += f' ({RELAXATION} = "{DAMPED}" keeps the friction)'
        if self.has_friction and not self.has_springs:
            kept += ", as the file lacks the tangential springs"
        return [self._touching, nearby, anywhere, kept]

    @property
    def _touching(self) -> str:
        """Return a phrase on the effect of moving grains until they touch."""
        pairs = "1 pair overlaps" if self.n_beyond == 1 else f"{self.n_beyond} pairs overlap"
        beyond = f"; {pairs} by more, which it rejects" if self.n_beyond else ""
        if not self.n_within and self.n_beyond:
            return (
                f'"{TOUCH.name}" moves no grain, because no pair is within {self.tolerance:.2g} m '
                f"(packing.{TOLERANCE}){beyond}"
            )
        left = f", to {self.remaining:.2g} m" if self.remaining > self.tolerance / 2 else ""
        moved = f"moves grains by up to {self.moved:.2g} m until the {self.n_within} pairs within "
        return f'"{TOUCH.name}" {moved}{self.tolerance:.2g} m just touch{left}{beyond}'

    @property
    def remedy(self) -> str:
        """Remedy for overlaps in two sentences, for a message; without a full stop."""
        advice = f"move them apart, or choose {KEY}"
        if self.relative_overlap >= _DEEP:
            percent = 100 * self.relative_overlap
            return (
                f"{advice}. An overlap of {percent:.0f} % of a diameter is more than a contact: "
                f"number the spheres of one body in a column {CLUMP}, or check that sizes have the "
                "unit of positions and that diameters are not read as radii"
            )
        pressed = f'"{OVERLAPS.name}" presses the grains'
        if self.largest_force is not None:
            pressed += f", with up to {self.largest_force:.3g} N"
        if self.has_friction:
            pressed += " and without friction"
        return (
            f'{advice}: {self._touching_in_short}. {pressed}; "{RELAX.name}" finds an equilibrium '
            f'at any distance; "{KEEP.name}" starts out of equilibrium'
        )

    @property
    def _touching_in_short(self) -> str:
        """Return a phrase on the effect of moving grains until they touch, for a message."""
        name = f'"{TOUCH.name}"'
        if not self.n_within and self.n_beyond:
            return f"{name} accepts overlaps of up to {self.tolerance:.2g} m"
        moved = f"{name} moves grains by up to {self.moved:.2g} m until they touch"
        if not self.n_beyond:
            return moved
        pairs = "1 pair" if self.n_beyond == 1 else f"{self.n_beyond} pairs"
        return f"{moved}, but rejects {pairs} with overlaps above {self.tolerance:.2g} m"


def advice_on(case: Case, grains: Grains, period: Period = None) -> ContactAdvice:
    """Return the effect of each value of ``packing.contacts`` on grains.

    Parameters
    ----------
    grains
        The grains as they were found.
    period
        Periods along x and y, m.
    """
    packing = case.packing
    tolerance = packing.touch_tolerance or tolerance_of(grains, packing.diameter)
    gaps = gaps_up_to(grains, tolerance, period)
    overlapping = gaps.overlapping(TOUCHING * packing.diameter)
    fit = fit_touching(grains, tolerance, period)
    return ContactAdvice(
        rounding_of(grains),
        tolerance,
        fit.n_contacts,
        len(gaps.overlapping(tolerance)),
        len(overlapping),
        overlapping.largest_overlap,
        fit.moved,
        fit.remaining,
        _largest_force(case, grains, overlapping),
        case.contact.friction > 0,
        packing.springs is not None,
        _relative_overlap(grains, overlapping),
    )


def _relative_overlap(grains: Grains, overlapping: GrainGaps) -> float:
    """Return the largest overlap of a pair, divided by the diameter of its smaller grain."""
    if not len(overlapping):
        return 0.0
    smaller = grains.diameter[overlapping.pairs].min(axis=1)
    return float((-overlapping.gap / smaller).max())


def _largest_force(case: Case, grains: Grains, overlapping: GrainGaps) -> float | None:
    """Return the largest force of overlapping pairs, N; None if a table of the case is invalid."""
    if not len(overlapping):
        return 0.0
    radii = grains.diameter[overlapping.pairs] / 2
    shared = radii.prod(axis=1) / radii.sum(axis=1)
    hertzian = np.sqrt(shared) * (-overlapping.gap) ** 1.5
    largest = 0.0
    try:
        for row in np.argsort(-hertzian)[:_MOST_LAWS]:
            first, second = overlapping.pairs[row].tolist()
            bodies = (
                case.named_material(grains.material[first]),
                case.named_material(grains.material[second]),
            )
            law = law_between(
                case.contact_between(*bodies),
                bodies,
                (float(radii[row, 0]), float(radii[row, 1])),
                shapes=(grains.shape[first], grains.shape[second]),
                plane_strain=case.contact.line == "plane-strain",
            )
            largest = max(largest, float(law.loading_force(-overlapping.gap[row])))
    except (WrongTable, KeyError, ValueError):
        return None
    return largest
