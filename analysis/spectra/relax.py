"""Static state of grains under load, by Newton's method.

Unknown are the displacements of the grains, the strains of the cell that are free, and the
distances of walls that move in to a force. The energy of the contacts and of the loads is smallest
in the static state; contacts are loaded for the first time, without friction. As in the static
stage of a run, walls move in to their force with elastic contacts, and stay there.

A packing that buckles has no such state near the places that it is given. Newton's method with the
turning of forces then finds the one in which all forces balance and from which it buckles: some
motions lower its energy.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from typing import TypeAlias

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.sparse.linalg import cg, splu

from granwave.analysis.spectra.bodies import Bodies, Contacts
from granwave.analysis.spectra.network import Array, Ints, Network
from granwave.analysis.spectra.pair_laws import PairLaws
from granwave.analysis.spectra.stiffness import factorised
from granwave.lammps_inputs.contact.law import elastic_case
from granwave.lammps_inputs.contact.static_load import static_stiffness
from granwave.lammps_inputs.deck.static_stage import FORCE_TOLERANCE
from granwave.lammps_inputs.errors import InputError, RunError
from granwave.lammps_inputs.lattices import TOUCHING
from granwave.lammps_inputs.packing.assembly import assemble

_MARGIN = 0.02  # mean diameters: gaps of pairs that may close in a step
_ROUNDS = 200
# steps of grains that fall until they touch others; springs that hold them in a step: first and
# largest stiffness over that of a contact, and factors by which it grows and falls
_ROUNDS_OF_FALL = 1000
_HOLDING = 1e-3
_RIGID = 1e9
_STIFFER = 4.0
_SOFTER = 3.0
# net force over the largest contact force; of many grains
_BALANCED = 1e-11
_BALANCED_OF_MANY = 1e-9
_TOLERATED = 1e-6  # the same where rounding leaves more
# steps without progress, and how much more net force is then allowed
_NO_PROGRESS = 3
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
_FALLEN_UP_TO = 200_000  # unknowns: whose loose grains are followed
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


_Way: TypeAlias = "Callable[[_Problem, Array], tuple[Array, _At]]"


class _Problem:
    """Unknowns and their energy."""

    def __init__(self, bodies: Bodies, *, with_turning: bool = False) -> None:
        self.bodies = bodies
        self.with_turning = with_turning
        self.free = bodies.moves[:, :3] if bodies.settles is None else bodies.settles
        number = np.where(self.free, np.cumsum(self.free.ravel()).reshape(self.free.shape) - 1, -1)
        self.number = np.append(
            number, np.full((1, 3), -1), axis=0
        )  # the last row is that of walls
        self.strains = list(bodies.stress)
        self.n_motions = int(self.free.sum())
        self.n_of_grains = self.n_motions + len(self.strains)
        self.n = self.n_of_grains + len(bodies.presses)

    @property
    def loaded(self) -> bool:
        """True if a load acts, on grains, on the cell or on walls."""
        bodies = self.bodies
        return bool(bodies.dead_load.any() or any(bodies.stress.values()) or bodies.presses)

    def state(self, x: Array) -> tuple[Array, Array]:
        """Centres and periods."""
        position = self.bodies.position.copy()
        position[self.free] += x[: self.n_motions]
        return position, self.bodies.periods @ self.deformation(x).T

    def deformation(self, x: Array) -> Array:
        """Deformation of the cell: (3, 3)."""
        found = np.eye(3)
        strains = x[self.n_motions : self.n_of_grains]
        for (a, b), strain in zip(self.strains, strains, strict=True):
            found[a, b] += strain
            if a != b:
                found[b, a] += strain
        return found

    def uniform(self, strain: float) -> Array:
        """Unknowns of an even compression along the free strains that bear a load."""
        x = np.zeros(self.n)
        x[self.n_motions : self.n_of_grains] = [-strain if a == b else 0.0 for a, b in self.strains]
        deformed = self.bodies.position @ self.deformation(x).T
        x[: self.n_motions] = (deformed - self.bodies.position)[self.free]
        return x

    def at(self, x: Array) -> _At:
        """Evaluate the energy."""
        bodies = self.bodies.with_walls_in(x[self.n_of_grains :])
        position, periods = self.state(x)
        contacts = bodies.near(position, periods, _MARGIN * bodies.spacing)
        values = np.zeros((3, len(contacts)))
        for law, rows, scale in bodies.laws_of(contacts):
            values[:, rows] = law.evaluate(contacts.overlap[rows], scale)
        force, slope, work = values
        stretch = self._stretch(contacts, contacts.normal, walls=True)
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
        stretch = self._stretch(contacts, contacts.normal, walls=True)
        gradient = np.zeros(self.n)
        gradient[: self.n_motions] = -bodies.dead_load[self.free]
        gradient[self.n_of_grains :] = [-force for force in bodies.presses.values()]
        return _move(static_stiffness(assemble(bodies.case)) * (stretch.T @ stretch), gradient)

    def _stretch(
        self, contacts: Contacts, direction: Array, *, walls: bool = False
    ) -> sparse.csr_array:
        """Derivatives by the unknowns of how far contacts are apart along directions (n, 3): (n,
        n_unknowns).

        Parameters
        ----------
        walls
            True for directions along normals, along which walls move in.
        """
        moved = self._approach(contacts.first, direction) - self._approach(
            contacts.second, direction
        )
        strained = np.zeros((len(direction), len(self.strains)))
        for place, (a, b) in enumerate(self.strains):
            strained[:, place] = direction[:, a] * contacts.shift[:, b]
            strained[:, place] += direction[:, b] * contacts.shift[:, a] if a != b else 0.0
        closed = np.zeros((len(direction), len(self.bodies.presses)))
        for place, names in enumerate(self.bodies.presses if walls else ()):
            closed[:, place] = -np.isin(contacts.wall.astype(str), names).astype(float)
        return sparse.csr_array(sparse.hstack([moved[:, : self.n_motions], strained, closed]))

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


@dataclasses.dataclass(frozen=True, eq=False)
class Balance:
    """Static state of grains.

    Attributes
    ----------
    bodies
        The grains, between walls that have moved in to their forces.
    position, periods
        Of the grains and of the cell: (n, 3) and (n_periods, 3), m.
    residual
        Largest net force on a grain over the largest force of a contact.
    """

    bodies: Bodies
    position: Array
    periods: Array
    residual: float

    @property
    def network(self) -> Network:
        """Springs of the contacts that bear force."""
        return self.bodies.network(self.position, self.periods)


def relax(bodies: Bodies) -> Balance:
    """Find the static state of grains under their loads, or, if they buckle, the balance from which
    they do.

    Raises
    ------
    InputError
        The loads press the grains together too far.
    RunError
        No balance was found.
    """
    if not bodies.presses:
        return _balance(_Problem(bodies))[0]
    elastic = PairLaws(elastic_case(bodies.case), bodies.laws.bodies)
    pressed, x = _balance(_Problem(dataclasses.replace(bodies, laws=elastic)))
    n = len(x) - len(bodies.presses)
    held = dataclasses.replace(pressed.bodies, laws=bodies.laws, presses={})
    state = _balance(_Problem(held), x[:n])[0]
    _check_presses(bodies, state, x[n:])
    return state


def _check_presses(bodies: Bodies, state: Balance, distances: Array) -> None:
    """Check that walls bear the forces to which they have moved in, and have not moved out.

    Parameters
    ----------
    distances
        By which the walls have moved in: (n_presses,), m.

    Raises
    ------
    InputError
        They do not, or have.
    """
    name = bodies.case.name
    contacts = state.bodies.near(state.position, state.periods, 0.0)
    springs = state.bodies.springs(contacts)
    for distance, (walls, asked) in zip(distances, bodies.presses.items(), strict=True):
        key = f"precompression.{walls[0].removesuffix('lo')}_force"
        each = asked / len(walls)
        if distance < 0:
            raise InputError(
                f"{name}: {key}: found {each:g} N, less than the packing presses on walls that "
                "only touch it under its other loads; give more, or the distance by which they "
                "move in"
            )
        force = float(springs.force[np.isin(contacts.wall.astype(str), walls)].sum()) / len(walls)
        if not abs(force / each - 1) <= FORCE_TOLERANCE:
            raise InputError(
                f"{name}: {key}: found walls that bear {force:.6g} N after the static stage, "
                f"expected {each:g} N: their distance is found with elastic contacts, and under "
                "this force some yield, or have dents; give a smaller force, or the distance by "
                "which they move in"
            )


def _balance(problem: _Problem, start: Array | None = None) -> tuple[Balance, Array]:
    """Return the static state of a problem and its unknowns there."""
    first = _start(problem) if start is None else start
    x, now = _search(problem, first)
    if (problem.loaded or now.largest) and not _balanced(problem, now):
        for other, way in _other_ways(problem):
            there, at = way(other, first)
            if _balanced(other, at):
                problem = other
                x = there
                now = at
                break
    net = _net(problem, now)
    residual = net / now.largest if now.largest else 0.0
    if now.largest and not _balanced(problem, now):
        raise RunError(
            f"{problem.bodies.case.name}: found no static state: a net force of {residual:.2g} of "
            "the largest contact force remains; a larger load, or less scatter, makes the packing "
            "rigid; or run the case, and give the directory of the run"
        )
    moved = problem.bodies.with_walls_in(x[problem.n_of_grains :])
    return Balance(moved, *problem.state(x), residual), x


def _other_ways(problem: _Problem) -> Iterator[tuple[_Problem, _Way]]:
    """Give the problems and the searches that find a balance where Newton's method does not."""
    if problem.n <= _BUCKLED_UP_TO:
        yield _Problem(problem.bodies, with_turning=True), _search
    if problem.n <= _FALLEN_UP_TO:
        yield problem, _fall


