"""Numbers of the thesis model and of our second program for the confined rows of chapter 6.

The program (velocity Verlet for the equations of symmetric motion, no code shared with granwave) counts contacts from
0: its contact 20 is our 21st. It stopped at some 6 ms: of slow waves its value for contact 200 is that of the contact
where the wave was then, some 129, 142 and 154 for n = 6 and a up to 1.3e-3, and 185 for n = 7 and a = 0.
The thesis model has directions that do not turn, no contacts in the rings, and k_w with the factor 1.2.
"""

from __future__ import annotations

import dataclasses
import math

OFFSET = 1  # of our numbers of contacts from those of the program


@dataclasses.dataclass(frozen=True)
class Reference:
    """Peak forces over E* R*^2, times 1e4, at contacts 20, 50, 100, 200 (from 0); speed, m/s; decay per contact."""

    peaks: tuple[float, float, float, float]
    speed: float
    decay: float


#: Thesis model and true model, by n and a as the legends of the source print it.
REFERENCES: dict[tuple[int, float], tuple[Reference, Reference]] = {}
_TABLE = """
6 0      1.872 1.839 1.802 1.778 306.7 4.1e-4   1.601 1.582 1.552 1.535 302.1 3.8e-4
6 5.2e-4 1.426 1.417 1.408 1.400 329.9 1.3e-4   1.350 1.335 1.322 1.311 335.3 2.0e-4
6 1.3e-3 0.981 0.963 0.958 0.953 344.3 1.1e-4   0.880 0.869 0.864 0.858 352.9 1.3e-4
6 2.1e-3 0.834 0.785 0.758 0.729 357.1 7.2e-4   0.663 0.650 0.650 0.650 368.1 1e-5
7 0      2.656 2.442 2.123 1.684 426.2 2.8e-3   2.613 2.416 2.121 1.699 430.3 2.6e-3
7 5.0e-4 2.538 2.311 2.008 1.579 462.1 2.6e-3   2.408 2.181 1.873 1.416 471.2 2.9e-3
7 1.3e-3 1.927 1.890 1.852 1.782 500.4 3.9e-4   1.835 1.758 1.669 1.516 513.0 9.8e-4
7 2.0e-3 1.607 1.584 1.583 1.580 520.3 1.7e-5   1.496 1.455 1.432 1.388 536.3 3.1e-4
8 0      3.259 2.550 1.695 0.749 472.5 8.2e-3   3.208 2.499 1.649 0.717 475.4 8.3e-3
8 4.8e-4 2.527 2.292 1.990 1.561 549.8 2.5e-3   2.477 2.227 1.907 1.458 560.6 2.8e-3
8 1.2e-3 1.717 1.673 1.642 1.584 591.6 3.6e-4   1.685 1.624 1.578 1.496 608.0 5.4e-4
8 1.9e-3 1.394 1.353 1.350 1.343 619.2 4.9e-5   1.316 1.266 1.259 1.247 637.6 9.8e-5
9 0      3.260 3.235 3.193 3.112 590.4 2.6e-4   3.214 3.202 3.182 3.141 596.7 1.3e-4
9 4.6e-4 2.506 2.496 2.492 2.484 626.9 3.4e-5   2.454 2.443 2.438 2.428 638.6 4e-5
9 1.2e-3 1.656 1.620 1.620 1.620 660.6 1e-6     1.587 1.547 1.547 1.547 676.5 1e-6
9 1.9e-3 1.288 1.222 1.221 1.221 690.1 1e-6     1.225 1.154 1.153 1.153 708.8 1e-6
"""
for _line in _TABLE.strip().splitlines():
    _n, _a, *_values = map(float, _line.split())
    _models = tuple(Reference((one[0], one[1], one[2], one[3]), one[4], one[5]) for one in (_values[:6], _values[6:]))
    REFERENCES[int(_n), _a] = (_models[0], _models[1])

#: Diameter of small spheres, radius of the tube (over D), cos(theta), eps, eta, and gamma with the source's factor and
#: in the tube, of rows of equal spheres, by n.
GEOMETRY: dict[int, tuple[float, float, float, float, float, float, float]] = {
    6: (0.66667, 1.00000, 0.60000, 0.2963, 0.2494, 2.0785, 2.5645),
    7: (0.46383, 0.76642, 0.68314, 0.0998, 0.3071, 1.7337, 2.1136),
    8: (0.34315, 0.61991, 0.74452, 0.0404, 0.3419, 1.4912, 1.8006),
    9: (0.26495, 0.51980, 0.79055, 0.0186, 0.3596, 1.3103, 1.5698),
}
#: E*, Pa, E* R*^2, N, sqrt(m_b/k_bb) in SI, and v sqrt(pi/2 rho (1 - nu^2)/E) of 1 m/s, of beads of 15 mm.
E_STAR, FORCE_UNIT, TIME_UNIT, SPEED_NUMBER = 63.187e9, 888567.0, 1.7063e-6, 3.2504e-4
#: Speed in the source's unit of its model without precompression, by n (figure 6.4, whose axis is 0.04 to 0.085).
SLOWEST = {6: 0.0348, 7: 0.0484, 8: 0.0538, 9: 0.0672}


def reference_of(n: int, a: float) -> tuple[Reference, Reference] | None:
    """Thesis model and true model of a row at 1 m/s; None if it is not among them."""
    near = (both for (m, b), both in REFERENCES.items() if m == n and math.isclose(a, b, rel_tol=1e-6, abs_tol=1e-9))
    return next(near, None)
