"""Disorder of a packing: diameters in a tolerance band, random vacancies, replaced spheres, and a
tilted floor.

Separate streams of random numbers follow from ``packing.seed``, so that a change of one property
does not change the others:

    diameters   one number for each site, scaled by the width of the band; independent of vacancies
                and replaced spheres
    vacancies   one number for each site; the sites of the smallest numbers are vacant, so that the
                vacancies of a larger fraction include those of a smaller fraction
    replace     as vacancies, with one stream for each entry, by its position in the case
    strikers    three numbers for each striker with a misalignment, one stream each, by its position
                in the case

The numbers are the upper 53 bits of the output of PCG64, whose stream numpy guarantees for all
versions and machines. For a normal distribution they pass through a special function whose last
bits may depend on the machine; the results are rounded to multiples of `_GRID` of the band.

Spheres of a square packing on a slightly tilted floor: each lies on the floor and leans on two
neighbours or walls.

The spheres roll to a corner and come to rest one after another, so that every sphere touches the
next sphere towards the corner in its row and in its column, or the wall. Sphere (a, b), counted
from the corner, is where the circles of these contacts meet; all spheres of a diagonal are placed
at once. The contacts are closed and carry no force.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.bodies import Replace, Striker
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.packing.packing import PackingSection

DEFAULT_SEED = 1
DIAMETERS, VACANCIES, REPLACE, STRIKERS = range(4)  # streams

_DEVIATIONS = 3.0  # standard deviations between the middle and the ends of the band
_GRID = 2.0**-24  # fraction of the band


def is_random(case: Case) -> bool:
    """Return True if the packing or a striker's position depends on the seed."""
    share = isinstance(case.packing.vacancies, float) and case.packing.vacancies > 0
    strikers = any(any(striker.misalignment) for striker in case.striker)
    return (
        bool(case.packing.diameter_scatter)
        or share
        or strikers
        or any(entry.share for entry in case.replace)
    )


def has_gaps(case: Case) -> bool:
    """Return True if contacts may be open at the start, which makes the search for static
    equilibrium long.
    """
    return bool(
        case.packing.diameter_scatter or case.packing.vacancies or case.contact.initial_overlap
    )


def diameter_losses(packing: PackingSection, n: int) -> NDArray[np.float64]:
    """Draw the deficits of the diameters from the nominal diameter: (n,), m, from 0 to
    ``diameter_scatter``.
    """
    place = _uniform(packing.seed, n, DIAMETERS)
    if packing.scatter_distribution == "normal":
        from scipy.special import ndtr, ndtri  # imported on demand: slow to load

        least = ndtr(-_DEVIATIONS)
        most = ndtr(_DEVIATIONS)
        place = (ndtri(least + (most - least) * place) / _DEVIATIONS + 1) / 2
        place = np.clip(np.rint(place / _GRID) * _GRID, 0, 1)
    return packing.diameter_scatter * place


def vacant_sites(packing: PackingSection, n: int, kept: Collection[int]) -> NDArray[np.int64]:
    """Return the vacant sites, from 0: listed sites, or random sites for a fraction; the ids in
    ``kept`` are never vacant.

    Raises
    ------
    ValueError
        The fraction exceeds the spheres that may be omitted.
    """
    if isinstance(packing.vacancies, tuple) or not packing.vacancies:
        return np.array(packing.vacancies or (), dtype=np.int64) - 1
    may_go = np.ones(n, dtype=bool)
    may_go[np.fromiter(kept, dtype=np.int64, count=len(kept)) - 1] = False
    number = round(float(packing.vacancies) * n)
    among = int(np.count_nonzero(may_go))
    if number >= n:
        raise ValueError("leaves no spheres")
    if number > among:
        raise ValueError(
            f"removes {number} spheres, but only {among} can be removed: the case uses the others"
        )
    return _smallest(_uniform(packing.seed, n, VACANCIES), may_go, number)


def random_share(
    packing: PackingSection, entry: Replace, place: int, present: NDArray[np.bool_]
) -> NDArray[np.int64]:
    """Draw the sites, from 0, of a ``[[replace]]`` entry with a fraction, among the sites that are
    ``present``.

    Parameters
    ----------
    place
        Number of the entry in the case, from 1.
    """
    number = round((entry.share or 0.0) * int(np.count_nonzero(present)))
    return _smallest(_uniform(packing.seed, len(present), REPLACE, place), present, number)


def striker_shift(seed: int | None, striker: Striker, place: int) -> NDArray[np.float64]:
    """Return the shift of a striker: its offset plus its random misalignment, (3,), m.

    Parameters
    ----------
    place
        Number of the striker in the case, from 1.
    """
    shift = np.array(striker.offset)
    if any(striker.misalignment):
        shift += np.array(striker.misalignment) * (2 * _uniform(seed, 3, STRIKERS, place) - 1)
    return shift


