"""Means of a few random replicates, with how far they can be trusted.

Replicates are independent, so that the mean of ``n`` has Student's confidence interval ``mean +- t_(n-1) s / sqrt(n)``.
Of intervals that are meant to cover the true mean 95 times of 100, this one covers it 95 times for normal values at any
n, and 91 to 93 times at n = 3 to 20 for values as lopsided as lognormal ones whose logarithms deviate by 0.5. The
bootstrap, which assumes nothing, resamples too few values to show their spread: its percentile interval covers the mean
of normal values 74 times at n = 3, 83 times at n = 5 and 89 times at n = 10.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

CONFIDENCE = 0.95
_MOST_SEEDS = 1_000_000
_ROUNDING = 1e-12  # of the mean: a deviation that equal values have


@dataclasses.dataclass(frozen=True)
class Estimate:
    """A mean and how far it can be trusted.

    Attributes
    ----------
    n
        How many values there are.
    mean
        Of the values.
    deviation
        Standard deviation of the values, over n - 1; NaN of a single one.
    half_width
        Of the confidence interval of the mean; NaN where one random value is all there is, 0 of what is not random.
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
        """Nothing is random in it."""
        return self.half_width == 0 and self.n == 1

    def over(self, unit: float) -> Estimate:
        """In units of a number that is exactly known."""
        return Estimate(self.n, self.mean / unit, self.deviation / abs(unit), self.half_width / abs(unit))


def exactly(value: float) -> Estimate:
    """The estimate of a value that is not random."""
    return Estimate(1, value, 0.0, 0.0)


def estimate(values: Sequence[float] | NDArray[np.float64], confidence: float = CONFIDENCE) -> Estimate:
    """Mean, deviation and confidence interval of random values.

    Raises
    ------
    ValueError
        There is no value.
    """
    found = np.asarray(values, dtype=np.float64)
    if not len(found):
        raise ValueError("found no value, expected one at least")
    mean = float(np.mean(found))
    deviation = float(np.std(found, ddof=1)) if len(found) > 1 else math.nan
    if deviation < _ROUNDING * abs(mean):
        deviation = 0.0
    return Estimate(len(found), mean, deviation, half_width(deviation, len(found), confidence))


def half_width(deviation: float, n: int, confidence: float = CONFIDENCE) -> float:
    """Half width of the confidence interval of the mean of ``n`` values of this deviation; NaN for fewer than two."""
    return _student(confidence, n - 1) * deviation / math.sqrt(n) if n > 1 else math.nan


def seeds_needed(deviation: float, wanted: float, confidence: float = CONFIDENCE) -> int:
    """How many values make the confidence interval at most ``wanted`` to either side, by their standard deviation.

    Raises
    ------
    ValueError
        The wanted half-width is not positive, or would take more than a million values.
    """
    if not wanted > 0:
        raise ValueError(f"found a half-width of {wanted}, expected a positive one")
    if not half_width(deviation, _MOST_SEEDS, confidence) <= wanted:
        raise ValueError(f"a half-width of {wanted} takes more than {_MOST_SEEDS} values, expected a wider one")
    few, enough = 1, 2
    while half_width(deviation, enough, confidence) > wanted:
        few, enough = enough, 2 * enough
    while enough - few > 1:  # the half-width falls with n
        middle = (few + enough) // 2
        few, enough = (few, middle) if half_width(deviation, middle, confidence) <= wanted else (middle, enough)
    return enough


def differ_significantly(first: Estimate, second: Estimate, confidence: float = CONFIDENCE) -> bool | None:
    """The means differ by more than chance lets expect: Welch's test; None where the spread of one is not known.

    Intervals that do not overlap always can be told apart; those that overlap a little may be too.
    """
    if not (math.isfinite(first.half_width) and math.isfinite(second.half_width)):
        return None
    parts = [one.deviation**2 / one.n if not one.exact else 0.0 for one in (first, second)]
    variance, gap = sum(parts), abs(first.mean - second.mean)
    if variance == 0:
        return gap > 0
    freedom = variance**2 / sum(part**2 / (one.n - 1) for part, one in zip(parts, (first, second), strict=True) if part)
    return gap > _student(confidence, freedom) * math.sqrt(variance)


def growing(values: Sequence[float] | NDArray[np.float64], confidence: float = CONFIDENCE) -> list[Estimate]:
    """Estimates of the first two, three, ... values."""
    return [estimate(values[:n], confidence) for n in range(2, len(values) + 1)]


def crossing(x: Sequence[float], y: Sequence[float], level: float) -> float | None:
    """The x at which y, straight between its points, first falls below a level; None where it never does."""
    below = [place for place, value in enumerate(y) if value < level]
    if not below:
        return None
    n = below[0]
    if n == 0:
        return float(x[0])
    return float(x[n - 1] + (x[n] - x[n - 1]) * (y[n - 1] - level) / (y[n - 1] - y[n]))


def _student(confidence: float, freedom: float) -> float:
    return float(stdtrit(freedom, 0.5 + 0.5 * confidence))
