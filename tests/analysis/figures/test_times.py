"""Units of times on figures: µs up to 5 ms, ms beyond."""

from __future__ import annotations

import numpy as np
import pytest

from granwave.analysis.figures.scales import long_times_in_ms
from granwave.analysis.figures.series import against_time, panels
from granwave.analysis.formatting.numbers import instant, size_text


@pytest.mark.parametrize(
    ("end", "title", "last"), [(4e-3, "Time (µs)", "4000"), (12e-3, "Time (ms)", "12")]
)
def test_long_records_are_shown_in_milliseconds(end: float, title: str, last: str) -> None:
    """The tick at the end of the record uses the unit of the axis title."""
    figure, axes = panels(2.0)
    time = np.linspace(0.0, end, 50)
    against_time(axes, time, time)
    long_times_in_ms(figure)
    assert axes.get_xlabel() == title
    axes.set_xticks([1e6 * end])
    figure.canvas.draw()
    assert [tick.get_text() for tick in axes.get_xticklabels()] == [last]


def test_other_axes_keep_their_units() -> None:
    """Lengths in µm, and axes without a unit, are not times."""
    figure, axes = panels(2.0)
    axes.plot([0, 1e4], [0, 1e4])
    axes.set(xlabel="Overlap (µm)", ylabel="Force")
    long_times_in_ms(figure)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("Overlap (µm)", "Force")


@pytest.mark.parametrize(
    ("seconds", "text"), [(3.14e-4, "314 µs"), (1.234e-5, "12.3 µs"), (0.0125, "12.5 ms")]
)
def test_instants(seconds: float, text: str) -> None:
    assert instant(seconds) == text


def test_size_of_a_packing() -> None:
    assert size_text([24, 24, 12]) == "24 × 24 × 12"
