"""Static state of grains under load, by Newton's method on their `EnergyProblem`.

As in the static stage of a run, walls move in with elastic contacts until they carry their forces,
and then stay.

A packing that buckles has no stable static state near its given positions. Newton's method with the
turning of forces then finds the state in which all forces balance and from which the packing
buckles: some motions lower its energy. Grains that are initially loose are followed until they
touch others.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from typing import TypeAlias

import numpy as np

from granwave.lammps_inputs.contact.static_load import FORCE_TOLERANCE, static_stiffness
from granwave.lammps_inputs.errors import InputError, RunError
from granwave.lammps_inputs.statics.bodies import Array, Bodies
from granwave.lammps_inputs.statics.energy import (
    DIRECT_UP_TO,
    MARGIN,
    ROUNDING,
    SOFT,
    EnergyProblem,
    Evaluation,
    newton_step,
)

_ROUNDS = 200  # largest number of steps of Newton's method
_ROUNDS_OF_FALL = 1000  # largest number of steps of grains that fall until they touch others
_HOLDING = 1e-3  # first stiffness that holds them in a step / stiffness of a contact
_RIGID = 1e9  # largest such stiffness / stiffness of a contact
_STIFFER = 4.0  # factor of its growth
_SOFTER = 3.0  # factor of its decay
_BALANCED = 1e-11  # net force / largest contact force in balance ...
_BALANCED_OF_MANY = 1e-9  # ... of many grains ...
_TOLERATED = 1e-6  # ... and where rounding leaves more
_NO_PROGRESS = 3  # steps without progress after which a net force by rounding is accepted
_STALLED = 6  # steps without progress after which a larger net force is accepted ...
_OF_STALLED = 100.0  # ... by this factor
_SMALLEST_STEP = 2.0**-10  # smallest part of a step
_FARTHEST = 1e3  # longest step, mean diameters; longer steps are motions without resistance
_BUCKLED_UP_TO = 6000  # number of unknowns up to which the turning of forces is included
_FALLEN_UP_TO = 200_000  # number of unknowns up to which loose grains are followed
_FIRST_STRAIN = 1e-7  # smallest trial of the first strain
_LARGEST_STRAIN = 0.05  # largest strain of the cell
_HALVINGS = 5  # halvings of the interval of the first strain


_Way: TypeAlias = "Callable[[EnergyProblem, Array], tuple[Array, Evaluation]]"


@dataclasses.dataclass(frozen=True, eq=False)
class StaticState:
    """Static state of grains.

    Attributes
    ----------
    bodies
        The grains, between walls that have moved in to their forces.
    position, periods
        Positions of the grains, and periods of the cell: (n, 3) and (n_periods, 3), m.
    residual
        Largest net force on a grain / largest force of a contact.
    """

    bodies: Bodies
    position: Array
    periods: Array
    residual: float


def relax(bodies: Bodies) -> StaticState:
    """Find the static state of grains under their loads, or, if they buckle, the equilibrium from
    which they buckle.

    Raises
    ------
    InputError
        The loads press the grains together too far.
    RunError
        No balance was found.
    """
    if not bodies.presses:
        return _balance(EnergyProblem(bodies))[0]
    pressed, x = _balance(EnergyProblem(bodies.elastic()))
    n = len(x) - len(bodies.presses)
    confined = dataclasses.replace(pressed.bodies, laws=bodies.laws, presses={})
    state = _balance(EnergyProblem(confined), x[:n])[0]
    _check_presses(bodies, state, x[n:])
    return state


def _check_presses(bodies: Bodies, state: StaticState, distances: Array) -> None:
    """Check that walls have moved in, and carry their prescribed forces.

    Parameters
    ----------
    distances
        Distances by which the walls have moved in: (n_presses,), m.

    Raises
    ------
    InputError
        They do not, or have.
    """
    name = bodies.case.name
    contacts = state.bodies.near(state.position, state.periods, 0.0)
    forces = np.zeros(len(contacts))
    for law, rows, scale in state.bodies.laws_of(contacts):
        forces[rows], _, _ = law.evaluate(contacts.overlap[rows], scale)
    for distance, (walls, applied) in zip(distances, bodies.presses.items(), strict=True):
        key = f"precompression.{walls[0].removesuffix('lo')}_force"
        each = applied / len(walls)
        if distance < 0:
            raise InputError(
                f"{name}: {key}: found {each:g} N, which is less than the force on touching walls "
                "under the other loads; use a larger force, or the distance by which the walls "
                "move in"
            )
        force = float(forces[np.isin(contacts.wall.astype(str), walls)].sum()) / len(walls)
        if not abs(force / each - 1) <= FORCE_TOLERANCE:
            raise InputError(
                f"{name}: {key}: found walls that carry {force:.6g} N after the static stage, "
                f"expected {each:g} N: their distance is computed with elastic contacts, but some "
                "contacts yield under this force, or have plastic indentations; use a smaller "
                "force, or the distance by which the walls move in"
            )


def _balance(problem: EnergyProblem, start: Array | None = None) -> tuple[StaticState, Array]:
    """Return the static state of a problem and its unknowns there."""
    first = _start(problem) if start is None else start
    x, now = _search(problem, first)
    if (problem.loaded or now.largest) and not _balanced(problem, now):
        for other, method in _other_ways(problem):
            unknowns, evaluation = method(other, first)
            if _balanced(other, evaluation):
                problem = other
                x = unknowns
                now = evaluation
                break
    net = _net(problem, now)
    residual = net / now.largest if now.largest else 0.0
    if now.largest and not _balanced(problem, now):
        raise RunError(
            f"{problem.bodies.case.name}: found no static state: a net force of {residual:.2g} of "
            "the largest contact force remains; use a larger load or less scatter to make the "
            "packing rigid, or run the case and use the directory of the run"
        )
    moved = problem.bodies.with_walls_in(x[problem.n_of_grains :])
    return StaticState(moved, *problem.state(x), residual), x


def _other_ways(problem: EnergyProblem) -> Iterator[tuple[EnergyProblem, _Way]]:
    """Yield the problems and searches that find an equilibrium if Newton's method does not."""
    if problem.n <= _BUCKLED_UP_TO:
        yield EnergyProblem(problem.bodies, with_turning=True), _search
    if problem.n <= _FALLEN_UP_TO:
        yield problem, fall


