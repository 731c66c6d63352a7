"""Slurm's queue of a scan: jobs that a killed driver left behind go on, and must not be doubled."""

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
_ANSWER = 60.0  # s, in which Slurm must answer


@dataclasses.dataclass(frozen=True)
class Job:
    """A job that waits or runs; ``reason``: why it waits, in Slurm's word."""

    id: str
    pending: bool
    points: tuple[str, ...]
    reason: str = ""


def check_slurm() -> None:
    """Raise InputError where there is no Slurm on this machine, or none that answers."""
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
    """The jobs of a scan that wait or run, whoever submitted them.

    Raises
    ------
    RunError
        Slurm does not answer: then nothing is known of its jobs.
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
    """Take jobs back; those that run get SIGTERM, and some seconds."""
    if jobs:
        ask(["scancel", *(job.id for job in jobs)])


def _points(batch: Path) -> tuple[str, ...]:
    try:
        return tuple(point["id"] for point in json.loads(batch.read_text(encoding="utf-8"))["points"])
    except FileNotFoundError:
        return ()


def ask(command: list[str]) -> str:
    """Return the output of a command of Slurm; RunError with its own words where it fails."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=_ANSWER, check=False)
    except OSError as error:
        raise RunError(f"{command[0]} cannot be run: {error.strerror}") from None
    except subprocess.TimeoutExpired:
        raise RunError(f"{command[0]} does not answer; is the Slurm controller up?") from None
    if done.returncode:
        raise RunError(f"{command[0]} failed: {' '.join(done.stderr.split())}")
    return done.stdout
