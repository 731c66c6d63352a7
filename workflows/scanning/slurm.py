"""A cluster with Slurm: the profile that `granwave scan --profile FILE` reads, the queue, and how
jobs ended.
"""

from __future__ import annotations

import contextlib
import dataclasses
import logging
import os
import re
import shlex
import shutil
import subprocess
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Literal

from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.schema import ErrorList, ValidationError, text
from granwave.lammps_inputs.errors import InputError, Mismatch, RunError
from granwave.lammps_inputs.files import read_json, read_toml
from granwave.workflows.scanning import layout

_LINES_FORM = "shell commands, a string or a list of strings"


def _lines(lines: tuple[str, ...]) -> str:
    return "\n".join(lines)


_LINES = schema.ListType(
    item=schema.TextType(expected=_LINES_FORM, may_be_empty=True),
    expected=_LINES_FORM,
    at_least=0,
    alone=True,
    finish=_lines,
)


#: Options that are keys of the profile, and options that granwave sets.
_KEYS = {
    "--partition": "partition", "-p": "partition", "--account": "account", "-A": "account", "--time": "time",
    "-t": "time", "--mem": "memory", "--mem-per-cpu": "memory", "--nodes": "nodes", "-N": "nodes",
}  # fmt: skip
_OURS = (
    "--job-name", "-J", "--output", "-o", "--error", "-e", "--parsable", "--export", "--comment", "--workdir",
    "--chdir", "-D", "--ntasks", "-n", "--cpus-per-task", "-c", "--signal", "--wrap",
)  # fmt: skip


def _options(value: str) -> str:
    """Check options of sbatch; refuse the options in `_KEYS` and `_OURS`."""
    try:
        words = shlex.split(value)
    except ValueError:  # unbalanced quotation mark
        raise ValidationError("options of sbatch, as in a shell") from None
    for name in (word.partition("=")[0] for word in words):
        if name in _KEYS:
            raise ValidationError(f"no {name}: it is the key slurm.{_KEYS[name]}")
        if name in _OURS:
            raise ValidationError(f"no {name}: granwave gives it to each job")
    return value


_OPTIONS = schema.TextType(
    expected="options of sbatch, a string", may_be_empty=True, finish=_options
)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Profile:
    """``[slurm]`` of a profile file."""

    partition: str | None = text("partition to submit to", default=None)
    account: str | None = text("account to charge", default=None)
    time: int | None = schema.count(
        "time limit of a job, minutes; default: thrice the expected time", default=None
    )
    memory: int | None = schema.count(
        "memory of a job, MB; default: what its points need", default=None
    )
    jobs: int = schema.count("jobs at once, where --jobs is not given", default=100)
    nodes: int = schema.count("nodes that the ranks of a point are spread over", default=1)
    launcher: str = text("starts the ranks of a point", default="srun --mpi=pmi2")
    before: str = schema.typed(
        "shell commands before each job, such as module load ...", _LINES, default=""
    )
    options: str = schema.typed(
        "further options for sbatch, such as --constraint=...", _OPTIONS, default=""
    )
    job_start: float = schema.number("time that it takes to start a job, s", above=0, default=15.0)
    status: Literal["squeue", "sacct"] = schema.choice(
        "how the state of jobs is asked for; sacct needs an accounting database",
        ("squeue", "sacct"),
        default="squeue",
    )


def load_profile(path: str | Path) -> Profile:
    """Read a profile file.

    Raises
    ------
    InputError
        The file is wrong; the message lists all faults.
    """
    data = read_toml(path)
    errors = ErrorList(str(path))
    if set(data) != {"slurm"}:
        errors.add("slurm", Mismatch(f"{', '.join(data) or 'nothing'}", "one table [slurm]"))
        raise InputError(errors.items)
    profile = schema.read_table(Profile, data["slurm"], "slurm", errors)
    if profile is None:
        raise InputError(errors.items)
    return profile


logger = logging.getLogger(__name__)

COMMENT = "granwave batch "  # of our jobs, followed by the id of the batch
_USUAL = (
    "None",
    "Resources",
    "Priority",
    "BeginTime",
    "Cleaning",
    "Prolog",
)  # normal reasons of pending jobs
_STATES = {  # commands that list jobs with their states
    "squeue": ["squeue", "--me", "--noheader", "--format=%i|%T"],
    "sacct": ["sacct", "-X", "-n", "-P", "-o", "JobID,State"],
}
_UNENDED = (
    "PENDING",
    "RUNNING",
    "CONFIGURING",
    "COMPLETING",
    "SUSPENDED",
    "REQUEUED",
    "RESIZING",
    "STOPPED",
)
_ANSWER = 60.0  # s, time limit for an answer of Slurm


@dataclasses.dataclass(frozen=True)
class QueuedJob:
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


def jobs_of(directory: Path) -> list[QueuedJob]:
    """Return the pending and running jobs of a scan, including jobs of earlier drivers.

    Raises
    ------
    RunError
        Slurm does not answer, so that its jobs are unknown.
    """
    jobs = []
    for line in ask(
        ["squeue", "--me", "--array", "--noheader", "--format=%i|%T|%r|%k|%Z"]
    ).splitlines():
        name, state, reason, comment, place = line.split("|", 4)
        if comment.startswith(COMMENT) and os.path.realpath(place) == os.path.realpath(directory):
            batch = read_json(
                directory / layout.BATCHES / f"{comment.removeprefix(COMMENT)}.json"
            ) or {"points": []}
            points = tuple(point["id"] for point in batch["points"])
            jobs.append(QueuedJob(name, state == "PENDING", points, reason))
    return jobs