def _balanced(problem: EnergyProblem, now: Evaluation) -> bool:
    return now.largest > 0 and _net(problem, now) <= max(_TOLERATED * now.largest, now.rounding)


def _search(problem: EnergyProblem, x: Array) -> tuple[Array, Evaluation]:
    """Return the unknowns and the state that Newton's method reaches from a start."""
    now = problem.at(x)
    progress = _Progress(problem)
    for _ in range(_ROUNDS):
        if progress.ends(now):
            break
        move = newton_step(now.hessian, now.gradient, pivots=problem.with_turning)
        largest_move = np.abs(move[: problem.n_motions]).max(initial=0.0)
        if largest_move > _FARTHEST * problem.bodies.spacing:
            break  # motions that nothing resists: the packing buckles
        step = _downhill(problem, x, now, move)
        if step is None:
            break
        x, now = step
    return x, now


class _Progress:
    """Progress of a search, with its end."""

    def __init__(self, problem: EnergyProblem) -> None:
        self.problem = problem
        self.balanced = _BALANCED if problem.n <= DIRECT_UP_TO else _BALANCED_OF_MANY
        self.best = np.inf
        self.since = 0

    def ends(self, now: Evaluation) -> bool:
        """Return True if a state is balanced up to rounding."""
        net = _net(self.problem, now)
        self.since = 0 if net < 0.5 * self.best else self.since + 1
        self.best = min(self.best, net)
        enough = self.balanced * now.largest
        if net <= enough + 1e-300 or self.problem.n == 0:
            return True
        if self.since > _STALLED and net <= _OF_STALLED * enough:
            return True  # rounding, with several contacts
        return self.since > _NO_PROGRESS and net <= enough + now.rounding

    def is_rounding(self, now: Evaluation, stiffness: float) -> bool:
        """Return True if the net forces are rounding errors of much larger contact forces.

        Parameters
        ----------
        stiffness
            Stiffness of a contact under the load, N/m.
        """
        span = float(np.abs(self.problem.bodies.position).max(initial=0.0))
        rounding = ROUNDING * stiffness * np.finfo(float).eps * span
        enough = min(self.balanced * now.largest + rounding, _TOLERATED * now.largest)
        return bool(now.largest > 0 and _net(self.problem, now) <= enough)


