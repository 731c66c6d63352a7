"""Peak forces of spheres above the static force that their contacts carried before the load."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.signals import Array
from granwave.analysis.result.reader import Result

_STATIC = "contacts/initial_force"

BEFORE_END = 1 - 1e-9  # fraction of the run: a force that is largest later may still rise


def has_static_forces(result: Result) -> bool:
    """Return True if contacts carried a static force before the load."""
    return _STATIC in result and bool(np.any(result[_STATIC] > 0))


def dynamic_contact_peaks(
    result: Result,
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], Array, Array]]:
    """Iterate over contacts in blocks: ids i and j, largest rise of the force above its static
    value, N, and time of the largest force, s: (n_contacts,) each.
    """
    names = ["contacts/i", "contacts/j", "contacts/peak_force", "contacts/time_peak"]
    if _STATIC not in result:
        for i, j, peak, when in result.blocks(*names):
            yield i, j, peak, when
        return
    for i, j, peak, when, static in result.blocks(*names, _STATIC):
        yield i, j, peak - static, when


def dynamic_peak_forces(result: Result) -> Array:
    """Return the largest rise of a contact force of each sphere above its static value:
    (n_spheres,), N.

    Without a static load it is the peak force. Contacts with walls are excluded, as in
    ``spheres/peak_force``.
    """
    if not has_static_forces(result):
        return result["spheres/peak_force"]
    largest = np.zeros(result.n_spheres)
    for i, j, rise, _ in dynamic_contact_peaks(result):
        for ends in (i, j):
            np.maximum.at(largest, result.rows(ends), rise)
    return largest
