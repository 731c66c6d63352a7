"""Error bars of a contact law for the peak force and the restitution of a run."""

from __future__ import annotations

import math

import numpy as np

from granwave._contact_laws import ContactLaw
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.contact.law import flat_contact, pair_contact

_PEAK = ("contacts/i", "contacts/j", "contacts/peak_force", "contacts/peak_overlap")


def law_errors(result: Result, *, rebounds: bool) -> dict[str, float | None]:
    """Return the error bars of the peak force and of the coefficient of restitution.

    Parameters
    ----------
    rebounds
        True if the run is a single collision with a coefficient of restitution.

    Returns
    -------
    dict
        ``peak_force_error_N`` and ``restitution_error``; None where the law states none.
    """
    contact = result.case.contact
    bars: dict[str, float | None] = {"peak_force_error_N": None, "restitution_error": None}
    if not contact.entry.states_error or contact.cohesion is not None:
        return bars
    pair = _largest_pair(result)
    if pair is not None:
        law, overlap = pair
        bars["peak_force_error_N"] = _stated(float(law.force_error(overlap, overlap)))
    if rebounds and contact.loss is None:
        collision = pair if result.n_spheres > 1 else _largest_at_wall(result)
        if collision is not None:
            law, overlap = collision
            bars["restitution_error"] = _stated(float(law.restitution_error(overlap)))
    return bars


def _stated(bar: float) -> float | None:
    return bar if math.isfinite(bar) else None


def _largest_pair(result: Result) -> tuple[ContactLaw, float] | None:
    """Return the law of the pair of grains with the largest force, and its largest overlap, m."""
    largest = 0.0
    pair: tuple[int, int, float] | None = None
    for first, second, force, overlap in result.blocks(*_PEAK):
        row = int(np.argmax(force)) if len(force) else -1
        if row >= 0 and force[row] > largest:
            largest = float(force[row])
            pair = (int(first[row]), int(second[row]), float(overlap[row]))
    if pair is None:
        return None
    return pair_contact(result.assembly, pair[0], pair[1]), pair[2]


def _largest_at_wall(result: Result) -> tuple[ContactLaw, float] | None:
    """Return the law of a single sphere on the rigid wall, and its largest overlap, m."""
    overlap = result["wall_contacts/peak_overlap"]
    if not len(overlap):
        return None
    sphere = int(result["wall_contacts/id"][int(np.argmax(overlap))])
    return flat_contact(result.assembly, sphere), float(overlap.max())