def fall(
    problem: EnergyProblem,
    x: Array,
    farthest: float = np.inf,
) -> tuple[Array, Evaluation]:
    """Return the unknowns and the state that the method of Levenberg (1944) and Marquardt (1963)
    reaches from a start. The method follows loose grains until they touch others.

    If the start is far from the unloaded state, the search begins in the unloaded state, since no
    contact resists at the start. Springs hold all grains in place during a step. They soften after
    each step that lowers the energy or the net force, and stiffen if a step would lower neither
    energy nor net force.

    Parameters
    ----------
    farthest
        Largest displacement of a grain along an axis, at which the search ends, m.
    """
    reach = MARGIN / 2 * problem.bodies.spacing
    if np.abs(x[: problem.n_motions]).max(initial=0.0) > reach:
        x = np.zeros(problem.n)
    now = problem.at(x)
    progress = _Progress(problem)
    stiffness = float(static_stiffness(problem.bodies.assembly))
    holding = _HOLDING * stiffness
    for _ in range(_ROUNDS_OF_FALL):
        # where only rounding is left, motions that hardly anything resists would grow
        if progress.ends(now) or progress.is_rounding(now, stiffness):
            break
        while holding < _RIGID * stiffness:
            move = newton_step(now.hessian, now.gradient, holding=holding)
            if problem.largest_approach(now, move) <= reach:
                trial = problem.at(x + move)
                if trial.energy < now.energy or _net(problem, trial) < _net(problem, now):
                    break
            holding *= _STIFFER
        else:
            break
        if np.abs(x[: problem.n_motions] + move[: problem.n_motions]).max(initial=0.0) > farthest:
            break
        x = x + move
        now = trial
        holding = max(holding / _SOFTER, SOFT * stiffness)
    return x, now


def _downhill(
    problem: EnergyProblem, x: Array, now: Evaluation, move: Array
) -> tuple[Array, Evaluation] | None:
    """Return the unknowns after a part of a step that lowers energy or net force; None if there is
    no such part.
    """
    net = _net(problem, now)
    size = 1.0
    margin = MARGIN / 2 * problem.bodies.spacing
    if (approach := problem.largest_approach(now, move)) > margin:
        size = margin / approach
    while size >= _SMALLEST_STEP:
        trial = problem.at(x + size * move)
        slack = 1e-13 * abs(now.energy)
        lower = not problem.with_turning and trial.energy <= now.energy + slack
        if lower or _net(problem, trial) < net:
            return x + size * move, trial
        size /= 2
    return None


def _net(problem: EnergyProblem, now: Evaluation) -> float:
    """Return the largest net force on a grain, a wall, or the cell (divided by its
    mean period), N.
    """
    motions = float(np.abs(now.gradient[: problem.n_motions]).max(initial=0.0))
    lengths = np.linalg.norm(problem.bodies.periods, axis=1)
    cell = float(np.abs(now.gradient[problem.n_motions : problem.n_of_grains]).max(initial=0.0))
    walls = float(np.abs(now.gradient[problem.n_of_grains :]).max(initial=0.0))
    return max(motions, walls, cell / float(lengths.mean()) if len(lengths) else 0.0)


def _start(problem: EnergyProblem) -> Array:
    """Unknowns at which a uniform strain balances the load, so that contacts are closed."""
    diagonal = [
        place for place, (a, b) in enumerate(problem.strains, start=problem.n_motions) if a == b
    ]
    load = sum(
        problem.bodies.stress[strain] for strain in problem.strains if strain[0] == strain[1]
    )
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
                f"{problem.bodies.case.name}: precompression: shortens the cell by more than "
                f"{100 * _LARGEST_STRAIN:g} %; use a smaller load, or a cell across which the "
                "grains touch"
            )
    low = high / 4 if high > _FIRST_STRAIN else 0.0
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if excess(middle) > 0 else (low, middle)
    return problem.uniform(high)
