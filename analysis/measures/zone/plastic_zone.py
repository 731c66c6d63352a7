"""Contacts and spheres that have yielded, size of the plastic zone, and range of the contact law.

A contact has yielded when its largest overlap passed alpha_y (elastoplastic, thornton) or when it was loaded
at all (bilinear); with hertz none yields. A dent from before the run must have grown in it. The elasto-plastic law was
fitted up to an overlap of about 0.2 R*; from 0.1 R* on the plastic zones of one sphere's contacts may begin to touch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

LAW_LIMIT = 0.2  # of R*: the largest overlap that the elasto-plastic law was fitted to
HALF_LAW_LIMIT = 0.1  # of R*


@dataclass(frozen=True)
class PlasticZone:
    """The spheres with at least one contact that yielded.

    Attributes
    ----------
    n_spheres
        How many.
    volume
        Their volume, m^3.
    depth
        From the struck sphere's centre to the deepest of their centres, m.
    radius
        Largest lateral distance of their centres from the impact axis, m.
    """

    n_spheres: int
    volume: float
    depth: float
    radius: float


def plastic_zone(
    positions: NDArray[np.float64],
    radii: NDArray[np.float64],
    plastic: NDArray[np.bool_],
    origin: NDArray[np.float64],
) -> PlasticZone:
    """The plastic zone of a packing.

    Parameters
    ----------
    positions
        At the start: (n_spheres, 3), m.
    radii
        (n_spheres,), m.
    plastic
        Which spheres belong to it: (n_spheres,).
    origin
        Centre of the struck sphere at the start: (3,), m.
    """
    offset = positions[plastic] - origin
    return PlasticZone(
        n_spheres=int(np.count_nonzero(plastic)),
        volume=float(np.sum(4 / 3 * np.pi * radii[plastic] ** 3)),
        depth=float(np.max(offset[:, 2], initial=0.0)),
        radius=float(np.max(np.hypot(offset[:, 0], offset[:, 1]), initial=0.0)),
    )
