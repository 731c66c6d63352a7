"""Contact of cylinders along a line, beside scipy's Lambert function, and the logarithm that it uses."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import lambertw

from granwave._contact_laws import LineContact, logarithm

D, LENGTH = 4.76e-3, 9.525e-3
BRASS = LineContact(youngs_modulus=(115e9, np.inf), poisson_ratio=(0.3, 0.0), diameter=D, length=LENGTH)
V = (1 - 0.3**2) / (np.pi * 115e9)


def test_logarithm():
    x = np.concatenate([np.geomspace(1e-300, 1e300, 20001), np.linspace(0.5, 2, 20001)])
    exact = np.log(x)
    assert np.all(np.abs(logarithm(x) - exact) <= 1.0 * np.spacing(np.abs(exact)))


def test_published_check_values():
    """Brass, 4.76 mm x 9.525 mm, on a rigid wall, 1 um deep: 266.272 N and 2.86441e8 N/m."""
    assert BRASS.force(1e-6) == pytest.approx(266.272, abs=5e-4)
    assert BRASS.stiffness(1e-6) == pytest.approx(2.86441e8, rel=2e-6)


@pytest.mark.parametrize("overlap", [1e-24, 1e-15, 1e-9, 1e-6, 1e-4, 1e-3, 0.0099])
def test_closed_form(overlap):
    s = overlap * D / (2 * LENGTH**2)
    assert BRASS.force(overlap) == pytest.approx(overlap * LENGTH / (V * abs(lambertw(-s / np.e, -1).real)), rel=1e-12)
    force = BRASS.force(overlap)
    assert force * V / LENGTH * (1 - np.log(V * force * D / (2 * LENGTH**3))) == pytest.approx(overlap, rel=1e-13)


def test_energy_and_stiffness_follow_from_the_force():
    for overlap in (1e-7, 1e-5, 5e-3):
        work = quad(lambda a: float(BRASS.force(a)), 0, overlap, epsabs=0, epsrel=1e-12)[0]
        assert BRASS.energy(overlap) == pytest.approx(work, rel=1e-10)
        h = 1e-4 * overlap
        slope = (BRASS.force(overlap + h) - BRASS.force(overlap - h)) / (2 * h)
        assert BRASS.stiffness(overlap) == pytest.approx(slope, rel=1e-7)


def test_no_contact():
    assert BRASS.force([0.0, -1e-6, 1e-26, 1e-300]).tolist() == [0.0] * 4
    assert BRASS.energy([0.0, -1e-6, 1e-26]).tolist() == [0.0] * 3


def test_two_bodies():
    pair = LineContact(youngs_modulus=(70e9, 210e9), poisson_ratio=(0.3, 0.3), diameter=D, length=LENGTH)
    both = (1 - 0.3**2) / np.pi * (1 / 70e9 + 1 / 210e9)
    s = 1e-6 * D / (2 * LENGTH**2)
    assert pair.force(1e-6) == pytest.approx(1e-6 * LENGTH / (both * abs(lambertw(-s / np.e, -1).real)), rel=1e-12)
    with pytest.raises(ValueError, match="must be positive"):
        LineContact(youngs_modulus=(1e9, 1e9), poisson_ratio=(0.3, 0.3), diameter=0.0, length=1.0)


def test_batches_have_the_same_bits():
    """From none over the foot of a wave to beyond the end of the law, in batches that are full and not."""
    rng = np.random.default_rng(1)
    ends = [0.0, -1e-6, np.nan, 1e-26, 1.0001e-25, BRASS.largest_overlap, 2 * BRASS.largest_overlap]
    overlap = np.concatenate([ends, np.geomspace(1e-24, 1.0, 997) * BRASS.largest_overlap, rng.uniform(0, 1e-6, 200)])
    for part in (overlap, overlap[:3], rng.permutation(overlap)):
        force, stiffness = BRASS.in_batches(part)
        assert np.array_equal(force, BRASS.force(part), equal_nan=True)
        assert np.array_equal(stiffness, BRASS.stiffness(part), equal_nan=True)
