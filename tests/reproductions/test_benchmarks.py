"""Benchmarks of others: oblique impacts, and the integration with partial slip that stands beside them."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import granwave as gw
from granwave.analysis.studies.registry import load_study

FOLDER = Path(__file__).parents[2] / "reproductions" / "benchmarks"
OXIDE = {"youngs_modulus": 3.8e11, "poisson_ratio": 0.23, "density": 4000}
CASE = {
    "material": OXIDE,
    "contact.law": "hertz",
    "contact.friction": 0.092,
    "packing.diameter": 0.005,
    "load.velocity": 3.9,
    "run.end_time": 3e-5,
    "run.frames": 2,
}


def rebound_of(run):
    """Impact of the run, as the script takes it."""
    return load_study(str(FOLDER / "impacts_oblique.py")).Rebound(run)


@pytest.mark.parametrize("angle", [10, 60])
def test_rebound_beside_partial_slip(tmp_path: Path, angle: float) -> None:
    """Sliding is that of rigid bodies; where a part of the circle sticks, partial slip gives more spin than one spring."""
    run = gw.run("sphere-on-wall", CASE | {"load.angle": angle}, directory=tmp_path / "run", progress=False)
    one = rebound_of(run)
    normal, across, spin = one.with_partial_slip()
    energy = 0.5 * 0.4 * run.case.sphere_mass * one.radius**2 * one.spin_after**2
    assert run["energy_rotational_J"] == pytest.approx(energy, rel=5e-3)
    assert normal == pytest.approx(one.normal_after, rel=1e-3)
    if angle == 60:
        change = 2 * 0.092 * 3.9 * math.cos(math.radians(60))
        assert across == pytest.approx(one.across - change, rel=1e-3)
        assert one.across_after == pytest.approx(across, rel=1e-3)
    else:
        assert 1.15 < spin / one.spin_after < 1.35


@pytest.mark.parametrize(("angle", "loss"), [(3.94, None), (10, {"dashpot": {"restitution": 0.98}})])
def test_runs_with_partial_slip_follow_it(tmp_path: Path, angle: float, loss: object) -> None:
    case = CASE | {"load.angle": angle, "contact.tangential": "partial_slip"} | ({"contact.loss": loss} if loss else {})
    one = rebound_of(gw.run("sphere-on-wall", case, directory=tmp_path / "run", progress=False))
    _, across, spin = one.with_partial_slip()
    assert one.spin_after == pytest.approx(spin, rel=0.01)
    assert one.across_after == pytest.approx(across, rel=3e-3)
