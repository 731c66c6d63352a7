"""Complex wave vectors: attenuation of waves inside gaps.

Along a direction in which planes of the lattice lie h apart, all phases are powers of lambda = exp(i s h), and

    sum_m K_m lambda^m u = omega^2 M u

is an eigenvalue problem in lambda at a given frequency. |lambda| = 1 are waves; |lambda| < 1 falls by -ln |lambda| from
plane to plane. Small cells only: the whole spectrum of a dense matrix is found at each frequency.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.linalg import eig

from granwave.analysis.spectra.network import Array
from granwave.analysis.spectra.stiffness import Stiffness

MOST_UNKNOWNS = 80  # of the linear problem, which is solved at some hundred frequencies
_WHOLE = 1e-6  # by which the places of planes may miss multiples of their spacing
_WAVE = 1e-6  # of ln |lambda|: a wave that does not fall
_SMALLEST, _LARGEST = 1e-12, 1e12  # of |lambda|; beyond are the infinite ones of a singular pencil


@dataclasses.dataclass(frozen=True, eq=False)
class ComplexBands:
    """Waves and decaying fields along a direction.

    Attributes
    ----------
    direction
        Unit vector: (3,).
    spacing
        Distance h of the planes, m.
    frequency
        (n_frequencies,), Hz.
    attenuation
        -ln |lambda| of all that do not grow, rising along each row; NaN where there are fewer: (n_frequencies, n).
    phase
        arg lambda of the same, rad.
    """

    direction: Array
    spacing: float
    frequency: Array
    attenuation: Array
    phase: Array

    @property
    def least(self) -> Array:
        """Smallest attenuation from plane to plane; 0 where there are waves: (n_frequencies,)."""
        return np.asarray(np.nan_to_num(self.attenuation[:, 0], nan=np.inf))


def plane_spacing(stiffness: Stiffness, direction: Array) -> float:
    """Return the distance of the planes of the lattice across a direction, m; 0 if they have none."""
    places = np.abs(stiffness.shifts @ direction)
    size = np.linalg.norm(stiffness.network.periods, axis=1).max()
    places = places[places > _WHOLE * size]
    if not len(places):
        return 0.0
    spacing = float(places.min())
    for place in np.unique(places):  # Euclid's algorithm
        a, b = float(place), spacing
        while b > 10 * _WHOLE * size:
            a, b = b, abs(a - b * round(a / b))
        spacing = a
    numbers = places / spacing
    return spacing if np.abs(numbers - np.round(numbers)).max() < 100 * _WHOLE else 0.0


def complex_bands(stiffness: Stiffness, start: Array, direction: Array, frequency: Array) -> ComplexBands | None:
    """Find the complex wave vectors along a direction from a wave vector, rad/m, at frequencies (n,), Hz.

    Returns
    -------
    ComplexBands or None
        None if the cell is too large, or the direction has no planes.
    """
    spacing = plane_spacing(stiffness, direction)
    if not spacing:
        return None
    numbers = np.rint(stiffness.shifts @ direction / spacing).astype(int)
    most, n = int(np.abs(numbers).max()), stiffness.network.n_freedoms
    if 2 * most * n > MOST_UNKNOWNS:
        return None
    own, others = stiffness._dense
    parts = {m: np.zeros((n, n), dtype=np.complex128) for m in range(-most, most + 1)}
    parts[0] += own
    for number, shift, one in zip(numbers.tolist(), stiffness.shifts, others, strict=True):
        phased = one * np.exp(1j * float(start @ shift))
        parts[number] += phased
        parts[-number] += phased.conj().T
    found = [_solve(parts, most, n, (2 * np.pi * one) ** 2) for one in frequency]
    width = max(len(one) for one in found)
    values = np.full((len(found), width), np.nan, dtype=np.complex128)
    for row, one in enumerate(found):
        values[row, : len(one)] = one
    with np.errstate(invalid="ignore"):
        attenuation = np.maximum(-np.log(np.abs(values)), 0.0)
        attenuation[attenuation < _WAVE] = 0.0
    return ComplexBands(direction, spacing, frequency, attenuation, np.angle(values))


def _solve(parts: dict[int, np.ndarray], most: int, n: int, square: float) -> np.ndarray:
    """Return the lambda that do not grow, by rising attenuation."""
    size = 2 * most * n
    scale = max(float(np.abs(parts[0]).max()), square)
    left, right = np.zeros((size, size), dtype=np.complex128), np.eye(size, dtype=np.complex128)
    left[: size - n, n:] = np.eye(size - n)
    for m in range(-most, most):
        block = parts[m] - (square * np.eye(n) if m == 0 else 0.0)
        left[size - n :, (m + most) * n : (m + most + 1) * n] = -block / scale
    right[size - n :, size - n :] = parts[most] / scale
    pair = eig(left, right, right=False, homogeneous_eigvals=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        values = pair[0] / pair[1]
    size_of = np.abs(values)
    kept = values[np.isfinite(size_of) & (size_of > _SMALLEST) & (size_of < _LARGEST) & (size_of <= 1 + _WAVE)]
    return kept[np.argsort(-np.abs(kept), kind="stable")]
