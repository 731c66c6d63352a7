"""Grid of ranks, and the model of the time of a step."""

from __future__ import annotations

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
AT_REST_ALONE = StepCosts(rest=4e-9, moving=4e-9, ghost=20e-9)


def test_all_grids_of_a_number_of_ranks() -> None:
    found = list(grids(12))
    assert len(found) == len(set(found)) == 18
    assert all(math.prod(grid) == 12 for grid in found)


def test_one_rank_takes_its_spheres_alone() -> None:
    times = step_times(CUBE, (1, 1, 1), ROUGH, 1e9)
    assert times.busiest == times.mean == pytest.approx(64_000 * ROUGH.moving)
    assert times.communication == 0.0
    assert times.efficiency == pytest.approx(1.0)


def test_ghosts_lie_within_reach_of_a_brick() -> None:
    assert CUBE.ghosts((1, 1, 1)) == 0.0
    assert CUBE.ghosts((2, 1, 1)) == pytest.approx(1.2 * 40 * 40)
    assert CUBE.ghosts((4, 1, 1)) == pytest.approx(2.4 * 40 * 40)


def test_half_of_the_ranks_wait_while_a_wave_crosses_the_upper_half() -> None:
    times = step_times(FROM_TOP, (1, 1, 2), StepCosts(0.0, 1e-7, 0.0, 0.0, 0.0), 19.0)
    assert times.efficiency == pytest.approx(0.5)
    columns = step_times(FROM_TOP, (2, 1, 1), StepCosts(0.0, 1e-7, 0.0, 0.0, 0.0), 19.0)
    assert columns.efficiency == pytest.approx(1.0)


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
