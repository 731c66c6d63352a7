"""Commands that run packings: ``granwave run``, ``write`` and ``analyse``; each returns the exit
status.
"""

from __future__ import annotations

import argparse
import logging
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from granwave.analysis.measures.zone_size import zone_warning
from granwave.analysis.summary_table import summary_table
from granwave.lammps_inputs.contact.initial_dents import dents_table, earlier_result
from granwave.lammps_inputs.deck.deck import read_deck, write_deck
from granwave.lammps_inputs.directories import check_disk, label_of, results_directory
from granwave.lammps_inputs.message_words import counted
from granwave.lammps_inputs.packing.assembly import Assembly, assemble
from granwave.lammps_inputs.planning.cost import analysing_ranks, expected_deck
from granwave.lammps_inputs.planning.plan import afford, check_files, plan
from granwave.lammps_inputs.processes import ALONE, Processes
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import CASE_FILE, RESULT_FILE, RUN, SUMMARY_FILE
from granwave.workflows import library
from granwave.workflows.cli.results import as_wrong_input, existing
from granwave.workflows.cli.submission import refuse_without_submit, submit_run
from granwave.workflows.cli.terminal import print_json, warn, warn_of_lacks
from granwave.workflows.run import mpi, record
from granwave.workflows.run.directory import RunDirectory, decide, held, run_files

_SMALL_DECK = 1e7  # bytes; smaller ones are written whole or not at all without a look at the disk


def run(options: argparse.Namespace) -> int:
    """Execute ``granwave run``."""
    if options.submit is not None:
        return submit_run(options)
    refuse_without_submit(options)
    starts_ranks = options.ranks > 1 and not mpi.launched()
    if starts_ranks:
        mpi.check_cores(options.ranks)
        logging.getLogger("granwave").setLevel(
            logging.ERROR
        )  # the ranks will print the warnings of the case
    assembly = library.load_assembly(options.case, options.overrides)
    case = assembly.case
    directory = results_directory(options.directory or case.name)
    how = how_to_run(options)
    if starts_ranks:
        decide(assembly, RunDirectory(directory), n_ranks=options.ranks, **how)
        words = _without_ranks(options.given)
        return mpi.launch(options.ranks, words, remedy="continue with --resume")

    from granwave.workflows.run.driver import (
        run_assembly,
    )  # loads the analysis, which is not needed to start ranks

    comm = mpi.world()
    outcome = run_assembly(
        assembly, directory, progress=True, checkpoint_interval=options.checkpoint, comm=comm, **how
    )
    if comm.rank == 0:
        summary = outcome.summary
        print_json(summary) if options.json else print(
            f"{summary_table(summary)}\n\nresults in {outcome.directory}"
        )
        warn_of_zone(summary, directory)
        warn_of_force(summary, directory, assembly)
        if beyond := summary.get("contacts_beyond_law"):
            warn(
                f"{counted(beyond, 'contact')} exceeded an overlap of 0.2 R*, the limit of the "
                f"contact law; figures mark {'them' if beyond > 1 else 'it'} with a ring"
            )
        if outcome.state == record.INTERRUPTED:
            print(
                "granwave: interrupted; run the same command with --resume to continue",
                file=sys.stderr,
            )
        if outcome.state == record.REFUSED:
            error = summary.get("energy_balance_error")
            misses = (
                "it is not a number" if error is None else f"its error is {error:.1e} of the input"
            )
            automatic = case.run.timestep == "auto"
            mend = (
                "set run.energy_tolerance to a smaller value"
                if automatic
                else "remove run.timestep"
            )
            print(
                f"granwave: energy balance error too large: {misses}; the results are kept. "
                f"Expected at most {case.run.accepted_balance_error:g}: {mend}, and run it again "
                "with --force",
                file=sys.stderr,
            )
    return {record.FINISHED: 0, record.INTERRUPTED: 130}.get(outcome.state, 1)


def how_to_run(options: argparse.Namespace) -> dict[str, Any]:
    """Return the options ``resume``, ``force`` and ``figures`` by name."""
    return {name: getattr(options, name) for name in ("resume", "force", "figures")}


