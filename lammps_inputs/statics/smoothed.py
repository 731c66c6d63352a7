"""Static state of grains near jamming: a path from smoothed contacts to the contacts of the case.

Near jamming there are hardly more contacts than degrees of freedom. Newton's method does not take
into account gaps that a step closes, and each contact that opens leaves grains without support.
Contacts are therefore smoothed first (Chen and Harker, SIAM J. Matrix Anal. Appl. 14 (1993) 1168):
a contact of the overlap d gets the overlap a with a (a - d) = s^2, which is positive across gaps
too. The smoothing s shrinks step by step. Each equilibrium starts from the previous equilibrium,
and the last equilibrium is without smoothing.

The second derivatives include the turning of forces, which is not negligible for the soft motions
of such a packing. If they are indefinite, springs hold the grains during a step. The energy
decreases along each step, which ends near its minimum, or continues as long as the energy falls, as
in a packing that buckles.
"""

from __future__ import annotations

import math

import numpy as np
from scipy import sparse

from granwave.lammps_inputs.statics.bodies import Array
from granwave.lammps_inputs.statics.energy import (
    MARGIN,
    SOFT,
    EnergyProblem,
    Evaluation,
    factorised,
)

_SHRINK = 0.3  # smoothing / smoothing of the balance before
_LEAST = 1e-4  # smallest smoothing / overlap under the load
_ROUNDS = 250  # largest number of steps with a smoothing ...
_ROUNDS_AT_END = 150  # ... and without
_NEAR = 0.03  # net force / largest load on a grain with the first smoothing; it shrinks with it ...
_NEAREST = 1e-6  # ... down to this
_BALANCED = 1e-7  # net force / largest contact force, at the end
_LEAST_HOLDING = 1e-7  # smallest stiffness that holds the grains / mean stiffness
_STIFFER = 4.0  # factor of its growth, and of its decay from step to step
_MOST_HOLDINGS = 40  # largest number of factorisations in a step
_TRIALS = 30  # largest number of sizes of a step
_SMALLEST_CUT = 0.1  # bounds of a shorter size / size that went too far
_LARGEST_CUT = 0.7
_FLAT = 0.5  # slope of the energy at the end of a step / slope at its start
_LONGER = 2.0  # factor of a size where the energy still falls


def follow_smoothing(problem: EnergyProblem, x: Array, overlap: float) -> tuple[Array, Evaluation]:
    """Return the unknowns and the state of balance that the path from smooth contacts reaches.

    Parameters
    ----------
    overlap
        Typical overlap of a contact under the load, m.
    """
    load = float(np.abs(problem.bodies.dead_load).max(initial=0.0))
    smoothing = math.sqrt(overlap * _typical_gap(problem, x))
    near = _NEAR
    while smoothing > _LEAST * overlap:
        x, _ = _minimum(problem, x, smoothing, near * load)
        now = problem.at(x)
        if is_balanced(now):
            return x, now
        smoothing *= _SHRINK
        near = max(_SHRINK * near, _NEAREST)
    return _minimum(problem, x)


def largest_net_force(now: Evaluation) -> float:
    """Return the largest component of a net force, N."""
    return float(np.abs(now.gradient).max(initial=0.0))


def is_balanced(now: Evaluation) -> bool:
    """Return True if net forces are negligible next to contact forces."""
    return largest_net_force(now) <= _BALANCED * now.largest + now.rounding


def _typical_gap(problem: EnergyProblem, x: Array) -> float:
    """Return the median distance from touching of the nearest contacts, as many as degrees of
    freedom, m.
    """
    overlap = np.sort(problem.at(x).contacts.overlap)[::-1]
    return float(np.median(np.abs(overlap[: problem.n])))


def _minimum(
    problem: EnergyProblem, x: Array, smoothing: float = 0.0, near: float = 0.0
) -> tuple[Array, Evaluation]:
    """Return the unknowns and the state near a minimum of the energy with a smoothing, m.

    Parameters
    ----------
    near
        Net force at which the search ends, N; without a smoothing it ends in balance.
    """
    now = problem.at(x, smoothing)
    holding = 0.0
    for _ in range(_ROUNDS if smoothing else _ROUNDS_AT_END):
        if largest_net_force(now) <= near if smoothing else is_balanced(now):
            break
        descent = _descent(problem, now, holding / _STIFFER)
        if descent is None:
            break
        step, holding = descent
        reached = _along(problem, x, now, step, smoothing)
        if reached is None:
            break
        x, now = reached
    return x, now


def _descent(problem: EnergyProblem, now: Evaluation, holding: float) -> tuple[Array, float] | None:
    """Return a step of Newton's method along which the energy decreases, and the stiffness of the
    springs that hold the grains, N/m; None if there is no such step.

    Parameters
    ----------
    holding
        Stiffness to begin with, N/m.
    """
    hessian = now.hessian
    mean = float(hessian.diagonal().mean())
    least = _LEAST_HOLDING * mean
    if holding < least:
        holding = 0.0
    for _ in range(_MOST_HOLDINGS):
        soft = (SOFT * mean + holding) * sparse.eye_array(problem.n)
        factors = factorised(hessian + soft)
        # the pivots stay on the diagonal, so that their signs are those of the eigenvalues
        if not problem.with_turning or factors.U.diagonal().min() > 0:
            step = np.asarray(factors.solve(-now.gradient))
            if step @ now.gradient < 0:
                return step, holding
        holding = max(_STIFFER * holding, least)
    return None


def _along(
    problem: EnergyProblem, x: Array, now: Evaluation, step: Array, smoothing: float
) -> tuple[Array, Evaluation] | None:
    """Return the unknowns and the state after a step of suitable length; None if the energy rises
    even after the smallest step.

    The slopes of the energy along the step are compared, which rounding affects less than the
    energy.
    """
    reach = MARGIN / 2 * problem.bodies.spacing
    approach = problem.largest_approach(now, step)
    start = float(now.gradient @ step)
    size = min(1.0, reach / approach) if approach else 1.0
    for _ in range(_TRIALS):
        reached = problem.at(x + size * step, smoothing)
        slope = float(reached.gradient @ step)
        if slope <= -_FLAT * start:
            break
        cut = start / (start - slope)
        size *= min(max(cut, _SMALLEST_CUT), _LARGEST_CUT)
    else:
        return None
    while slope < _FLAT * start and _LONGER * size * approach <= reach:
        farther = problem.at(x + _LONGER * size * step, smoothing)
        slope = float(farther.gradient @ step)
        if slope > -_FLAT * start:
            break
        size *= _LONGER
        reached = farther
    return x + size * step, reached
