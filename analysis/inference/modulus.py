"""Young's modulus from the motion: strains tell forces up to a factor, accelerations tell them without.

The right-hand side of the stress is proportional to the moduli, that of the motion is not. The factor of the moduli is
the minimum of chi^2, the sum of squares of the errors of strains and accelerations over their standard deviations, with
the forces that are best for each factor. These forces are not held within the cone of friction here: noise could push
those on its border inwards only, which biases the modulus upwards by as much as its standard error. An additional
column of the least squares, in place of the search, would be biased low: it takes the strains as free of errors.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
from scipy import optimize, sparse

from granwave.analysis.inference.equations import Equations
from granwave.analysis.inference.grains import Array, Grains
from granwave.lammps_inputs.errors import InputError

_WIDTH = math.log(30.0)  # of the first scan about the first guess, each way
_SCANNED = 9
_WIDENED = 4  # times that a scan is moved if the minimum lies at its end
_ACCURACY = 1e-5  # of the logarithm of the factor
_STEP = 0.02  # of the logarithm, for the curvature


@dataclasses.dataclass(frozen=True, eq=False)
class ModulusSearch:
    """Search for the factor of the moduli.

    Attributes
    ----------
    factors, chi2
        All trials, rising factors: (n,).
    factor
        The best.
    curvature
        Second derivative of chi^2 by the logarithm of the factor, at the best.
    error
        Standard error of the logarithm of the factor.
    """

    factors: Array
    chi2: Array
    factor: float
    curvature: float
    error: float = 0.0

    def with_error(self, scale: float) -> ModulusSearch:
        """Return the search with the standard error: chi^2 grows by ``scale`` at that distance from the minimum."""
        error = math.sqrt(2 * scale / self.curvature) if self.curvature > 0 else math.inf
        return dataclasses.replace(self, error=error)


def free_misfit(matrix: sparse.csr_array, data: Array) -> float:
    """Return the least |matrix f - data|^2 of any forces f, within the cone or not."""
    both = np.concatenate([matrix.toarray(), data[:, None]], axis=1)
    triangle = np.asarray(np.linalg.qr(both, mode="r"))
    return float(triangle[-1, -1] ** 2) if both.shape[0] >= both.shape[1] else 0.0


def refuse_unknowable(grains: Grains, equations: Equations) -> None:
    """Raise InputError if stresses were measured, or no acceleration or weight tells the modulus."""
    if grains.compliance is None:
        raise InputError('infer.modulus: found "find" with measured stresses, which need no modulus; expected strains')
    if not len(equations.motion_data) or not np.any(equations.motion_data):
        raise InputError(
            'infer.modulus: found "find", but nothing to find it from: strains tell forces up to a factor; expected '
            "accelerations other than zero (or a weight, infer.gravity), or material.youngs_modulus"
        )


def find_modulus(equations: Equations, chi2: Callable[[float], float]) -> ModulusSearch:
    """Find the factor of the moduli with the least chi^2.

    Raises
    ------
    InputError
        No minimum was found.
    """
    tried: dict[float, float] = {}

    def at(logarithm: float) -> float:
        if logarithm not in tried:
            tried[logarithm] = chi2(math.exp(logarithm))
        return tried[logarithm]

    size = float(np.linalg.norm(equations.stress_data))
    centre = math.log(float(np.linalg.norm(equations.motion_data)) / size) if size > 0 else 0.0
    grid = np.linspace(-_WIDTH, _WIDTH, _SCANNED)
    for _ in range(_WIDENED):
        values = [at(centre + float(shift)) for shift in grid]
        best = int(np.argmin(values))
        if 0 < best < len(grid) - 1:
            break
        centre += float(grid[best])
    else:
        raise InputError(
            'infer.modulus: found "find", but chi^2 falls to the end of the search: motion and strains do not belong '
            "together; check the units of strains, accelerations and density, or give material.youngs_modulus"
        )
    low, high = centre + float(grid[best - 1]), centre + float(grid[best + 1])
    found = optimize.minimize_scalar(at, bounds=(low, high), method="bounded", options={"xatol": _ACCURACY})
    logarithm = float(found.x)
    curvature = (at(logarithm + _STEP) - 2 * at(logarithm) + at(logarithm - _STEP)) / _STEP**2
    logarithms = np.array(sorted(tried))
    return ModulusSearch(
        np.exp(logarithms), np.array([tried[one] for one in logarithms.tolist()]), math.exp(logarithm), curvature
    )


def search_near(chi2: Callable[[float], float], factor: float, width: float) -> float:
    """Return the best factor near another, within ``width`` of its logarithm each way."""
    centre, width = math.log(factor), min(width, _WIDTH)
    bounds = (centre - width, centre + width)
    found = optimize.minimize_scalar(
        lambda logarithm: chi2(math.exp(logarithm)), bounds=bounds, method="bounded", options={"xatol": 0.01 * width}
    )
    return math.exp(float(found.x))
