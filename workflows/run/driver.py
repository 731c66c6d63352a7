"""One run from case to figures: input script, LAMMPS in pieces, energy balance, checkpoints,
analysis.

LAMMPS executes the lines of in.granwave. Only the run section is replaced by pieces of the run;
between them the energy balance is checked, the progress bar is updated, and a request to stop is
answered.
"""

from __future__ import annotations

import contextlib
import dataclasses
import logging
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.pipeline import analyse
from granwave.analysis.result.reader import moved_mass
from granwave.analysis.result.writer import BALANCE_REFUSED
from granwave.analysis.summary import check_value_names
from granwave.lammps_inputs.checks.warnings import case_warnings
from granwave.lammps_inputs.deck.commands import PARTS
from granwave.lammps_inputs.deck.deck import Deck, read_deck, write_deck
from granwave.lammps_inputs.deck.output import frames_file
from granwave.lammps_inputs.deck.script import READ_DATA, input_script, part
from granwave.lammps_inputs.directories import (
    disk_space_message,
    free_space,
    label_of,
    results_directory,
)
from granwave.lammps_inputs.errors import GranwaveError, RunError
from granwave.lammps_inputs.message_words import counted
from granwave.lammps_inputs.packing.assembly import Assembly, of_case
from granwave.lammps_inputs.packing.motion import written_in_parts
from granwave.lammps_inputs.planning.bar_echoes import echo_warnings
from granwave.lammps_inputs.planning.blocks import BLOCK_THRESHOLD
from granwave.lammps_inputs.planning.cost import analysing_ranks
from granwave.lammps_inputs.planning.plan import plan
from granwave.lammps_inputs.planning.ranks import grid_of
from granwave.lammps_inputs.planning.schedule import Schedule
from granwave.lammps_inputs.processes import Processes
from granwave.lammps_inputs.run_directory import (
    CASE_FILE,
    DATA_FILE,
    DUMPS,
    ENERGY_FILE,
    LOG_FILE,
    RESULT_FILE,
)
from granwave.workflows.run import checks, record
from granwave.workflows.run.checkpoint import write_checkpoint
from granwave.workflows.run.directory import (
    ANALYSE,
    CONTINUE,
    FINISHED,
    START,
    RunDirectory,
    decide,
    held,
    start,
)
from granwave.workflows.run.failures import describe_removal, unfinished_analysis, with_advice
from granwave.workflows.run.initial_state import make_spheres
from granwave.workflows.run.kept_warnings import keeping_warnings
from granwave.workflows.run.lammps_engine import Engine, SingleRankError, open_engine
from granwave.workflows.run.mpi import StopRequest, abort, nodes, on_first, world
from granwave.workflows.run.progress import Progress, announce
from granwave.workflows.run.ranks import shared
from granwave.workflows.run.static_progress import StaticProgress
from granwave.workflows.run.static_state import look_at_rolling, look_at_strikers
from granwave.workflows.run.turns import refuse_threads_of_ranks, turn

if TYPE_CHECKING:
    from mpi4py.MPI import Intracomm

logger = logging.getLogger(__name__)

MOST_ATTEMPTS = 4  # timesteps tried if the balance does not close, each half of the previous one
_FIRST_ENDS = 1.0  # s until other ranks end all ranks if the first has not
_PIECE = 1.0  # s of wall time between checks of the balance
_NOTED = 5.0  # s of wall time between records of the time reached


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


