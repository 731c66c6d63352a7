"""Jobs of single commands: ``granwave run CASE --submit`` makes NAME.job next to the directory NAME
of the results, with script, logs, and a record of the jobs.

A chain is several jobs, each of which waits for the end of the previous job and continues from
its checkpoint; all are submitted at the start, because submission from compute nodes is often not
allowed. When the work is done, the remaining jobs end at once.
"""

from __future__ import annotations

import dataclasses
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.errors import InputError, RunError
from granwave.lammps_inputs.files import read_json, replace_text
from granwave.workflows.cluster.profile import Profile
from granwave.workflows.cluster.scheduler import JobRequest
from granwave.workflows.cluster.schedulers import scheduler
from granwave.workflows.run import mpi

SUFFIX = ".job"
RECORD = "job.json"
SCRIPT = "script.sh"
ENDED = "ended"  # file: the work is done, or cannot be done
FAILURES = "failures"  # file: number of jobs whose command has failed
_MOST_FAILURES = 2


@dataclasses.dataclass(frozen=True, kw_only=True)
class CommandJob:
    """A command of granwave that runs as a job.

    Attributes
    ----------
    name
        Name of the job.
    directory
        Directory of the results.
    words
        Words of the command line behind ``granwave``.
    ranks
        MPI ranks of the command.
    cores
        Cores of the job; None: one for each rank.
    wall_time, longest
        Expected and longest wall time, s.
    memory
        Expected memory on a node, bytes.
    chain
        Number of jobs, one after the other.
    files
        Files of the folder that the command reads: texts by name.
    """

    name: str
    directory: Path
    words: Sequence[str]
    ranks: int
    cores: int | None = None
    wall_time: float
    longest: float
    memory: float
    chain: int = 1
    files: dict[str, str] = dataclasses.field(default_factory=dict)

    @property
    def folder(self) -> Path:
        """Folder of script, logs and record."""
        return folder_of(self.directory)

    def request(self, profile: Profile, after: tuple[str, ...] = ()) -> JobRequest:
        """Return the request of a job; ``after`` are jobs that must have ended before."""
        cores = self.cores or self.ranks
        request = profile.request(
            f"granwave-{self.name}",
            [*mpi.PYTHON, "-m", "granwave.workflows.cli.job", str(self.folder)],
            ranks=cores,
            minutes=profile.minutes(self.wall_time, self.longest),
            memory=self.memory,
            logs=".",
            directory=self.folder,
            after=after,
        )
        return dataclasses.replace(request, is_step=self.cores is None)

    def script(self, profile: Profile) -> str:
        """Return the script of the first job; raise InputError as `Scheduler.script`."""
        return profile.script(self.request(profile))


def folder_of(directory: Path) -> Path:
    """Return the folder of the jobs whose results are in a directory."""
    return directory.with_name(directory.name + SUFFIX)


def check_folder(directory: Path) -> None:
    """Check that jobs for a directory can be submitted.

    Raises
    ------
    InputError
        A job for it is in the queue, or the folder of its jobs holds something else.
    """
    folder = folder_of(directory)
    if not folder.exists():
        return
    record = read_json(folder / RECORD)
    if record is None:
        if folder.is_dir() and not any(folder.iterdir()):
            return
        raise InputError(
            f"{folder}: found something else, expected the script and logs of the job; move it "
            "away, or choose another directory with directory=..."
        )
    queue = scheduler(record["scheduler"], record.get("status", "squeue"))
    try:
        waiting = queue.queue()
    except RunError as error:
        raise InputError(f"{folder}: {error}") from None
    unended = [job for job in record["jobs"] if job in waiting]
    if unended:
        raise InputError(
            f"{directory}: its job {', '.join(unended)} is in the queue; wait for it, or cancel it "
            f"({shown_cancel(queue.commands, unended)})"
        )


def shown_cancel(commands: Any, jobs: Sequence[str]) -> str:
    """Return the command line that cancels jobs."""
    return " ".join([*commands.delete_job_command, *jobs])


def submit(job: CommandJob, profile: Profile) -> list[str]:
    """Submit the jobs of a command; return their ids.

    Raises
    ------
    RunError
        The scheduler rejects the first job; the following jobs are then missing from the record.
    """
    folder = job.folder
    folder.mkdir(parents=True, exist_ok=True)
    for name in (ENDED, FAILURES):
        (folder / name).unlink(missing_ok=True)
    for name, text in job.files.items():
        replace_text(folder / name, text)
    record = {
        "words": list(job.words),
        "ranks": job.ranks,
        "launcher": profile.launcher_words(job.ranks),
        "scheduler": profile.scheduler,
        "status": profile.status,
        "python": sys.version.split()[0],
        "jobs": [],
    }
    jobs: list[str] = []
    for _ in range(job.chain):
        script = profile.script(job.request(profile, after=tuple(jobs[-1:])))
        if not jobs:
            replace_text(folder / SCRIPT, script)
            replace_text(folder / RECORD, json.dumps(record, indent=1) + "\n")
        try:
            jobs.append(profile.queue.submit(script, folder))
        except RunError as error:
            queue = profile.queue
            raise RunError(f"{queue.title} rejected the job: {queue.refusal(error)}") from None
        replace_text(folder / RECORD, json.dumps({**record, "jobs": jobs}, indent=1) + "\n")
    return jobs


def is_ended(folder: Path) -> bool:
    """Return True if nothing is left to do for the jobs of a folder."""
    return (folder / ENDED).exists()


def note_end(folder: Path, status: int) -> None:
    """Note the exit status of the command of a job: 0 and 2 are final, and a second failure.

    An interrupted command (130) and a killed command continue in the next job.
    """
    final = status in (0, 2)
    if status == 1:
        failures = _failures(folder) + 1
        replace_text(folder / FAILURES, f"{failures}\n")
        final = failures >= _MOST_FAILURES
    if final:
        replace_text(folder / ENDED, f"{status}\n")


def _failures(folder: Path) -> int:
    try:
        return int((folder / FAILURES).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return 0
