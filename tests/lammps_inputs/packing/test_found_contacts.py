"""Contacts of grains of a file: touch tolerance by its digits, and the ways to start them."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granwave.lammps_inputs import plan
from granwave.lammps_inputs.case.packing.contact_ways import CONTACT_WAYS
from granwave.lammps_inputs.case.packing.grains import Grains, parse_grains
from granwave.lammps_inputs.contact.contact_advice import advice_on
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.lattices import Lattice
from granwave.lammps_inputs.load_case import case_from_dict, stored_case
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.touching import (
    fit_touching,
    gaps_up_to,
    last_place,
    tolerance_of,
)
from granwave.workflows.cli.tables.plan_table import plan_table

D = 0.01
PAIR = "x,y,z,diameter\n0,0,0,0.01\n0,0,0.00999,0.01\n"


def rounded(lattice: Lattice, form: str) -> str:
    """Table of a lattice with numbers in this format."""
    rows = []
    for place in lattice.positions(1, lattice.n_spheres).tolist():
        rows.append(",".join(form % value for value in [*place, lattice.diameter]))
    return "x,y,z,diameter\n" + "\n".join(rows) + "\n"


def case_of(text: str, **packing: Any) -> dict[str, Any]:
    return {"packing": {"kind": "file", "grains": text} | packing, "material": "brass"}


@pytest.mark.parametrize(
    ("words", "unit"),
    [
        (["0.034641", "0.00500", "0.01"], 1e-6),
        (["0.0346410", "0.0288675", "0.00816497"], 1e-7),
        (["0.12345678", "0.00000001"], 1e-8),
        (["1.23456e-05", "2e-5"], 1e-10),
        (["0", "0.01", "0.0225"], 1e-4),
        (["0", "0"], 0.0),
    ],
)
def test_last_place_of_numbers(words: list[str], unit: float) -> None:
    values = np.array(words, dtype=float)
    assert last_place(values) == pytest.approx(unit, rel=1e-9)
    in_millimetres = np.array([1e3 * float(word) for word in words])
    assert last_place(in_millimetres / 1e3) == pytest.approx(unit, rel=1e-9)


@pytest.mark.parametrize("form", ["%.6g", "%.5g", "%.8f", "%.12e"])
@pytest.mark.parametrize("kind", ["hcp", "fcc"])
def test_rounded_crystals_become_exact_ones(kind: str, form: str) -> None:
    lattice = Lattice(kind, (6, 6, 5), D)
    grains = parse_grains(rounded(lattice, form), None)
    tolerance = tolerance_of(grains, D)
    fit = fit_touching(grains, tolerance)
    assert fit.n_contacts == lattice.n_contacts
    assert fit.remaining < 1e-13 * D
    assert fit.moved <= 2 * tolerance
    exact = lattice.positions(1, lattice.n_spheres)
    exact -= exact.mean(axis=0)
    moved = fit.position - fit.position.mean(axis=0)
    left, _, right = np.linalg.svd(moved.T @ exact)
    assert moved @ (left @ right) == pytest.approx(exact, abs=1e-12 * D)


def test_rounded_crystals_that_are_not_rigid_touch_near_their_places() -> None:
    lattice = Lattice("bcc", (6, 6, 5), D)
    grains = parse_grains(rounded(lattice, "%.6g"), None)
    fit = fit_touching(grains, tolerance_of(grains, D))
    assert (fit.n_contacts, fit.remaining < 1e-13 * D) == (lattice.n_contacts, True)
    assert fit.moved < 1e-6


def test_rounding_bounds_the_gaps_of_contacts() -> None:
    lattice = Lattice("hcp", (8, 8, 5), D)
    for form in ("%.6g", "%.7f", "%.4g"):
        grains = parse_grains(rounded(lattice, form), None)
        gaps = gaps_up_to(grains, 0.1 * D)
        assert len(gaps.within(tolerance_of(grains, D))) == lattice.n_contacts


def test_touching_cylinders_and_images() -> None:
    """Two cylinders along y next to a sphere, and a chain that touches its own image."""
    text = (
        "x,y,z,diameter,length\n0,0,0,0.01,0\n"
        "0.00800001,0.001,0,0.006,0.01\n-0.008,0,1e-8,0.006,0.01\n"
    )
    grains = parse_grains(text, None)
    fit = fit_touching(grains, 1e-7)
    assert (fit.n_contacts, fit.position[1, 1]) == (2, 0.001)
    assert fit.remaining < 1e-15
    row = parse_grains("x,y,z\n0,0,0\n0.01000001,0,0\n0.01999999,0,0\n", D)
    assert fit_touching(row, 1e-7, (0.03, 0.05)).n_contacts == 3
    assert fit_touching(row, 1e-7, (0.03, 0.05)).remaining < 1e-15


def test_digits_that_explain_overlaps_make_them_touch(caplog: pytest.LogCaptureFixture) -> None:
    lattice = Lattice("hcp", (6, 6, 4), D)
    text = rounded(lattice, "%.6g")
    case = case_from_dict(case_of(text), "mine")
    assert case.packing.contacts == "touch"
    assert assemble(case).n_contacts == lattice.n_contacts
    assert "which rounding of the numbers explains" in caplog.text
    caplog.clear()
    chosen = case_from_dict(case_of(text, contacts="touch"), "mine")
    assert (chosen, caplog.text) == (case, "")
    again = tomllib.loads(case.to_toml())
    assert stored_case(again, "mine") == case_from_dict(again, "mine") == case


def test_gaps_of_a_file_stay_where_nothing_is_chosen() -> None:
    text = "x,y,z,diameter\n0,0,0,0.01\n0,0,0.0100001,0.01\n"
    case = case_from_dict(case_of(text), "mine")
    assert (case.packing.contacts, assemble(case).n_contacts) == (None, 0)
    closed = case_from_dict(case_of(text, touch_tolerance=2e-7), "mine")
    assert (closed.packing.contacts, assemble(closed).n_contacts) == ("touch", 1)


def test_refusal_names_the_ways_and_what_they_would_do() -> None:
    with pytest.raises(InputError) as caught:
        case_from_dict(case_of(PAIR), "mine")
    (message,) = caught.value.errors
    assert "found grains 1 and 2, which overlap by 1e-05 m; move them apart, or choose" in message
    assert all(f'"{name}"' in message for name in CONTACT_WAYS)
    assert '"touch" moves grains by up to 5e-06 m until they touch. "overlaps" presses' in message
    assert "with up to" in message
    assert "column clump" not in message
    assert message.count(". ") == 1 and len(message.split()) <= 50


def test_deep_overlaps_hint_at_clumps_and_units() -> None:
    text = "x,y,z,diameter\n0,0,0,0.01\n0,0,0.006,0.01\n"
    with pytest.raises(InputError) as caught:
        case_from_dict(case_of(text), "mine")
    (message,) = caught.value.errors
    assert "An overlap of 40 % of a diameter is more than a contact" in message
    assert message.count(". ") == 1 and len(message.split()) < 60
    assert "number the spheres of one body in a column clump" in message


@pytest.mark.parametrize(
    ("packing", "fault"),
    [
        (
            {"touch_tolerance": 2e-3},
            "packing.touch_tolerance: found 0.002 m, expected at most 0.001 m",
        ),
        ({"contacts": "touch", "touch_tolerance": 1e-6}, "found grains 1 and 2, which overlap"),
        ({"contacts": "press"}, 'packing.contacts: found "press", expected one of'),
    ],
)
def test_faults_of_contacts(packing: dict[str, Any], fault: str) -> None:
    with pytest.raises(InputError) as caught:
        case_from_dict(case_of(PAIR, **packing), "mine")
    assert fault in caught.value.errors[0]


def test_contacts_that_no_places_have() -> None:
    """A fourth sphere amid three that touch each other is too large for the hole between them."""
    height = D * 3**0.5 / 2
    text = (
        f"x,y,z,diameter\n0,0,0,0.01\n0.01,0,0,0.01\n0.005,0,{height!r},0.01\n"
        f"0.005,0,{height / 3!r},0.0017\n"
    )
    with pytest.raises(InputError, match="which cannot all touch: the best positions leave gaps"):
        case_from_dict(case_of(text, contacts="touch", touch_tolerance=1.6e-4))


def test_lattices_have_no_contacts_to_choose() -> None:
    chain = {"kind": "chain", "size": 3, "diameter": D, "contacts": "touch"}
    with pytest.raises(InputError, match=r"packing\.contacts: belongs to packing\.kind = .file."):
        case_from_dict({"packing": chain, "material": "brass"})


@pytest.mark.parametrize("way", ["overlaps", "relax", "keep"])
def test_overlaps_that_press(way: str) -> None:
    tables = case_of(PAIR, contacts=way)
    case = case_from_dict(tables, "mine")
    assert case.precompression is not None
    assert case.precompression.takes_overlaps
    assert case.seeks_balance == (way != "keep")
    assert case.may_rearrange == (way == "relax")
    assert stored_case(tomllib.loads(case.to_toml()), "mine") == case
    under_weight = tables | {"precompression": {"kind": "gravity"}, "boundary": {"bottom": "wall"}}
    case = case_from_dict(under_weight, "mine")
    assert case.precompression is not None
    assert (case.precompression.kind, case.precompression.overlaps) == ("gravity", True)


def test_check_advises() -> None:
    case = case_from_dict(case_of(rounded(Lattice("hcp", (4, 4, 3), D), "%.6g"), contacts="keep"))
    table = plan_table(assemble(case), plan(case))
    assert "touching in the file" in table
    assert "last digit of the file: 1e-07 m" in table
    assert '"keep" starts from the file, out of equilibrium (chosen)' in table


def test_advice_counts_and_presses() -> None:
    case = case_from_dict(case_of(PAIR, contacts="keep"), "mine")
    grains = case.packing.grains
    assert isinstance(grains, Grains)
    advice = advice_on(case, grains)
    assert (advice.n_within, advice.n_overlapping, advice.n_beyond) == (1, 1, 0)
    law = case.contact_between(case.material, case.material).between(
        (case.material, case.material), (D / 2, D / 2)
    )
    assert advice.largest_force == pytest.approx(float(law.loading_force(1e-5)), rel=1e-9)


def test_file_of_few_digits(tmp_path: Path) -> None:
    (tmp_path / "row.csv").write_text(PAIR)
    tables = {"packing": {"kind": "file", "file": str(tmp_path / "row.csv")}, "material": "brass"}
    with pytest.raises(
        InputError, match=r"grains 1 .line 2. and 2 .line 3., which overlap by 1e-05"
    ):
        case_from_dict(tables)
