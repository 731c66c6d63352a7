"""Progress of finite-element runs."""

from __future__ import annotations

import math

import pytest

from granwave.workflows.finite_elements.runner import advance, digits_of


@pytest.mark.parametrize("total", [6.5, 0.8, 0.0123, 2e-5])
def test_a_bar_ends_at_its_total(total):
    """Whatever the size of the total, and where the last place lies beyond it."""
    digits, shown = digits_of(total), 0.0
    end = round(total, digits)
    assert end == pytest.approx(total, rel=0.01)
    places = [0.1 * total * n for n in range(10)] + [total, 1.4 * total]
    for place in places:
        step = advance(shown, place, end, digits)
        assert step >= 0
        shown += step
        assert shown <= end * (1 + 1e-9)
    assert math.isclose(shown, end)


def test_a_bar_without_a_total_goes_on():
    assert digits_of(None) == 2
    assert advance(1.0, 3.456, None, 2) == 2.46
    assert advance(5.0, 3.0, None, 2) == 0
