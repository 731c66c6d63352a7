"""Measures along lines and rows of grains: first pulses, decay, neighbours, precompressed chains."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

import granwave as gw
from granwave.analysis.measures import geometry as module
from granwave.analysis.measures.geometry import nearest
from granwave.analysis.measures.lines import LineRecord, fit_decay, parted_at
from granwave.analysis.result.histories import first_pulses
from granwave.measures import (
    Chain,
    GrainRow,
    decay_rate,
    first_peak,
    long_wave_speed,
    power_law,
    speed_along_layers,
)
from granwave.theory import (
    crest_force,
    crest_speed,
    crest_times,
    discrete_speed,
    lattice_speed,
    precompressed_line,
)
from granwave.workflows import load_case

TIME = np.linspace(0, 10e-3, 4001)


def pulse(centre: float, height: float, width: float = 1e-3) -> np.ndarray:
    """A Gaussian with this half width."""
    return height * np.exp(-4 * np.log(2) * ((TIME - centre) / width) ** 2)


def test_first_pulse_of_a_gaussian() -> None:
    speed = np.stack(
        [pulse(3e-3, 2.0), pulse(3e-3, 2.0) + pulse(7e-3, 5.0), pulse(3e-3, 0.04)], axis=1
    )
    found, row = first_pulses(TIME, speed, 1.0)
    arrival = 3e-3 - 1e-3 * np.sqrt(np.log(2.0 / 0.05) / (4 * np.log(2)))
    assert found["peak_speed"][:2] == pytest.approx(2.0, rel=1e-6) and found["peak_time"][
        :2
    ] == pytest.approx(3e-3)
    assert found["width"][:2] == pytest.approx(1e-3, rel=1e-4)
    assert found["arrival"][:2] == pytest.approx(arrival, rel=1e-4)
    assert (
        np.isnan([found["arrival"][2], found["peak_speed"][2], found["width"][2]]).all()
        and row[2] == -1
    )


def test_ripples_on_the_way_up_are_no_peak() -> None:
    speed = pulse(5e-3, 1.0, 4e-3) * (1 + 0.02 * np.sin(2e4 * TIME))
    found, _ = first_pulses(TIME, speed[:, None], 1.0)
    assert found["peak_time"][0] == pytest.approx(5e-3, abs=4e-4) and found["peak_speed"][
        0
    ] == pytest.approx(1.0, abs=0.03)


def test_a_speed_that_never_falls_has_no_peak() -> None:
    found, _ = first_pulses(TIME, (TIME / TIME[-1])[:, None], 1.0)
    assert found["arrival"][0] == pytest.approx(0.05 * TIME[-1]) and np.isnan(
        found["peak_speed"][0]
    )


@pytest.mark.parametrize("border", [0.031, 0.05, 0.0721])
def test_a_broken_line_is_found_again(border: float) -> None:
    x = np.arange(10) * 0.0125
    y = 7 * np.exp(-1.7 * x - 12.0 * np.maximum(x - border, 0))
    found = fit_decay(x, y)
    assert found is not None
    assert (found.first, found.second, found.border) == pytest.approx((1.7, 13.7, border), rel=1e-4)
    y[4] = np.nan
    again = fit_decay(x, y)
    assert (
        again is not None and again.points == 9 and again.border == pytest.approx(border, rel=1e-4)
    )


def test_few_points_have_no_two_regions() -> None:
    assert fit_decay(np.arange(3.0), np.ones(3)) is None
    found = fit_decay(np.arange(4.0), np.exp(-np.arange(4.0)))
    assert found is not None and found.single == pytest.approx(1.0)


def test_where_crystals_part() -> None:
    x = np.arange(5) * 0.01
    wide = np.full(5, 2.0)
    assert parted_at(x, np.array([2.0, 1.95, 1.93, 1.8, 2.0]), wide) == pytest.approx(0.02)
    assert parted_at(x, np.array([2.0, np.nan, 1.99, 2.01, 2.0]), wide) is None


def test_front_speed_and_distribution() -> None:
    x = np.arange(8) * 0.01
    speeds = np.array([1.0, 1.2, 1.4, 1.1, 0.9, 1.3, 1.0, 1.25])
    line = LineRecord("a", x, x / 120.0, x, x, np.exp(-2 * x), speeds, x, left_out=2)
    assert line.front_speed == pytest.approx(120.0)
    assert line.decay is not None and line.decay.points == 6
    spread = line.distribution
    assert (
        spread is not None
        and spread.mean == pytest.approx(speeds.mean())
        and 0 < spread.normal_p < 1
    )
    crooked = LineRecord("b", x, x / 120.0, x, x, np.exp(-2 * x), speeds, x, 0, straight=False)
    assert (
        crooked.front_speed is None and crooked.decay is None and crooked.distribution is not None
    )


def test_row_in_a_tube(tmp_path: Path) -> None:
    """Only contacts of beads, numbered from 1; rings in equilibrium between wall and beads."""
    changes = {
        "packing.size": 16, "grains.1.repeat.times": 15, "hold.1.index": [1, 16], "load.index": [3],
        "precompression": {"kind": "walls", "tube": 1.425e-5}, "run.end_time": 1.2e-4,
        "output.probes": [{"contact": [5, 6]}, {"sphere": 5}],
    }  # fmt: skip
    run = gw.run("confined-row", changes, directory=tmp_path, progress=False)
    row = GrainRow(run)
    assert list(row.ids) == list(range(1, 17)) and len(row.beside) == 15 * 8 and row.struck == 3
    peak = row.of_contacts("peak_force")
    when = row.of_contacts("time_peak")
    ((contact, force),) = row.contact_forces.items()
    assert contact == 5 and force.max() == pytest.approx(peak[4], rel=0.02)
    assert 3 < row.passed < 15 and (np.diff(when[2 : row.passed]) > 0).all()
    small = 0.005147186258 / 2
    big = 0.0075
    inner = 0.009298716066 - 1.425e-5
    modulus = 115e9 / (1 - 0.3**2)
    ring = 0.006725122938 - row.inward
    overlap = big + small - np.hypot(ring, big)
    push = (
        4
        / 3
        * modulus
        / 2
        * np.sqrt(big * small / (big + small))
        * 2
        * overlap**1.5
        * ring
        / np.hypot(ring, big)
    )
    push += (
        4
        / 3
        * modulus
        / 2
        * np.sqrt(small / 2)
        * 2
        * np.sin(np.pi / 8)
        * (2 * row.inward * np.sin(np.pi / 8)) ** 1.5
    )
    wall = 4 / 3 * modulus * np.sqrt(gw.theory.elliptic_radius(1 / small, 1 / small - 1 / inner))
    assert push == pytest.approx(wall * (ring + small - inner) ** 1.5, rel=1e-3)


def test_rate_of_a_decay() -> None:
    x = np.arange(60, 201)
    assert decay_rate(x, 7 * np.exp(-2e-3 * x)) == pytest.approx(2e-3)
    assert np.isnan(decay_rate(x, x - 60.0)) and np.isnan(decay_rate([1], [1]))


@pytest.mark.parametrize("by_tree", [0, 10**9])
@pytest.mark.parametrize("n_places", [1, 3, 700])
def test_as_a_tree(monkeypatch, by_tree, n_places):
    monkeypatch.setattr(module, "_BY_TREE", by_tree)
    monkeypatch.setattr(module, "_BLOCK", 1000)  # several blocks
    generator = np.random.default_rng(5)
    points = generator.normal(size=(430, 3))
    places = generator.normal(size=(n_places, 3))
    distance, row = nearest(points, places)
    expected, rows = cKDTree(places).query(points)
    assert distance == pytest.approx(expected, rel=1e-14) and np.array_equal(row, rows)


def test_of_equal_distances_the_first():
    """Impacted spheres form symmetric groups: a sphere between them belongs to the first group,
    with and without a tree search.
    """
    _, row = nearest(
        np.zeros((2, 3)), np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    )
    assert row.tolist() == [0, 0]


EXACT_FACTOR = math.sqrt(9 / math.pi) * 3 ** (-1 / 3) * 4 ** (-1 / 6)


def test_long_waves_of_a_chain() -> None:
    case = load_case("precompressed-chain", {"precompression.force": 7.0})
    modulus = case.material.youngs_modulus / (1 - case.material.poisson_ratio**2)
    unit = (4 * modulus**2 * 7.0 / (case.packing.diameter**2 * case.material.density**3)) ** (1 / 6)
    assert precompressed_line(case).speed / unit == pytest.approx(EXACT_FACTOR)


def test_lattice_waves_lie_between_small_pulses_and_the_uncompressed_chain() -> None:
    """Nesterenko's wave of a continuum has the speed sqrt(8/15) f^(1/6) c0 for large f = F_m/F0."""
    assert lattice_speed(np.array([1.0, 1.01])) == pytest.approx([1, 1 + 0.01 / 18], rel=2e-4)
    over = lattice_speed(np.array([1e5]))[0] / (math.sqrt(8 / 15) * 1e5 ** (1 / 6))
    assert over == pytest.approx(discrete_speed(), rel=2e-3)


