"""``import granwave as gw``: run, scan, load and case, on tiny packings."""

from __future__ import annotations

import json
import subprocess
import sys
import tomllib

import h5py
import numpy as np
import pytest

import granwave as gw
from granwave.lammps_inputs import load_case
from granwave.workflows import library
from granwave.workflows.python.inputs import in_python
from granwave.workflows.run import mpi
from tests.conftest import PLAIN
from tests.helpers.keywords import check_keywords
from tests.helpers.made_up.export_inputs import equal

TINY = {"packing.size": [4, 4, 3], "run.end_time": 5e-5, "run.frames": 2}
PAIR = {
    "name": "pair",
    "material": "brass",
    "packing": {"kind": "chain", "size": 2, "diameter": 0.01},
    "load": {"velocity": 2.0},
    "boundary": {"bottom": "free"},
    "run": {"end_time": 5e-5},
}


@pytest.mark.parametrize(
    ("name", "own"), [("run", ("submit", "print", "chain")), ("scan", ("plan", "submit", "print"))]
)
def test_options_of_commands_are_keywords(name, own):
    check_keywords(name, *own)


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    return tmp_path_factory.mktemp("results") / "tiny"


@pytest.fixture(scope="module")
def tiny(directory):
    return gw.run("fcc-small", TINY, directory=directory, progress=False)


def test_import_is_light():
    code = """
import sys
import granwave
heavy = {"numpy", "pandas", "xarray", "matplotlib", "h5py", "mpi4py", "granwave.workflows"}
assert not heavy & set(sys.modules), heavy & set(sys.modules)
assert {"run", "Case", "workflows", "__version__"} <= set(dir(granwave))
assert granwave.workflows.load_case and not {"pandas", "xarray", "matplotlib"} & set(sys.modules)
from granwave import *
assert callable(run) and issubclass(InputError, ValueError)
"""
    subprocess.run([sys.executable, "-c", code], check=True, env=PLAIN, timeout=60)


def test_commands_do_without_pandas(tmp_path):
    words = [
        "run",
        "fcc-small",
        "--no-figures",
        *(f"--set={key}={value}" for key, value in TINY.items()),
    ]
    code = f"""
import sys
from granwave.workflows.cli.main import main
assert main(["cases"]) == main({words!r}) == 0
assert not {{"pandas", "xarray"}} & set(sys.modules)
"""
    subprocess.run(
        [sys.executable, "-c", code],
        check=True,
        env=PLAIN,
        cwd=tmp_path,
        timeout=60,
        capture_output=True,
    )


def test_there_is_no_other_name():
    with pytest.raises(AttributeError, match="has no attribute 'x'"):
        _ = gw.x
    assert all(hasattr(gw, name) for name in gw.__all__)


def test_run(tiny, directory):
    assert isinstance(tiny, gw.Run) and tiny.directory == directory
    assert dict(tiny) == json.loads((directory / "summary.json").read_text())
    with h5py.File(directory / "result.h5") as file:
        assert equal(tiny.contacts["peak_force"].to_numpy(), file["contacts/peak_force"][()])
    assert tiny["peak_force_N"] == tiny.contacts["peak_force"].max()
    assert not (directory / "figures").exists()
    assert tiny.case == gw.case("fcc-small", TINY) == gw.case(tiny)


def test_results_are_kept_continued_or_replaced(tiny, directory, tmp_path):
    words = r"already holds results.*; resume=True continues with them"
    words += ".*, force=True moves the results to"
    with pytest.raises(gw.InputError, match=words):
        gw.run("fcc-small", TINY, directory=directory)
    before = (directory / "result.h5").stat().st_mtime_ns
    assert gw.run("fcc-small", TINY, directory=directory, resume=True) == tiny
    assert (directory / "result.h5").stat().st_mtime_ns == before
    with pytest.raises(
        gw.InputError, match=r"holds another case .different: load.; force=True moves the results"
    ):
        gw.run("fcc-small", TINY, directory=directory, resume=True, load__velocity=7)
    first = gw.run(PAIR, directory=tmp_path / "pair")
    faster = gw.run(PAIR, directory=tmp_path / "pair", force=True, load__velocity=7)
    assert faster["energy_input_J"] > first["energy_input_J"]
    assert dict(gw.load(directory)) == dict(tiny)


