"""Command ``granwave scan``: plan and run of scans and suites."""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from granwave.analysis.formatting.numbers import duration
from granwave.analysis.scans.result import ScanResult
from granwave.lammps_inputs.case.packing.made_packing import PackingNotMadeError, nothing_made
from granwave.lammps_inputs.case.schema import did_you_mean
from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import InputError, RunError, raise_all
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import SCAN_REPORT
from granwave.workflows.cli.submission import profile_of
from granwave.workflows.cli.tables.rows import GIB, table
from granwave.workflows.cli.tables.scan_outcome import outcome_text, outcome_values
from granwave.workflows.cli.tables.scan_plan import plan_text, plan_values
from granwave.workflows.cli.terminal import in_shell, print_json
from granwave.workflows.cluster.profile import Profile, check_executor, load_profile
from granwave.workflows.scanning.batches import Machine, slowness_of
from granwave.workflows.scanning.directory import check_points, decide, points_left
from granwave.workflows.scanning.driver import STOPPED, ScanOutcome, default_jobs, run_scan
from granwave.workflows.scanning.engine import EXECUTORS, LOCAL, request_of
from granwave.workflows.scanning.scan_file import Scan, load_scan
from granwave.workflows.scanning.suite import Suite, check_suite, is_suite, load_suite, run_suite

_WORTH_MEASURING = 20.0  # s; for a longer expected time the speed of this machine is measured first
_PLANNED = 1000  # most points of a plan, chosen at random: 5 to 20 s


def scan(options: argparse.Namespace) -> int:
    """Run a scan or suite; return the exit status."""
    profile = _executor(options)
    try:
        making = nothing_made() if options.plan else contextlib.nullcontext()
        with making:
            return _plan_and_run(options, profile, options.jobs or default_jobs(profile))
    except PackingNotMadeError as error:
        return _not_made(options.scan, error, as_json=options.json)
    except BrokenPipeError:
        raise  # the reader of the plan has closed it
    except OSError as error:  # usually a full disk
        place = error.filename or options.directory or options.scan
        reason = error.strerror or error
        raise RunError(
            f"{place}: {reason}; fix this, then run the same command with --resume to continue"
        ) from error


def _not_made(name: str, error: PackingNotMadeError, *, as_json: bool) -> int:
    """Show the cost of the packings of a scan, whose plan follows once they are made."""
    time = sum(packing.time for packing in error.packings)
    memory = max(packing.memory for packing in error.packings)
    if as_json:
        values = {
            "n_packings": len(error.packings),
            "wall_time_s": time,
            "memory_bytes": memory,
            "files": [str(packing.file) for packing in error.packings],
        }
        print_json({"not_made": values})
        return 0
    rows = [
        ("scan", name),
        ("packings to generate", f"{len(error.packings)}, each stored for all points that use it"),
        ("time to generate them", f"about {duration(time)} on one core, in sequence"),
        ("memory", f"about {memory / GIB:.2f} GiB while they are generated"),
        ("made by", f"granwave scan {name}, before its first point"),
        ("the points", "are planned once their packings are generated"),
    ]
    print(table(rows))
    return 0


def _plan_and_run(options: argparse.Namespace, profile: Profile | None, jobs: int) -> int:
    """Plan a scan or a suite and, without ``--plan``, run it; return the exit status."""
    whole = _load(options)
    directory = results_directory(options.directory or whole.name)
    if not options.plan:
        _check_directory(whole, directory, options)
    scans = _scans_by_directory(whole, directory)
    if options.print:
        return _print_scripts(scans, profile, jobs, fresh=options.force)
    plans = [_plan(scan, place, profile, jobs, options) for place, scan in scans.items()]
    if isinstance(whole, Suite) and not options.json:
        total = duration(_total_time(plans))
        print(f"suite {whole.name}: {len(whole.scans)} scans, about {total} in all\n")
    if options.plan:
        _check_all(scans, fresh=options.force)
        if options.json:
            _print_plans(whole, directory, plans)
        return 0
    sys.stdout.flush()
    outcomes = _run(whole, directory, plans, profile, options)
    _print_outcomes(whole, directory, outcomes, as_json=options.json)
    return _status(outcomes[-1].stopped, outcomes)


