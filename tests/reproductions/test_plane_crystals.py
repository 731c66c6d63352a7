"""Formulas of the source on lateral constraints."""

from __future__ import annotations

import numpy as np
import pytest

from granwave.analysis.studies.registry import load_study
from tests.helpers.programs.scripts import FOLDER

source = load_study(str(FOLDER / "plane_crystals" / "source.py"))


def test_stress_of_a_pulse() -> None:
    """The hereditary integral of equation 7 by the trapezoidal rule."""
    time, strain, stress = source.pulse(2.0)
    rate = np.gradient(strain, time)
    when = len(time) // 3
    ago = time[when] - time[: when + 1]
    relaxing = source.LONG + sum(size * np.exp(-ago / tau) for size, tau in source.TERMS)
    assert stress[when] == pytest.approx(
        np.trapezoid(relaxing * rate[: when + 1], time[: when + 1]), rel=1e-4
    )


def test_impulses_of_pulses() -> None:
    """A pulse too short to relax has the instantaneous modulus and the impulse of a linear law; the
    printed moduli give impulses of the printed size.
    """
    instant = source.LONG + sum(size for size, _ in source.TERMS)
    assert source.modulus_of_pulse(1e-3) == pytest.approx(instant, rel=2e-3)
    duration, gained = source.impulse_of_pulse(740.0)
    assert (duration, gained) == pytest.approx((1.562, -1.516), rel=2e-3)
    assert [abs(row.theory / row.source - 1) < 0.3 for row in source.impulse_rows()] == [True, True]
