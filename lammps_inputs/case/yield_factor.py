"""Contact pressure at first yield under Hertz's pressure: ``p_y = C sigma_y``.

On the axis below the centre of a Hertzian contact of radius a and peak pressure p0, at depth z = zeta a
(K. L. Johnson, Contact Mechanics, 1985, eq. 3.45):

    sigma_z / p0 = -1 / (1 + zeta^2)
    sigma_r / p0 = -(1 + nu) (1 - zeta arctan(1/zeta)) + 1 / (2 (1 + zeta^2))

The von Mises stress there is |sigma_z - sigma_r|; for nu >= 0 its largest value over the depth is the largest
in the body. Hence C = 1 / max |sigma_z - sigma_r| with p0 = 1: 1.613 at nu = 0.30; the
default of the laws is 1.60.
"""

from __future__ import annotations

import numpy as np

DEFAULT_YIELD_FACTOR = 1.60
FITTED_POISSON_RATIO = 0.30
_DEEPEST = 3.0  # in contact radii; the largest stress lies above 0.7 for every Poisson's ratio


def hertz_von_mises_yield_factor(poisson_ratio: float) -> float:
    """Return the exact C for a Poisson's ratio (above -1, below 0.5)."""
    from scipy.optimize import minimize_scalar  # takes longer to load than most commands need

    def stress(depth: float | np.ndarray) -> np.ndarray:
        zeta = np.maximum(depth, 1e-300)
        vertical = -1.0 / (1.0 + zeta**2)
        radial = -(1.0 + poisson_ratio) * (1.0 - zeta * np.arctan(1.0 / zeta)) + 0.5 / (1.0 + zeta**2)
        return np.abs(vertical - radial)

    grid = np.linspace(0.0, _DEEPEST, 301)
    start = int(np.argmax(stress(grid)))
    bounds = (grid[max(start - 1, 0)], grid[min(start + 1, grid.size - 1)])
    refined = minimize_scalar(
        lambda depth: -float(stress(depth)), bounds=bounds, method="bounded", options={"xatol": 1e-10}
    )
    return 1.0 / max(-float(refined.fun), float(stress(grid[start])))
