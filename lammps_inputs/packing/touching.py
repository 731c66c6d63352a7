"""Contacts of grains at user-defined positions that touch within a tolerance: tolerance from the
rounding in their file, and displacements after which they just touch.

A grain whose coordinates are rounded to the unit u of their last place has an error of up to u/2
along each axis and in its diameter. The gap of a pair is then off by up to (sqrt(3) + 1/2) u.

The gaps g of the pairs are closed by displacements d with J d = -g to first order; the solution
with the smallest sum of squares is applied iteratively, and the gaps converge quadratically to
zero.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.packing.grains import Grains
from granwave.lammps_inputs.packing.cylinders import (
    distances,
    nearest_image,
    nearest_vectors,
    reaches,
)
from granwave.lammps_inputs.packing.places import near_pairs
from granwave.lammps_inputs.packing_kind import TOUCHING

_DIGITS = 15  # digits of a double that survive a change of its unit
_OF_GAP = math.sqrt(3) + 1 / 2  # largest error of a gap / unit of the last place
_LARGEST_DEFAULT = 1e-2  # diameters: largest tolerance by the digits of a file
_ROUNDS = 6  # iterations of the fit; each squares the error
_CLOSED = 1e-13  # diameters: gap of grains that just touch
_PRECISION = 1e-14  # precision of the least squares
_MOST_ITERATIONS = 20_000

Period = tuple[float, float] | None


def last_place(values: NDArray[np.float64]) -> float:
    """Return the unit of the last digit of the largest of some numbers, as they were written.

    A file has a number of decimals, or of significant digits; in both cases the largest numbers
    have the largest unit, and some number has all the digits. Trailing zeros and the rounding of a
    change of unit do not matter.
    """
    sizes = np.unique(np.abs(values))
    if not sizes.any():
        return 0.0
    digits = max(map(_significant_digits, sizes.tolist()))
    return float(10.0 ** (math.floor(math.log10(sizes[-1])) + 1 - digits))


def _significant_digits(value: float) -> int:
    mantissa, _ = f"{value:.{_DIGITS - 1}e}".split("e")
    return len(mantissa.rstrip("0").replace(".", ""))


def rounding_of(grains: Grains) -> float:
    """Return the unit of the last digit of the lengths of grains, m: from the reader of the file,
    otherwise from the digits.
    """
    if len(grains.half_unit):
        return 2 * float(grains.half_unit.max())
    return last_place(np.concatenate([grains.position.ravel(), grains.diameter]))


def tolerance_of(grains: Grains, diameter: float) -> float:
    """Return the touch tolerance of grains by their digits, m.

    Parameters
    ----------
    diameter
        Nominal diameter, m.
    """
    by_digits = min(_OF_GAP * rounding_of(grains), _LARGEST_DEFAULT * diameter)
    return max(by_digits, TOUCHING * diameter)


@dataclasses.dataclass(frozen=True, eq=False)
class GrainGaps:
    """Gaps of pairs of grains.

    Attributes
    ----------
    pairs
        Rows of the grains: (n, 2).
    gap
        Gaps, negative where they overlap: (n,), m.
    """

    pairs: NDArray[np.int64]
    gap: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.gap)

    def within(self, tolerance: float) -> GrainGaps:
        """Return the pairs that touch within a tolerance, m."""
        near = np.abs(self.gap) <= tolerance
        return GrainGaps(self.pairs[near], self.gap[near])

    def overlapping(self, tolerance: float) -> GrainGaps:
        """Return the pairs that overlap by more than a tolerance, m."""
        deep = self.gap < -tolerance
        return GrainGaps(self.pairs[deep], self.gap[deep])

    @property
    def largest_overlap(self) -> float:
        """Largest overlap, m; 0 without any."""
        return max(0.0, -float(self.gap.min(initial=0.0)))


def gaps_up_to(grains: Grains, largest: float, period: Period = None) -> GrainGaps:
    """Return the gaps of all pairs of grains that overlap, or whose gap is at most this large;
    without pairs within a clump.

    Parameters
    ----------
    largest
        Largest gap, m.
    period
        Periods along x and y, m.
    """
    pairs = near_pairs(grains.position, reaches(grains), largest, period)
    pairs = pairs[grains.of_different_clumps(pairs)]
    gap = _gaps(grains, grains.position, pairs, period)
    near = gap <= largest
    return GrainGaps(pairs[near], gap[near])


def _gaps(
    grains: Grains, position: NDArray[np.float64], pairs: NDArray[np.int64], period: Period
) -> NDArray[np.float64]:
    """Return the gaps of pairs of rows of grains at these positions: (n,), m."""
    first, second = pairs.T
    apart = distances(position, grains.diameter, grains.shape, first, second, period)
    return apart - grains.diameter[pairs].sum(axis=1) / 2


@dataclasses.dataclass(frozen=True, eq=False)
class TouchingFit:
    """Grains that were moved until they just touch.

    Attributes
    ----------
    position
        Centres: (n, 3), m.
    n_contacts
        Number of pairs that were to touch.
    moved
        Largest displacement of a grain, m.
    remaining
        Largest gap or overlap that these pairs have left, m.
    """

    position: NDArray[np.float64]
    n_contacts: int
    moved: float
    remaining: float


def fit_touching(grains: Grains, tolerance: float, period: Period = None) -> TouchingFit:
    """Move grains as little as possible until all pairs within a tolerance (m) just touch.

    Parameters
    ----------
    period
        Periods along x and y, m.
    """
    contacts = gaps_up_to(grains, tolerance, period).within(tolerance)
    position = grains.position
    gap = contacts.gap
    closed = _CLOSED * float(grains.diameter.mean())
    best = float(np.abs(gap).max(initial=0.0))
    for _ in range(_ROUNDS):
        if best <= closed:
            break
        there = position + _closing(grains, position, contacts.pairs, gap, period)
        gap = _gaps(grains, there, contacts.pairs, period)
        left = float(np.abs(gap).max())
        if left > best / 2:
            break  # rounding, or more contacts than any arrangement can have
        position = there
        best = left
    moved = np.linalg.norm(position - grains.position, axis=1)
    return TouchingFit(position, len(contacts), float(moved.max(initial=0.0)), best)


def _closing(
    grains: Grains,
    position: NDArray[np.float64],
    pairs: NDArray[np.int64],
    gap: NDArray[np.float64],
    period: Period,
) -> NDArray[np.float64]:
    """Return the smallest displacements that close some gaps, to first order: (n, 3), m."""
    # imported on demand: slow to load
    from scipy.sparse import csr_array
    from scipy.sparse.linalg import lsqr

    normal = _normals(grains, position, pairs, period)
    n_pairs = len(pairs)
    axes = np.arange(3)
    columns = np.concatenate([3 * pairs[:, 0, None] + axes, 3 * pairs[:, 1, None] + axes], axis=1)
    values = np.concatenate([-normal, normal], axis=1)
    rows = np.repeat(np.arange(n_pairs), columns.shape[1])
    shape = (n_pairs, position.size)
    matrix = csr_array((values.ravel(), (rows, columns.ravel())), shape=shape)
    scale = float(np.abs(gap).max())
    solution = lsqr(
        matrix, -gap / scale, atol=_PRECISION, btol=_PRECISION, conlim=0, iter_lim=_MOST_ITERATIONS
    )[0]
    return np.asarray(scale * solution.reshape(-1, 3))


def _normals(
    grains: Grains, position: NDArray[np.float64], pairs: NDArray[np.int64], period: Period
) -> NDArray[np.float64]:
    """Return the directions along which gaps widen, from the first grain to the second: (n, 3)."""
    between = nearest_image(position[pairs[:, 1]] - position[pairs[:, 0]], period)
    normal = between.copy()
    if any(grains.shape):
        kinds = list(dict.fromkeys(grains.shape))
        kind = np.array([kinds.index(shape) for shape in grains.shape])[pairs]
        for first, second in np.unique(kind, axis=0):
            rows = (kind == (first, second)).all(axis=1)
            normal[rows] = nearest_vectors(between[rows], kinds[first], kinds[second])[0]
    return np.asarray(normal / np.linalg.norm(normal, axis=1, keepdims=True))
