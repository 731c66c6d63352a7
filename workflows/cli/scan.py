"""Command ``granwave scan``: plan, run and outcome of scans and suites in the terminal."""

from __future__ import annotations

import argparse
import contextlib
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from granwave.analysis.formatting.numbers import duration
from granwave.analysis.measures.zone_size import LABELS, bounds_in_words, mark_of
from granwave.analysis.quantities import Quantity, quantity, scan_columns
from granwave.analysis.scans.keys import means_of
from granwave.analysis.scans.result import REDUCTION, ScanResult, protects
from granwave.lammps_inputs.case.made_packing import PackingNotMadeError, nothing_made
from granwave.lammps_inputs.case.schema import did_you_mean
from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import InputError, RunError, raise_all
from granwave.lammps_inputs.planning.plan import Plan
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import SCAN_REPORT
from granwave.workflows.cli.check import expected_cut, static_stage_note, table
from granwave.workflows.cli.submission import profile_of
from granwave.workflows.cli.terminal import columns, in_shell, print_json
from granwave.workflows.cluster.profile import Profile, check_executor, load_profile
from granwave.workflows.scanning.batches import Machine, slowness_of
from granwave.workflows.scanning.directory import check_points, decide, points_left
from granwave.workflows.scanning.driver import STOPPED, ScanOutcome, default_jobs, run_scan
from granwave.workflows.scanning.engine import EXECUTORS, LOCAL, request_of
from granwave.workflows.scanning.scan_file import Scan, ScanPoint, load_scan
from granwave.workflows.scanning.suite import Suite, check_suite, is_suite, load_suite, run_suite

_GIB = 2**30
_WORTH_MEASURING = 20.0  # s; for a longer expected time the speed of this machine is measured first
_PLANNED = 1000  # points that a plan is made of, taken at random: 5 to 20 s
_MOST_ROWS = 40
_MOST_MEANS = 4  # quantities in the table of means


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
        ("memory", f"about {memory / _GIB:.2f} GiB while they are generated"),
        ("made by", f"granwave scan {name}, before its first point"),
        ("the points", "are planned once their packings are generated"),
    ]
    print(table(rows))
    return 0


