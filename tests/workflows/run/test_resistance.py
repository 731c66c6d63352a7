"""Runs with resistance to rolling and twisting: ledger, summary, timestep, pairs, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.deck.commands import pair_coefficients, wall_commands
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.planning.timestep import auto_timestep
from granwave.workflows import load_case, run_case

SPIN = {
    "packing.size": [6, 6, 4],
    "contact.friction": 0.2,
    "contact.rolling": {"coefficient": 0.05, "damping": 0.5},
    "contact.twisting": "marshall",
    "load.spin": [300.0, 0.0, 600.0],
    "run.end_time": 1e-4,
    "run.frames": 3,
}


def test_the_ledger_has_columns_of_rolling_and_twisting(tmp_path: Path) -> None:
    found = run_case(load_case("fcc-small", SPIN), tmp_path / "run", figures=False).summary
    assert found["energy_balance_error"] < 1e-5
    with Result(tmp_path / "run") as result:
        lost = {name: result[f"energy/{name}"] for name in ("friction", "rolling", "twisting")}
        whole = sum(values[-1] for values in lost.values())
        contacts, walls = result["contacts/friction_energy"].sum(), result["wall_contacts/friction_energy"].sum()
        assert contacts + walls == pytest.approx(whole, rel=1e-9)
        assert result["spheres/friction_energy"].sum() == pytest.approx(whole, rel=1e-9)
        assert result.yield_energy.sum() == pytest.approx(result.yield_ledger[-1], rel=1e-6)
        for name in ("rolling", "twisting"):
            assert np.all(np.diff(lost[name]) > -1e-9 * lost[name][-1]) and lost[name][-1] > 0
            assert np.all(result[f"energy/elastic_{name}"] >= 0)
            assert found[f"{name}_fraction"] == pytest.approx(lost[name][-1] / result.energy_input)
            assert found[f"energy_dissipated_{name}_J"] == lost[name][-1]


def words(**contact: object) -> tuple[str, str]:
    case = load_case("fcc-small", {f"contact.{name}": value for name, value in contact.items()})
    assembly = assemble(case)
    return "\n".join(pair_coefficients(assembly)), "\n".join(wall_commands(assembly))


def test_words_of_pair_style_and_walls() -> None:
    table = {"coefficient": 2e-5, "stiffness": 4.0, "damping": 1e-5}
    for text in words(friction=0.3, rolling=0.02, twisting=table):
        assert "friction 0.3 rolling sds mindlin 0 0.02 twisting sds 4 1e-05 2e-05" in text
    for text in words(friction=0.3, rolling=0.0, twisting="marshall"):
        assert "rolling" not in text and "twisting marshall" in text
    for text in words(friction=0.3):
        assert "rolling" not in text and "twisting" not in text


def test_a_case_file_keeps_them() -> None:
    case = load_case("fcc-small", SPIN)
    table = case.to_dict()["contact"]
    assert table["rolling"] == {"coefficient": 0.05, "damping": 0.5}
    assert table["twisting"] == "marshall"


def test_a_given_stiffness_or_damping_shortens_the_timestep() -> None:
    usual = auto_timestep(load_case("fcc-small", {"contact.friction": 0.3, "contact.rolling": 0.1}))
    assert usual == auto_timestep(load_case("fcc-small", {"contact.friction": 0.3}))
    for name, value in (("stiffness", 1e12), ("damping", 1e6)):
        case = load_case("fcc-small", {"contact.rolling": {"coefficient": 0.1, name: value}})
        assert auto_timestep(case) < 0.5 * usual


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("rolling", -0.1, "coefficient from 0 to 10"),
        ("rolling", "marshall", "a coefficient, or {coefficient"),
        ("rolling", {"stiffness": 1e6}, "the coefficient is missing"),
        ("rolling", {"coefficient": 0.1, "stiffness": 0.0}, "a stiffness above 0"),
        ("rolling", {"coefficient": 0.1, "viscosity": 1.0}, "viscosity is unknown"),
        ("twisting", "hertz", 'or "marshall"'),
        ("twisting", "marshall", "expected friction above 0, by which it resists"),
    ],
)
def test_refused(key: str, value: object, message: str) -> None:
    with pytest.raises(InputError, match=f"contact.{key}") as error:
        load_case("fcc-small", {f"contact.{key}": value})
    assert message in str(error.value) and len(str(error.value).splitlines()) == 1
