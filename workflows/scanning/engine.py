"""Jobs of a scan, one for each batch: processes on this machine, or jobs of the scheduler of a
cluster; as many at once as resources allow.
"""

from __future__ import annotations

import contextlib
import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.errors import RunError
from granwave.lammps_inputs.files import available_memory, replace_text
from granwave.workflows.cluster.profile import Profile
from granwave.workflows.cluster.scheduler import JobRequest
from granwave.workflows.cluster.schedulers import SCHEDULERS
from granwave.workflows.run import mpi
from granwave.workflows.scanning import layout
from granwave.workflows.scanning.batches import Batch
from granwave.workflows.scanning.queue import jobs_of, note_submitted, warn_of_pending

LOCAL = "local"
EXECUTORS = (LOCAL, *SCHEDULERS)
# s between checks of processes, and of the queue
_POLL = 0.3
_QUEUE_POLL = 2.0
_PATIENCE = 60.0  # s that running jobs have to stop after a request
_SCRIPT = "script.sh"  # script of the jobs of a batch, in the folder of their logs
_SETTINGS = {"OMP_NUM_THREADS": "1", mpi.SAFE_PATH: "1"}  # environment variables of all jobs


class Jobs:
    """Jobs of one round; if a job was killed, its batch gets another job.

    Parameters
    ----------
    directory
        Directory of the scan.
    batches
        Batches of points, the longest first.

    Attributes
    ----------
    waiting
        Batches without a job so far.
    refusal
        Reason why no job can be started for them; empty if jobs can be started.
    """

    def __init__(self, directory: Path, batches: Iterable[Batch]) -> None:
        self.directory = directory
        self.waiting = list(batches)
        self.refusal = ""
        self._live: dict[Any, Batch] = {}  # batches by process, or by id of the job
        self._repeated: set[str] = set()

    def running(self) -> bool:
        """Start the jobs for which there is room; return True if jobs are running or pending."""
        for job in self._ended():
            batch = self._live.pop(job)
            if batch.id not in self._repeated and not all(
                layout.is_final(self.directory, p.id) for p in batch.points
            ):
                self._repeated.add(batch.id)
                self.waiting.insert(0, batch)
        for batch in [*self.waiting]:
            if self._has_room(batch) and (job := self._start(batch)) is not None:
                self._live[job] = batch
                self.waiting.remove(batch)
        return bool(self._live) or (bool(self.waiting) and not self.refusal)

    def stop(self, in_haste: Callable[[], bool]) -> None:
        """Start no further job, and wait until the running jobs have stopped at the request of a
        file.

        Parameters
        ----------
        in_haste
            Function that returns True when there is no more time to wait.
        """
        self._repeated |= {batch.id for batch in self._live.values()}
        self.waiting.clear()
        while self.running() and not in_haste():
            time.sleep(_POLL)

    def kill(self) -> None:
        """Kill the points that are still running on this machine."""

    def _ended(self) -> list[Any]:
        raise NotImplementedError

    def _has_room(self, batch: Batch) -> bool:
        raise NotImplementedError

    def _start(self, batch: Batch) -> Any:
        """Start a job and return its identifier; None if no job can be started now."""
        raise NotImplementedError


class LocalJobs(Jobs):
    """Jobs on a number of cores of this machine, within its memory."""

    def __init__(self, directory: Path, batches: Sequence[Batch], cores: int) -> None:
        super().__init__(directory, batches)
        self._cores = cores
        self._memory = max(available_memory(), *(batch.memory for batch in batches))

    def kill(self) -> None:
        """Kill the processes of all jobs."""
        for process in self._live:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()

    def _ended(self) -> list[Any]:
        return [process for process in self._live if process.poll() is not None]

    def _has_room(self, batch: Batch) -> bool:
        batches = [batch, *self._live.values()]
        cores = sum(min(one.ranks, self._cores) for one in batches)
        return cores <= self._cores and sum(one.memory for one in batches) <= self._memory

    def _start(self, batch: Batch) -> Any:
        with (self.directory / layout.LOGS / f"{batch.id}.log").open("ab") as log:
            # a new session: Ctrl-C reaches only the driver, which stops the jobs with checkpoints
            return subprocess.Popen(
                _worker(batch), cwd=self.directory, env=_environment() | {layout.DRIVER: str(os.getpid())},
                stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True,
            )  # fmt: skip


