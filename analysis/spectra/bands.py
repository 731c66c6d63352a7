"""Bands of an endless packing: frequencies, group velocities and mode shapes along a path of wave vectors."""

from __future__ import annotations

import dataclasses
import warnings
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh

from granwave.analysis.spectra.defaults import MOST_BANDS
from granwave.analysis.spectra.network import FREEDOMS, Array, Network
from granwave.analysis.spectra.paths import Path
from granwave.analysis.spectra.stiffness import DENSE_UP_TO, Complex, Stiffness, factorised
from granwave.lammps_inputs.errors import InputError, RunError

_ZERO = 1e-10  # omega^2 over the largest: no stiffness
_LONG = 1e-6  # |k| times the period: a uniform displacement
_BATCH = 2**24  # numbers in the matrices that are solved at once
_FACTORISED_UP_TO = 3000  # degrees of freedom; factors of larger matrices fill the memory, Lanczos' method needs none
_PRECISION, _MOST_RESTARTS = 1e-9, 20_000
_TURNING = 0.99  # of the energy in rotations: grains that roll
ROLLING = "like gears: they roll on each other, which friction does not resist"
_BELOW = 1e-7  # of the largest omega^2, where values are sought from


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
        Mode shapes at the corners of the path, in units of M^(-1/2): (n_corners, n_freedoms, n_bands).
    largest
        Upper bound of omega^2, s^-2.
    share
        Part of the energy that chosen degrees of freedom have: (n_k, n_bands); None if none were chosen.
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
        """Frequencies: (n_k, n_bands), Hz; 0 where nothing resists, NaN where a motion grows by itself."""
        zero = _ZERO * self.largest
        hertz = np.sqrt(np.maximum(self.square, 0)) / (2 * np.pi)
        hertz = np.where(np.abs(self.square) <= zero, np.where(self.uniform[:, None], 0.0, hertz), hertz)
        return np.where(self.square < -zero, np.nan, hertz)

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
    stiffness: Stiffness, path: Path, n_bands: int | None = None, chosen: NDArray[np.bool_] | None = None
) -> Bands:
    """Find the bands along a path, the lowest ones of a large cell.

    Parameters
    ----------
    n_bands
        How many; None: all of a small cell, 30 of a large one.
    chosen
        Degrees of freedom whose part of the energy is sought: (n_freedoms,).
    """
    n = stiffness.network.n_freedoms
    wanted = min(n, n_bands or (n if n <= DENSE_UP_TO else MOST_BANDS))
    corners = [row for row, _ in path.corners]
    if n <= DENSE_UP_TO:
        return _dense(stiffness, path, wanted, corners, chosen)
    largest = _bound(stiffness)
    square, velocity = np.empty((len(path.k), wanted)), np.empty((len(path.k), wanted, 3))
    shape = np.empty((len(corners), n, wanted), dtype=np.complex128)
    share = None if chosen is None else np.empty((len(path.k), wanted))
    for row, k in enumerate(path.k):
        values, vectors = lowest(stiffness.matrix(k), wanted, largest)
        square[row] = values
        if share is not None:
            share[row] = (np.abs(vectors[chosen]) ** 2).sum(axis=0)
        for axis in range(3):
            slope = stiffness.slope(k, axis)
            velocity[row, :, axis] = np.einsum("na,na->a", vectors.conj(), slope @ vectors).real
        for place, corner in enumerate(corners):
            if corner == row:
                shape[place] = vectors
    return Bands(stiffness, path, square, _per_omega(velocity, square, largest), shape, largest, share)


def lowest(matrix, wanted: int, largest: float) -> tuple[Array, Complex]:  # type: ignore[no-untyped-def]
    """Return the lowest eigenvalues of a sparse Hermitian matrix, rising, and their vectors.

    Raises
    ------
    RunError
        They are not found.
    """
    try:
        if matrix.shape[0] > _FACTORISED_UP_TO:
            basis = min(matrix.shape[0] - 1, max(4 * wanted, 60))
            values, vectors = eigsh(matrix, k=wanted, which="SA", ncv=basis, tol=_PRECISION, maxiter=_MOST_RESTARTS)
            order = np.argsort(values)
            return values[order], vectors[:, order]
        shift = -_BELOW * largest
        inverse = factorised(matrix - shift * sparse.eye_array(matrix.shape[0]))
        operator = LinearOperator(matrix.shape, inverse.solve, dtype=matrix.dtype)
        values, vectors = eigsh(matrix, k=wanted, sigma=shift, which="LM", OPinv=operator)
    except ArpackNoConvergence as error:
        raise RunError(f"the lowest {wanted} frequencies were not found ({error}); ask for fewer (--bands)") from None
    order = np.argsort(values)
    return values[order], vectors[:, order]


def _bound(stiffness: Stiffness) -> float:
    """Upper bound of omega^2 by Gershgorin's circles, s^-2."""
    matrix = stiffness.matrix(np.zeros(3))
    return float(np.abs(matrix).sum(axis=1).max())


