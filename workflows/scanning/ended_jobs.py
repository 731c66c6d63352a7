"""Reasons given by Slurm for jobs that it refused or ended, stored in the records of their points."""

from __future__ import annotations

import contextlib
import re
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from granwave.lammps_inputs.errors import RunError
from granwave.workflows.scanning import layout, queue

if TYPE_CHECKING:
    from granwave.workflows.scanning.scan_file import Point

_OF_ITSELF = ("", "COMPLETED", "COMPLETING", "RUNNING", "PENDING", "CONFIGURING", "SUSPENDED")
_SLURM_ERROR = re.compile(r"slurmstepd[^:]*: error: (.+)")  # in the log of a job
_REMEDIES = {
    r"OUT_OF_MEMORY|oom|memory limit": "give more slurm.memory in the profile",
    r"TIMEOUT|TIME LIMIT": "give a longer slurm.time in the profile",
}


def note_refused(directory: Path, points: Sequence[Point], reason: str) -> None:
    """Mark points whose jobs could not be submitted as failed, for this reason."""
    for point in points:
        record = {"state": layout.FAILED, "reason": f"Slurm did not run the job: {reason}"}
        layout.write_state(layout.unfinished(directory, point.id), **{**layout.state(directory, point.id), **record})


def note_ended(directory: Path, points: Sequence[Point]) -> None:
    """Record why Slurm ended the jobs of unfinished points; a point fails with the second such job."""
    with contextlib.suppress(RunError):  # if Slurm does not answer, only its reasons are missing
        live = {name for job in queue.jobs_of(directory) for name in job.points}
        for point in points:
            if point.id not in live and not layout.is_done(directory, point.id):
                _note(directory, point)


def _note(directory: Path, point: Point) -> None:
    state = layout.state(directory, point.id)
    job = state.get("job")
    if not job or state.get("asked") == job or not (reason := end_of(directory, job)):
        return
    in_work, last = state.get("state") == layout.RUNNING, state.get("attempts", 0) >= layout.MOST_ATTEMPTS
    record = {
        "state": layout.FAILED if in_work and last else state.get("state"),
        "reason": reason if in_work else "; ".join(filter(None, (state.get("reason"), reason))),
        "asked": job,
    }
    layout.write_state(layout.unfinished(directory, point.id), **{**state, **record})


def end_of(directory: Path, job: str) -> str:
    """Return why Slurm ended a job of a scan, with a remedy; empty if it did not, or has no record of the job.

    An example is ``TIMEOUT (TimeLimit): JOB 17 ON n1 CANCELLED AT ... DUE TO TIME LIMIT; give a longer slurm.time``.
    """
    state = _state(job)
    lines = [line for log in (directory / layout.LOGS).glob(f"rule_*/*/{job}.log") for line in _lines(log)]
    errors = "; ".join(dict.fromkeys(match[1].strip("* ") for line in lines if (match := _SLURM_ERROR.match(line))))
    if not state:
        return ""
    remedy = next((text for sign, text in _REMEDIES.items() if re.search(sign, f"{state} {errors}", re.IGNORECASE)), "")
    return f"Slurm ended job {job}: {state}{f': {errors}' if errors else ''}{f'; {remedy}' if remedy else ''}"


def _state(job: str) -> str:
    """Return Slurm's state of an ended job, with its reason; empty if it ended by itself, or has not ended."""
    try:
        found = queue.ask(["scontrol", "--oneliner", "show", "job", job])
        state, reason, status = (re.search(rf"\b{key}=(\S+)", found) for key in ("JobState", "Reason", "ExitCode"))
        words = [match[1] if match else "" for match in (state, reason, status)]
    except RunError:  # scontrol has no record of old jobs
        if shutil.which("sacct") is None:
            return ""
        try:
            lines = queue.ask(["sacct", "-X", "-n", "-P", "-j", job, "-o", "State,Reason,ExitCode"]).splitlines()
        except RunError:  # there is no accounting
            return ""
        words = lines[-1].split("|") if lines else ["", "", ""]
    state_word, reason_word, code = words
    if state_word in _OF_ITSELF or (state_word == "FAILED" and code.endswith(":0")):
        return ""
    return state_word if reason_word in ("None", "") else f"{state_word} ({reason_word})"


def _lines(log: Path) -> list[str]:
    try:
        return log.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return []
