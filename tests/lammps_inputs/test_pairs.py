"""Friction, spins and contact laws for pairs of materials: in the deck, in the law command, in runs."""

from __future__ import annotations

import math
import re
import tomllib
from argparse import Namespace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granwave.analysis.figures.style import write_csv
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.material import material
from granwave.lammps_inputs.contact.law import contact_of, flat_contact, pair_contact, sphere_contact
from granwave.lammps_inputs.deck.deck import write_deck
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict, load_case
from granwave.workflows.cli.contacts import fit
from granwave.workflows.run.checks import TOLERANCE
from granwave.workflows.run.driver import run_case
from tests.helpers.twin import OTHER

R = 0.005


def make(kind: str = "chain", size: Any = 4, **sections: Any) -> Case:
    packing = {"kind": kind, "size": size, "diameter": 2 * R}
    return case_from_dict({"name": "pairs", "packing": packing, "material": "brass", **sections})


def script(case: Case, directory: Path) -> str:
    return write_deck(case, directory).script.read_text()


def coefficients(text: str) -> dict[str, str]:
    """Argument of the keyword friction, or the whole law, by types or by the name of a wall."""
    found = dict(re.findall(r"^pair_coeff +(\d \d) (.*)$", text, re.M))
    return found | dict(re.findall(r"^fix +(\w+) \w+ wall/gran/hysteretic (.*)$", text, re.M))


THREE_LAWS: dict[str, Any] = {
    "replace": [{"index": 2, "material": "steel"}],
    "pair": [
        {"materials": ["brass", "steel"], **OTHER},
        {"materials": ["brass", "rigid"], "law": "bilinear", "beta": 0.5},
        {"materials": ["steel", "steel"], "law": "hertz"},
    ],
}


class TestFrictionInDecks:
    def test_without_it_nothing_is_there(self, tmp_path: Path) -> None:
        text = script(make("fcc", [5, 5, 3], boundary={"sides": "wall"}), tmp_path)
        for word in (
            " friction ",
            "nve/sphere",
            "vel yes",
            "omega",
            "rotational",
            "elastic_tangential",
            "c_contact[6]",
        ):
            assert word not in text

    def test_of_contacts_is_that_of_walls_too(self, tmp_path: Path) -> None:
        text = script(make("fcc", [5, 5, 3], contact={"friction": 0.3}), tmp_path)
        assert all(law.endswith("friction 0.3") for law in coefficients(text).values())
        assert re.search(r"^fix +motion all nve/sphere$", text, re.M)
        assert re.search(r"^comm_modify +vel yes$", text, re.M)
        assert re.search(r"^variable +elastic equal c_contact\+f_bottom\[4\]\+v_elastic_tangential$", text, re.M)
        assert re.search(r"^variable +friction equal c_contact\[7\]\+f_bottom\[9\]$", text, re.M)

    def test_walls_of_their_own(self, tmp_path: Path) -> None:
        boundary = {"sides": "wall", "friction": 0.1}
        found = coefficients(script(make("fcc", [5, 5, 3], contact={"friction": 0.3}, boundary=boundary), tmp_path))
        assert found["1 1"].endswith("friction 0.3")
        assert all(found[name].endswith("friction 0.1") for name in ("bottom", "xlo", "yhi"))

    def test_pairs(self, tmp_path: Path) -> None:
        pairs = [
            {"materials": ["steel", "brass"], "friction": 0.5},
            {"materials": ["brass", "rigid"], "friction": 0.2},
            {"materials": ["steel", "steel"], "law": "hertz"},
        ]
        case = make("fcc", [5, 5, 3], replace=[{"index": [1, 2], "material": "steel"}], pair=pairs)
        found = coefficients(script(case, tmp_path))
        assert found["1 2"].endswith("friction 0.5") and found["bottom"].endswith("friction 0.2")
        assert found["2 2"] == "hertz 2.1e+11 0.3"
        assert "friction" not in found["1 1"] and "friction" not in found["bottom_2"]
        assert case_from_dict(case.to_dict()) == case

    def test_faces_of_bars_have_none_and_nodes_do_not_turn(self, tmp_path: Path) -> None:
        bar = {"length": 0.1, "area": 1e-4, "elements": 5, "material": "steel"}
        text = script(make(contact={"friction": 0.3}, bar=bar), tmp_path)
        found = coefficients(text)
        assert found["1 1"].endswith("friction 0.3") and "friction" not in found["1 3"]
        assert re.search(r"^fix +motion mobile nve/sphere\nfix +motion_bar bar nve$", text, re.M)

    def test_angle_and_spin(self, tmp_path: Path) -> None:
        load = {"velocity": 2.0, "angle": 30.0, "spin": [0, 40.0, 0]}
        case = make("fcc", [5, 5, 3], load=load)
        text = script(case, tmp_path)
        velocity = re.search(r"^velocity +hit set (\S+) 0.0 (\S+) units box$", text, re.M)
        assert velocity is not None
        assert [float(part) for part in velocity.groups()] == pytest.approx([1.0, math.sqrt(3)])
        assert re.search(r"^set +group hit omega 0.0 40 0.0$", text, re.M)
        assert "nve/sphere" in text and "friction" not in text


