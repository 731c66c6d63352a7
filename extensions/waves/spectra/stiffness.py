"""Stiffness and dynamical matrices of a network of springs.

The stiffness between the cells at 0 and at the vector R of periods is K_R. With the phase k.R
between these cells

    K(k) = K_0 + sum_R (K_R exp(i k.R) + K_R^H exp(-i k.R))
    D(k) = M^(-1/2) K(k) M^(-1/2),   D a = omega^2 a

where the sum contains one vector R of each opposite pair. dD/dk gives the group velocities
(Hellmann, Feynman).
"""

from __future__ import annotations

import dataclasses
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh

from granwave.extensions.waves.spectra.network import Network
from granwave.lammps_inputs.errors import InputError, RunError
from granwave.lammps_inputs.statics.bodies import Array, across
from granwave.lammps_inputs.statics.energy import factorised

Complex = NDArray[np.complex128]
DENSE_UP_TO = 600  # degrees of freedom up to which whole spectra are faster than a few values
_FACTORISED_UP_TO = 3000  # degrees of freedom up to which factors fit the memory
_PRECISION = 1e-9  # relative precision of Lanczos' method, which needs no factors
_MOST_RESTARTS = 20_000  # largest number of its restarts
_BATCH = 2**18  # numbers in the matrices that are solved at once; more of them leave the caches
_BELOW = 1e-7  # shift below zero at which values are sought / largest omega^2


def _cross(vectors: Array) -> Array:
    """Matrices of ``vector x``: (n, 3, 3)."""
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)


def _strains(network: Network) -> tuple[list[Array], list[Array]]:
    """Stretch, turning, slip, rolling and twisting of each contact by the motion of its first and
    of its second grain: (n, 1 or 3, 6).
    """
    springs = network.contacts
    normal = springs.normal
    turn = _cross(springs.normal)
    none = np.zeros_like(turn)
    aside = across(normal)
    strains = []
    for side, lever in ((1.0, springs.lever[:, 0]), (-1.0, springs.lever[:, 1])):
        stretch = np.concatenate([side * normal, np.zeros_like(normal)], axis=1)[:, None, :]
        turning = np.concatenate([side * springs.turns, none], axis=2)
        slip = np.concatenate([side * aside, -lever[:, None, None] * turn], axis=2)
        rolling = np.concatenate([none, side * aside], axis=2)
        twisting = np.concatenate([np.zeros_like(normal), side * normal], axis=1)[:, None, :]
        strains.append([stretch, turning, slip, rolling, twisting])
    return strains[0], strains[1]


def _block(first: list[Array], second: list[Array], weights: list[Array]) -> Array:
    """Return the sum of products of strains and their stiffnesses: (n, 6, 6)."""
    parts = zip(first[: len(weights)], second[: len(weights)], weights, strict=True)
    return np.sum([np.einsum("n,nra,nrb->nab", w, a, b) for a, b, w in parts], axis=0)


