"""Command ``granwave design``: plan and outcome of a search in the terminal."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from granwave.analysis.formatting.numbers import counted, duration
from granwave.analysis.formatting.values import printed_unit, unit_in_cases
from granwave.analysis.quantities import quantity
from granwave.analysis.summary_table import lines
from granwave.extensions.design.files import DESIGN_OUTCOME
from granwave.extensions.design.report import range_under_checks
from granwave.extensions.design.search.design_file import load_problem
from granwave.extensions.design.search.driver import run_design
from granwave.extensions.design.search.points import default_jobs
from granwave.extensions.design.search.problem import DesignProblem
from granwave.extensions.design.search.search import random_designs
from granwave.extensions.design.search.study import (
    FAILED,
    REFUSED,
    DesignStudy,
    first_design,
    new_design,
)
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_json
from granwave.lammps_inputs.planning.plan import plan
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import SCAN_REPORT
from granwave.workflows.cli.submission import (
    check_submission,
    profile_of,
    refuse_without_submit,
    submit_or_print,
)
from granwave.workflows.cli.terminal import print_json
from granwave.workflows.cluster.job import CommandJob
from granwave.workflows.cluster.profile import SLURM
from granwave.workflows.run.directory import held

_DRAWN = 64  # designs from which a plan is made


def design(options: argparse.Namespace) -> int:
    """Search for the best design; return the exit status."""
    if options.submit is not None:
        return submit_design(options)
    refuse_without_submit(options)
    problem = load_problem(options.file, options.budget)
    directory = results_directory(options.directory or problem.name)
    jobs = options.jobs or default_jobs(options.ranks)
    values = plan_values(problem, jobs, options.ranks)
    if not options.json:
        print(plan_text(problem, values), flush=True)
    study, stopped = run_design(
        problem, directory, jobs=options.jobs, ranks=options.ranks, resume=options.resume, force=options.force,
        progress=True,
    )  # fmt: skip
    found = read_json(directory / DESIGN_OUTCOME)
    if stopped or found is None:
        print(
            "granwave: interrupted; run the same command with --resume to continue",
            file=sys.stderr,
        )
        return 130
    print_json(found) if options.json else print(outcome_text(found, str(directory / SCAN_REPORT)))
    none = not study.best()
    failed = sum(one.state == FAILED for one in study.designs)
    if none:
        print(
            "granwave: no design of the search meets the limits; see designs.csv for the reasons",
            file=sys.stderr,
        )
    elif failed:
        print(
            f"granwave: {failed} designs failed; see designs.csv for the reasons", file=sys.stderr
        )
    return int(none or bool(failed))


def submit_design(options: argparse.Namespace) -> int:
    """Submit a search as one job that runs designs in parallel; return the exit status."""
    profile = profile_of(options.submit)
    if profile.nodes > 1 and profile.scheduler != SLURM:
        raise InputError(
            f"cluster.nodes: found {profile.nodes}, expected 1: granwave design uses several nodes "
            "with Slurm alone; set nodes = 1"
        )
    problem = load_problem(options.file, options.budget)
    ranks = options.ranks
    jobs = options.jobs or max(1, profile.ranks // ranks)
    directory = results_directory(options.directory or problem.name).absolute()
    results = ResultDirectory(directory)
    if not options.print:
        check_submission(profile, directory)
        results.check(resume=options.resume, force=options.force)
        if not options.resume and not options.force:
            results.refuse_results()
    words = ["design", str(problem.path.absolute()), "-o", str(directory), "--resume"]
    words += ["--jobs", str(jobs), "--np", str(ranks)]
    if options.budget:
        words += ["--budget", str(options.budget)]
    values = plan_values(problem, jobs, ranks)
    job = CommandJob(
        name=problem.name,
        directory=directory,
        words=words,
        ranks=1,
        cores=jobs * ranks,
        wall_time=values["wall_time_s"] or 0.0,
        longest=0.0,
        memory=values["memory_bytes"] / profile.nodes_of(jobs * ranks),
        chain=options.chain or 1,
    )

    def make_room() -> None:
        """Move earlier results away."""
        if options.force:
            with held(results):
                results.make_room(force=True)

    return submit_or_print(job, profile, options, make_room)


def plan_of_design(path: Path, options: argparse.Namespace) -> int:
    """Print the plan of a search, like ``granwave check``; return the exit status."""
    if options.overrides:
        raise InputError(f"--set: {path} is a search for a design; set keys in its [set]")
    problem = load_problem(path)
    first_design(DesignStudy(problem, Path(problem.name)))
    values = plan_values(problem, default_jobs(options.ranks), options.ranks)
    print_json(values) if options.json else print(plan_text(problem, values))
    return 0


def plan_values(problem: DesignProblem, jobs: int, ranks: int) -> dict[str, Any]:
    """Return the values of a planned search; units are part of the names."""
    designs = [
        new_design(problem, n, values)
        for n, values in zip(
            range(_DRAWN), random_designs(problem.space, problem.search.seed), strict=False
        )
    ]
    fit = [one for one in designs if one.state != REFUSED]
    plans = [
        plan(problem.assembly(problem.tables_of(one.values)), n_ranks=ranks) for one in fit[:8]
    ]
    times = [expected.wall_time for expected in plans]
    size = problem.space.size
    n = min(problem.search.evaluations, size)
    return {
        "name": problem.name,
        "variables": [one.key for one in problem.space.variables],
        "n_designs": None if size == float("inf") else int(size),
        "share_within_limits": len(fit) / len(designs),
        "evaluations": int(n),
        "runs_each": len(problem.samples),
        "jobs": jobs,
        "wall_time_s": n * len(problem.samples) * sum(times) / len(times) / jobs if times else None,
        "memory_bytes": jobs * max((expected.memory for expected in plans), default=0.0),
    }


def plan_text(problem: DesignProblem, values: dict[str, Any]) -> str:
    """Return the table of a planned search."""
    goals = [
        f"{'smallest' if one.sign > 0 else 'largest'} {one.name}" for one in problem.objectives
    ]
    n = values["n_designs"]
    seconds = values["wall_time_s"]
    rows = [
        ("design", problem.name),
        ("wanted", " and ".join(goals)),
        ("variables", ", ".join(values["variables"])),
        ("designs", f"{n}" if n is not None else "infinite: ranges are continuous"),
        ("within limits", f"{100 * values['share_within_limits']:.0f} % of random designs"),
        (
            "evaluations",
            f"{values['evaluations']}, with {counted(values['runs_each'], 'run')} each",
        ),
    ]
    if seconds:
        expected = f"about {duration(seconds)}, without checks and neighbours of the best"
        rows.append(("expected time", expected))
    return lines(rows)


def outcome_text(found: dict[str, Any], report: str) -> str:
    """Return the best design, its checks, and the location of the other results."""
    best = found["best"]
    if best is None:
        return f"no design meets the limits; report in {report}"
    rows = [
        (
            "best design",
            f"number {best['number']}, in {best['directory']}; {found['evaluations']} were run",
        )
    ]
    for key, value in best["variables"].items():
        rows.append((key, f"{show(value)} {unit_in_cases(key, [best['variables']])}".rstrip()))
    for name, value in best["objective"].items():
        ends = best.get("spread", {}).get(name)
        spread = f" ({ends[0]:.4g} to {ends[1]:.4g})" if ends else ""
        unit = printed_unit(quantity(name).unit or "")
        rows.append((quantity(name).label or name, f"{value:.5g}{spread} {unit}".rstrip()))
        if checked := range_under_checks(best, name):
            rows.append(("", checked))
    rows += [("mass", f"{best['mass_kg']:.4g} kg"), ("height", f"{best['height_m']:.4g} m")]
    text = lines(rows)
    for one in best["guards"]:
        if one["warning"]:
            text += f"\nnote: {one['text']}"
    return f"{text}\n\nten best: best-1.toml ...; report in {report}"
