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
    assert rows["diameters"] == "0.01 m to 0.015 m, 0.0116667 m on average"
    assert rows["materials"] == "2 brass, 1 steel"
    assert rows["types in the file"] == "2 of type 1, 1 of type 2"
    assert rows["box of the file"] == "0.04 × 0.04 × 0.1 m, periodic along x and y"
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


BED = """\
ITEM: TIMESTEP
1
ITEM: NUMBER OF ATOMS
3
ITEM: BOX BOUNDS ff ff ff
-0.001 0.029994
0 0.02
0 0.1
ITEM: ATOMS id x y z radius
1 0.0049 0.01 0.004999 0.005
2 0.015 0.01 0.004998 0.005
3 0.024996 0.01 0.004999 0.005
"""
BED_CASE = """
material = "glass"
contact = {law = "hertz", friction = 0.3}
packing = {kind = "file", file = "bed.dump", up = "z", contacts = "keep"}
precompression = {kind = "gravity"}
load = {index = [1], velocity = 1.0}
run = {end_time = 1e-5}
"""


@pytest.fixture
def bed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Return the name of a case of three spheres that press the floor and a side of their box."""
    monkeypatch.chdir(tmp_path)
    writers.write(tmp_path / "bed.dump", BED)
    (tmp_path / "bed.toml").write_text(BED_CASE)
    return "bed.toml"


@pytest.mark.parametrize(("settings", "warning"), [
    ([], "3 grains overlap with faces of the box of the file by up to 2e-06 m, as the file had "
         "walls there; the walls of the case touch the outermost grains, so these overlaps are "
         "lost; set packing.enclosure = {bottom = 0} for walls at the faces"),
    (["packing.enclosure={bottom=0.0}"], "packing.file: grains overlap with faces of the box of "
     'the file, which had walls there; the case has none; set boundary.x = "wall" to add them'),
    (["boundary.x=wall"], "4 grains overlap with faces of the box of the file by up to 2e-06 m, as "
     "the file had walls there; the walls of the case touch the outermost grains, so these "
     "overlaps are lost; set packing.enclosure = {x = [-0.001, 0.029994], bottom = 0}"),
    (["boundary.bottom=free"], 'the case has none; set boundary.x and boundary.bottom = "wall"'),
])  # fmt: skip
def test_walls_of_the_program_that_settled_the_bed(
    bed: str, settings: list[str], warning: str, caplog: pytest.LogCaptureFixture
) -> None:
    words = ["check", bed]
    for setting in settings:
        words += ["--set", setting]
    assert main(words) == 0
    assert warning in caplog.text


def test_walls_in_their_places_give_no_warning(bed: str, caplog: pytest.LogCaptureFixture) -> None:
    enclosure = "packing.enclosure={x=[-0.001,0.029994],bottom=0.0}"
    assert main(["check", bed, "--set", enclosure, "--set", "boundary.x=wall"]) == 0
    assert "faces of the box" not in caplog.text


def test_advice_on_a_bed_with_friction(bed: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", bed]) == 0
    rows = [line.strip() for line in capsys.readouterr().out.splitlines()]
    relax = '"relax" finds an equilibrium at any distance '
    relax += '(relaxation = "damped" keeps the '
    assert f"{relax}friction)" in rows
    keep = '"keep" starts from the file, out of equilibrium, '
    keep += "as the file lacks the tangential springs"
    assert f"{keep} (chosen)" in rows
    assert main(["check", bed, "--set", "packing.touch_tolerance=1e-7"]) == 0
    touch = '"touch" moves no grain, because no pair is within 1e-07 m '
    assert (
        f"{touch}(packing.touch_tolerance); 1 pair overlaps by more, which it rejects"
        in capsys.readouterr().out
    )


@pytest.mark.parametrize(
    ("rows", "keys", "remedy"),
    [
        ("x,y,z,diameter\n0,0,0,10\n0,0,10,10\n", "", "if the lengths of the file are in mm"),
        ("x,y,z\n0,0,0\n0,0,10\n", "diameter = 0.01\n", "if the positions of the file are in mm"),
        ("x,y,z\n0,0,0\n0,0,0.9\n", "diameter = 0.01\n", ""),
    ],
)
def test_a_file_in_millimetres_has_a_remedy(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, rows: str, keys: str, remedy: str
) -> None:
    """The warning names the key that sets the unit, and the key removes the warning."""
    table = tmp_path / "grains.csv"
    table.write_text(rows)
    case = tmp_path / "case.toml"
    packing = f'[packing]\nkind = "file"\nfile = "{table}"\n{keys}'
    case.write_text(
        f'material = "brass"\n{packing}[load]\nvelocity = 1.0\n[run]\nend_time = 2e-5\n'
    )
    assert main(["check", str(case)]) == 0
    (warning,) = [record.getMessage() for record in caplog.records]
    if not remedy:
        assert warning.endswith("check for rounded coordinates and mixed units")
        return
    assert warning.endswith(f'{remedy}, set packing.units = "mm"')
    assert main(["check", str(case), "--set", 'packing.units="mm"']) == 0
    assert len(caplog.records) == 1
