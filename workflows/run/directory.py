"""Directory of a run: its record and checkpoint; start, continue or reject, by the rules of
`lammps_inputs.result_directory`; its lock.
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
import logging
import math
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from granwave import __version__
from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.lammps_inputs import run_directory as files
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.figures import figure_names
from granwave.lammps_inputs.case.run import DIVISION_KEYS
from granwave.lammps_inputs.contact.initial_dents import dents_table, earlier_result
from granwave.lammps_inputs.deck.deck import deck_files
from granwave.lammps_inputs.directories import check_disk
from granwave.lammps_inputs.errors import InputError, raise_all
from granwave.lammps_inputs.files import checksum, read_json, replace_text
from granwave.lammps_inputs.load_case import stored_case
from granwave.lammps_inputs.own_files import figure_files
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.planning.plan import check_files, check_memory, plan
from granwave.lammps_inputs.planning.schedule import Schedule
from granwave.lammps_inputs.processes import ALONE, Processes
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.workflows.run import record
from granwave.workflows.run.mpi import on_first

if TYPE_CHECKING:
    from mpi4py.MPI import Intracomm

logger = logging.getLogger(__name__)

_RUN_TABLE = "run"

START = "start"
CONTINUE = "continue"
ANALYSE = "analyse"
FINISHED = "finished"

# in the name of the file that LAMMPS writes next to the parts, in place of the rank
_BASE = "base"
_CHECKPOINT = re.compile(
    re.escape(files.CHECKPOINT_FILE).replace(r"\{\}", rf"\d+(\.({files.RANK}|{_BASE}))?")
)


class RunDirectory(ResultDirectory):
    """Directory of a run by the driver, which also holds its record and checkpoint."""

    def read_record(self) -> record.Record | None:
        """Read the record; None if missing or damaged."""
        return record.record_of(read_json(self / files.RECORD_FILE))

    def write_record(self, content: record.Record) -> None:
        """Replace the record atomically."""
        text = json.dumps(dataclasses.asdict(content), indent=2) + "\n"
        replace_text(self / files.RECORD_FILE, text)

    def recovered_record(self) -> record.Record | None:
        """Read the record in result.h5, as of the analysis; None if there is none."""
        from granwave.analysis.result.reader import (
            Result,
        )  # imported on demand: h5py is slow to load

        try:
            with Result(self) as result:
                return record.record_of(result.record)
        except (MissingOutputError, OutputFormatError, KeyError, ValueError):
            return None

    def keep_checkpoint(self, checkpoint: dict[str, Any] | None) -> None:
        """Remove the restart files of all other checkpoints."""
        kept = checkpoint_files(checkpoint["file"]) if checkpoint else []
        there = [name for name in self.marker.files if _CHECKPOINT.fullmatch(name)]
        self.clear([name for name in there if name not in kept])

    def checkpoint_fault(self, checkpoint: dict[str, Any], processes: Processes = ALONE) -> str:
        """Describe why a run cannot resume from a checkpoint; empty if it can. ``processes`` read
        its files.

        Reasons are another minor version, since restart files may differ, or a file that was
        changed after the run wrote it. Output files may have grown.
        """
        try:
            made = str(checkpoint["version"])
            if made.split(".")[:2] != __version__.split(".")[:2]:
                return (
                    f"{self}: its checkpoint was written by granwave {made}, expected {__version__}"
                )
            return self._changed_since(checkpoint, processes)
        except (AttributeError, KeyError, TypeError):
            return f"{self / files.RECORD_FILE}: its checkpoint cannot be read"

    def _changed_since(self, checkpoint: dict[str, Any], processes: Processes) -> str:
        """Describe the first file that was changed since a checkpoint; empty if none was."""
        whole = checkpoint["whole"]
        sums = checkpoint.get("sums", {})
        sizes = whole | checkpoint["sizes"]
        for name, size in sizes.items():
            path = self / name
            if not path.is_file():
                return f"{path}: is missing"
            now = path.stat().st_size
            if now < size or (now != size and name in whole):
                return f"{path}: has {now} bytes, had {size} at the checkpoint"
        tasks = [(self / name, sizes[name], (0, 0)) for name in sums]
        now_sums = processes.map(sum_of_part, tasks)
        for name, now, before in zip(sums, now_sums, sums.values(), strict=True):
            if now != before:
                return (
                    f"{self / name}: differs from the file that the run wrote: its checksum differs"
                )
        return ""

    def cut_back(self, checkpoint: dict[str, Any]) -> None:
        """Truncate the output files to their sizes at the checkpoint."""
        for name in self.output_names():
            path = self.own_path(name)
            if path is not None and name in checkpoint["sizes"]:
                os.truncate(path, checkpoint["sizes"][name])
            elif path is not None:
                path.unlink()


def checkpoint_files(name: str) -> list[str]:
    """Return the names of the files of a checkpoint: for a checkpoint in parts, also the file next
    to them.
    """
    return list(dict.fromkeys([name, name.replace(files.RANK, _BASE)]))


def sum_of_part(task: tuple[Path, int, tuple[int, int]]) -> int:
    """Return the CRC-32 of the first bytes of a file: path, number of bytes, and size and CRC-32 of
    a part that was read before.
    """
    path, size, after = task
    return checksum(path, size, after=after)


# ---------------------------------------------------------------------- start or resume


def decide(
    assembly: Assembly,
    results: RunDirectory,
    *,
    resume: bool,
    force: bool,
    n_ranks: int,
    figures: bool = True,
    here: bool = True,
    processes: Processes = ALONE,
) -> str:
    """Choose the action for a directory: START, CONTINUE from its checkpoint, ANALYSE, or nothing
    (FINISHED).

    Changes nothing. ``processes`` read the files of the checkpoint. A run that is not made
    ``here``, but by a job on other nodes, needs no memory of this machine.

    Raises
    ------
    InputError
        The directory holds results and neither resume nor force was given; it holds another case,
        or files that granwave did not write and would overwrite; or memory or disk space is
        insufficient.
    """
    case = assembly.case
    check_processors(case, n_ranks)
    expected = plan(assembly, n_ranks=n_ranks)
    names = run_files(assembly, expected.schedule)
    if figures:
        names += case.figures.products.values()
        if os.path.lexists(results / files.FIGURES_DIRECTORY):
            for name in figure_names():
                names.extend(figure_files(name))

    def read(tables: Any) -> dict[str, Any]:
        return _without_figures(stored_case(tables, results / files.CASE_FILE))

    asked = _without_figures(case)
    if results.decide(files.RUN, names, resume=resume, force=force, case=asked, read=read):
        found = _remaining_work(results, processes)
        if found == FINISHED:
            return found
        results.refuse_foreign(names)
        if found != START:
            return found
    raise_all(
        [
            lambda: check_files(assembly),
            lambda: check_disk(results.path, expected.disk, spare=expected.disk_reserve),
            lambda: check_memory(expected) if here else None,
            lambda: results.refuse_source(case.name, earlier_result(case)),
        ]
    )
    return START


def _remaining_work(results: RunDirectory, processes: Processes) -> str:
    """Decide what remains to be done in the directory of a run of the same case; warn about damaged
    files.

    Raises
    ------
    InputError
        LAMMPS was run on the deck by hand, so that it is unknown whether that run finished.
    """
    marker = results.marker
    outputs = [name for name in results.output_names() if (results / name).is_file()]
    if marker.kind and files.RECORD_FILE not in marker.files and outputs:
        raise InputError(
            f"{results}: contains a manual LAMMPS run, which resume=True cannot continue: "
            f"granwave analyse {results}  produces the results, force=True runs the case again"
        )
    there = results.read_record()
    fault = results.fault()
    seen = there or results.recovered_record() or record.Record(state="")
    if seen.state == record.FINISHED and not fault:
        lost = not (results / files.RESULT_FILE).exists() and results.outputs_complete()
        return ANALYSE if lost else FINISHED
    if seen.state in (record.FINISHED, record.INTEGRATED) and results.outputs_complete():
        way = ANALYSE
    else:
        saved = seen.checkpoint
        useless = results.checkpoint_fault(saved, processes) if saved else ""
        way = CONTINUE if saved and not useless else START
        if useless:
            logger.warning(
                "%s; the checkpoint is unusable, so the run restarts from the beginning", useless
            )
    if fault and (there is None or seen.state == record.FINISHED):
        logger.warning(
            "%s; %s", fault, "analysed again" if way == ANALYSE else "the case is run again"
        )
    return way


def _without_figures(case: Case) -> dict[str, Any]:
    """Return the tables that determine the results of a case, without the division of the box."""
    tables = {name: table for name, table in case.to_dict().items() if name != files.FIGURES_TABLE}
    run = tables.get(_RUN_TABLE, {})
    tables[_RUN_TABLE] = {key: value for key, value in run.items() if key not in DIVISION_KEYS}
    return tables


def check_processors(case: Case, n_ranks: int) -> None:
    """Raise `InputError` unless the grid of `run.processors` has a brick for each rank."""
    grid = case.run.processors
    if isinstance(grid, str) or math.prod(grid) == n_ranks:
        return
    raise InputError(
        f"{case.name}: run.processors: found {list(grid)}, {math.prod(grid)} ranks; expected a "
        f"grid of {n_ranks}, the number of ranks of this run (--np)"
    )


def run_files(assembly: Assembly, schedule: Schedule) -> list[str]:
    """Return the names of the files of a run, without figures."""
    return [
        *deck_files(assembly, schedule),
        files.RECORD_FILE,
        files.RESULT_FILE,
        files.SUMMARY_FILE,
    ]


def start(assembly: Assembly, results: RunDirectory, *, force: bool = False) -> None:
    """Prepare the directory for a run, after checking that the LAMMPS input can be written.

    Parameters
    ----------
    force
        True to move earlier results into NAME.old; otherwise they are removed.

    Raises
    ------
    InputError
        The initial dents cannot be read; nothing was removed.
    """
    case = assembly.case
    results.refuse_source(case.name, earlier_result(case))
    if case.contact.initial_overlap:
        dents_table(assembly)
    results.make_room(force=force)
    results.claim([files.RECORD_FILE], kind=files.RUN)


@contextlib.contextmanager
def held(
    results: ResultDirectory,
    comm: Intracomm | None = None,
    way: str = "; choose another with directory=...",
) -> Iterator[None]:
    """Lock a directory against other runs within a ``with`` block; create it if necessary.

    Parameters
    ----------
    comm
        Communicator of all ranks, which call this together: the first takes the lock for all. None
        without MPI.
    way
        Advice in the message if the directory cannot be written to.

    Raises
    ------
    InputError
        Another run uses the directory, or it cannot be written to.
    """
    if comm is None:
        results.lock(way)
    else:
        on_first(comm, lambda: results.lock(way))
    try:
        yield
    finally:
        results.unlock()
