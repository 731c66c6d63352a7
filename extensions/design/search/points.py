"""Runs of designs on this machine: several at once, each in a separate directory, stopped and
resumed like any run.

A run on one rank is made by a forked copy of this process, which has loaded all modules; a run on
several ranks by mpiexec. If MPI was started in this process (in Python, after a run), a new process
is used, because a copy must not share MPI. In a job of Slurm on several nodes each run is a step of
that job, which srun starts where there is room.
"""

from __future__ import annotations

import dataclasses
import os
import signal
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO, Any

import tomli_w

from granwave.analysis.figures.side_by_side import PROCESSES
from granwave.lammps_inputs.files import replace_text
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.result_directory import ResultDirectory, case_digest
from granwave.lammps_inputs.run_directory import (
    POINT_CASE,
    POINT_FILES,
    POINT_LOG,
    POINT_STOP,
    POINTS,
)
from granwave.workflows.run import forks, mpi, record
from granwave.workflows.run.directory import RunDirectory
from granwave.workflows.run.launchers import of_this_machine

_POLL = 0.05  # time between checks of the runs, s
# command of a step of the Slurm job in which this process runs
_STEP = ("srun", "--mpi=pmi2", "--exact", "-N", "1")


@dataclasses.dataclass(frozen=True)
class Ended:
    """A run that has ended.

    Attributes
    ----------
    summary
        Content of summary.json; empty if the run failed or was interrupted.
    reason
        Reason of a failure; empty without.
    """

    name: str
    summary: Mapping[str, Any]
    reason: str
    interrupted: bool
    seconds: float


class Points:
    """Runs in work.

    Parameters
    ----------
    results
        Directory of the search; the runs are in a folder of it.
    ranks
        MPI ranks of each run.
    """

    def __init__(self, results: ResultDirectory, ranks: int) -> None:
        self.results = results
        self.folder = results / POINTS
        self.ranks = ranks
        self._running: dict[str, tuple[int, float]] = {}  # process id and start time, by name
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        os.environ[PROCESSES] = "1"  # other runs use the other cores

    def __len__(self) -> int:
        return len(self._running)

    def start(self, name: str, tables: Mapping[str, Any]) -> None:
        """Start the run of a case, or resume it in its directory."""
        place = self.folder / name
        place.mkdir(parents=True, exist_ok=True)
        self.results.claim([f"{self.folder.name}/{name}/"])
        results = RunDirectory(place)
        results.claim(POINT_FILES)
        (place / POINT_STOP).unlink(missing_ok=True)
        tables = case_from_dict(
            {**tables, "name": f"{self.folder.parent.name}-{name}"}, place / POINT_CASE
        ).to_dict()
        replace_text(place / POINT_CASE, tomli_w.dumps(tables))
        previous = results.tables_as_run()
        if previous is not None and case_digest(previous) != case_digest(tables):
            results.clear()
        words = [
            "run",
            str(place / POINT_CASE),
            "-o",
            str(place),
            "--no-figures",
            "--resume",
        ]
        with (place / POINT_LOG).open("wb") as log:
            if self.ranks > 1 or nodes_of_job() > 1 or _mpi_started():
                self._processes[name] = self._launch(words, place, log)
                process = self._processes[name].pid
            else:
                process = forks.fork(lambda: _run(tables, place), log.fileno())
        self._running[name] = (process, time.monotonic())

    def _launch(self, words: Sequence[str], place: Path, log: IO[bytes]) -> subprocess.Popen[bytes]:
        """Start a command of granwave in a separate process, or on several ranks."""
        environment = mpi.alone()
        if nodes_of_job() > 1:
            command = mpi.command(self.ranks, words, _STEP)
        else:
            environment = of_this_machine(environment)
            command = [*mpi.PYTHON, "-m", "granwave.workflows", *words]
            if self.ranks > 1:
                command = mpi.command(self.ranks, words, ())
        environment[mpi.STOP_FILE] = str(place / POINT_STOP)
        environment[mpi.EXPECTED_RANKS] = str(self.ranks)
        return subprocess.Popen(
            command,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
            start_new_session=True,  # Ctrl-C would end the ranks without a checkpoint
            preexec_fn=mpi.end_with_parent,
        )

    def wait(self) -> list[Ended]:
        """Wait until a run ends, or for a moment; return the runs that have ended."""
        time.sleep(_POLL)
        ended = []
        for name, (process, begin) in list(self._running.items()):
            if name in self._processes:
                status = self._processes[name].poll()
            else:
                ended_id, waited = os.waitpid(process, os.WNOHANG)
                status = os.waitstatus_to_exitcode(waited) if ended_id else None
            if status is not None:
                self._processes.pop(name, None)
                del self._running[name]
                ended.append(self._ended(name, status, time.monotonic() - begin))
        return ended

    def _ended(self, name: str, status: int, seconds: float) -> Ended:
        place = self.folder / name
        results = RunDirectory(place)
        state = results.read_record()
        log = place / POINT_LOG
        stopped = state is not None and state.state == record.INTERRUPTED
        if stopped or status in (130, -signal.SIGTERM, -signal.SIGINT):
            return Ended(name, {}, "", True, seconds)
        if status == 0:
            return Ended(name, results.summary(), "", False, seconds)
        reason = "energy balance error too large"
        if state is None or state.state != record.REFUSED:
            lines = log.read_text(encoding="utf-8", errors="replace").strip().splitlines()
            last = lines[-1].removeprefix("granwave: ") if lines else f"ended with status {status}"
            reason = (state.reason if state is not None else "") or last
        return Ended(name, {}, reason, False, seconds)

    def stop(self) -> None:
        """Ask all runs to write a checkpoint and to end."""
        for name, (process, _) in self._running.items():
            if name in self._processes:
                (self.folder / name / POINT_STOP).touch()
            else:
                os.kill(process, signal.SIGTERM)


def _mpi_started() -> bool:
    module = sys.modules.get("mpi4py.MPI")
    return bool(module and module.Is_initialized())


def nodes_of_job() -> int:
    """Return the number of nodes of the Slurm job of this process; 1 without a job."""
    return int(os.environ.get("SLURM_JOB_NUM_NODES", 1))


def default_jobs(ranks: int) -> int:
    """Return the default number of simultaneous runs: cores of this machine, or tasks of the job,
    divided by the ranks.
    """
    n_tasks = len(os.sched_getaffinity(0))
    if nodes_of_job() > 1:
        n_tasks = int(os.environ.get("SLURM_NTASKS", 1))
    return max(1, n_tasks // ranks)


def load() -> None:
    """Import the modules that runs need, without starting MPI: each run starts MPI itself."""
    if not _mpi_started():
        forks.load()


def _run(tables: Mapping[str, Any], place: Path) -> int:
    from granwave.workflows.run.driver import run_case

    try:
        case = case_from_dict(tables, place / POINT_CASE)
        outcome = run_case(case, place, resume=True, figures=False)
    except BaseException as error:
        print(f"granwave: {type(error).__name__}: {error}", file=sys.stderr)
        return 1
    return {record.FINISHED: 0, record.INTERRUPTED: 130}.get(outcome.state, 1)


def names(number: int, samples: Sequence[object]) -> list[str]:
    """Return the names of the directories of the runs of a design."""
    if len(samples) == 1:
        return [f"{number}"]
    return [f"{number}-{n}" for n in range(1, len(samples) + 1)]
