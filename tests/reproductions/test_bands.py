"""Chains that are driven at frequencies of their bands, with and without a tunnel (thesis 7.2)."""

from __future__ import annotations

import math
import tomllib
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import granwave as gw
from granwave.analysis.studies.registry import load_study
from granwave.workflows import load_scan
from tests.helpers.programs.scripts import FOLDER, columns, row, study_of

BANDS = FOLDER / "bands"
finite = load_study(str(BANDS / "finite_tunnel.py"))
SCAN = BANDS / "tunnel-finite.toml"


@pytest.fixture(scope="module")
def rows_of_springs() -> list[Any]:
    """Linear chains with a tunnel, by the approach of its walls."""
    return [finite.LinearRow(finite.Tunnel(a), list(finite.GAPS)) for a in finite.APPROACHES]


def test_modes_without_a_tunnel() -> None:
    """A chain with a free and a fixed end has the frequencies 2 sqrt(K/m) sin((2 j - 1) pi / (2 (2
    n + 1))).
    """
    tunnel = finite.Tunnel(0.0)
    linear = finite.LinearRow(tunnel, [])
    free = finite.SPHERES - 1
    mode = np.arange(1, free + 1)
    modes = 2 * np.sin((2 * mode - 1) * math.pi / (2 * (2 * free + 1)))
    assert linear.omega / tunnel.row_frequency == pytest.approx(modes, rel=1e-9)


def test_peak_velocity_without_a_tunnel() -> None:
    """In the band of an infinite chain a force A gives all spheres the velocity A / sqrt(K m); the
    front of the wave overshoots it, by the largest integral of Airy's function, 1.27.
    """
    tunnel = finite.Tunnel(0.0)
    linear = finite.LinearRow(tunnel, [])
    steady = finite.DRIVE / (tunnel.mass * tunnel.row_frequency)
    peak = linear.peak_velocity(1.2 * tunnel.row_frequency, finite.DRIVE)
    assert 1.0 < peak / steady < 1.3


def test_modes_of_a_tunnel(rows_of_springs: list[Any]) -> None:
    """Their number is the number of free motions: spheres along, cylinders along and across."""
    for linear, approach in zip(rows_of_springs, finite.APPROACHES, strict=True):
        assert len(linear.omega) == finite.SPHERES - 1 + 2 * len(finite.GAPS)
        third = finite.Tunnel(approach).edges[2]
        highest = linear.omega[-len(finite.GAPS) :]
        assert (highest > 0.999 * third[0]).all()
        assert (highest < 1.001 * third[1]).all()


def test_scan_has_the_closed_forms() -> None:
    """Overlaps, rings and walls of the scan agree with the static state of 7.5 to 7.7."""
    text = SCAN.read_text(encoding="utf-8")
    table = tomllib.loads(text)["zip"][0]
    for index, approach in enumerate(finite.APPROACHES):
        tunnel = finite.Tunnel(approach)
        d1, d2, _ = tunnel.geometry(tunnel.d0)
        outside = (finite.FORCE / tunnel.constants[0]) ** (2 / 3)
        reach = tunnel.radius + tunnel.small - d1
        radius = math.sqrt(reach**2 - (tunnel.radius - tunnel.d0 / 2) ** 2)
        (grain,) = table["grains"][index]
        assert grain["ring"]["radius"] == pytest.approx(radius, rel=1e-12)
        assert table["precompression"][index]["x"] == pytest.approx(d2, rel=1e-6)
        for gap, width in table["packing"]["gaps"][index]:
            overlap = tunnel.d0 if gap in finite.GAPS else outside
            assert -width == pytest.approx(overlap, rel=1e-6)


@pytest.mark.validation
def test_static_state_balances(tmp_path: Any) -> None:
    """Without a wave nothing moves at sphere 75, behind the tunnel."""
    case = load_scan(SCAN).points[0].case
    run = gw.run(case, {"run.end_time": 2e-4}, directory=tmp_path / "run", progress=False)
    assert np.abs(run.result["probes/sphere_75_vz"]).max() < 1e-9


def made_up(linear: Any, tunnel: Any, moved: float | None, frequency: float, force: float) -> Any:
    """Run with the velocity of the linear row."""
    omega = frequency * tunnel.row_frequency
    load = SimpleNamespace(frequency=omega / (2 * math.pi), amplitude=force)
    kind = "uniaxial" if moved is None else "walls"
    static = SimpleNamespace(kind=kind, moves={"x": moved})
    velocity = np.array([0.0, -linear.peak_velocity(omega, force)])
    return SimpleNamespace(
        case=SimpleNamespace(load=load, precompression=static),
        result={"probes/sphere_75_vz": velocity},
    )


def test_rows_of_linear_runs(rows_of_springs: list[Any]) -> None:
    """Velocities of the linear chain give rows without a difference, and edges of both bands."""
    linear = rows_of_springs[0]
    tunnel = finite.Tunnel(finite.APPROACHES[0])
    _, moved, _ = tunnel.geometry(tunnel.d0)
    frequencies = np.arange(0.6, 1.85, 0.1)
    runs = [made_up(linear, tunnel, moved, each, finite.DRIVE) for each in frequencies]
    plain = finite.LinearRow(tunnel, [])
    runs += [made_up(plain, tunnel, None, each, finite.DRIVE) for each in (0.7, 0.8, 1.5, 1.8)]
    runs.append(made_up(plain, tunnel, None, 0.5, 1e-3))
    study = study_of("bands/finite_tunnel.py", runs)
    for each in study.rows:
        if each.verification:
            assert each.ours == pytest.approx(each.theory, abs=1e-9)
    weak = row(study, "Largest difference from the linear chain, no tunnel, 0.5")
    assert weak.quantity.endswith("0.001 N")
    fall, rise = (
        each.ours
        for each in study.rows
        if each.quantity.endswith("half its level, a = -1.8e-05") and each.verification
    )
    low, high = tunnel.edges[[0, 1], [1, 0]] / tunnel.row_frequency
    assert low - 0.1 < fall < low
    assert high < rise < high + 0.1
    assert len(columns(study)["velocity_no_tunnel"]) == 4
