"""Packings: exact positions, contacts against a brute-force search, struck spheres, walls."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.lattices import KINDS, Lattice
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.packing import Packing, build_packing
from granwave.lammps_inputs.packing.places import struck_spheres
from granwave.lammps_inputs.packing.walls import walls

D = 0.01
INSIDE = {
    "fcc": 12,
    "hcp": 12,
    "bcc": 8,
    "sc": 6,
    "square": 4,
    "hexagonal": 6,
    "centred-square": 4,
    "chain": 2,
}  # coordination
SOLID = [kind for kind, rule in KINDS.items() if rule.axes == "xyz"]


def make_case(kind: str, size: tuple[int, ...], **sections: Any) -> Case:
    packing = {"kind": kind, "size": list(size) if len(size) > 1 else size[0], "diameter": D}
    return case_from_dict({"name": "test", "packing": packing, "material": "brass", **sections})


def make(kind: str, size: tuple[int, ...], periodic: bool = False) -> Packing:
    return build_packing(make_case(kind, size, boundary={"sides": "periodic" if periodic else "free"}))


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
    nx, ny, nz = 4, 5, 7
    positions = make(kind, (nx, ny, nz)).positions
    for k in range(nz):
        for j in range(ny):
            for i in range(nx):
                s = k % stacking
                x = D * (i + (j % 2) / 2 + s / 2)
                y = D * (j * math.sqrt(3) / 2 + s * math.sqrt(3) / 6)
                z = D * k * math.sqrt(2 / 3)
                assert positions[i + nx * (j + ny * k)] == pytest.approx((x, y, z), rel=1e-15, abs=1e-17)


def test_positions_of_the_other_kinds() -> None:
    a = 2 * D / math.sqrt(3)
    assert make("bcc", (2, 2, 3)).positions[[1, 2, 4, 8]] == pytest.approx(
        np.array([[a, 0, 0], [0, a, 0], [a / 2, a / 2, a / 2], [0, 0, a]]), rel=1e-15
    )
    assert make("sc", (2, 2, 2)).positions[-1] == pytest.approx((D, D, D))
    assert make("square", (3, 4)).positions[-1] == pytest.approx((2 * D, 3 * D, 0))
    assert make("chain", (5,)).positions[-1] == pytest.approx((0, 0, 4 * D))


SIZES = [
    *[(kind, size) for kind in SOLID for size in [(1, 1, 1), (2, 3, 4), (6, 5, 7), (1, 6, 2)]],
    *[("square", size) for size in [(1, 1), (2, 3), (7, 6)]],
    *[(kind, size) for kind in ("hexagonal", "centred-square") for size in [(2, 1), (5, 6), (6, 7)]],
    *[("chain", (n,)) for n in (1, 2, 9)],
]


@pytest.mark.parametrize(("kind", "size"), SIZES)
def test_contacts_of_free_packings(kind: str, size: tuple[int, ...]) -> None:
    packing = make(kind, size)
    expected = touching_pairs(packing)
    np.testing.assert_array_equal(packing.contacts, expected)
    assert packing.lattice.n_contacts == len(expected)
    counts = np.bincount(expected.ravel(), minlength=packing.n_spheres + 1)[1:]
    np.testing.assert_array_equal(packing.coordination, counts)
    for sphere in (1, packing.n_spheres):
        partners = expected[(expected == sphere).any(axis=1)]
        assert packing.lattice.neighbours(sphere) == sorted(set(partners.ravel().tolist()) - {sphere})


@pytest.mark.parametrize(
    ("kind", "size"),
    [*[(kind, size) for kind in SOLID for size in [(3, 4, 7), (5, 6, 4)]], ("sc", (3, 3, 3)), ("square", (5, 4))],
)
def test_contacts_of_periodic_packings(kind: str, size: tuple[int, ...]) -> None:
    packing = make(kind, size, periodic=True)
    expected = touching_pairs(packing)
    np.testing.assert_array_equal(packing.contacts, expected)
    assert packing.lattice.n_contacts == len(expected)
    if kind == "square":
        assert set(packing.coordination) == {4}


@pytest.mark.parametrize("kind", KINDS)
def test_coordination_inside(kind: str) -> None:
    packing = make(kind, (7, 7, 7)[: len(KINDS[kind].axes)])
    assert packing.coordination.max() == INSIDE[kind] == KINDS[kind].coordination


def test_reference_packing() -> None:
    packing = make("fcc", (72, 72, 30))
    assert packing.n_spheres == 155_520
    assert packing.lattice.n_contacts == len(packing.contacts) == packing.coordination.sum() // 2
    assert np.abs(packing.gaps(packing.contacts)).max() < 1e-12 * D


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


def test_bounds_without_building_the_packing() -> None:
    for kind, size in SIZES:
        lattice = Lattice(kind, size, D)
        positions = lattice.positions(1, lattice.n_spheres)
        np.testing.assert_array_equal(lattice.bounds(), [positions.min(axis=0), positions.max(axis=0)])


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
        centre, *ring = struck_spheres(lattice, 7)
        assert len(ring) == 6
        at = {sphere: lattice.positions(sphere, sphere)[0] for sphere in (centre, *ring)}
        assert all(np.linalg.norm(at[sphere] - at[centre]) == pytest.approx(D) for sphere in ring)
        assert all(at[sphere][2] == 0 for sphere in ring)

    @pytest.mark.parametrize(
        ("kind", "size", "count"),
        [("fcc", (7, 7, 1), 3), ("fcc", (2, 2, 2), 7), ("bcc", (5, 5, 5), 3), ("chain", (9,), 7)],
    )
    def test_where_there_are_no_such_neighbours(self, kind: str, size: tuple[int, ...], count: int) -> None:
        with pytest.raises(ValueError, match=r"need|rest with"):
            struck_spheres(Lattice(kind, size, D), count)


def test_walls_touch_the_outermost_spheres() -> None:
    case = make_case("fcc", (4, 4, 4), boundary={"sides": "wall"})
    positions = build_packing(case).positions
    planes = {wall.name: wall.coordinate for wall in walls(case)}
    low, high = positions.min(axis=0) - D / 2, positions.max(axis=0) + D / 2
    assert planes == pytest.approx({"bottom": high[2], "xlo": low[0], "xhi": high[0], "ylo": low[1], "yhi": high[1]})
    assert walls(make_case("fcc", (4, 4, 4), boundary={"bottom": "free"})) == ()
    assert [wall.held_layer for wall in walls(make_case("fcc", (4, 4, 4), boundary={"bottom": "fixed"}))] == [True]