def _balanced(problem: _Problem, now: _At) -> bool:
    return now.largest > 0 and _net(problem, now) <= max(_TOLERATED * now.largest, now.rounding)


def _search(problem: _Problem, x: Array) -> tuple[Array, _At]:
    """Return the unknowns and the state that Newton's method reaches from a start."""
    now = problem.at(x)
    progress = _Progress(problem)
    for _ in range(_ROUNDS):
        if progress.ends(now):
            break
        move = _move(now.hessian, now.gradient, pivots=problem.with_turning)
        largest_move = np.abs(move[: problem.n_motions]).max(initial=0.0)
        if largest_move > _FARTHEST * problem.bodies.spacing:
            break  # motions that nothing resists: the packing buckles
        step = _downhill(problem, x, now, move)
        if step is None:
            break
        x, now = step
    return x, now


class _Progress:
    """Progress of a search, which tells when it is over."""

    def __init__(self, problem: _Problem) -> None:
        self.problem = problem
        self.balanced = _BALANCED if problem.n <= _DIRECT_UP_TO else _BALANCED_OF_MANY
        self.best = np.inf
        self.since = 0

    def ends(self, now: _At) -> bool:
        """Return True if a state is balanced, as far as rounding lets it."""
        net = _net(self.problem, now)
        self.since = 0 if net < 0.5 * self.best else self.since + 1
        self.best = min(self.best, net)
        enough = self.balanced * now.largest
        if net <= enough + 1e-300 or self.problem.n == 0:
            return True
        if self.since > _STALLED and net <= _OF_STALLED * enough:
            return True  # rounding, of more contacts than one
        return self.since > _NO_PROGRESS and net <= enough + now.rounding


