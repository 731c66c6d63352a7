"""Grid of ranks, and the model of the time of a step."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from granwave.lammps_inputs.load_case import load_assembly
from granwave.lammps_inputs.planning.ranks import (
    ROUGH,
    SMOOTH,
    StepCosts,
    Wave,
    best_grid,
    grid_of,
    grids,
    mean_times,
    step_times,
    wave_of,
)
from granwave.workflows import library

CUBE = Wave(
    n_spheres=64_000,
    low=np.zeros(3),
    high=np.full(3, 40.0),
    first=np.array([19.5, 19.5, 0.0]),
    last=np.array([20.5, 20.5, 1.0]),
    reach=1.2,
)
FROM_TOP = Wave(
    n_spheres=64_000,
    low=np.zeros(3),
    high=np.full(3, 40.0),
    first=np.zeros(3),
    last=np.array([40.0, 40.0, 1.0]),
    reach=1.2,
)
AT_REST_ALONE = StepCosts(rest=4e-9, active=4e-9, moving=4e-9, ghost=20e-9)
ACTIVE_ALONE = StepCosts(rest=0.0, active=1e-7, moving=1e-7, ghost=0.0, message=0.0, total=0.0)


def test_all_grids_of_a_number_of_ranks() -> None:
    found = list(grids(12))
    assert len(found) == len(set(found)) == 18
    assert all(math.prod(grid) == 12 for grid in found)


def test_one_rank_takes_its_spheres_alone() -> None:
    times = step_times(CUBE, (1, 1, 1), ROUGH, 1e9)
    assert times.busiest == times.mean == pytest.approx(64_000 * ROUGH.active)
    assert times.communication == 0.0
    assert times.efficiency == pytest.approx(1.0)


def test_ghosts_lie_within_reach_of_a_brick() -> None:
    assert CUBE.ghosts((1, 1, 1)) == 0.0
    assert CUBE.ghosts((2, 1, 1)) == pytest.approx(1.2 * 40 * 40)
    assert CUBE.ghosts((4, 1, 1)) == pytest.approx(2.4 * 40 * 40)


def test_half_of_the_ranks_wait_while_a_wave_crosses_the_upper_half() -> None:
    times = step_times(FROM_TOP, (1, 1, 2), ACTIVE_ALONE, 19.0)
    assert times.efficiency == pytest.approx(0.5)
    columns = step_times(FROM_TOP, (2, 1, 1), ACTIVE_ALONE, 19.0)
    assert columns.efficiency == pytest.approx(1.0)


def test_behind_a_plane_wave_all_spheres_move() -> None:
    assert FROM_TOP.is_plane
    assert not CUBE.is_plane
    times = step_times(FROM_TOP, (1, 1, 1), ROUGH, 1e9)
    assert times.busiest == pytest.approx(64_000 * ROUGH.moving)


def test_a_block_is_active_as_a_whole() -> None:
    """A block of 33 spheres around each chain that carries the wave."""
    alone = CUBE.active((1, 1, 1), 4.0)[1]
    blocks = dataclasses.replace(CUBE, block=32.0).active((1, 1, 1), 4.0)[1]
    assert alone == pytest.approx(blocks * (1.0 + 2 * 4.0 / 3) / (33.0 + 2 * 4.0 / 3))


def test_the_front_of_a_wave_is_a_diamond() -> None:
    """A square of side 20, halved in both directions by the top: an area of 100, and the loaded
    sphere.
    """
    wave = dataclasses.replace(CUBE, block=100.0)  # whole rows
    assert wave.active((1, 1, 1), 10.0)[1] == pytest.approx((100 + 20 + 10 + 1) / 1600, rel=0.02)
    assert wave.active((1, 1, 2), 10.0)[0] == pytest.approx((100 + 20 + 10 + 1) / 1600, rel=0.02)
    assert wave.active((1, 1, 1), 1e3)[1] == pytest.approx(1.0)


#: Impact on one sphere of 48 x 48 x 24 spheres, two ranks, cut across z: active spheres of both
#: ranks, and the fraction of the time in which a rank waits. Processor times outside MPI, means of
#: 150 steps, 29 November 2026.
MEASURED = {
    ROUGH: [(3568, 0.185), (5216, 0.219), (6976, 0.272), (8880, 0.269), (11152, 0.268),
            (13680, 0.265), (16160, 0.255)],
    SMOOTH: [(3632, 0.186), (5136, 0.212), (6848, 0.246), (8880, 0.251), (11184, 0.263),
             (13728, 0.248), (16272, 0.219)],
}  # fmt: skip


@pytest.mark.parametrize("costs", MEASURED, ids=["friction", "no friction"])
def test_waiting_is_that_measured(costs: StepCosts) -> None:
    """Each time is within 20 %, and their sum within 10 %."""
    assembly = load_assembly(library.find("fcc-impact"), {"packing.size": [48, 48, 24]})
    wave = wave_of(assembly)
    distances = np.linspace(0.0, wave.farthest, 500)
    spheres = [wave.active((1, 1, 1), travelled)[1] * wave.n_spheres for travelled in distances]
    times = [
        step_times(wave, (1, 1, 2), costs, float(np.interp(active, spheres, distances)))
        for active, _ in MEASURED[costs]
    ]
    waiting = np.array([1 - time.mean / time.busiest for time in times])
    measured = np.array([share for _, share in MEASURED[costs]])
    np.testing.assert_allclose(waiting, measured, rtol=0.2)
    assert waiting.mean() == pytest.approx(measured.mean(), rel=0.1)


@pytest.mark.parametrize("n_ranks", [2, 4, 16])
def test_a_plane_wave_is_cut_into_columns_along_its_way(n_ranks: int) -> None:
    assert best_grid(FROM_TOP, n_ranks, ROUGH)[2] == 1


def test_without_waiting_the_surface_is_smallest() -> None:
    assert best_grid(CUBE, 8, AT_REST_ALONE) == (2, 2, 2)
    assert best_grid(FROM_TOP, 27, AT_REST_ALONE) == (3, 3, 3)


def test_no_brick_is_thinner_than_a_sphere() -> None:
    layer = Wave(1600, np.zeros(3), np.array([40.0, 40.0, 1.0]), np.zeros(3), np.ones(3), 1.2)
    assert best_grid(layer, 16, SMOOTH)[2] == 1
    assert math.prod(best_grid(layer, 10_007, SMOOTH)) == 10_007


def test_the_chosen_grid_is_no_slower_than_any_other() -> None:
    times = {grid: mean_times(CUBE, grid, ROUGH).busiest for grid in grids(16)}
    assert times[best_grid(CUBE, 16, ROUGH)] <= min(times.values()) * (1 + 1e-5)


def test_grid_of_a_case() -> None:
    assembly = load_assembly(library.find("fcc-small"))
    wave = wave_of(assembly)
    assert (wave.first >= wave.low).all()
    assert (wave.last <= wave.high).all()
    assert math.prod(grid_of(assembly, 6)) == 6
    chosen = load_assembly(library.find("fcc-small"), {"run.processors": [1, 2, 3]})
    assert grid_of(chosen, 6) == (1, 2, 3)


def test_all_spheres_of_a_precompressed_packing_are_loaded() -> None:
    wave = wave_of(load_assembly(library.find("precompressed-fcc")))
    assert wave.farthest == 0.0
    times = step_times(wave, (2, 2, 1), ROUGH, 0.0)
    assert times.busiest == pytest.approx(times.mean)


def test_the_grid_is_kept_in_the_case_where_it_is_given() -> None:
    assert "processors" not in load_assembly(library.find("fcc-small")).case.to_dict()["run"]
    case = load_assembly(library.find("fcc-small"), {"run.processors": [1, 2, 1]}).case
    assert case.to_dict()["run"]["processors"] == [1, 2, 1]