@dataclasses.dataclass(frozen=True, eq=False)
class Stiffness:
    """Stiffness of a network, cell by cell; see the module.

    Attributes
    ----------
    network
        The network.
    own
        K_0: (n_freedoms, n_freedoms), N/m.
    images
        Whole numbers of periods R: (n_images, n_periods).
    others
        K_R of each of these.
    """

    network: Network
    own: sparse.csr_array
    images: NDArray[np.int64]
    others: tuple[sparse.csr_array, ...]

    @property
    def shifts(self) -> Array:
        """Vectors R: (n_images, 3), m."""
        return np.asarray(self.images @ self.network.periods)

    @cached_property
    def _scaled(self) -> tuple[sparse.csr_array, list[sparse.csr_array]]:
        """M^(-1/2) K M^(-1/2) of K_0 and of each K_R."""
        scale = sparse.diags_array(1 / np.sqrt(self.network.masses))
        return scale @ self.own @ scale, [scale @ block @ scale for block in self.others]

    @cached_property
    def _dense(self) -> tuple[Array, Array]:
        own, others = self._scaled
        n = self.network.n_freedoms
        return own.toarray(), np.array([block.toarray() for block in others]).reshape(-1, n, n)

    @cached_property
    def largest(self) -> float:
        """Upper bound of omega^2 by Gershgorin's circles, s^-2."""
        return float(np.abs(self.matrix(np.zeros(3))).sum(axis=1).max())

    @property
    def total(self) -> sparse.csr_array:
        """K(0), for identical motions of all cells: (n_freedoms, n_freedoms), N/m."""
        return sparse.csr_array(sum((block + block.T for block in self.others), start=self.own))

    def _phases(self, k: Array, axis: int | None) -> Complex:
        """Factors of the K_R at wave vectors (n_k, 3), or their slopes along an axis: (n_k,
        n_images).
        """
        phases = np.exp(1j * k @ self.shifts.T)
        return np.asarray(phases if axis is None else 1j * self.shifts[:, axis] * phases)

    def dense(self, k: Array, axis: int | None = None) -> Complex:
        """Return D(k), or dD/dk along an axis, for wave vectors (n_k, 3), rad/m: (n_k, n_freedoms,
        n_freedoms).
        """
        own, others = self._dense
        half = np.tensordot(self._phases(k, axis), others, axes=1)
        return np.asarray((own if axis is None else 0.0) + half + half.conj().transpose(0, 2, 1))

    def matrix(self, k: Array, axis: int | None = None) -> sparse.csr_array:
        """Return D(k), or dD/dk along an axis, for a wave vector (3,), rad/m: a sparse matrix."""
        own, others = self._scaled
        matrix = sparse.csr_array(own.shape, dtype=np.complex128)
        if axis is None:
            matrix = own.astype(np.complex128)
        for phase, block in zip(self._phases(k[None], axis)[0], others, strict=True):
            part = block * phase
            matrix = matrix + part + part.conj().T
        return matrix.tocsr()

    @property
    def small(self) -> bool:
        """True if whole spectra are found."""
        return self.network.n_freedoms <= DENSE_UP_TO

    @property
    def at_once(self) -> int:
        """Number of wave vectors whose spectra are found at once."""
        return max(1, _BATCH // self.network.n_freedoms**2) if self.small else 1

    def spectrum(self, k: Array, n_bands: int) -> tuple[Array, Complex]:
        """Return the lowest omega^2 and their vectors at wave vectors (n_k, 3), rad/m.

        Returns
        -------
        ndarray, ndarray
            (n_k, n_bands), s^-2, rising, and (n_k, n_freedoms, n_bands).
        """
        if self.small:
            values, vectors = np.linalg.eigh(self.dense(k))
            return values[:, :n_bands], vectors[:, :, :n_bands]
        pairs = [lowest(self.matrix(vector), n_bands, self.largest) for vector in k]
        return np.array([values for values, _ in pairs]), np.array(
            [vectors for _, vectors in pairs]
        )

    def slope(self, k: Array, axis: int, vectors: Complex) -> Complex:
        """Return dD/dk along an axis times vectors, as `spectrum` gives them."""
        if self.small:
            return np.asarray(self.dense(k, axis) @ vectors)
        return np.array(
            [self.matrix(vector, axis) @ part for vector, part in zip(k, vectors, strict=True)]
        )


def stiffness_of(network: Network) -> Stiffness:
    """Assemble the stiffness of a network.

    Raises
    ------
    InputError
        Nothing in it can move.
    """
    if not network.n_freedoms:
        raise InputError("found no grain that can move; remove [[hold]], or use other --directions")
    springs = network.contacts
    first, second = _strains(network)
    weights = [springs.stiffness, -springs.force / springs.distance, springs.tangential]
    if springs.rolling is not None and springs.twisting is not None:
        weights += [springs.rolling, springs.twisting]
    # the last row is walls'
    n = network.n_freedoms
    number = np.append(network.numbers, np.full((1, 6), -1), axis=0)

    def gathered(
        rows: NDArray[np.int64], columns: NDArray[np.int64], blocks: Array
    ) -> sparse.csr_array:
        row = np.repeat(number[rows], 6, axis=1).reshape(-1)
        column = np.tile(number[columns], (1, 6)).reshape(-1)
        kept = (row >= 0) & (column >= 0)
        return sparse.coo_array(
            (blocks.reshape(-1)[kept], (row[kept], column[kept])), shape=(n, n)
        ).tocsr()

    own = gathered(springs.first, springs.first, _block(first, first, weights))
    own = own + gathered(springs.second, springs.second, _block(second, second, weights))
    between = _block(first, second, weights)
    inside = ~springs.image.any(axis=1)
    coupled = gathered(springs.first[inside], springs.second[inside], between[inside])
    own = own + coupled + coupled.T
    images = np.unique(springs.image[~inside], axis=0)
    others = []
    for image in images:
        rows = np.flatnonzero((springs.image == image).all(axis=1))
        others.append(gathered(springs.first[rows], springs.second[rows], between[rows]))
    return Stiffness(network, own.tocsr(), images, tuple(others))


def lowest(matrix, n_bands: int, largest: float) -> tuple[Array, Complex]:  # type: ignore[no-untyped-def]
    """Return the lowest eigenvalues of a sparse Hermitian matrix, rising, and their vectors.

    Raises
    ------
    RunError
        They are not found.
    """
    try:
        if matrix.shape[0] > _FACTORISED_UP_TO:
            basis = min(matrix.shape[0] - 1, max(4 * n_bands, 60))
            values, vectors = eigsh(
                matrix, k=n_bands, which="SA", ncv=basis, tol=_PRECISION, maxiter=_MOST_RESTARTS
            )
        else:
            shift = -_BELOW * largest
            inverse = factorised(matrix - shift * sparse.eye_array(matrix.shape[0]))
            operator = LinearOperator(matrix.shape, inverse.solve, dtype=matrix.dtype)
            values, vectors = eigsh(matrix, k=n_bands, sigma=shift, which="LM", OPinv=operator)
    except ArpackNoConvergence as error:
        raise RunError(
            f"the lowest {n_bands} frequencies were not found ({error}); ask for fewer (--bands)"
        ) from None
    order = np.argsort(values)
    return values[order], vectors[:, order]
