"""Strikers that are misaligned or rest on scattered spheres, and spheres that lean on each other on a tilted floor."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from granwave.lammps_inputs.case.case import Case
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


def square(strikers: list[dict[str, Any]], packing: dict[str, Any] | None = None, **tables: Any) -> Case:
    own = {"kind": "square", "size": [5, 6], "diameter": D} | (packing or {})
    contact = {"law": "hertz"}
    head = {"name": "square", "material": STEEL, "packing": own, "contact": contact, "striker": strikers}
    return case_from_dict(head | tables)


def gaps(assembly: Assembly, striker: int, spheres: list[int]) -> np.ndarray:
    """Gaps between a striker, by its id, and spheres, m."""
    centre, radius = assembly.centre_of(striker), assembly.diameter_of(striker) / 2
    return np.array([np.linalg.norm(assembly.centre_of(one) - centre) - radius - assembly.diameter_of(one) / 2
                     for one in spheres])  # fmt: skip


def test_a_striker_off_centre_is_brought_up_along_its_way() -> None:
    offset = 0.8e-3
    case = square([EDGE[0], EDGE[1] | {"offset": [0.0, offset, 0.0]}])
    found = assemble(case)
    between = found.centre_of(31) - found.centre_of(32)
    np.testing.assert_allclose(between, [np.sqrt(D**2 - offset**2), -offset, 0.0], atol=1e-14)
    assert found.striker_contacts == [(11, 31), (16, 31), (31, 32)]
    along = assemble(square([EDGE[0], EDGE[1] | {"offset": [2e-3, offset, 0.0]}]))  # along its way it has no effect
    np.testing.assert_allclose(along.centre_of(32), found.centre_of(32), atol=1e-14)


def test_a_resting_striker_aside_leaves_a_gap() -> None:
    aside = 20e-6
    found = assemble(square([EDGE[0] | {"offset": [0.0, aside, 0.0]}, EDGE[1]]))
    assert found.striker_contacts == [(16, 31), (31, 32)]
    x = np.sqrt(D**2 - (D / 2 - aside) ** 2)  # it slides over sphere 16, which it touches
    np.testing.assert_allclose(gaps(found, 31, [16, 11]), [0.0, np.hypot(x, D / 2 + aside) - D], atol=1e-15)
    assert found.n_contacts == build_packing(found).contacts.shape[0]  # the gap is no contact


def test_misalignment_is_random_within_its_bounds_and_follows_the_seed() -> None:
    case = [square([EDGE[0], EDGE[1] | {"misalignment": [0.0, 5e-4, 0.0]}], {"seed": n}) for n in range(1, 60)]
    assert is_random(case[0]) and not is_random(square(EDGE))
    sides = np.array([assemble(one).centre_of(32)[1] - 2.5 * D for one in case])
    assert np.abs(sides).max() <= 5e-4 and sides.std() == pytest.approx(5e-4 / np.sqrt(3), rel=0.2)
    again = assemble(square([EDGE[0], EDGE[1] | {"misalignment": [0.0, 1e-3, 0.0]}], {"seed": 1}))
    assert again.centre_of(32)[1] - 2.5 * D == pytest.approx(2 * sides[0])  # the same number, scaled
    only = square([EDGE[0] | {"misalignment": [0.0, 1e-5, 0.0]}, EDGE[1]])
    assert assemble(only).centre_of(31)[1] != pytest.approx(
        again.centre_of(31)[1], abs=1e-9
    )  # a stream of each striker


@pytest.mark.parametrize("tilt", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
def test_leaning_spheres_touch_their_neighbours_and_the_corner(tilt: tuple[int, int]) -> None:
    boundary = {"sides": "wall", "bottom": "wall"}
    packing = {"diameter_scatter": 3e-5, "tilt": list(tilt), "seed": 3}
    found = assemble(square([], packing, boundary=boundary, load={"kind": "impact", "velocity": 0.1}))
    built = build_packing(found)
    n_pairs = 5 * 5 + 4 * 6
    assert len(built.contacts) == found.n_contacts == n_pairs
    assert np.abs(built.gaps(built.contacts)).max() < 1e-16
    every = np.array([(i, j) for i in range(1, 31) for j in range(i + 1, 31)])
    assert built.gaps(every).min() > -1e-16  # nothing overlaps
    radii = found.sphere_diameters() / 2
    planes = {wall.name: wall for wall in built.walls}
    corner = [planes["xhi" if tilt[0] > 0 else "xlo"], planes["yhi" if tilt[1] > 0 else "ylo"], planes["bottom"]]
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
    two = assemble(square(EDGE, SCATTERED))
    np.testing.assert_allclose(gaps(two, 31, [11, 16]), 0.0, atol=1e-12)  # two spheres always hold one in their plane


def test_without_scatter_a_tilt_changes_nothing() -> None:
    tilted, plain = (assemble(square(EDGE, more)) for more in ({"tilt": [1, 1]}, {}))
    np.testing.assert_array_equal(tilted.positions(), plain.positions())


@pytest.mark.parametrize(
    ("strikers", "packing", "message"),
    [
        (
            [EDGE[0], EDGE[1] | {"offset": [0, 0.011, 0]}],
            {},
            r"striker 2: shifted by 0\.011 m across its way it misses",
        ),
        (
            [EDGE[0], EDGE[1] | {"misalignment": [0, -1e-3, 0]}],
            {},
            r"striker\.2\.misalignment: .* none of them negative",
        ),
        ([EDGE[0], EDGE[1] | {"offset": [1e-3, 0, 0]}], {}, r"striker\.2\.offset: .* along its way"),
        ([EDGE[0] | {"offset": [1e-3, 0, 0]}, EDGE[1]], {}, r"striker 1: its shift along its way has no effect"),
        (EDGE, {"tilt": [1, 0]}, r"packing\.tilt: found \[1, 0\], expected \[1, 1\]"),
        (
            EDGE,
            {"kind": "fcc", "size": [5, 6, 1], "tilt": [1, 1]},
            r"packing\.tilt: found with packing\.kind = \"fcc\"",
        ),
        (EDGE, {"tilt": [1, 1], "vacancies": 0.1}, r"packing\.vacancies: found beside packing\.tilt"),
    ],
)
def test_bad_input_is_one_clear_line(strikers: list[dict[str, Any]], packing: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message) as error:
        square(strikers, packing)
    assert len(error.value.errors) == 1, error.value.errors


def test_a_tilt_needs_a_corner_of_equal_or_smaller_spheres_without_a_static_stage() -> None:
    with pytest.raises(InputError, match=r"precompression: found beside packing\.tilt"):
        square(EDGE, {"tilt": [1, 1]}, precompression={"kind": "gravity"})
    with pytest.raises(InputError, match=r"replace\.1\.diameter: found 0\.011 .* packing\.tilt"):
        square(EDGE, {"tilt": [1, 1]}, replace=[{"index": 3, "diameter": 0.011}])
    with pytest.raises(InputError, match=r"boundary\.sides: found \"periodic\" beside packing\.tilt"):
        square(EDGE, {"tilt": [1, 1]}, boundary={"sides": "periodic"})