def test_crests_of_a_struck_linear_line() -> None:
    """Closed form compared with integrated equations of motion (k = m = v = 1)."""
    n = 40
    dt = 2e-3
    u = np.zeros(n)
    v = np.zeros(n)
    v[0] = 1.0
    times = np.arange(1, 12_000) * dt
    speeds = np.empty((len(times), n))
    forces = np.empty((len(times), n - 1))
    for k in range(len(times)):
        u += dt * v / 2
        force = u[:-1] - u[1:]
        v[:-1] -= dt * force
        v[1:] += dt * force
        u += dt * v / 2
        speeds[k] = v
        forces[k] = u[:-1] - u[1:]
    chosen = np.array([3, 8, 15])
    assert 2 * times[speeds.argmax(axis=0)[chosen - 1]] == pytest.approx(
        crest_times(chosen), rel=1e-3
    )
    assert forces.max(axis=0)[chosen - 1] == pytest.approx(crest_force(chosen), rel=1e-4)


def test_contact_force_of_a_packing_is_that_of_its_mean_stress() -> None:
    """Force f = p D^2/(2 sqrt 2): uniaxial by equilibrium of a layer, uniform by the virial;
    flattened by fixed sides.
    """
    pressure = 1e4
    for kind, sides in (("uniaxial", "periodic"), ("uniform", "free")):
        case = load_case("precompressed-fcc", {"precompression.kind": kind, "precompression.pressure": pressure,
                                               "boundary.sides": sides})  # fmt: skip
        line = precompressed_line(case)
        assert line.force == pytest.approx(
            pressure * case.packing.diameter**2 / math.sqrt(8), rel=1e-4
        )
        stiffness = 2 * 1.5 * line.force / line.overlap
        assert line.speed == pytest.approx(
            line.spacing * math.sqrt(stiffness / case.sphere_mass), rel=1e-4
        )


