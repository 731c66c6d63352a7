"""Bands of a periodic packing along a path of wave vectors, gaps between them, and modes of a
finite packing.

The participation ratio of a mode is (sum e_i)^2/(n sum e_i^2), where e_i are the energies of the n
grains: 1 if all grains move equally, 1/n if only one grain moves. The density of states of a large
packing is computed over its complete range from moments over Chebyshev polynomials with random
vectors (kernel polynomial method, doi:10.1103/RevModPhys.78.275).
"""

from __future__ import annotations

import dataclasses
import warnings
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from granwave.extensions.waves.spectra.defaults import MOST_BANDS, MOST_MODES
from granwave.extensions.waves.spectra.network import FREEDOMS, Network
from granwave.extensions.waves.spectra.stiffness import Complex, Stiffness, lowest
from granwave.extensions.waves.spectra.wave_vectors import Path
from granwave.lammps_inputs.statics.bodies import Array

_ZERO = 1e-10  # omega^2 / largest omega^2 without stiffness
_LONG = 1e-6  # |k| times the period of a uniform displacement
_TURNING = 0.99  # fraction of the energy in rotations above which grains roll
ROLLING = "like gears: they roll on each other without resistance from friction"
_LEAST = 1e-6  # smallest gap / highest frequency: bands that only touch leave no gap
ALL_UP_TO = 1500  # degrees of freedom up to which all modes are found
_BINS = 120  # largest number of bins of the density of states of a small packing
_MOMENTS = 240  # Chebyshev moments of the density of states of a large packing
_VECTORS = 12  # random vectors for these moments
_SEED = 1
_WORDS = {
    place: f"along {name}" if place < 3 else f"rotating about {name[1]}"
    for place, name in enumerate(FREEDOMS)
}


def _hertz(square: Array, largest: float, rigid: NDArray[np.bool_] | bool = True) -> Array:
    """Frequencies, Hz, from omega^2, s^-2; 0 for ``rigid`` motions without stiffness, NaN for
    unstable motions.
    """
    zero = _ZERO * largest
    hertz = np.where(
        (np.abs(square) <= zero) & rigid, 0.0, np.sqrt(np.maximum(square, 0.0)) / (2 * np.pi)
    )
    return np.where(square < -zero, np.nan, hertz)


@dataclasses.dataclass(frozen=True, eq=False)
class Bands:
    """Bands along a path.

    Attributes
    ----------
    stiffness
        The packing.
    path
        The wave vectors.
    square
        omega^2, rising along each row: (n_k, n_bands), s^-2.
    velocity
        Group velocities: (n_k, n_bands, 3), m/s; NaN where the frequency is zero.
    shape
        Mode shapes at the corners of the path, in units of M^(-1/2): (n_corners, n_freedoms,
        n_bands).
    largest
        Upper bound of omega^2, s^-2.
    share
        Fraction of the energy in selected degrees of freedom: (n_k, n_bands); None without a
        selection.
    """

    stiffness: Stiffness
    path: Path
    square: Array
    velocity: Array
    shape: Complex
    largest: float
    share: Array | None = None

    @property
    def network(self) -> Network:
        """The packing."""
        return self.stiffness.network

    @cached_property
    def frequency(self) -> Array:
        """Frequencies: (n_k, n_bands), Hz; 0 where nothing resists, NaN where a motion grows by
        itself.
        """
        return _hertz(self.square, self.largest, self.uniform[:, None])

    @property
    def complete(self) -> bool:
        """True if these are all bands."""
        return self.square.shape[1] == self.network.n_freedoms

    @property
    def uniform(self) -> NDArray[np.bool_]:
        """True for wave vectors that are zero: (n_k,)."""
        size = float(np.linalg.norm(self.network.periods, axis=1).max(initial=1.0))
        return np.linalg.norm(self.path.k, axis=1) * size < _LONG

    @cached_property
    def floppy(self) -> NDArray[np.bool_]:
        """True for modes without resistance, other than uniform displacements: (n_k, n_bands)."""
        zero = _ZERO * self.largest
        loose = self.square <= zero
        loose[self.uniform] = self.square[self.uniform] < -zero
        return loose


