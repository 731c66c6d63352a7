"""``granwave check``: size and mass of the packing, where the blow lands, zone, and values that will be missing."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest

from granwave.lammps_inputs.case.case import Case
from granwave.workflows import load_case, run_case
from granwave.workflows.cli.main import main

SMALL = {"packing.size": "[8,8,5]"}
CENTRE = {"load": "{kind='striker'}", "striker": "[{touches='centre',velocity=[0,0,5]}]"}
CORNER = {"load": "{kind='striker'}", "striker": "[{touches=1,velocity=[0,0,5]}]"}


def check(name: str, changes: dict[str, str], capsys: pytest.CaptureFixture[str]) -> tuple[dict[str, Any], str]:
    """Return the values of ``check --json``, and the table."""
    words = ["check", name, *(word for key, value in changes.items() for word in ("--set", f"{key}={value}"))]
    assert main([*words, "--json"]) == 0
    values = json.loads(capsys.readouterr().out)
    assert main(words) == 0
    return values, capsys.readouterr().out


def loaded(changes: dict[str, str]) -> Case:
    return load_case("fcc-small", [f"{key}={value}" for key, value in changes.items()])


@pytest.mark.parametrize("changes", [{}, {"replace": "[{index=[5],diameter=0.008,material='steel'}]"}])
def test_mass_and_height_are_those_of_the_run(changes, tmp_path, capsys) -> None:
    values, table = check("fcc-small", SMALL | changes, capsys)
    case = loaded(SMALL | changes | {"run.end_time": "1e-6", "run.frames": "2"})
    summary = run_case(case, tmp_path / "run", figures=False).summary
    for name in ("packing_mass_kg", "packing_height_m"):
        assert values[name] == pytest.approx(summary[name], rel=1e-9)
    rows = 0.01 * math.sqrt(3) / 2  # triangular layers, of which every second or third is shifted
    assert values["packing_width_m"][1] == pytest.approx(0.01 + 7 * rows + 2 / 3 * rows, rel=0.02)
    assert f"{values['packing_mass_kg']:.4g} kg, {values['packing_height_m']:.4g} m high" in table


def test_where_a_striker_lands(capsys) -> None:
    corner, table = check("fcc-small", SMALL | CORNER, capsys)
    assert corner["struck"]["sphere"] == 1 and corner["struck"]["where"] == "at a corner of the top"
    assert "sphere 1, at a corner of the top, 0.0" in table
    impact = check("fcc-small", SMALL, capsys)[0]["struck"]
    centre = check("fcc-small", SMALL | CENTRE, capsys)[0]["struck"]
    assert centre == impact and not centre["where"] and not centre["aside_m"]
    assert loaded(SMALL | CENTRE).striker[0].touches == (impact["sphere"],)


def test_what_will_be_null(tmp_path, capsys) -> None:
    plate = {"load": "{kind='plate',mass=0.1,velocity=1.0}", "boundary.bottom": "{plate={mass=1.0,stiffness=1e6}}"}
    values, table = check("fcc-small", SMALL | plate, capsys)
    assert 'load.kind = "plate"' in values["nulls"]["peak_reduction"] and "no peak reduction" in table
    case = loaded(SMALL | plate | {"run.end_time": "2e-5", "run.frames": "2"})
    assert run_case(case, tmp_path / "run", figures=False).summary["peak_reduction"] is None
    values, table = check("fcc-small", SMALL, capsys)
    assert values["nulls"] == {} and "no peak reduction" not in table


def test_no_zone_is_deeper_than_its_packing(capsys) -> None:
    values, table = check("fcc-small", SMALL, capsys)
    zone = values["zone"]
    assert zone["depth_m"] < values["packing_height_m"] < zone["depth_in_larger_packing_m"]
    assert zone["radius_m"] < zone["radius_in_larger_packing_m"]
    assert "to the bottom and the sides of the packing; in a larger one about" in table


def test_a_striker_along_z_has_a_continuum(capsys) -> None:
    impact, _ = check("fcc-small", SMALL, capsys)
    striker, _ = check("fcc-small", SMALL | CENTRE, capsys)
    assert striker["counterpart"]["command"] == impact["counterpart"]["command"]
    aside = CENTRE | {"striker": "[{touches='centre',velocity=[1,0,5]}]"}
    assert check("fcc-small", SMALL | aside, capsys)[0]["counterpart"]["command"] is None
