"""Static stages of chains from files: spheres with cylinders at their contacts, between walls."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import granwave as gw
from granwave.lammps_inputs.errors import RunError

D = 9.525e-3
ROD = 5.334e-3  # 0.56 of it, as in thesis 7
BESIDE = ((D / 2 + ROD / 2) ** 2 - (D / 2) ** 2) ** 0.5
ROWS = (40, 100)  # spheres of a row of some 120 grains, and of some 300
GUIDE = {"group": "row", "free": "z"}


def table(n: int) -> str:
    """Chain of n spheres with two cylinders at each contact, in numbers of six digits."""
    rows = [f"0,0,{k * D:.6g},{D:.6g},sphere,,steel,row" for k in range(n)]
    for k in range(n - 1):
        along = f"0,{(k + 0.5) * D:.6g},{ROD:.6g},cylinder,{D:.6g},aluminium,rods"
        rows += [f"{BESIDE:.6g},{along}", f"{-BESIDE:.6g},{along}"]
    return "x,y,z,diameter,shape,length,material,group\n" + "\n".join(rows) + "\n"


def row(n: int, **changes: Any) -> dict[str, Any]:
    packing = {"kind": "file", "grains": table(n), "contacts": "touch"}
    packing |= changes.pop("packing", {})
    return {
        "name": "row",
        "material": "steel",
        "contact": {"law": "hertz"},
        "packing": packing,
        "boundary": {"bottom": "wall", "x": "wall", "sides_touch": {"group": "rods"}},
        "load": {"index": [3], "velocity": 0.1},
        "run": {"end_time": 1e-6, "frames": 2},
    } | changes


WALLS = {"kind": "walls", "x": 3.81e-6}  # cylinders between spheres push these apart
FORCE = {"kind": "uniaxial", "force": 10.0}
LOADS: dict[str, dict[str, Any]] = {
    "walls": {"precompression": WALLS},
    "force": {"precompression": FORCE},
    "weight": {"precompression": {"kind": "gravity"}},
    "none": {},
}


@pytest.mark.parametrize("n", ROWS)
@pytest.mark.parametrize("load", LOADS)
def test_rows_reach_balance(tmp_path: Path, n: int, load: str) -> None:
    """FIRE by itself takes 3000 to 27 000 iterations for these chains, or the chain buckles;
    without a load, with the overlaps of the rounded file, it found no equilibrium after 400 000.
    """
    ends = {"hold": [{"index": [1, n]}]} if load in ("walls", "none") else {}
    case = row(n, packing={"contacts": "overlaps"}, **LOADS[load], **ends)
    run = gw.run(case, directory=tmp_path / "out", figures=False)
    prestage = (tmp_path / "out" / "dumps" / "prestage.txt").read_text().splitlines()
    names, values = (line.lstrip("#").split() for line in prestage)
    record = dict(zip(names, map(float, values), strict=True))
    assert record["iterations"] <= 20
    if load != "none":
        assert record["residual"] < 1e-8
    assert run.summary["energy_balance_error"] < 1e-5


def test_weight_on_the_bottom(tmp_path: Path) -> None:
    case = row(40, packing={"contacts": "overlaps"}, precompression={"kind": "gravity"})
    run = gw.run(case, directory=tmp_path / "out", figures=False)
    weight = 9.81 * float(run.spheres["mass"].sum())
    at_bottom = run.result["wall_contacts/initial_force"][()]
    assert float(np.max(at_bottom)) == pytest.approx(weight, rel=0.5)  # walls carry some of it


def test_advice_on_a_load_that_is_lost_works(tmp_path: Path) -> None:
    """The walls drive the cylinders between the spheres, and the upper end away."""
    overlaps = {"contacts": "overlaps"}
    with pytest.raises(RunError, match="pushed the grains apart; hold the outer grains") as caught:
        gw.run(row(20, packing=overlaps, precompression=WALLS), directory=tmp_path / "none")
    assert "press on the top with precompression.force" in str(caught.value)
    for name, changes in {
        "hold": {"hold": [{"index": [1, 20]}], "precompression": WALLS},
        "press": {"precompression": WALLS | {"force": 50.0}},
    }.items():
        run = gw.run(row(20, packing=overlaps, **changes), directory=tmp_path / name, figures=False)
        assert run.summary["energy_balance_error"] < 1e-5


ADVICE: dict[str, dict[str, Any]] = {
    "guide": {"guide": [GUIDE]},
    "hold": {"hold": [{"group": "row", "directions": "xy"}]},
    "relax": {"packing": {"contacts": "relax"}},
}


def test_advice_on_a_row_that_buckles_works(tmp_path: Path) -> None:
    """A sphere of an unguided chain starts next to the axis."""
    text = table(40).replace(f"0,0,{20 * D:.6g}", f"0,1e-05,{20 * D:.6g}")
    packing = {"grains": text, "touch_tolerance": 2e-6}
    case = row(40, packing=packing, precompression=FORCE)
    with pytest.raises(RunError, match="a sphere moved by") as caught:
        gw.run(case, directory=tmp_path / "none", figures=False)
    message = str(caught.value)
    assert all(word in message for word in ("[[guide]]", "[[hold]]", 'packing.contacts = "relax"'))
    for name, changes in ADVICE.items():
        others = {key: value for key, value in changes.items() if key != "packing"}
        pressed = packing | changes.get("packing", {})
        case = row(40, packing=pressed, precompression=FORCE, **others)
        run = gw.run(case, directory=tmp_path / name, figures=False)
        assert run.summary["energy_balance_error"] < 1e-5
