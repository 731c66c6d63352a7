"""Truncated, lost or edited files of a run are rejected, or made again with --resume, never
mixed.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

from granwave.analysis.reports.report import write_report
from granwave.lammps_inputs.errors import InputError, RunError
from granwave.lammps_inputs.files import checksum
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import MARKER
from granwave.workflows import load_case, run_case
from granwave.workflows.cli.main import main
from granwave.workflows.run import driver
from tests.helpers.made_up.small_cases import TWO_SPHERES

pytestmark = pytest.mark.xdist_group("damaged results")  # its fixtures are made once

CLOCK = ("wall_time_s", "sphere_steps_per_s")


def summary(directory: Path) -> dict:
    return json.loads((directory / "summary.json").read_text())


def cut(path: Path, size: int = 100) -> None:
    os.truncate(path, size)


def resumed(directory: Path, whole: Path) -> str:
    """Resume, and check that results are unchanged: "kept", "analysed" or "run", by modification
    times and the result.
    """
    before = directory / "result.h5"
    number = before.stat().st_ino if before.exists() else None
    outcome = run_case(TWO_SPHERES, directory, resume=True, figures=False)
    assert outcome.state == "finished" and outcome.summary == summary(directory)
    one = summary(whole)
    two = summary(directory)
    assert {k: v for k, v in one.items() if k not in CLOCK} == {
        k: v for k, v in two.items() if k not in CLOCK
    }
    assert (directory / "case.toml").read_bytes() == (whole / "case.toml").read_bytes()
    assert json.loads((directory / "run.json").read_text())["state"] == "finished"
    if one["wall_time_s"] != two["wall_time_s"]:
        return "run"
    return "kept" if before.exists() and before.stat().st_ino == number else "analysed"


@pytest.mark.parametrize(
    ("damaged", "way"),
    [
        ("summary.json", "analysed"),
        ("result.h5", "analysed"),
        ("summary.json result.h5", "analysed"),
        ("run.json", "analysed"),
        ("case.toml", "kept"),
        ("case.toml summary.json", "analysed"),
        ("run.json result.h5", "run"),  # no record of the settings of the run
        ("dumps/energy.txt", "run"),
        ("dumps/contacts.dump summary.json", "run"),
        ("data.granwave result.h5", "run"),
    ],
)
def test_what_was_cut_is_made_again(run, whole, caplog, damaged, way):
    for name in damaged.split():
        cut(run / name, 30)
    assert resumed(run, whole) == way
    assert any(str(run / name) in caplog.text for name in damaged.split())


def test_results_whose_marker_was_cut_are_nobodys(run):
    cut(run / MARKER, 30)
    before = {path: path.read_bytes() for path in run.rglob("*") if path.is_file()}
    for how in ({"resume": True}, {"force": True}, {}):
        with pytest.raises(InputError, match=r"and \.granwave, the list .*, is damaged; move them"):
            run_case(TWO_SPHERES, run, figures=False, **how)
    assert {path: path.read_bytes() for path in run.rglob("*") if path.is_file()} == before
    analyse_all(run)


@pytest.mark.parametrize(
    ("lost", "way"),
    [
        ("summary.json", "analysed"),
        ("result.h5", "analysed"),
        ("run.json", "analysed"),
        ("case.toml", "kept"),
        ("dumps/spheres.bin dumps/contacts.dump", "kept"),  # removed to save space
        ("dumps/spheres.bin summary.json", "run"),
    ],
)
def test_what_was_lost_is_made_again_where_it_is_needed(run, whole, lost, way):
    for name in lost.split():
        (run / name).unlink()
    assert resumed(run, whole) == way


@pytest.mark.parametrize("name", ["spheres.bin", "energy.txt", "contacts.dump"])
def test_garbage_in_the_output_is_run_again(run, whole, name):
    with (run / "dumps" / name).open("r+b") as file:
        file.write(bytes(range(256)) * 2)
    (run / "summary.json").unlink()
    assert resumed(run, whole) == "run"


# ---------------------------------------------------------------------- a case that was edited


def edit(directory: Path) -> None:
    path = directory / "case.toml"
    path.write_text(path.read_text().replace("velocity = ", "velocity = 1"))


def test_an_edited_case_is_refused(run, tmp_path, capsys):
    velocity = TWO_SPHERES.load.velocity
    edit(run)
    message = f"{run / 'case.toml'}: was changed after the run: load.velocity is 1{velocity}, was {velocity}."
    before = {path: path.read_bytes() for path in run.rglob("*") if path.is_file()}
    for command in (["analyse", str(run)], ["report", str(run), "-o", str(tmp_path / "r.html")]):
        assert main(command) == 2
        (line,) = capsys.readouterr().err.strip().splitlines()
        assert message in line and "granwave analyse" in line
    for case in (TWO_SPHERES, load_case(run / "case.toml")):
        with pytest.raises(InputError, match="was changed after the run"):
            run_case(case, run, resume=True)
    assert {path: path.read_bytes() for path in run.rglob("*") if path.is_file()} == before
    (run / "case.toml").unlink()
    assert main(["analyse", str(run), "--no-figures"]) == 0
    assert (run / "case.toml").read_bytes() == before[run / "case.toml"].replace(
        b"velocity = 1", b"velocity = "
    )


def analyse_all(directory: Path) -> None:
    write_report([directory], directory.parent / "r.md")


def test_comments_and_spaces_are_no_change(run, whole):
    text = (run / "case.toml").read_text()
    (run / "case.toml").write_text("# mine\n" + text.replace(" = ", "="))
    assert run_case(TWO_SPHERES, run, resume=True).state == "finished"
    assert main(["analyse", str(run), "--no-figures"]) == 0
    assert {k: v for k, v in summary(run).items() if k not in CLOCK} == {
        k: v for k, v in summary(whole).items() if k not in CLOCK
    }


# ---------------------------------------------------------------------- a disk that becomes full


@pytest.fixture
def small_disk(tmp_path):
    """Disk of 3 MB."""
    disk = tmp_path / "disk"
    disk.mkdir()
    if subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=3m", "tmpfs", disk], capture_output=True
    ).returncode:
        pytest.skip("no disk can be mounted here")
    yield disk
    subprocess.run(["umount", "-l", disk], check=True)


def fill_up(disk: Path, left: int = 0) -> Path:
    free = shutil.disk_usage(disk).free
    (disk / "ballast").write_bytes(bytes(max(free - left, 0)))
    return disk / "ballast"


@pytest.mark.parametrize("left", [0, 8192, 65536])
def test_an_analysis_on_a_full_disk_can_be_resumed(run, whole, small_disk, left):
    there = shutil.copytree(run, small_disk / "r")
    (there / "summary.json").unlink()
    ballast = fill_up(small_disk, left)
    with pytest.raises(RunError) as caught:
        run_case(TWO_SPHERES, there, resume=True, figures=False)
    assert "No space left on device" in str(caught.value) and "resume=True" in str(caught.value)
    assert str(caught.value).startswith(str(there / ("result.h5" if left else MARKER)))
    ballast.unlink()
    assert resumed(there, whole) == "analysed"


def test_a_full_disk_is_told_with_the_file_and_no_crash(process, run, small_disk):
    """HDF5 causes a segmentation fault if it cannot close a file."""
    there = shutil.copytree(run, small_disk / "r")
    before = (there / "result.h5").read_bytes()
    fill_up(small_disk, 32768)
    done = process("analyse", there, "--no-figures")
    assert done.returncode == 1, done.stderr
    assert done.stderr.splitlines() == [f"granwave: {there / 'result.h5'}: No space left on device"]
    assert (there / "result.h5").read_bytes() == before


@pytest.mark.needs_extension("pictures")
@pytest.mark.parametrize(
    ("words", "name"),
    [
        ("write two-spheres --set run.frames=9 -o deck --force", "deck"),
        ("view r -o v.html", "v.html"),
        ("export r --to csv -o ex", "ex/"),
        ("export r --to vtp -o ex2", "ex2/"),
        ("law -o law.png", "law.png"),
        ("law -o law.csv", "law.csv"),
    ],
)
@pytest.mark.parametrize("left", [0, 4096])
def test_good_files_stay_on_a_full_disk(run, small_disk, monkeypatch, capsys, words, name, left):
    """One line, exit status 1, and existing files are unchanged."""
    shutil.copytree(run, small_disk / "r")
    monkeypatch.chdir(small_disk)
    for first in (words, "write two-spheres -o deck --force"):
        assert main(first.split()) == 0
    capsys.readouterr()
    fill_up(small_disk, left)
    before = {path: path.read_bytes() for path in small_disk.rglob("*") if path.is_file()}
    assert main(words.split()) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"granwave: {name}") and (
        "No space left" in line or "check the disk space" in line
    )
    assert {path: path.read_bytes() for path in small_disk.rglob("*") if path.is_file()} == before


def test_a_run_ends_with_a_checkpoint_before_the_disk_is_full(whole, tmp_path, monkeypatch):
    free = iter([1e12])
    for room in ("driver", "failures"):
        name = f"granwave.workflows.run.{room}.free_space"
        monkeypatch.setattr(name, lambda _: next(free, 1000.0))
    with pytest.raises(RunError) as caught:
        run_case(TWO_SPHERES, tmp_path / "r", figures=False)
    message = str(caught.value)
    assert message.startswith(f"{tmp_path / 'r'}: the disk is full: stopped at step ")
    assert (
        "require about" in message
        and "only 1e-06 GB are free" in message
        and "from the checkpoint at step" in message
    )
    record = json.loads((tmp_path / "r" / "run.json").read_text())
    assert record["state"] == "failed" and (tmp_path / "r" / record["checkpoint"]["file"]).exists()
    monkeypatch.undo()
    assert run_case(TWO_SPHERES, tmp_path / "r", resume=True, figures=False).state == "finished"
    one = summary(whole)
    two = summary(tmp_path / "r")
    for key in ("n_steps", "peak_force_N", "energy_dissipated_J", "restitution"):
        assert two[key] == pytest.approx(one[key], rel=1e-9)
    assert not [
        name
        for name in ResultDirectory(tmp_path / "r").marker.files
        if name.startswith("checkpoint")
    ]


READERS = (
    "report {} -o {}.md",
    "film {} -o {}.gif",
    "figures {}",
    "export {} --to csv",
    "view {}",
    "infer {}",
)


def damage(path: Path, share: float = 0.6) -> None:
    """Change one byte to a different digit."""
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
    assert path.read_bytes() == (whole / "dumps" / name).read_bytes() and values(run) == values(
        whole
    )


@pytest.mark.needs_extension("pictures", "inference")
@pytest.mark.parametrize("command", READERS)
@pytest.mark.parametrize("name", ["result.h5"])
def test_a_result_that_changed_is_refused(run, capsys, command, name):
    damage(run / name)
    assert main(command.format(run, run.parent / "out").split()) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert (
        f"{run / name}: differs from the file that the run wrote" in line
        and f"granwave analyse {run}" in line
    )
    assert main(["analyse", str(run), "--no-figures"]) == 0
    capsys.readouterr()


@pytest.mark.needs_extension("pictures")
@pytest.mark.parametrize("place", range(0, 800, 96))
def test_damage_that_no_checksum_of_ours_tells_is_one_line(run, capsys, place):
    """The beginning of the file has checksums of HDF5 itself, whose errors are KeyErrors."""
    (run / MARKER).unlink()
    content = bytearray((run / "result.h5").read_bytes())
    content[place] ^= 0xFF
    (run / "result.h5").write_bytes(content)
    if status := main(["view", str(run), "-o", str(run.parent / "v.html")]):
        (line,) = capsys.readouterr().err.strip().splitlines()
        assert status == 2 and line.startswith(f"granwave: {run}")


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
    assert (
        f"{interrupted / name}: differs from the file that the run wrote" in caplog.text
        and "the run restarts from the beginning" in caplog.text
    )
    assert values(interrupted) == values(whole)


def test_a_whole_checkpoint_is_gone_on_with_and_analysed(interrupted, caplog):
    assert run_case(TWO_SPHERES, interrupted, resume=True, figures=False).state == "finished"
    assert (
        "the run restarts from the beginning" not in caplog.text
        and "read_restart" in (interrupted / "log.lammps").read_text()
    )
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
        messages = {
            f"{one}: holds the point {two.name}",
            f"{two}: holds the point {one.name}",
        }  # the first of the scan
    else:
        for path in (*two.iterdir(), two / MARKER):
            if path.is_file() and path.name not in ("point.json", "point.toml"):
                shutil.copy(path, one / path.name)
        messages = {f"{one}: contains a run of another case"}
    for words in (
        ["report", place, "-o", tmp_path / "r.md"],
        ["scan", tmp_path / "here/s.toml", "-o", place, "--resume"],
    ):
        assert main([str(word) for word in words]) == 2
        found = capsys.readouterr().err
        assert any(message in found for message in messages)
    shutil.rmtree(one)
    if way != "directories":
        assert main(["scan", str(tmp_path / "here/s.toml"), "-o", str(place), "--resume"]) == 0
        table = (place / "scan.csv").read_text()
        assert table.count("done") == 2, table