def solve_bands(
    stiffness: Stiffness,
    path: Path,
    n_bands: int | None = None,
    chosen: NDArray[np.bool_] | None = None,
) -> Bands:
    """Find the bands along a path; of a large cell only the lowest bands.

    Parameters
    ----------
    n_bands
        Number of bands; None: all bands of a small cell, 30 of a large cell.
    chosen
        Degrees of freedom whose part of the energy is sought: (n_freedoms,).
    """
    n = stiffness.network.n_freedoms
    n_k = len(path.k)
    count = min(n, n_bands or (n if stiffness.small else MOST_BANDS))
    corners = [row for row, _ in path.corners]
    square = np.empty((n_k, count))
    velocity = np.empty((n_k, count, 3))
    shape = np.empty((len(corners), n, count), dtype=np.complex128)
    share = None if chosen is None else np.empty((n_k, count))
    for start in range(0, n_k, stiffness.at_once):
        part = slice(start, start + stiffness.at_once)
        square[part], vectors = stiffness.spectrum(path.k[part], count)
        if share is not None:
            share[part] = (np.abs(vectors[:, chosen]) ** 2).sum(axis=1)
        for axis in range(3):
            turned = stiffness.slope(path.k[part], axis, vectors)
            velocity[part, :, axis] = (vectors.conj() * turned).sum(axis=1).real
        for place, corner in enumerate(corners):
            if start <= corner < part.stop:
                shape[place] = vectors[corner - start]
    largest = (
        max(float(square.max()), stiffness.largest / 2) if stiffness.small else stiffness.largest
    )
    is_moving = square > _ZERO * largest
    omega = np.sqrt(np.where(is_moving, square, 1.0))[:, :, None]
    velocity = np.where(is_moving[:, :, None], velocity / (2 * omega), np.nan)
    return Bands(stiffness, path, square, velocity, shape, largest, share)


def describe_floppy(bands: Bands) -> str:
    """Describe the modes without resistance: their number, wave vector and motion; empty if there
    are none.
    """
    counts = bands.floppy.sum(axis=1)
    row = int(np.argmax(counts))
    at = int(np.count_nonzero(counts))
    if not at:
        return ""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        _, vectors = bands.stiffness.spectrum(bands.path.k[row : row + 1], bands.floppy.shape[1])
    loose = np.abs(vectors[0][:, bands.floppy[row]]) ** 2
    return (
        f"the static state is not rigid: {counts[row]} of {bands.network.n_freedoms} modes have "
        f"no stiffness at {bands.path.nearest(row)} (at {at} of {len(bands.path.k)} wave vectors "
        f"there are such modes){growing(bands.square, bands.largest)}; "
        f"{who_moves(bands.network, loose.sum(axis=1))}"
    )


def growing(square: Array, largest: float) -> str:
    """Describe the modes that grow, given omega^2 (..., n_modes) and its upper bound, s^-2; empty
    if there are none.
    """
    grow = square < -_ZERO * largest
    if not grow.any():
        return ""
    rate = float(np.sqrt(-square.min()))
    n = f"{'up to ' if square.ndim > 1 else ''}{grow.sum(axis=-1).max()}"
    return f", and {n} of them grow, by {rate:.3g} 1/s at most: the packing buckles under its load"


def who_moves(network: Network, share: Array) -> str:
    """Describe the directions and the grains of a motion, given the energies of the degrees of
    freedom: (n_freedoms,).
    """
    grain, direction = network.freedoms
    total = share.sum()
    along = np.bincount(direction, share, 6) / total
    rolling = f" ({ROLLING})" if along[3:].sum() > _TURNING else ""
    words = [
        f"{100 * part:.0f} % {_WORDS[place]}" for place, part in enumerate(along) if part > 0.005
    ]
    own = np.bincount(grain, share, network.n_grains) / total
    most = np.argsort(-own)[:3]
    ids = ", ".join(str(network.ids[row]) for row in most if own[row] > 0.01)
    return f"they move {', '.join(words)}{rolling}" + (f"; grains {ids} most" if ids else "")


@dataclasses.dataclass(frozen=True)
class Gap:
    """Frequencies at which no wave travels along the path.

    Attributes
    ----------
    low, high
        Its edges, Hz; ``high`` is infinite above the highest band, ``low`` zero below the lowest.
    below
        Number of bands below it.
    """

    low: float
    high: float
    below: int

    @property
    def middle(self) -> float:
        """Middle of the gap, Hz."""
        return (self.low + self.high) / 2

    @property
    def relative_width(self) -> float:
        """Width divided by the middle frequency."""
        return (self.high - self.low) / self.middle if np.isfinite(self.high) else np.inf


