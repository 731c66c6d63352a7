"""A search on a Slurm cluster of two virtual nodes: `granwave design --submit`."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import PLAIN
from tests.helpers.programs.processes import wait_for
from tests.helpers.programs.slurm_cluster import slurm  # noqa: F401 (a fixture)

pytest.importorskip("sklearn")

PROFILE = '[cluster]\nscheduler = "slurm"\npartition = "main"\ntime = 10\nnodes = 2\n'


def design(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Run `granwave design beads.toml -o out --submit profile.toml` with further words."""
    (folder / "profile.toml").write_text(PROFILE)
    command = [
        sys.executable, "-P", "-m", "granwave.workflows", "design", "beads.toml", "-o", "out",
        "--submit", "profile.toml", *words,
    ]  # fmt: skip
    return subprocess.run(
        command, cwd=folder, env=PLAIN, text=True, capture_output=True, check=False
    )


def is_in_queue(job: str) -> bool:
    """Return True if a job waits or runs."""
    done = subprocess.run(["squeue", "--me", "-h", "-o", "%i"], capture_output=True, text=True)
    return job in done.stdout.split()


def test_the_script_of_a_search(folder):
    done = design(folder, "--print", "--budget", "4", "--jobs", "2")
    assert done.returncode == 0, done.stderr
    assert "#SBATCH --nodes=2" in done.stdout
    assert "granwave.workflows.cli.job" in done.stdout
    assert not (folder / "out").exists()
    assert not (folder / "out.job").exists()


@pytest.mark.validation
@pytest.mark.xdist_group("slurm")
def test_a_search_on_two_nodes(folder, slurm):  # noqa: F811
    """The search runs its designs on both nodes; the results stay, and are not overwritten."""
    done = design(folder, "--budget", "4", "--jobs", "2", "--json")
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    (job,) = answer["jobs"]
    again = design(folder, "--budget", "4")
    assert again.returncode == 2
    assert f"its job {job} is in the queue" in again.stderr
    wait_for(lambda: not is_in_queue(job), 240)
    logs = "\n".join(path.read_text() for path in (folder / "out.job").glob("*.log"))
    assert (folder / "out.job" / "ended").read_text() == "0\n", logs
    with (folder / "out" / "designs.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) >= 4  # and neighbours of the best
    assert {row["state"] for row in rows} == {"complete"}, logs
    points = (folder / "out" / "points").glob("[0-9]/run.json")
    records = [json.loads(path.read_text()) for path in points]
    nodes = set()
    for record in records:
        nodes.update(record["nodes"])
    assert nodes == set(slurm)
    again = design(folder, "--budget", "4")
    assert again.returncode == 2
    assert "already holds results" in again.stderr
