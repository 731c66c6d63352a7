"""One run from case to figures: deck, LAMMPS in pieces, energy balance, checkpoints, analysis.

LAMMPS executes the lines of in.granwave. Only the run section is replaced by pieces of the run; between them the energy
balance is checked, the progress bar is updated, and a request to stop is answered.
"""

from __future__ import annotations

import contextlib
import dataclasses
import logging
import time
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.pipeline import analyse
from granwave.analysis.result.reader import moved_mass
from granwave.analysis.result.writer import BALANCE_REFUSED
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.deck.deck import Deck, read_deck, write_deck
from granwave.lammps_inputs.deck.output import frames_file
from granwave.lammps_inputs.deck.script import READ_DATA, input_script, part
from granwave.lammps_inputs.directories import (
    disk_space_message,
    free_space,
    note_files,
    read_summary,
    restore_case,
    results_directory,
)
from granwave.lammps_inputs.errors import RunError
from granwave.lammps_inputs.ownership import claim, clear, clear_scratch, output_names
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.motion import written_in_parts
from granwave.lammps_inputs.planning.plan import plan
from granwave.lammps_inputs.planning.schedule import BLOCK_THRESHOLD
from granwave.lammps_inputs.processes import Processes
from granwave.lammps_inputs.run_directory import CASE_FILE, DATA_FILE, DUMPS, ENERGY_FILE, LOG_FILE, RESULT_FILE
from granwave.workflows.run import record
from granwave.workflows.run.checks import TOLERANCE, Balance, check_coordination, check_equilibrium, expected_neighbours
from granwave.workflows.run.directory import ANALYSE, CONTINUE, FINISHED, START, decide, held, start
from granwave.workflows.run.initial_state import make_spheres
from granwave.workflows.run.lammps_engine import Engine, SingleRankError, open_engine
from granwave.workflows.run.mpi import StopRequest, abort, nodes, on_first, world
from granwave.workflows.run.progress import Progress, announce
from granwave.workflows.run.ranks import shared
from granwave.workflows.run.record import Record, versions

if TYPE_CHECKING:
    from mpi4py.MPI import Intracomm

logger = logging.getLogger(__name__)

MOST_ATTEMPTS = 4  # timesteps tried if the balance does not close, each half of the previous one
_FIRST_ENDS = 1.0  # s until other ranks end all if the first has not
_PIECE = 1.0  # s of wall time between checks of the balance


@dataclasses.dataclass(frozen=True)
class Outcome:
    """Outcome of a run.

    Attributes
    ----------
    state
        ``finished``, ``interrupted`` or ``refused`` (the energy balance does not close).
    summary
        Content of summary.json, the same on all ranks.
    """

    directory: Path
    state: str
    summary: dict[str, Any]


def run_case(
    case: Case,
    directory: str | Path,
    *,
    resume: bool = False,
    force: bool = False,
    progress: bool = False,
    checkpoint_interval: float = 60.0,
    figures: bool = True,
    comm: Intracomm | None = None,
) -> Outcome:
    """Run a case and analyse it.

    Parameters
    ----------
    directory
        Directory of the results; the page 'What a run leaves' of the documents lists its files.
    resume
        Continue existing results; a finished run is not changed, and an empty directory is a new run.
    force
        Replace existing results.
    progress
        Show a bar (on a terminal) or lines (in a log).
    checkpoint_interval
        Wall time between checkpoints, s.
    figures
        Draw the figures.
    comm
        MPI communicator; by default that of all ranks.

    Raises
    ------
    InputError
        The directory holds results or another case, or memory or disk space is insufficient. Nothing was run.
    RunError
        LAMMPS failed; results so far are kept.
    """
    comm = world() if comm is None else comm
    directory = results_directory(directory)
    options = {"resume": resume, "force": force, "figures": figures, "n_ranks": comm.size}
    with held(directory, comm):
        what = shared(comm, lambda ranks: _prepare(case, directory, processes=ranks, **options))
        run = _Run(case, directory, comm, progress, checkpoint_interval)
        if what == ANALYSE:
            try:
                return run.analyse(figures=figures, take_up=True)
            except (MissingOutputError, OutputFormatError) as error:
                if comm.rank == 0:
                    logger.warning("%s; the case is run again", error)
                on_first(comm, lambda: start(case, directory))
                what, run = START, _Run(case, directory, comm, progress, checkpoint_interval)
        if what == FINISHED:
            return Outcome(directory, record.FINISHED, on_first(comm, lambda: read_summary(directory)))
        if run.show:
            announce(plan(case, n_ranks=comm.size, figures=figures))
        with StopRequest(comm) as stop, contextlib.chdir(directory):
            run.integrate(stop, go_on=what == CONTINUE)
        return run.analyse(figures=figures)


