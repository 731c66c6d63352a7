"""Static state of grains under load, by Newton's method.

Unknown are the displacements of the grains and the strains of the cell that are free. The energy of
the contacts and of the loads is smallest in the static state; contacts are loaded for the first
time, without friction.

A packing that buckles has no such state near the places that it is given. Newton's method with the
turning of forces then finds the one in which all forces balance and from which it buckles: some
motions lower its energy.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.sparse.linalg import cg, splu

from granwave.analysis.spectra.bodies import Bodies, Contacts
from granwave.analysis.spectra.network import Array, Ints
from granwave.analysis.spectra.stiffness import factorised
from granwave.lammps_inputs.contact.static_load import static_stiffness
from granwave.lammps_inputs.errors import InputError, RunError
from granwave.lammps_inputs.lattices import TOUCHING
from granwave.lammps_inputs.packing.assembly import assemble

_MARGIN = 0.02  # mean diameters: gaps of pairs that may close in a step
_ROUNDS = 200
# net force over the largest contact force; of many grains
_BALANCED = 1e-11
_BALANCED_OF_MANY = 1e-9
_TOLERATED = 1e-6  # the same where rounding leaves more
# steps without progress, and how much more net force is then allowed
_STALLED = 6
_OF_STALLED = 100.0
_SMALLEST_STEP = 2.0**-10
_FARTHEST = 1e3  # mean diameters: steps beyond it are those of motions that nothing resists
# unknowns, factorised; more by conjugate gradients, except in slender packings
_DIRECT_UP_TO = 1500
# entries by unknown in a row of grains; bandwidth: some 6 x 6 grains across
_OF_A_ROW = 6
_SLENDER = 120
# unknowns: whose balance is sought with the turning of forces, by factors with pivots
_BUCKLED_UP_TO = 6000
_SOFT = 1e-10  # of the mean stiffness, added to all: free motions, and grains without contacts
_FIRST_STRAIN = 1e-7
_LARGEST_STRAIN = 0.05
_ROUNDING = 16  # net force by rounding over stiffness times the rounding error of a coordinate
_HALVINGS = 5  # of the interval in which the first strain is sought


@dataclasses.dataclass(frozen=True, eq=False)
class _At:
    """State with its energy and gradient, and what the second derivatives are made of."""

    energy: float
    gradient: Array
    contacts: Contacts  # of grains near each other, and near walls
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


class _Problem:
    """Unknowns and their energy."""

    def __init__(self, bodies: Bodies, *, with_turning: bool = False) -> None:
        self.bodies = bodies
        self.with_turning = with_turning
        self.free = bodies.moves[:, :3].copy()
        number = np.where(self.free, np.cumsum(self.free.ravel()).reshape(self.free.shape) - 1, -1)
        self.number = np.append(
            number, np.full((1, 3), -1), axis=0
        )  # the last row is that of walls
        self.strains = list(bodies.stress)
        self.n_motions = int(self.free.sum())
        self.n = self.n_motions + len(self.strains)

    @property
    def loaded(self) -> bool:
        """True if a load acts, on grains or on the cell."""
        return bool(self.bodies.dead_load.any() or any(self.bodies.stress.values()))

    def state(self, x: Array) -> tuple[Array, Array]:
        """Centres and periods."""
        position = self.bodies.position.copy()
        position[self.free] += x[: self.n_motions]
        return position, self.bodies.periods @ self.deformation(x).T

    def deformation(self, x: Array) -> Array:
        """Deformation of the cell: (3, 3)."""
        found = np.eye(3)
        for (a, b), strain in zip(self.strains, x[self.n_motions :], strict=True):
            found[a, b] += strain
            if a != b:
                found[b, a] += strain
        return found

    def uniform(self, strain: float) -> Array:
        """Unknowns of an even compression along the free strains that bear a load."""
        x = np.zeros(self.n)
        x[self.n_motions :] = [-strain if a == b else 0.0 for a, b in self.strains]
        deformed = self.bodies.position @ self.deformation(x).T
        x[: self.n_motions] = (deformed - self.bodies.position)[self.free]
        return x

    def at(self, x: Array) -> _At:
        """Evaluate the energy."""
        bodies = self.bodies
        position, periods = self.state(x)
        contacts = bodies.near(position, periods, _MARGIN * bodies.spacing)
        values = np.zeros((3, len(contacts)))
        for law, rows, scale in bodies.laws_of(contacts):
            values[:, rows] = law.evaluate(contacts.overlap[rows], scale)
        force, slope, work = values
        stretch = self._stretch(contacts, contacts.normal)
        energy = float(work.sum()) - float((bodies.dead_load * (position - bodies.position)).sum())
        gradient = -(stretch.T @ force)
        gradient[: self.n_motions] -= bodies.dead_load[self.free]
        for place, load in enumerate(bodies.stress.values(), start=self.n_motions):
            energy += load * x[place]
            gradient[place] += load
        tables = [(slope, stretch)]
        if self.with_turning:
            weight = -force / contacts.distance
            tables += [
                (weight, self._stretch(contacts, contacts.turns[:, axis])) for axis in range(3)
            ]
        span = float(np.abs(position).max()) if len(position) else 0.0
        rounding = _ROUNDING * slope.max(initial=0.0) * np.finfo(float).eps * span
        return _At(energy, gradient, contacts, tables, force.max(initial=0.0), rounding)

    def largest_approach(self, now: _At, move: Array) -> float:
        """Return the largest motion of grains against their neighbours and the walls, m."""
        motion = np.zeros_like(self.bodies.position)
        motion[self.free] = move[: self.n_motions]
        pairs = now.contacts.second >= 0
        between = motion[now.contacts.second[pairs]] - motion[now.contacts.first[pairs]]
        along = float(np.abs(now.tables[0][1] @ move).max(initial=0.0))
        return max(along, float(np.linalg.norm(between, axis=1).max(initial=0.0)))

    def by_linear_springs(self) -> Array:
        """Unknowns under the dead loads if all contacts were linear springs, which bear tension
        too.
        """
        bodies = self.bodies
        gap = TOUCHING * bodies.spacing + bodies.case.packing.diameter_scatter
        contacts = bodies.near(bodies.position, bodies.periods, gap, _MARGIN * bodies.spacing)
        stretch = self._stretch(contacts, contacts.normal)
        gradient = np.zeros(self.n)
        gradient[: self.n_motions] = -bodies.dead_load[self.free]
        return _move(static_stiffness(assemble(bodies.case)) * (stretch.T @ stretch), gradient)

    def _stretch(self, contacts: Contacts, direction: Array) -> sparse.csr_array:
        """Derivatives by the unknowns of how far contacts are apart along directions (n, 3): (n,
        n_unknowns).
        """
        moved = self._approach(contacts.first, direction) - self._approach(
            contacts.second, direction
        )
        strained = np.zeros((len(direction), len(self.strains)))
        for place, (a, b) in enumerate(self.strains):
            strained[:, place] = direction[:, a] * contacts.shift[:, b]
            strained[:, place] += direction[:, b] * contacts.shift[:, a] if a != b else 0.0
        return sparse.csr_array(sparse.hstack([moved[:, : self.n_motions], strained]))

    def _approach(self, grain: Ints, normal: Array) -> sparse.csr_array:
        """Derivatives by the unknowns of gaps in front of grains along normals (n, 3): (n,
        n_unknowns).
        """
        number = self.number[grain]
        kept = number >= 0
        row = np.repeat(np.arange(len(grain)), 3).reshape(len(grain), 3)[kept]
        return sparse.coo_array(
            (-normal[kept], (row, number[kept])), shape=(len(grain), self.n)
        ).tocsr()


def relax(bodies: Bodies) -> tuple[Array, Array, float]:
    """Find the static state of grains under their loads, or, if they buckle, the balance from which
    they do.

    Returns
    -------
    position, periods
        Of the grains and of the cell: (n, 3) and (n_periods, 3), m.
    residual
        Largest net force on a grain over the largest force of a contact.

    Raises
    ------
    InputError
        The loads press the grains together too far.
    RunError
        No balance was found.
    """
    problem = _Problem(bodies)
    x, now, steps = _search(problem, _start(problem))
    if problem.loaded and problem.n <= _BUCKLED_UP_TO and not _balanced(problem, now):
        turning = _Problem(bodies, with_turning=True)
        there, at, more = _search(turning, _start(turning))
        if _balanced(turning, at):
            problem = turning
            x = there
            now = at
            steps = steps + more
    net = _net(problem, now)
    residual = net / now.largest if now.largest else 0.0
    if now.largest and not _balanced(problem, now):
        raise RunError(
            f"{bodies.case.name}: found no static state: a net force of {residual:.2g} of the largest contact force "
            f"remains after {steps + 1} steps; a larger load, or less scatter, makes the packing rigid"
        )
    return *problem.state(x), residual


def _balanced(problem: _Problem, now: _At) -> bool:
    return now.largest > 0 and _net(problem, now) <= max(_TOLERATED * now.largest, now.rounding)


def _search(problem: _Problem, x: Array) -> tuple[Array, _At, int]:
    """Return the unknowns, what they give, and the steps, of Newton's method from a start."""
    bodies = problem.bodies
    now = problem.at(x)
    balanced = _BALANCED if problem.n <= _DIRECT_UP_TO else _BALANCED_OF_MANY
    best = np.inf
    since = 0
    steps = 0
    for rounds in range(_ROUNDS):
        steps = rounds
        net = _net(problem, now)
        if net <= balanced * now.largest + 1e-300 or problem.n == 0:
            break
        since = 0 if net < 0.5 * best else since + 1
        best = min(best, net)
        if since > 3 and net <= balanced * now.largest + now.rounding:
            break
        if since > _STALLED and net <= _OF_STALLED * balanced * now.largest:
            break  # rounding, of more contacts than one
        move = _move(now.hessian, now.gradient, pivots=problem.with_turning)
        size = 1.0
        largest_move = np.abs(move[: problem.n_motions]).max(initial=0.0)
        if largest_move > _FARTHEST * bodies.spacing:
            break  # motions that nothing resists: the packing buckles
        if (approach := problem.largest_approach(now, move)) > _MARGIN / 2 * bodies.spacing:
            size = _MARGIN / 2 * bodies.spacing / approach
        while True:
            there = problem.at(x + size * move)
            slack = 1e-13 * abs(now.energy)
            lower = not problem.with_turning and there.energy <= now.energy + slack
            if lower or _net(problem, there) < net or size < _SMALLEST_STEP:
                break
            size /= 2
        if size < _SMALLEST_STEP:
            break
        x = x + size * move
        now = there
    return x, now, steps


