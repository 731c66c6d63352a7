"""Files that are not what the run wrote, at equal length too: refused, or computed again, never used."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

import pytest

from granwave.lammps_inputs.files import checksum
from granwave.lammps_inputs.run_directory import MARKER
from granwave.workflows import run_case
from granwave.workflows.cli.main import main
from granwave.workflows.run import driver
from tests.helpers.small_cases import TWO_SPHERES

CLOCK = ("wall_time_s", "sphere_steps_per_s")
READERS = ("report {} -o {}.md", "film {} -o {}.gif", "figures {}", "export {} --to csv", "view {}", "infer {}")


def damage(path: Path, share: float = 0.6) -> None:
    """Change one byte to a digit that it is not."""
    content = bytearray(path.read_bytes())
    place = int(share * len(content))
    content[place] = ord("7") if content[place] != ord("7") else ord("8")
    path.write_bytes(content)


def values(directory: Path) -> dict:
    summary = json.loads((directory / "summary.json").read_text())
    return {key: value for key, value in summary.items() if key not in CLOCK}


@pytest.mark.parametrize("name", ["contacts.dump", "spheres.bin", "energy.txt"])
def test_a_dump_that_changed_is_refused_and_computed_again(run, whole, capsys, name):
    path = run / "dumps" / name
    damage(path, 0.95)
    results = [(run / one).read_bytes() for one in ("result.h5", "summary.json")]
    assert main(["analyse", str(run), "--no-figures"]) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert str(path) in line and "--resume" in line
    assert [(run / one).read_bytes() for one in ("result.h5", "summary.json")] == results
    assert run_case(TWO_SPHERES, run, resume=True, figures=False).state == "finished"
    assert path.read_bytes() == (whole / "dumps" / name).read_bytes() and values(run) == values(whole)


@pytest.mark.parametrize("command", READERS)
@pytest.mark.parametrize("name", ["result.h5"])
def test_a_result_that_changed_is_refused(run, capsys, command, name):
    damage(run / name)
    assert main(command.format(run, run.parent / "out").split()) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert f"{run / name}: is not what the run wrote" in line and f"granwave analyse {run}" in line
    assert main(["analyse", str(run), "--no-figures"]) == 0
    capsys.readouterr()


@pytest.mark.parametrize("place", range(0, 800, 48))
def test_damage_that_no_checksum_of_ours_tells_is_one_line(run, capsys, place):
    """The beginning of the file has checksums of HDF5 itself, whose errors are KeyErrors."""
    (run / MARKER).unlink()
    content = bytearray((run / "result.h5").read_bytes())
    content[place] ^= 0xFF
    (run / "result.h5").write_bytes(content)
    if status := main(["view", str(run), "-o", str(run.parent / "v.html")]):
        (line,) = capsys.readouterr().err.strip().splitlines()
        assert status == 2 and line.startswith(f"granwave: {run}")


def test_a_summary_that_changed_is_no_line_of_a_report(run, capsys):
    text = (run / "summary.json").read_text()
    (run / "summary.json").write_text(text.replace('"peak_force_N": ', '"peak_force_N": 1'))
    assert main(["report", str(run), "-o", str(run.parent / "r.md")]) == 2
    assert "summary.json: is not what the run wrote" in capsys.readouterr().err


@pytest.fixture
def interrupted(tmp_path: Path, monkeypatch) -> Path:
    """Run that stopped with a checkpoint."""
    looks = iter(range(1000))
    with monkeypatch.context() as patched:
        patched.setattr(driver.StopRequest, "wanted", lambda _: next(looks) == 1)
        patched.setattr(driver, "_PIECE", 1e-3)
        assert run_case(TWO_SPHERES, tmp_path / "r", figures=False).state == "interrupted"
    return tmp_path / "r"


@pytest.mark.parametrize("name", ["", "dumps/energy.txt"])
def test_a_checkpoint_that_changed_is_not_gone_on_with(interrupted, whole, caplog, name):
    saved = json.loads((interrupted / "run.json").read_text())["checkpoint"]
    name = name or saved["file"]
    damage(interrupted / name)
    assert run_case(TWO_SPHERES, interrupted, resume=True, figures=False).state == "finished"
    assert f"{interrupted / name}: is not what the run wrote" in caplog.text and "begins again" in caplog.text
    assert values(interrupted) == values(whole)


def test_a_whole_checkpoint_is_gone_on_with_and_analysed(interrupted, caplog):
    assert run_case(TWO_SPHERES, interrupted, resume=True, figures=False).state == "finished"
    assert "begins again" not in caplog.text and "read_restart" in (interrupted / "log.lammps").read_text()
    assert main(["analyse", str(interrupted), "--no-figures"]) == 0


def test_checksums_of_parts(tmp_path):
    path = tmp_path / "dump"
    path.write_bytes(os.urandom(3_000_000))
    half = checksum(path, 1_000_001)
    assert checksum(path, 2_500_000, after=(1_000_001, half)) == checksum(path, 2_500_000)
    assert checksum(path) == checksum(path, 3_000_000) != half


# ---------------------------------------------------------------------- points of a scan


@pytest.fixture(scope="module")
def scan(tmp_path_factory) -> Path:
    """Folder of a finished scan of two points."""
    folder = tmp_path_factory.mktemp("scan")
    text = 'case = "two-spheres"\n[set]\nrun.frames = 2\n[grid]\nload.velocity = [1.0, 2.0]\n'
    (folder / "s.toml").write_text(text)
    assert main(["scan", str(folder / "s.toml"), "-o", str(folder / "scan"), "--jobs", "1"]) == 0
    return folder


@pytest.mark.parametrize("way", ["directories", "runs in them"])
def test_swapped_points_are_refused(scan, tmp_path, capsys, way):
    shutil.copytree(scan, tmp_path / "here")
    place = tmp_path / "here" / "scan"
    one, two = sorted((place / "points").iterdir())
    if way == "directories":
        one.rename(place / "x")
        two.rename(one)
        (place / "x").rename(two)
        message = f"{one}: holds the point {two.name}"
    else:
        for path in (*two.iterdir(), two / MARKER):
            if path.is_file() and path.name not in ("point.json", "point.toml"):
                shutil.copy(path, one / path.name)
        message = f"{one}: holds a run of another case"
    for words in (
        ["report", place, "-o", tmp_path / "r.md"],
        ["scan", tmp_path / "here/s.toml", "-o", place, "--resume"],
    ):
        assert main([str(word) for word in words]) == 2
        assert message in capsys.readouterr().err
    shutil.rmtree(one)
    if way != "directories":
        assert main(["scan", str(tmp_path / "here/s.toml"), "-o", str(place), "--resume"]) == 0
        table = (place / "scan.csv").read_text()
        assert table.count("done") == 2, table