def test_directory_is_named_after_the_case(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert gw.run(PAIR, figures=True).directory == tmp_path / "pair"
    assert (tmp_path / "pair" / "figures" / "energies.png").exists()
    monkeypatch.setenv("HOME", str(tmp_path))
    assert gw.run(PAIR, directory="~/at-home").directory == tmp_path / "at-home"


def test_ranks(tiny, tmp_path):
    """Results are bitwise identical for any number of ranks."""
    again = gw.run("fcc-small", TINY, directory=tmp_path, ranks=2)
    assert again["n_ranks"] == 2 and again["peak_force_N"] == tiny["peak_force_N"]
    assert again.contacts.equals(tiny.contacts)
    with pytest.raises(gw.InputError, match=r"already holds results.*force=True"):
        gw.run("fcc-small", TINY, directory=tmp_path, ranks=2)


def test_an_interrupted_run_goes_on(tiny, tmp_path, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(mpi.StopRequest, "wanted", lambda self: True)
        with pytest.raises(KeyboardInterrupt, match="pass resume=True to continue"):
            gw.run("fcc-small", TINY, directory=tmp_path)
    assert gw.load(tmp_path)["end_reason"] == "interrupted"
    again = gw.run("fcc-small", TINY, directory=tmp_path, resume=True)
    assert again["end_reason"] == "end_time" and again.contacts.equals(tiny.contacts)


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_refused_run_is_an_error(tmp_path, ranks):
    with pytest.raises(gw.RunError, match="energy balance error too large"):
        gw.run("fcc-small", TINY, directory=tmp_path, run__timestep=2e-6, ranks=ranks)
    assert gw.load(tmp_path)["energy_balance_error"] > 1e-5


def test_ways_to_give_a_case(tmp_path):
    path = library.find("fcc-small")
    values = {"load.velocity": 7, "material": "steel", "packing.size": [4, 4, 3]}
    expected = load_case(path, values)
    tables = tomllib.loads(path.read_text())
    for source in ("fcc-small", path, str(path), tables, gw.case("fcc-small")):
        assert gw.case(source, values) == expected
        assert (
            gw.case(source, load__velocity=7, material="steel", packing__size=(4, 4, 3)) == expected
        )
    numbers = {"load.velocity": np.float32(7), "packing.size": np.array([4, 4, 3])}
    assert gw.case("fcc-small", numbers, material={"preset": "steel"}) == expected
    again = tmp_path / "again.toml"
    again.write_text(expected.to_toml())
    assert gw.case(again) == expected


def test_a_case_of_python_is_checked_as_its_file_is(tmp_path):
    wrong = {
        **PAIR,
        "load": {"velocity": -1, "speed": 3},
        "packing": {"kind": "fcx", "size": [4, 4], "diameter": 0.01},
    }
    (tmp_path / "case.toml").write_text(
        'name = "pair"\nmaterial = "brass"\nload = {velocity = -1, speed = 3}\nboundary.bottom = "free"\n'
        'run.end_time = 5e-5\npacking = {kind = "fcx", size = [4, 4], diameter = 0.01}\n'
    )
    with pytest.raises(gw.InputError) as of_file:
        gw.case(tmp_path / "case.toml")
    with pytest.raises(gw.InputError) as of_python:
        gw.case(wrong)
    assert of_python.value.errors == [
        line.replace(str(tmp_path / "case.toml"), "case") for line in of_file.value.errors
    ]
    assert len(of_python.value.errors) == 3


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda: gw.run("fcc-smal"), "neither a file nor a built-in case; did you mean fcc-small"),
        (lambda: gw.run("restitution"), "is a scan, expected a case"),
        (
            lambda: gw.run(3),
            "case: found 3, expected a name, the path of a file, a mapping or a case",
        ),
        (
            lambda: gw.run(PAIR, load__velocty=3),
            "^load.velocty: unknown key; did you mean velocity",
        ),
        (
            lambda: gw.run(PAIR, load_velocity=3),
            "^load_velocity: unknown key; did you mean load__velocity, with two",
        ),
        (lambda: gw.run(PAIR, velocity=3), "velocity: unknown key; did you mean load.velocity"),
        (lambda: gw.run(PAIR, load__velocity=None), "load.velocity: found None, expected a number"),
        (
            lambda: gw.run(PAIR, load__velocity=print),
            "load.velocity: found <built-in function print>, expected a number",
        ),
        (
            lambda: gw.run(PAIR, {"load.velocity": 1}, load__velocity=2),
            "load.velocity: given twice",
        ),
        (
            lambda: gw.run(PAIR, "load.velocity=3"),
            'expected a mapping such as {"load.velocity": 10}',
        ),
        (lambda: gw.run(PAIR, directory=""), "found the empty name"),
        (lambda: gw.run(PAIR, directory="/"), "the root directory.* with directory="),
        (lambda: gw.run(PAIR, ranks=0), "ranks: found 0, expected a whole number"),
        (lambda: gw.run(PAIR, checkpoint=0), "checkpoint: found 0, expected a number above 0"),
        (
            lambda: gw.run(PAIR, force=True, resume=True),
            "resume=True and force=True exclude each other",
        ),
        (lambda: gw.scan("restitutio"), "did you mean restitution"),
        (lambda: gw.scan("fcc-small"), "is a case, expected a scan"),
        (lambda: gw.scan("protection"), "is a suite of scans, expected one scan: one of"),
        (lambda: gw.scan(5), "scan: found 5, expected a name"),
        (lambda: gw.scan({"case": "fcc-small"}), "scan: grid: nothing varies"),
        (
            lambda: gw.scan({"case": PAIR, "grid": {"load.velocty": [1, 2]}}),
            "load.velocty: unknown key",
        ),
        (lambda: gw.scan({"case": {}, "grid": {"load.velocity": [1, 2]}}), "packing: missing"),
        (lambda: gw.scan("restitution", jobs=0), "jobs: found 0, expected a whole number"),
        (
            lambda: gw.scan("restitution", executor="here"),
            'executor: found "here", expected one of local, slurm, pbs',
        ),
    ],
)
def test_wrong_input_is_refused_before_anything_runs(ask, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(gw.InputError, match=message):
        ask()
    assert list(tmp_path.iterdir()) == []


def test_options_are_called_asin_python():
    assert in_python("x: --force replaces it, or choose another with -o") == (
        "x: force=True replaces it, or choose another with directory=..."
    )
    command = "resume with  granwave run x/case.toml -o x --resume"
    assert in_python(command) == command


def test_scan(tmp_path):
    case = gw.case(PAIR)
    asked = {"name": "pairs", "case": case, "grid": {"load.velocity": np.array([1.0, 2.0])}}
    scan = gw.scan(asked, directory=tmp_path / "pairs", jobs=1, run__end_time=6e-5)
    assert isinstance(scan, gw.ScanRuns) and scan.name == "pairs" and len(scan) == 2
    assert scan.table["load.velocity"].tolist() == [1.0, 2.0] and scan.table["status"].tolist() == [
        "done",
        "done",
    ]
    alone = gw.run(case, directory=tmp_path / "alone", load__velocity=2.0, run__end_time=6e-5)
    assert scan[2]["peak_force_N"] == alone["peak_force_N"] == scan.table.loc[2, "peak_force_N"]
    assert scan[2].contacts.equals(alone.contacts)
    assert gw.load(tmp_path / "pairs").table.equals(scan.table)
    text = (tmp_path / "pairs" / "scan.toml").read_text()
    assert tomllib.loads(text)["case"] == "pair" and '# kind = "chain"' in text
    with pytest.raises(
        gw.InputError,
        match=r"resume=True runs only the missing points, force=True moves the results to",
    ):
        gw.scan(asked, directory=tmp_path / "pairs")


def test_points_that_fail_are_reported(tmp_path, caplog):
    scan = gw.scan(
        {"case": PAIR, "grid": {"run.timestep": [1e-8, 5e-6]}}, directory=tmp_path, jobs=1
    )
    assert scan.table["status"].tolist() == ["done", "failed"] and len(scan) == 1
    assert "energy balance error too large" in scan.table.loc[2, "reason"]
    assert f"{tmp_path}: of 2 points 1 failed; table.reason gives the" in caplog.text