def _load(options: argparse.Namespace) -> Scan | Suite:
    """Return the scan or suite of the command line."""
    here = options.executor == LOCAL
    if not is_suite(options.scan):
        most = _PLANNED if options.plan else None
        return load_scan(options.scan, options.overrides, here=here, most=most)
    if options.overrides:
        raise InputError(
            f"--set: {options.scan} is a suite of scans with different cases; set keys in its "
            "scan files"
        )
    return load_suite(options.scan, here=here)


def _check_directory(whole: Scan | Suite, directory: Path, options: argparse.Namespace) -> None:
    """Raise InputError if the results cannot be written into this directory."""
    results = ResultDirectory(directory)
    try:
        if isinstance(whole, Scan):
            decide(whole, results, resume=options.resume, force=options.force)
        else:
            check_suite(whole, results, resume=options.resume, force=options.force)
    except OSError as error:  # the directory cannot be read
        raise InputError(
            f"{directory}: {error.strerror or error}; choose another directory with -o"
        ) from None


def _scans_by_directory(whole: Scan | Suite, directory: Path) -> dict[Path, Scan]:
    """Return a scan, or the scans of a suite, by the directories of their results."""
    if isinstance(whole, Scan):
        return {directory: whole}
    return {directory / scan.name: scan for scan in whole.scans}


@dataclasses.dataclass(frozen=True)
class _ScanPlan:
    """Values of a planned scan, and the slowness of this machine relative to the estimate."""

    name: str
    values: Mapping[str, Any]
    slowness: float


