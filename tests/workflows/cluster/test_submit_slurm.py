"""Runs that are submitted to a Slurm cluster of two virtual nodes: ranks on both nodes, a chain of
jobs, jobs in the queue.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import PLAIN
from tests.helpers.programs.processes import wait_for
from tests.helpers.programs.slurm_cluster import slurm  # noqa: F401 (a fixture)

pytestmark = [pytest.mark.usefixtures("slurm"), pytest.mark.xdist_group("slurm")]

PROFILE = '[cluster]\nscheduler = "slurm"\npartition = "main"\ntime = 10\nnodes = 2\n'
# few steps: where other programs use all processors, each message between two ranks waits for both
SHORT = ["--set", "run.end_time=5e-6", "--set", "run.frames=2", "--no-figures"]
LONG = [
    "--set", "packing.size=[14, 14, 8]", "--set", "run.end_time=1e-3",
    "--set", "run.timestep=2.8e-8", "--set", "run.frames=2", "--no-figures", "--checkpoint", "1",
]  # fmt: skip


@pytest.fixture
def submit(slurm, tmp_path):  # noqa: F811
    """Run `granwave run fcc-small -o out --submit profile.toml`; its jobs are cancelled at the end
    of the test.
    """
    (tmp_path / "profile.toml").write_text(PROFILE)

    def run(*words: str) -> subprocess.CompletedProcess[str]:
        command = [
            sys.executable, "-P", "-m", "granwave.workflows", "run", "fcc-small", "-o", "out",
            "--submit", "profile.toml", *words,
        ]  # fmt: skip
        return subprocess.run(command, cwd=tmp_path, env=PLAIN, text=True, capture_output=True)

    yield run
    subprocess.run(["scancel", "--me"], check=False)
    wait_for(lambda: not states(), 60)


def states() -> dict[str, str]:
    """State of every job in the queue, by id."""
    done = subprocess.run(
        ["squeue", "--me", "-h", "-o", "%i %T"], capture_output=True, text=True, check=True
    )
    return dict(line.split() for line in done.stdout.splitlines())


def logs_in(folder: Path) -> str:
    return "\n".join(path.read_text() for path in folder.glob("*.log"))


@pytest.mark.validation
def test_a_run_on_two_nodes(submit, tmp_path):
    done = submit(*SHORT, "--np", "2", "--json")
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    (job,) = answer["jobs"]
    assert Path(answer["folder"]) == tmp_path / "out.job"
    again = submit(*SHORT, "--np", "2")
    assert again.returncode == 2
    assert f"its job {job} is in the queue" in again.stderr
    wait_for(lambda: job not in states(), 120)
    record = tmp_path / "out" / "run.json"
    assert record.exists(), logs_in(tmp_path / "out.job")
    assert json.loads(record.read_text())["nodes"] == ["n1", "n2"]
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["n_ranks"] == 2
    again = submit(*SHORT, "--np", "2")
    assert again.returncode == 2
    assert "already holds results" in again.stderr


@pytest.mark.validation
def test_a_chain_goes_on_from_checkpoints(submit, tmp_path):
    """The first job is stopped as if before its time limit; the third has nothing to do."""
    done = submit(*LONG, "--chain", "3", "--json")
    assert done.returncode == 0, done.stderr
    jobs = json.loads(done.stdout)["jobs"]
    assert len(jobs) == 3
    out = tmp_path / "out"
    wait_for(lambda: (out / "dumps" / "energy.txt").exists(), 120)
    assert [state for job, state in sorted(states().items()) if job != jobs[0]] == ["PENDING"] * 2
    subprocess.run(["scancel", "--signal=TERM", jobs[0]], check=True)
    wait_for(lambda: jobs[0] not in states(), 60)
    assert json.loads((out / "run.json").read_text())["state"] == "interrupted"
    wait_for(lambda: not states(), 240)
    assert (out / "summary.json").exists(), logs_in(tmp_path / "out.job")
    assert "read_restart" in (out / "log.lammps").read_text()
    assert (tmp_path / "out.job" / "ended").read_text() == "0\n"
    assert "granwave" not in (tmp_path / "out.job" / f"{jobs[2]}.log").read_text()


@pytest.mark.validation
def test_a_chain_goes_on_after_the_time_limit(submit, tmp_path):
    """Slurm signals the first job before its limit of two minutes; the second one continues."""
    (tmp_path / "profile.toml").write_text(PROFILE.replace("time = 10", "time = 2"))
    done = submit(*LONG, "--set", "run.end_time=1", "--np", "2", "--chain", "2", "--json")
    assert done.returncode == 0, done.stderr
    first, second = json.loads(done.stdout)["jobs"]
    wait_for(lambda: first not in states(), 240)
    record = json.loads((tmp_path / "out" / "run.json").read_text())
    assert record["state"] == "interrupted", logs_in(tmp_path / "out.job")
    reached = record["checkpoint"]["step"]
    assert reached > 0
    log = tmp_path / "out" / "log.lammps"
    wait_for(lambda: "read_restart" in log.read_text(), 120)
    subprocess.run(["scancel", "--signal=TERM", second], check=True)
    wait_for(lambda: not states(), 60)
    record = json.loads((tmp_path / "out" / "run.json").read_text())
    assert record["state"] == "interrupted"
    assert record["checkpoint"]["step"] > reached


def test_a_job_that_slurm_does_not_take(submit, tmp_path):
    (tmp_path / "profile.toml").write_text(PROFILE.replace('"main"', '"nix"'))
    done = submit(*SHORT)
    assert done.returncode == 1
    assert "Slurm rejected the job: invalid partition specified: nix" in done.stderr
    (tmp_path / "profile.toml").write_text(PROFILE)
    done = submit(*SHORT)
    assert done.returncode == 0, done.stderr
