"""Forces and displacements in any direction: symmetry, momentum with the walls, energy balance,
ranks, invalid input.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import granwave as gw
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs import write_deck
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.workflows.run.driver import run_case
from tests.helpers.made_up.small_cases import grains_at

N = 5
D = 0.01
CUBE = [[D * i, D * j, D * k] for k in range(N) for j in range(N) for i in range(N)]
LOADS = {
    "force": {"kind": "force", "shape": "half-sine", "amplitude": 2e3, "duration": 1e-5},
    "displacement": {"kind": "displacement", "shape": "table", "table": [[0, 0], [1e-5, 3e-5]]},
}


def run_of(
    directory: Path,
    load: dict[str, Any],
    boundary: dict[str, Any],
    ranks: int = 1,
    end: float = 6e-5,
    **contact: Any,
) -> Result:
    case = case_from_dict({
        "name": "cube", "material": "brass", "packing": grains_at(CUBE), "contact": contact,
        "boundary": boundary, "load": load, "run": {"end_time": end, "timestep": 8e-8, "frames": 3},
    })  # fmt: skip
    if ranks > 1:
        gw.run(case, directory=directory, ranks=ranks, figures=False, progress=False)
    else:
        run_case(case, directory, figures=False)
    return Result(directory)


@pytest.mark.parametrize("kind", LOADS)
def test_a_load_along_x_is_that_along_z_turned(tmp_path: Path, kind: str) -> None:
    """A cube of touching spheres with friction under an oblique force on a face: exchanging x and z
    gives the same motion to rounding.
    """
    number = {tuple(place): row for row, place in enumerate(CUBE)}
    turned = np.array([number[z, y, x] for x, y, z in CUBE])
    middle = D * (N // 2)
    runs = []
    for struck, way in (((middle, middle, 0.0), [1, 0.5, 2]), ((0.0, middle, middle), [2, 0.5, 1])):
        load = LOADS[kind] | {"index": [number[struck] + 1], "direction": way}
        runs.append(run_of(tmp_path / str(way[0]), load, {"bottom": "free"}, friction=0.3))
    one, other = (run.frame(run.n_frames - 1, "velocity") for run in runs)
    assert np.abs(one).max(axis=0).min() > 1e-3
    assert np.abs(other[turned][:, ::-1] - one).max() < 1e-8 * np.abs(one).max()
    for name in ("energy/input", "energy/dissipated", "energy/struck_velocity", "energy/friction"):
        assert runs[1][name] == pytest.approx(runs[0][name], rel=1e-8, abs=1e-12), name
    for run in runs:
        error = (
            run["energy/kinetic"]
            + run["energy/elastic"]
            + run["energy/dissipated"]
            - run["energy/input"]
        )
        assert np.abs(error).max() < 1e-4 * run["energy/input"].max()
    if kind == "displacement":  # the moved sphere follows its table, and does not move across it
        gone = runs[0].frame(runs[0].n_frames - 1, "displacement")[number[middle, middle, 0.0]]
        assert gone == pytest.approx(3e-5 * np.array([1, 0.5, 2]) / 5.25**0.5, rel=1e-6, abs=1e-12)


@pytest.mark.validation
def test_impulse_of_an_oblique_force_is_that_of_packing_and_walls(tmp_path: Path) -> None:
    """Along each axis: impulse of the force = momentum + impulse of the walls; two ranks are
    bitwise identical.
    """
    load = LOADS["force"] | {"direction": [3, 4, 12]}
    walls = {"bottom": "wall", "sides": "wall"}
    one, two = (
        run_of(tmp_path / str(n), load, walls, n, end=3e-5).frame(2, "velocity") for n in (1, 2)
    )
    assert np.abs(one).max() > 0.1 and np.array_equal(one, two)
    run = run_of(tmp_path / "whole", load, walls, end=1.6e-4)
    velocity = run.frame(run.n_frames - 1, "velocity")
    momentum = (run.assembly.sphere_masses()[:, None] * velocity).sum(axis=0)
    given = 2 * 2e3 * 1e-5 / np.pi * np.array([3, 4, 12]) / 13
    taken = {name: np.trapezoid(run[f"walls/{name}/force"], run[f"walls/{name}/time"])
             for name in ("xlo", "xhi", "ylo", "yhi", "bottom")}  # fmt: skip
    on_walls = np.array([taken["xhi"] - taken["xlo"], taken["yhi"] - taken["ylo"], taken["bottom"]])
    assert on_walls.min() > 0.1 * given.min()
    assert momentum + on_walls == pytest.approx(given, rel=2e-3)


def test_deck_of_a_direction(tmp_path: Path) -> None:
    """Axes are written as letters, other directions as vectors; the default direction changes no
    line.
    """
    scripts = {}
    for n, way in enumerate((None, [0, 0, 3], [2, 0, 0], [0, 0, -1], [1, 0, 1])):
        load = LOADS["displacement"] | ({} if way is None else {"direction": way})
        case = case_from_dict(
            {"name": "cube", "material": "brass", "packing": grains_at(CUBE), "load": load}
        )
        scripts[n] = write_deck(case, tmp_path / str(n)).script.read_text()
    assert scripts[0] == scripts[1]
    for n, words in ((0, "z"), (2, "x"), (3, "vector 0 0 -1"), (4, "vector 1 0 1")):
        assert f"gran/load {words}" in scripts[n]
    assert "struck_velocity equal vcm(struck,x)" in scripts[2]
    assert "struck_velocity equal (0.7071067811865475*vcm(struck,x)+" in scripts[4]


def test_walls_hold_a_striker_that_asks_for_it(tmp_path: Path) -> None:
    """A sphere that is deflected by another one hits a side wall and then the floor, or passes them
    if they do not act on it.
    """
    places = [[0, 0, 0], [0.05, 0.05, 0.03], [-0.05, -0.05, 0.03]]
    tables = {
        "name": "thrown", "material": "brass", "packing": grains_at(places), "contact": {"law": "hertz"},
        "boundary": {"bottom": "wall", "sides": "wall"}, "run": {"end_time": 1.6e-2, "frames": 2},
    }  # fmt: skip
    thrown = {"touches": 1, "velocity": [0, 0, 10.0], "offset": [0.006, 0, 0]}
    found = {}
    for held in (True, False):
        case = case_from_dict(tables | {"striker": [thrown | ({"walls": True} if held else {})]})
        run_case(case, tmp_path / str(held), figures=False)
        run = Result(tmp_path / str(held))
        found[held] = [run.frame(run.n_frames - 1, name)[-1] for name in ("position", "velocity")]
        error = (
            run["energy/kinetic"]
            + run["energy/elastic"]
            + run["energy/dissipated"]
            - run["energy/input"]
        )
        assert np.abs(error).max() < 1e-5 * run["energy/input"].max()
    place, velocity = found[True]
    passed, kept = found[False]
    assert passed[0] > 0.055 and passed[2] > 0.035 and place[0] < 0.05 and place[2] < 0.03
    assert velocity == pytest.approx(-kept, rel=1e-4, abs=1e-3)  # reflected by both
    with pytest.raises(InputError, match="the striker overlaps the wall xhi by"):
        case_from_dict(tables | {"striker": [thrown | {"touches": 2, "walls": True}]})
    with pytest.raises(InputError, match="there are no walls"):
        case_from_dict(
            tables | {"boundary": {"bottom": "free"}, "striker": [thrown | {"walls": True}]}
        )