def _dense(
    stiffness: Stiffness, path: Path, wanted: int, corners: list[int], chosen: NDArray[np.bool_] | None
) -> Bands:
    n, n_k = stiffness.network.n_freedoms, len(path.k)
    at_once = max(1, _BATCH // n**2)
    square, velocity = np.empty((n_k, wanted)), np.empty((n_k, wanted, 3))
    shape = np.empty((len(corners), n, wanted), dtype=np.complex128)
    share = None if chosen is None else np.empty((n_k, wanted))
    for start in range(0, n_k, at_once):
        part = slice(start, min(start + at_once, n_k))
        values, vectors = np.linalg.eigh(stiffness.dense(path.k[part]))
        square[part] = values[:, :wanted]
        vectors = vectors[:, :, :wanted]
        if share is not None:
            share[part] = (np.abs(vectors[:, chosen]) ** 2).sum(axis=1)
        for axis in range(3):
            slope = stiffness.dense_slope(path.k[part], axis)
            velocity[part, :, axis] = (vectors.conj() * (slope @ vectors)).sum(axis=1).real
        for place, corner in enumerate(corners):
            if start <= corner < part.stop:
                shape[place] = vectors[corner - start]
    largest = max(float(square.max()), _bound(stiffness) / 2)
    return Bands(stiffness, path, square, _per_omega(velocity, square, largest), shape, largest, share)


def _per_omega(slope: Array, square: Array, largest: float) -> Array:
    """Group velocities from d(omega^2)/dk; NaN where omega is zero."""
    there = square > _ZERO * largest
    omega = np.sqrt(np.where(there, square, 1.0))
    return np.where(there[:, :, None], slope / (2 * omega[:, :, None]), np.nan)


def refuse_floppy(bands: Bands, name: str) -> None:
    """Raise InputError if grains can move without resistance at a wave vector of the path.

    Raises
    ------
    InputError
        They can; the message says in how many modes, where, and which grains move how.
    """
    if bands.floppy.any():
        found = describe_floppy(bands)
        if ROLLING in found:
            cure = "[[hold]] with rotation = true, --set contact.friction=0, or another --path"
        else:
            cure = (
                'friction, a load from all sides (precompression.kind = "uniform"), --directions, [[hold]], or another '
            )
            cure += "--path"
        raise InputError(f"{name}: {found}; {cure} makes it rigid, and --allow-floppy leaves these modes blank")


def describe_floppy(bands: Bands) -> str:
    """Describe the modes without resistance: how many, where, which grains move how."""
    floppy = bands.floppy
    counts = floppy.sum(axis=1)
    row = int(np.argmax(counts))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if bands.network.n_freedoms <= DENSE_UP_TO:
            _, vectors = np.linalg.eigh(bands.stiffness.dense(bands.path.k[row : row + 1])[0])
        else:
            _, vectors = lowest(bands.stiffness.matrix(bands.path.k[row]), floppy.shape[1], bands.largest)
    loose = np.abs(vectors[:, : floppy.shape[1]][:, floppy[row]]) ** 2
    at = int(np.count_nonzero(counts))
    return (
        f"the static state is not rigid: {counts[row]} of {bands.network.n_freedoms} modes meet no resistance at "
        f"{bands.path.nearest(row)} (at {at} of {len(bands.path.k)} wave vectors there are some)"
        f"{growing(bands.square, bands.largest)}; {who_moves(bands.network, loose.sum(axis=1))}"
    )


def growing(square: Array, largest: float) -> str:
    """Describe the modes that grow, given omega^2 (..., n_modes) and its upper bound, s^-2; empty if there are none."""
    grow = square < -_ZERO * largest
    if not grow.any():
        return ""
    rate = float(np.sqrt(-square.min()))
    n = f"{'up to ' if square.ndim > 1 else ''}{grow.sum(axis=-1).max()}"
    return f", and {n} of them grow, by {rate:.3g} 1/s at most: the packing buckles under its load"


def who_moves(network: Network, share: Array) -> str:
    """Describe which grains move in which directions, given the energies of the degrees of freedom (n_freedoms,)."""
    grain, direction = network.freedoms
    total = share.sum()
    along = np.bincount(direction, share, 6) / total
    rolling = f" ({ROLLING})" if along[3:].sum() > _TURNING else ""
    words = [f"{100 * one:.0f} % {_WORDS[place]}" for place, one in enumerate(along) if one > 0.005]
    own = np.bincount(grain, share, network.n_grains) / total
    most = np.argsort(-own)[:3]
    ids = ", ".join(str(network.ids[one]) for one in most if own[one] > 0.01)
    return f"they move {', '.join(words)}{rolling}" + (f"; grains {ids} most" if ids else "")


_WORDS = {place: f"along {name}" if place < 3 else f"turning about {name[1]}" for place, name in enumerate(FREEDOMS)}