def _smallest(
    values: NDArray[np.float64], allowed: NDArray[np.bool_], number: int
) -> NDArray[np.int64]:
    """Return the indices of the ``number`` smallest of the allowed values, in rising order."""
    where = np.flatnonzero(allowed)
    return np.sort(where[np.argsort(values[where], kind="stable")[:number]])


def _uniform(seed: int | None, n: int, *stream: int) -> NDArray[np.float64]:
    """Draw random numbers in [0, 1): (n,)."""
    entropy = np.random.SeedSequence(DEFAULT_SEED if seed is None else seed, spawn_key=stream)
    upper = np.random.PCG64(entropy).random_raw(n) >> np.uint64(11)
    return upper.astype(np.float64) * 2.0**-53


Array = NDArray[np.float64]
Cells = tuple[NDArray[np.int64], NDArray[np.int64]]  # rows and columns of arrays (ny, nx)


def lean(size: tuple[int, ...], diameter: float, diameters: Array, tilt: tuple[int, int]) -> Array:
    """Return the centres of leaning spheres: (nx ny, 3), m, ids with x fastest.

    Parameters
    ----------
    size
        Numbers of spheres along x and y.
    diameter
        Nominal diameter, m: walls and floor touch nominal spheres at the sites of the lattice.
    diameters
        Diameters of the spheres, at most the nominal diameter: (nx ny,), m.
    tilt
        Signs of the directions along x and y in which the spheres roll.

    Raises
    ------
    ValueError
        The spheres differ so much that one does not fit between its neighbours.
    """
    nx, ny = size[:2]
    radii = _from_corner(diameters.reshape(ny, nx) / 2, tilt)
    drop = diameter / 2 - radii  # height of nominal centres above these centres
    # distances from the two walls
    u = np.empty_like(radii)
    v = np.empty_like(radii)
    u[:, 0] = radii[:, 0]
    v[0, :] = radii[0, :]
    for diagonal in range(1, nx + ny - 1):
        b = np.arange(max(0, diagonal - nx + 1), min(ny, diagonal + 1))
        a = diagonal - b
        reach_u = _reach(
            radii, drop, (b, a), (b, a - 1)
        )  # distance of the neighbour in its row; not used at the wall
        reach_v = _reach(radii, drop, (b, a), (b - 1, a))
        first = (b == 0) & (a > 0)
        last = (a == 0) & (b > 0)
        inner = (a > 0) & (b > 0)
        u[b[first], a[first]] = u[0, a[first] - 1] + _side(
            reach_u[first], v[0, a[first]] - v[0, a[first] - 1]
        )
        v[b[last], 0] = v[b[last] - 1, 0] + _side(reach_v[last], u[b[last], 0] - u[b[last] - 1, 0])
        # intersection of circles about the neighbours in the row and below, away from the corner
        i = b[inner]
        j = a[inner]
        beside, below = (np.stack([u[one], v[one]]) for one in ((i, j - 1), (i - 1, j)))
        between = below - beside
        apart = np.linalg.norm(between, axis=0)
        along = (apart**2 + reach_u[inner] ** 2 - reach_v[inner] ** 2) / (2 * apart)
        normal = np.stack([-between[1], between[0]]) / apart
        u[i, j], v[i, j] = beside + along * between / apart + _side(reach_u[inner], along) * normal
    far = np.array([nx - 1, ny - 1]) * diameter + diameter / 2  # positions of the far walls
    x, y = (
        far[axis] - part if sign > 0 else part - diameter / 2
        for axis, (part, sign) in enumerate(zip((u, v), tilt, strict=True))
    )
    centres = np.stack([_from_corner(part, tilt).ravel() for part in (x, y, drop)], axis=1)
    return np.asarray(centres)


def _from_corner(values: Array, tilt: tuple[int, int]) -> Array:
    """Reverse the axes of values (ny, nx) so that the first is at the corner; the function is its
    own inverse.
    """
    return values[:: -tilt[1], :: -tilt[0]]


def _reach(radii: Array, drop: Array, one: Cells, other: Cells) -> Array:
    """Return the distance in the plane of the centres of two touching spheres on the floor."""
    return _side(radii[one] + radii[other], drop[one] - drop[other])


def _side(hypotenuse: Array, other: Array) -> Array:
    """Third side of a right triangle."""
    square = hypotenuse**2 - other**2
    if square.size and square.min() <= 0:
        raise ValueError("the diameters differ too much for spheres that rest against each other")
    return np.sqrt(square)
