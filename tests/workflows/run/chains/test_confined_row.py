"""Chains in tubes, and chains with cylinders at their gaps."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import root

import granwave as gw
from granwave._contact_laws import elliptic_radius
from granwave.analysis.result.reader import Result
from granwave.analysis.summary_table import summary_table
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.measures import GrainRow, first_peak, largest_of_pulses, push_starts
from granwave.workflows import load_case
from granwave.workflows.run.driver import run_case
from tests.helpers.bodies.symmetric_row import SymmetricRow

N = 14
BIG = 0.015
STRUCK = 5
SPEED = 1.0
END = 1.6e-4
BRASS = {
    "name": "brass",
    "youngs_modulus": 115e9,
    "poisson_ratio": 0.30,
    "density": 8500.0,
    "yield_strength": 550e6,
}
MODULUS = 115e9 / (1 - 0.3**2) / 2  # of two like bodies


class Row:
    """Big spheres on the axis, and in every gap a ring of ``n`` small spheres with equal motion:
    axial w, outward u.
    """

    def __init__(self, n: int, shrinks: float) -> None:
        self.n = n
        self.shrinks = shrinks
        self.small = 2 * BIG * np.tan(np.pi / n) ** 2
        self.ring = np.sqrt(self.small**2 + 2 * self.small * BIG) / 2
        self.tube = self.ring + self.small / 2
        r = self.small / 2
        inner = self.tube - shrinks
        self.k_big = 4 / 3 * MODULUS * np.sqrt(BIG / 4)
        self.k_side = 4 / 3 * MODULUS * np.sqrt(BIG * self.small / 2 / (BIG + self.small))
        self.k_ring = 4 / 3 * MODULUS * np.sqrt(r / 2)
        self.k_wall = 4 / 3 * 2 * MODULUS * np.sqrt(elliptic_radius(1 / r, 1 / r - 1 / inner))
        self.mass = 8500 * np.pi / 6 * np.array([BIG**3, self.small**3])

    def forces(
        self, z: np.ndarray, w: np.ndarray, u: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Contact forces of neighbouring big spheres; forces on big spheres, and on small ones
        along and outward.
        """

        def hertz(stiffness: float, overlap: np.ndarray) -> np.ndarray:
            return stiffness * np.maximum(overlap, 0.0) ** 1.5

        push = hertz(self.k_big, z[:-1] - z[1:])
        on_big = np.zeros(len(z))
        on_big[:-1] -= push
        on_big[1:] += push
        axial = np.zeros(len(w))
        outward = np.zeros(len(w))
        for side, place in ((-1, z[:-1]), (1, z[1:])):
            along = BIG / 2 * -side + w - place
            across = self.ring + u
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
            return np.concatenate(
                [*velocities, on_big / self.mass[0], axial / self.mass[1], outward / self.mass[1]]
            )

        times = np.linspace(0, END, 3201)
        found = solve_ivp(
            rates, (0, END), rest, method="DOP853", t_eval=times, rtol=1e-9, atol=1e-13
        ).y
        pushes = np.array([self.forces(*unpack(state)[:3])[0] for state in found.T])
        return pushes.max(axis=0), unpack(found[:, -1])[3]


@pytest.mark.parametrize(
    ("n", "shrinks"), [(8, 9e-6), pytest.param(6, 0.0, marks=pytest.mark.validation)]
)
def test_waves_in_a_confined_row(tmp_path: Path, n: int, shrinks: float) -> None:
    row = Row(n, shrinks)
    ring = {
        "ring": {"n": n, "radius": row.ring, "z": BIG / 2},
        "repeat": {"times": N - 1, "step": [0.0, 0.0, BIG]},
    }
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
        i = result["contacts/i"]
        j = result["contacts/j"]
        big = (i <= N) & (j <= N)
        peaks = np.zeros(N - 1)
        peaks[i[big] - 1] = result["contacts/peak_force"][big]
        last = result.frame(1, "velocity")[:N, 2]
    assert peaks[STRUCK - 1 :] == pytest.approx(forces[STRUCK - 1 :], rel=2e-4, abs=1e-3)
    assert last == pytest.approx(velocities, abs=2e-4 * SPEED)


BEADS = 20
SHORT = {
    "packing.size": BEADS, "hold.1.index": [1, BEADS], "guide.1.index": {"first": 2, "last": BEADS - 1}, "load.index": [4],
    "run.end_time": 2.2e-4,
}  # fmt: skip


def run(name: str, directory: Path, **changes: Any) -> GrainRow:
    found = gw.run(name, changes, directory=directory, figures=False, progress=False)
    assert found["energy_balance_error"] < 3e-6
    return GrainRow(found)


def wall_force(row: GrainRow) -> float:
    """Force of a wall on a cylinder before the wave, BEADS."""
    return float(row.array("walls/xlo/force")[0] / (len(row.beside) / 2))


def of_sensor(row: GrainRow) -> float:
    """First peak of the sensor in sphere 21, which reads the mean of its two contact forces, BEADS."""
    before, behind = (row.contact_forces[contact] for contact in (20, 21))
    return first_peak(row.array("probes/time"), (before + behind) / 2, floor=0.05)[1]