def _net(problem: _Problem, now: _At) -> float:
    """Largest net force on a grain, or that on the cell over the mean of its periods, N."""
    motions = float(np.abs(now.gradient[: problem.n_motions]).max(initial=0.0))
    lengths = np.linalg.norm(problem.bodies.periods, axis=1)
    cell = float(np.abs(now.gradient[problem.n_motions :]).max(initial=0.0))
    return max(motions, cell / float(lengths.mean()) if len(lengths) else 0.0)


def _move(hessian: sparse.csr_array, gradient: Array, *, pivots: bool = False) -> Array:
    """Newton's step; with pivots, for a matrix that is not definite, also towards balances that are
    no minimum.
    """
    diagonal = hessian.diagonal()
    soft = _SOFT * float(diagonal.mean()) if len(diagonal) else 1.0
    matrix = (hessian + (soft or 1.0) * sparse.eye_array(len(diagonal))).tocsc()
    if pivots:
        return np.asarray(splu(matrix).solve(-gradient))
    # in a long row or a slender packing factors are small, and conjugate gradients need its length
    direct = len(diagonal) <= _DIRECT_UP_TO or matrix.nnz <= _OF_A_ROW * matrix.shape[0]
    if not direct:
        place = np.empty(matrix.shape[0], dtype=np.int64)
        place[reverse_cuthill_mckee(sparse.csr_matrix(matrix), symmetric_mode=True)] = np.arange(
            len(place)
        )
        rows, columns = matrix.nonzero()
        direct = bool(np.abs(place[rows] - place[columns]).max() <= _SLENDER)
    if direct:
        return np.asarray(factorised(matrix).solve(-gradient))
    found, _ = cg(
        matrix, -gradient, rtol=1e-5, maxiter=4000, M=sparse.diags_array(1 / matrix.diagonal())
    )
    return np.asarray(found)


def _start(problem: _Problem) -> Array:
    """Unknowns at which the even strain of the cell bears the load: contacts are closed there."""
    diagonal = [
        place for place, (a, b) in enumerate(problem.strains, start=problem.n_motions) if a == b
    ]
    load = sum(problem.bodies.stress[one] for one in problem.strains if one[0] == one[1])
    if not diagonal or not load:
        return (
            problem.by_linear_springs() if problem.bodies.dead_load.any() else np.zeros(problem.n)
        )

    def excess(strain: float) -> float:
        return float(problem.at(problem.uniform(strain)).gradient[diagonal].sum())

    high = _FIRST_STRAIN
    while excess(high) > 0:
        high *= 4
        if high > _LARGEST_STRAIN:
            raise InputError(
                f"{problem.bodies.case.name}: precompression: would shorten the cell by more than "
                f"{100 * _LARGEST_STRAIN:g} %; give a smaller load, or a cell across which the grains touch"
            )
    low = high / 4 if high > _FIRST_STRAIN else 0.0
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if excess(middle) > 0 else (low, middle)
    return problem.uniform(high)
