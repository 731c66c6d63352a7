"""Courses of a mean along a varied key, and changes beyond the confidence intervals.

Two means differ if their difference exceeds the combined half-width of their 95 % confidence
intervals, (h_1^2 + h_2^2)^(1/2). A line of points rises if its last mean differs from the first one
and is larger, and no pair of points falls beyond its combined half-width.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

SAME = 1e-6  # relative difference of values that count as equal


class Trend(StrEnum):
    """Trend of a mean along a line of points."""

    RISES = "rises"
    FALLS = "falls"
    CONSTANT = "constant"
    MIXED = "mixed"  # rises and falls beyond the intervals
    UNCLEAR = "unclear"  # changes within the intervals


def course_of(means: Sequence[float], half_widths: Sequence[float]) -> Trend:
    """Return the course of means in the order of their abscissae.

    Parameters
    ----------
    half_widths
        Half-widths of their confidence intervals: 0 for exact values, NaN if unknown.
    """
    values = np.array(means, dtype=float)
    largest = float(np.abs(values).max(initial=0.0))
    if np.ptp(values) <= SAME * largest:
        return Trend.CONSTANT
    steps = significant_steps(values, np.array(half_widths, dtype=float))
    if (steps > 0).any() and (steps < 0).any():
        return Trend.MIXED
    ends = steps[0, -1]
    if ends > 0:
        return Trend.RISES
    return Trend.FALLS if ends < 0 else Trend.UNCLEAR


def significant_steps(
    means: NDArray[np.float64], half_widths: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the signs of the changes from each point to each later one, 0 for a change within the
    combined half-width or rounding: (n, n), 0 on and below the diagonal.
    """
    changes = means[None, :] - means[:, None]
    noise = np.hypot(half_widths[None, :], half_widths[:, None])
    beyond = np.abs(changes) > noise + SAME * np.abs(means).max(initial=0.0)
    return np.triu(np.sign(changes) * beyond)
