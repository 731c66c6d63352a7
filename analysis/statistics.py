"""Means of a few random replicates, with their confidence intervals.

Replicates are independent, so that the mean of ``n`` has Student's confidence interval ``mean +-
t_(n-1) s / sqrt(n)``. At a nominal coverage of 95 %, this interval covers the true mean in 95 % of
cases for normal values at any n, and in 91 to 93 % at n = 3 to 20 for skewed values, such as
lognormal ones with a standard deviation of 0.5 of the logarithm. The bootstrap makes no assumption,
but so few values underestimate the spread: its percentile interval covers the mean of normal values
in 74 % of cases at n = 3, 83 % at n = 5 and 89 % at n = 10.
"""

from __future__ import annotations

import bisect
import dataclasses
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

CONFIDENCE = 0.95
_MOST_SEEDS = 1_000_000
_ROUNDING = 1e-12  # deviation / mean that counts as rounding


@dataclasses.dataclass(frozen=True)
class Estimate:
    """Mean with its confidence interval.

    Attributes
    ----------
    n
        Number of values.
    mean
        Mean of the values.
    deviation
        Standard deviation of the values, over n - 1; NaN for a single one.
    half_width
        Half-width of the confidence interval of the mean; NaN for a single random value, 0 for an
        exact one.
    """

    n: int
    mean: float
    deviation: float
    half_width: float

    @property
    def low(self) -> float:
        """Lower end of the interval."""
        return self.mean - self.half_width

    @property
    def high(self) -> float:
        """Upper end of the interval."""
        return self.mean + self.half_width

    @property
    def exact(self) -> bool:
        """True if the value is not random."""
        return self.half_width == 0 and self.n == 1

    def over(self, unit: float) -> Estimate:
        """Return the estimate in units of an exactly known number."""
        return Estimate(
            self.n, self.mean / unit, self.deviation / abs(unit), self.half_width / abs(unit)
        )


def exactly(value: float) -> Estimate:
    """Return the estimate of a value that is not random."""
    return Estimate(1, value, 0.0, 0.0)


def estimate(
    values: Sequence[float] | NDArray[np.float64], confidence: float = CONFIDENCE
) -> Estimate:
    """Estimate mean, deviation and confidence interval of random values.

    Raises
    ------
    ValueError
        There is no value.
    """
    found = np.asarray(values, dtype=np.float64)
    if not len(found):
        raise ValueError("found no value, expected at least one")
    mean = float(np.mean(found))
    deviation = float(np.std(found, ddof=1)) if len(found) > 1 else math.nan
    if deviation < _ROUNDING * abs(mean):
        deviation = 0.0
    return Estimate(len(found), mean, deviation, half_width(deviation, len(found), confidence))


def half_width(deviation: float, n: int, confidence: float = CONFIDENCE) -> float:
    """Return the half-width of the confidence interval of a mean of ``n`` values; NaN for fewer
    than two.
    """
    return _student(confidence, n - 1) * deviation / math.sqrt(n) if n > 1 else math.nan


def seeds_needed(deviation: float, wanted: float) -> int:
    """Return the number of values of this standard deviation for a half-width of at most
    ``wanted``.

    Raises
    ------
    ValueError
        The wanted half-width is not positive, or needs more than a million values.
    """
    if not wanted > 0:
        raise ValueError(f"found a half-width of {wanted}, expected a positive one")
    if not half_width(deviation, _MOST_SEEDS) <= wanted:
        raise ValueError(
            f"a half-width of {wanted} requires more than {_MOST_SEEDS} values; use a wider one"
        )
    wide = range(2, _MOST_SEEDS + 1)  # the half-width decreases with their number
    return wide[bisect.bisect_left(wide, True, key=lambda n: half_width(deviation, n) <= wanted)]


def differ_significantly(
    first: Estimate, second: Estimate, confidence: float = CONFIDENCE
) -> bool | None:
    """Test if two means differ significantly, by Welch's test; None if the spread of one is
    unknown.

    Means whose intervals do not overlap always differ significantly; means with a small overlap may
    differ significantly too.
    """
    if not (math.isfinite(first.half_width) and math.isfinite(second.half_width)):
        return None
    parts = [one.deviation**2 / one.n if not one.exact else 0.0 for one in (first, second)]
    variance = sum(parts)
    gap = abs(first.mean - second.mean)
    if variance == 0:
        return gap > 0
    freedom = variance**2 / sum(
        part**2 / (one.n - 1) for part, one in zip(parts, (first, second), strict=True) if part
    )
    return gap > _student(confidence, freedom) * math.sqrt(variance)


def growing(
    values: Sequence[float] | NDArray[np.float64], confidence: float = CONFIDENCE
) -> list[Estimate]:
    """Return the estimates from the first two, three, ... values."""
    return [estimate(values[:n], confidence) for n in range(2, len(values) + 1)]


def crossing(x: Sequence[float], y: Sequence[float], level: float) -> float | None:
    """Return the x at which y, interpolated linearly, first falls below a level; None if it never
    does.
    """
    below = [place for place, value in enumerate(y) if value < level]
    if not below:
        return None
    n = below[0]
    if n == 0:
        return float(x[0])
    return float(x[n - 1] + (x[n] - x[n - 1]) * (y[n - 1] - level) / (y[n - 1] - y[n]))


def _student(confidence: float, freedom: float) -> float:
    from scipy.special import stdtrit  # imported on demand: slow to load

    return float(stdtrit(freedom, 0.5 + 0.5 * confidence))
