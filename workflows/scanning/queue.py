"""Jobs of a scan in Slurm's queue, including those that a killed driver left."""

from __future__ import annotations

import dataclasses
import json
import os
import re
import shutil
import subprocess
from pathlib import Path

from granwave.lammps_inputs.errors import InputError, RunError
from granwave.workflows.scanning import layout

_BATCH = re.compile(r"rule_(?:serial|parallel)_wildcards_(\w+)")  # in the comment that Snakemake gives a job
_ANSWER = 60.0  # s, time limit for an answer of Slurm


@dataclasses.dataclass(frozen=True)
class Job:
    """A pending or running job; ``reason``: why it is pending, as Slurm gives it."""

    id: str
    pending: bool
    points: tuple[str, ...]
    reason: str = ""


def check_slurm() -> None:
    """Raise InputError if Slurm is not installed on this machine, or does not answer."""
    for command in ("sbatch", "squeue", "srun"):
        if shutil.which(command) is None:
            raise InputError(
                f"--executor slurm: there is no {command} here; run it on a login node of the cluster, "
                "or take --executor local"
            )
    try:
        ask(["squeue", "--me", "--noheader", "--format=%i"])
    except RunError as error:
        raise InputError(f"--executor slurm: {error}") from None


def jobs_of(directory: Path) -> list[Job]:
    """Return the pending and running jobs of a scan, including those of earlier drivers.

    Raises
    ------
    RunError
        Slurm does not answer, so that its jobs are unknown.
    """
    jobs = []
    for line in ask(["squeue", "--me", "--array", "--noheader", "--format=%i|%T|%r|%k|%Z"]).splitlines():
        name, state, reason, comment, place = line.split("|", 4)
        batch = _BATCH.search(comment)
        if batch and os.path.realpath(place) == os.path.realpath(directory):
            points = _points(directory / layout.BATCHES / f"{batch[1]}.json")
            jobs.append(Job(name, state == "PENDING", points, reason))
    return jobs


def cancel(jobs: list[Job]) -> None:
    """Cancel jobs; running ones get SIGTERM and some seconds to stop."""
    if jobs:
        ask(["scancel", *(job.id for job in jobs)])


def _points(batch: Path) -> tuple[str, ...]:
    try:
        return tuple(point["id"] for point in json.loads(batch.read_text(encoding="utf-8"))["points"])
    except FileNotFoundError:
        return ()


def ask(command: list[str]) -> str:
    """Return the output of a command of Slurm; raise RunError with its message on failure."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=_ANSWER, check=False)
    except OSError as error:
        raise RunError(f"{command[0]} cannot be run: {error.strerror}") from None
    except subprocess.TimeoutExpired:
        raise RunError(f"{command[0]} does not answer; is the Slurm controller up?") from None
    if done.returncode:
        raise RunError(f"{command[0]} failed: {' '.join(done.stderr.split())}")
    return done.stdout