def _without_ranks(arguments: Sequence[str]) -> list[str]:
    kept = []
    skip = False
    for argument in arguments:
        if skip or argument == "--np" or argument.startswith("--np="):
            skip = not skip and argument == "--np"
        else:
            kept.append(argument)
    return kept


def write(options: argparse.Namespace) -> int:
    """Execute ``granwave write``."""
    assembly = library.load_assembly(options.case, options.overrides)
    case = assembly.case
    expected = plan(assembly)
    check_files(assembly)
    warn_of_lacks(case.name, lambda: afford(expected))
    results = ResultDirectory(options.directory)
    results.check(force=options.force)
    needed = expected_deck(assembly)
    if needed > _SMALL_DECK:
        check_disk(results.path, needed, what="the deck", remedy="use a smaller packing")
    with held(results, mpi.world()):
        results.refuse_other_kind(RUN)
        if not options.force:
            results.refuse_results("")
        results.refuse_foreign(run_files(assembly, expected.schedule))
        results.refuse_source(case.name, earlier_result(case))
        if case.contact.initial_overlap:
            dents_table(assembly)
        old = results.make_room(force=options.force)
        try:
            deck = write_deck(assembly, results)
        except BaseException:
            results.put_back(old)
            raise
    schedule = deck.schedule
    steps = f"{schedule.n_steps} steps of {schedule.timestep:.3g} s"
    if schedule.adaptive:
        first = f"initial timestep {schedule.first_timestep:.3g} s"
        steps = f"{first}, end time {schedule.end_time:.4g} s"
    print(f"{options.directory}: {assembly.n_spheres} {assembly.grains_called}, {steps}")
    print(f"run it by hand:  cd {options.directory} && lmp -in {deck.script.name}")
    return 0


def analyse(options: argparse.Namespace) -> int:
    """Execute ``granwave analyse``."""
    directory = existing(options.directory)
    if options.ranks > 1 and not mpi.launched():
        mpi.check_cores(options.ranks)
        return mpi.launch(
            options.ranks, _without_ranks(options.given), remedy="the output of LAMMPS is unchanged"
        )
    comm = mpi.world() if mpi.launched() else None
    results = ResultDirectory(directory)

    def work(processes: Processes = ALONE, assembly: Assembly | None = None) -> Mapping[str, Any]:
        from granwave.analysis.pipeline import analyse as analyse_directory

        results.refuse_foreign([RESULT_FILE, SUMMARY_FILE])
        results.clear_scratch([RESULT_FILE])
        if results.restore_case():
            print(
                f"granwave: {directory / CASE_FILE}: restored to the version of the run",
                file=sys.stderr,
            )
        with as_wrong_input():
            return analyse_directory(
                results,
                progress=True,
                figures=options.figures,
                processes=processes,
                assembly=assembly,
            )

    with held(results, comm, way=""):
        if comm is None:
            summary = work()
        else:
            from granwave.workflows.run.ranks import shared

            with mpi.StopRequest(comm) as stop:
                assembly = mpi.on_first(comm, lambda: _assembly_of(directory))
                most = analysing_ranks(assembly, comm.size)
                summary = shared(comm, partial(work, assembly=assembly), stop.noticed, most)
    if mpi.is_first():
        print_json(summary) if options.json else print(summary_table(summary))
        warn_of_zone(summary, directory)
        warn_of_force(summary, directory)
    return 0


def _assembly_of(directory: Path) -> Assembly:
    """Return all bodies of the case of a run."""
    with as_wrong_input():
        return assemble(read_deck(directory).case)


def warn_of_force(
    summary: Mapping[str, Any], directory: Path, assembly: Assembly | None = None
) -> None:
    """Print a warning if the force on the bottom may rise further after the end of a run.

    Parameters
    ----------
    assembly
        All bodies of its case, if they are known; otherwise they are assembled.
    """
    from granwave.analysis.measures.target_record import rising_force_warning

    if warning := rising_force_warning(directory, assembly):
        warn(f"{label_of(summary['name'], directory)}: {warning}")


def warn_of_zone(summary: Mapping[str, Any], directory: Path, body: str = "packing") -> None:
    """Print a warning if the size of the packing, or of another body, limits the plastic zone."""
    if warning := zone_warning(summary, body):
        warn(f"{label_of(summary['name'], directory)}: {warning}")
