"""Contacts of grains at user-defined positions, by ``packing.contacts``: grains that move until
they touch, and overlaps that press.
"""

from __future__ import annotations

import dataclasses
from typing import Any

from granwave.lammps_inputs.case.boundary import Boundary
from granwave.lammps_inputs.case.packing.contact_ways import (
    DAMPED,
    KEEP,
    KEY,
    OVERLAPS,
    RELAX,
    RELAXATION,
    SPRINGS,
    TOLERANCE,
    TOUCH,
)
from granwave.lammps_inputs.case.packing.grains import Grains
from granwave.lammps_inputs.case.packing.packing import PackingSection
from granwave.lammps_inputs.case.precompression import PRECOMPRESSION, Overlaps, Precompression
from granwave.lammps_inputs.case.schema import ErrorList, show
from granwave.lammps_inputs.errors import Mismatch
from granwave.lammps_inputs.packing.touching import (
    Period,
    fit_touching,
    gaps_up_to,
    rounding_of,
    tolerance_of,
)
from granwave.lammps_inputs.packing_kind import TOUCHING

# diameters: tolerance below which overlaps are attributed to the digits of a file
_EXPLAINED = 1e-4
_LARGEST_TOLERANCE = 0.1  # smallest diameters


def period_of(packing: PackingSection, boundary: Boundary | None) -> Period:
    """Return the periods along x and y of grains, m; None if they do not repeat."""
    periodic = boundary is not None and boundary.periodic
    return packing.period if periodic else None


def with_contacts(parts: dict[str, Any], errors: ErrorList) -> None:
    """Set grains and static load of a case according to its ``packing.contacts``.

    Parameters
    ----------
    parts
        Fields of a case, as `granwave.lammps_inputs.case.parse.parse_case` returns them.
    """
    packing: PackingSection | None = parts.get("packing")
    if packing is None or packing.grains is None:
        return
    stage: Precompression | None = parts.get(PRECOMPRESSION)
    period = period_of(packing, parts.get("boundary"))
    if packing.contact_way is None:
        packing = _with_usual_way(packing, stage, period, errors)
    way = packing.contact_way
    relaxes = way is not None and way.rearranges
    errors.check(
        (
            packing.relaxation is not None and not relaxes,
            f"packing.{RELAXATION}",
            f'applies only to {KEY} = "{RELAX.name}"; found {show(packing.contacts or "none")}',
        ),
        (
            packing.springs is not None and not (way is KEEP or packing.relaxation == DAMPED),
            f"packing.{SPRINGS}",
            f'applies only to {KEY} = "{KEEP.name}" or packing.relaxation = "{DAMPED}"; found '
            f"{show(packing.contacts or 'none')}",
        ),
    )
    if way is None or not _tolerance_fits(packing, errors):
        return
    if way.moves_grains:
        packing = _touching(packing, period, errors)
    parts["packing"] = packing
    if way.presses and packing.grains is not None:
        overlapping = gaps_up_to(packing.grains, 0.0, period).overlapping(_slack(packing))
        overlaps = len(overlapping) > 0 or packing.restart is not None
        parts[PRECOMPRESSION] = _pressed(stage, overlaps=overlaps)


def _slack(packing: PackingSection) -> float:
    """Return the largest gap or overlap at which grains count as just touching, m."""
    return TOUCHING * packing.diameter


def _with_usual_way(
    packing: PackingSection, stage: Precompression | None, period: Period, errors: ErrorList
) -> PackingSection:
    """Complete ``packing.contacts`` from the tolerance, the static load, or the digits of the
    file.
    """
    grains = packing.grains
    touching = dataclasses.replace(packing, contacts=TOUCH.name)
    if packing.touch_tolerance is not None:
        return touching
    if stage is not None and stage.takes_overlaps:
        return dataclasses.replace(packing, contacts=OVERLAPS.name)
    if grains is None or packing.cell is not None:
        return packing
    tolerance = tolerance_of(grains, packing.diameter)
    if tolerance > _EXPLAINED * packing.diameter:
        return packing
    overlapping = gaps_up_to(grains, 0.0, period).overlapping(_slack(packing))
    if not len(overlapping) or overlapping.largest_overlap > tolerance:
        return packing
    errors.notes.append(_note(grains, len(overlapping), overlapping.largest_overlap, tolerance))
    return touching


def _note(grains: Grains, n_overlapping: int, largest: float, tolerance: float) -> str:
    pairs = "a pair overlaps" if n_overlapping == 1 else f"{n_overlapping} pairs overlap"
    return (
        f"{grains.key(1)}: {pairs} by up to {largest:.3g} m, which rounding of the numbers "
        f"explains (the last digit is {rounding_of(grains):.3g} m): grains move until the pairs "
        f'within {tolerance:.3g} m just touch; {KEY} = "{TOUCH.name}" does this without a message'
    )


def _tolerance_fits(packing: PackingSection, errors: ErrorList) -> bool:
    """Check that a touch tolerance is small compared with the grains; return True if it is."""
    assert packing.grains is not None
    most = _LARGEST_TOLERANCE * float(packing.grains.diameter.min())
    tolerance = packing.touch_tolerance or 0.0
    found = Mismatch(
        f"{tolerance:g} m", f"at most {most:g} m, {_LARGEST_TOLERANCE:g} of the smallest diameter"
    )
    return errors.check_first((tolerance > most, f"packing.{TOLERANCE}", found))


def _touching(packing: PackingSection, period: Period, errors: ErrorList) -> PackingSection:
    """Return a packing whose grains have moved until the pairs within the tolerance just touch."""
    grains = packing.grains
    assert grains is not None
    tolerance = packing.touch_tolerance or tolerance_of(grains, packing.diameter)
    fit = fit_touching(grains, tolerance, period)
    if fit.remaining > _slack(packing):
        errors.add(
            KEY,
            Mismatch(
                f'"{TOUCH.name}" with {fit.n_contacts} pairs within {tolerance:.3g} m, which '
                "cannot all touch: the best positions leave gaps or overlaps of up to "
                f"{fit.remaining:.3g} m",
                remedy=f"use a smaller packing.{TOLERANCE}, more digits, or another treatment",
            ),
        )
        return packing
    moved = grains
    if fit.moved:
        moved = dataclasses.replace(grains, position=fit.position, found=grains)
    return dataclasses.replace(packing, grains=moved, touch_tolerance=tolerance)


def _pressed(stage: Precompression | None, *, overlaps: bool) -> Precompression | None:
    """Return the static load with the overlaps of grains, if there are any."""
    if stage is None:
        return Precompression(kind=Overlaps.name) if overlaps else None
    return stage if stage.takes_overlaps else dataclasses.replace(stage, overlaps=True)
