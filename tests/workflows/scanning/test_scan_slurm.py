"""Scans on a Slurm cluster of two virtual nodes: ranks on several nodes, failures, requeued jobs, a
killed driver.
"""

from __future__ import annotations

import csv
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from granwave.workflows.cluster.schedulers import scheduler
from granwave.workflows.scanning import queue as queue_of_scan
from tests.conftest import PLAIN
from tests.helpers.programs.processes import children, wait_for
from tests.helpers.programs.slurm_cluster import slurm  # noqa: F401 (a fixture)

pytestmark = [pytest.mark.usefixtures("slurm"), pytest.mark.xdist_group("slurm")]

PROFILE = """
[slurm]
partition = "main"
nodes = 2
time = 10
job_start = 2
before = "export GREETING='{hello}'"
"""
TINY = """
name = "tiny"
case = "fcc-small"
ranks = {spheres_per_rank = 120, most = 2}
[set]
run.end_time = 5e-5
run.frames = 2
[grid]
packing.size = [[4, 4, 4], [6, 6, 4]]
run.timestep = ["auto", 1.0e-5]       # the second is far too large: it fails
"""
LONG = """
name = "long"
case = "fcc-small"
[set]
packing.size = [14, 14, 8]
run.end_time = 4e-3
run.timestep = 2.8e-8
run.frames = 2
[grid]
load.velocity = [5, 6]
"""


