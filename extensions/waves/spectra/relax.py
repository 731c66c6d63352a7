"""Static state of grains under load, by Newton's method on their `EnergyProblem`.

As in the static stage of a run, walls move in to their force with elastic contacts, and stay there.

A packing that buckles has no static state near the places that it is given. Newton's method with
the turning of forces then finds the one in which all forces balance and from which it buckles: some
motions lower its energy. Grains that are loose at first are followed until they touch others.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from typing import TypeAlias

import numpy as np

from granwave.extensions.waves.spectra.bodies import Bodies
from granwave.extensions.waves.spectra.energy import (
    DIRECT_UP_TO,
    MARGIN,
    SOFT,
    EnergyProblem,
    Evaluation,
    newton_step,
)
from granwave.extensions.waves.spectra.network import Array, Network
from granwave.extensions.waves.spectra.pair_laws import PairLaws
from granwave.lammps_inputs.contact.law import elastic_case
from granwave.lammps_inputs.contact.static_load import static_stiffness
from granwave.lammps_inputs.deck.static_stage import FORCE_TOLERANCE
from granwave.lammps_inputs.errors import InputError, RunError

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
# unknowns: whose balance is sought with the turning of forces, by factors with pivots
_BUCKLED_UP_TO = 6000
_FALLEN_UP_TO = 200_000  # unknowns: whose loose grains are followed
_FIRST_STRAIN = 1e-7
_LARGEST_STRAIN = 0.05
_HALVINGS = 5  # of the interval in which the first strain is sought


_Way: TypeAlias = "Callable[[EnergyProblem, Array], tuple[Array, Evaluation]]"


@dataclasses.dataclass(frozen=True, eq=False)
class StaticState:
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


def relax(bodies: Bodies) -> StaticState:
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
        return _balance(EnergyProblem(bodies))[0]
    elastic = PairLaws(elastic_case(bodies.case), bodies.laws.bodies)
    pressed, x = _balance(EnergyProblem(dataclasses.replace(bodies, laws=elastic)))
    n = len(x) - len(bodies.presses)
    confined = dataclasses.replace(pressed.bodies, laws=bodies.laws, presses={})
    state = _balance(EnergyProblem(confined), x[:n])[0]
    _check_presses(bodies, state, x[n:])
    return state


def _check_presses(bodies: Bodies, state: StaticState, distances: Array) -> None:
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
    for distance, (walls, applied) in zip(distances, bodies.presses.items(), strict=True):
        key = f"precompression.{walls[0].removesuffix('lo')}_force"
        each = applied / len(walls)
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
            "the largest contact force remains; a larger load, or less scatter, makes the packing "
            "rigid; or run the case, and give the directory of the run"
        )
    moved = problem.bodies.with_walls_in(x[problem.n_of_grains :])
    return StaticState(moved, *problem.state(x), residual), x


def _other_ways(problem: EnergyProblem) -> Iterator[tuple[EnergyProblem, _Way]]:
    """Give the problems and the searches that find a balance where Newton's method does not."""
    if problem.n <= _BUCKLED_UP_TO:
        yield EnergyProblem(problem.bodies, with_turning=True), _search
    if problem.n <= _FALLEN_UP_TO:
        yield problem, _fall


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
    """Progress of a search, which tells when it is over."""

    def __init__(self, problem: EnergyProblem) -> None:
        self.problem = problem
        self.balanced = _BALANCED if problem.n <= DIRECT_UP_TO else _BALANCED_OF_MANY
        self.best = np.inf
        self.since = 0

    def ends(self, now: Evaluation) -> bool:
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


def _fall(problem: EnergyProblem, x: Array) -> tuple[Array, Evaluation]:
    """Return the same as `_search`, by the method of Levenberg and Marquardt, which follows grains
    that nothing resists until something does.

    It starts before the load where the start is far away, since no contact resists there. Springs
    hold all grains in place during a step: they soften after each step that lowers the energy, and
    stiffen where one would not.
    """
    reach = MARGIN / 2 * problem.bodies.spacing
    if np.abs(x[: problem.n_motions]).max(initial=0.0) > reach:
        x = np.zeros(problem.n)
    now = problem.at(x)
    progress = _Progress(problem)
    stiffness = float(static_stiffness(problem.bodies.assembly))
    holding = _HOLDING * stiffness
    for _ in range(_ROUNDS_OF_FALL):
        if progress.ends(now):
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
        x = x + move
        now = trial
        holding = max(holding / _SOFTER, SOFT * stiffness)
    return x, now


def _downhill(
    problem: EnergyProblem, x: Array, now: Evaluation, move: Array
) -> tuple[Array, Evaluation] | None:
    """Return the unknowns after so much of a step that energy or net force falls; None if neither
    does.
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
    """Largest net force on a grain, or that on the cell over the mean of its periods, N."""
    motions = float(np.abs(now.gradient[: problem.n_motions]).max(initial=0.0))
    lengths = np.linalg.norm(problem.bodies.periods, axis=1)
    cell = float(np.abs(now.gradient[problem.n_motions : problem.n_of_grains]).max(initial=0.0))
    walls = float(np.abs(now.gradient[problem.n_of_grains :]).max(initial=0.0))
    return max(motions, walls, cell / float(lengths.mean()) if len(lengths) else 0.0)


def _start(problem: EnergyProblem) -> Array:
    """Unknowns at which the even strain of the cell bears the load: contacts are closed there."""
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
                f"{problem.bodies.case.name}: precompression: would shorten the cell by more than "
                f"{100 * _LARGEST_STRAIN:g} %; give a smaller load, or a cell across which the grains touch"
            )
    low = high / 4 if high > _FIRST_STRAIN else 0.0
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if excess(middle) > 0 else (low, middle)
    return problem.uniform(high)