def _plan(
    scan: Scan, place: Path, profile: Profile | None, jobs: int, options: argparse.Namespace
) -> _ScanPlan:
    """Plan a scan and, without ``--json``, print its table."""
    left = points_left(scan, place, fresh=options.force)
    left = sorted(left, key=lambda point: point.plan.wall_time)
    expected = sum(point.plan.wall_time for point in left) / jobs
    measured = None
    if options.executor == LOCAL and expected >= _WORTH_MEASURING:
        measured = slowness_of(left[len(left) // 2], jobs)
    slowness = measured or 1.0
    values = plan_values(scan, place, left, Machine(jobs, profile, slowness))
    if not options.json:
        print(plan_text(scan, left, values, measured))
        if is_suite(options.scan):
            print()
    return _ScanPlan(scan.name, values, slowness)


def _total_time(plans: Sequence[_ScanPlan]) -> float:
    """Return the expected time of all scans, in s."""
    return sum(plan.values["wall_time_s"] for plan in plans)


def _check_all(scans: Mapping[Path, Scan], *, fresh: bool) -> None:
    """Raise InputError with the faults of the points of all scans."""
    raise_all(
        partial(check_points, scan, ResultDirectory(place), force=fresh)
        for place, scan in scans.items()
    )


def _print_plans(whole: Scan | Suite, directory: Path, plans: Sequence[_ScanPlan]) -> None:
    """Print the values of a planned scan or suite as JSON."""
    values = [plan.values for plan in plans]
    if isinstance(whole, Scan):
        print_json(values[0])
        return
    suite = {
        "name": whole.name,
        "wall_time_s": _total_time(plans),
        "directory": directory,
        "scans": values,
    }
    print_json(suite)


def _run(
    whole: Scan | Suite,
    directory: Path,
    plans: Sequence[_ScanPlan],
    profile: Profile | None,
    options: argparse.Namespace,
) -> Sequence[ScanOutcome]:
    """Run a scan, or the scans of a suite; return their outcomes."""
    settings = {
        "executor": options.executor,
        "jobs": options.jobs,
        "profile": profile,
        "progress": True,
        "resume": options.resume,
        "force": options.force,
    }
    slowness = {plan.name: plan.slowness for plan in plans}
    if isinstance(whole, Scan):
        return [run_scan(whole, directory, slowness=slowness[whole.name], **settings)]
    return list(run_suite(whole, directory, slowness=slowness, **settings).scans)


def _print_outcomes(
    whole: Scan | Suite, directory: Path, outcomes: Sequence[ScanOutcome], *, as_json: bool
) -> None:
    """Print the outcomes of a scan or suite as tables, or as JSON."""
    stopped = outcomes[-1].stopped
    if as_json:
        scans = [outcome_values(outcome) for outcome in outcomes]
        suite = {"name": whole.name, "directory": directory, "stopped": stopped, "scans": scans}
        print_json(scans[0] if isinstance(whole, Scan) else suite)
        return
    if isinstance(whole, Scan):
        print(outcome_text(outcomes[0]))
        return
    for outcome in outcomes:
        print(outcome_text(outcome) + "\n")
    if not stopped:
        print(f"report of all: {directory / SCAN_REPORT}")


def _print_scripts(
    parts: Mapping[Path, Scan], profile: Profile | None, jobs: int, *, fresh: bool
) -> int:
    """Print the script of the first job of each scan; return the exit status."""
    if profile is None:
        raise InputError("--print: requires --submit; remove it, or add --submit PROFILE")
    machine = Machine(jobs, profile)
    for place, part in parts.items():
        batches = machine.batches(points_left(part, place, fresh=fresh), "batch")
        if batches:
            request = request_of(profile, batches[0], part.name, place.absolute())
            print(profile.script(request), end="")
    return 0


def _status(stopped: str | None, outcomes: Sequence[ScanOutcome]) -> int:
    """Print the remaining work; return the exit status."""
    if stopped == STOPPED:
        print(
            "granwave: interrupted; run the same command with --resume to continue",
            file=sys.stderr,
        )
        return 130
    if stopped:
        print(
            f"granwave: {stopped}; free disk space, then run the same command with --resume to "
            "continue",
            file=sys.stderr,
        )
        return 1
    for outcome in outcomes:
        left = " and ".join(
            f"{n} {what}"
            for n, what in ((outcome.failed, "failed"), (outcome.missing, "missing"))
            if n
        )
        if left:
            reasons = {
                p.reason.strip()
                for p in ScanResult(outcome.directory).points
                if p.status == "failed"
            }
            shared = ""
            if len(reasons) == 1:
                shared = f" ({in_shell(' '.join(reasons.pop().split()))})"
            print(f"granwave: {left} of the points{shared}; the reasons are in "
                f"{outcome.directory / 'scan.csv'}; the same command with --resume runs them again",
                  file=sys.stderr)  # fmt: skip
    return 0 if all(outcome.complete for outcome in outcomes) else 1


def _executor(options: argparse.Namespace) -> Profile | None:
    if options.submit is not None:
        if options.executor != LOCAL or options.profile:
            raise InputError(
                "--submit: cannot be combined with --executor or --profile; remove them"
            )
        profile = profile_of(options.submit)
        options.executor = profile.scheduler
        return profile
    if options.print:
        raise InputError("--print: requires --submit; remove it, or add --submit PROFILE")
    if options.executor not in EXECUTORS:
        hint = did_you_mean(options.executor, EXECUTORS)
        raise InputError(
            f"--executor: found {options.executor}, expected one of {', '.join(EXECUTORS)}{hint}"
        )
    if options.executor == LOCAL:
        if options.profile:
            raise InputError("--profile: requires --executor slurm; add it, or remove --profile")
        return None
    if not options.profile:
        return Profile(scheduler=options.executor)
    profile = load_profile(options.profile)
    check_executor(profile, options.executor, options.profile)
    return profile
