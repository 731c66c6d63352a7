"""``granwave infer``: tables, time series, runs, and the messages for invalid input."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import granwave as gw
from granwave.extensions.inference.forces.tables import QUANTITIES
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.workflows import load_case, run_case
from granwave.workflows.cli.main import main
from granwave.workflows.library import find_for
from tests.helpers.keywords import check_keywords

RADIUS = 0.005
LENGTH = 0.02
DENSITY = 1200.0
MODULUS = 50e6
RATIO = 0.4
MASS = DENSITY * np.pi * RADIUS**2 * LENGTH
CASE = f"""
[material]
density = {DENSITY}
poisson_ratio = {RATIO}
youngs_modulus = {MODULUS}
[infer]
friction = 0.2
thickness = {LENGTH}
walls = {{left = 0.0, right = {6 * RADIUS}}}
"""
HEADER = "id,x_m,y_m,radius_m,ax_m_s2,ay_m_s2,exx,eyy,exy"


def column(acceleration: float) -> list[str]:
    """Chains of three discs that are pushed from the left, with the strains of plane stress."""
    forces = MASS * acceleration * np.array([3, 2, 1, 0])
    stress = -(forces[:3] + forces[1:]) * RADIUS / (np.pi * RADIUS**2 * LENGTH)
    strain = (np.stack([stress, -RATIO * stress], axis=1) / MODULUS).tolist()
    return [f"{k + 1},{RADIUS * (2 * k + 1)!r},0,{RADIUS},{acceleration},0,{strain[k][0]!r},{strain[k][1]!r},0"
            for k in range(3)]  # fmt: skip


@pytest.fixture
def infer(tmp_path, monkeypatch, capsys):
    """Run the command on a table and a case; return status, output and errors."""
    monkeypatch.chdir(tmp_path)

    def run(rows: list[str] | None, *more: str, case: str = CASE, header: str = HEADER):
        (tmp_path / "case.toml").write_text(case)
        if rows is not None:
            (tmp_path / "grains.csv").write_text("\n".join([header, *rows]) + "\n")
        status = main(["infer", "grains.csv", "--case", "case.toml", "--no-figures", *more])
        said = capsys.readouterr()
        return status, said.out, said.err

    return run


def rows_of(name: str) -> list[dict[str, str]]:
    with Path("infer", name).open(newline="") as file:
        return list(csv.DictReader(file))


def test_a_table_gives_forces_and_a_summary(infer):
    status, out, err = infer(column(500.0), "--json")
    assert (status, err) == (0, "")
    forces = {(row["i"], row["j"]): float(row["normal_force_N"]) for row in rows_of("forces.csv")}
    unit = MASS * 500.0
    assert forces == pytest.approx({("1", "2"): 2 * unit, ("2", "3"): unit, ("1", "left"): 3 * unit,
                                    ("3", "right"): 0}, rel=1e-9, abs=1e-9 * unit)  # fmt: skip
    assert list(rows_of("forces.csv")[0])[:6] == [
        "i",
        "j",
        "nx",
        "ny",
        "normal_force_N",
        "tangential_force_N",
    ]
    summary = json.loads(out)
    assert summary == json.loads(Path("infer/summary.json").read_text())
    assert set(summary) <= set(QUANTITIES)
    assert summary["n_loaded_contacts"] == 3
    assert len(rows_of("grains.csv")) == 3
    assert infer(column(500.0))[0] == 2  # not replaced
    assert infer(column(500.0), "--force")[0] == 0


def test_noise_gives_errors_and_figures(infer, tmp_path):
    noisy = CASE + "noise = {strain = 1e-5, acceleration = 5.0}\nmodulus = 'find'\n"
    status, out, _ = infer(column(500.0), "--repeat", "5", case=noisy)
    assert status == 0
    assert "Young's modulus" in out
    assert float(rows_of("forces.csv")[0]["normal_error_N"]) > 0
    summary = json.loads(Path("infer/summary.json").read_text())
    assert summary["youngs_modulus_Pa"] == pytest.approx(MODULUS, rel=1e-3)
    assert main(["infer", "grains.csv", "--case", "case.toml", "--force", "--repeat", "3"]) == 0
    there = {path.name for path in Path("infer/figures").iterdir()}
    assert {
        f"{name}.png" for name in ("force_network", "residuals", "force_errors", "modulus")
    } <= there


def test_a_series_is_differentiated(infer):
    """Discs that start from rest: positions a t^2/2, whose differences are exact."""
    acceleration = 500.0
    rate = 8000.0
    still = [row.split(",") for row in column(acceleration)]
    rows = []
    for frame in range(5):
        moved = (
            0.5e-3 * acceleration * (frame / rate) ** 2
        )  # of a thousandth, so that the walls stay where they are
        rows += [
            ",".join([str(frame), row[0], repr(float(row[1]) + moved), *row[2:4], *row[6:]])
            for row in still
        ]
    header = "frame,id,x_m,y_m,radius_m,exx,eyy,exy"
    case = CASE + f"frame_rate = {rate}\ncontact_tolerance = 0.01\n"
    assert infer(rows, case=case, header=header)[0] == 0
    forces = rows_of("forces.csv")
    assert sorted({float(row["time_s"]) for row in forces}) == pytest.approx(
        [1 / rate, 2 / rate, 3 / rate]
    )
    summary = json.loads(Path("infer/summary.json").read_text())
    assert summary["n_instants"] == 3
    assert infer(rows, "--force", case=case + "time = 2.4e-4\n", header=header)[0] == 0
    assert json.loads(Path("infer/summary.json").read_text())["time_s"] == pytest.approx(2 / rate)
    gone = [row for row in rows if not row.startswith("3,")]
    status, _, err = infer(gone, "--force", case=case, header=header)
    assert status == 2 and "at a constant interval" in err


GOOD = column(500.0)
STRETCHED = "{},1e-3,0,0"
WITHOUT = CASE.replace(f"youngs_modulus = {MODULUS}\n", "")
STATIC = "id,x_m,y_m,radius_m,exx,eyy,exy"
BAD = {
    "strain": ([GOOD[0], GOOD[1].replace(",0", ",0", 1).rsplit(",", 3)[0] + ",1.5,0,0"], {}, "line 3: exx: found 1.5"),
    "nan": ([GOOD[0], GOOD[1].rsplit(",", 1)[0] + ",nan"], {}, 'line 3: exy: found "nan"'),
    "word": (["a" + GOOD[0]], {}, 'line 2: id: found "a1"'),
    "twice": ([*GOOD, GOOD[2].replace(f"{5 * RADIUS!r}", "1.0")], {}, "line 5: id: found 3 again"),
    "inside": ([*GOOD, "4" + GOOD[2][1:]], {}, "line 5: lies in the grain of line 4"),
    "radius": ([GOOD[0].replace(f",{RADIUS},500", f",-{RADIUS},500")], {}, "line 2: radius_m: found -0.005"),
    "short": ([GOOD[0].rsplit(",", 1)[0]], {}, "line 2: found 8 values, expected 9"),
    "partly": ([GOOD[0].rsplit(",", 1)[0] + ","], {}, "line 2: found some of exx, eyy, exy empty"),
    "lonely": ([*GOOD, "9,0.015,1.0,0.005,0,0,0,0,0"], {}, "grain 9: has no contact"),
    "behind": ([*GOOD, "9,0.1,1.0,0.005,0,0,0,0,0"], {}, "grain 9: lies behind the wall right"),
    "passing": ([f"{row},2" for row in GOOD], {"header": f"{HEADER},passes_walls"}, "passes_walls: found 2, expected 0"),
    "columns": (GOOD, {"header": HEADER.replace("radius_m", "size")}, "lacks radius_m"),
    "no strain": (["1,0,0,0.005,0,0"], {"header": "id,x_m,y_m,radius_m,ax_m_s2,ay_m_s2"}, "lacks strains or stresses"),
    "half": (["1,0,0,0.005,0"], {"header": "id,x_m,y_m,radius_m,exx"}, "found exx, expected all of exx, eyy, exy"),
    "repeated": (GOOD, {"header": HEADER.replace("ay_m_s2", "ax_m_s2")}, "found the column ax_m_s2 2 times"),
    "empty": ([], {}, "found no grain"),
    "no modulus": (["1,0.005,0,0.005,-1e-3,0,0"], {"header": STATIC, "case": WITHOUT},
                   "since it cannot be determined without accelerations"),
    "modulus": (GOOD, {"case": WITHOUT}, 'infer.modulus = "find"'),
    "nothing to find": (["1,0.005,0,0.005,-1e-3,0,0"], {"header": STATIC, "case": WITHOUT + 'modulus = "find"\n'},
                        "the data do not determine it"),
    "rank": ([GOOD[0].rsplit(",", 5)[0] + ",,,,,"], {}, "0 equations of rank 0 for 2 components"),
    "case": (GOOD, {"case": CASE.replace("friction = 0.2", "frictoin = 0.2")}, "did you mean friction?"),
    "walls": (
        GOOD, {"case": CASE.replace("left = 0.0", "left = 1.0")}, "expected a value below right",
    ),
    "weights": (GOOD, {"case": CASE + 'weights = "white"\n'}, "infer.noise"),
    "thick": (GOOD, {"case": CASE.replace("0.02", "-0.02")}, "infer.thickness"),
    "noise": (GOOD, {"case": f"{CASE}noise = {{strain = 1e-300}}"}, "strain from 1e-1"),
    "loud": (GOOD, {"case": f"{CASE}noise = {{acceleration = 1e300}}"}, "acceleration from 1e-1"),
    "id": (GOOD, {"case": CASE.replace("left = 0.0", '"2" = {point = [0.0, 0.0], normal = [1.0, 0.0]}')},
           "the first a letter"),
    "stretched": ([STRETCHED.format(row.rsplit(",", 3)[0]) for row in GOOD], {}, "strains that "
        "are tensile in each of the 3"),
    "frames": (["0," + GOOD[0], "1," + GOOD[0]], {"header": "frame," + HEADER}, "infer.frame_rate: missing"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_answered_in_a_line(infer, name):
    rows, more, expected = BAD[name]
    status, out, err = infer(rows, **more)
    assert (status, out) == (2, "")
    assert expected in err
    assert all(line.startswith("granwave: ") for line in err.splitlines())
    assert not Path("infer").exists()


def test_files_that_cannot_be_read(infer, tmp_path):
    assert "no such file" in infer(None)[2]
    (tmp_path / "grains.csv").write_bytes(b"\xff\xfe\x00")
    assert "UTF-8" in infer(None)[2]
    (tmp_path / "grains.csv").write_text("")
    assert "found nothing" in infer(None)[2]
    assert "requires the directory of a run" in infer(column(1.0), "--noise", "0.1")[2]


SQUARE = {
    "packing.kind": "sc", "packing.size": [3, 3, 2], "contact.law": "hertz", "contact.friction": 0.3,
    "load.spin": [2000.0, 1000.0, 0.0], "boundary.sides": "wall", "run.end_time": 1e-4, "run.frames": 31,
    "output.contact_forces": True,
}  # fmt: skip


@pytest.fixture(scope="module")
def run_of_spheres(tmp_path_factory):
    directory = tmp_path_factory.mktemp("run") / "cubic"
    run_case(load_case("fcc-small", SQUARE), directory, figures=False)
    return directory


def test_a_run_is_measured_exactly(run_of_spheres, tmp_path, monkeypatch, capsys):
    """Forces of LAMMPS, including tangential and wall forces, are recovered from motion and mean
    stress.
    """
    monkeypatch.chdir(tmp_path)
    assert main(["infer", str(run_of_spheres), "--json", "--no-figures"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert set(summary) == set(QUANTITIES)
    assert summary["true_force_error"] < 1e-11
    rows = rows_of("forces.csv")
    assert (
        max(float(row["true_tangential_force_N"]) for row in rows)
        > 1e-3 * summary["largest_force_N"]
    )
    # the measurement and its case are read as those of an experiment, and nothing is lost on the
    # way
    again = gw.infer("infer/measurement.csv", "infer/measurement.toml")
    true = np.array([float(row["true_normal_force_N"]) for row in rows])
    assert np.abs(again.forces["normal_force_N"] - true).max() < 1e-12 * summary["largest_force_N"]
    made = gw.infer(gw.load(run_of_spheres), noise=0.05, repeat=2, directory="made")
    assert made.measurement is not None and 0 < made["true_force_error"] < 0.5
    assert Path("made/measurement.toml").exists()


def test_cylinders_of_a_file_and_grains_that_touch_nothing(tmp_path, monkeypatch, capsys):
    """Two cylinders collide next to a third; the measurement is in the plane and excludes the third
    cylinder.
    """
    monkeypatch.chdir(tmp_path)
    Path("grains.csv").write_text(
        "x,y,z,diameter,shape,length,axis,vz\n0,0,0,0.01,cylinder,0.02,y,2\n0,0,0.01,0.01,cylinder,0.02,y,0\n"
        "0.03,0,0,0.01,cylinder,0.02,y,0\n"
    )
    run = gw.run({
        "name": "three", "packing": {"kind": "file", "file": "grains.csv", "diameter": 0.01},
        "material": {"name": "soft", "youngs_modulus": 70e6, "poisson_ratio": 0.45, "density": 1100},
        "contact": {"law": "line", "loss": {"time": 1e-5}}, "load": {"kind": "grains"},
        "boundary": {"bottom": "free"}, "run": {"end_time": 1e-4, "frames": 5}, "output": {"contact_forces": True},
    }, progress=False)  # fmt: skip
    found = gw.infer(run)
    assert found["n_grains"] == 2 and found["state"] == "plane-stress"
    assert found["notes"] == ["1 of 3 grains have no contact and are excluded"]
    assert found["true_force_error"] < 1e-11
    measured = found.measurement
    force = found.forces["normal_force_N"].iloc[0]
    assert 0.005**2 * np.pi * 0.02 * 1100 * np.abs(measured["ay_m_s2"].to_numpy()) == pytest.approx(
        np.full(2, force)
    )


def test_a_striker_from_outside_passes_the_wall(tmp_path, monkeypatch, capsys):
    """A sphere that comes through a side wall: forces are exact, also from the table written from
    the run.
    """
    monkeypatch.chdir(tmp_path)
    packing = {"kind": "sc", "size": [3, 3, 1], "diameter": 0.01}
    tables = {
        "name": "through", "material": "steel", "packing": packing, "contact": {"law": "hertz"},
        "boundary": {"sides": {"material": "steel"}}, "striker": [{"touches": 4, "velocity": [2, 0, 0]}],
        "run": {"end_time": 3e-5, "frames": 4}, "output": {"contact_forces": True},
    }  # fmt: skip
    run_case(case_from_dict(tables, "through"), Path("through"), figures=False)
    assert main(["infer", "through", "--no-figures", "--json"]) == 0
    first = json.loads(capsys.readouterr().out)
    assert first["n_loaded_contacts"] > 0 and first["true_force_error"] < 1e-9
    assert [row["passes_walls"] for row in rows_of("measurement.csv")].count("1.0") == 1
    words = [
        "infer",
        "infer/measurement.csv",
        "--case",
        "infer/measurement.toml",
        "-o",
        "again",
        "--no-figures",
    ]
    assert main([*words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["largest_force_N"] == pytest.approx(
        first["largest_force_N"], rel=1e-9
    )


def test_python_says_what_is_wrong(tmp_path):
    for arguments, keys, said in [
        (("none.csv", "none.toml"), {}, "none.csv: no such file"),
        ((3,), {}, "measurement: found 3"),
        ((tmp_path,), {"noise": -1}, "noise: found -1, expected a number from 0 up"),
        (
            (tmp_path,),
            {"directory": tmp_path / "not" / "there"},
            "there: no such directory:",
        ),
    ]:
        with pytest.raises(gw.InputError, match=said):
            gw.infer(*arguments, **keys)


def test_noise_and_frames_of_a_run(run_of_spheres, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = ["infer", str(run_of_spheres), "--json", "--repeat", "2", "--noise", "0.02,0.1"]
    assert main(words) == 0
    words.insert(2, "--no-figures")
    summary = json.loads(capsys.readouterr().out)
    small, large = summary["true_force_error"]
    assert 0 < small < large < 0.5
    assert Path("infer/figures/noise.png").exists()
    assert main([*words[:-2], "--frame-rate", "1e5", "--force"]) == 0
    slow = json.loads(capsys.readouterr().out)
    assert 0 < slow["acceleration_error"] < 1
    assert main([*words[:-2], "--frame-rate", "1e6", "--force"]) == 2
    assert "run it again with run.frames" in capsys.readouterr().err


def test_a_run_without_forces_is_refused(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    run_case(load_case("two-spheres"), tmp_path / "run", figures=False)
    assert main(["infer", "run"]) == 2
    assert "output.contact_forces=true" in capsys.readouterr().err


def test_doubts_are_notes(infer):
    rows = [STRETCHED.format(GOOD[0].rsplit(",", 3)[0]), *GOOD[1:]]
    status, out, _ = infer(rows, case=CASE + "noise = {strain = 1e-5}\n")
    assert status == 0 and "most of the strains are tensile" in out
    assert "infer.noise lacks acceleration: it is not used" in out


def test_a_case_of_inference_is_named_as_such(tmp_path):
    file = tmp_path / "crystal.toml"
    file.write_text("[infer]\nfriction = 0.3\n")
    with pytest.raises(InputError, match=r"granwave infer GRAINS\.csv --case"):
        find_for(str(file), "run")


def test_options_of_the_command_are_keywords():
    check_keywords("infer")
