"""Options ``--submit`` and ``--chain``: a command as a job of a cluster."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import tomli_w

from granwave.analysis.formatting.numbers import counted
from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.planning.plan import plan
from granwave.workflows import library
from granwave.workflows.cli.commands import chosen
from granwave.workflows.cli.terminal import print_json
from granwave.workflows.cluster.job import (
    CommandJob,
    check_folder,
    folder_of,
    shown_cancel,
    submit,
)
from granwave.workflows.cluster.profile import Profile, load_profile
from granwave.workflows.run.directory import FINISHED, RunDirectory, decide, held, start
from granwave.workflows.scanning.batches import memory_on_node

CASE = "case.toml"  # in the folder of a job


def profile_of(value: Any) -> Profile:
    """Return the profile given by ``--submit``; without a name a standard Slurm profile."""
    return Profile() if value is True else load_profile(value)


def refuse_without_submit(options: argparse.Namespace) -> None:
    """Raise InputError for options that apply only with ``--submit``."""
    for name, value in (("--print", options.print), ("--chain", options.chain)):
        if value:
            raise InputError(f"{name}: requires --submit; remove it, or add --submit PROFILE")


def ranks_of(options: argparse.Namespace, profile: Profile) -> int:
    """Return the number of MPI ranks: ``--np``, or otherwise the number in the profile."""
    given = any(word == "--np" or word.startswith("--np=") for word in options.given)
    return options.ranks if given else profile.ranks


def submit_run(options: argparse.Namespace) -> int:
    """Submit a run with its analysis; return the exit status."""
    profile = profile_of(options.submit)
    ranks = ranks_of(options, profile)
    assembly = library.load_assembly(options.case, options.overrides)
    case = assembly.case
    directory = results_directory(options.directory or case.name).absolute()
    results = RunDirectory(directory)
    if not options.print:
        check_submission(profile, directory)
        way = chosen(options, decide)
        found = decide(assembly, results, n_ranks=ranks, here=False, **way)
        if found == FINISHED:
            print(f"{shown(directory)}: the run is finished; nothing was submitted")
            return 0
    expected = plan(assembly, n_ranks=ranks, figures=options.figures)
    folder_case = folder_of(directory) / CASE
    words = ["run", str(folder_case), "-o", str(directory), "--resume"]
    words += ["--checkpoint", str(options.checkpoint)]
    if not options.figures:
        words.append("--no-figures")
    job = CommandJob(
        name=case.name,
        directory=directory,
        words=words,
        ranks=ranks,
        wall_time=expected.wall_time,
        longest=expected.times.longest,
        memory=memory_on_node(expected, ranks, profile.nodes_of(ranks)),
        chain=options.chain or 1,
        files={CASE: tomli_w.dumps(case.to_dict())},
    )

    def make_room() -> None:
        """Move earlier results away."""
        if options.force:
            with held(results):
                start(assembly, results, force=True)

    return submit_or_print(job, profile, options, make_room)


def check_submission(profile: Profile, directory: Path) -> None:
    """Check that jobs for a directory can be submitted.

    Raises
    ------
    InputError
        The scheduler is missing, a job for the directory is in the queue, or the folder of its
        jobs holds something else.
    """
    profile.queue.check("--submit")
    check_folder(directory)


def submit_or_print(
    job: CommandJob, profile: Profile, options: argparse.Namespace, make_room: Any
) -> int:
    """Print the script of a job, or submit its chain; return the exit status.

    Parameters
    ----------
    make_room
        Function that is called before the first job is submitted.
    """
    script = job.script(profile)
    if options.print:
        print(script, end="")
        return 0
    make_room()
    jobs = submit(job, profile)
    if options.json:
        print_json({"jobs": jobs, "directory": job.directory, "folder": job.folder})
        return 0
    print(_submitted(job, profile, jobs))
    return 0


def _submitted(job: CommandJob, profile: Profile, jobs: Sequence[str]) -> str:
    """Return a description of the submitted jobs, and the directory of the results."""
    request = job.request(profile)
    queue = profile.queue
    title = f"job {jobs[0]}"
    if len(jobs) > 1:
        title = f"jobs {', '.join(jobs)}, one after the other"
    size = f"{counted(request.ranks, 'rank')} on {counted(request.nodes, 'node')}"
    return (
        f"{queue.title}: {title}: {size}, {counted(request.minutes, 'minute')}, "
        f"{request.memory} MB on each node\n"
        f"results: {shown(job.directory)}; script and log: {shown(job.folder)}\n"
        f"cancel: {shown_cancel(queue.commands, jobs)}"
    )


def shown(path: Path) -> str:
    """Return a path relative to the working directory, if it is inside."""
    here = Path.cwd()
    return str(path.relative_to(here)) if path.is_relative_to(here) else str(path)
