"""Walls of regions in a case: their words, faces, distances, deck and rejected input."""

from __future__ import annotations

import tomllib
from typing import Any

import numpy as np
import pytest

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.region_walls import read_shape
from granwave.lammps_inputs.deck.deck import write_deck
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.region_faces import RegionFace

GRAINS = "x,y,z,diameter\n0,0,0,0.01\n0.011,0,0,0.01\n"


def walled(region: str, **tables: Any) -> Case:
    case = {
        "packing": {"kind": "file", "grains": GRAINS},
        "material": "brass",
        "boundary": {"bottom": "free"},
        "wall": [{"region": region}],
    }
    return case_from_dict(case | tables, "case")


def fault_of(region: str, **tables: Any) -> str:
    with pytest.raises(InputError) as caught:
        walled(region, **tables)
    return caught.value.errors[0].removeprefix("case: ")


@pytest.mark.parametrize(
    ("region", "faces"),
    [
        ("plane 0 0 0 0 0 -1", ("all",)),
        ("sphere 0 0 0 1", ("all",)),
        ("sphere 0 0 0 1 side out", ("all",)),
        ("cylinder x 0 0 1 INF INF side out", ("all",)),
        ("cylinder z 0 0 1 0 INF", ("lo", "side")),
        ("cone y 0 0 1 2 0 1 open 1 open 2", ("side",)),
        ("block INF INF 0 1 0 1 open 6", ("ylo", "yhi", "zlo")),
    ],
)
def test_faces_that_are_walls(region: str, faces: tuple[str, ...]) -> None:
    assert read_shape(region).faces == faces


@pytest.mark.parametrize(
    "region",
    [
        "plane 0.1 0.2 0.9 0.3 -0.2 -1",
        "sphere 0.1 0.2 0.3 1",
        "cylinder x 0.1 0.2 0.8 -1 1",
        "cylinder y 0.1 0.2 0.8 -1 1",
        "cone z 0.1 -0.2 0.4 0.9 -1 1",
        "cone x 0.1 -0.2 0.9 0.4 -1 1",
        "block -0.5 0.6 -0.7 0.8 -0.9 1",
    ],
)
def test_nearest_points_are_on_their_face(region: str) -> None:
    points = np.random.default_rng(1).uniform(-1, 1, (200, 3))
    shape = read_shape(region)
    for name in shape.faces:
        face = RegionFace("r", region, shape, name)
        distance = face.distances(points)
        inside = np.isfinite(distance)
        nearest = face.nearest(points[inside])
        apart = np.linalg.norm(points[inside] - nearest, axis=1)
        assert 10 < inside.sum() < 200
        assert (distance[inside] >= 0).all()
        assert apart == pytest.approx(distance[inside], rel=1e-12)
        # the same distance from a plane through the nearest point: it is the nearest there is
        on_face = RegionFace("r", region, shape, name).nearest(nearest)
        assert on_face == pytest.approx(nearest, abs=1e-12)


def test_a_case_keeps_its_regions_and_its_deck_names_them(tmp_path: Any) -> None:
    case = walled("cylinder  z 0 0 0.03 -0.02 0.02 open 1", load={"index": [1]})
    assert case.wall[0].region == "cylinder z 0 0 0.03 -0.02 0.02 open 1"
    assert case_from_dict(tomllib.loads(case.to_toml()), "case") == case
    script = write_deck(assemble(case), tmp_path).script.read_text()
    assert "region          wall1 cylinder z 0 0 0.03 -0.02 0.02 open 1 units box\n" in script
    assert (
        "fix             wall1hi all wall/gran/hysteretic region wall1 hi elastoplastic" in script
    )
    assert "fix             wall1side all wall/gran/hysteretic region wall1 side" in script


def test_grains_far_from_the_origin_stay_where_their_walls_are() -> None:
    far = "x,y,z,diameter\n5,0,0,0.01\n5.011,0,0,0.01\n"
    packing = {"kind": "file", "grains": far}
    assert assemble(walled("sphere 5 0 0 0.1", packing=packing)).deck_origin.tolist() == [0, 0, 0]


@pytest.mark.parametrize(
    ("region", "fault"),
    [
        (
            "ellipsoid 0 0 0 1 1 1",
            'wall.1.region: found "ellipsoid 0 0 0 1 1 1", expected arguments of',
        ),
        (
            "sphere 0 0 0",
            'wall.1.region: found "sphere 0 0 0", expected arguments of the LAMMPS reg',
        ),
        ("sphere 0 0 0 one", "wall.1.region: found"),
        ("sphere 0 0 0 -1", 'wall.1.region: found "sphere 0 0 0 -1", expected radii above 0'),
        ("sphere 0 0 0 0.1 move v_x NULL NULL", "wall.1.region: found"),
        ("sphere 0 0 0 0.1 side middle", "wall.1.region: found"),
        ("sphere 0 0 0 0.1 open 1", "wall.1.region: found"),
        ("plane 0 0 1 0 0 0", "wall.1.region: found"),
        ("cylinder z 0 0 0.1 1 0", "wall.1.region: found"),
        ("block 0 1 0 1 0 1 side out", "wall.1.region: found"),
        ("cylinder z 0 0 0.1 0 1 open 4", "wall.1.region: found"),
        ("cylinder z 0 0 0.003 -1 1", "wall.1.region: found"),
        ("sphere 9 0 0 0.1", 'wall.1.region: found "sphere 9 0 0 0.1", which contains no grain'),
        ("sphere 0 0 0 0.012", "wall.1.region: found"),
    ],
)
def test_wrong_regions_are_refused(region: str, fault: str) -> None:
    assert fault_of(region).startswith(fault)


@pytest.mark.parametrize(
    ("tables", "what"),
    [
        ({"precompression": {"kind": "overlaps"}}, "precompression"),
        (
            {
                "boundary": {"bottom": "free", "sides": "periodic"},
                "packing": {"kind": "file", "grains": GRAINS, "period": [0.05, 0.05]},
            },
            'boundary.sides = "periodic"',
        ),
    ],
)
def test_what_does_not_go_with_such_walls(tables: dict[str, Any], what: str) -> None:
    with pytest.raises(InputError) as caught:
        walled("sphere 0 0 0 0.1", **tables)
    assert any(
        f"wall.1.region: found this key with {what}" in text for text in caught.value.errors
    ) or (what == "precompression" and "precompression" in caught.value.errors[0])