@pytest.fixture
def scan(slurm, tmp_path):  # noqa: F811
    """Start `granwave scan` on the cluster; killed at the end of the test, with its jobs."""
    (tmp_path / "profile.toml").write_text(PROFILE)
    for name in ("random", "numpy", "mpi4py"):  # of the user's own, which no job may take
        (tmp_path / f"{name}.py").write_text("raise SystemExit(3)\n")
    started = []

    def start(text: str, *words: str) -> subprocess.Popen[str]:
        (tmp_path / "scan.toml").write_text(text)
        command = [
            sys.executable, "-P", "-m", "granwave.workflows", "scan", "scan.toml", "-o", "out",
            "--executor", "slurm", "--profile", "profile.toml", *words,
        ]  # fmt: skip
        process = subprocess.Popen(
            command,
            cwd=tmp_path,
            env=PLAIN,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        started.append(process)
        return process

    yield start
    for process in started:
        process.kill()
    subprocess.run(["scancel", "--me"], check=False)
    wait_for(lambda: not queue(), 60)


def queue() -> list[list[str]]:
    """ID and state of every job."""
    done = subprocess.run(
        ["squeue", "--me", "-h", "-o", "%i %T"], capture_output=True, text=True, check=True
    )
    return [line.split() for line in done.stdout.splitlines()]


def noted(directory: Path, name: str) -> list:
    """Values of this name in the records of the points that are not done: state, attempts, pid."""
    return [
        json.loads(path.read_text())[name] for path in directory.glob("unfinished/*/point.json")
    ]


def rows_of(directory: Path) -> list[dict[str, str]]:
    with (directory / "scan.csv").open() as file:
        return list(csv.DictReader(file))


def jobs_ever() -> int:
    """Largest job ID so far."""
    done = subprocess.run(
        ["scontrol", "-o", "show", "jobs"], capture_output=True, text=True, check=True
    )
    return max(
        (int(line.split()[0].removeprefix("JobId=")) for line in done.stdout.splitlines()),
        default=0,
    )


def test_points_over_nodes_and_a_point_that_fails(scan, tmp_path):
    out, err = (process := scan(TINY)).communicate(timeout=240)
    assert process.returncode == 1, out + err
    assert "2 failed" in err
    rows = rows_of(tmp_path / "out")
    assert [row["status"] for row in rows] == ["done", "failed", "done", "failed"]
    assert [row["n_ranks"] for row in rows] == ["1", "", "2", ""]
    for row in rows[1::2]:
        assert row["attempts"] == "2" and "energy balance error too large" in row["reason"]
        assert (tmp_path / "out" / row["directory"] / "point.log").stat().st_size > 0
    run = json.loads((tmp_path / "out" / rows[2]["directory"] / "run.json").read_text())
    assert run["nodes"] == ["n1", "n2"]
    assert "energy balance error too large" in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.validation
def test_requeued_job_and_killed_driver_lose_and_double_nothing(scan, tmp_path):
    out = tmp_path / "out"
    driver = scan(LONG)
    wait_for(
        lambda: noted(out, "state") == ["running"] * 2 and all(s == "RUNNING" for _, s in queue()),
        120,
    )
    wait_for(lambda: len(list(out.glob("unfinished/*/dumps/energy.txt"))) == 2, 60)
    time.sleep(2)
    last = jobs_ever()

    # one job is requeued, with a checkpoint
    victim = queue()[0][0]
    subprocess.run(["scontrol", "requeue", victim], check=True)
    wait_for(lambda: [victim, "PENDING"] in queue(), 60)
    assert "interrupted" in noted(out, "state") or len(list(out.glob("points/*"))) > 0
    driver.send_signal(signal.SIGKILL)
    driver.wait()

    # the next start waits for both jobs, and submits none of its own
    driver = scan(LONG, "--resume")
    time.sleep(3)
    subprocess.run(["scontrol", "update", f"JobId={victim}", "StartTime=now"], check=False)
    text, err = driver.communicate(timeout=240)
    assert driver.returncode == 0, text + err
    assert jobs_ever() == last
    assert len(list(out.glob("points/*/summary.json"))) == 2
    logs = [path.read_text() for path in out.glob("points/*/log.lammps")]
    assert any("read_restart" in log for log in logs)


@pytest.mark.validation
def test_ctrl_c_takes_jobs_back_and_resume_goes_on(scan, tmp_path):
    out = tmp_path / "out"
    driver = scan(LONG)
    wait_for(lambda: "running" in noted(out, "state"), 120)
    driver.send_signal(signal.SIGINT)
    _, err = driver.communicate(timeout=120)
    assert driver.returncode == 130 and "--resume" in err, err
    assert not queue()
    assert set(noted(out, "state")) == {"interrupted"}
    driver = scan(LONG.replace("[5, 6]", "[5]"), "--resume")
    text, err = driver.communicate(timeout=240)
    assert driver.returncode == 0, text + err


def test_refused_jobs_have_slurm_s_reason(scan, tmp_path):
    """An invalid partition; then the same command with a corrected profile."""
    small = TINY.partition("[grid]")[0] + "[[points]]\npacking.size = [4, 4, 4]\n"
    (tmp_path / "profile.toml").write_text(PROFILE.replace('"main"', '"nix"'))
    out, err = (process := scan(small)).communicate(timeout=120)
    words = "Slurm did not run the job: invalid partition specified: nix"
    assert process.returncode == 1 and err.count(words) == 1 and "1 failed" in err, out + err
    assert all(
        row["status"] == "failed" and row["reason"].startswith(words)
        for row in rows_of(tmp_path / "out")
    )
    assert words in (tmp_path / "out" / "report.html").read_text()
    (tmp_path / "profile.toml").write_text(PROFILE)
    out, err = (process := scan(small, "--resume")).communicate(timeout=240)
    assert process.returncode == 0, out + err


def test_jobs_that_wait_for_what_never_comes_say_so(scan):
    update = ["scontrol", "update", "PartitionName=main"]
    subprocess.run([*update, "MaxTime=5"], check=True)
    try:
        driver = scan(LONG)
        wait_for(lambda: any(state == "PENDING" for _, state in queue()), 60)
        time.sleep(3)
        driver.send_signal(signal.SIGINT)
        _, err = driver.communicate(timeout=120)
        assert (
            driver.returncode == 130
            and err.count("jobs wait in the queue of Slurm: PartitionTimeLimit") == 1
        ), err
    finally:
        subprocess.run([*update, "MaxTime=INFINITE"], check=True)


@pytest.mark.validation
def test_jobs_that_are_ended_have_slurm_s_reason(scan, tmp_path):
    """A point fails with its job, and again with the replacement job."""
    out = tmp_path / "out"
    driver = scan(LONG.replace("[5, 6]", "[5]"))
    for attempt in (1, 2):
        wait_for(
            lambda number=attempt: (
                noted(out, "attempts") == [number] and noted(out, "state") == ["running"]
            ),
            120,
        )
        jobs = [job for job, _ in queue()]
        for worker in noted(out, "pid"):  # as if out of memory: no checkpoint is written
            for process in (worker, *children(worker)):
                os.kill(process, signal.SIGKILL)
        subprocess.run(["scancel", *jobs], check=True)
    text, err = driver.communicate(timeout=240)
    assert driver.returncode == 1 and "1 failed of the points (Slurm ended job" in err, text + err
    (row,) = rows_of(out)
    assert row["status"] == "failed" and row["attempts"] == "2"
    assert re.match(r"Slurm ended job \d+: CANCELLED", row["reason"]), row["reason"]


@pytest.mark.validation
def test_how_slurm_ended_a_job(slurm, tmp_path):  # noqa: F811
    logs = tmp_path / ".scan" / "logs" / "batch"
    logs.mkdir(parents=True)

    def end_of(_: Path, job: str) -> str:
        return queue_of_scan.end_of(tmp_path, job, scheduler("slurm"))

    def submit(command: str) -> str:
        words = [
            "sbatch",
            "--parsable",
            "--no-requeue",
            "-D",
            str(tmp_path),
            f"--output={logs}/%j.log",
            "--wrap",
            command,
        ]
        return subprocess.run(words, check=True, capture_output=True, text=True).stdout.strip()

    late, killed, failed, done = map(submit, ("sleep 300", "sleep 300", "exit 3", "true"))
    wait_for(lambda: sum(state == "RUNNING" for _, state in queue()) == 2, 60)
    subprocess.run(["scontrol", "update", f"JobId={late}", "TimeLimit=00:00:01"], check=True)
    subprocess.run(["scancel", killed], check=True)
    wait_for(lambda: not queue(), 120)
    assert end_of(tmp_path, failed) == end_of(tmp_path, done) == end_of(tmp_path, "999999") == ""
    assert end_of(tmp_path, killed).startswith(f"Slurm ended job {killed}: CANCELLED")
    said = end_of(tmp_path, late)
    assert re.match(
        rf"Slurm ended job {late}: TIMEOUT \(TimeLimit\): .*DUE TO TIME LIMIT; give a longer time in the profile",
        said,
    ), said

    lost = submit("sleep 300")
    wait_for(lambda: [lost, "RUNNING"] in queue(), 60)
    subprocess.run(
        ["scontrol", "update", "NodeName=n1,n2", "State=DOWN", "Reason=test"], check=True
    )
    try:
        wait_for(lambda: not queue(), 60)
        assert end_of(tmp_path, lost).startswith(f"Slurm ended job {lost}: NODE_FAIL (NodeDown)")
    finally:
        for (
            node
        ) in slurm:  # the controller rejects the whole command if one of the nodes is already up
            subprocess.run(["scontrol", "update", f"NodeName={node}", "State=RESUME"], check=False)


def test_jobs_of_another_scan_are_not_ours(scan, tmp_path):
    for folder in ("mine", "other"):
        (tmp_path / folder / ".scan" / "logs").mkdir(parents=True)
    queue_ = scheduler("slurm")
    script = "#!/bin/bash\n#SBATCH --output=/dev/null\nsleep 60\n"
    job = queue_.submit(script, tmp_path)
    queue_of_scan.note_submitted(tmp_path / "mine", job, "abc")
    queue_of_scan.note_submitted(tmp_path / "other", f"{int(job) + 1000}", "abc")
    assert [found.id for found in queue_of_scan.jobs_of(tmp_path / "mine", queue_)] == [job]
    assert not queue_of_scan.jobs_of(tmp_path / "other", queue_)
