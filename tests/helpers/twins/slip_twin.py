"""Partial slip by many springs along the diameter of the contact circle (method of dimensionality
reduction), without the plugin.

Elastic sphere and rigid plane, in space: springs at fixed, equally spaced positions, each with an
elongation and a limit that follows from the overlap there. The program instead has a few cells that
follow the circle.
"""

from __future__ import annotations

import numpy as np


def rebound(
    *,
    modulus,
    poisson,
    density,
    radius,
    friction,
    normal,
    across,
    spin=0.0,
    springs=800,
    steps=3000,
) -> tuple[float, float, float]:
    """Velocity away from the plane, along it, m/s, and spin, rad/s, after an elastic impact.

    `across` is the velocity along x, `spin` the angular velocity about y, by which the surface
    moves at across + radius spin.
    """
    plane = modulus / (1 - poisson**2)
    shear = 2 * modulus / ((1 + poisson) * (2 - poisson))
    mass = density * 4 / 3 * np.pi * radius**3
    hertz = 4 / 3 * plane * np.sqrt(radius)
    deepest = (1.25 * mass * normal**2 / hertz) ** 0.4
    step = 3.0 * deepest / normal / steps
    width = 1.01 * np.sqrt(radius * deepest) / springs
    depth = (
        (np.arange(springs) + 0.5) * width
    ) ** 2 / radius  # overlap at which each spring comes into contact
    elongation = np.zeros(springs)
    overlap = 0.5 * step * normal
    while overlap > 0:
        normal -= step * hertz * overlap**1.5 / mass
        pressed = np.maximum(overlap - depth, 0.0)
        elongation = np.clip(
            elongation + step * (across + radius * spin),
            *(s * friction * plane / shear * pressed for s in (-1, 1)),
        )
        impulse = -2 * shear * width * elongation.sum() * step
        across = across + impulse / mass
        spin = spin + 2.5 * impulse / (mass * radius)
        overlap += step * normal
    return -normal, across, spin


def forces(overlap, slip, *, modulus, shear, radius, friction, springs=800):
    """Tangential force along a path of overlaps (n,), m, and slips of the steps, (n, 2), m: (n, 2),
    N.

    `modulus` is E*, `shear` 4 G*, `radius` R*.
    """
    width = 1.01 * np.sqrt(radius * np.max(overlap)) / springs
    depth = ((np.arange(springs) + 0.5) * width) ** 2 / radius
    elongation = np.zeros((springs, 2))
    found = []
    for a, s in zip(overlap, slip, strict=True):
        elongation = elongation + s
        most = friction * modulus / shear * np.maximum(a - depth, 0.0)
        size = np.linalg.norm(elongation, axis=1)
        elongation *= np.minimum(1.0, most / np.maximum(size, 1e-300))[:, None]
        found.append(-2 * shear * width * elongation.sum(axis=0))
    return np.array(found)