def run_assembly(
    assembly: Assembly,
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
        Directory of the results; the page 'What a run leaves' of the documentation lists its files.
    resume
        Continue existing results; a finished run is not changed, and an empty directory is a new
        run.
    force
        Move existing results into NAME.old.
    progress
        Show a bar (on a terminal) or lines (in a log).
    checkpoint_interval
        Wall time between checkpoints, s.
    figures
        Draw the figures.
    comm
        MPI communicator; by default the communicator of all ranks.

    Raises
    ------
    InputError
        The directory holds results or another case, or memory or disk space is insufficient.
        Nothing was run.
    RunError
        LAMMPS failed; results so far are kept.
    """
    comm = world() if comm is None else comm
    results = RunDirectory(results_directory(directory))

    def prepare(ranks: Processes) -> str:
        n_ranks = comm.size
        what = decide(
            assembly,
            results,
            resume=resume,
            force=force,
            figures=figures,
            n_ranks=n_ranks,
            processes=ranks,
        )
        if what == START:
            start(assembly, results, force=force)
        elif results.restore_case():
            logger.warning(
                "%s was missing or damaged: restored to the version of the run", results / CASE_FILE
            )
        return what

    refuse_threads_of_ranks(comm)
    check_value_names()
    with held(results, comm), turn(results.path):
        what = shared(comm, prepare)
        run = _Run(assembly, results, comm, progress, figures, checkpoint_interval)
        if what == ANALYSE:
            try:
                return run.analyse(take_up=True)
            except (MissingOutputError, OutputFormatError) as error:
                if comm.rank == 0:
                    logger.warning("%s; the case is run again", error)
                on_first(comm, lambda: start(assembly, results))
                what = START
                run = _Run(assembly, results, comm, progress, figures, checkpoint_interval)
        if what == FINISHED:
            return Outcome(results.path, record.FINISHED, on_first(comm, results.summary))
        return run.complete(go_on=what == CONTINUE)


run_case = of_case(run_assembly)


class _Run:
    def __init__(
        self,
        assembly: Assembly,
        results: RunDirectory,
        comm: Intracomm,
        show: bool,
        figures: bool,
        checkpoint_interval: float,
    ) -> None:
        self.assembly = assembly
        self.case = assembly.case
        self.results = results
        self.directory = results.path
        self.comm = comm
        self.figures = figures
        self.show = show and comm.rank == 0
        self.checkpoint_interval = checkpoint_interval
        self.label = label_of(self.case.name, self.directory)
        self.record = record.Record(name=self.case.name, n_ranks=comm.size)
        accepted = self.case.run.accepted_balance_error
        self.balance = checks.Balance(
            results / DUMPS / ENERGY_FILE, accepted, moved_mass(self.assembly)
        )
        self.state = record.RUNNING  # state of the time integration; recorded after the analysis
        self.warnings: list[str] = []
        # disk space to be kept free, bytes
        self.reserve = on_first(comm, self._plan)
        # dissipated energy at the start of the current block of end_time = "auto", J
        self.lost_before_block = 0.0
        self.began = False  # LAMMPS has opened its output

    def _plan(self) -> float:
        """Keep the warnings about the case, and return the disk space to be kept free, bytes."""
        self.warnings += [*case_warnings(self.assembly), *echo_warnings(self.assembly)]
        with keeping_warnings((self.case.name, self.label), self.warnings):
            return plan(self.assembly).disk_reserve

    # ------------------------------------------------------------------ attempts

    def complete(self, *, go_on: bool) -> Outcome:
        """Integrate in time, and analyse."""
        if self.show:
            expected = plan(self.assembly, n_ranks=self.comm.size, figures=self.figures)
            announce(expected, self.label)
        try:
            with StopRequest(self.comm) as stop:
                self.integrate(stop, go_on=go_on)
            return self.analyse()
        except (OSError, GranwaveError) as error:
            if gone := describe_removal(self._places()):
                raise RunError(gone) from error
            raise

    def integrate(self, stop: StopRequest, *, go_on: bool) -> None:
        """Integrate in time; halve an automatic timestep until the balance closes."""
        if go_on:
            self.record = on_first(self.comm, lambda: self.results.read_record() or record.Record())
        self.warnings = list(dict.fromkeys([*self.record.warnings, *self.warnings]))
        self.record.energy_balance_accepted = self.balance.accepted
        timestep = None
        chosen = self.case.run.timestep == "auto"
        while True:
            deck = self._deck(timestep, go_on)
            try:
                with keeping_warnings((self.case.name, self.label), self.warnings):
                    self._attempt(deck, stop, go_on)
            except (RunError, OSError) as error:
                self._fail(error)
            if self.state != record.REFUSED:
                break
            misses = self.balance.error
            accepted = self.balance.accepted
            if not chosen or len(self.record.attempts) + 1 >= MOST_ATTEMPTS:
                advice = "" if chosen else '; use a shorter run.timestep, or "auto"'
                self._log(
                    f"energy balance error too large: {misses:.1e} of the input, {accepted:.0e} "
                    f"is accepted{advice}"
                )
                break
            tried = deck.schedule.first_timestep
            self.record.attempts.append({"timestep_s": tried, "energy_balance_error": misses})
            timestep = tried / 2
            go_on = False
            self.balance = checks.Balance(self.balance.path, accepted, self.balance.moved)
            self._log(
                f"energy balance error of {misses:.1e} of the input; repeating with half the "
                f"timestep, {timestep:.3g} s"
            )
        outputs = [DATA_FILE, *self.results.output_names()]
        on_first(self.comm, lambda: self.results.note_files(outputs))
        self._note(state=self.state if self.state == record.INTERRUPTED else record.INTEGRATED)

    def _fail(self, error: RunError | OSError) -> NoReturn:
        """Record the error that ends the run, and raise it; if the disk is full, with advice on
        resuming.
        """
        failure = self._describe(error)
        if isinstance(failure, SingleRankError) and self.comm.size > 1:
            # the first rank may be waiting inside LAMMPS: this rank writes the record and ends all
            failed = dataclasses.replace(self.record, state=record.FAILED, reason=str(failure))
            self.results.write_record(failed)
            abort(self.comm, str(failure))
        with contextlib.suppress(OSError):  # on a full disk the last record remains
            self._note(state=record.FAILED, reason=str(failure))
        raise failure from error

    def _describe(self, error: RunError | OSError) -> RunError:
        """Return an error of the integration with advice on resuming."""
        gone = describe_removal(self._places())
        return (
            RunError(gone)
            if gone
            else with_advice(error, self.directory, self.record.checkpoint, self.reserve)
        )

    def _places(self) -> list[Path]:
        """Return the paths that a run needs until its end."""
        written = [self.directory / DUMPS, self.balance.path] if self.began else []
        return [self.directory, *written]

    def analyse(self, *, take_up: bool = False) -> Outcome:
        """Analyse the output; ``take_up`` is True for output of an earlier session."""
        if take_up:
            there = on_first(self.comm, self.results.read_record)
            self.record = (
                there or on_first(self.comm, self.results.recovered_record) or record.Record()
            )
            if there is None:  # it was damaged
                self._note()
            self.state = (
                record.REFUSED if self.record.end_reason == BALANCE_REFUSED else record.FINISHED
            )

        def work(ranks: Processes) -> dict[str, Any]:
            self.results.clear_scratch([RESULT_FILE])  # files of an analysis that was killed
            return analyse(
                self.results,
                progress=self.show,
                figures=self.figures,
                processes=ranks,
                assembly=self.assembly,
            )

        try:
            most = analysing_ranks(self.assembly, self.comm.size)
            summary = shared(self.comm, work, most=most)
        except MissingOutputError:
            raise
        except OSError as error:
            raise unfinished_analysis(error, self.directory) from error
        self._note(state=self.state)  # a run counts as finished only after its analysis
        if self.comm.rank == 0 and self.state != record.INTERRUPTED:
            self.results.keep_checkpoint(None)
        return Outcome(self.directory, self.record.state, summary)

    def _deck(self, timestep: float | None, go_on: bool) -> Deck:
        def write(ranks: Processes) -> Deck:
            if go_on:
                return read_deck(self.directory, self.case)
            self.results.keep_checkpoint(None)
            self.results.clear(self.results.output_names())
            return write_deck(self.assembly, self.results, timestep=timestep, processes=ranks)

        deck = shared(self.comm, write)
        if not go_on:
            fresh: dict[str, Any] = {
                "checkpoint": None,
                "n_steps": 0,
                "end_time_s": 0.0,
                "wall_time_s": 0.0,
            }
            self.record = dataclasses.replace(self.record, versions=record.versions(), **fresh)
        self.record.warnings = self.warnings  # the list grows during the run
        self.record.n_ranks = self.comm.size
        self.record.nodes = nodes(self.comm)
        self.record.timestep_s = deck.schedule.first_timestep
        return deck

    # ------------------------------------------------------------------ one attempt

    def _attempt(self, deck: Deck, stop: StopRequest, go_on: bool) -> None:
        script = on_first(self.comm, lambda: deck.script.read_text(encoding="utf-8"))
        self.began = False
        self.state = record.RUNNING
        self.lost_before_block = 0.0
        self._note(state=record.RUNNING, reason=None, end_reason=None)
        saved = self.record.checkpoint if go_on else None
        log = "none" if go_on else LOG_FILE
        with open_engine(self.comm, log, self.directory) as engine:
            if saved:
                # the expected snapshots, and the files to be extended
                added = f"{DUMPS}/{frames_file(self.assembly, saved['file'])}"

                def cut_back() -> str:
                    self.results.cut_back(saved)
                    self.results.claim([added, *self.results.output_names()])
                    return input_script(self.assembly, deck.schedule, restart_from=saved["file"])

                script = on_first(self.comm, cut_back)
                self.balance.read()
                self.lost_before_block = saved["lost_before_block"]
                engine.commands(f"log {LOG_FILE} append")
            elif self.case.precompression and self.show:
                logger.info("%s: static stage, until the packing is in equilibrium ...", self.label)
            setup = part(script, "setup")
            grid = on_first(self.comm, lambda: grid_of(self.assembly, self.comm.size))
            engine.commands("processors " + " ".join(map(str, grid)))
            if written_in_parts(self.assembly):
                engine.commands(f"variable {PARTS} index {len(self.record.nodes)}")
            from_data = not (saved or self.case.packing.restart)
            if from_data and not (self.assembly.bars or self.assembly.clumps):
                before, _, setup = setup.partition(f"{READ_DATA}\n")
                engine.commands(before)
                make_spheres(engine, self.assembly)
            static = self.case.precompression is not None and not saved
            self._set_up(engine, setup, stop, static=static)
            self.began = True
            if not saved and self.case.precompression:
                found = on_first(
                    self.comm, lambda: checks.check_equilibrium(self.assembly, self.directory)
                )
                if found["yielded"] and self.case.contact.entry.elastic_limit > 0:
                    yielded = counted(round(found["yielded"]), "contact")
                    self._log(
                        f"{yielded} yielded, or grew in indentation, under the precompression"
                    )
                look_at_strikers(engine, self.assembly, self.comm)
                if checks.rolls_on(found):
                    look_at_rolling(engine, self.assembly, self.comm, found)
            elif not saved:
                expected = on_first(self.comm, lambda: checks.expected_neighbours(self.assembly))
                checks.check_coordination(self.case.packing.kind, expected, engine)
            self._advance(engine, deck.schedule, stop)
            engine.commands(part(script, "end"))

    def _set_up(self, engine: Engine, commands: str, stop: StopRequest, *, static: bool) -> None:
        """Execute the commands before the first step; a request to stop ends them, as a static
        stage can be long.
        """
        interrupted: dict[str, Any] = {"state": record.INTERRUPTED, "end_reason": "interrupted"}
        ended = threading.Event()
        failure = None

        def end() -> None:
            ended.set()
            if self.comm.size == 1:
                return engine.end_command()
            if self.comm.rank == 0:  # LAMMPS cannot end a command at the same step on all ranks
                self.results.write_record(dataclasses.replace(self.record, **interrupted))
            else:
                time.sleep(_FIRST_ENDS)
            abort(self.comm, "stopped", 130)

        try:
            with stop.answered_at_once(end):
                if static:
                    StaticProgress(engine, self.label, enabled=self.show).commands(commands)
                else:
                    engine.commands(commands)
        except RunError as error:
            if isinstance(error, SingleRankError) and self.comm.size > 1:
                raise
            failure = error
        if ended.is_set():
            self._note(**interrupted)
            raise KeyboardInterrupt(f"{self.directory}: stopped before its first step")
        if failure:
            raise failure

    def _advance(self, engine: Engine, schedule: Schedule, stop: StopRequest) -> None:
        blocks = schedule.block_steps
        bar = Progress(
            schedule.n_steps,
            self.label,
            enabled=self.show,
            done=engine.step,
            at_most=blocks > 0,
        )
        begin = last_checkpoint = noted = time.monotonic()
        before = at_checkpoint = self.record.wall_time_s
        # pieces end at a common multiple of all possible timesteps
        unit = schedule.longest_step
        fresh = True
        piece = 20 * unit
        try:
            while self.state == record.RUNNING:
                left = schedule.n_steps - engine.step
                if blocks:
                    left = min(left, blocks - engine.step % blocks)
                started = time.monotonic()
                engine.commands(f"run {min(piece, left)}{'' if fresh else ' pre no'} post no")
                fresh = False
                now = time.monotonic()
                longer = min(4 * piece, piece * _PIECE / max(now - started, 1e-3))
                piece = self.comm.bcast(unit * max(1, int(longer / unit)))
                self._look(engine.step, schedule)
                self.record.n_steps = engine.step
                self.record.end_time_s = engine.step * schedule.timestep
                self.record.wall_time_s = before + now - begin
                row = self.balance.row
                here = 1e3 * self.record.end_time_s
                share = row["dissipated"] / row["input"] if row and row["input"] else 0.0
                note = f"{here:.3f}/{1e3 * schedule.end_time:g} ms, dissipated {share:.3f}"
                last = self.state == record.FINISHED
                bar.update(engine.step, f"{note}, balance {self.balance.error:.1e}", last=last)
                if self.state != record.RUNNING:
                    break
                if stop.wanted():
                    self.state = record.INTERRUPTED
                    self.record.end_reason = "interrupted"
                due, free = self.comm.bcast(
                    (now - last_checkpoint > self.checkpoint_interval, free_space(self.directory))
                )
                full = free <= self.reserve  # LAMMPS does not report failed writes
                if due or full or self.state == record.INTERRUPTED:
                    self._checkpoint(engine)
                    last_checkpoint = noted = time.monotonic()
                    at_checkpoint = self.record.wall_time_s
                    fresh = True
                elif now - noted > _NOTED:
                    self._note_progress(at_checkpoint)
                    noted = now
                if full and self.state == record.RUNNING:
                    message = disk_space_message(
                        "a snapshot and a checkpoint", self.reserve, 0.0, free
                    )
                    raise RunError(f"stopped at step {engine.step}: {message}")
        finally:
            bar.close()

    def _look(self, step: int, schedule: Schedule) -> None:
        """Check the energy balance, and decide if the run has ended."""
        at_block_end = schedule.block_steps > 0 and step % schedule.block_steps == 0

        def decide() -> tuple[checks.Balance, str, str | None]:
            balance = self.balance.read()
            row = balance.row
            if not row:
                raise RunError(f"{balance.path}: found no row of energies after {step} steps")
            ended = step >= schedule.n_steps
            given = step * schedule.timestep >= self.case.load.lasts  # the energy input is complete
            if (given or ended) and not balance.closed and self.case.contact.variant != "published":
                return balance, record.REFUSED, BALANCE_REFUSED
            if (
                given
                and at_block_end
                and row["dissipated"] - self.lost_before_block < BLOCK_THRESHOLD * row["input"]
            ):
                return balance, record.FINISHED, "settled"
            if ended:
                return balance, record.FINISHED, "longest" if schedule.block_steps else "end_time"
            return balance, record.RUNNING, None

        self.balance, self.state, self.record.end_reason = on_first(self.comm, decide)
        if at_block_end:
            self.lost_before_block = self.balance.row["dissipated"]

    def _checkpoint(self, engine: Engine) -> None:
        parts = written_in_parts(self.assembly)
        saved = write_checkpoint(
            engine, self.comm, self.results, self.record.checkpoint, parts=parts
        )
        self.record.checkpoint = saved | {"lost_before_block": self.lost_before_block}

        def keep() -> None:
            self.results.write_record(self.record)
            self.results.keep_checkpoint(saved)

        on_first(self.comm, keep)

    # ------------------------------------------------------------------ the record

    def _note(self, **changes: Any) -> None:
        self.record = dataclasses.replace(self.record, **changes)
        if self.comm.rank == 0:
            self.results.write_record(self.record)

    def _note_progress(self, wall_time: float) -> None:
        """Record the time reached, for a run that may be killed.

        Parameters
        ----------
        wall_time
            At the last checkpoint, s: the integration that is lost after it does not count.
        """
        if self.comm.rank == 0:
            self.results.write_record(dataclasses.replace(self.record, wall_time_s=wall_time))

    def _log(self, text: str) -> None:
        if self.comm.rank == 0:
            logger.warning("%s: %s", self.label, text)
