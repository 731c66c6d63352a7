"""Strikers and cylinders of chains."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.law import flat_contact, pair_contact
from granwave.lammps_inputs.deck.commands import contacts, cylinder_commands, wall_commands
from granwave.lammps_inputs.deck.deck import write_data
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import Assembly, assemble
from granwave.lammps_inputs.packing.disorder import is_random
from granwave.lammps_inputs.packing.packing import build_packing

D = 0.01
STEEL = {"youngs_modulus": 193e9, "poisson_ratio": 0.3, "density": 8000.0}
#: In its plane between spheres 16 and 21, and from above on 12, 13, 17, 18, of 5 x 6.
EDGE = [{"touches": [11, 16]}, {"touches": 31, "velocity": [0.3, 0.0, 0.0]}]
TOP = [{"touches": [12, 13, 17, 18]}, {"touches": 31, "velocity": [0.0, 0.0, 0.6]}]
SCATTERED = {"diameter_scatter": 1e-5, "tilt": [1, -1]}


def square(
    strikers: list[dict[str, Any]], packing: dict[str, Any] | None = None, **tables: Any
) -> Case:
    own = {"kind": "square", "size": [5, 6], "diameter": D} | (packing or {})
    contact = {"law": "hertz"}
    head = {
        "name": "square",
        "material": STEEL,
        "packing": own,
        "contact": contact,
        "striker": strikers,
    }
    return case_from_dict(head | tables)


def gaps(assembly: Assembly, striker: int, spheres: list[int]) -> np.ndarray:
    """Gaps between a striker, by its id, and spheres, m."""
    centre = assembly.centre_of(striker)
    radius = assembly.diameter_of(striker) / 2
    return np.array([np.linalg.norm(assembly.centre_of(one) - centre) - radius - assembly.diameter_of(one) / 2
                     for one in spheres])  # fmt: skip


def test_a_striker_off_centre_is_brought_up_along_its_way() -> None:
    offset = 0.8e-3
    case = square([EDGE[0], EDGE[1] | {"offset": [0.0, offset, 0.0]}])
    found = assemble(case)
    between = found.centre_of(31) - found.centre_of(32)
    np.testing.assert_allclose(between, [np.sqrt(D**2 - offset**2), -offset, 0.0], atol=1e-14)
    assert found.striker_contacts == [(11, 31), (16, 31), (31, 32)]
    along = assemble(
        square([EDGE[0], EDGE[1] | {"offset": [2e-3, offset, 0.0]}])
    )  # along its way it has no effect
    np.testing.assert_allclose(along.centre_of(32), found.centre_of(32), atol=1e-14)


def test_a_resting_striker_aside_leaves_a_gap() -> None:
    aside = 20e-6
    found = assemble(square([EDGE[0] | {"offset": [0.0, aside, 0.0]}, EDGE[1]]))
    assert found.striker_contacts == [(16, 31), (31, 32)]
    x = np.sqrt(D**2 - (D / 2 - aside) ** 2)  # it slides over sphere 16, which it touches
    np.testing.assert_allclose(
        gaps(found, 31, [16, 11]), [0.0, np.hypot(x, D / 2 + aside) - D], atol=1e-15
    )
    assert found.n_contacts == build_packing(found).contacts.shape[0]  # the gap is no contact


def test_misalignment_is_random_within_its_bounds_and_follows_the_seed() -> None:
    case = [
        square([EDGE[0], EDGE[1] | {"misalignment": [0.0, 5e-4, 0.0]}], {"seed": n})
        for n in range(1, 60)
    ]
    assert is_random(case[0]) and not is_random(square(EDGE))
    sides = np.array([assemble(one).centre_of(32)[1] - 2.5 * D for one in case])
    assert np.abs(sides).max() <= 5e-4 and sides.std() == pytest.approx(5e-4 / np.sqrt(3), rel=0.2)
    again = assemble(square([EDGE[0], EDGE[1] | {"misalignment": [0.0, 1e-3, 0.0]}], {"seed": 1}))
    assert again.centre_of(32)[1] - 2.5 * D == pytest.approx(
        2 * sides[0]
    )  # the same number, scaled
    only = square([EDGE[0] | {"misalignment": [0.0, 1e-5, 0.0]}, EDGE[1]])
    assert assemble(only).centre_of(31)[1] != pytest.approx(
        again.centre_of(31)[1], abs=1e-9
    )  # a stream of each striker


@pytest.mark.parametrize("tilt", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
def test_leaning_spheres_touch_their_neighbours_and_the_corner(tilt: tuple[int, int]) -> None:
    boundary = {"sides": "wall", "bottom": "wall"}
    packing = {"diameter_scatter": 3e-5, "tilt": list(tilt), "seed": 3}
    found = assemble(
        square([], packing, boundary=boundary, load={"kind": "impact", "velocity": 0.1})
    )
    built = build_packing(found)
    n_pairs = 5 * 5 + 4 * 6
    assert len(built.contacts) == found.n_contacts == n_pairs
    assert np.abs(built.gaps(built.contacts)).max() < 1e-16
    every = np.array([(i, j) for i in range(1, 31) for j in range(i + 1, 31)])
    assert built.gaps(every).min() > -1e-16  # nothing overlaps
    radii = found.sphere_diameters() / 2
    planes = {wall.name: wall for wall in built.walls}
    corner = [
        planes["xhi" if tilt[0] > 0 else "xlo"],
        planes["yhi" if tilt[1] > 0 else "ylo"],
        planes["bottom"],
    ]
    for wall, touching in zip(corner, (6, 5, 30), strict=True):
        apart = wall.outward * (wall.coordinate - built.positions[:, wall.axis]) - radii
        assert np.count_nonzero(np.abs(apart) < 1e-16) == touching and apart.min() > -1e-16


def test_a_striker_rests_on_three_of_four_scattered_spheres() -> None:
    for seed in range(1, 6):
        found = assemble(square(TOP, SCATTERED | {"seed": seed}))
        apart = gaps(found, 31, [12, 13, 17, 18])
        assert np.count_nonzero(np.abs(apart) < 1e-12) == 3 and 1e-9 < apart.max() < 1e-4
        assert len(found.striker_contacts) == 4
        # no place with three contacts is deeper, and the one at rest stays above
        assert found.centre_of(31)[2] < 0
    tilted, plain = (assemble(square(EDGE, more)) for more in ({"tilt": [1, 1]}, {}))
    np.testing.assert_array_equal(
        tilted.positions(), plain.positions()
    )  # without scatter a tilt changes nothing
    two = assemble(square(EDGE, SCATTERED))
    np.testing.assert_allclose(
        gaps(two, 31, [11, 16]), 0.0, atol=1e-12
    )  # two spheres always hold one in their plane


CHAIN = {"kind": "chain", "size": 3, "diameter": 0.01}
SMALL = {"shape": "cylinder", "diameter": 0.006, "length": 0.01, "material": "steel"}
BESIDE = 0.5 * math.sqrt(0.016**2 - 0.01**2)


def case(packing=CHAIN, **tables):
    return case_from_dict(
        {"material": "brass", "contact": {"law": "hertz"}, "boundary": {"bottom": "free"}, "load": {"index": [1]},
         "packing": packing, **tables}
    )  # fmt: skip


def beside(**changes):
    return SMALL | {"at": [[BESIDE, 0, 0.005], [-BESIDE, 0, 0.005]]} | changes


def test_a_row_with_cylinders():
    """Two cylinders at a contact touch both spheres; their masses are masses of cylinders."""
    made = assemble(case(grains=[beside()], boundary={"bottom": "free", "x": "wall"}))
    assert {tuple(pair) for pair in made.contacts().tolist()} == {
        (1, 2),
        (2, 3),
        (1, 4),
        (1, 5),
        (2, 4),
        (2, 5),
    }
    assert build_packing(made).coordination.tolist() == [3, 4, 1, 2, 2]
    density = made.material_of(4).density
    assert (
        made.mass_of(4)
        == made.sphere_masses()[3]
        == pytest.approx(density * math.pi * 0.003**2 * 0.01)
    )
    assert cylinder_commands(made) == ["fix             cylinders all gran/cylinder 2 0.01 0 1 0"]
    assert "line plane-strain" not in "".join(wall_commands(made))
    law = pair_contact(made, 1, 4)
    assert 0.003 < law.effective_radius < 0.005 and math.isinf(flat_contact(made, 4).yield_overlap)
    again = case_from_dict(made.case.to_dict())
    assert (
        again.packing.grains == made.case.packing.grains
        and "line" not in again.to_dict()["contact"]
    )


@pytest.mark.parametrize(
    ("kind", "size", "axis"), [("chain", 4, "0 1 0"), ("square", [3, 2], "0 0 1")]
)
def test_packings_of_cylinders(tmp_path, kind, size, axis):
    packing = {"kind": kind, "size": size, "diameter": 0.01, "shape": "cylinder", "length": 0.03}
    tables = {"boundary": {"bottom": "free", "sides": "wall"}}
    made = assemble(case(packing, **tables, contact={"law": "line"}))
    assert made.plane_strain and f"gran/cylinder 1 0.03 {axis} line plane-strain" in "\n".join(
        contacts(made)
    )
    as_half_spaces = assemble(case(packing, **tables))
    assert "plane-strain" not in "\n".join(contacts(as_half_spaces))
    modulus = pair_contact(as_half_spaces, 1, 2).effective_modulus
    depth = 1e-6
    force = float(pair_contact(as_half_spaces, 1, 2).loading_force(np.array([depth]))[0])
    v = 1 / (math.pi * modulus)  # both bodies; d is twice the effective radius
    assert force * v / 0.03 * (1 - math.log(v * force * 0.005 / (2 * 0.03**3))) == pytest.approx(
        depth, rel=1e-9
    )
    mass = made.material.density * math.pi * 0.005**2 * 0.03
    assert made.case.sphere_mass == pytest.approx(mass) and np.allclose(made.sphere_masses(), mass)
    write_data(made, tmp_path / "data")
    row = (tmp_path / "data").read_text().splitlines()[-1].split()
    assert float(row[3]) * math.pi / 6 * 0.01**3 == pytest.approx(mass)
    assert "line plane-strain" in "".join(wall_commands(made))


@pytest.mark.parametrize(
    ("row", "expected"),
    [
        ("0,0,0,0.01,cylinder,0,0,1,0", "line 2: found a cylinder with a length of 0 m"),
        ("0,0,0,0.01,cone,0.1,0,1,0", "line 2: found the shape 'cone'"),
        ("0,0,0,0.01,,0.1,0,0,0", "line 2: found the axis .* no direction"),
        ("0,0,0,0.01,cylinder,long,0,1,0", 'line 2: found "long" for length'),
    ],
)
def test_faults_of_a_file(tmp_path, row, expected):
    path = tmp_path / "grains.csv"
    path.write_text(f"x,y,z,diameter,shape,length,axis_x,axis_y,axis_z\n{row}\n")
    with pytest.raises(InputError, match=expected):
        case({"kind": "file", "file": str(path)})


def test_powers_in_the_deck():
    pairs = [{"materials": ["brass", "brass"], "law": "power", "constant": 3e7, "exponent": 1.2}]
    made = case(pair=pairs)
    assert "power 1.15e+11 0.3 constant 3e+07 exponent 1.2" in "\n".join(contacts(assemble(made)))
    assert pair_contact(assemble(made), 1, 2).loading_force(1e-6) == pytest.approx(3e7 * 1e-6**1.2)


def test_the_centre_of_a_rough_top_is_near_its_middle(tmp_path) -> None:
    """The uppermost grain is in a corner; the lower grain in the middle has space for a small
    striker; a large striker rests on a neighbour.
    """
    (tmp_path / "grains.csv").write_text(
        "x,y,z,diameter\n0,0,-0.02,0.01\n0.02,0.02,0,0.01\n"
        "0.031,0.02,-0.008,0.01\n0.04,0.041,0,0.01\n"
    )
    packing = {"kind": "file", "file": str(tmp_path / "grains.csv")}
    for diameter, touched in ((0.008, 2), (0.04, 3)):
        striker = {"touches": "centre", "diameter": diameter, "velocity": [0.0, 0.0, 1.0]}
        case = case_from_dict(
            {
                "name": "rough",
                "material": STEEL,
                "packing": packing,
                "contact": {"law": "hertz"},
                "striker": [striker],
            }
        )
        assert case.striker[0].touches == (touched,)
        found = assemble(case)
        between = gaps(found, 5, [1, 2, 3, 4])
        assert between.min() == pytest.approx(0.0, abs=1e-12)
        assert between.argmin() + 1 == touched