def ended(jobs: Iterable[str], status: str) -> set[str]:
    """Return the jobs among these that have ended, by ``status`` of the profile; raise as
    `jobs_of`.
    """
    asked = [*_STATES[status], *([f"--jobs={','.join(jobs)}"] if status == "sacct" else [])]
    states = {name: state for name, state in (line.split("|") for line in ask(asked).splitlines())}
    unknown = "PENDING" if status == "sacct" else ""  # which learns of new jobs late
    return {job for job in jobs if states.get(job, unknown) not in _UNENDED}


def warn_of_pending(directory: Path, scan: str, reported: set[str]) -> None:
    """Log the unusual reasons why jobs of a scan are pending that were not ``reported``, and add
    them there.
    """
    for reason in {job.reason for job in jobs_of(directory) if job.pending} - reported:
        reported.add(reason)
        if reason not in _USUAL:
            logger.warning(
                "%s: Slurm lets jobs wait: %s; Ctrl-C takes them back", scan, reason.strip("()")
            )


def cancel(jobs: list[QueuedJob]) -> None:
    """Cancel jobs; running ones get SIGTERM and some seconds to stop."""
    if jobs:
        ask(["scancel", *(job.id for job in jobs)])


def ask(command: list[str], **options: Any) -> str:
    """Return the output of a command of Slurm, run with options of `subprocess.run`; raise RunError
    on failure.
    """
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=_ANSWER, check=False, **options
        )
    except OSError as error:
        raise RunError(f"{command[0]} cannot be run: {error.strerror}") from None
    except subprocess.TimeoutExpired:
        raise RunError(f"{command[0]} does not answer; is the Slurm controller up?") from None
    if done.returncode:
        raise RunError(f"{command[0]} failed: {' '.join(done.stderr.split())}")
    return done.stdout


_OF_ITSELF = ("", "COMPLETED", "COMPLETING", "RUNNING", "PENDING", "CONFIGURING", "SUSPENDED")
_SLURM_ERROR = re.compile(r"slurmstepd[^:]*: error: (.+)")  # in the log of a job
_REMEDIES = {
    r"OUT_OF_MEMORY|oom|memory limit": "give more slurm.memory in the profile",
    r"TIMEOUT|TIME LIMIT": "give a longer slurm.time in the profile",
}


def note_refused(directory: Path, points: Iterable[str], reason: str) -> None:
    """Mark points as failed if their jobs could not be submitted, with this reason."""
    for point in points:
        layout.change_state(
            directory, point, state=layout.FAILED, reason=f"Slurm did not run the job: {reason}"
        )


def note_ended(directory: Path, points: Iterable[str]) -> None:
    """Record why Slurm ended the jobs of unfinished points; a point fails with the second such job."""
    with contextlib.suppress(RunError):  # if Slurm does not answer, only its reasons are missing
        live = {name for job in jobs_of(directory) for name in job.points}
        for point in points:
            state = layout.state(directory, point)
            job = str(state.get("job") or "")
            left = (
                point not in live
                and not layout.is_done(directory, point)
                and job
                and state.get("asked") != job
            )
            if not left or not (reason := end_of(directory, job)):
                continue
            in_work = state.get("state") == layout.RUNNING
            last = state.get("attempts", 0) >= layout.MOST_ATTEMPTS
            layout.change_state(
                directory, point, asked=job, state=layout.FAILED if in_work and last else state.get("state"),
                reason=reason if in_work else "; ".join(filter(None, (state.get("reason"), reason))),
            )  # fmt: skip


def end_of(directory: Path, job: str) -> str:
    """Return why Slurm ended a job of a scan, with a remedy; empty if it did not, or has no record
    of the job.

    An example is ``TIMEOUT (TimeLimit): JOB 17 ON n1 CANCELLED AT ... DUE TO TIME LIMIT; give a
    longer slurm.time``.
    """
    try:
        found = ask(["scontrol", "--oneliner", "show", "job", job])
        parts = [re.search(rf"\b{key}=(\S+)", found) for key in ("JobState", "Reason", "ExitCode")]
        state, why, code = (match[1] if match else "" for match in parts)
    except RunError:  # it has no record of old jobs
        try:
            rows = ask(
                ["sacct", "-X", "-n", "-P", "-j", job, "-o", "State,Reason,ExitCode"]
            ).splitlines()
        except RunError:  # there is no accounting
            return ""
        state, why, code = rows[-1].split("|") if rows else ("", "", "")
    if state in _OF_ITSELF or (state == "FAILED" and code.endswith(":0")):
        return ""
    if why not in ("None", ""):
        state = f"{state} ({why})"
    lines: list[str] = []
    for log in (directory / layout.LOGS).glob(f"**/{job}.log"):
        with contextlib.suppress(OSError):
            lines += log.read_text(encoding="utf-8", errors="replace").splitlines()
    errors = "; ".join(
        dict.fromkeys(match[1].strip("* ") for line in lines if (match := _SLURM_ERROR.match(line)))
    )
    remedy = next(
        (
            text
            for sign, text in _REMEDIES.items()
            if re.search(sign, f"{state} {errors}", re.IGNORECASE)
        ),
        "",
    )
    return f"Slurm ended job {job}: {state}{f': {errors}' if errors else ''}{f'; {remedy}' if remedy else ''}"
