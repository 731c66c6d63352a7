"""Statistics of replicates: against scipy, closed forms, and the coverage of their intervals."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats
from scipy.special import gammaln

from granwave.analysis.statistics import (
    Estimate,
    crossing,
    differ_significantly,
    estimate,
    exactly,
    growing,
    half_width,
    seeds_needed,
)


@pytest.mark.parametrize("n", [2, 3, 5, 20])
@pytest.mark.parametrize("confidence", [0.68, 0.95, 0.99])
def test_interval_is_students(n: int, confidence: float) -> None:
    values = np.random.default_rng(n).normal(7.0, 2.0, n)
    found = estimate(values, confidence)
    low, high = stats.t.interval(confidence, n - 1, loc=values.mean(), scale=stats.sem(values))
    assert (found.low, found.high) == pytest.approx((low, high), rel=1e-12)
    assert (found.n, found.mean) == (n, pytest.approx(values.mean()))
    assert found.deviation == pytest.approx(values.std(ddof=1))


def test_closed_forms() -> None:
    two = estimate([1.0, 3.0])  # t with one degree of freedom is Cauchy's: tan(0.475 pi)
    assert two.half_width == pytest.approx(math.tan(0.475 * math.pi) * math.sqrt(2) / math.sqrt(2), rel=1e-12)
    assert half_width(1.0, 10**6) == pytest.approx(1.959964e-3, rel=1e-5)
    one = estimate([4.0])
    assert one.mean == 4.0 and math.isnan(one.deviation) and math.isnan(one.half_width) and not one.exact
    assert exactly(4.0).exact and exactly(4.0).low == exactly(4.0).high == 4.0
    alike = estimate([0.1 + 0.2, 0.3, 0.3])  # values that differ by rounding only
    assert alike.deviation == alike.half_width == 0 and not alike.exact
    halved = two.over(-2.0)
    assert (halved.mean, halved.half_width) == (-1.0, pytest.approx(two.half_width / 2))
    with pytest.raises(ValueError, match="found no value"):
        estimate([])


@pytest.mark.parametrize("n", [3, 5, 10])
def test_interval_covers_the_mean_as_often_as_it_says(n: int) -> None:
    rng, width = np.random.default_rng(8), half_width(1.0, n)

    def coverage(values: np.ndarray, mean: float) -> float:
        off = np.abs(values.mean(axis=1) - mean)
        return float(np.mean(off <= width * values.std(axis=1, ddof=1)))

    assert coverage(rng.normal(10.0, 1.0, (20_000, n)), 10.0) == pytest.approx(0.95, abs=0.005)
    assert coverage(rng.lognormal(0.0, 0.5, (20_000, n)), math.exp(0.125)) > 0.90


def test_seeds_needed_is_the_least_that_suffices() -> None:
    for ratio in (0.05, 0.3, 1.0, 4.0, 30.0):
        n = seeds_needed(ratio, 1.0)
        assert half_width(ratio, n) <= 1.0 and (n == 2 or half_width(ratio, n - 1) > 1.0)
    assert seeds_needed(0.0, 1e-9) == 2
    assert seeds_needed(1.0, 0.02) == pytest.approx((1.96 / 0.02) ** 2, rel=2e-3)
    with pytest.raises(ValueError, match="positive"):
        seeds_needed(1.0, 0.0)
    with pytest.raises(ValueError, match="more than"):
        seeds_needed(1e9, 1.0)


def test_means_that_differ_by_welch() -> None:
    rng = np.random.default_rng(3)
    for _ in range(50):
        a, b = rng.normal(0.0, 1.0, 4), rng.normal(1.5, 3.0, 9)
        expected = stats.ttest_ind(a, b, equal_var=False).pvalue < 0.05
        assert differ_significantly(estimate(a), estimate(b)) == expected
        assert differ_significantly(estimate(a), exactly(1.0)) == (stats.ttest_1samp(a, 1.0).pvalue < 0.05)
    same = [differ_significantly(*map(estimate, rng.normal(0.0, 1.0, (2, 5)))) for _ in range(4000)]
    assert np.mean(same) == pytest.approx(0.05, abs=0.012)  # by chance only
    assert differ_significantly(exactly(1.0), exactly(1.1)) is True and not differ_significantly(
        exactly(1.0), exactly(1.0)
    )
    assert differ_significantly(estimate([1.0]), exactly(2.0)) is None


def test_confidence_converges_with_the_root_of_the_seeds() -> None:
    """Mean over many sets of seeds: 1/sqrt(n) times Student's factor, which tends to 1.96."""
    rng, counts = np.random.default_rng(5), np.array([8, 32, 128, 512])
    widths = np.array(
        [np.mean([estimate(values).half_width for values in rng.normal(100, 20, (300, n))]) for n in counts]
    )
    bias = np.sqrt(2 / (counts - 1)) * np.exp(
        gammaln(counts / 2) - gammaln((counts - 1) / 2)
    )  # of a standard deviation
    expected = [bias_n * half_width(20.0, int(n)) for bias_n, n in zip(bias, counts, strict=True)]
    assert widths == pytest.approx(expected, rel=0.03)
    slope = np.polyfit(np.log(counts[1:]), np.log(widths[1:]), 1)[0]
    assert slope == pytest.approx(-0.5, abs=0.02)
    steps = growing(rng.normal(100, 20, 50))
    assert [one.n for one in steps] == list(range(2, 51)) and isinstance(steps[0], Estimate)


@pytest.mark.parametrize(
    ("y", "expected"),
    [([1.0, 0.95, 0.85], 1.5), ([1.0, 0.8, 1.2], 0.5), ([1.0, 1.2, 0.9], None), ([0.5, 1.0, 1.0], 0.0)],
)
def test_crossing_is_the_first(y: list[float], expected: float | None) -> None:
    found = crossing([0.0, 1.0, 2.0], y, 0.9)
    assert found == (None if expected is None else pytest.approx(expected))
