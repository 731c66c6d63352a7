"""Prescribed displacements: what they may begin with, and one definition of the error of the energy balance."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.workflows import run_case
from granwave.workflows.run.checks import Balance

PUSH = [[0, 0], [1e-6, 1e-5], [1e-3, 1e-5]]  # 10 m/s for 1 us, then held


def case_of(table: list[list[float]], **changes: Any) -> dict[str, Any]:
    return {
        "material": "brass",
        "packing": {"kind": "chain", "size": 5, "diameter": 0.01},
        "load": {"kind": "displacement", "shape": "table", "table": table},
        "run": {"end_time": 1e-5},
    } | changes


def test_a_displacement_that_stops_has_one_balance(tmp_path: Path) -> None:
    """The grain gives back 0.22 J when it stops, of which the packing keeps 4e-4 J: errors are of the latter."""
    outcome = run_case(case_from_dict(case_of(PUSH)), tmp_path / "run", figures=False)
    summary = outcome.summary
    assert summary["energy_input_J"] == pytest.approx(4.2e-4, rel=0.02)
    record = json.loads((tmp_path / "run/run.json").read_text())
    assert summary["energy_balance_error"] <= 1e-5 and outcome.state == "finished"
    assert [try_["energy_balance_error"] > 1e-5 for try_ in record["attempts"]] == [True] * len(record["attempts"])
    grain = 8500 * 3.141592653589793 / 6 * 0.01**3
    seen = Balance(tmp_path / "run/dumps/energy.txt", moved=grain).read()
    assert seen.error == pytest.approx(summary["energy_balance_error"], rel=1e-9)


@pytest.mark.parametrize("law", ["elastoplastic", "hertz"])
@pytest.mark.parametrize("table", [[[0, 1e-6], [1e-4, 1e-6]], [[1e-5, 1e-6], [1e-4, 2e-6]]])
def test_a_displacement_begins_at_zero(table: list[list[float]], law: str) -> None:
    with pytest.raises(InputError, match=r"load\.table: found 1e-06 m at first, expected 0: .* subtract 1e-06"):
        case_from_dict(case_of(table, contact={"law": law}))


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"hold": [{"index": [1]}]}, "hold.1: holds sphere 1 along z"),
        ({"guide": [{"free": "x"}]}, "guide.1: holds sphere 1 along z"),
        ({"load": {"index": [5]}, "boundary": {"bottom": "fixed"}}, "load.index: found 5, a sphere of the last layer"),
        ({"load": {"angle": 30.0}, "guide": [{"free": "z"}]}, "guide.1: holds sphere 1 along x"),
    ],
)
def test_a_struck_grain_is_not_held(changes: dict[str, Any], fault: str) -> None:
    with pytest.raises(InputError) as caught:
        case_from_dict(case_of(PUSH, **({"load": {}} | changes)))
    assert fault in str(caught.value)
