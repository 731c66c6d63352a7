"""Decay of a peak along a line: a continuous broken line in the logarithm of the peak, and where two lines part.

ln(peak) = c - a1 x up to the border b, and on with the slope -a2 beyond it. For each border the rest is linear, so that
the border alone is searched: over each interval between grains that leaves at least two on either side.
"""

from __future__ import annotations

import dataclasses
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

_LEAST = 2  # points on each side of the border
_TRIALS = 60  # borders tried in each interval before the best is refined
PARTED = 0.03  # of the peak speed: from there on two crystals differ


@dataclasses.dataclass(frozen=True)
class Decay:
    """Decay in two regions.

    Attributes
    ----------
    first, second
        Rates of the decay before and beyond the border, 1/m.
    border
        Where the second begins, m.
    single
        Rate of one straight line through all points, 1/m.
    points
        Number of points.
    """

    first: float
    second: float
    border: float
    single: float
    points: int


def fit_decay(distance: NDArray[np.float64], peak: NDArray[np.float64]) -> Decay | None:
    """Fit the broken line to peaks at distances (m); None for fewer than four.

    Parameters
    ----------
    distance, peak
        (n,); points whose peak is not known or not positive do not count.
    """
    known = np.isfinite(peak) & (peak > 0)
    x, y = distance[known], np.log(peak[known])
    if len(x) < 2 * _LEAST:
        return None

    def misfit(border: float) -> tuple[float, NDArray[np.float64]]:
        columns = np.stack([np.ones_like(x), x, np.maximum(x - border, 0.0)], axis=1)
        found, *_ = np.linalg.lstsq(columns, y, rcond=None)
        return float(np.sum((columns @ found - y) ** 2)), found

    low, high = x[_LEAST - 1], x[-_LEAST]
    if low == high:
        candidates = np.array([low])
    else:
        inside = x[(x >= low) & (x <= high)]
        candidates = np.unique(np.concatenate([np.linspace(a, b, _TRIALS) for a, b in pairwise(inside)]))
    best = min(candidates.tolist(), key=lambda border: misfit(border)[0])
    if len(candidates) > 1:
        from scipy.optimize import minimize_scalar  # takes longer to load than most commands need

        at = int(np.searchsorted(candidates, best))
        bounds = candidates[max(at - 1, 0)], candidates[min(at + 1, len(candidates) - 1)]
        refined = minimize_scalar(lambda border: misfit(border)[0], bounds=bounds, method="bounded")
        best = float(refined.x) if misfit(float(refined.x))[0] < misfit(best)[0] else best
    _, slope, bend = misfit(best)[1]
    single = float(np.polyfit(x, y, 1)[0])
    return Decay(-float(slope), -float(slope + bend), best, -single, len(x))


def parted_at(
    distance: NDArray[np.float64],
    peak: NDArray[np.float64],
    wide: NDArray[np.float64],
    share: float = PARTED,
) -> float | None:
    """Return the distance of the first grain whose peak differs by a share from that in a wider crystal, m; None: none.

    Parameters
    ----------
    distance, peak, wide
        Of the same grains: (n,), m and m/s; grains without a peak in one of both do not count.
    """
    known = np.isfinite(peak) & np.isfinite(wide) & (wide > 0)
    apart = np.flatnonzero(known & (np.abs(peak / np.where(known, wide, 1.0) - 1) > share))
    return float(distance[apart[0]]) if len(apart) else None