def _fall(problem: _Problem, x: Array) -> tuple[Array, _At]:
    """Return the same as `_search`, by the method of Levenberg and Marquardt, which follows grains
    that nothing resists until something does.

    It starts before the load where the start is far away, since no contact resists there. Springs
    hold all grains in place during a step: they soften after each step that lowers the energy, and
    stiffen where one would not.
    """
    reach = _MARGIN / 2 * problem.bodies.spacing
    if np.abs(x[: problem.n_motions]).max(initial=0.0) > reach:
        x = np.zeros(problem.n)
    now = problem.at(x)
    progress = _Progress(problem)
    stiffness = float(static_stiffness(assemble(problem.bodies.case)))
    holding = _HOLDING * stiffness
    for _ in range(_ROUNDS_OF_FALL):
        if progress.ends(now):
            break
        while holding < _RIGID * stiffness:
            move = _move(now.hessian, now.gradient, holding=holding)
            if problem.largest_approach(now, move) <= reach:
                there = problem.at(x + move)
                if there.energy < now.energy or _net(problem, there) < _net(problem, now):
                    break
            holding *= _STIFFER
        else:
            break
        x = x + move
        now = there
        holding = max(holding / _SOFTER, _SOFT * stiffness)
    return x, now


def _downhill(problem: _Problem, x: Array, now: _At, move: Array) -> tuple[Array, _At] | None:
    """Return the unknowns after so much of a step that energy or net force falls; None if neither
    does.
    """
    net = _net(problem, now)
    size = 1.0
    margin = _MARGIN / 2 * problem.bodies.spacing
    if (approach := problem.largest_approach(now, move)) > margin:
        size = margin / approach
    while size >= _SMALLEST_STEP:
        there = problem.at(x + size * move)
        slack = 1e-13 * abs(now.energy)
        lower = not problem.with_turning and there.energy <= now.energy + slack
        if lower or _net(problem, there) < net:
            return x + size * move, there
        size /= 2
    return None


def _net(problem: _Problem, now: _At) -> float:
    """Largest net force on a grain, or that on the cell over the mean of its periods, N."""
    motions = float(np.abs(now.gradient[: problem.n_motions]).max(initial=0.0))
    lengths = np.linalg.norm(problem.bodies.periods, axis=1)
    cell = float(np.abs(now.gradient[problem.n_motions : problem.n_of_grains]).max(initial=0.0))
    walls = float(np.abs(now.gradient[problem.n_of_grains :]).max(initial=0.0))
    return max(motions, walls, cell / float(lengths.mean()) if len(lengths) else 0.0)


def _move(
    hessian: sparse.csr_array, gradient: Array, *, pivots: bool = False, holding: float = 0.0
) -> Array:
    """Newton's step; with pivots, for a matrix that is not definite, also towards balances that are
    no minimum.

    Parameters
    ----------
    holding
        Stiffness of springs that hold all grains in place, N/m; by default so soft that only free
        motions feel it.
    """
    diagonal = hessian.diagonal()
    soft = _SOFT * float(diagonal.mean()) if len(diagonal) else 1.0
    matrix = (hessian + (holding or soft or 1.0) * sparse.eye_array(len(diagonal))).tocsc()
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
        forces = problem.bodies.dead_load.any() or problem.bodies.presses
        return problem.by_linear_springs() if forces else np.zeros(problem.n)

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
