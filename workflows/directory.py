"""What may be done in an output directory: start, go on, or leave it alone. Nothing is ever overwritten unasked."""

from __future__ import annotations

import contextlib
import fcntl
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from granwave.lammps_inputs.case import Case, load_case
from granwave.lammps_inputs.deck import CASE_FILE, DATA_FILE, DUMPS, SCRIPT_FILE
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.plan import check_memory, plan
from granwave.workflows import checkpoint, record
from granwave.workflows.mpi import on_first

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
    return [name for name in _RESULTS if (directory / name).exists()]


def refuse_results(directory: Path) -> None:
    """Raise InputError where a directory holds results."""
    found = results_in(directory)
    if found:
        raise InputError(
            f"{directory}: already holds results ({', '.join(found[:3])}{', ...' if len(found) > 3 else ''}); "
            "--resume goes on with them, --force replaces them, or choose another directory with -o"
        )


def decide(case: Case, directory: Path, *, resume: bool, force: bool, n_ranks: int) -> str:
    """What to do in ``directory``: START, CONTINUE from its checkpoint, ANALYSE, or nothing (FINISHED).

    Changes nothing.

    Raises
    ------
    InputError
        It holds results and neither resume nor force was given, holds another case, or the machine is too small.
    """
    if resume and force:
        raise InputError(
            "--resume and --force exclude each other: one goes on with what is there, the other replaces it"
        )
    if directory.exists() and not directory.is_dir():
        raise InputError(f"{directory}: is a file, expected a directory; choose another with -o")
    if resume and (directory / CASE_FILE).exists():
        _same_case(case, directory)
        seen = record.read(directory)
        if seen and seen.state == record.FINISHED:
            return FINISHED if (directory / "summary.json").exists() else ANALYSE
        if seen and seen.state == record.INTEGRATED:
            return ANALYSE
        if seen and checkpoint.usable(directory, seen.checkpoint):
            return CONTINUE
    elif not force:
        refuse_results(directory)
    _check_machine(case, directory, n_ranks)
    return START


def clear(directory: Path) -> None:
    """Remove the results that a directory holds, and nothing else."""
    for name in results_in(directory):
        path = directory / name
        shutil.rmtree(path) if path.is_dir() else path.unlink()
    checkpoint.keep_only(directory, None)


def _same_case(case: Case, directory: Path) -> None:
    there = load_case(directory / CASE_FILE).to_dict()
    here = case.to_dict()
    if there != here:
        keys = sorted(name for name in {*there, *here} if there.get(name) != here.get(name))
        raise InputError(
            f"{directory}: holds another case (different: {', '.join(keys)}); --force replaces it, or choose another "
            "directory with -o"
        )


def _check_machine(case: Case, directory: Path, n_ranks: int) -> None:
    expected = plan(case, n_ranks=n_ranks)
    check_memory(expected)
    place = next(path for path in (directory, *directory.parents) if path.exists())
    free = shutil.disk_usage(place).free
    if expected.disk > free:
        raise InputError(
            f"{directory}: the results need about {expected.disk / 1e9:.3g} GB, {free / 1e9:.3g} GB are free there; "
            "choose another directory with -o, or fewer run.frames"
        )


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
