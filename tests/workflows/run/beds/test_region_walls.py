"""Runs with walls of regions: equality with the walls of a boundary, energy balances, and
friction.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.workflows.run import driver
from tests.helpers import meshes

HEAD = "x,y,z,diameter,vx,vy,vz\n"
PAIR = f"{HEAD}0,0,0,0.01,0,0,0\n0.002,0.001,-0.0099,0.01,0,0,5\n"


def ran(directory: Path, grains: str, **tables: Any) -> Result:
    case = {
        "name": "walls",
        "material": "brass",
        "packing": {"kind": "file", "grains": grains},
        "load": {"kind": "grains"},
        "run": {"end_time": 8e-5, "timestep": 2e-8, "frames": 2},
    }
    outcome = driver.run_case(case_from_dict(case | tables), directory, figures=False)
    assert outcome.state == "finished"
    return Result(directory)


def same(one: Result, other: Result, names: tuple[str, str]) -> None:
    """Assert that two runs are equal; their walls have these names."""
    for name in (
        "energy/kinetic",
        "energy/dissipated",
        "energy/elastic",
        "wall_contacts/peak_force",
    ):
        assert other[name] == pytest.approx(one[name], rel=1e-7, abs=1e-12)
    forces = [
        result[f"walls/{name}/force"] for result, name in zip((one, other), names, strict=True)
    ]
    assert forces[0].max() > 100
    assert forces[1] == pytest.approx(forces[0], rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("wall", [{}, {"material": "steel"}, {"friction": 0.1}])
def test_a_plane_of_a_region_is_the_bottom(tmp_path: Path, wall: dict[str, Any]) -> None:
    contact = {"friction": 0.3}
    bottom = {"material": wall["material"]} if "material" in wall else "wall"
    friction = {"friction": 0.1} if "friction" in wall else {}
    plane = [{"region": "plane 0 0 0.005 0 0 -1"} | wall]
    common = {"contact": contact}
    with (
        ran(tmp_path / "one", PAIR, boundary={"bottom": bottom} | friction, **common) as one,
        ran(tmp_path / "two", PAIR, boundary={"bottom": "free"}, wall=plane, **common) as two,
    ):
        same(one, two, ("bottom", "wall1"))
        assert one["energy/friction"][-1] > 0


def test_a_cylinder_is_the_tube(tmp_path: Path) -> None:
    grains = f"{HEAD}0.0024,0.0012,0,0.01,3,1,0\n0,0,0.03,0.01,0,0,0\n"
    sides = {"tube": {"radius": 0.0078}, "material": "steel"}
    tube = {"bottom": "free", "sides": sides}
    cylinder = [{"region": "cylinder z 0 0 0.0078 INF INF", "material": "steel"}]
    with (
        ran(tmp_path / "one", grains, boundary=tube) as one,
        ran(tmp_path / "two", grains, boundary={"bottom": "free"}, wall=cylinder) as two,
    ):
        same(one, two, ("tube", "wall1"))


def test_a_block_is_planes_on_three_sides_at_once(tmp_path: Path) -> None:
    """A sphere in a corner hits three faces at once, with equal forces."""
    grains = f"{HEAD}0,0,0,0.01,2,2,2\n-0.02,0,0,0.01,0,0,0\n"
    block = [{"region": "block -0.1 0.0051 -0.1 0.0051 -0.1 0.0051"}]
    law = {"law": "hertz"}
    bottom = {"bottom": "free"}
    with ran(tmp_path / "run", grains, boundary=bottom, wall=block, contact=law) as result:
        velocity = result.frame(1, "velocity")[0]
        others = [result[f"walls/wall1{axis}lo/force"].max() for axis in "xyz"]
        given = result["energy/input"][-1]
        error = result["energy/kinetic"] + result["energy/elastic"] - given
        forces = [result[f"walls/wall1{axis}hi/force"].max() for axis in "xyz"]
    assert others == [0, 0, 0]
    assert velocity == pytest.approx([-2, -2, -2], rel=1e-4)
    assert forces == pytest.approx([forces[0]] * 3, rel=1e-9)
    assert np.abs(error).max() < 1e-5 * given


def test_a_hopper_of_two_regions(tmp_path: Path) -> None:
    """Grains and a clump run down a cone into a tube: the energy balance closes with friction and
    indentations.
    """
    grains = (
        "x,y,z,diameter,clump,vx,vy,vz\n0,0,0,0.01,0,0.5,0,3\n0.0105,0,0.001,0.01,1,0,0,4\n"
        "0.0105,0.006,0.001,0.01,1,0,0,4\n"
    )
    regions = [
        {"region": "cone z 0 0 0.04 0.014 -0.02 0.012 open 1 open 2", "material": "steel"},
        {"region": "cylinder z 0 0 0.014 0.012 0.03 open 1", "friction": 0.5},
    ]
    run = {"end_time": 6e-3, "timestep": 6e-8, "frames": 2}
    bottom = {"bottom": "free"}
    tables = {"boundary": bottom, "wall": regions, "contact": {"friction": 0.2}, "run": run}
    with ran(tmp_path / "run", grains, **tables) as result:
        energy = sum(result[f"energy/{name}"] for name in ("kinetic", "elastic", "dissipated"))
        given = result["energy/input"]
        walls = set(result["wall_contacts/wall"].tolist())
        assert result["energy/friction"][-1] > 0
    assert np.abs(energy / given - 1).max() < 1e-5
    assert "wall1" in walls


@pytest.mark.parametrize("n", [1, 10])
def test_a_plate_of_triangles_is_the_bottom(tmp_path: Path, n: int) -> None:
    """A plate of 2 or 200 triangles, in millimetres and displaced."""
    file = tmp_path / "plate.stl"
    file.write_text(meshes.stl_text(1e3 * meshes.plate(n, height=0.006)))
    plate = [{"stl": str(file), "units": "mm", "moved": [0.0, 0.0, -0.001], "material": "steel"}]
    contact = {"contact": {"friction": 0.3}}
    with (
        ran(tmp_path / "one", PAIR, boundary={"bottom": {"material": "steel"}}, **contact) as one,
        ran(tmp_path / "two", PAIR, boundary={"bottom": "free"}, wall=plate, **contact) as two,
    ):
        same(one, two, ("bottom", "wall1"))
        assert one["energy/friction"][-1] > 0


def test_a_hopper_of_triangles(tmp_path: Path) -> None:
    """Grains run down a funnel of facets: one smooth patch, and the energy balance closes."""
    grains = f"{HEAD}0,0,0,0.01,0.5,0,3\n0.012,0,0.001,0.01,0,0,4\n"
    sides = meshes.tube(60, 0.04, -0.02, 0.012)
    sides[..., :2] *= 1 - 0.65 * ((sides[..., 2:] + 0.02) / 0.032)
    file = tmp_path / "funnel.stl"
    file.write_bytes(meshes.stl_binary(1e3 * sides))
    run = {"end_time": 6e-3, "timestep": 6e-8, "frames": 2}
    wall = [{"stl": str(file), "units": "mm", "material": "steel"}]
    tables = {
        "boundary": {"bottom": "free"},
        "wall": wall,
        "contact": {"friction": 0.2},
        "run": run,
    }
    with ran(tmp_path / "run", grains, **tables) as result:
        energy = sum(result[f"energy/{name}"] for name in ("kinetic", "elastic", "dissipated"))
        given = result["energy/input"]
        force = result["walls/wall1/force"].max()
    assert np.abs(energy / given - 1).max() < 1e-5
    assert force > 100
