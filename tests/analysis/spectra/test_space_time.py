"""Space-time transform against a chain whose motion is known."""

import numpy as np
import pytest
from scipy.special import jv

from granwave.analysis.measures.line_waves import space_time_transform


def test_ridge_is_the_band_of_the_chain():
    """A struck line of masses, v_n = J_2n-2 + J_2n of 2 w t: the ridge is w |sin(kh/2)|/pi, within 1 %."""
    unit, h, n = 5e4, 0.01, 100
    time = np.linspace(0, 1.6e-3, 400)
    tau = 2 * unit * time[:, None]
    order = np.arange(n)
    velocity = jv(2 * order, tau) + jv(2 * order + 2, tau)
    k = np.linspace(30, 250, 12)
    found = space_time_transform(time, h * order, velocity, k, np.linspace(0, 18e3, 721))
    theory = unit * np.sin(k * h / 2) / np.pi
    np.testing.assert_allclose(found.ridge(), theory, rtol=0.01)
    backwards = space_time_transform(time, h * order, velocity, -k[::-1], np.linspace(0, 18e3, 181))
    raw = space_time_transform(time, h * order, velocity, np.linspace(-250, 250, 41), np.linspace(0, 18e3, 181))
    assert raw.amplitude[:, :18].max() < 0.05 * raw.amplitude[:, 23:].max()  # it travels to larger x alone
    assert backwards.amplitude.max() == 1


def test_uneven_places_are_refused():
    with pytest.raises(ValueError, match="places with uneven steps"):
        space_time_transform(np.arange(4.0), np.array([0, 1, 3.0]), np.ones((4, 3)), np.arange(2.0), np.arange(2.0))
