"""Waves along precompressed chains and packings against closed forms."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import granwave as gw
from granwave.measures import Chain, first_peak, long_wave_speed, power_law, speed_along_layers
from granwave.theory import crest_force, crest_speed, crest_times, discrete_speed, lattice_speed, precompressed_line
from granwave.workflows import load_case

EXACT_FACTOR = math.sqrt(9 / math.pi) * 3 ** (-1 / 3) * 4 ** (-1 / 6)


def test_long_waves_of_a_chain() -> None:
    case = load_case("precompressed-chain", {"precompression.force": 7.0})
    modulus = case.material.youngs_modulus / (1 - case.material.poisson_ratio**2)
    unit = (4 * modulus**2 * 7.0 / (case.packing.diameter**2 * case.material.density**3)) ** (1 / 6)
    assert precompressed_line(case).speed / unit == pytest.approx(EXACT_FACTOR)


def test_lattice_waves_lie_between_small_pulses_and_the_uncompressed_chain() -> None:
    """Nesterenko's wave of a continuum has the speed sqrt(8/15) f^(1/6) over c0 for large f = F_m/F0."""
    assert lattice_speed(np.array([1.0, 1.01])) == pytest.approx([1, 1 + 0.01 / 18], rel=2e-4)
    over = lattice_speed(np.array([1e5]))[0] / (math.sqrt(8 / 15) * 1e5 ** (1 / 6))
    assert over == pytest.approx(discrete_speed(), rel=2e-3)


def test_crests_of_a_struck_linear_line() -> None:
    """Closed form against integrated equations of motion (k = m = v = 1)."""
    n, dt = 40, 2e-3
    u, v = np.zeros(n), np.zeros(n)
    v[0] = 1.0
    times = np.arange(1, 12_000) * dt
    speeds, forces = np.empty((len(times), n)), np.empty((len(times), n - 1))
    for k in range(len(times)):
        u += dt * v / 2
        force = u[:-1] - u[1:]
        v[:-1] -= dt * force
        v[1:] += dt * force
        u += dt * v / 2
        speeds[k], forces[k] = v, u[:-1] - u[1:]
    chosen = np.array([3, 8, 15])
    assert 2 * times[speeds.argmax(axis=0)[chosen - 1]] == pytest.approx(crest_times(chosen), rel=1e-3)
    assert forces.max(axis=0)[chosen - 1] == pytest.approx(crest_force(chosen), rel=1e-4)


def test_contact_force_of_a_packing_is_that_of_its_mean_stress() -> None:
    """Force f = p D^2/(2 sqrt 2): uniaxial by equilibrium of a layer, uniform by the virial; flattened by fixed sides."""
    pressure = 1e4
    for kind, sides in (("uniaxial", "periodic"), ("uniform", "free")):
        case = load_case("precompressed-fcc", {"precompression.kind": kind, "precompression.pressure": pressure,
                                               "boundary.sides": sides})  # fmt: skip
        line = precompressed_line(case)
        assert line.force == pytest.approx(pressure * case.packing.diameter**2 / math.sqrt(8), rel=1e-4)
        stiffness = 2 * 1.5 * line.force / line.overlap
        assert line.speed == pytest.approx(line.spacing * math.sqrt(stiffness / case.sphere_mass), rel=1e-4)


def test_chains_follow_the_formulas(tmp_path: Path) -> None:
    """Steel chains of 80 beads: small pulses at three forces, of the linear chain; an impact, of the lattice."""
    points = [(1.0, 2e-4, 3.0e-3), (10.0, 1.4e-3, 2.1e-3), (100.0, 9e-3, 1.4e-3), (10.0, 20.0, 9e-4)]
    speeds, keys = [], {"packing__size": 80, "output__history": 700, "material": "steel", "run__frames": 2}
    for n, (force, velocity, end) in enumerate(points):
        where = {"precompression__force": force, "load__velocity": velocity, "run__end_time": end}
        run = gw.run("precompressed-chain", directory=tmp_path / f"{n}", progress=False, **keys, **where)
        chain, line = Chain(run), precompressed_line(run.case)
        added, passed, numbers = chain.force - line.force, np.arange(30, 60), np.arange(10, 60)
        crests = np.array([first_peak(chain.time, added[:, k], floor=0.5) for k in passed])
        speed = line.spacing / np.polyfit(passed, crests[:, 0], 1)[0]
        if velocity < 0.1:
            times = [first_peak(chain.time, chain.velocity[:, k - 1], floor=0.5)[0] for k in numbers]
            speeds.append(long_wave_speed(line, numbers, np.array(times)))
            assert speeds[-1] == pytest.approx(line.speed, rel=2e-3)
            assert speed == pytest.approx(crest_speed(line, passed + 1), rel=2e-3)
        else:
            ratio = 1 + crests[:, 1].mean() / line.force
            assert speed == pytest.approx(line.speed * lattice_speed(np.array(ratio)), rel=2e-3)
    assert power_law(np.array([1.0, 10.0, 100.0]), np.array(speeds)).exponent == pytest.approx(1 / 6, abs=3e-4)


@pytest.mark.parametrize(
    ("kind", "how", "sides", "size"),
    [("fcc", "uniaxial", "periodic", [4, 4, 16]), ("hcp", "uniaxial", "periodic", [4, 4, 16]),
     ("fcc", "uniform", "free", [14, 16, 9])],
)  # fmt: skip
def test_speed_of_small_waves_in_packings(tmp_path: Path, kind: str, how: str, sides: str, size: list[int]) -> None:
    changes = {"packing.kind": kind, "precompression.kind": how, "boundary.sides": sides, "packing.size": size,
               "run.end_time": 2.3e-4 if how == "uniaxial" else 1.2e-4, "run.frames": 50}  # fmt: skip
    run = gw.run("precompressed-fcc", changes, directory=tmp_path / "run", progress=False)
    assert run["precompression_residual"] < 1e-6
    line = precompressed_line(run.case)
    assert speed_along_layers(run.result, line) == pytest.approx(line.speed, rel=3e-3)
