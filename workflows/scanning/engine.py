"""Jobs of a scan, one for each batch: processes on this machine, or jobs of Slurm; as many at once
as have room.
"""

from __future__ import annotations

import contextlib
import math
import os
import re
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.errors import RunError
from granwave.lammps_inputs.files import available_memory
from granwave.workflows.run import mpi
from granwave.workflows.scanning import layout, slurm
from granwave.workflows.scanning.batches import Batch
from granwave.workflows.scanning.slurm import Profile

LOCAL = "local"
SLURM = "slurm"
EXECUTORS = (LOCAL, SLURM)
# s between checks of processes, and of the queue
_POLL = 0.3
_QUEUE_POLL = 2.0
_PATIENCE = 60.0  # s that running jobs have to stop after a request
_LEAST_MINUTES = 10  # shortest default time limit
_LEFT_ALONE = 30  # s that ranks may go on after one has died
_WARNING = 90  # s before the time limit at which points write checkpoints


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
        Reason why no job can be started for them; empty if they can.
    """

    def __init__(self, directory: Path, batches: Iterable[Batch]) -> None:
        self.directory = directory
        self.waiting = list(batches)
        self.refusal = ""
        self._live: dict[Any, Batch] = {}  # by process, or by id of the job
        self._repeated: set[str] = set()

    def running(self) -> bool:
        """Start the jobs that have room; return True while jobs are running or pending."""
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
        """Start no further job, and wait until the running ones have stopped, which a file has
        asked for.

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
        """Kill what still runs on this machine."""

    def _ended(self) -> list[Any]:
        raise NotImplementedError

    def _has_room(self, batch: Batch) -> bool:
        raise NotImplementedError

    def _start(self, batch: Batch) -> Any:
        """Start a job and return its identifier; None if no job can be started now."""
        raise NotImplementedError


class LocalJobs(Jobs):
    """Jobs on so many cores of this machine, and in its memory."""

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


class SlurmJobs(Jobs):
    """Jobs of Slurm, so many at once, by the profile of a cluster; ``name`` is the name of the
    scan.
    """

    def __init__(
        self, directory: Path, batches: Sequence[Batch], at_once: int, profile: Profile, name: str
    ) -> None:
        super().__init__(directory, batches)
        self._at_once = at_once
        self._profile = profile
        self._name = name
        self._asked = -math.inf  # time of the last look at the queue
        self._reported: set[str] = set()  # reasons of pending jobs

    def running(self) -> bool:
        """Do so for all jobs at once, from time to time; return the answer of the last time in
        between.
        """
        if time.monotonic() > self._asked + _QUEUE_POLL:
            self._unended = super().running()
            self._asked = time.monotonic()
        return self._unended

    def stop(self, in_haste: Callable[[], bool]) -> None:
        """Take pending jobs back, and wait for the others; then cancel them."""
        slurm.cancel([job for job in slurm.jobs_of(self.directory) if job.pending])
        patience = time.monotonic() + _PATIENCE
        while jobs := slurm.jobs_of(self.directory):
            if time.monotonic() > patience or in_haste():
                return slurm.cancel(jobs)
            time.sleep(_QUEUE_POLL)

    def _ended(self) -> list[Any]:
        if not self._live:
            return []
        try:
            slurm.warn_of_pending(self.directory, self._name, self._reported)
            return list(slurm.ended(self._live, self._profile.status))
        except RunError:  # unknown
            return []

    def _has_room(self, batch: Batch) -> bool:
        return len(self._live) < self._at_once and not self.refusal

    def _start(self, batch: Batch) -> Any:
        logs = self.directory / layout.LOGS / batch.id
        logs.mkdir(exist_ok=True)
        command, script = submission(self._profile, batch, self._name)
        environment = {
            name: value for name, value in _environment().items() if not name.startswith("SLURM_")
        }
        try:
            return (
                slurm.ask(command, input=script, env=environment, cwd=self.directory)
                .strip()
                .partition(";")[0]
            )
        except RunError as error:
            if not self._live:  # otherwise there may be a limit, and room later
                lines = str(error).removeprefix("sbatch failed: ").split("sbatch: error: ")
                self.refusal = "; ".join(
                    dict.fromkeys(filter(None, (line.strip(" .") for line in lines)))
                )
            return None


def submission(profile: Profile, batch: Batch, name: str) -> tuple[list[str], str]:
    """Return the command that submits a batch of the scan ``name`` to Slurm, and the script that it
    reads.
    """
    minutes = profile.time or max(
        _LEAST_MINUTES, math.ceil(max(3 * batch.wall_time, batch.longest) / 60)
    )
    given = {"partition": profile.partition, "account": profile.account}
    if batch.ranks > 1:
        given["nodes"] = str(_nodes_of(profile, batch))
    command = [
        "sbatch", "--parsable", "--export=ALL", f"--comment={slurm.COMMENT}{batch.id}",
        f"--job-name=granwave-{re.sub(r'[^A-Za-z0-9]', '', name)}", f"--output={layout.LOGS}/{batch.id}/%j.log",
        *(f"--{option}={value}" for option, value in given.items() if value),
        f"--ntasks={batch.ranks}", f"--time={minutes}", f"--mem={profile.memory or math.ceil(batch.memory / 1e6)}",
        # before the limit, to the job steps and not to the shell, which would end at once
        f"--signal=TERM@{min(_WARNING, minutes * 60 // 3)}", *shlex.split(profile.options),
    ]  # fmt: skip
    step = [] if batch.ranks > 1 else ["srun", "--ntasks=1", "--cpu-bind=q"]
    return (
        command,
        f"#!/bin/bash\nset -euo pipefail\n{profile.before}\nexec {shlex.join([*step, *_worker(batch)])}\n",
    )


def launcher_of(profile: Profile | None, batch: Batch) -> list[str]:
    """Return the command that starts the ranks of a point; empty for the usual one of this machine."""
    words = profile.launcher.split() if profile else []
    if profile and words[0] == "srun":
        words += [f"--wait={_LEFT_ALONE}", "-N", str(_nodes_of(profile, batch))]
    return words


def _nodes_of(profile: Profile, batch: Batch) -> int:
    return min(profile.nodes, batch.ranks)


def _worker(batch: Batch) -> list[str]:
    return [
        sys.executable,
        "-P",
        "-m",
        "granwave.workflows.cli.worker",
        f"{layout.BATCHES}/{batch.id}.json",
    ]


def _environment() -> dict[str, str]:
    return {**mpi.alone(), "OMP_NUM_THREADS": "1", mpi.SAFE_PATH: "1"}
