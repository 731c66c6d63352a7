"""Jobs of a scan in the queue of a cluster: their batches, reasons to wait, and ends.

Each job that is submitted is noted in a file of the scan, with its batch, so that a later driver
finds the jobs of an earlier driver.
"""

from __future__ import annotations

import contextlib
import dataclasses
import logging
from collections.abc import Iterable
from pathlib import Path

from granwave.lammps_inputs.errors import RunError
from granwave.lammps_inputs.files import read_json
from granwave.workflows.cluster.scheduler import PENDING, Scheduler
from granwave.workflows.scanning import layout

logger = logging.getLogger(__name__)


@dataclasses.dataclass(frozen=True)
class QueuedJob:
    """A job of a scan that has not ended."""

    id: str
    pending: bool
    points: tuple[str, ...]


def note_submitted(directory: Path, job: str, batch: str) -> None:
    """Note the job of a batch."""
    with (directory / layout.SUBMITTED).open("a", encoding="utf-8") as file:
        file.write(f"{job} {batch}\n")


def batches_of_jobs(directory: Path) -> dict[str, str]:
    """Return the batch of each job that was submitted."""
    try:
        text = (directory / layout.SUBMITTED).read_text(encoding="utf-8")
    except FileNotFoundError:
        return {}
    rows = (line.split() for line in text.splitlines())
    return {row[0]: row[1] for row in rows if len(row) == 2}


def jobs_of(directory: Path, scheduler: Scheduler) -> list[QueuedJob]:
    """Return the pending and running jobs of a scan, including jobs of earlier drivers.

    Raises
    ------
    RunError
        The scheduler does not answer, so that its jobs are unknown.
    """
    batches = batches_of_jobs(directory)
    if not batches:
        return []
    jobs = []
    for name, state in scheduler.queue().items():
        if name in batches:
            batch = read_json(directory / layout.BATCHES / f"{batches[name]}.json") or {}
            points = tuple(point["id"] for point in batch.get("points", ()))
            jobs.append(QueuedJob(name, state == PENDING, points))
    return jobs


def warn_of_pending(
    jobs: Iterable[str], scheduler: Scheduler, scan: str, reported: set[str]
) -> None:
    """Log unusual reasons why jobs of a scan are pending, unless they are ``reported``, and add
    them.
    """
    reasons = scheduler.reasons()
    for reason in {reasons[job] for job in jobs if job in reasons} - reported:
        reported.add(reason)
        logger.warning(
            "%s: jobs wait in the queue of %s: %s; Ctrl-C cancels them",
            scan,
            scheduler.title,
            reason,
        )


def note_refused(directory: Path, points: Iterable[str], reason: str, scheduler: Scheduler) -> None:
    """Mark points as failed if their jobs could not be submitted, with this reason."""
    text = f"{scheduler.title} did not run the job: {reason}"
    for point in points:
        layout.change_state(directory, point, state=layout.FAILED, reason=text)


def note_ended(directory: Path, points: Iterable[str], scheduler: Scheduler) -> None:
    """Record why the scheduler ended the jobs of unfinished points; a point fails with the second
    such job.
    """
    with contextlib.suppress(RunError):  # without an answer only its reasons are missing
        live: set[str] = set()
        for job in jobs_of(directory, scheduler):
            live |= set(job.points)
        for point in points:
            if point not in live and not layout.is_done(directory, point):
                _note_end(directory, point, scheduler)


def _note_end(directory: Path, point: str, scheduler: Scheduler) -> None:
    """Record why the scheduler ended the job of an unfinished point."""
    state = layout.state(directory, point)
    job = str(state.get("job") or "")
    if not job or state.get("asked") == job:
        return
    reason = end_of(directory, job, scheduler)
    if not reason:
        return
    after = state.get("state")
    if after == layout.RUNNING:
        if state.get("attempts", 0) >= layout.MOST_ATTEMPTS:
            after = layout.FAILED
    else:
        reason = "; ".join(filter(None, (state.get("reason"), reason)))
    layout.change_state(directory, point, asked=job, state=after, reason=reason)


def end_of(directory: Path, job: str, scheduler: Scheduler) -> str:
    """Return why a scheduler ended a job of a scan, as `Scheduler.end_of`."""
    lines: list[str] = []
    for pattern in scheduler.log_patterns:
        for path in (directory / layout.LOGS).glob(f"**/{pattern.format(job=job)}"):
            with contextlib.suppress(OSError):
                lines += path.read_text(encoding="utf-8", errors="replace").splitlines()
    return scheduler.end_of(job, lines)
