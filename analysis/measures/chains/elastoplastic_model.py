"""The source's model of an elasto-plastic chain after a pulse: peak force and dissipation (thesis 2.2.3, 2.2.4).

With I the impulse in units of E* R*^2 tau, n the contact from 1 and x/R* = 4n:

    F / (E* R*^2 I) = a exp(-b (n - 1))   up to contact 7, then   C / (4n)        (2.25, 2.26)
    e               = d0 + d1 F + d2 F^2                                          (2.28)

The source prints b as if per R*; only per contact does it agree with its figures.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from granwave._contact_laws import ContactLaw

Array = NDArray[np.float64]

START, DECAY, INVERSE = 3.74e-2, 0.256, 0.268  # a, b per contact, C
SWITCH = 7  # contact: x_t/R* = 28
QUADRATIC = (1.23e-4, -3.63e-7, 1.86e-8)  # d0, d1, d2 in J, J/N, J/N^2, for brass of R = 4.76 mm
FITTED_TO = 1e3  # N: how far we fit the law with the same form
SPACING = 4.0  # R* from contact to contact

_POINTS = 500
_WIDEST = 1.0  # of R*: overlaps of the table that a force is looked up in


def peak_force(contact: Array) -> Array:
    """Peak force over E* R*^2 I at contacts (from 1)."""
    return np.where(contact <= SWITCH, START * np.exp(-DECAY * (contact - 1)), INVERSE / (SPACING * contact))


def dissipation_of(force: Array | float) -> Array:
    """Dissipated by a contact of that peak force, N, by 2.28 with the source's constants, J."""
    return np.asarray(np.polynomial.polynomial.polyval(force, QUADRATIC), dtype=np.float64)


def summed_dissipation(contacts: int, peak: float) -> Array:
    """Dissipated up to each contact, summed contact by contact: (contacts,), J.

    Parameters
    ----------
    peak
        E* R*^2 I, N.
    """
    return np.cumsum(dissipation_of(peak * peak_force(np.arange(1.0, contacts + 1))))


def integrated_dissipation(contacts: int, peak: float) -> Array:
    """The same with the integral over distance in place of the sum, from contact 1 on (thesis 2.31): (contacts,), J."""
    n = np.arange(1.0, contacts + 1)
    d0, d1, d2 = QUADRATIC
    early, late = np.minimum(n, SWITCH), np.maximum(n, SWITCH)
    f, c = START * peak, INVERSE / SPACING * peak
    return (
        d0 * (n - 1)
        + d1 * (f / DECAY * (1 - np.exp(-DECAY * (early - 1))) + c * np.log(late / SWITCH))
        + d2 * (f**2 / (2 * DECAY) * (1 - np.exp(-2 * DECAY * (early - 1))) + c**2 * (1 / SWITCH - 1 / late))
    )


def quadratic_of(law: ContactLaw, largest: float = FITTED_TO) -> Array:
    """d0, d1, d2 of a least-squares parabola through what the law dissipates, from first yield to a peak force (N)."""
    force = np.linspace(law.yield_force, largest, _POINTS)
    fit = np.polynomial.Polynomial.fit(force, dissipation_at(law, force), 2)
    return np.asarray(fit.convert().coef, dtype=np.float64)


def dissipation_at(law: ContactLaw, force: Array) -> Array:
    """Return the energy that a contact of that peak force (N) has dissipated, J."""
    overlap = np.geomspace(law.yield_overlap, _WIDEST * law.effective_radius, 4000)
    peak, lost = law.loading_force(overlap), law.dissipated_energy(overlap)
    return np.asarray(PchipInterpolator(peak, lost)(force))
