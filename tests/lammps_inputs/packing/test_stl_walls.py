"""Surfaces of triangles of STL files in a case: units, position, deck, stored case, and rejected
input.
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granwave._contact_laws import read_stl
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.deck.deck import write_deck
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.walls import walls
from tests.helpers import meshes

GRAINS = "x,y,z,diameter\n0,0,0,0.01\n0.011,0,0,0.01\n"


def walled(*entries: dict[str, Any], **tables: Any) -> Case:
    case = {
        "packing": {"kind": "file", "grains": GRAINS},
        "material": "brass",
        "boundary": {"bottom": "free"},
        "load": {"index": [1]},
        "wall": list(entries),
    }
    return case_from_dict(case | tables, "case")


def fault_of(*entries: dict[str, Any], **tables: Any) -> str:
    with pytest.raises(InputError) as caught:
        walled(*entries, **tables)
    return "\n".join(caught.value.errors)


@pytest.fixture
def box(tmp_path: Path) -> str:
    """A cube of 40 units around the origin."""
    path = tmp_path / "box.stl"
    path.write_bytes(meshes.stl_binary(meshes.box(20.0)))
    return str(path)


def test_a_file_in_millimetres_is_moved(box: str, tmp_path: Path) -> None:
    entry = {"stl": box, "units": "mm", "moved": [0.0, 0.0, 0.001], "friction": 0.4}
    case = walled(entry, {"region": "plane 0 0 0.05 0 0 -1"})
    assembly = assemble(case)
    names = [wall.name for wall in walls(assembly)]
    assert names == [*(f"wall1patch{k}" for k in range(1, 7)), "wall2"]
    gaps = sorted(
        float(wall.gaps(np.zeros((1, 3)), np.array([0.005]))[0]) for wall in walls(assembly)[:6]
    )
    assert gaps == pytest.approx([0.014, 0.015, 0.015, 0.015, 0.015, 0.016], rel=1e-6)
    deck = write_deck(assembly, tmp_path / "deck")
    script = deck.script.read_text()
    assert "wall/gran/hysteretic mesh wall1.stl 30 6 elastoplastic" in script
    assert "region wall2 all" in script
    assert "wall1.stl" in deck.written
    corners = read_stl((tmp_path / "deck" / "wall1.stl").read_bytes())
    assert corners.reshape(-1, 3).max(axis=0) == pytest.approx([0.02, 0.02, 0.021], rel=1e-12)


def test_the_case_of_a_run_holds_the_triangles(box: str) -> None:
    case = walled({"stl": box, "units": "mm"})
    assert case.wall[0].stl is None
    text = case.to_toml()
    Path(box).unlink()
    assert case_from_dict(tomllib.loads(text), "case") == case


def test_a_tube_has_one_patch_at_a_large_angle(tmp_path: Path) -> None:
    path = tmp_path / "tube.stl"
    path.write_text(meshes.stl_text(meshes.tube(8, 0.03, -0.02, 0.02)))
    assert len(walls(assemble(walled({"stl": str(path), "angle": 50})))) == 1
    assert len(walls(assemble(walled({"stl": str(path)})))) == 8


def test_wrong_surfaces_are_refused(box: str, tmp_path: Path) -> None:
    plane = "plane 0 0 0.05 0 0 -1"
    broken = tmp_path / "broken.stl"
    broken.write_bytes(Path(box).read_bytes()[:-7])
    plate = tmp_path / "plate.stl"
    plate.write_text(meshes.stl_text(meshes.plate(2, 0.02, 0.004)))
    rough = tmp_path / "rough.stl"
    points = np.random.default_rng(1).uniform(-1, 1, (200, 3, 3)) * 0.01 + 0.03
    rough.write_text(meshes.stl_text(points))
    periodic = {"kind": "file", "grains": GRAINS, "period": [0.05, 0.05]}
    sides = {"bottom": "free", "sides": "periodic"}
    faults = {
        fault_of({}): "wall.1: found neither region nor stl",
        fault_of({"stl": box, "region": plane}): "wall.1: found region and stl, expected one shape",
        fault_of({"region": plane, "units": "mm"}): "wall.1.units: found this key with a region",
        fault_of({"stl": "nowhere.stl"}): "nowhere.stl: cannot be read: No such file",
        fault_of({"stl": str(broken)}): "broken.stl: found 677 bytes, expected an STL file",
        fault_of({"stl": 3}): "wall.1.stl: found 3, expected the path of an STL file",
        fault_of({"stl": box}): "wall.1.stl: found a surface of 40 m, and grains in 0.0",
        fault_of({"stl": str(plate)}): "grain 1 overlaps its wall by 0.001 m",
        fault_of({"stl": str(rough)}): "wall.1.angle: found a surface of 200 patches",
        fault_of({"triangles": "solid"}): "wall.1.triangles: found",
        fault_of(
            {"stl": box, "units": "mm"}, packing=periodic, boundary=sides
        ): 'wall.1.stl: found this key with boundary.sides = "periodic"',
    }  # fmt: skip
    for fault, expected in faults.items():
        assert expected in fault
        assert "\n" not in fault
