"""Zeros of functions."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import brentq as scipy_brentq

from granwave.lammps_inputs.roots import brentq

FUNCTIONS: dict[str, tuple[Callable[[float], float], float, float]] = {
    "cosine": (math.cos, 0.0, 3.0),
    "steep": (lambda x: math.exp(20 * x) - 3, -4.0, 5.0),
    "kinked": (lambda x: x - 0.1 if x < 0.1 else 1e3 * (x - 0.1), -7.0, 2.0),
    "stepped": (lambda x: -1.0 if x < 1 / 3 else 1.0, 0.0, 1.0),
    "work": (lambda x: math.log(math.exp(2.5 * x) * (1 + math.exp(x)) / 0.07), -60.0, 3.0),
}


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("xtol", [1e-3, 1e-10, 1e-16])
def test_same_zero_as_scipy(name: str, xtol: float) -> None:
    function, low, high = FUNCTIONS[name]
    found = brentq(function, low, high, xtol=xtol)
    assert found == pytest.approx(scipy_brentq(function, low, high, xtol=xtol), rel=1e-14, abs=1e-3 * xtol)
    assert brentq(function, high, low, xtol=xtol) == pytest.approx(found, rel=1e-12, abs=xtol)


def test_same_places_as_scipy() -> None:
    """So many cubic functions that each branch is taken; the places at which they are evaluated are the same."""
    rng = np.random.default_rng(3)
    for _ in range(200):
        a, b, c = rng.normal(size=3) * 10.0 ** rng.integers(-3, 3, 3)
        ours: list[float] = []
        theirs: list[float] = []

        def cubic(x: float, seen: list[float], a: float = a, b: float = b, c: float = c) -> float:
            seen.append(x)
            return x**3 + a * x**2 + b * x + c

        bound = 2 + abs(a) + abs(b) + abs(c)
        ours_at = brentq(lambda x: cubic(x, ours), -bound, bound, xtol=1e-12, rtol=1e-10)  # noqa: B023
        theirs_at = scipy_brentq(lambda x: cubic(x, theirs), -bound, bound, xtol=1e-12, rtol=1e-10)  # noqa: B023
        assert ours_at == pytest.approx(theirs_at, rel=1e-14)
        assert len(ours) == len(theirs)
        np.testing.assert_allclose(ours, theirs, rtol=1e-12)


def test_zero_at_a_bound() -> None:
    assert brentq(lambda x: x, 0.0, 1.0, xtol=1e-12) == 0.0
    assert brentq(lambda x: x - 1, 0.0, 1.0, xtol=1e-12) == 1.0


def test_no_change_of_sign() -> None:
    with pytest.raises(ValueError, match="expected different signs, found 2 at 1 and 5 at 2"):
        brentq(lambda x: x * x + 1, 1.0, 2.0, xtol=1e-12)


def test_not_found() -> None:
    with pytest.raises(RuntimeError, match="found no zero in 100 steps"):
        brentq(lambda x: math.nan if 0 < abs(x) < 1 else x + 2e-300, -1.0, 1.0, xtol=1e-12)
