"""The directory of a run: whether to start, go on, or leave it alone, by the rules of `lammps_inputs.directories`."""

from __future__ import annotations

import contextlib
import fcntl
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from granwave.lammps_inputs import directories
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.deck.deck import CASE_FILE, DATA_FILE, DUMPS, SCRIPT_FILE
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import load_case
from granwave.lammps_inputs.planning.plan import check_memory, plan
from granwave.workflows.run import checkpoint, record
from granwave.workflows.run.mpi import on_first

if TYPE_CHECKING:
    from mpi4py.MPI import Intracomm

START, CONTINUE, ANALYSE, FINISHED = "start", "continue", "analyse", "finished"

_RESULTS = (
    CASE_FILE,
    SCRIPT_FILE,
    DATA_FILE,
    DUMPS,
    "log.lammps",
    "result.h5",
    "summary.json",
    "figures",
    "export",
    record.FILE,
)
_LOCK = ".granwave-lock"


def results_in(directory: Path) -> list[str]:
    """Names of the results that a directory holds."""
    return directories.results_in(directory, _RESULTS)


def refuse_results(directory: Path, ways: str) -> None:
    """Raise InputError where a directory holds results; ``ways`` are those that lead on."""
    directories.refuse_results(directory, _RESULTS, ways)


def decide(case: Case, directory: Path, *, resume: bool, force: bool, n_ranks: int) -> str:
    """What to do in ``directory``: START, CONTINUE from its checkpoint, ANALYSE, or nothing (FINISHED).

    Changes nothing.

    Raises
    ------
    InputError
        It holds results and neither resume nor force was given, holds another case, or the machine is too small.
    """
    if directories.decide(directory, _RESULTS, resume=resume, force=force, case=case.to_dict(), read=_case_there):
        seen = record.read(directory)
        if seen and seen.state == record.FINISHED:
            return FINISHED if (directory / "summary.json").exists() else ANALYSE
        if seen and seen.state == record.INTEGRATED:
            return ANALYSE
        if seen and checkpoint.usable(directory, seen.checkpoint):
            return CONTINUE
    expected = plan(case, n_ranks=n_ranks)
    check_memory(expected)
    directories.check_disk(directory, expected.disk)
    return START


def clear(directory: Path) -> None:
    """Remove the results that a directory holds, and nothing else."""
    directories.clear(directory, _RESULTS)
    checkpoint.keep_only(directory, None)


def _case_there(path: Path) -> dict[str, Any]:
    return load_case(path).to_dict()


def busy(directory: Path) -> bool:
    """Another process holds the directory."""
    try:
        with (directory / _LOCK).open("r") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        pass
    return False


@contextlib.contextmanager
def held(directory: Path, comm: Intracomm | None = None) -> Iterator[None]:
    """Keep other runs out of a directory for as long as this lasts.

    Parameters
    ----------
    comm
        All ranks take part; None for a program that has no MPI.

    Raises
    ------
    InputError
        Another run is at work in it, or it cannot be written to.
    """

    def take() -> int | None:
        try:
            directory.mkdir(parents=True, exist_ok=True)
            lock = (directory / _LOCK).open("w")
        except OSError as error:
            raise InputError(f"{directory}: cannot be written to: {error.strerror}; choose another with -o") from None
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            lock.close()
            raise InputError(
                f"{directory}: another run or scan is at work there; wait for it, or choose another with -o"
            ) from None
        locks.append(lock)
        return None

    locks: list = []
    on_first(comm, take) if comm is not None else take()
    try:
        yield
    finally:
        for lock in locks:
            (directory / _LOCK).unlink(missing_ok=True)
            lock.close()
        with contextlib.suppress(OSError):
            if comm is None or comm.rank == 0:
                directory.rmdir()  # only where nothing came of it
