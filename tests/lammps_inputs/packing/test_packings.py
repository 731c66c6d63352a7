"""Packings and plane crystals: positions, contacts, periods, faults."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from granwave.lammps_inputs import build_packing, make_schedule, walls
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.deck.script import input_script
from granwave.lammps_inputs.lattices import FILE, KINDS, Lattice, kind_of
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.motion import left_out, line_ids, struck_of
from granwave.lammps_inputs.packing.packing import Packing
from granwave.lammps_inputs.packing.places import struck_spheres

D = 0.01
INSIDE = {  # coordination
    "fcc": 12,
    "hcp": 12,
    "bcc": 8,
    "sc": 6,
    "square": 4,
    "hexagonal": 6,
    "centred-square": 4,
    "chain": 2,
}
SOLID = [kind for kind, rule in KINDS.items() if rule.axes == "xyz"]


def make_case(kind: str, size: tuple[int, ...], **sections: Any) -> Case:
    packing = {"kind": kind, "size": list(size) if len(size) > 1 else size[0], "diameter": D}
    return case_from_dict({"name": "test", "packing": packing, "material": "brass", **sections})


def make(kind: str, size: tuple[int, ...], periodic: bool = False) -> Packing:
    return build_packing(
        make_case(kind, size, boundary={"sides": "periodic" if periodic else "free"})
    )


def touching_pairs(packing: Packing) -> np.ndarray:
    """All pairs of spheres within 1e-6 D of contact, by comparing all pairs and images."""
    x = packing.positions
    step = x[None, :, :] - x[:, None, :]
    if packing.lattice.periodic:
        for axis, length in enumerate(packing.lattice.lengths):
            step[..., axis] -= length * np.round(step[..., axis] / length)
    first, second = np.nonzero(np.linalg.norm(step, axis=2) - D <= 1e-6 * D)
    return np.stack([first, second], axis=1)[first < second] + 1


@pytest.mark.parametrize(("kind", "stacking"), [("fcc", 3), ("hcp", 2)])
def test_positions_of_hexagonal_packings_are_those_promised(kind: str, stacking: int) -> None:
    positions = make(kind, (4, 5, 7)).positions.reshape(7, 5, 4, 3)
    for k, j, i in np.ndindex(7, 5, 4):
        s = k % stacking
        x = D * (i + (j % 2) / 2 + s / 2)
        y = D * (j * math.sqrt(3) / 2 + s * math.sqrt(3) / 6)
        assert positions[k, j, i] == pytest.approx(
            (x, y, D * k * math.sqrt(2 / 3)), rel=1e-15, abs=1e-17
        )


def test_positions_of_the_other_kinds() -> None:
    a = 2 * D / math.sqrt(3)
    assert make("bcc", (2, 2, 3)).positions[[1, 2, 4, 8]] == pytest.approx(
        np.array([[a, 0, 0], [0, a, 0], [a / 2, a / 2, a / 2], [0, 0, a]]), rel=1e-15
    )
    for kind, size, last in (
        ("sc", (2, 2, 2), (1, 1, 1)),
        ("square", (3, 4), (2, 3, 0)),
        ("chain", (5,), (0, 0, 4)),
    ):
        assert make(kind, size).positions[-1] / D == pytest.approx(last)


SIZES = [
    *[(kind, size) for kind in SOLID for size in [(1, 1, 1), (2, 3, 4), (6, 5, 7), (1, 6, 2)]],
    *[("square", size) for size in [(1, 1), (2, 3), (7, 6)]],
    *[
        (kind, size)
        for kind in ("hexagonal", "centred-square")
        for size in [(2, 1), (5, 6), (6, 7)]
    ],
    *[("chain", (n,)) for n in (1, 2, 9)],
]


@pytest.mark.parametrize(
    ("kind", "size", "periodic"),
    [
        *((kind, size, False) for kind, size in SIZES),
        *((kind, size, True) for kind in SOLID for size in [(3, 4, 7), (5, 6, 4)]),
        ("sc", (3, 3, 3), True),
        ("square", (5, 4), True),
    ],
)
def test_contacts(kind: str, size: tuple[int, ...], periodic: bool) -> None:
    packing = make(kind, size, periodic)
    expected = touching_pairs(packing)
    np.testing.assert_array_equal(packing.contacts, expected)
    assert packing.lattice.n_contacts == len(expected)
    counts = np.bincount(expected.ravel(), minlength=packing.n_spheres + 1)[1:]
    np.testing.assert_array_equal(packing.coordination, counts)
    for sphere in (1, packing.n_spheres) if not periodic else ():
        partners = expected[(expected == sphere).any(axis=1)]
        assert packing.lattice.neighbours(sphere) == sorted(
            set(partners.ravel().tolist()) - {sphere}
        )
    if not periodic:
        bounds = packing.lattice.bounds()
        np.testing.assert_array_equal(
            bounds, [packing.positions.min(axis=0), packing.positions.max(axis=0)]
        )


@pytest.mark.parametrize("kind", KINDS)
def test_coordination_inside(kind: str) -> None:
    packing = make(kind, (7, 7, 7)[: len(KINDS[kind].axes)])
    assert packing.coordination.max() == INSIDE[kind] == KINDS[kind].coordination


@pytest.mark.parametrize(
    ("flag", "kinds"),
    [
        ("is_chain", {"chain"}),
        ("is_layer", {"square"}),
        ("is_plane_crystal", {"hexagonal", "centred-square"}),
        ("is_close_packed", {"fcc", "hcp"}),
        ("has_faces", {"fcc", "hcp", "bcc", "sc", "square"}),
    ],
)
def test_flags_of_kinds(flag: str, kinds: set[str]) -> None:
    assert {name for name, kind in KINDS.items() if getattr(kind, flag)} == kinds


def test_grains_of_a_file_are_no_lattice() -> None:
    rule = kind_of(FILE)
    assert not (rule.is_lattice or rule.is_chain or rule.has_faces or rule.is_close_packed)


@pytest.mark.parametrize(
    ("kind", "size", "title", "axis"),
    [
        ("fcc", "[nx, ny, nz]", "FCC packing", (0.0, 0.0, 1.0)),
        ("square", "[nx, ny]", "Square packing", (0.0, 0.0, 1.0)),
        ("hexagonal", "[nx, nz]", "Hexagonal packing", (0.0, 1.0, 0.0)),
        ("chain", "n", "Chain", (0.0, 1.0, 0.0)),
    ],
)
def test_words_of_kinds(kind: str, size: str, title: str, axis: tuple[float, float, float]) -> None:
    rule = KINDS[kind]
    assert (rule.size_form, rule.title, rule.cylinder_axis) == (size, title, axis)


def test_moved_spheres_are_found_out() -> None:
    packing = make("fcc", (3, 3, 3))
    packing.atoms.positions[13] += 1e-4 * D
    with pytest.raises(RuntimeError, match="expected contact"):
        _ = packing.contacts


def test_atoms_carry_cell_and_diameters() -> None:
    atoms = make("hcp", (4, 6, 3), periodic=True).atoms
    assert atoms.pbc.tolist() == [True, True, False]
    assert atoms.cell.lengths()[:2] == pytest.approx([4 * D, 6 * D * math.sqrt(3) / 2])
    assert set(atoms.get_array("diameters")) == {D}


class TestStruckSpheres:
    def test_nearest_to_the_centroid_ties_go_to_the_lowest_id(self) -> None:
        # (35, 35) and (36, 36) of the top layer are equally near
        assert struck_spheres(Lattice("fcc", (72, 72, 30), D), 1) == (1 + 35 + 72 * 35,)
        assert struck_spheres(Lattice("sc", (2, 2, 2), D), 1) == (1,)
        assert struck_spheres(Lattice("square", (3, 3), D), 1) == (5,)
        assert struck_spheres(Lattice("chain", (7,), D), 1) == (1,)

    @pytest.mark.parametrize("kind", ["fcc", "hcp"])
    def test_three_touch_and_rest_on_one_sphere(self, kind: str) -> None:
        lattice = Lattice(kind, (7, 7, 4), D)
        struck = struck_spheres(lattice, 3)
        assert struck[0] == struck_spheres(lattice, 1)[0]
        for sphere in struck:
            assert set(struck) - {sphere} <= set(lattice.neighbours(sphere))
        common = set.intersection(*(set(lattice.neighbours(sphere)) for sphere in struck))
        assert [lattice.layer_of(sphere) for sphere in common] == [1]

    def test_seven_are_the_struck_sphere_and_its_ring(self) -> None:
        lattice = Lattice("fcc", (7, 7, 2), D)
        centre, *ring = (
            lattice.positions(sphere, sphere)[0] for sphere in struck_spheres(lattice, 7)
        )
        assert np.linalg.norm(np.array(ring) - centre, axis=1) == pytest.approx(np.full(6, D))
        assert not any(sphere[2] for sphere in ring)

    @pytest.mark.parametrize(
        ("kind", "size", "count"),
        [("fcc", (7, 7, 1), 3), ("fcc", (2, 2, 2), 7), ("bcc", (5, 5, 5), 3), ("chain", (9,), 7)],
    )
    def test_where_there_are_no_such_neighbours(
        self, kind: str, size: tuple[int, ...], count: int
    ) -> None:
        with pytest.raises(ValueError, match=r"require|rest with"):
            struck_spheres(Lattice(kind, size, D), count)


def test_walls_touch_the_outermost_spheres() -> None:
    case = make_case("fcc", (4, 4, 4), boundary={"sides": "wall"})
    positions = build_packing(case).positions
    planes = {wall.name: wall.coordinate for wall in walls(case)}
    low = positions.min(axis=0) - D / 2
    high = positions.max(axis=0) + D / 2
    assert planes == pytest.approx(
        {"bottom": high[2], "xlo": low[0], "xhi": high[0], "ylo": low[1], "yhi": high[1]}
    )
    assert walls(make_case("fcc", (4, 4, 4), boundary={"bottom": "free"})) == ()
    assert [
        wall.held_layer for wall in walls(make_case("fcc", (4, 4, 4), boundary={"bottom": "fixed"}))
    ] == [True]


DISC = 0.0127
SOFT = {"name": "soft", "youngs_modulus": 70e6, "poisson_ratio": 0.48, "density": 1130}
PLATE = {"kind": "plate", "mass": 0.5, "velocity": 6.0}


def crystal(kind: str = "centred-square", size: tuple[int, int] = (6, 16), **changes: Any) -> Case:
    packing = {"kind": kind, "size": list(size), "diameter": DISC} | changes.pop("packing", {})
    tables = {
        "material": SOFT,
        "contact": {"law": "hertz"},
        "load": PLATE,
        "boundary": {"sides": "wall"},
    }
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
    assert places["xhi"] - places["xlo"] == pytest.approx(width * DISC)
    assert places["bottom"] - places["plate"] == pytest.approx(height * DISC)
    assert set(places) == {"bottom", "plate", "xlo", "xhi"}  # none across y
    rows = np.unique(np.round(packing.positions[:, 2] / DISC, 6), return_counts=True)[1]
    long = size[0]
    short = size[0] - (top != "equal")
    assert rows.tolist() == ([short, long] if top == "short" else [long, short]) * (size[1] // 2)
    assert np.all(packing.positions[:, 1] == 0)


def test_the_plate_covers_the_top_row_and_its_centre_is_struck() -> None:
    assembly = assemble(crystal(packing={"top_row": "short"}))
    assert struck_of(assembly) == (3, 1, 2, 4, 5)
    text = input_script(assembly, make_schedule(assembly.case))
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
    [
        ("centred-square", "short", np.arange(8) * np.sqrt(2)),
        ("hexagonal", "long", np.arange(7) * np.sqrt(3)),
    ],
)
def test_lines_down_the_middle(kind: str, top: str, depths: np.ndarray) -> None:
    size = (6, 16) if kind == "centred-square" else (8, 14)
    start = {} if top == "short" else {"start": 12}
    case = crystal(kind, size, packing={"top_row": top}, line=[{"name": "down"} | start])
    assembly = assemble(case)
    ids = line_ids(assembly, case.line[0])
    centres = np.array([assembly.centre_of(one) for one in ids])
    assert (centres[:, 2] - centres[0, 2]) / DISC == pytest.approx(depths)
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