class TestRuns:
    @pytest.mark.parametrize("friction", [0.0, 0.2])
    def test_balance_with_angle_and_spin(self, tmp_path: Path, friction: float) -> None:
        load = {"velocity": 3.0, "angle": 40.0, "spin": [0.0, 200.0, 50.0]}
        case = make("fcc", [5, 5, 3], load=load, contact={"friction": friction}, run={"end_time": 1e-4})
        outcome = run_case(case, tmp_path / "r", figures=False)
        mass = case.sphere_mass
        given = 0.5 * mass * 9.0 + 0.2 * mass * R**2 * (200.0**2 + 50.0**2)
        assert outcome.summary["energy_input_J"] == pytest.approx(given, rel=1e-12)
        assert outcome.summary["energy_balance_error"] < TOLERANCE
        lines = (tmp_path / "r" / "dumps" / "energy.txt").read_text().splitlines()
        last = dict(zip(lines[1].lstrip("#").split(), map(float, lines[-1].split()), strict=True))
        assert (last.get("friction", 0.0) > 1e-6) == (friction > 0)
        assert last["rotational"] > 0

    def test_a_spinning_striker(self, tmp_path: Path) -> None:
        striker = [{"touches": 1, "spin": [0.0, 300.0, 0.0], "velocity": [0.0, 0.0, 1.0]}]
        case = make(striker=striker, contact={"friction": 0.3}, run={"end_time": 5e-5})
        outcome = run_case(case, tmp_path / "r", figures=False)
        assert outcome.state == "finished" and outcome.summary["energy_balance_error"] < TOLERANCE


class TestLaws:
    def test_every_law_asked_for_is_that_of_the_pair(self) -> None:
        case = make(**THREE_LAWS)
        assert pair_contact(case, 1, 2).constants == pytest.approx(
            contact_of([material("brass")], [R], constants=OTHER).constants
        )
        assert pair_contact(case, 2, 2).name == "hertz"
        assert flat_contact(case, 1).name == "bilinear" and flat_contact(case, 2).name == "elastoplastic"
        assert sphere_contact(case).constants != pair_contact(case, 1, 2).constants

    def test_the_run_has_it(self, tmp_path: Path) -> None:
        """Peak force and dent of the contact between the two materials are on the pair's loading curve."""
        import h5py

        case = make(**THREE_LAWS, run={"end_time": 5e-5})
        assert run_case(case, tmp_path / "r", figures=False).summary["energy_balance_error"] < TOLERANCE
        with h5py.File(tmp_path / "r" / "result.h5") as file:
            peak, force, alone = (
                file[f"contacts/{name}"][0] for name in ("peak_overlap", "peak_force", "yield_overlap")
            )
        law = pair_contact(case, 1, 2)
        assert alone == pytest.approx(law.yield_overlap)
        assert peak > 5 * alone
        assert force == pytest.approx(float(law.loading_force(np.array([peak]))[0]), rel=1e-6)

    @pytest.mark.parametrize(
        ("sections", "message"),
        [
            ({"pair": [{"materials": ["brass", "stel"], "friction": 0.1}]},
             r'pair.1.materials: found "stel", expected materials of the case: "brass", "rigid"'),
            ({"pair": [{"materials": ["brass", "brass"], "friction": -0.1}]}, "pair.1.friction: found -0.1, expected .* at least 0"),
            ({"pair": [{"materials": ["brass", "brass"], "pressure_limit": 0.1}]}, "pair.1.pressure_limit: no passive law"),
            ({"contact": {"friction": -1}}, "contact.friction: found -1, expected a number at least 0"),
            ({"boundary": {"friction": -1}}, "boundary.friction: found -1"),
        ],
    )  # fmt: skip
    def test_refused(self, sections: dict, message: str) -> None:
        with pytest.raises(InputError, match=message) as refused:
            make(**sections)
        assert len(refused.value.errors) == 1

    def test_only_who_yields_needs_a_strength(self) -> None:
        soft = {"name": "soft", "youngs_modulus": 1e9, "poisson_ratio": 0.4, "density": 1e3}
        sections = {"replace": [{"index": 2, "material": soft}]}
        with pytest.raises(InputError, match=r"replace.1.material.yield_strength: missing"):
            make(**sections)
        make(**sections, pair=[{"materials": ["soft", "soft"], "law": "hertz"}])


def test_a_fitted_curve_becomes_a_pair(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Law of a pair from a computed curve: constants by `granwave fit`, and the table in a case."""
    materials = [material("steel"), material("brass")]
    law = contact_of(materials, [R, R], constants=OTHER)
    cycles = [np.linspace(0, 60, 80), *(np.linspace(*ends, 60)[1:] for ends in ((60, 30), (30, 150), (150, 120)))]
    cycles += [np.linspace(*ends, 80)[1:] for ends in ((120, 300), (300, 270))]
    overlap = np.concatenate(cycles) * law.yield_overlap
    force = law.force(overlap, np.maximum.accumulate(overlap))
    write_csv({"overlap_m": overlap, "force_N": force}, tmp_path / "curve.csv")
    asked = Namespace(
        curve=tmp_path / "curve.csv", directory=tmp_path / "fit", material=["steel", "brass"], radius=[R], free=None,
        fit_yield=False, force=False, pair=["steel", "brass"],
    )  # fmt: skip
    assert fit(asked) == 0
    table = (tmp_path / "fit" / "pair.toml").read_text()
    assert table.strip() in capsys.readouterr().out
    assert tomllib.loads(table)["pair"][0]["materials"] == ["steel", "brass"]
    text = (
        'material = "brass"\n[packing]\nkind = "chain"\nsize = 3\ndiameter = 0.01\n'
        '[[replace]]\nindex = 2\nmaterial = "steel"\n' + table
    )
    (tmp_path / "case.toml").write_text(text)
    case = load_case(tmp_path / "case.toml")
    assert pair_contact(case, 1, 2).constants == pytest.approx(OTHER, rel=1e-3)
    assert pair_contact(case, 1, 2).loading_force(overlap[60]) == pytest.approx(force[60], rel=1e-6)
    assert sphere_contact(case).constants == contact_of([material("brass")], [R]).constants