def test_chains_follow_the_formulas(tmp_path: Path) -> None:
    """Steel chains of 80 beads: small pulses at three forces, of the linear chain; an impact, of
    the lattice.
    """
    points = [
        (1.0, 2e-4, 3.0e-3),
        (10.0, 1.4e-3, 2.1e-3),
        (100.0, 9e-3, 1.4e-3),
        (10.0, 20.0, 9e-4),
    ]
    speeds = []
    keys = {"packing__size": 80, "output__history": 700, "material": "steel", "run__frames": 2}
    for n, (force, velocity, end) in enumerate(points):
        where = {"precompression__force": force, "load__velocity": velocity, "run__end_time": end}
        run = gw.run(
            "precompressed-chain", directory=tmp_path / f"{n}", progress=False, **keys, **where
        )
        chain = Chain(run)
        line = precompressed_line(run.case)
        added = chain.force - line.force
        passed = np.arange(30, 60)
        numbers = np.arange(10, 60)
        crests = np.array([first_peak(chain.time, added[:, k], floor=0.5) for k in passed])
        speed = line.spacing / np.polyfit(passed, crests[:, 0], 1)[0]
        if velocity < 0.1:
            times = [
                first_peak(chain.time, chain.velocity[:, k - 1], floor=0.5)[0] for k in numbers
            ]
            speeds.append(long_wave_speed(line, numbers, np.array(times)))
            assert speeds[-1] == pytest.approx(line.speed, rel=2e-3)
            assert speed == pytest.approx(crest_speed(line, passed + 1), rel=2e-3)
        else:
            ratio = 1 + crests[:, 1].mean() / line.force
            assert speed == pytest.approx(line.speed * lattice_speed(np.array(ratio)), rel=2e-3)
    assert power_law(np.array([1.0, 10.0, 100.0]), np.array(speeds)).exponent == pytest.approx(
        1 / 6, abs=3e-4
    )


@pytest.mark.parametrize(
    ("kind", "how", "sides", "size"),
    [("fcc", "uniaxial", "periodic", [4, 4, 16]), ("hcp", "uniaxial", "periodic", [4, 4, 16]),
     ("fcc", "uniform", "free", [14, 16, 9])],
)  # fmt: skip
def test_speed_of_small_waves_in_packings(
    tmp_path: Path, kind: str, how: str, sides: str, size: list[int]
) -> None:
    changes = {"packing.kind": kind, "precompression.kind": how, "boundary.sides": sides, "packing.size": size,
               "run.end_time": 2.3e-4 if how == "uniaxial" else 1.2e-4, "run.frames": 50}  # fmt: skip
    run = gw.run("precompressed-fcc", changes, directory=tmp_path / "run", progress=False)
    assert run["precompression_residual"] < 1e-6
    line = precompressed_line(run.case)
    assert speed_along_layers(run.result, line) == pytest.approx(line.speed, rel=3e-3)
