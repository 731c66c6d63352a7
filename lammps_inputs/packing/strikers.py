"""Positions of strikers: in contact with given spheres, outside of the packing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.bodies import Striker
from granwave.lammps_inputs.packing.places import Layout

_TOLERANCE = 1e-9  # diameters; largest gap or overlap between a striker and the spheres that it touches
_TELLING = 1e-6  # relative size below which a direction or a singular value counts as zero
_OVERLAP = 1e-6  # diameters; largest overlap with other spheres


def place_strikers(
    lattice: Layout,
    ids: NDArray[np.int64],
    centres: NDArray[np.float64],
    diameters: NDArray[np.float64],
    middle: NDArray[np.float64],
    strikers: Sequence[Striker],
) -> list[NDArray[np.float64]]:
    """Return the centres of the strikers: (3,) each, m.

    A striker touches all its spheres at once. If there are several such positions, a moving striker is placed on the
    side that it comes from, a resting one away from the centre of the packing, or above it if both sides are equal.

    Parameters
    ----------
    ids
        Ids of the spheres of the packing: (n_spheres,).
    centres
        Centres of these spheres: (n_spheres, 3), m.
    diameters
        Diameters of these spheres: (n_spheres,), m.
    middle
        Mean of all sites of the lattice: (3,), m.

    Raises
    ------
    ValueError
        No position of a striker touches all its spheres at once, or a striker overlaps another sphere.
    """
    radii = diameters / 2
    placed = []
    for number, striker in enumerate(strikers, start=1):
        radius = (striker.diameter or lattice.diameter) / 2
        touched = np.searchsorted(ids, striker.touches)
        at, reach = centres[touched], radii[touched] + radius
        centre = _touching(at, reach, _side(striker, at, middle))
        gap = np.linalg.norm(centres - centre, axis=1) - radii - radius
        if np.abs(gap[touched]).max() > _TOLERANCE * 2 * radius:
            raise ValueError(f"striker {number}: found no place where it touches {list(striker.touches)} all at once")
        if gap.min() < -_OVERLAP * 2 * radius:
            other = ids[gap.argmin()]
            raise ValueError(f"striker {number}: its place overlaps sphere {other} by {-gap.min():.3g} m")
        placed.append(centre)
        centres, radii = np.vstack([centres, centre]), np.append(radii, radius)
        ids = np.append(ids, lattice.n_spheres + number)
    return placed


def _side(striker: Striker, at: NDArray[np.float64], middle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the unit vector from the spheres at ``at`` to the side of the striker: (3,)."""
    away = at.mean(axis=0) - middle
    above = np.array([0.0, 0.0, -1.0])
    span = at[1:] - at[0]
    for guess in (-np.array(striker.velocity), away, above):
        across = guess - np.linalg.pinv(span) @ (span @ guess) if len(span) else guess
        # only the component across the line or plane of the spheres distinguishes the possible positions
        size = np.linalg.norm(across)
        if size > _TELLING * np.linalg.norm(guess) and size > _TOLERANCE * np.abs(at).max(initial=0.0):
            return across / size
    return above


def _touching(at: NDArray[np.float64], reach: NDArray[np.float64], side: NDArray[np.float64]) -> NDArray[np.float64]:
    """Find the point at distances ``reach`` from the points ``at``, in the space spanned by these and ``side``."""
    middle = at.mean(axis=0)
    if len(at) == 1:
        return middle + reach[0] * side
    from scipy.optimize import least_squares  # takes longer to load than most commands need

    _, sizes, directions = np.linalg.svd(at - middle)
    spanned = directions[: len(sizes)][sizes > _TELLING * sizes[0]]
    axes = np.vstack([spanned, side])
    start = np.append(np.zeros(len(spanned)), reach.mean())

    def misses(place: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.linalg.norm(at - middle - place @ axes, axis=1) / reach - 1

    found = least_squares(misses, start, x_scale=float(reach.mean()), xtol=1e-15, ftol=1e-15, gtol=1e-15)
    return middle + found.x @ axes
