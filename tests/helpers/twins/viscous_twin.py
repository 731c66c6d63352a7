"""Chains of elastic spheres with viscous damping, solved by scipy's solver of ordinary differential
equations.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Law = Callable[[NDArray], tuple[NDArray, NDArray]]  # force and slope at positive overlaps


def hertz(modulus: float, ratio: float, radius: float) -> Law:
    """Law of two equal spheres."""
    constant = 4 / 3 * modulus / (2 * (1 - ratio**2)) * np.sqrt(radius / 2)
    return lambda a: (constant * a**1.5, 1.5 * constant * np.sqrt(a))


def power(constant: float, exponent: float) -> Law:
    """Power of the overlap."""
    return lambda a: (constant * a**exponent, exponent * constant * a ** (exponent - 1))


def forces(
    overlap: NDArray, rate: NDArray, law: Law, mass: float, time: float = 0.0, dashpot: float = 0.0
) -> NDArray:
    """Forces with a relaxation time, or with the factor of a dashpot; ``mass`` is the mass of one
    of two equal spheres.
    """
    pressed = np.maximum(overlap, 0.0)
    force, slope = law(pressed)
    coefficient = time * slope + dashpot * np.sqrt(2 / 3 * mass / 2 * slope)
    return np.where(overlap > 0, np.maximum(force + coefficient * rate, 0.0), 0.0)


def collision(law: Law, mass: float, speed: float, **loss: float) -> float:
    """Restitution of two equal bodies of this mass that collide at a speed."""
    found = chain(law, mass, 2, speed, end=None, **loss)
    return float(found["velocity"][1, -1] - found["velocity"][0, -1]) / speed


def chain(
    law: Law, mass: float, n: int, speed: float, end: float | None, **loss: float
) -> dict[str, NDArray]:
    """Chain of ``n`` bodies that just touch; the first has an initial speed.

    Returns
    -------
    dict
        ``velocity`` (n, n_times), m/s; ``force`` of the contacts (n - 1, n_times), N; ``time``
        (n_times,), s.
    """

    def rates(_: float, state: NDArray) -> NDArray:
        place, velocity = np.split(state, 2)
        force = forces(-np.diff(place), -np.diff(velocity), law, mass, **loss)
        pushed = np.zeros(n)
        pushed[:-1] -= force
        pushed[1:] += force
        return np.concatenate([velocity, pushed / mass])

    def parted(_: float, state: NDArray) -> float:
        return state[1] - state[0] - (1e-15 if end is None else -1.0)

    parted.terminal = True
    parted.direction = 1.0
    start = np.zeros(2 * n)
    start[n] = speed
    found = solve_ivp(
        rates, (0.0, end or 1.0), start, rtol=1e-10, atol=1e-15, events=parted if end is None else None,
        t_eval=None if end is None else np.linspace(0, end, 4001),
    )  # fmt: skip
    place, velocity = np.split(found.y, 2)
    force = forces(-np.diff(place, axis=0), -np.diff(velocity, axis=0), law, mass, **loss)
    return {"velocity": velocity, "force": force, "time": found.t}