def compare(row: GrainRow, tolerance: float) -> None:
    """Peaks of all contacts that the wave has passed, compared with the second solver."""
    peaks, arrivals = SymmetricRow.of(row.case).struck(3, 1.0, 2.2e-4)
    last = int(np.flatnonzero(arrivals < 2e-4).max())
    assert last > 10
    assert row.of_contacts("peak_force")[3:last] == pytest.approx(peaks[3:last], rel=tolerance)


def test_row_between_pressed_walls(tmp_path: Path) -> None:
    """Other cylinders, and another approach of the walls."""
    changes = SHORT | {
        "grains.1.diameter": 4.0e-3,
        "grains.1.length": 7e-3,
        "precompression.x": 5e-6,
    }
    row = run("filter-row", tmp_path, **changes)
    assert wall_force(row) == pytest.approx(
        SymmetricRow.of(row.case).wall_force()[BEADS // 2], rel=1e-6
    )
    compare(row, 1e-3)


@pytest.mark.validation
def test_row_between_walls_that_just_touch(tmp_path: Path) -> None:
    """The foot of the wave is far below the rounding of positions: the line law must not fail
    there.
    """
    compare(run("filter-row-touching", tmp_path, **SHORT), 2e-3)


def test_static_state_between_walls(tmp_path: Path) -> None:
    """Force of a wall on a cylinder, shift of a cylinder, and stiffness of sphere and cylinder."""
    row = run("filter-row", tmp_path, **SHORT | {"run.end_time": 2e-6})
    solved = SymmetricRow.of(row.case)
    shift = solved.across - solved.at_rest()
    assert wall_force(row) == pytest.approx(solved.wall_force()[BEADS // 2], rel=2e-5)
    assert row.inward == pytest.approx(shift[BEADS // 2], rel=2e-5)
    law = row.law_between(1, BEADS + 1)
    stiffness = 4 / 3 * law.effective_modulus * math.sqrt(law.effective_radius)
    assert stiffness == pytest.approx(solved.side_stiffness, rel=1e-6)


def first_peak_solved(case: Case) -> float:
    """First peak of the sensor in sphere 21 by the second solver, N."""
    _, force, _ = SymmetricRow.of(case).motion(0, 0.8, 3.45e-4)
    time = np.linspace(0, 3.45e-4, len(force))
    return first_peak(time, (force[:, 19] + force[:, 20]) / 2, floor=0.05)[1]


def test_open_gap_that_cylinders_bridge(tmp_path: Path) -> None:
    """First peak behind one open gap, compared with the second solver; friction reduces it by a
    fifth.
    """
    smooth, rubbed = (
        run("gap-switch", tmp_path / str(f), **{"run.end_time": 3.45e-4, "boundary.friction": f})
        for f in (0.0, 0.185)
    )
    assert of_sensor(smooth) == pytest.approx(first_peak_solved(smooth.case), rel=5e-3)
    assert of_sensor(rubbed) == pytest.approx(first_peak_solved(rubbed.case), rel=2e-2)
    assert of_sensor(rubbed) == pytest.approx(0.78 * of_sensor(smooth), rel=0.02)
    summary = rubbed.run.summary
    assert summary["energy_dissipated_wall_J"] >= 0
    assert summary["n_cylinders"] == 2 and "grains                       29" in summary_table(
        summary
    )


@pytest.mark.validation
@pytest.mark.parametrize("upstream", [True, False])
def test_loose_cylinders(tmp_path: Path, upstream: bool) -> None:
    grains = load_case("gap-switch-loose").packing.grains
    assert grains is not None
    x, y, z = grains.position[-2]
    z = z if upstream else 27 * 9.5e-3 - z  # the other sphere of the same gap
    row = run(
        "gap-switch-loose",
        tmp_path,
        **{"grains.1.at": [[x, y, z], [-x, y, z]], "run.end_time": 3.45e-4},
    )
    assert of_sensor(row) == pytest.approx(first_peak_solved(row.case), rel=1e-3)


def test_row_between_walls_after_a_strong_pulse(tmp_path: Path) -> None:
    """Indentations by a strong pulse increase the transmission of a weak pulse, and relax the
    walls.
    """
    weak = [[0, 0], [1e-4, 0], [1.05e-4, 706], [1.1e-4, 0]]
    changes = SHORT | {
        "load": {"kind": "force", "index": [4], "shape": "table", "table": weak}, "contact.law": "elastoplastic",
        "output.probes": [{"contact": [5, 6]}, {"contact": [8, 9]}], "output.probe_interval": 1e-6,
    }  # fmt: skip
    del changes["load.index"]
    whole = run("filter-row", tmp_path / "whole", **changes)
    changes["load"] |= {"table": [[0, 0], [5e-6, 3530], [1e-5, 0], *weak[1:]]}
    after = run("filter-row", tmp_path / "after", **changes)
    assert (push_starts(whole.load.table), push_starts(after.load.table)) == ([1e-4], [0.0, 1e-4])
    _, dented = largest_of_pulses(after.array("probes/time"), after.contact_forces[8], 1e-4)
    assert 0.0 < whole.contact_forces[8].max() < 0.5 * dented
    for row, low, high in ((whole, 1 - 1e-6, 1 + 1e-6), (after, 0.0, 0.98)):
        time = row.array("walls/xlo/time")
        force = row.array("walls/xlo/force")
        before = force[(time >= 8e-5) & (time <= 1e-4)].mean() / force[0]
        assert low < before < high
