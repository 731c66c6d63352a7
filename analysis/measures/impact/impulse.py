"""Peak forces of contacts against the impulse that struck the packing, and whether they are proportional."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.impact.dissipation import rays
from granwave.analysis.measures.waves.front import in_cone
from granwave.analysis.result.reader import Result

_WEAK = 1.0  # of the unit: contacts that stay below at the largest velocity are left out

Pair = tuple[int, int]


@dataclasses.dataclass(frozen=True, eq=False)
class PeakForces:
    """Peak forces of one impact.

    Attributes
    ----------
    of_pair
        Of every contact, by the ids of its spheres.
    along
        Largest of the n-th contacts along the preferred directions: (n_contacts,).
    depth
        Of the contacts within the cone of these directions, m, by the ids of their spheres.
    """

    of_pair: dict[Pair, float]
    along: NDArray[np.float64]
    depth: dict[Pair, float]


def peak_forces(result: Result, unit: float) -> PeakForces:
    """Return the peak forces of an impact in a unit, N."""
    pairs = list(zip(result["contacts/i"].tolist(), result["contacts/j"].tolist(), strict=True))
    force = (result["contacts/peak_force"] / unit).tolist()
    depth = result["spheres/position"][result.ends, 2].mean(axis=1) - result.origin[2]
    inside = np.flatnonzero(in_cone(result)[result.ends].all(axis=1))
    along = np.nanmax(rays(result).peak_force, axis=1) / unit
    return PeakForces(dict(zip(pairs, force, strict=True)), along, {pairs[k]: float(depth[k]) for k in inside})


@dataclasses.dataclass(frozen=True, eq=False)
class Linearity:
    """Peak force against velocity, contact by contact.

    Attributes
    ----------
    velocity
        (n_runs,).
    ray
        Largest peak force of the contacts on the preferred directions: (n_contacts, n_runs).
    depth
        Of the contacts, m: (m,).
    exponent
        Of force against velocity, a least-squares slope on logarithmic axes: (m,).
    """

    velocity: NDArray[np.float64]
    ray: NDArray[np.float64]
    depth: NDArray[np.float64]
    exponent: NDArray[np.float64]


def linearity(velocity: Sequence[float], found: Sequence[PeakForces]) -> Linearity | None:
    """Return the linearity of impacts on one packing, by rising velocity; None if no contact counts.

    Contacts count that lie within the cone of the preferred directions, are pressed beyond the unit at the largest
    velocity and were pressed at all at every other. Beyond the cone a contact may be loaded by the rebound alone.
    """
    forces, depth = [one.of_pair for one in found], found[-1].depth
    kept = [pair for pair in depth if forces[-1][pair] > _WEAK and all(one.get(pair, 0) > 0 for one in forces)]
    if not kept:
        return None
    x, y = np.log(velocity), np.log([[one[pair] for one in forces] for pair in kept])
    x = x - x.mean()
    shortest = min(len(one.along) for one in found)
    ray = np.stack([one.along[:shortest] for one in found], axis=1)
    return Linearity(np.array(velocity), ray, np.array([depth[pair] for pair in kept]), (y @ x) / (x @ x))