def band_edges(bands: Bands) -> Array:
    """Return the lowest and highest frequency of each band along the path: (n_bands, 2), Hz; NaN
    for bands without a frequency.
    """
    frequency = bands.frequency
    low = np.where(np.isnan(frequency), np.inf, frequency).min(axis=0)
    high = np.where(np.isnan(frequency), -np.inf, frequency).max(axis=0)
    has_gap = np.isfinite(low)
    return np.stack([np.where(has_gap, low, np.nan), np.where(has_gap, high, np.nan)], axis=1)


def gaps(bands: Bands) -> list[Gap]:
    """Return the gaps between, below and above the bands of a path, by rising frequency.

    The gap above the last band is omitted if only the lowest bands of a large cell were sought.
    """
    edges = band_edges(bands)
    intervals: list[Gap] = []
    top = 0.0
    least = _LEAST * float(np.nanmax(edges, initial=0.0))
    for n, (low, high) in enumerate(
        edges[np.argsort(edges[:, 0])].tolist()
    ):  # bands without any frequency are last
        if low > top + least:
            intervals.append(Gap(top, low, n))
        top = max(top, high)
    return [*intervals, Gap(top, np.inf, len(edges))] if bands.complete else intervals


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
        Displacements and rotations of unit kinetic energy: (n_freedoms, n_modes), kg^-1/2
        (rotations: kg^-1/2 m^-1).
    participation
        Participation ratios: (n_modes,).
    density_frequency, density
        Density of states, a fraction of all modes for each Hz, and its frequencies, Hz: (n,).
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
        """Number of modes without resistance among these modes."""
        return int(np.count_nonzero(self.square <= _ZERO * self.largest))

    @property
    def frequency(self) -> Array:
        """Frequencies: (n_modes,), Hz; 0 where nothing resists, NaN where a motion grows by
        itself.
        """
        return _hertz(self.square, self.largest)

    @property
    def complete(self) -> bool:
        """True if these are all modes of the packing."""
        return len(self.square) == self.network.n_freedoms

    def describe_floppy(self) -> str:
        """Describe the modes without resistance: their number and motion."""
        loose = self.square <= _ZERO * self.largest
        share = (self.shape[:, loose] ** 2 * self.network.masses[:, None]).sum(axis=1)
        suffix = "" if self.complete or not loose.all() else " or more"
        many = f"{self.n_floppy}{suffix} of {self.network.n_freedoms} modes have no stiffness"
        return f"{many}{growing(self.square, self.largest)}; {who_moves(self.network, share)}"


def solve_modes(stiffness: Stiffness, n_modes: int | None = None) -> Modes:
    """Find the modes of a finite packing: all modes of a small packing, the lowest modes of a large
    packing.

    Parameters
    ----------
    n_modes
        Number of modes; None: all modes of a small packing, 60 of a large packing.
    """
    network = stiffness.network
    n = network.n_freedoms
    matrix = stiffness.matrix(np.zeros(3)).real.tocsr()
    largest = stiffness.largest
    if n <= ALL_UP_TO:
        square, vectors = np.linalg.eigh(matrix.toarray())
        modes = np.sqrt(np.maximum(square, 0.0)) / (2 * np.pi)
        n_bins = int(np.clip(len(square) / 8, 10, _BINS))
        counts, edges = np.histogram(modes, n_bins, (0.0, 1.02 * modes.max()))
        frequency = (edges[1:] + edges[:-1]) / 2
        density = counts / (len(square) * np.diff(edges))
        if n_modes is not None:
            square = square[:n_modes]
            vectors = vectors[:, :n_modes]
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


def _chebyshev(matrix, largest: float) -> tuple[Array, Array]:  # type: ignore[no-untyped-def]
    """Density of states of a large matrix, by the kernel polynomial method with Jackson's
    kernel.
    """
    n = matrix.shape[0]
    random = np.random.default_rng(_SEED)
    vector = random.choice([-1.0, 1.0], (n, _VECTORS))
    middle = width = largest / 2

    def scaled(vectors: Array) -> Array:
        return np.asarray((matrix @ vectors - middle * vectors) / (1.01 * width))

    before = vector
    now = scaled(vector)
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
    density = (
        np.cos(np.outer(np.arccos(x), m)) @ weights / (np.pi * np.sqrt(1 - x**2) * 1.01 * width)
    )
    per_frequency = density * 8 * np.pi**2 * frequency
    kept = (
        frequency
        <= frequency[np.flatnonzero(per_frequency > 1e-4 * per_frequency.max())[-1]] * 1.02
    )
    return frequency[kept], np.maximum(per_frequency[kept], 0.0)
