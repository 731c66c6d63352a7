"""Plane crystals: rows, straight sides, walls with a gap, plates, and lines of grains."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.deck.script import input_script
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.motion import left_out, line_ids, struck_of
from granwave.lammps_inputs.packing.packing import build_packing
from granwave.lammps_inputs.packing.walls import walls
from granwave.lammps_inputs.planning.schedule import make_schedule

D = 0.0127
SOFT = {"name": "soft", "youngs_modulus": 70e6, "poisson_ratio": 0.48, "density": 1130}
PLATE = {"kind": "plate", "mass": 0.5, "velocity": 6.0}
PRECOMPRESSION = {"kind": "walls", "x": 1e-5}


def crystal(kind: str = "centred-square", size: tuple[int, int] = (6, 16), **changes: Any) -> Case:
    packing = {"kind": kind, "size": list(size), "diameter": D} | changes.pop("packing", {})
    tables = {"material": SOFT, "contact": {"law": "hertz"}, "load": PLATE, "boundary": {"sides": "wall"}}
    return case_from_dict({"name": "crystal", "packing": packing, **(tables | changes)})


@pytest.mark.parametrize(
    ("kind", "size", "top", "count", "width", "height"),
    [
        ("centred-square", (6, 16), "short", 88, 5 * np.sqrt(2) + 1, 15 / np.sqrt(2) + 1),
        ("hexagonal", (8, 14), "long", 105, 8.0, 13 * np.sqrt(3) / 2 + 1),
        ("hexagonal", (8, 14), "equal", 112, 8.5, 13 * np.sqrt(3) / 2 + 1),
    ],
)
def test_the_crystals_of_the_source(
    kind: str, size: tuple[int, int], top: str, count: int, width: float, height: float
) -> None:
    case = crystal(kind, size, packing={"top_row": top})
    packing = build_packing(case)
    places = {wall.name: wall.coordinate for wall in packing.walls}
    assert packing.n_spheres == count
    assert places["xhi"] - places["xlo"] == pytest.approx(width * D)
    assert places["bottom"] - places["plate"] == pytest.approx(height * D)
    assert set(places) == {"bottom", "plate", "xlo", "xhi"}  # none across y
    rows = np.unique(np.round(packing.positions[:, 2] / D, 6), return_counts=True)[1]
    long, short = size[0], size[0] - (top != "equal")
    assert rows.tolist() == ([short, long] if top == "short" else [long, short]) * (size[1] // 2)
    assert np.all(packing.positions[:, 1] == 0)


def test_the_plate_covers_the_top_row_and_its_centre_is_struck() -> None:
    assembly = assemble(crystal(packing={"top_row": "short"}))
    assert struck_of(assembly) == (3, 1, 2, 4, 5)
    text = input_script(assembly, make_schedule(assembly))
    assert "support free 0.5 6" in text and "v_motion" in text and "c_kinetic+f_plate[12]" in text
    assert "0.5*0.5*6^2" in text


def test_gap_and_pressure_of_side_walls() -> None:
    free, gap, pressed = (
        {wall.name: wall.coordinate for wall in walls(crystal(boundary={"sides": "wall"} | change))}
        for change in ({}, {"side_gap": 1e-4}, {"side_gap": -1e-5})
    )
    assert free["xlo"] - gap["xlo"] == pytest.approx(1e-4) == gap["xhi"] - free["xhi"]
    assert pressed["xlo"] - free["xlo"] == pytest.approx(1e-5) == free["xhi"] - pressed["xhi"]
    case = crystal(boundary={"sides": "wall", "side_gap": -1e-5})
    assert case.precompression is not None and case.precompression.moves == {"x": 1e-5}
    assert case_from_dict(case.to_dict()) == case


@pytest.mark.parametrize(
    ("kind", "top", "depths"),
    [("centred-square", "short", np.arange(8) * np.sqrt(2)), ("hexagonal", "long", np.arange(7) * np.sqrt(3))],
)
def test_lines_down_the_middle(kind: str, top: str, depths: np.ndarray) -> None:
    size = (6, 16) if kind == "centred-square" else (8, 14)
    start = {} if top == "short" else {"start": 12}
    case = crystal(kind, size, packing={"top_row": top}, line=[{"name": "down"} | start])
    assembly = assemble(case)
    ids = line_ids(assembly, case.line[0])
    centres = np.array([assembly.centre_of(one) for one in ids])
    assert (centres[:, 2] - centres[0, 2]) / D == pytest.approx(depths)
    assert np.ptp(centres[:, 0]) == pytest.approx(0, abs=1e-12)
    assert left_out(assembly, case.line[0]) == 2


def test_other_lines() -> None:
    lines = [
        {"name": "diagonal", "start": 1, "direction": [1, 0, 1]},
        {"name": "some", "index": [5, 3, 9], "leave_out": 1},
        {"name": "all", "index": "all"},
    ]
    case = crystal(size=(4, 5), line=lines)
    assembly = assemble(case)
    diagonal, some, everything = (line_ids(assembly, line) for line in case.line)
    assert diagonal == (1, 5, 9, 13, 17)[: len(diagonal)] and len(diagonal) == 5
    assert some == (5, 3, 9) and everything == tuple(range(1, 19))
    assert left_out(assembly, case.line[1]) == 1


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"size": (1, 5)}, "short rows would be empty"),
        ({"packing": {"kind": "fcc", "size": [3, 3, 3], "top_row": "short"}, "boundary": {}}, "packing.top_row"),
        ({"boundary": {"sides": "periodic"}}, 'expected "equal"'),
        ({"load": {"kind": "plate"}}, "load.mass: missing"),
        ({"load": {"kind": "impact", "mass": 1.0}}, 'belongs to a load of kind "plate"'),
        ({"boundary": {"sides": "free", "side_gap": 1e-4}}, "there are no side walls"),
        ({"boundary": {"sides": "wall", "side_gap": -0.01}}, "the walls press at most"),
        ({"boundary": {"sides": "wall", "side_gap": -1e-5}, "precompression": {"kind": "gravity"}}, "take one of them"),
        ({"precompression": {"kind": "uniaxial", "pressure": 1e3}}, "a crystal in the plane, which has no face"),
        ({"precompression": {"kind": "uniaxial", "force": 1.0}}, "would bear any other load"),
        ({"striker": [{"touches": [1], "velocity": [0, 0, 1]}]}, "covers the whole top"),
        ({"line": [{"name": "a", "start": 999}]}, "line.1.start: found 999"),
        ({"line": [{"name": "a", "direction": [0, 0, -1]}]}, "found 1 grain along"),
        ({"line": [{"name": "a", "direction": [0, 0, 0]}]}, "line.1.direction"),
        ({"line": [{"name": "a", "index": [1, 1]}]}, "expected each id once"),
        ({"line": [{"name": "a", "index": [1, 2], "start": 1}]}, "give one of them"),
        ({"line": [{"name": "a"}, {"name": "a"}]}, "line.2.name"),
        ({"line": [{"name": "a b"}]}, "letters, digits"),
    ],
)
def test_what_cannot_be(changes: dict[str, Any], said: str) -> None:
    size = changes.pop("size", (6, 6))
    with pytest.raises(InputError) as found:
        crystal(size=size, **changes)
    assert any(said in line for line in found.value.errors), found.value.errors


def test_a_cylinder_that_strikes_lies_as_those_of_the_packing() -> None:
    """In a square, whose rows are along x and y, cylinders are along z."""
    case = case_from_dict({
        "name": "square", "packing": {"kind": "square", "size": [3, 3], "shape": "cylinder", "length": 0.02,
                                      "diameter": 0.01},
        "material": "steel", "contact": {"law": "line"}, "boundary": {"bottom": "free"},
        "striker": [{"touches": [2], "velocity": [0, 1, 0], "shape": "cylinder", "length": 0.02}],
    })  # fmt: skip
    assert case.striker[0].body == case.packing.of_grain
    assert case.packing.of_grain is not None and case.packing.of_grain.axis == (0.0, 0.0, 1.0)
