"""Square packings that are not ideal: twin sensors, scattered diameters; a chain on a load cell."""

from __future__ import annotations

import pytest

from granwave.analysis.measures.hertz_lattices import discrete_width


def test_width_of_the_wave_of_the_chain_itself() -> None:
    assert discrete_width() == pytest.approx(1.5791, abs=1e-4)  # runs of chains give 1.579
