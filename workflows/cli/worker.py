"""Job of a scan: runs the points of one batch in sequence.

    cd DIR && python -m granwave.workflows.cli.worker .scan/batches/BATCH.json

A point on one rank runs in a forked copy of this process, which has loaded all modules; a point on
several ranks is started by mpiexec or srun. In both cases a crash of one point does not affect the
others. SIGTERM, the stop file of the scan, and the end of the driver of a local scan make the
current point write a checkpoint, and end the job.

Exit status: 0 if every point is done or has failed for good; 1 if some points are unfinished.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import os
import re
import signal
import sys
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import tomli_w

from granwave.analysis.figures.side_by_side import PROCESSES
from granwave.lammps_inputs.directories import disk_space_message, free_space
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import DISK_IS_FULL, read_tables, replace_text
from granwave.lammps_inputs.result_directory import ResultDirectory, case_digest
from granwave.lammps_inputs.run_directory import (
    CASE_FILE,
    POINT_CASE,
    POINT_LOG,
    POINT_STOP,
    SUMMARY_FILE,
)
from granwave.workflows.cli.main import main as granwave
from granwave.workflows.cluster.scheduler import JOB_VARIABLE
from granwave.workflows.cluster.schedulers import scheduler
from granwave.workflows.run import forks, mpi, record
from granwave.workflows.run.directory import RunDirectory
from granwave.workflows.scanning import layout
from granwave.workflows.scanning.queue import end_of
from granwave.workflows.solvers import GRANULAR, solver_of

_POLL = 0.5  # s
_RANK_DIED = re.compile(
    r"(?:EXIT STRING: |^srun: error: .*: tasks? [^:]+: )(.+)"
)  # messages of MPICH and Slurm


def main(arguments: Sequence[str]) -> int:
    """Run a batch; return the exit status."""
    batch = Path(arguments[0])
    worker = _Worker(Path.cwd(), json.loads(batch.read_text(encoding="utf-8")))
    return 1 if worker.work() else 0


class _Worker:
    def __init__(self, directory: Path, batch: dict[str, Any]) -> None:
        self.directory = directory
        self.batch = batch
        self.stopping = threading.Event()
        self.current: int | None = None  # process id of the current point
        self.rank_stop: Path | None = None  # stop file of its ranks
        self.driver = int(os.environ.get(layout.DRIVER, 0))

    def work(self) -> int:
        """Run all points; return the number of points that are neither done nor finally failed."""
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, lambda *_: self.stop())
        for name in set(os.environ) - set(mpi.alone()):
            del os.environ[name]  # the points are not ranks of the program that started this job
        os.environ[PROCESSES] = "1"  # other points use the other cores
        if self._unwanted():
            self.stop()
        elif self.batch["ranks"] == 1:
            self._load()
        threading.Thread(target=self._watch, daemon=True).start()
        points = self.batch["points"]
        for point in points:
            while not self.stopping.is_set() and not layout.is_final(self.directory, point["id"]):
                try:
                    self._attempt(point)
                except OSError as error:
                    if error.errno not in DISK_IS_FULL:
                        raise
                    self._halt("")
        return sum(not layout.is_final(self.directory, point["id"]) for point in points)

    def _load(self) -> None:
        """Load the modules that all points need."""
        kind = solver_of(self.batch["points"][0]["case"])
        if kind is GRANULAR:
            forks.load(figures=self.batch["figures"])
        for module in kind.modules:
            importlib.import_module(module)

    # ------------------------------------------------------------------ stopping

    def stop(self) -> None:
        """Ask the current point to write a checkpoint and stop, and start no further point."""
        self.stopping.set()
        if self.rank_stop is not None:
            self.rank_stop.touch()
        elif self.current is not None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self.current, signal.SIGTERM)

    def _watch(self) -> None:
        while not self.stopping.wait(_POLL):
            if self._unwanted():
                self.stop()

    def _unwanted(self) -> bool:
        return (self.directory / layout.STOP).exists() or (
            self.driver > 0 and not _alive(self.driver)
        )

    # ------------------------------------------------------------------ one point

    def _attempt(self, point: dict[str, Any]) -> None:
        place = layout.unfinished(self.directory, point["id"])
        results = RunDirectory(place)
        while results.busy():  # a worker of an earlier scan is still running
            if self.stopping.wait(_POLL):
                return
        if layout.is_done(self.directory, point["id"]) or not self._room(point):
            return
        seen = layout.state(self.directory, point["id"])
        before = seen.get("attempts", 0)
        begun = results.read_record()
        # finished by a process whose worker was killed
        ended = (begun is not None and begun.state == record.FINISHED) or (
            place / SUMMARY_FILE
        ).exists()
        if (
            before >= layout.MOST_ATTEMPTS and not ended
        ):  # the last worker was killed before it recorded the failure
            job = seen.get("job", "")
            reason = seen.get("reason") or self._end_of(job)
            reason = (
                reason
                or "its job was killed, possibly because memory or the time limit was exceeded"
            )
            layout.change_state(
                self.directory, point["id"], state=layout.FAILED, reason=reason, asked=job
            )
            return
        note = {
            "attempts": before + 1,
            "host": os.uname().nodename,
            "pid": os.getpid(),
            "started": time.time(),
        }
        note |= {"case": case_digest(point["case"]), "job": os.environ.get(JOB_VARIABLE, "")}
        layout.write_state(place, state=layout.RUNNING, **note)
        log_begins = (place / POINT_LOG).stat().st_size if (place / POINT_LOG).exists() else 0
        begin = time.monotonic()
        status = self._run(point, place)
        note["seconds"] = time.monotonic() - begin
        if status == 0:
            layout.write_state(place, state=layout.DONE_STATE, **note)
            try:
                layout.close(self.directory, point["id"])
            except InputError as error:
                layout.write_state(place, state=layout.FAILED, reason=str(error), **note)
        elif status == 130 or (status < 0 and self.stopping.is_set()) or not self._room(point):
            note["attempts"] = before
            layout.write_state(place, state=layout.INTERRUPTED, **note)
            self.stopping.set()
        else:
            reason = _reason(status, place / POINT_LOG, log_begins)
            final = note["attempts"] >= layout.MOST_ATTEMPTS
            layout.write_state(
                place, state=layout.FAILED if final else layout.INTERRUPTED, reason=reason, **note
            )

    def _end_of(self, job: str) -> str:
        """Return why the scheduler ended a job; empty on this machine."""
        name = self.batch.get("scheduler", "")
        return end_of(self.directory, job, scheduler(name)) if job and name else ""

    def _room(self, point: dict[str, Any]) -> bool:
        free = free_space(self.directory)
        if free > point["disk"] + layout.LEAST_FREE:
            return True
        message = disk_space_message(
            "the results of the next point", point["disk"], layout.LEAST_FREE, free
        )
        self._halt(f"{self.directory}: {message}")
        return False

    def _halt(self, reason: str) -> None:
        """Stop the whole scan."""
        stop = self.directory / layout.STOP
        if not stop.exists():
            with contextlib.suppress(OSError):  # on a full disk the existence of the file suffices
                stop.touch()
                stop.write_text(reason, encoding="utf-8")
        self.stopping.set()

    def _run(self, point: dict[str, Any], place: Path) -> int:
        """Run a point; return the exit status of its process, negative if a signal killed it."""
        case = place / POINT_CASE
        replace_text(case, tomli_w.dumps({**point["case"], "name": _name(point, place)}))
        words = [point["verb"], str(case), "-o", str(place), "--resume"]
        words += [] if self.batch["figures"] else ["--no-figures"]
        with (place / POINT_LOG).open("ab") as log:
            if self.batch["ranks"] > 1:
                return self._launch(words, place / POINT_STOP, log.fileno())
            starts_mpi = point["verb"] == GRANULAR.verb
            self.current = forks.fork(lambda: granwave(words), log.fileno(), starts_mpi=starts_mpi)
            if self.stopping.is_set():
                self.stop()
            _, waited = os.waitpid(self.current, 0)
            self.current = None
        return os.waitstatus_to_exitcode(waited)

    def _launch(self, words: Sequence[str], stop: Path, log: int) -> int:
        stop.unlink(missing_ok=True)
        self.rank_stop = stop
        launcher = self.batch.get("launcher", [])
        command = mpi.command(self.batch["ranks"], words, launcher)
        ranks = mpi.start(command, self.batch["ranks"], stop, log, log, launcher=launcher)
        if self.stopping.is_set():
            self.stop()
        status = ranks.wait()
        self.rank_stop = None
        stop.unlink(missing_ok=True)
        return status


def _alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        pass
    return True


def _name(point: dict[str, Any], place: Path) -> str:
    """Return the name of the point's case as first run; clear the directory if its case cannot be
    read.
    """
    results = ResultDirectory(place)
    tables = results.tables_as_run() or read_tables(place / CASE_FILE)
    try:
        if tables is not None:
            return str(solver_of(tables).stored(tables, place / CASE_FILE).name)
    except InputError:
        tables = None
    if (
        tables is None and (place / CASE_FILE).exists()
    ):  # the machine crashed while the file was written
        results.clear()
    return str(point["case"]["name"])


def _reason(status: int, log: Path, begin: int) -> str:
    """Return why a point failed: the last error in its log."""
    with contextlib.suppress(OSError):
        with log.open("rb") as stream:
            stream.seek(begin)
            lines = stream.read().decode("utf-8", "replace").strip().splitlines()
        if errors := mpi.errors_in(lines):
            return errors[-1]
        died = [match[1] for line in lines if (match := _RANK_DIED.search(line))]
        if died:
            return f"a rank died: {died[-1]}; the machine may be out of memory"
        if lines and status > 0:
            return lines[-1]
    if status < 0:
        return (
            f"killed by signal {-status} ({signal.strsignal(-status)}); the machine may be out "
            "of memory"
        )
    return f"ended with status {status}"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
