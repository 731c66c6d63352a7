"""Directory of a run: start, continue or refuse, by the rules of `lammps_inputs.directories`; and
its lock.
"""

from __future__ import annotations

import contextlib
import fcntl
import logging
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from granwave.lammps_inputs import directories, ownership
from granwave.lammps_inputs import run_directory as files
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.run import FIGURE_NAMES
from granwave.lammps_inputs.contact.initial_dents import dents_table, earlier_result
from granwave.lammps_inputs.deck.deck import deck_files
from granwave.lammps_inputs.errors import InputError, raise_all
from granwave.lammps_inputs.load_case import stored_case
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.planning.plan import afford, check_files, plan
from granwave.lammps_inputs.planning.schedule import Schedule
from granwave.lammps_inputs.processes import ALONE, Processes
from granwave.workflows.run import record
from granwave.workflows.run.mpi import on_first

if TYPE_CHECKING:
    from mpi4py.MPI import Intracomm

logger = logging.getLogger(__name__)

START = "start"
CONTINUE = "continue"
ANALYSE = "analyse"
FINISHED = "finished"


def decide(
    case: Case,
    directory: Path,
    *,
    resume: bool,
    force: bool,
    n_ranks: int,
    figures: bool = True,
    processes: Processes = ALONE,
) -> str:
    """Decide what to do in ``directory``: START, CONTINUE from its checkpoint, ANALYSE, or nothing
    (FINISHED).

    Changes nothing. ``processes`` read the files of the checkpoint.

    Raises
    ------
    InputError
        The directory holds results and neither resume nor force was given; it holds another case,
        or files that granwave did not write and would overwrite; or memory or disk space is
        insufficient.
    """
    expected = plan(case, n_ranks=n_ranks)
    names = run_files(case, expected.schedule)
    if figures:
        names += [files.FILM_FILE.format(case.figures.film)] if case.figures.film != "none" else []
        names += [files.VIEW_FILE] if case.figures.view else []
        if os.path.lexists(directory / files.FIGURES_DIRECTORY):
            names += [file for name in FIGURE_NAMES for file in ownership.figure_files(name)]

    def read(tables: Any) -> dict[str, Any]:
        return _without_figures(stored_case(tables, directory / files.CASE_FILE))

    asked = _without_figures(case)
    if directories.decide(
        directory, files.RUN, names, resume=resume, force=force, case=asked, read=read
    ):
        found = _remaining_work(directory, processes)
        if found == FINISHED:
            return found
        ownership.refuse_foreign(directory, names)
        if found != START:
            return found
    raise_all(
        [
            lambda: check_files(case),
            lambda: afford(expected, directory),
            lambda: directories.refuse_source(directory, case.name, earlier_result(case)),
        ]
    )
    return START


def _remaining_work(directory: Path, processes: Processes) -> str:
    """Decide what remains to be done in the directory of a run of the same case; warn about damaged
    files.

    Raises
    ------
    InputError
        LAMMPS was run on the deck by hand, so that it is unknown whether that run finished.
    """
    marker = ownership.read_marker(directory)
    outputs = [name for name in ownership.output_names(directory) if (directory / name).is_file()]
    if marker.kind and files.RECORD_FILE not in marker.files and outputs:
        raise InputError(
            f"{directory}: holds a deck that LAMMPS was run on by hand, which resume=True cannot go on with: "
            f"granwave analyse {directory}  makes the results, force=True runs the case again"
        )
    there = record.read(directory)
    fault = directories.result_fault(directory)
    seen = there or record.recover(directory) or record.Record(state="")
    if seen.state == record.FINISHED and not fault:
        lost = not (directory / files.RESULT_FILE).exists() and directories.outputs_complete(
            directory
        )
        return ANALYSE if lost else FINISHED
    if seen.state in (record.FINISHED, record.INTEGRATED) and directories.outputs_complete(
        directory
    ):
        way = ANALYSE
    else:
        saved = seen.checkpoint
        useless = record.checkpoint_fault(directory, saved, processes) if saved else ""
        way = CONTINUE if saved and not useless else START
        if useless:
            logger.warning("%s; the run begins again, as its checkpoint is of no use", useless)
    if fault and (there is None or seen.state == record.FINISHED):
        logger.warning(
            "%s; %s", fault, "analysed again" if way == ANALYSE else "the case is run again"
        )
    return way


def _without_figures(case: Case) -> dict[str, Any]:
    """Return the tables that decide the results of a case."""
    return {name: table for name, table in case.to_dict().items() if name != files.FIGURES_TABLE}


def run_files(case: Case, schedule: Schedule) -> list[str]:
    """Return the names of the files of a run, without figures."""
    return [
        *deck_files(assemble(case), schedule),
        files.RECORD_FILE,
        files.RESULT_FILE,
        files.SUMMARY_FILE,
    ]


def start(case: Case, directory: Path) -> None:
    """Remove the results of an earlier run, after checking that the deck can be written; make it a
    run's directory.

    Raises
    ------
    InputError
        The initial dents cannot be read; nothing was removed.
    """
    directories.refuse_source(directory, case.name, earlier_result(case))
    if case.contact.initial_overlap:
        dents_table(assemble(case))
    ownership.clear(directory)
    ownership.claim(directory, [files.RECORD_FILE], kind=files.RUN)


# ---------------------------------------------------------------------- one process at a time


def busy(directory: Path) -> bool:
    """Return True if another process has locked the directory."""
    try:
        with (directory / files.LOCK_FILE).open("r") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        pass
    return False


@contextlib.contextmanager
def held(
    directory: Path, comm: Intracomm | None = None, way: str = "; choose another with directory=..."
) -> Iterator[None]:
    """Lock a directory against other runs within a ``with`` block; create it if necessary.

    Parameters
    ----------
    comm
        Communicator of all ranks, which call this together; None without MPI.
    way
        Advice in the message if the directory cannot be written to.

    Raises
    ------
    InputError
        Another run uses the directory, or it cannot be written to.
    """
    made = [path for path in (directory, *directory.parents) if not path.exists()]
    locks: list[int] = []

    def take() -> None:
        try:
            directory.mkdir(parents=True, exist_ok=True)
            locks.append(_lock(directory / files.LOCK_FILE))
        except BlockingIOError:
            raise InputError(
                f"{directory}: another run or scan is at work there; wait for it, or choose another with directory=..."
            ) from None
        except OSError as error:
            raise InputError(f"{directory}: cannot be written to: {error.strerror}{way}") from None

    on_first(comm, take) if comm is not None else take()
    try:
        yield
    finally:
        for lock in locks:
            (directory / files.LOCK_FILE).unlink(missing_ok=True)
            os.close(lock)
        with contextlib.suppress(OSError):
            for path in made if locks else ():
                path.rmdir()  # succeeds only if still empty


def _lock(path: Path) -> int:
    """Open and lock a file; try again if its previous holder removed it meanwhile."""
    while True:
        lock = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            with contextlib.suppress(FileNotFoundError):
                if os.path.samestat(os.fstat(lock), os.lstat(path)):
                    return lock
        except OSError:
            os.close(lock)
            raise
        os.close(lock)
