"""Runs and scans on a Grid Engine of one node: jobs, a chain, and the reason why a job has
ended.
"""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from pathlib import Path

import pytest

from granwave.workflows.cluster.schedulers import scheduler
from tests.conftest import PLAIN
from tests.helpers.programs.grid_engine_cluster import grid_engine  # noqa: F401 (a fixture)
from tests.helpers.programs.processes import wait_for

pytestmark = [
    pytest.mark.usefixtures("grid_engine"),
    pytest.mark.xdist_group("grid_engine"),
    pytest.mark.validation,
]

PROFILE = """[cluster]
scheduler = "sge"
partition = "main.q"
parallel_environment = "mpi"
time = 10
memory = 200
job_start = 2
"""
PATIENCE = 600  # s for the end of a run: hosts may be busy
SHORT = ["--set", "run.end_time=5e-5", "--set", "run.frames=2", "--no-figures"]
LONG = [
    "--set", "packing.size=[14, 14, 8]", "--set", "run.end_time=1e-3",
    "--set", "run.timestep=2.8e-8", "--set", "run.frames=2", "--no-figures", "--checkpoint", "1",
]  # fmt: skip
SCAN = """name = "tiny"
case = "fcc-small"
[set]
packing.size = [4, 4, 4]
run.end_time = 5e-5
run.frames = 2
[grid]
load.velocity = [1, 2]
"""


@pytest.fixture
def granwave(grid_engine, tmp_path, monkeypatch):  # noqa: F811
    """Run `granwave` with the commands of the cluster; its jobs are cancelled at the end."""
    (tmp_path / "profile.toml").write_text(PROFILE)
    for name in grid_engine:
        if name.startswith("SGE_"):
            monkeypatch.setenv(name, grid_engine[name])
    environment = {**PLAIN, **{n: v for n, v in grid_engine.items() if n.startswith("SGE_")}}

    def run(*words: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-P", "-m", "granwave.workflows", *words]
        return subprocess.run(
            command, cwd=tmp_path, env=environment, text=True, capture_output=True, timeout=PATIENCE
        )

    yield run
    queue = scheduler("sge")
    queue.cancel(queue.queue())
    wait_for(lambda: not queue.queue(), 60)


def submitted(done: subprocess.CompletedProcess[str]) -> list[str]:
    """Ids of the jobs in an output."""
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)["jobs"]


def logs_in(folder: Path) -> str:
    return "\n".join(path.read_text() for path in folder.glob("*.log"))


def test_a_run_on_two_ranks(granwave, tmp_path):
    words = ["run", "fcc-small", "-o", "out", "--submit", "profile.toml", "--np", "2", *SHORT]
    (job,) = submitted(granwave(*words, "--json"))
    wait_for(lambda: job not in scheduler("sge").queue(), PATIENCE)
    summary = tmp_path / "out" / "summary.json"
    assert summary.exists(), logs_in(tmp_path / "out.job")
    assert json.loads(summary.read_text())["n_ranks"] == 2


def test_a_chain_goes_on_after_a_killed_job(granwave, tmp_path):
    """Grid Engine cancels with SIGKILL: the second job continues from the last checkpoint."""
    words = ["run", "fcc-small", "-o", "out", "--submit", "profile.toml", "--chain", "2", *LONG]
    first, _ = submitted(granwave(*words, "--json"))
    record = tmp_path / "out" / "run.json"
    wait_for(lambda: record.exists() and json.loads(record.read_text()).get("checkpoint"), PATIENCE)
    queue = scheduler("sge")
    assert queue.queue() == {first: "running", str(int(first) + 1): "hqw"}
    queue.cancel([first])
    wait_for(lambda: not queue.queue(), PATIENCE)
    assert (tmp_path / "out" / "summary.json").exists(), logs_in(tmp_path / "out.job")
    assert "read_restart" in (tmp_path / "out" / "log.lammps").read_text()


def test_a_scan(granwave, tmp_path):
    (tmp_path / "scan.toml").write_text(SCAN)
    done = granwave("scan", "scan.toml", "-o", "out", "--submit", "profile.toml")
    assert done.returncode == 0, done.stdout + done.stderr
    with (tmp_path / "out" / "scan.csv").open() as file:
        assert [row["status"] for row in csv.DictReader(file)] == ["done"] * 2
    jobs = (tmp_path / "out" / ".scan" / "logs" / "submitted.txt").read_text()
    assert jobs.split()[0].isdigit()


def test_refused_jobs_have_the_reason_of_grid_engine(granwave, tmp_path):
    (tmp_path / "profile.toml").write_text(PROFILE.replace('"mpi"', '"nix"'))
    done = granwave(
        "run", "fcc-small", "-o", "out", "--submit", "profile.toml", "--np", "2", *SHORT
    )
    assert done.returncode == 1
    assert "Grid Engine rejected the job" in done.stderr and "nix" in done.stderr


def test_why_grid_engine_has_ended_a_job(granwave, tmp_path):
    """A job that exceeds its time limit."""
    queue = scheduler("sge")
    script = "#!/bin/bash\n#$ -S /bin/bash\n#$ -o /dev/null -j y\n#$ -l h_rt=2\nsleep 60\n"
    job = queue.submit(script, tmp_path)
    wait_for(lambda: job not in queue.queue(), 120)
    wait_for(lambda: queue.end_of(job, []), 60)
    assert "h_rt" in queue.end_of(job, [])
    assert "give a longer time in the profile" in queue.end_of(job, [])
