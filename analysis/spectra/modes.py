"""Modes of a finite packing: frequencies, participation, density of states.

Participation ratio of a mode with the energies e_i of its grains: (sum e)^2/(n sum e^2); 1: all grains move alike,
1/n: one moves. The density of states of a large packing is that of its lowest modes; for the whole range, its moments
over Chebyshev polynomials are found with random vectors (kernel polynomial method, doi:10.1103/RevModPhys.78.275).
"""

from __future__ import annotations

import dataclasses

import numpy as np

from granwave.analysis.spectra.bands import _ZERO, growing, lowest, who_moves
from granwave.analysis.spectra.defaults import MOST_MODES
from granwave.analysis.spectra.network import Array, Network
from granwave.analysis.spectra.stiffness import Stiffness

ALL_UP_TO = 1500  # degrees of freedom: all modes of smaller packings are found
_BINS, _MOMENTS, _VECTORS, _SEED = 120, 240, 12, 1


@dataclasses.dataclass(frozen=True, eq=False)
class Modes:
    """Modes of a finite packing.

    Attributes
    ----------
    network
        The packing.
    square
        omega^2, rising: (n_modes,), s^-2.
    shape
        Displacements and rotations of unit kinetic energy: (n_freedoms, n_modes), kg^-1/2 (rotations: kg^-1/2 m^-1).
    participation
        Participation ratios: (n_modes,).
    density_frequency, density
        Density of states, a share of all modes for each Hz, and its frequencies, Hz: (n,).
    largest
        Upper bound of omega^2, s^-2.
    """

    network: Network
    square: Array
    shape: Array
    participation: Array
    density_frequency: Array
    density: Array
    largest: float

    @property
    def n_floppy(self) -> int:
        """Number of modes that meet no resistance, among those that were found."""
        return int(np.count_nonzero(self.square <= _ZERO * self.largest))

    @property
    def frequency(self) -> Array:
        """Frequencies: (n_modes,), Hz; 0 where nothing resists, NaN where a motion grows by itself."""
        zero = _ZERO * self.largest
        hertz = np.sqrt(np.maximum(self.square, 0.0)) / (2 * np.pi)
        return np.where(self.square < -zero, np.nan, np.where(self.square <= zero, 0.0, hertz))

    @property
    def complete(self) -> bool:
        """True if these are all modes."""
        return len(self.square) == self.network.n_freedoms

    def describe_floppy(self) -> str:
        """Describe the modes without resistance: how many, and which grains move how."""
        loose = self.square <= _ZERO * self.largest
        share = (self.shape[:, loose] ** 2 * self.network.masses[:, None]).sum(axis=1)
        n = int(loose.sum())
        known = "" if self.complete or n < len(self.square) else " or more"
        text = f"{n}{known} of {self.network.n_freedoms} modes meet no resistance{growing(self.square, self.largest)}; "
        text += who_moves(self.network, share)
        return text


def solve_modes(stiffness: Stiffness, n_modes: int | None = None) -> Modes:
    """Find the modes of a finite packing: all of a small one, the lowest of a large one.

    Parameters
    ----------
    n_modes
        How many; None: all of a small packing, 60 of a large one.
    """
    network = stiffness.network
    n = network.n_freedoms
    matrix = stiffness.matrix(np.zeros(3)).real.tocsr()
    largest = float(np.abs(matrix).sum(axis=1).max())
    if n <= ALL_UP_TO:
        square, vectors = np.linalg.eigh(matrix.toarray())
        frequency, density = _histogram(square)
        if n_modes is not None:
            square, vectors = square[:n_modes], vectors[:, :n_modes]
    else:
        square, vectors = lowest(matrix, min(n_modes or MOST_MODES, n - 2), largest)
        frequency, density = _chebyshev(matrix, largest)
    grain, _ = network.freedoms
    own = np.zeros((network.n_grains, vectors.shape[1]))
    np.add.at(own, grain, vectors**2)
    moving = np.unique(grain).size
    participation = own.sum(axis=0) ** 2 / (moving * (own**2).sum(axis=0))
    shape = vectors / np.sqrt(network.masses)[:, None]
    return Modes(network, square, shape, participation, frequency, density, largest)


def _histogram(square: Array) -> tuple[Array, Array]:
    """Density of states of all modes."""
    frequency = np.sqrt(np.maximum(square, 0.0)) / (2 * np.pi)
    n_bins = int(np.clip(len(square) / 8, 10, _BINS))
    counts, edges = np.histogram(frequency, n_bins, (0.0, 1.02 * frequency.max()))
    return (edges[1:] + edges[:-1]) / 2, counts / (len(square) * np.diff(edges))


def _chebyshev(matrix, largest: float) -> tuple[Array, Array]:  # type: ignore[no-untyped-def]
    """Density of states of a large matrix, by the kernel polynomial method with Jackson's kernel."""
    n = matrix.shape[0]
    random = np.random.default_rng(_SEED)
    vector = random.choice([-1.0, 1.0], (n, _VECTORS))
    middle = width = largest / 2

    def scaled(one: Array) -> Array:
        return np.asarray((matrix @ one - middle * one) / (1.01 * width))

    before, now = vector, scaled(vector)
    moments = [float((vector * before).sum()), float((vector * now).sum())]
    for _ in range(_MOMENTS - 2):
        before, now = now, 2 * scaled(now) - before
        moments.append(float((vector * now).sum()))
    m = np.arange(_MOMENTS)
    q = np.pi / (_MOMENTS + 1)
    kernel = ((_MOMENTS - m + 1) * np.cos(m * q) + np.sin(m * q) / np.tan(q)) / (_MOMENTS + 1)
    weights = np.array(moments) / (n * _VECTORS) * kernel * np.where(m == 0, 1.0, 2.0)
    frequency = (np.arange(_BINS) + 0.5) / _BINS * np.sqrt(largest) / (2 * np.pi)
    square = (2 * np.pi * frequency) ** 2
    x = np.clip((square - middle) / (1.01 * width), -1 + 1e-9, 1 - 1e-9)
    density = np.cos(np.outer(np.arccos(x), m)) @ weights / (np.pi * np.sqrt(1 - x**2) * 1.01 * width)
    found = density * 8 * np.pi**2 * frequency
    kept = frequency <= frequency[np.flatnonzero(found > 1e-4 * found.max())[-1]] * 1.02
    return frequency[kept], np.maximum(found[kept], 0.0)
