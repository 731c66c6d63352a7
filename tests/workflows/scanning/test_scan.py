"""Scans on this machine from the point of view of a user: output files, exit statuses, failures,
kills, resume.
"""

from __future__ import annotations

import contextlib
import csv
import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from granwave.analysis.scans.table import read_scan, write_scan_table
from granwave.workflows.cli.worker import _Worker
from tests.conftest import PLAIN
from tests.helpers.programs.processes import alive, children, wait_for

pytestmark = pytest.mark.xdist_group("scan")  # its fixtures are made once

HEAD = """
case = "fcc-small"
ranks = {spheres_per_rank = 200, most = 2}
[set]
run.end_time = 5e-5
run.frames = 2
"""
#: Two valid points, one of them twice; one with an immediate error of LAMMPS; one on two ranks.
POINTS = """
[[points]]
packing.size = [6, 6, 4]
load.velocity = 1
[[points]]
packing.size = [6, 6, 4]
load.velocity = 2
[[points]]
packing.size = [6, 6, 4]
load.velocity = 1000
[[points]]
packing.size = [6, 6, 4]
load.velocity = 2.0
[[points]]
packing.size = [8, 8, 4]
load.velocity = 1
"""
#: One point that takes seconds, and some that take a fraction of a second.
LONG = """
case = "fcc-small"
[set]
run.frames = 2
run.timestep = 2.8e-8
[[points]]
packing.size = [12, 12, 6]
run.end_time = %g
""" + "".join(
    f"[[points]]\npacking.size = [8, 8, 5]\nrun.end_time = 3e-4\nload.velocity = {v}\n"
    for v in range(1, 5)
)
TINY = 'case = "two-spheres"\n[[points]]\nload.velocity = 3\n'
SCAN = [sys.executable, "-m", "granwave.workflows", "scan"]

