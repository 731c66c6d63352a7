"""Zero of a measured overlap: the reading at which the bodies touch.

A displacement gauge is set to zero near first contact. If it reads z at first contact, z is
subtracted from every overlap, and from the largest overlap before an unloading.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from granwave._contact_laws import ContactLaw
from granwave.analysis.contact_law.curves import Curve

ZERO = "zero"

_NO_FORCE = 1e-3  # force / largest force below which the bodies do not touch
_SURE_FORCE = 0.05  # force / largest force at which they touch
# reach of zeros below the first reading with a force, over its distance from the largest overlap
_REACH = 0.5
_TRIALS = 200

Array = NDArray[np.float64]


def shifted(curve: Curve, zero: float) -> Curve:
    """Return a curve with its overlaps reduced by the reading at first contact, m."""
    return dataclasses.replace(curve, overlap=curve.overlap - zero, peak=curve.peak - zero)


def touching(curve: Curve) -> NDArray[np.bool_]:
    """Return True for rows with a force large enough to indicate contact: (n,)."""
    return np.abs(curve.force) > _NO_FORCE * np.abs(curve.force).max(initial=0.0)


def zero_range(curve: Curve) -> tuple[float, float]:
    """Return the smallest and the largest reading that may be first contact, m."""
    loading = curve.loading & touching(curve)
    if not loading.any():
        return 0.0, 0.0
    overlap = curve.overlap[loading]
    sure = curve.force[loading] >= _SURE_FORCE * np.abs(curve.force).max()
    first = float(overlap.min())
    largest = float(overlap.max())
    latest = float(overlap[sure].min()) if sure.any() else largest
    return first - _REACH * (largest - first), latest


def estimated_zero(curve: Curve, law: ContactLaw) -> float:
    """Return an initial estimate of the reading at first contact from the shape of first loading,
    m.

    With this zero the ratio of the measured forces to the forces of the law varies least. The
    magnitude of the ratio does not matter, so that the law need not have the yield strength of the
    measured material.
    """
    loading = curve.loading & touching(curve)
    overlap = curve.overlap[loading]
    force = curve.force[loading]
    low, high = zero_range(curve)
    if not low < high:
        return 0.0

    def spread(zero: float) -> float:
        ratio = law.loading_force(np.maximum(overlap - zero, 0.0)) / force
        middle = float(np.median(ratio))
        if not middle > 0:
            return np.inf
        return float(np.mean(np.abs(ratio / middle - 1)))

    trials = np.linspace(low, high, _TRIALS)
    best = int(np.argmin([spread(zero) for zero in trials]))
    around = (trials[max(best - 1, 0)], trials[min(best + 1, _TRIALS - 1)])
    return float(minimize_scalar(spread, bounds=around, method="bounded").x)
