"""Clumps in tables and cases: numbers, contacts, the deck, and rejected input."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granwave.lammps_inputs import build_packing, plan
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.packing.grains import parse_grains
from granwave.lammps_inputs.deck.deck import write_deck
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble

TRIMER = """x,y,z,diameter,clump
0,0,0,0.010,4
0.006,0,0,0.010,4
0.003,0,0.005,0.008,4
0.003,0,-0.012,0.010,
0.020,0,0,0.010,9
"""


def clumps_of(text: str = TRIMER, **tables: Any) -> Case:
    packing = {"kind": "file", "grains": text} | tables.pop("packing", {})
    load = {"load": {"index": [4]}}
    return case_from_dict({"packing": packing, "material": "brass"} | load | tables, "case")


def fault_of(text: str = TRIMER, **tables: Any) -> str:
    with pytest.raises(InputError) as caught:
        clumps_of(text, **tables)
    return caught.value.errors[0].removeprefix("case: ")


def test_a_column_of_clumps_is_kept() -> None:
    grains = parse_grains(TRIMER, None)
    assert grains.clump.tolist() == [4, 4, 4, 0, 9]
    assert grains.clumps == {4: (1, 2, 3)}  # one grain alone is none
    case = clumps_of()
    assert case_from_dict(tomllib.loads(case.to_toml()), "case") == case
    assert case.has_rotation
    assert "clump" not in parse_grains("x,y,z,diameter\n0,0,0,0.01\n", None).text


def test_molecules_of_a_data_file_are_clumps_by_name(tmp_path: Path) -> None:
    rows = "".join(f"{n} {mol} 1 0.01 2000 {x} 0 0\n" for n, mol, x in ((1, 5, 0), (2, 5, 0.006)))
    text = f"SI units\n\n2 atoms\n1 atom types\n\nAtoms # bpm/sphere\n\n{rows}"
    (tmp_path / "clumps.data").write_text(text)
    packing = {"kind": "file", "file": str(tmp_path / "clumps.data"), "format": "lammps-data"}
    columns = ["id", "clump", "type", "diameter", "density", "x", "y", "z"]
    data = {"packing": packing | {"columns": columns}, "material": "brass"}
    with pytest.raises(InputError, match=r"load\.index: found \"impact\" on grain 1 of clump 5"):
        case_from_dict(data, "case")


def test_spheres_of_a_clump_have_no_contact() -> None:
    case = clumps_of()
    assembly = assemble(case)
    assert assembly.n_contacts == 0
    assert build_packing(case).contacts.shape == (0, 2)
    assert assembly.in_clumps.tolist() == [1, 2, 3]
    touching = TRIMER.replace("0.003,0,-0.012", "0,0,-0.010")
    assert assemble(clumps_of(touching)).contacts().tolist() == [[1, 4]]


def test_grains_that_are_apart_are_told_without_those_of_a_clump(caplog: Any) -> None:
    plan(clumps_of())
    assert "no two grains touch at the start, the closest are 0.00237 m apart" in caplog.text


def test_added_grains_number_the_clumps_of_their_copies() -> None:
    rods = {"at": [[0.02, 0, 0], [0.026, 0, 0]], "diameter": 0.01, "clump": 3}
    heads = {"at": [[0.023, 0, 0.006]], "diameter": 0.004, "clump": 3}
    copies = {"repeat": {"times": 2, "step": [0, 0, 0.02]}}
    case = case_from_dict(
        {
            "packing": {"kind": "chain", "size": 3, "diameter": 0.01},
            "material": "brass",
            "grains": [rods | copies, heads | copies],
            "load": {"index": [1]},
        },
        "case",
    )
    assert case.packing.grains.clumps == {3: (4, 5, 8), 4: (6, 7, 9)}


def test_a_deck_names_molecules_and_one_rigid_fix(tmp_path: Path) -> None:
    deck = write_deck(assemble(clumps_of()), tmp_path)
    script = deck.script.read_text()
    assert "fix             motion mobile gran/nve/sphere" in script
    assert "fix             motion_clumps clumps rigid/small molecule" in script
    assert "neigh_modify    exclude molecule/intra clumps" in script
    _, _, molecules = deck.data.read_text().partition("Molecules")
    numbers = np.loadtxt(molecules.splitlines()[1:], dtype=int)
    assert numbers.tolist() == [[1, 4], [2, 4], [3, 4], [4, 0], [5, 0]]


@pytest.mark.parametrize(
    ("changed", "fault"),
    [
        (("0.006,0,0,0.010,4", "0.006,0,0,0.010,-4"), "line 3: found -4 for clump, expected a num"),
        (
            ("0.006,0,0,0.010,4", "0.006,0,0,0.010,1.5"),
            "line 3: found 1.5 for clump, expected a wh",
        ),
        (("0.006,0,0,0.010,4", "0.006,0,0,0.010,rod"), 'line 3: found "rod" for clump'),
    ],
)
def test_wrong_numbers_name_their_line(changed: tuple[str, str], fault: str) -> None:
    assert f": {fault}" in fault_of(TRIMER.replace(*changed))


MOVING = TRIMER.replace("clump\n", "clump,vx\n").replace(",4\n", ",4,1\n")


@pytest.mark.parametrize(
    ("tables", "fault"),
    [
        ({"load": {"index": [2]}}, 'load.index: found "impact" on grain 2 of clump 4'),
        ({"hold": [{"index": [3]}]}, "hold.1: holds grain 3 of clump 4; name single grains"),
        ({"guide": [{"index": [1], "free": "z"}]}, "guide.1: holds grain 1 of clump 4"),
        ({"absorb": [{"index": [1], "rate": 1e4}]}, "absorb.1.index: absorbs waves of grain 1"),
        (
            {"precompression": {"kind": "gravity", "acceleration": 9.81}},
            'precompression.kind: found "gravity" with clumps, but the minimiser does not move',
        ),
        (
            {"boundary": {"bottom": "fixed"}},
            'boundary.bottom: found "fixed" with grain 3 of a clump in the last layer',
        ),
    ],
)
def test_features_of_single_grains_are_refused(tables: dict, fault: str) -> None:
    assert fault_of(**tables).startswith(fault)


def test_a_clump_wider_than_half_the_period_is_refused() -> None:
    rows = [f"{x},0,0,0.01,4" for x in (0.0, 0.012, 0.024)]
    text = "\n".join(["x,y,z,diameter,clump", *rows, "0,0,-0.02,0.01,0", ""])
    tables = {"boundary": {"sides": "periodic"}, "packing": {"period": [0.04, 0.04]}}
    fault = fault_of(text, **tables)
    assert "found clump 4, wider than half the period of 0.04 m along x" in fault
    assert clumps_of(text, **tables | {"packing": {"period": [0.06, 0.06]}}).packing.has_clumps


def test_a_clump_has_one_velocity() -> None:
    rows = MOVING.replace("0.006,0,0,0.010,4,1", "0.006,0,0,0.010,4,2")
    rows = rows.replace("0.010,\n", "0.010,,\n").replace("0.010,9\n", "0.010,9,0\n")
    rows = rows.replace("0.010,,\n", "0.010,0,0\n")
    fault = fault_of(rows, load={"kind": "grains"})
    assert "found grains 1 and 2 of clump 4 with different velocities" in fault


def test_clumps_are_of_spheres() -> None:
    rows = "x,y,z,diameter,shape,length,clump\n0,0,0,0.01,cylinder,0.02,1\n0.02,0,0,0.01,,,1\n"
    rows += "0,0,-0.02,0.01,,,\n"
    fault = fault_of(rows, load={"index": [3]})
    assert "found grain 1 of clump 1, a cylinder, expected clumps of spheres" in fault