Start = Callable[..., subprocess.Popen[str]]


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """Start a scan of this text in the directory "out"; remaining processes are killed at the end
    of the test.
    """
    started: list[subprocess.Popen[str]] = []

    def run(text: str, *words: str) -> subprocess.Popen[str]:
        (tmp_path / "my.toml").write_text(text, encoding="utf-8")
        process = subprocess.Popen(
            [*SCAN, "my.toml", "-o", "out", "--jobs", "2", *words],
            cwd=tmp_path, env=PLAIN, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip
        started.append(process)
        return process

    yield run
    for process in started:
        process.kill()
        process.communicate()
    with contextlib.suppress(TimeoutError):
        wait_for(
            lambda: (
                not (tmp_path / "out" / "unfinished").exists()
                or not any(map(alive, workers(tmp_path)))
            ),
            30,
        )


def rows(directory: Path) -> list[dict[str, str]]:
    with (directory / "scan.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def record(place: Path) -> dict:
    with contextlib.suppress(OSError, ValueError):
        return json.loads((place / "point.json").read_text())
    return {}


def marks(directory: Path) -> dict[str, tuple[int, int]]:
    """Files of the finished points, by which a repeated point is detected."""
    return {
        str(path.relative_to(directory)): (path.stat().st_ino, path.stat().st_mtime_ns)
        for path in (directory / "points").glob("*/*")
    }


def tree(directory: Path) -> dict[str, int]:
    return {str(path): path.stat().st_mtime_ns for path in directory.rglob("*")}


def workers(tmp_path: Path) -> set[int]:
    """Processes of the workers with a point in progress."""
    return {
        record(path.parent)["pid"]
        for path in tmp_path.glob("out/unfinished/*/point.json")
        if record(path.parent)
    }


def growing(place: Path, since: int = 20_000) -> bool:
    """True if the energy record of the present attempt at this point exceeds a number of bytes."""
    with contextlib.suppress(OSError):
        ledger = (place / "dumps" / "energy.txt").stat()
        noted = record(place)
        return (
            noted.get("state") == "running"
            and ledger.st_mtime > noted["started"]
            and ledger.st_size > since
        )
    return False


# ---------------------------------------------------------------------- what a scan leaves


@pytest.fixture(scope="module")
def finished(tmp_path_factory) -> tuple[Path, subprocess.CompletedProcess[str]]:
    """Scan whose third point fails, in a directory with special characters in its name."""
    directory = tmp_path_factory.mktemp("scans") / "my {scan} Nö 1"
    directory.mkdir()
    (directory / "notes.txt").write_text("mine")
    (directory.parent / "my.toml").write_text(HEAD + POINTS, encoding="utf-8")
    command = [*SCAN, "my.toml", "-o", directory.name]
    return directory, subprocess.run(
        command, cwd=directory.parent, capture_output=True, text=True, timeout=300, env=PLAIN
    )


def test_a_scan_leaves_everything(finished) -> None:
    directory, done = finished
    assert done.returncode == 1, done.stderr
    for name in (
        "scan.toml",
        "scan.json",
        "scan.csv",
        "scan.h5",
        "report.html",
        "figures",
        "points",
        "notes.txt",
    ):
        assert (directory / name).exists(), name
    table = rows(directory)
    assert [row["load.velocity"] for row in table] == ["1", "2", "1000", "2.0", "1"]
    assert [row["packing.size"] for row in table] == ["[6, 6, 4]"] * 4 + ["[8, 8, 4]"]
    assert [row["status"] for row in table] == ["done", "done", "failed", "done", "done"]
    assert [row["n_ranks"] for row in table] == ["1", "1", "", "1", "2"]
    for row in table:
        place = directory / row["directory"]
        assert (place / "summary.json").exists() == (row["status"] == "done")
        assert (place / "case.toml").exists() and (place / "point.log").exists()
    velocities = [
        json.loads((directory / row["directory"] / "summary.json").read_text()) for row in table[:2]
    ]
    assert velocities[0]["energy_input_J"] * 4 == pytest.approx(velocities[1]["energy_input_J"])
    assert float(table[0]["dissipated_fraction"]) == velocities[0]["dissipated_fraction"]
    data = read_scan(directory)
    assert data.n_points == 5 and data["peak_force_N"][1] == float(table[1]["peak_force_N"])
    # equal points are run once
    assert table[1]["directory"] == table[3]["directory"] and table[1]["attempts"] == "1"
    assert len(list((directory / "points").iterdir())) == 3
    assert (
        list((directory / "figures").glob("*.png"))
        and "1000" in (directory / "report.html").read_text()
    )


def test_a_point_that_fails_is_tried_twice_and_kept_with_its_reason(finished) -> None:
    directory, done = finished
    row = rows(directory)[2]
    assert row["attempts"] == "2" and "overlap by" in row["reason"] and row["peak_force_N"] == ""
    log = (directory / row["directory"] / "point.log").read_text()
    assert row["directory"].startswith("unfinished/") and log.count("overlap by") >= 2
    assert "overlap by" in done.stdout and "3 done, 1 failed, 0 missing" in done.stdout
    (line,) = [line for line in done.stderr.splitlines() if line.startswith("granwave: ")]
    assert "1 failed" in line and "scan.csv" in line and "--resume" in line


def test_a_directory_with_results_is_refused(finished, granwave) -> None:
    directory, _ = finished
    before = tree(directory)
    again = granwave("scan", "my.toml", "-o", directory, cwd=directory.parent)
    assert (
        again.returncode == 2
        and "already holds results" in again.stderr
        and "--resume" in again.stderr
    )
    other = granwave("scan", "restitution", "-o", directory, "--resume")
    assert (
        other.returncode == 2 and "another scan (my)" in other.stderr and "--force" in other.stderr
    )
    run = granwave(
        "scan",
        "my.toml",
        "-o",
        directory / rows(directory)[0]["directory"],
        "--force",
        cwd=directory.parent,
    )
    assert run.returncode == 2 and "holds a run" in run.stderr
    assert all(len(done.stderr.splitlines()) == 1 for done in (again, other, run))
    assert tree(directory) == before


def test_resume_does_what_is_missing_and_force_replaces_all(finished, granwave, tmp_path) -> None:
    out = tmp_path / "out"
    shutil.copytree(finished[0], out)
    # machine failure: an empty summary and an empty case
    places = [out / row["directory"] for row in rows(out)]
    (places[0] / "summary.json").write_text("")
    (places[1] / "case.toml").write_text("")
    places[1].rename(out / "unfinished" / places[1].name)
    before = {name: mark for name, mark in marks(out).items() if places[4].name in name}
    good = POINTS.replace("1000", "3") + "[[points]]\npacking.size = [6, 6, 4]\nload.velocity = 4\n"
    (tmp_path / "my.toml").write_text(HEAD + good)
    words = ("scan", "my.toml", "-o", "out")

    extended = granwave(*words, "--resume", cwd=tmp_path)
    assert extended.returncode == 0, extended.stderr
    assert "6, 5 of them different, 1 done already" in extended.stdout
    after = marks(out)
    assert {name: after[name] for name in before} == before and len(after) > len(before)
    assert [row["status"] for row in rows(out)] == ["done"] * 6

    (tmp_path / "my.toml").write_text(TINY)
    replaced = granwave(*words, "--force", cwd=tmp_path)
    assert replaced.returncode == 0, replaced.stderr
    assert [row["load.velocity"] for row in rows(out)] == ["3"]
    assert len(list((out / "points").iterdir())) == 1
    assert (out / "notes.txt").read_text() == "mine"


def test_damaged_points_are_made_again(granwave, tmp_path) -> None:
    """Counts on the terminal agree with the table, and --resume repairs the scan."""
    text = 'case = "two-spheres"\n[set]\nrun.frames = 2\n[grid]\nload.velocity = [1, 2, 3, 4, 5]\n'
    (tmp_path / "my.toml").write_text(text)
    words = ("scan", "my.toml", "-o", "out", "--resume")
    out = tmp_path / "out"
    assert granwave(*words, cwd=tmp_path).returncode == 0
    places = [out / row["directory"] for row in rows(out)]
    before = marks(out)
    whole = [json.loads((place / "summary.json").read_text()) for place in places]
    for place, name in zip(
        places, ("summary.json", "result.h5", "dumps/contacts.dump", "case.toml"), strict=False
    ):
        os.truncate(place / name, 60)
    (places[0] / "notes").write_text("mine")

    table = write_scan_table(out)
    first = next(iter(csv.DictReader(table.open())))
    assert (first["status"], first["reason"]) == ("missing", "its summary.json is damaged")
    mended = granwave(*words, cwd=tmp_path)
    assert mended.returncode == 0, mended.stderr
    assert "5, 1 done already" in mended.stdout and "5 done, 0 failed, 0 missing" in mended.stdout
    assert [
        line.partition(": is damaged")[0]
        for line in mended.stderr.splitlines()
        if "summary.json" in line
    ] == [f"granwave: warning: {places[0] / 'summary.json'}"]
    assert [row["status"] for row in rows(out)] == ["done"] * 5 and (
        places[0] / "notes"
    ).read_text() == "mine"
    for place, was in zip(places, whole, strict=True):
        now = json.loads((place / "summary.json").read_text())
        assert {key: now[key] for key in was if not key.endswith("_s")} == {
            key: value for key, value in was.items() if not key.endswith("_s")
        }
        # only the truncated output required another run of LAMMPS
        assert (now["wall_time_s"] == was["wall_time_s"]) == (place != places[2])
    after = marks(out)
    last = [name for name in before if places[4].name in name]
    assert last and all(after[name] == before[name] for name in last)

    (places[1] / "case.toml").write_text(
        (places[1] / "case.toml").read_text().replace("velocity = 2", "velocity = 7")
    )
    for command in (words, ("report", "out", "-o", "r.html")):
        refused = granwave(*command, cwd=tmp_path)
        (line,) = refused.stderr.splitlines()
        assert (
            refused.returncode == 2 and "load.velocity is 7" in line and str(places[1].name) in line
        )


def test_too_little_room_for_a_point_is_told(tmp_path, monkeypatch) -> None:
    (tmp_path / ".scan").mkdir()
    worker = _Worker(tmp_path, {})
    monkeypatch.setattr("granwave.workflows.cli.worker.free_space", lambda _: 21e6)
    assert not worker._room({"disk": 1e6})
    assert (tmp_path / ".scan" / "stop").read_text() == (
        f"{tmp_path}: the results of the next point require about 0.001 GB and 0.05 GB must stay free, but only 0.021 GB are free"
    )


# ---------------------------------------------------------------------- what goes wrong on the way


@pytest.mark.validation
def test_ctrl_c_and_kills_lose_nothing(start: Start, granwave, tmp_path: Path) -> None:
    directory = tmp_path / "out"
    text = LONG % 2e-2
    process = start(text)
    wait_for((directory / "scan.json").exists, beside=process)
    first = json.loads((directory / "scan.json").read_text())["points"][0]["id"]
    long = directory / "unfinished" / first
    busy = granwave("scan", "my.toml", "-o", "out", "--resume", cwd=tmp_path)
    assert busy.returncode == 2 and "in use by another run or scan" in busy.stderr

    # the process of a point is killed: the point is retried once
    wait_for(lambda: growing(long), beside=process)
    (point,) = children(record(long)["pid"])
    os.kill(point, signal.SIGKILL)
    wait_for(lambda: record(long).get("attempts") == 2, beside=process)

    # Ctrl-C
    wait_for(
        lambda: growing(long) and list(directory.glob("points/*/summary.json")), beside=process
    )
    process.send_signal(signal.SIGINT)
    said, errors = process.communicate(timeout=120)
    assert process.returncode == 130, errors
    assert "--resume" in errors and "Traceback" not in errors and "missing" in said
    assert list(long.glob("checkpoint-*.restart")) and record(long)["state"] == "interrupted"
    assert {row["status"] for row in rows(directory)} == {"done", "missing"}
    before = marks(directory)
    size = (long / "dumps" / "energy.txt").stat().st_size

    # the driver is killed: its processes end by themselves
    process = start(text, "--resume")
    wait_for(lambda: growing(long, size), beside=process)
    process.kill()
    process.communicate()

    done = granwave("scan", "my.toml", "-o", "out", "--resume", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    table = rows(directory)
    assert [row["status"] for row in table] == ["done"] * 5 and not (
        directory / "unfinished"
    ).exists()
    assert float(table[0]["energy_balance_error"]) < 1e-5
    after = marks(directory)
    assert {name: after[name] for name in before} == before
    # it continued from its checkpoint each time, without duplicate output
    log = (directory / "points" / first / "log.lammps").read_text()
    assert log.count("Reading restart file") == 2 and log.count("create_box") == 1
    ledger = (directory / "points" / first / "dumps" / "energy.txt").read_text().splitlines()
    lines = [line for line in ledger if not line.startswith("#")]
    steps = [int(line.split()[0]) for line in lines]
    # a continued run writes the identical row of its checkpoint step again; readers use one of them
    assert steps == sorted(steps) and len(set(lines)) == len(set(steps)) >= len(steps) - 2


@pytest.mark.validation
def test_a_scan_survives_a_worker(start: Start, tmp_path: Path) -> None:
    directory = tmp_path / "out"
    process = start(LONG % 3e-3)
    wait_for((directory / "scan.json").exists, beside=process)
    long = (
        directory
        / "unfinished"
        / json.loads((directory / "scan.json").read_text())["points"][0]["id"]
    )
    wait_for(lambda: growing(long), beside=process)
    os.kill(record(long)["pid"], signal.SIGKILL)
    _, errors = process.communicate(timeout=200)
    assert process.returncode == 0, errors
    assert [row["status"] for row in rows(directory)] == ["done"] * 5


# ---------------------------------------------------------------------- bad input


def test_a_plan_runs_nothing(granwave, tmp_path: Path) -> None:
    done = granwave("scan", "restitution", "--plan", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    for words in (
        "points         26",
        "load.velocity (13), packing.size (2)",
        "memory",
        "disk",
        "expected time",
    ):
        assert words in done.stdout
    assert not list(tmp_path.iterdir())


def test_a_scan_is_no_case(granwave) -> None:
    done = granwave("run", "velocity-fcc")
    assert (
        done.returncode == 2
        and "is a scan" in done.stderr
        and "granwave scan velocity-fcc" in done.stderr
    )


def test_without_slurm_there_is_no_slurm(granwave, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    done = granwave("scan", "restitution", "--executor", "slurm", cwd=tmp_path)
    assert (
        done.returncode == 2 and "--executor slurm" in done.stderr and not list(tmp_path.iterdir())
    )
