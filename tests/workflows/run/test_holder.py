"""A chain in a holder that rubs, from the case to the summary, against an independent integration by scipy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from granwave.analysis.result.reader import Result
from granwave.workflows import load_case, run_case

N, MU, G, SPEED, END = 8, 40.0, 9.81, 0.3, 4e-4
DIAMETER, MODULUS, RATIO, DENSITY = 0.01, 209e9, 0.28, 7925.0
CASE = {
    "packing.size": N,
    "packing.diameter": DIAMETER,
    "load.velocity": SPEED,
    "boundary.bottom": "free",
    "boundary.holder_friction": MU,
    "run.end_time": END,
    "run.timestep": "auto",
    "run.energy_tolerance": 1e-7,
    "output.history": 200,
}
FASTEST_AT_REST = 1e-6  # m/s, below which friction fades here, and only here


def independent(times: np.ndarray) -> np.ndarray:
    """Velocities (n_times, N) of Hertz's chain with friction mu m g tanh(v/v0) on every bead."""
    mass = DENSITY * np.pi / 6 * DIAMETER**3
    stiffness = np.sqrt(DIAMETER) * MODULUS / (3 * (1 - RATIO**2))

    def change(_: float, state: np.ndarray) -> np.ndarray:
        place, velocity = state.reshape(2, N)
        force = stiffness * np.maximum(place[:-1] - place[1:], 0) ** 1.5
        rubbing = MU * mass * G * np.tanh(velocity / FASTEST_AT_REST)
        net = -rubbing
        net[:-1] -= force
        net[1:] += force
        return np.concatenate([velocity, net / mass])

    start = np.zeros(2 * N)
    start[N] = SPEED
    found = solve_ivp(change, (0, times[-1]), start, "LSODA", times, rtol=1e-8, atol=1e-13)
    assert found.success
    return found.y[N:].T


@pytest.fixture(scope="module")
def directory(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("holder") / "run"
    run_case(load_case("homogeneous-chain", CASE), folder, figures=False)
    return folder


def test_motion_is_that_of_an_independent_chain(directory: Path) -> None:
    """Within 1e-4 of the impact's speed, while friction takes a large part of the energy and beads come to rest."""
    with Result(directory) as result:
        times, ours = result["chain/time"], result["chain/velocity"]
    assert 0 < np.count_nonzero(ours[-1] == 0) < N
    assert np.abs(ours - independent(times)).max() < 1e-4 * SPEED


def test_the_ledger_has_what_the_holder_took(directory: Path) -> None:
    """A column and a share of its own, equal to friction times weight times the path, none of it by yielding."""
    with Result(directory) as result:
        time, velocity = result["chain/time"], result["chain/velocity"]
        work = MU * result["spheres/mass"].sum() / N * G * np.trapezoid(np.abs(velocity), time, axis=0).sum()
        holder, dissipated = result["energy/holder"][-1], result["energy/dissipated"][-1]
        given = result["energy/input"][-1]
        assert np.all(result.yield_ledger == 0)
    assert holder == pytest.approx(work, rel=2e-3)
    assert dissipated == pytest.approx(holder, rel=1e-12)
    assert 0.2 < holder / given < 0.9


def test_the_summary_tells_it(directory: Path) -> None:
    import json

    summary = json.loads((directory / "summary.json").read_text())
    assert summary["holder_fraction"] == pytest.approx(summary["dissipated_fraction"], rel=1e-12)
    assert summary["energy_dissipated_plastic_J"] == 0
    assert summary["energy_balance_error"] < 1e-6


def test_a_smooth_holder_is_none(tmp_path: Path) -> None:
    outcome = run_case(load_case("homogeneous-chain", CASE | {"boundary.holder_friction": 0.0, "run.end_time": 5e-5}),
                       tmp_path / "run", figures=False)  # fmt: skip
    assert outcome.summary["holder_fraction"] is None and outcome.summary["energy_dissipated_holder_J"] is None
    assert "gran/holder" not in (tmp_path / "run" / "in.granwave").read_text()
