"""A contact law that a case reads from another file."""

from __future__ import annotations

import pytest

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict, load_case

CASE = """
name = "pulled-in"
material = "brass"
[packing]
kind = "chain"
size = 3
diameter = 0.01
[contact]
law = "fits/fit.toml"
friction = 0.2
"""
FIT = """
name = "fitted"
[contact]
law = "elastoplastic"
pressure_limit = 2.3
friction = 0.1
[material]
youngs_modulus = 1e9
"""


@pytest.fixture
def case_file(tmp_path):
    (tmp_path / "fits").mkdir()
    (tmp_path / "fits" / "fit.toml").write_text(FIT)
    path = tmp_path / "case.toml"
    path.write_text(CASE)
    return path


def test_the_law_of_a_file_next_to_the_case(case_file, tmp_path, monkeypatch):
    """The file is read from any folder; keys of the case have precedence, and other tables of the
    file are ignored.
    """
    monkeypatch.chdir("/")
    case = load_case(case_file)
    assert (case.contact.law, case.contact.pressure_limit) == ("elastoplastic", 2.3)
    assert case.contact.friction == 0.2
    assert case.material.name == "brass"
    assert "fit.toml" not in case.to_toml()
    assert load_case(case_file, ["contact.law=hertz"]).contact.law == "hertz"
    monkeypatch.chdir(tmp_path / "fits")
    other = load_case("../case.toml", ["contact.law=fit.toml"])
    assert other.contact.pressure_limit == 2.3


def test_the_law_of_a_pair(case_file):
    pair = [{"materials": ["steel", "brass"], "law": str(case_file.parent / "fits" / "fit.toml")}]
    case = case_from_dict(
        {
            "name": "pair", "material": "brass", "pair": pair,
            "packing": {"kind": "chain", "size": 3, "diameter": 0.01},
            "replace": [{"index": 2, "material": "steel"}],
        }
    )  # fmt: skip
    assert case.pair[0].contact.pressure_limit == 2.3


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (None, r"contact\.law: .*fit\.toml: .*(no such|not found|cannot be read|there is no)"),
        ("[material]\n", r"contact\.law: .*fit\.toml: found no law in a table \[contact\]"),
        ('[contact]\nlaw = "other.toml"\n', r"contact\.law: .*another file; name that file"),
        ("[contact\n", r"contact\.law: .*fit\.toml.*not valid TOML"),
        ('[contact]\nlaw = "hooke"\n', r"contact\.law: found \"?hooke"),
    ],
)
def test_faults_name_key_and_file(case_file, text, fault):
    file = case_file.parent / "fits" / "fit.toml"
    if text is None:
        file.unlink()
    else:
        file.write_text(text)
    with pytest.raises(InputError, match=fault):
        load_case(case_file)
