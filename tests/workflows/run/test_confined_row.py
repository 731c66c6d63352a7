"""A row of beads with rings of small spheres in a tube, beside equations of symmetric motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import root

from granwave._contact_laws import elliptic_radius
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.workflows.run.driver import run_case

N, BIG, STRUCK, SPEED, END = 14, 0.015, 5, 1.0, 1.6e-4
BRASS = {"name": "brass", "youngs_modulus": 115e9, "poisson_ratio": 0.30, "density": 8500.0, "yield_strength": 550e6}
MODULUS = 115e9 / (1 - 0.3**2) / 2  # of two like bodies


class Row:
    """Big spheres on the axis, and in every gap a ring of ``n`` small ones that move alike: axial w, outward u."""

    def __init__(self, n: int, shrinks: float) -> None:
        self.n, self.shrinks = n, shrinks
        self.small = 2 * BIG * np.tan(np.pi / n) ** 2
        self.ring = np.sqrt(self.small**2 + 2 * self.small * BIG) / 2
        self.tube = self.ring + self.small / 2
        r, inner = self.small / 2, self.tube - shrinks
        self.k_big = 4 / 3 * MODULUS * np.sqrt(BIG / 4)
        self.k_side = 4 / 3 * MODULUS * np.sqrt(BIG * self.small / 2 / (BIG + self.small))
        self.k_ring = 4 / 3 * MODULUS * np.sqrt(r / 2)
        self.k_wall = 4 / 3 * 2 * MODULUS * np.sqrt(elliptic_radius(1 / r, 1 / r - 1 / inner))
        self.mass = 8500 * np.pi / 6 * np.array([BIG**3, self.small**3])

    def forces(
        self, z: np.ndarray, w: np.ndarray, u: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Contact forces of neighbouring big spheres; forces on big spheres, and on small ones along and outward."""

        def hertz(stiffness: float, overlap: np.ndarray) -> np.ndarray:
            return stiffness * np.maximum(overlap, 0.0) ** 1.5

        push = hertz(self.k_big, z[:-1] - z[1:])
        on_big = np.zeros(len(z))
        on_big[:-1] -= push
        on_big[1:] += push
        axial, outward = np.zeros(len(w)), np.zeros(len(w))
        for side, place in ((-1, z[:-1]), (1, z[1:])):
            along, across = BIG / 2 * -side + w - place, self.ring + u
            apart = np.hypot(along, across)
            force = hertz(self.k_side, (BIG + self.small) / 2 - apart)
            axial += force * along / apart
            outward += force * across / apart
            on_big[slice(0, -1) if side < 0 else slice(1, None)] -= self.n * force * along / apart
        outward -= hertz(self.k_wall, u + self.shrinks)
        outward += 2 * hertz(self.k_ring, -2 * u * np.sin(np.pi / self.n)) * np.sin(np.pi / self.n)
        on_big[[0, -1]] = 0.0
        return push, on_big, axial, outward

    def struck(self) -> tuple[np.ndarray, np.ndarray]:
        """Peak forces between big spheres, and their velocities at the end."""

        def unpack(state: np.ndarray) -> list[np.ndarray]:
            return np.split(state, np.cumsum([N, N - 1, N - 1, N, N - 1]))

        rest = np.zeros(6 * N - 4)
        if self.shrinks:
            middle = root(lambda u: self.forces(np.zeros(N), np.zeros(N - 1), u)[3], np.full(N - 1, -self.shrinks / 2),
                          tol=1e-14).x  # fmt: skip
            rest[2 * N - 1 : 3 * N - 2] = middle
        rest[3 * N - 2 + STRUCK - 1] = SPEED

        def rates(_: float, state: np.ndarray) -> np.ndarray:
            z, w, u, *velocities = unpack(state)
            _, on_big, axial, outward = self.forces(z, w, u)
            return np.concatenate([*velocities, on_big / self.mass[0], axial / self.mass[1], outward / self.mass[1]])

        times = np.linspace(0, END, 3201)
        found = solve_ivp(rates, (0, END), rest, method="DOP853", t_eval=times, rtol=1e-9, atol=1e-13).y
        pushes = np.array([self.forces(*unpack(state)[:3])[0] for state in found.T])
        return pushes.max(axis=0), unpack(found[:, -1])[3]


@pytest.mark.parametrize(("n", "shrinks"), [(8, 9e-6), pytest.param(6, 0.0, marks=pytest.mark.validation)])
def test_waves_in_a_confined_row(tmp_path: Path, n: int, shrinks: float) -> None:
    row = Row(n, shrinks)
    ring = {"ring": {"n": n, "radius": row.ring, "z": BIG / 2}, "repeat": {"times": N - 1, "step": [0.0, 0.0, BIG]}}
    tables = {
        "name": "row", "material": BRASS, "contact": {"law": "hertz"},
        "packing": {"kind": "chain", "size": N, "diameter": BIG},
        "grains": [ring | {"diameter": row.small}], "hold": [{"index": [1, N]}],
        "boundary": {"bottom": "free", "sides": {"tube": {"radius": row.tube}}},
        "load": {"index": [STRUCK], "velocity": SPEED}, "run": {"end_time": END, "frames": 2},
    }  # fmt: skip
    if shrinks:
        tables["precompression"] = {"kind": "walls", "tube": shrinks}
    outcome = run_case(case_from_dict(tables), tmp_path, figures=False)
    assert outcome.summary["energy_balance_error"] < 3e-6
    forces, velocities = row.struck()
    with Result(tmp_path) as result:
        i, j = result["contacts/i"], result["contacts/j"]
        big = (i <= N) & (j <= N)
        peaks = np.zeros(N - 1)
        peaks[i[big] - 1] = result["contacts/peak_force"][big]
        last = result.frame(1, "velocity")[:N, 2]
    assert peaks[STRUCK - 1 :] == pytest.approx(forces[STRUCK - 1 :], rel=2e-4, abs=1e-3)
    assert last == pytest.approx(velocities, abs=2e-4 * SPEED)