def _prepare(case: Case, directory: Path, **options: Any) -> str:
    """Decide what to do in a directory, and prepare it."""
    what = decide(case, directory, **options)
    if what == START:
        start(case, directory)
    elif restore_case(directory):
        logger.warning("%s was missing or damaged: written again as it was run", directory / CASE_FILE)
    return what


class _Run:
    def __init__(self, case: Case, directory: Path, comm: Intracomm, show: bool, checkpoint_interval: float) -> None:
        self.case, self.directory, self.comm = case, directory, comm
        self.show = show and comm.rank == 0
        self.checkpoint_interval = checkpoint_interval
        self.record = Record(name=case.name, n_ranks=comm.size)
        self.balance = Balance(
            directory / DUMPS / ENERGY_FILE, max(TOLERANCE, case.run.energy_tolerance), moved_mass(assemble(case))
        )
        self.state = record.RUNNING  # of the time integration; recorded after the analysis
        self.reserve = on_first(comm, lambda: plan(case).disk_reserve)  # disk space to keep free, bytes
        self.lost_before_block = 0.0  # dissipated energy at the start of the current block of end_time = "auto", J

    # ------------------------------------------------------------------ attempts

    def integrate(self, stop: StopRequest, *, go_on: bool) -> None:
        """Integrate in time; halve an automatic timestep as long as the balance does not close."""
        if go_on:
            self.record = on_first(self.comm, lambda: record.read(self.directory) or Record())
        timestep = None
        while True:
            deck = self._deck(timestep, go_on)
            try:
                self._attempt(deck, stop, go_on)
            except (RunError, OSError) as error:
                self._fail(error)
            if self.state != record.REFUSED:
                break
            misses = self.balance.error
            chosen = self.case.run.timestep == "auto"
            if not chosen or len(self.record.attempts) + 1 >= MOST_ATTEMPTS:
                self._log(
                    f"the energy balance does not close: {misses:.1e} of the input, "
                    f"{self.balance.accepted:.0e} is accepted"
                    + ("" if chosen else '; give a shorter run.timestep, or leave it to "auto"')
                )
                break
            tried = deck.schedule.first_timestep
            self.record.attempts.append({"timestep_s": tried, "energy_balance_error": misses})
            timestep, go_on = tried / 2, False
            self.balance = Balance(self.balance.path, self.balance.accepted, self.balance.moved)
            self._log(
                f"the energy balance misses by {misses:.1e} of the input; "
                f"once more with half the timestep, {timestep:.3g} s"
            )

        on_first(self.comm, lambda: note_files(self.directory, [DATA_FILE, *output_names(self.directory)]))
        self._note(state=self.state if self.state == record.INTERRUPTED else record.INTEGRATED)

    def _fail(self, error: RunError | OSError) -> NoReturn:
        """Record the error that ends the run, and raise it; if the disk is full, with advice how to resume."""
        failure = error
        if isinstance(error, OSError):
            failure = RunError(
                f"{error.filename or self.directory}: {error.strerror or error}; {self._resume_advice()}"
            )
        elif free_space(self.directory) < self.reserve:
            failure = type(error)(f"{self.directory}: the disk is full: {error}; {self._resume_advice()}")
        if isinstance(failure, SingleRankError) and self.comm.size > 1:
            # the first rank may be waiting inside LAMMPS: this rank writes the record and ends all
            dataclasses.replace(self.record, state=record.FAILED, reason=str(failure)).write(self.directory)
            abort(self.comm, str(failure))
        with contextlib.suppress(OSError):  # on a full disk the last record remains
            self._note(state=record.FAILED, reason=str(failure))
        raise failure from error

    def _resume_advice(self) -> str:
        """Tell how to resume a run that cannot continue."""
        saved = self.record.checkpoint
        where = f"from the checkpoint at step {saved['step']}" if saved else "from the start, as there is no checkpoint"
        return f"what was computed is kept; make room, then the same command with --resume goes on {where}"

    def analyse(self, *, figures: bool, take_up: bool = False) -> Outcome:
        """Analyse the output; ``take_up``: that of an earlier session."""
        if take_up:
            there = on_first(self.comm, lambda: record.read(self.directory))
            self.record = there or on_first(self.comm, lambda: record.recover(self.directory)) or Record()
            if there is None:  # it was damaged
                self._note()
            self.state = record.REFUSED if self.record.end_reason == BALANCE_REFUSED else record.FINISHED

        def work(ranks: Processes) -> dict[str, Any]:
            clear_scratch(self.directory, [RESULT_FILE])  # of an analysis that was killed
            return analyse(self.directory, progress=self.show, figures=figures, processes=ranks)

        try:
            summary = shared(self.comm, work)
        except OSError as error:
            if isinstance(error, MissingOutputError):
                raise
            where = error.filename or self.directory
            raise RunError(
                f"{where}: {error.strerror or error}; what LAMMPS computed is kept; make room, then the same command "
                "with --resume analyses it"
            ) from error
        self._note(state=self.state)  # a run counts as finished only after its analysis
        if self.comm.rank == 0 and self.state != record.INTERRUPTED:
            record.keep_checkpoint(self.directory, None)
        return Outcome(self.directory, self.record.state, summary)

    def _deck(self, timestep: float | None, go_on: bool) -> Deck:
        def write(ranks: Processes) -> Deck:
            if go_on:
                return read_deck(self.directory)
            record.keep_checkpoint(self.directory, None)
            clear(self.directory, output_names(self.directory))
            return write_deck(self.case, self.directory, timestep=timestep, processes=ranks)

        deck = shared(self.comm, write)
        if not go_on:
            self.record = dataclasses.replace(
                self.record, versions=versions(), checkpoint=None, n_steps=0, end_time_s=0.0, wall_time_s=0.0
            )
        self.record.n_ranks, self.record.nodes = self.comm.size, nodes(self.comm)
        self.record.timestep_s = deck.schedule.first_timestep
        return deck

    # ------------------------------------------------------------------ one attempt

    def _attempt(self, deck: Deck, stop: StopRequest, go_on: bool) -> None:
        script = on_first(self.comm, lambda: deck.script.read_text(encoding="utf-8"))
        self.state, self.lost_before_block = record.RUNNING, 0.0
        self._note(state=record.RUNNING, reason=None, end_reason=None)
        saved = self.record.checkpoint
        with open_engine(self.comm, log="none" if go_on else LOG_FILE) as engine:
            if go_on and saved:
                on_first(self.comm, lambda: record.cut_back(self.directory, saved))
                # the snapshots that it will write, and what it will add to
                added = f"{DUMPS}/{frames_file(assemble(self.case), saved['file'])}"
                on_first(self.comm, lambda: claim(self.directory, [added, *output_names(self.directory)]))
                self.balance.read()
                self.lost_before_block = saved["lost_before_block"]
                engine.commands(f"log {LOG_FILE} append")
                resumed = partial(input_script, restart_from=saved["file"])
                script = on_first(self.comm, lambda: resumed(assemble(self.case), deck.schedule))
            if not go_on and self.case.precompression and self.show:
                logger.info("%s: static stage, until the packing is in balance ...", self.case.name)
            setup = part(script, "setup")
            if not go_on and not assemble(self.case).bars:
                before, _, setup = setup.partition(f"{READ_DATA}\n")
                engine.commands(before)
                make_spheres(engine, assemble(self.case))
            self._set_up(engine, setup, stop)
            if not go_on and self.case.precompression:
                found = on_first(self.comm, lambda: check_equilibrium(self.case, self.directory))
                if found["yielded"] and self.case.contact.entry.elastic_limit > 0:
                    self._log(f"{found['yielded']:.0f} contacts yielded, or their dents grew, under the precompression")
            elif not go_on:
                expected = on_first(self.comm, lambda: expected_neighbours(self.case))
                check_coordination(self.case.packing.kind, expected, engine)
            self._advance(engine, deck, stop)
            engine.commands(part(script, "end"))

    def _set_up(self, engine: Engine, commands: str, stop: StopRequest) -> None:
        """Execute the commands before the first step; a request to stop ends them, as a static stage can be long."""
        interrupted: dict[str, Any] = {"state": record.INTERRUPTED, "end_reason": "interrupted"}

        ended = False

        def end() -> None:
            nonlocal ended
            ended = True
            if self.comm.size == 1:
                return engine.end_command()
            if self.comm.rank == 0:  # LAMMPS cannot end a command at the same step on all ranks
                dataclasses.replace(self.record, **interrupted).write(self.directory)
            else:
                time.sleep(_FIRST_ENDS)
            abort(self.comm, "stopped", 130)

        failure = None
        try:
            with stop.answered_at_once(end):
                engine.commands(commands)
        except RunError as error:
            if isinstance(error, SingleRankError) and self.comm.size > 1:
                raise
            failure = error
        if ended:
            self._note(**interrupted)
            raise KeyboardInterrupt(f"{self.directory}: stopped before its first step")
        if failure:
            raise failure

    def _advance(self, engine: Engine, deck: Deck, stop: StopRequest) -> None:
        schedule = deck.schedule
        at_most = schedule.block_steps > 0
        bar = Progress(schedule.n_steps, self.case.name, enabled=self.show, done=engine.step, at_most=at_most)
        begin = last_checkpoint = time.monotonic()
        before = self.record.wall_time_s
        unit, fresh = schedule.longest_step, True  # pieces end where every timestep can
        piece = 20 * unit
        try:
            while self.state == record.RUNNING:
                left = schedule.n_steps - engine.step
                if schedule.block_steps:
                    left = min(left, schedule.block_steps - engine.step % schedule.block_steps)
                started = time.monotonic()
                engine.commands(f"run {min(piece, left)}{'' if fresh else ' pre no'} post no")
                fresh = False
                now = time.monotonic()
                longer = min(4 * piece, piece * _PIECE / max(now - started, 1e-3))
                piece = self._shared(unit * max(1, int(longer / unit)))
                self._look(engine, deck)
                self.record.n_steps, self.record.end_time_s = engine.step, engine.step * schedule.timestep
                self.record.wall_time_s = before + now - begin
                last = self.state == record.FINISHED
                row, here = self.balance.row, 1e3 * self.record.end_time_s
                share = row["dissipated"] / row["input"] if row and row["input"] else 0.0
                note = f"{here:.3f}/{1e3 * schedule.end_time:g} ms, dissipated {share:.3f}"
                bar.update(engine.step, f"{note}, balance {self.balance.error:.1e}", last=last)
                if self.state == record.RUNNING and stop.wanted():
                    self.state, self.record.end_reason = record.INTERRUPTED, "interrupted"
                if self.state == record.INTERRUPTED or (
                    self.state == record.RUNNING and self._shared(now - last_checkpoint > self.checkpoint_interval)
                ):
                    self._checkpoint(engine)
                    last_checkpoint, fresh = time.monotonic(), True
                free = self._shared(free_space(self.directory))
                if self.state == record.RUNNING and free <= self.reserve:  # LAMMPS does not report failed writes
                    self._checkpoint(engine)
                    message = disk_space_message("a snapshot and a checkpoint", self.reserve, 0.0, free)
                    raise RunError(f"stopped at step {engine.step}: {message}")
        finally:
            bar.close()

    def _look(self, engine: Engine, deck: Deck) -> None:
        """Check the energy balance, and decide if the run has ended."""
        schedule = deck.schedule

        def decide() -> tuple[Balance, str, str | None]:
            balance = self.balance.read()
            row, step = balance.row, engine.step
            given = step * schedule.timestep >= self.case.load.lasts  # the energy input is complete
            judged = given or step >= schedule.n_steps
            if judged and not balance.closed and self.case.contact.variant != "published":
                return balance, record.REFUSED, BALANCE_REFUSED
            at_block_end = given and schedule.block_steps and step % schedule.block_steps == 0
            if at_block_end and row["dissipated"] - self.lost_before_block < BLOCK_THRESHOLD * row["input"]:
                return balance, record.FINISHED, "settled"
            if step >= schedule.n_steps:
                return balance, record.FINISHED, "longest" if schedule.block_steps else "end_time"
            return balance, record.RUNNING, None

        self.balance, self.state, self.record.end_reason = on_first(self.comm, decide)
        if schedule.block_steps and engine.step % schedule.block_steps == 0:
            self.lost_before_block = self.balance.row["dissipated"]

    def _checkpoint(self, engine: Engine) -> None:
        self.record.checkpoint = record.write_checkpoint(
            engine, self.comm, self.directory, self.record.checkpoint, parts=written_in_parts(assemble(self.case))
        )
        self.record.checkpoint["lost_before_block"] = self.lost_before_block
        on_first(self.comm, lambda: self.record.write(self.directory))
        on_first(self.comm, lambda: record.keep_checkpoint(self.directory, self.record.checkpoint))

    # ------------------------------------------------------------------ the record

    def _note(self, **changes: Any) -> None:
        self.record = dataclasses.replace(self.record, **changes)
        if self.comm.rank == 0:
            self.record.write(self.directory)

    def _shared(self, value: Any) -> Any:
        """Return the value on the first rank."""
        return self.comm.bcast(value) if self.comm.size > 1 else value

    def _log(self, text: str) -> None:
        if self.comm.rank == 0:
            logger.warning("%s: %s", self.case.name, text)
