"""The rigid flat punch with a rounded edge, frictionless.

The constraint is kinematic, not a penalty: nothing to choose, no compliance of its own, no limit on the timestep. With
lumped masses the positions at the end of a step are known up to one number, that of the punch, X: a node that would be
overtaken gets the impulse ``m_i (X - X_i)/dt`` that keeps it at the punch, the punch loses their sum,

    M (X* - X) = sum_i m_i max(0, X - X_i)        X_i = u_i* + gap_i        * : without contact

which is solved exactly in a few passes (the set of touching nodes only shrinks). Impulses only push. A node that is
caught loses its relative kinetic energy, as a node of a real surface passes it on as a wave; the sum, of the order of
the mass of half a row of elements over that of the punch, is reported.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.continuum.mesh import Mesh


def punch_gap(mesh: Mesh, radius: float, taper: float) -> NDArray[np.float64]:
    """How far the punch is above each node of the top that it can touch, when its flat part is at the surface.

    Flat up to ``radius - taper``, then a quarter circle of radius ``taper``; (n_nodes_below,), m.
    """
    r = mesh.r[mesh.r < radius]
    into = np.clip(r - (radius - taper), 0.0, taper)
    return taper - np.sqrt(taper**2 - into**2)
