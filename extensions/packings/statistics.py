"""Statistics of a packing of spheres: solid fraction, coordination, fabric, distribution of forces.

All functions use only numpy, on positions, diameters and pairs of rows.

Published values for comparison, of equal spheres, are in `PUBLISHED`:

* random close packing 0.64: G. D. Scott, D. M. Kilgour, J. Phys. D 2 (1969) 863 (0.6366 in bulk)
* random loose packing 0.555 to 0.60: G. Y. Onoda, E. G. Liniger, Phys. Rev. Lett. 64 (1990) 2727
* coordination 6 without friction, and 4 in the limit of large friction, at zero pressure and
  without rattlers: L. E. Silbert, D. Ertas, G. S. Grest, T. C. Halsey, D. Levine, Phys. Rev. E 65
  (2002) 031304
* exponential tail of the contact forces, exp(-beta F/<F>) with beta = 1.5: D. M. Mueth,
  H. M. Jaeger, S. R. Nagel, Phys. Rev. E 57 (1998) 3164
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]

RANDOM_CLOSE_PACKING = 0.64
RANDOM_LOOSE_PACKING = (0.555, 0.60)
COORDINATION_WITHOUT_FRICTION = 6.0
COORDINATION_WITH_FRICTION = 4.0
FORCE_TAIL = 1.5
_POINTS_ALONG_AN_EDGE = 64  # points along an edge of the inner part, in `solid_fraction`
LEAST_CONTACTS = 2  # fewest contacts of a grain that carries load, with friction
LEAST_WITHOUT_FRICTION = 4
LEAST_UNDER_GRAVITY = 3  # without friction, with the weight as the fourth force
TAIL_FROM = 1.0  # force / mean at which the fitted tail begins
_BINS = 30
_CONTACTS_OF_LAYER = 60


def solid_fraction(
    position: Floats,
    diameter: Floats,
    low: Floats,
    high: Floats,
    period: Sequence[float] = (),
) -> float:
    """Return the fraction of a box inside a packing that spheres fill. It is counted on a regular
    grid of points, with an error of about 1e-3.

    Parameters
    ----------
    position
        Centres: (n, 3), m.
    diameter
        (n,), m.
    low, high
        Corners of the box: (3,), m.
    period
        Periods along x, y and z, m; infinite, or omitted at the end, where there is none.
    """
    from scipy.spatial import KDTree

    axes = [_midpoints(low[axis], high[axis]) for axis in range(3)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    covered = np.zeros(len(points), dtype=bool)
    tree = KDTree(points)
    centres, radii = _with_images(position, diameter / 2, period)
    near = ((centres + radii[:, None] > low) & (centres - radii[:, None] < high)).all(axis=1)
    for centre, radius in zip(centres[near], radii[near], strict=True):
        covered[tree.query_ball_point(centre, radius)] = True
    return float(covered.mean())


def _midpoints(low: float, high: float) -> Floats:
    n = _POINTS_ALONG_AN_EDGE
    return low + (np.arange(n) + 0.5) / n * (high - low)


def _with_images(
    position: Floats, radius: Floats, period: Sequence[float]
) -> tuple[Floats, Floats]:
    """Return centres and radii, with the periodic images next to the cell."""
    lengths = np.zeros(3)
    lengths[: len(period)] = np.where(np.isfinite(period), period, 0.0)
    shifts = [(-1, 0, 1) if length else (0,) for length in lengths]
    images = np.array(list(itertools.product(*shifts))) * lengths
    centres = np.concatenate([position + shift for shift in images])
    return centres, np.tile(radius, len(images))


def depth_profile(position: Floats, diameter: Floats, area: float, edges: Floats) -> Floats:
    """Return the solid fraction of slices across z, exactly: (n_slices,).

    Parameters
    ----------
    area
        Area of the cross-section of the box, m^2.
    edges
        Planes between the slices, rising: (n_slices + 1,), m.
    """
    radius = diameter[:, None] / 2
    height = np.clip(edges - position[:, 2, None], -radius, radius)
    # volume of a sphere below a plane at this height above its centre
    below = math.pi * (2 / 3 * radius**3 + radius**2 * height - height**3 / 3)
    return np.diff(below.sum(axis=0)) / (area * np.diff(edges))


def coordination(n_grains: int, pairs: Rows) -> NDArray[np.int64]:
    """Return the number of contacts of each grain: (n_grains,).

    Parameters
    ----------
    pairs
        Rows of the grains in contact: (n_contacts, 2).
    """
    return np.bincount(pairs.ravel(), minlength=n_grains)


def without_rattlers(
    n_grains: int, pairs: Rows, least: int = LEAST_CONTACTS, at_walls: Rows | None = None
) -> NDArray[np.bool_]:
    """Return True for the grains that carry load: grains with enough contacts with such grains.

    Parameters
    ----------
    pairs
        Rows of the grains in contact: (n_contacts, 2).
    least
        Contacts that a grain needs: 2 with friction; without it 4, and 3 under gravity.
    at_walls
        Number of contacts of each grain with walls: (n_grains,); by default none.

    Returns
    -------
    ndarray
        (n_grains,).
    """
    carries = np.ones(n_grains, dtype=bool)
    walls = np.zeros(n_grains, dtype=np.int64) if at_walls is None else at_walls
    while True:
        inside = pairs[carries[pairs].all(axis=1)]
        enough = carries & (coordination(n_grains, inside) + walls >= least)
        if (enough == carries).all():
            return carries
        carries = enough


def fabric(directions: Floats) -> Floats:
    """Return the fabric tensor, the mean of n n over contact directions: (3, 3), of trace 1.

    Parameters
    ----------
    directions
        Unit vectors along the contacts: (n_contacts, 3).
    """
    return np.asarray(directions.T @ directions / len(directions))


def anisotropy(tensor: Floats) -> float:
    """Return the anisotropy of a fabric tensor: sqrt(3/2) times the norm of its deviator; 0 if it
    is isotropic, 1 if all contacts are parallel.
    """
    deviator = tensor - np.trace(tensor) / 3 * np.eye(3)
    return float(math.sqrt(1.5) * np.linalg.norm(deviator))


def force_over_mean_at_depth(force: Floats, depth: Floats) -> Floats:
    """Return contact forces divided by the mean force at their depth, which grows with the weight
    above.

    The mean is taken over the contacts in the same layer; layers have equal numbers of contacts.

    Parameters
    ----------
    force
        Forces of contacts that carry load: (n_contacts,), N.
    depth
        Depths of the contacts: (n_contacts,), m.
    """
    relative = np.empty_like(force)
    n_layers = max(1, len(force) // _CONTACTS_OF_LAYER)
    for rows in np.array_split(np.argsort(depth, kind="stable"), n_layers):
        relative[rows] = force[rows] / force[rows].mean()
    return relative


def force_distribution(force: Floats) -> tuple[Floats, Floats]:
    """Return the probability density of contact forces divided by their mean.

    Parameters
    ----------
    force
        Forces of contacts that carry load: (n_contacts,), N.

    Returns
    -------
    tuple
        Middles of the bins, forces / mean, and densities: (n_bins,) each.
    """
    relative = force / force.mean()
    density, edges = np.histogram(relative, bins=_BINS, range=(0.0, relative.max()), density=True)
    return (edges[:-1] + edges[1:]) / 2, density


def exponential_tail(force: Floats, start: float = TAIL_FROM) -> float:
    """Return beta of the tail exp(-beta F/<F>) of contact forces; NaN without forces there.

    It is the maximum-likelihood estimate: the inverse of the mean excess over the start.

    Parameters
    ----------
    force
        Forces of contacts that carry load: (n_contacts,), N.
    start
        Force / mean from which on the tail is fitted.
    """
    relative = force / force.mean()
    excess = relative[relative > start] - start
    return float(1 / excess.mean()) if excess.size else math.nan


@dataclasses.dataclass(frozen=True)
class PackingStatistics:
    """Statistics of a packing.

    Attributes
    ----------
    n_grains, n_contacts
        Numbers of grains, and of their contacts with each other.
    solid_fraction
        Fraction of the inner part, away from walls; NaN if the packing is too small to have one.
    coordination
        Mean number of contacts of a grain with others and walls.
    coordination_without_rattlers
        Coordination of grains that carry load only.
    rattlers
        Fraction of grains that carry no load.
    anisotropy
        Of the fabric tensor, see `anisotropy`.
    fabric
        Fabric tensor: (3, 3).
    force_tail
        See `exponential_tail`.
    mean_force, largest_force
        Of the contacts between grains, N.
    pressure
        When it was made, Pa; NaN of packings that were poured.
    """

    n_grains: int
    n_contacts: int
    solid_fraction: float
    coordination: float
    coordination_without_rattlers: float
    rattlers: float
    anisotropy: float
    fabric: Floats
    force_tail: float
    mean_force: float
    largest_force: float
    pressure: float
