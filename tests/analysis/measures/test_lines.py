"""Measures along lines of grains: first pulses, decay in two regions, where crystals part, distributions."""

from __future__ import annotations

import numpy as np
import pytest

from granwave.analysis.measures.lines import LineRecord, fit_decay, parted_at
from granwave.analysis.result.histories import first_pulses

TIME = np.linspace(0, 10e-3, 4001)


def pulse(centre: float, height: float, width: float = 1e-3) -> np.ndarray:
    """A Gaussian with this half width."""
    return height * np.exp(-4 * np.log(2) * ((TIME - centre) / width) ** 2)


def test_first_pulse_of_a_gaussian() -> None:
    speed = np.stack([pulse(3e-3, 2.0), pulse(3e-3, 2.0) + pulse(7e-3, 5.0), pulse(3e-3, 0.04)], axis=1)
    found, row = first_pulses(TIME, speed, 1.0)
    arrival = 3e-3 - 1e-3 * np.sqrt(np.log(2.0 / 0.05) / (4 * np.log(2)))
    assert found["peak_speed"][:2] == pytest.approx(2.0, rel=1e-6) and found["peak_time"][:2] == pytest.approx(3e-3)
    assert found["width"][:2] == pytest.approx(1e-3, rel=1e-4)
    assert found["arrival"][:2] == pytest.approx(arrival, rel=1e-4)
    assert np.isnan([found["arrival"][2], found["peak_speed"][2], found["width"][2]]).all() and row[2] == -1


def test_ripples_on_the_way_up_are_no_peak() -> None:
    speed = pulse(5e-3, 1.0, 4e-3) * (1 + 0.02 * np.sin(2e4 * TIME))
    found, _ = first_pulses(TIME, speed[:, None], 1.0)
    assert found["peak_time"][0] == pytest.approx(5e-3, abs=4e-4) and found["peak_speed"][0] == pytest.approx(
        1.0, abs=0.03
    )


def test_a_speed_that_never_falls_has_no_peak() -> None:
    found, _ = first_pulses(TIME, (TIME / TIME[-1])[:, None], 1.0)
    assert found["arrival"][0] == pytest.approx(0.05 * TIME[-1]) and np.isnan(found["peak_speed"][0])


@pytest.mark.parametrize("border", [0.031, 0.05, 0.0721])
def test_a_broken_line_is_found_again(border: float) -> None:
    x = np.arange(10) * 0.0125
    y = 7 * np.exp(-1.7 * x - 12.0 * np.maximum(x - border, 0))
    found = fit_decay(x, y)
    assert found is not None
    assert (found.first, found.second, found.border) == pytest.approx((1.7, 13.7, border), rel=1e-4)
    y[4] = np.nan
    again = fit_decay(x, y)
    assert again is not None and again.points == 9 and again.border == pytest.approx(border, rel=1e-4)


def test_few_points_have_no_two_regions() -> None:
    assert fit_decay(np.arange(3.0), np.ones(3)) is None
    found = fit_decay(np.arange(4.0), np.exp(-np.arange(4.0)))
    assert found is not None and found.single == pytest.approx(1.0)


def test_where_crystals_part() -> None:
    x, wide = np.arange(5) * 0.01, np.full(5, 2.0)
    assert parted_at(x, np.array([2.0, 1.95, 1.93, 1.8, 2.0]), wide) == pytest.approx(0.02)
    assert parted_at(x, np.array([2.0, np.nan, 1.99, 2.01, 2.0]), wide) is None


def test_front_speed_and_distribution() -> None:
    x = np.arange(8) * 0.01
    speeds = np.array([1.0, 1.2, 1.4, 1.1, 0.9, 1.3, 1.0, 1.25])
    line = LineRecord("a", x, x / 120.0, x, x, np.exp(-2 * x), speeds, x, left_out=2)
    assert line.front_speed == pytest.approx(120.0)
    assert line.decay is not None and line.decay.points == 6
    spread = line.distribution
    assert spread is not None and spread.mean == pytest.approx(speeds.mean()) and 0 < spread.normal_p < 1
    crooked = LineRecord("b", x, x / 120.0, x, x, np.exp(-2 * x), speeds, x, 0, straight=False)
    assert crooked.front_speed is None and crooked.decay is None and crooked.distribution is not None
