"""Scans on a real Slurm of two virtual nodes: ranks over nodes, failures, requeued jobs, a killed driver."""

from __future__ import annotations

import csv
import json
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.conftest import PLAIN
from tests.slurm_cluster import slurm  # noqa: F401 (a fixture)

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
run.frames = 2
[grid]
load.velocity = [5, 6]
"""


@pytest.fixture
def scan(slurm, tmp_path):  # noqa: F811
    """Start `granwave scan` on the cluster; killed at the end of the test, with its jobs."""
    (tmp_path / "profile.toml").write_text(PROFILE)
    started = []

    def start(text: str, *words: str) -> subprocess.Popen[str]:
        (tmp_path / "scan.toml").write_text(text)
        command = [
            sys.executable, "-m", "granwave.workflows", "scan", "scan.toml", "-o", "out",
            "--executor", "slurm", "--profile", "profile.toml", *words,
        ]  # fmt: skip
        process = subprocess.Popen(
            command, cwd=tmp_path, env=PLAIN, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
        )
        started.append(process)
        return process

    yield start
    for process in started:
        process.kill()
    subprocess.run(["scancel", "--me"], check=False)
    wait_for(lambda: not queue(), 60)


def queue() -> list[list[str]]:
    """Id and state of every job."""
    done = subprocess.run(["squeue", "--me", "-h", "-o", "%i %T"], capture_output=True, text=True, check=True)
    return [line.split() for line in done.stdout.splitlines()]


def wait_for(condition: Callable[[], object], patience: float) -> None:
    end = time.monotonic() + patience
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.3)


def states(directory: Path) -> list[str]:
    """States of the points that are not done."""
    found = []
    for path in directory.glob("unfinished/*/point.json"):
        found.append(json.loads(path.read_text())["state"])
    return found


def jobs_ever() -> int:
    """The largest job id there has been."""
    done = subprocess.run(["scontrol", "-o", "show", "jobs"], capture_output=True, text=True, check=True)
    return max((int(line.split()[0].removeprefix("JobId=")) for line in done.stdout.splitlines()), default=0)


def test_points_over_nodes_and_a_point_that_fails(scan, tmp_path):
    out, err = (process := scan(TINY)).communicate(timeout=240)
    assert process.returncode == 1, out + err
    assert "2 failed" in err
    with (tmp_path / "out" / "scan.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["status"] for row in rows] == ["done", "failed", "done", "failed"]
    assert [row["n_ranks"] for row in rows] == ["1", "", "2", ""]
    for row in rows[1::2]:
        assert row["attempts"] == "2" and "energy balance was refused" in row["reason"]
        assert (tmp_path / "out" / row["directory"] / "point.log").stat().st_size > 0
    run = json.loads((tmp_path / "out" / rows[2]["directory"] / "run.json").read_text())
    assert run["nodes"] == ["n1", "n2"]
    assert "energy balance was refused" in (tmp_path / "out" / "report.html").read_text()


def test_requeued_job_and_killed_driver_lose_and_double_nothing(scan, tmp_path):
    out = tmp_path / "out"
    driver = scan(LONG)
    wait_for(lambda: states(out) == ["running"] * 2 and all(s == "RUNNING" for _, s in queue()), 120)
    wait_for(lambda: len(list(out.glob("unfinished/*/dumps/energy.txt"))) == 2, 60)
    time.sleep(2)
    last = jobs_ever()

    # one job goes back into the queue, with a checkpoint
    victim = queue()[0][0]
    subprocess.run(["scontrol", "requeue", victim], check=True)
    wait_for(lambda: [victim, "PENDING"] in queue(), 60)
    assert "interrupted" in states(out) or len(list(out.glob("points/*"))) > 0
    engine = subprocess.run(["pgrep", "-P", str(driver.pid)], capture_output=True, text=True, check=True).stdout.split()
    driver.send_signal(signal.SIGKILL)
    subprocess.run(["kill", "-KILL", *engine], check=True)
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


def test_ctrl_c_takes_jobs_back_and_resume_goes_on(scan, tmp_path):
    out = tmp_path / "out"
    driver = scan(LONG)
    wait_for(lambda: "running" in states(out), 120)
    driver.send_signal(signal.SIGINT)
    _, err = driver.communicate(timeout=120)
    assert driver.returncode == 130 and "--resume" in err, err
    assert not queue()
    assert set(states(out)) == {"interrupted"}
    driver = scan(LONG.replace("[5, 6]", "[5]"), "--resume")
    text, err = driver.communicate(timeout=240)
    assert driver.returncode == 0, text + err


def test_jobs_of_another_scan_are_not_ours(scan, tmp_path):
    from granwave.workflows.scanning.queue import jobs_of

    subprocess.run(
        ["sbatch", "--parsable", "-D", str(tmp_path), "--comment=rule_serial_wildcards_abc", "--wrap", "sleep 60"],
        check=True, stdout=subprocess.DEVNULL,
    )  # fmt: skip
    assert len(jobs_of(tmp_path)) == 1 and not jobs_of(tmp_path.parent)
