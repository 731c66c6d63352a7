"""Viscoelastic contacts computed in two independent ways: by a solver of ordinary differential
equations of scipy, and as a foundation of many springs, each of which relaxes.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Branches = list[tuple[float, float]]  # weight and time (s)


def relaxation(branches: Branches, time: NDArray) -> NDArray:
    """Modulus divided by the instantaneous one, (n_times,)."""
    left = np.ones_like(time)
    for weight, constant in branches:
        left -= weight * (1 - np.exp(-time / constant))
    return left


def collision(
    law: Callable[[float], float], mass: float, speed: float, branches: Branches, longest: float
) -> float:
    """Restitution of two bodies with this effective mass (kg), for a law that gives the force at an
    overlap.

    The force is P less the weighted delayed forces q, with dq/dt = (P - q)/tau. The collision ends
    when the force vanishes.

    Parameters
    ----------
    longest
        Longest step of the solver, s.
    """
    weights, times = np.array(branches).T

    def force(state: NDArray) -> float:
        return float(law(max(state[0], 0.0)) - weights @ state[2:])

    def rates(_: float, state: NDArray) -> NDArray:
        late = state[2:]
        relaxing = (law(max(state[0], 0.0)) - late) / times
        return np.concatenate([[state[1], -force(state) / mass], relaxing])

    def parted(_: float, state: NDArray) -> float:
        return force(state) if state[1] < 0 else 1.0

    parted.terminal = True
    start = np.concatenate([[0.0, speed], np.zeros(len(weights))])
    accuracy = {"rtol": 1e-11, "atol": 1e-18, "max_step": longest}
    found = solve_ivp(rates, (0, 1.0), start, events=parted, method="DOP853", **accuracy)
    return -float(found.y[1, -1]) / speed


def chain(
    constant: float, mass: float, n: int, speed: float, end: float, branches: Branches
) -> NDArray:
    """Largest force of each contact (N), (n - 1,), of ``n`` bodies that just touch, of which the
    first has a speed.

    Where the delayed forces exceed P, the surfaces have separated, and these forces take its place.
    """
    weights, times = np.array(branches).T
    delayed = (n - 1, len(weights))

    def forces(state: NDArray) -> tuple[NDArray, NDArray, NDArray]:
        overlap = np.maximum(-np.diff(state[:n]), 0.0)
        late = state[2 * n :].reshape(delayed)
        law = np.maximum(constant * overlap**1.5, late @ weights)
        return law - late @ weights, law, late

    def rates(_: float, state: NDArray) -> NDArray:
        force, law, late = forces(state)
        pushed = np.zeros(n)
        pushed[:-1] -= force
        pushed[1:] += force
        relaxing = (law[:, None] - late) / times
        return np.concatenate([state[n : 2 * n], pushed / mass, relaxing.ravel()])

    start = np.zeros(2 * n + (n - 1) * len(weights))
    start[n] = speed
    at = np.linspace(0, end, 4001)
    found = solve_ivp(rates, (0.0, end), start, rtol=1e-9, atol=1e-14, t_eval=at)
    return np.max([forces(state)[0] for state in found.y.T], axis=0)


def foundation(
    constant: float, overlap: NDArray, time: NDArray, branches: Branches, n_springs: int
) -> tuple[NDArray, NDArray]:
    """Force (N) and stored energy (J) of a foundation that a growing overlap (m) presses, each
    (n_times,).

    Hertz's P is the sum of springs that touch one after the other: the spring that touches at the
    overlap r has the stiffness dk/dr for the overlap beyond r, with the slope k of P.
    """
    edges = np.linspace(0.0, overlap.max(), n_springs + 1) ** 2 / overlap.max()
    stiffness = np.diff(1.5 * constant * np.sqrt(edges))
    met = 0.5 * (edges[1:] + edges[:-1])
    pressed = np.maximum(overlap[:, None] - met, 0.0)
    rest = 1 - sum(weight for weight, _ in branches)
    force = rest * pressed @ stiffness
    energy = 0.5 * rest * pressed**2 @ stiffness
    for weight, constant_of in branches:
        elastic = np.zeros_like(met)
        for k in range(1, len(time)):
            step = time[k] - time[k - 1]
            left = np.exp(-step / constant_of)
            gain = (1 - left) * constant_of / step
            elastic = left * elastic + gain * (pressed[k] - pressed[k - 1])
            force[k] += weight * elastic @ stiffness
            energy[k] += 0.5 * weight * elastic**2 @ stiffness
    return force, energy
