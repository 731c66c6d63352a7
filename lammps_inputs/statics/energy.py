"""Energy of grains under static loads: unknowns, energy with its derivatives, and a step of
Newton's method.

The unknowns are the displacements of the grains, the free strains of the cell, and the distances of
walls that move in up to a force. The energy of contacts and loads has a minimum in the static
state. Contacts are loaded for the first time, without friction.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.sparse.linalg import cg, splu

from granwave.lammps_inputs.contact.static_load import static_stiffness
from granwave.lammps_inputs.packing_kind import TOUCHING
from granwave.lammps_inputs.statics.bodies import Array, Bodies, Ints, NeighbourPairs

MARGIN = 0.02  # largest gap of pairs that may close in a step, mean diameters
DIRECT_UP_TO = 1500  # unknowns; larger systems use conjugate gradients, except slender packings
SOFT = 1e-10  # stiffness added to all unknowns / mean stiffness, for motions without resistance
_OF_A_ROW = 6  # entries per unknown of a row of grains
_SLENDER = 120  # bandwidth of a slender packing, of some 6 x 6 grains across
_PIVOT = 0.1  # smallest pivot on the diagonal / largest entry of its column, indefinite matrices
ROUNDING = 16  # net force by rounding / (stiffness times the rounding error of a coordinate)


@dataclasses.dataclass(frozen=True, eq=False)
class Evaluation:
    """State with its energy and gradient, and the terms of the second derivatives."""

    energy: float
    gradient: Array
    contacts: NeighbourPairs  # contacts of grains near each other, and near walls
    tables: list[
        tuple[Array, sparse.csr_array]
    ]  # slopes of forces with the derivatives of distances, which are first
    largest: float
    rounding: float

    @property
    def hessian(self) -> sparse.csr_array:
        """Second derivatives of the energy."""
        return sparse.csr_array(
            sum(rows.T @ sparse.diags_array(slope) @ rows for slope, rows in self.tables)
        )


class EnergyProblem:
    """Unknowns and their energy."""

    def __init__(self, bodies: Bodies, *, with_turning: bool = False) -> None:
        self.bodies = bodies
        self.with_turning = with_turning
        self.free = bodies.moves[:, :3] if bodies.settles is None else bodies.settles
        number = np.where(self.free, np.cumsum(self.free.ravel()).reshape(self.free.shape) - 1, -1)
        self.number = np.append(number, np.full((1, 3), -1), axis=0)  # the last row is the walls
        self.strains = list(bodies.stress)
        self.n_motions = int(self.free.sum())
        self.n_of_grains = self.n_motions + len(self.strains)
        self.n = self.n_of_grains + len(bodies.presses)

    @property
    def loaded(self) -> bool:
        """True if a load acts on grains, on the cell or on walls."""
        bodies = self.bodies
        return bool(bodies.dead_load.any() or any(bodies.stress.values()) or bodies.presses)

    def state(self, x: Array) -> tuple[Array, Array]:
        """Centres and periods."""
        position = self.bodies.position.copy()
        position[self.free] += x[: self.n_motions]
        return position, self.bodies.periods @ self.deformation(x).T

    def deformation(self, x: Array) -> Array:
        """Deformation of the cell: (3, 3)."""
        matrix = np.eye(3)
        strains = x[self.n_motions : self.n_of_grains]
        for (a, b), strain in zip(self.strains, strains, strict=True):
            matrix[a, b] += strain
            if a != b:
                matrix[b, a] += strain
        return matrix

    def uniform(self, strain: float) -> Array:
        """Unknowns of a uniform compression along the loaded free strains."""
        x = np.zeros(self.n)
        x[self.n_motions : self.n_of_grains] = [-strain if a == b else 0.0 for a, b in self.strains]
        deformed = self.bodies.position @ self.deformation(x).T
        x[: self.n_motions] = (deformed - self.bodies.position)[self.free]
        return x

    def at(self, x: Array, smoothing: float = 0.0) -> Evaluation:
        """Evaluate the energy.

        Parameters
        ----------
        smoothing
            Overlap of contacts that just touch, m, see `granwave.lammps_inputs.statics.smoothed`.
        """
        bodies = self.bodies.with_walls_in(x[self.n_of_grains :])
        position, periods = self.state(x)
        contacts = bodies.near(position, periods, MARGIN * bodies.spacing)
        values = np.zeros((3, len(contacts)))
        overlap, growth = smoothed_overlaps(contacts.overlap, smoothing)
        for law, rows, scale in bodies.laws_of(contacts):
            values[:, rows] = law.evaluate(overlap[rows], scale)
        force, slope, work = values
        slope = slope * growth
        stretch = self.stretch(contacts, contacts.normal, walls=True)
        energy = float(work.sum()) - float((bodies.dead_load * (position - bodies.position)).sum())
        gradient = -(stretch.T @ force)
        gradient[: self.n_motions] -= bodies.dead_load[self.free]
        for place, load in enumerate(bodies.stress.values(), start=self.n_motions):
            energy += load * x[place]
            gradient[place] += load
        for place, force_on_walls in enumerate(bodies.presses.values(), start=self.n_of_grains):
            energy -= force_on_walls * x[place]
            gradient[place] -= force_on_walls
        tables = [(slope, stretch)]
        if self.with_turning:
            weight = -force / contacts.distance
            tables += [
                (weight, self.stretch(contacts, contacts.turns[:, axis])) for axis in range(3)
            ]
        span = float(np.abs(position).max()) if len(position) else 0.0
        rounding = ROUNDING * slope.max(initial=0.0) * np.finfo(float).eps * span
        return Evaluation(energy, gradient, contacts, tables, force.max(initial=0.0), rounding)

    def largest_approach(self, now: Evaluation, move: Array) -> float:
        """Return the largest motion of grains relative to their neighbours and the walls, m."""
        motion = np.zeros_like(self.bodies.position)
        motion[self.free] = move[: self.n_motions]
        pairs = now.contacts.second >= 0
        between = motion[now.contacts.second[pairs]] - motion[now.contacts.first[pairs]]
        along = float(np.abs(now.tables[0][1] @ move).max(initial=0.0))
        return max(along, float(np.linalg.norm(between, axis=1).max(initial=0.0)))

    def by_linear_springs(self) -> Array:
        """Unknowns under the dead loads if all contacts were linear springs, which also support
        tension.
        """
        bodies = self.bodies
        gap = TOUCHING * bodies.spacing + bodies.case.packing.diameter_scatter
        contacts = bodies.near(bodies.position, bodies.periods, gap, MARGIN * bodies.spacing)
        stretch = self.stretch(contacts, contacts.normal, walls=True)
        gradient = np.zeros(self.n)
        gradient[: self.n_motions] = -bodies.dead_load[self.free]
        gradient[self.n_of_grains :] = [-force for force in bodies.presses.values()]
        return newton_step(static_stiffness(bodies.assembly) * (stretch.T @ stretch), gradient)

    def stretch(
        self, contacts: NeighbourPairs, direction: Array, *, walls: bool = False
    ) -> sparse.csr_array:
        """Derivatives of the separations of contacts along directions (n, 3) by the unknowns: (n,
        n_unknowns).

        Parameters
        ----------
        walls
            True for directions along normals, along which walls move in.
        """
        of_first = self._approach(contacts.first, direction)
        of_second = self._approach(contacts.second, direction)
        moved = (of_first - of_second)[:, : self.n_motions]
        strained = np.zeros((len(direction), len(self.strains)))
        for place, (a, b) in enumerate(self.strains):
            strained[:, place] = direction[:, a] * contacts.shift[:, b]
            if a != b:
                strained[:, place] += direction[:, b] * contacts.shift[:, a]
        closed = np.zeros((len(direction), len(self.bodies.presses)))
        if walls:
            wall = contacts.wall.astype(str)
            for place, names in enumerate(self.bodies.presses):
                closed[:, place] = -np.isin(wall, names).astype(float)
        return sparse.csr_array(sparse.hstack([moved, strained, closed]))

    def _approach(self, grain: Ints, normal: Array) -> sparse.csr_array:
        """Derivatives, with respect to the unknowns, of gaps in front of grains along normals (n,
        3): (n, n_unknowns).
        """
        number = self.number[grain]
        kept = number >= 0
        row = np.repeat(np.arange(len(grain)), 3).reshape(len(grain), 3)[kept]
        return sparse.coo_array(
            (-normal[kept], (row, number[kept])), shape=(len(grain), self.n)
        ).tocsr()


def smoothed_overlaps(overlap: Array, smoothing: float) -> tuple[Array, Array]:
    """Return overlaps that are positive also in open contacts, and their slopes: (n,), m and 1.

    The overlap a follows from the overlap d of the geometry by a (a - d) = s^2: it is s in a
    contact that just touches, d in a contact with d >> s, and s^2/|d| in a contact that is open by
    much more than s.

    Parameters
    ----------
    smoothing
        The length s, m; 0 leaves the overlaps as they are.
    """
    if not smoothing:
        return overlap, np.ones_like(overlap)
    root = np.hypot(overlap, 2 * smoothing)
    open_ones = overlap < 0
    positive = np.where(
        open_ones, 2 * smoothing**2 / (root + np.abs(overlap)), (overlap + root) / 2
    )
    return positive, positive / root


def factorised(matrix: sparse.sparray, *, pivots: bool = False) -> Any:
    """Factorise a matrix with a symmetric pattern; SuperLU's default ordering gives ten times as
    much fill-in.

    Parameters
    ----------
    pivots
        True for an indefinite matrix, whose diagonal may vanish. Without pivots its solutions are
        wrong without an error.
    """
    threshold = _PIVOT if pivots else 0.0
    return splu(
        matrix.tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=threshold,
        options={"SymmetricMode": True},
    )


def newton_step(
    hessian: sparse.csr_array, gradient: Array, *, pivots: bool = False, holding: float = 0.0
) -> Array:
    """Return Newton's step.

    Parameters
    ----------
    pivots
        True for an indefinite matrix; the step then also leads to balances that are no minimum.
    holding
        Stiffness of springs that hold all grains in place, N/m; by default so small that it affects
        only free motions.
    """
    diagonal = hessian.diagonal()
    soft = SOFT * float(diagonal.mean()) if len(diagonal) else 1.0
    matrix = (hessian + (holding or soft or 1.0) * sparse.eye_array(len(diagonal))).tocsc()
    if pivots:
        return np.asarray(splu(matrix).solve(-gradient))
    if len(diagonal) <= DIRECT_UP_TO or _is_slender(matrix):
        return np.asarray(factorised(matrix).solve(-gradient))
    preconditioner = sparse.diags_array(1 / matrix.diagonal())
    step, _ = cg(matrix, -gradient, rtol=1e-5, maxiter=4000, M=preconditioner)
    return np.asarray(step)


def _is_slender(matrix: sparse.csc_array) -> bool:
    """Return True for the matrix of a long row or a slender packing.

    Its factors are small, and conjugate gradients would take a number of steps proportional to its
    length.
    """
    if matrix.nnz <= _OF_A_ROW * matrix.shape[0]:
        return True
    order = reverse_cuthill_mckee(sparse.csr_matrix(matrix), symmetric_mode=True)
    place = np.empty(matrix.shape[0], dtype=np.int64)
    place[order] = np.arange(len(place))
    rows, columns = matrix.nonzero()
    return bool(np.abs(place[rows] - place[columns]).max() <= _SLENDER)