def _plan_and_run(options: argparse.Namespace, profile: Profile | None, jobs: int) -> int:
    found: Scan | Suite
    here = options.executor == LOCAL
    way = {"resume": options.resume, "force": options.force}
    if not is_suite(options.scan):
        found = load_scan(
            options.scan, options.overrides, here=here, most=_PLANNED if options.plan else None
        )
    elif options.overrides:
        raise InputError(
            f"--set: {options.scan} is a suite of scans with different cases; set keys in its "
            "scan files"
        )
    else:
        found = load_suite(options.scan, here=here)
    directory = results_directory(options.directory or found.name)
    results = ResultDirectory(directory)
    if not options.plan:
        try:
            decide(found, results, **way) if isinstance(found, Scan) else check_suite(
                found, results, **way
            )
        except OSError as error:  # it cannot be looked into
            raise InputError(
                f"{directory}: {error.strerror or error}; choose another directory with -o"
            ) from None
    parts = (
        {directory: found}
        if isinstance(found, Scan)
        else {directory / part.name: part for part in found.scans}
    )
    if options.print:
        return _print_scripts(parts, profile, jobs, fresh=options.force)
    slowness = {}
    plans = []
    for place, part in parts.items():
        left = sorted(
            points_left(part, place, fresh=options.force), key=lambda point: point.plan.wall_time
        )
        worth_measuring = (
            here and sum(point.plan.wall_time for point in left) / jobs >= _WORTH_MEASURING
        )
        measured = slowness_of(left[len(left) // 2], jobs) if worth_measuring else None
        slowness[part.name] = measured or 1.0
        plans.append(plan_values(part, place, left, Machine(jobs, profile, measured or 1.0)))
        if not options.json:
            print(plan_text(part, left, plans[-1], measured) + "\n" * isinstance(found, Suite))
    total = sum(values["wall_time_s"] for values in plans)
    if isinstance(found, Suite) and not options.json:
        print(f"suite {found.name}: {len(found.scans)} scans, about {duration(total)} in all\n")
    if options.plan:
        raise_all(
            partial(check_points, part, ResultDirectory(place), force=options.force)
            for place, part in parts.items()
        )
        if options.json:
            suite = {
                "name": found.name,
                "wall_time_s": total,
                "directory": directory,
                "scans": plans,
            }
            print_json(plans[0] if isinstance(found, Scan) else suite)
        return 0
    sys.stdout.flush()
    how = {
        "executor": options.executor,
        "jobs": options.jobs,
        "profile": profile,
        "progress": True,
        **way,
    }
    if isinstance(found, Scan):
        outcomes = [run_scan(found, directory, slowness=slowness[found.name], **how)]
    else:
        outcomes = list(run_suite(found, directory, slowness=slowness, **how).scans)
    stopped = outcomes[-1].stopped
    if options.json:
        scans = [outcome_values(outcome) for outcome in outcomes]
        suite = {"name": found.name, "directory": directory, "stopped": stopped, "scans": scans}
        print_json(scans[0] if isinstance(found, Scan) else suite)
    else:
        for outcome in outcomes:
            print(outcome_text(outcome) + "\n" * isinstance(found, Suite))
        if isinstance(found, Suite) and not stopped:
            print(f"report of all: {directory / SCAN_REPORT}")
    return _status(stopped, outcomes)


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


def plan_values(
    scan: Scan, directory: Path, left: Sequence[ScanPoint], machine: Machine
) -> dict[str, Any]:
    """Return the values of a planned scan with these points left to be run; units are part of the
    names.
    """
    points = scan.distinct.values()
    sizes = [point.size for point in points]
    parts = scan.points[0].kind.parts
    return {
        "name": scan.name,
        "directory": directory,
        "varied": list(scan.varied),
        "n_points": scan.n_points,
        "n_planned": len(scan.points),
        "n_distinct": len(points),
        "n_left": len(left),
        f"n_{parts}_least": min(sizes),
        f"n_{parts}_most": max(sizes),
        "jobs": machine.jobs,
        "wall_time_s": scan.scale * machine.time(left),
        "memory_bytes": sum(
            sorted((point.plan.memory for point in left), reverse=True)[: machine.jobs]
        ),
        "disk_bytes": scan.scale * sum(point.plan.disk for point in left),
    }


def plan_text(
    scan: Scan, left: Sequence[ScanPoint], values: Mapping[str, Any], slowness: float | None
) -> str:
    """Return the table of a planned scan of these `plan_values`."""
    points = scan.distinct.values()
    parts = scan.points[0].kind.parts
    jobs = values["jobs"]
    counts = f"{scan.n_points}"
    if scan.scale > 1:
        counts += f", planned from {len(scan.points)} random points; a run checks all"
    if len(points) < len(scan.points):
        counts += f", {len(points)} of them different"
    if len(left) < len(points):
        counts += f", {len(points) - len(left)} done already"
    least = values[f"n_{parts}_least"]
    most = values[f"n_{parts}_most"]
    measured = ", from the speed measured here" if slowness else ""
    times = [p.plan.times for p in left if isinstance(p.plan, Plan)]
    unknown = [time for time in times if time.most_static > time.static]
    zones = [p.plan.zone for p in points if isinstance(p.plan, Plan) and p.plan.zone]
    cut = sum(bool(zone.reaches and expected_cut(zone)) for zone in zones)
    static = static_stage_note(unknown, jobs / (slowness or 1.0)) if unknown else ""
    reaches = ""
    if cut:
        reaches = f"expected to reach a boundary of the packing in {cut} of {len(points)} points"
    return table(
        [
            ("scan", scan.name),
            ("points", counts),
            ("varies", ", ".join(f"{key} ({scan.n_values_of(key)})" for key in scan.varied)),
            (parts, f"{least} to {most}" if most > least else f"{least}"),
            ("jobs at once", f"{jobs}"),
            ("expected time", f"about {duration(values['wall_time_s'])}{measured}"),
            ("static stages", static),
            ("memory", f"about {values['memory_bytes'] / 2**30:.2f} GiB"),
            ("disk", f"about {values['disk_bytes'] / 1e9:.3g} GB"),
            ("plastic zone", reaches),
            ("directory", str(values["directory"])),
        ]
    )


def outcome_values(outcome: ScanOutcome) -> dict[str, Any]:
    """Return the points of a scan with their values; those that are missing have no summary."""
    result = ScanResult(outcome.directory)
    shown = ("number", "status", "reason", "directory", "labels", "summary")
    return {
        "name": result.name,
        "directory": outcome.directory,
        **{name: getattr(outcome, name) for name in ("done", "failed", "missing", "stopped")},
        "varied": list(result.varied),
        "points": [{name: getattr(point, name) for name in shown} for point in result.points],
    }


def outcome_text(outcome: ScanOutcome) -> str:
    """Return the table of the main values of all points, and the place of the results."""
    result = ScanResult(outcome.directory)
    points = [point for point in result.points if point.status != "missing"]
    asked = (
        [quantity(REDUCTION)]
        if protects(result.varied, [point.summary for point in points])
        else []
    )
    shown = [
        one
        for one in [*asked, *scan_columns()]
        if any(point.summary.get(one.name) is not None for point in points)
    ]
    head = ["", *result.varied, *(one.heading for one in shown), ""]
    rows = [head]
    for point in points[:_MOST_ROWS]:
        summary = point.summary
        values = [_value(one, summary.get(one.name)) for one in shown]
        labels = [
            f"{value:.5g}" if isinstance(value, float) else str(value)
            for value in point.labels.values()
        ]
        ending = ""
        if point.status != "done":
            ending = in_shell(f"{point.status}: {point.reason}".rstrip(": "))
        rows.append([str(point.number), *labels, *values, ending])
    text = columns(rows, left=(len(head) - 1,))
    if len(points) > _MOST_ROWS:
        text += f"\n... {len(points) - _MOST_ROWS} more in scan.csv"
    text = f"{text}\n\n{_means_text(result)}" if points else ""
    marks = [mark_of(point.summary) for point in points]
    for mark, label in LABELS.items():
        if count := marks.count(mark):
            text += (
                f"plastic zone: {label} in {count} of {len(points)} points, as marked in "
                "figures and report\n\n"
            )
    counts = ", ".join(f"{getattr(outcome, name)} {name}" for name in ("done", "failed", "missing"))
    there = "the table"
    if (outcome.directory / "report.html").exists():
        there = "table, figures and report.html"
    return f"{text}{counts}; {there} in {outcome.directory}"


def _means_text(result: ScanResult) -> str:
    """Return the results of all points: means over replicates, if there are any, and a
    sentence.
    """
    means = means_of(result)
    shown = [key for _, key in means.quantities()]
    if not shown:
        return ""
    text = f"{means.sentence(shown[0])}\n\n"
    if max(means.counts) < 2:
        return text
    units = [(key.naming.label, key.naming.unit) for key in means.keys]
    units += [
        (quantity(name).label, quantity(name).unit.replace("^", "")) for name in shown[:_MOST_MEANS]
    ]
    rows = [[f"{label} ({unit})" if unit else label for label, unit in units]]
    for row in range(min(len(means.counts), _MOST_ROWS)):
        values = [means.text(name, row) for name in shown[:_MOST_MEANS]]
        rows.append([*(key.tick(row) for key in means.keys), *values])
    counts = sorted(set(means.counts))
    of = f"{counts[0]} to {counts[-1]}" if len(counts) > 1 else f"{counts[0]}"
    return f"means of {of} replicates, with 95 % confidence intervals:\n{columns(rows)}\n\n{text}"


def _value(shown: Quantity, value: Any) -> str:
    """A value of a summary for the table at the end; empty where there is none."""
    if value is None:
        return ""
    return bounds_in_words(value) if isinstance(value, list) else format(value, shown.digits)
