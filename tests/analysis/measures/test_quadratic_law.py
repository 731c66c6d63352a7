"""Dissipation against velocity: the quadratic law from a few points."""

from __future__ import annotations

import numpy as np
import pytest

from granwave.analysis.measures.impact import quadratic_law

VELOCITY = np.array([4.0, 8.0, 16.0])
CONSTANTS = (2.0, 3.0, 0.45)


@pytest.mark.filterwarnings("error")
def test_three_points_have_no_scatter():
    law = quadratic_law(VELOCITY, np.polynomial.polynomial.polyval(VELOCITY, CONSTANTS))
    np.testing.assert_allclose(law.constants, CONSTANTS, rtol=1e-10)
    assert np.isnan(law.deviations).all()


def test_two_points_are_too_few():
    with pytest.raises(ValueError, match="found 2 points, expected at least 3"):
        quadratic_law(VELOCITY[:2], VELOCITY[:2])