class ClusterJobs(Jobs):
    """Jobs of the scheduler of a cluster, with the number of simultaneous jobs in the profile;
    ``name`` is the name of the scan.
    """

    def __init__(
        self, directory: Path, batches: Sequence[Batch], at_once: int, profile: Profile, name: str
    ) -> None:
        super().__init__(directory, batches)
        self._at_once = at_once
        self._profile = profile
        self._queue = profile.queue
        self._name = name
        self._asked = -math.inf  # time of the last query of the queue
        self._reported: set[str] = set()  # reasons of pending jobs
        self._submitted: dict[str, float] = {}  # times, by id

    def running(self) -> bool:
        """Start jobs for which there is room, and ask for the states of all jobs at intervals;
        between these requests return the last answer.
        """
        if time.monotonic() > self._asked + _QUEUE_POLL:
            self._unended = super().running()
            self._asked = time.monotonic()
        return self._unended

    def stop(self, in_haste: Callable[[], bool]) -> None:
        """Withdraw pending jobs, and wait for the others; then cancel them."""
        self._queue.cancel(job.id for job in jobs_of(self.directory, self._queue) if job.pending)
        patience = time.monotonic() + _PATIENCE
        while jobs := jobs_of(self.directory, self._queue):
            if time.monotonic() > patience or in_haste():
                self._queue.cancel(job.id for job in jobs)
                return
            time.sleep(_QUEUE_POLL)

    def _ended(self) -> list[Any]:
        if not self._live:
            return []
        try:
            warn_of_pending(self._live, self._queue, self._name, self._reported)
            unended = self._queue.queue()
        except RunError:  # unknown
            return []
        return [job for job in self._live if job not in unended and not self._is_new(job)]

    def _is_new(self, job: str) -> bool:
        """Return True for a job that the scheduler may not list yet."""
        return time.monotonic() < self._submitted[job] + self._queue.listed_after

    def _has_room(self, batch: Batch) -> bool:
        return len(self._live) < self._at_once and not self.refusal

    def _start(self, batch: Batch) -> Any:
        logs = self.directory / layout.LOGS / batch.id
        logs.mkdir(exist_ok=True)
        script = self._profile.script(request_of(self._profile, batch, self._name, self.directory))
        replace_text(logs / _SCRIPT, script)
        try:
            job = self._queue.submit(script, self.directory)
        except RunError as error:
            if not self._live:  # otherwise there may be a limit, and capacity later
                self.refusal = self._queue.refusal(error)
            return None
        note_submitted(self.directory, job, batch.id)
        self._submitted[job] = time.monotonic()
        return job


def request_of(profile: Profile, batch: Batch, name: str, directory: Path) -> JobRequest:
    """Return the request of the job of a batch of the scan ``name`` in a directory."""
    variables = [f"{key}={value}" for key, value in _SETTINGS.items()]
    return profile.request(
        f"granwave-{name}",
        ["env", *variables, *_worker(batch)],
        ranks=batch.ranks,
        minutes=profile.minutes(batch.wall_time, batch.longest),
        memory=batch.memory_on(profile.nodes_of(batch.ranks)),
        logs=f"{layout.LOGS}/{batch.id}",
        directory=directory,
    )


def _worker(batch: Batch) -> list[str]:
    return [
        sys.executable,
        "-P",
        "-m",
        "granwave.workflows.cli.worker",
        f"{layout.BATCHES}/{batch.id}.json",
    ]


def _environment() -> dict[str, str]:
    return {**mpi.alone(), **_SETTINGS}
