"""Rows of ``granwave check`` for a packing from a file."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from granwave.workflows.cli.main import main
from tests.lammps_inputs.readers import writers

CASE = """
material = "brass"
[packing]
kind = "file"
file = "grains.dump"
up = "z"
types = {1 = "brass", 2 = "steel"}
[load]
index = [3]
velocity = 1.0
[run]
end_time = 2e-5
"""


@pytest.fixture
def case(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A case of a dump with two types, whose first two grains overlap by 1e-5 m."""
    monkeypatch.chdir(tmp_path)
    text = writers.dump_step(100).replace("\n3 1 ", "\n3 2 ").replace(f"{1 / 7!r}", "0.0")
    writers.write(tmp_path / "grains.dump", text.replace(" 0.015 ", " 0.01499 "))
    extra = (
        '[precompression]\nkind = "overlaps"\n[boundary]\nbottom = "free"\n[[hold]]\nindex = [1]\n'
    )
    (tmp_path / "case.toml").write_text(CASE + extra)
    return "case.toml"


def test_the_table_says_what_was_read(case: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", case, "--set", "packing.velocities=drop"]) == 0
    rows = dict(
        line.split("  ", 1) for line in capsys.readouterr().out.splitlines() if "  " in line
    )
    rows = {label: text.strip() for label, text in rows.items()}
    assert rows["read"].startswith("3 grains of ")
    assert rows["read"].endswith("grains.dump (LAMMPS dump, step 100)")
    assert rows["diameters"] == "0.01 m to 0.015 m, 0.0116667 m in the mean"
    assert rows["materials"] == "2 brass, 1 steel"
    assert rows["types in the file"] == "2 of type 1, 1 of type 2"
    assert rows["box of the file"] == "0.04 x 0.04 x 0.1 m, periodic along x and y"
    assert rows["overlaps in the file"] == "1, the largest by 1e-05 m"
    assert "velocities" not in rows


def test_json_has_the_values(case: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", case, "--json", "--set", "load.index=[2]"]) == 0
    values = json.loads(capsys.readouterr().out)["packing_file"]
    assert values["format"] == "LAMMPS dump, step 100"
    assert values["materials"] == {"brass": 2, "steel": 1}
    assert values["largest_speed_m_s"] == 0.5
    assert values["largest_overlap_m"] == pytest.approx(1e-5)
    assert values["n_touching"] == 1
    assert values["last_place_m"] < 1e-15
    assert values["periodic"] == "xy"


def test_a_lattice_has_no_such_rows(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "two-spheres", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["packing_file"] is None
