"""Relaxation modulus of the soft cylinders, equation 7 of the source; moduli in MPa, times in ms.

The source says that its time constants are seconds; its effective moduli follow only with ms.
"""

import numpy as np

LONG = 15.7
TERMS = ((253.1, 2.64), (1320.4, 0.55))
INSTANT = LONG + sum(size for size, _ in TERMS)
MEGA = 1e6  # from MPa
SAME = 1e-6  # relative


def secant(rise, scale=1.0):
    """Ratio of stress to strain, MPa, after the strain has risen at a constant rate for a time in
    ms.
    """
    terms = ((size, scale * tau) for size, tau in TERMS)
    return LONG + sum(size * tau / rise * -np.expm1(-rise / tau) for size, tau in terms)


def is_of_equation(case):
    """Return True if the grains have the instantaneous modulus of equation 7."""
    return abs(case.material.youngs_modulus / (MEGA * INSTANT) - 1) < SAME
