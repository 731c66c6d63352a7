"""Results that --force moves into a directory next to them: nothing is lost."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import granwave as gw
from granwave.lammps_inputs.run_directory import MARKER
from granwave.workflows.cli.main import main

PAIR = ["two-spheres", "--set", "run.frames=2", "--no-figures"]
SCAN = 'case = "two-spheres"\nfigures = false\n[set]\nrun.frames = 2\n[grid]\nload.velocity = [1]\n'


def speeds(*names: str) -> list[float]:
    """Velocities of the load of runs."""
    return [gw.load(name).case.load.velocity for name in names]


@pytest.fixture
def here(tmp_path, monkeypatch):
    """Empty working directory."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(velocity: float, *words: str) -> int:
    return main(["run", *PAIR, "--set", f"load.velocity={velocity}", "-o", "r", *words])


def test_each_run_by_force_keeps_the_one_before(here, capsys, caplog):
    assert run(1) == 0
    Path("r", "notes.txt").write_text("mine")
    before = {path.name: path.read_bytes() for path in Path("r").iterdir() if path.is_file()}
    assert run(2) == 2
    assert "--force moves the results to r.old first" in capsys.readouterr().err
    assert run(2, "--force") == 0
    moved = f"{here / 'r'}: the previous results are now in {here / 'r.old'}"
    assert moved in caplog.messages
    Path("r.old3").write_text("a file of mine")
    assert run(3, "--force") == 0
    assert run(4, "--force") == 0
    assert speeds("r.old", "r.old2", "r.old4", "r") == [1, 2, 3, 4]
    del before["notes.txt"]
    del before[MARKER]
    assert {name: Path("r.old", name).read_bytes() for name in before} == before
    assert Path("r", "notes.txt").read_text() == "mine"
    assert not Path("r.old", "notes.txt").exists()


def test_what_was_moved_is_a_directory_of_results(here):
    assert run(1) == 0
    assert run(2, "--force") == 0
    before = Path("r.old", "result.h5").stat().st_ino
    again = ["run", *PAIR, "--set", "load.velocity=1", "-o", "r.old", "--resume"]
    assert main(again) == 0
    assert Path("r.old", "result.h5").stat().st_ino == before
    assert main(["analyse", "r.old", "--no-figures"]) == 0
    assert main(["report", "r", "r.old", "-o", "both.md"]) == 0


def test_nothing_is_moved_where_the_run_is_refused(here, capsys):
    assert run(1) == 0
    before = {path: path.read_bytes() for path in here.rglob("*") if path.is_file()}
    assert run(-1, "--force") == 2
    assert run(2, "--force", "--set", "packing.size=2000000000") == 2
    assert {path: path.read_bytes() for path in here.rglob("*") if path.is_file()} == before
    capsys.readouterr()


def test_the_working_directory_is_left_where_it_is(here, monkeypatch):
    assert run(1) == 0
    monkeypatch.chdir("r")
    assert main(["run", *PAIR, "--set", "load.velocity=2", "-o", ".", "--force"]) == 0
    assert Path.cwd() == here / "r"
    assert speeds(".", "../r.old") == [2, 1]


def test_ranks_move_once(here):
    assert run(1) == 0
    assert run(2, "--force", "--np", "2") == 0
    assert sorted(path.name for path in here.iterdir()) == ["r", "r.old"]
    assert speeds("r", "r.old") == [2, 1]


def test_a_case_in_its_own_directory_is_run_again(here):
    assert run(1) == 0
    assert main(["run", "r/case.toml", "-o", "r", "--no-figures", "--force"]) == 0
    assert speeds("r", "r.old") == [1, 1]


def test_results_are_moved_for_a_deck(here):
    assert run(1) == 0
    assert main(["write", "two-spheres", "-o", "r", "--force"]) == 0
    assert not Path("r", "result.h5").exists()
    assert speeds("r.old") == [1]


def test_a_scan_moves_with_its_points(here):
    Path("s.toml").write_text(SCAN)
    words = ["scan", "s.toml", "-o", "s", "--jobs", "1"]
    assert main(words) == 0
    assert main([*words, "--force"]) == 0
    assert sorted(path.name for path in here.iterdir()) == ["s", "s.old", "s.toml"]
    for name in ("s", "s.old"):
        table = gw.load(name).table
        assert list(table["status"]) == ["done"]
    assert not list(here.rglob("s.old/points/*.old"))


def test_the_scans_of_a_suite_move_with_it(here):
    Path("a.toml").write_text(SCAN)
    Path("suite.toml").write_text('name = "suite"\nscans = ["a.toml"]\n')
    words = ["scan", "suite.toml", "-o", "all", "--jobs", "1"]
    assert main(words) == 0
    assert main([*words, "--force"]) == 0
    assert sorted(path.name for path in here.iterdir()) == [
        "a.toml",
        "all",
        "all.old",
        "suite.toml",
    ]
    for name in ("all", "all.old"):
        assert json.loads(Path(name, "suite.json").read_text())["scans"] == ["a"]
        assert not list(Path(name).glob("*.old"))
        assert list(gw.load(Path(name, "a")).table["status"]) == ["done"]
