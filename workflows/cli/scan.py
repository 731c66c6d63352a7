"""Command ``granwave scan``: plan, run and outcome of scans and suites in the terminal."""

from __future__ import annotations

import argparse
import dataclasses
import difflib
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from granwave.analysis.formatting.numbers import duration
from granwave.analysis.measures.zone.marks import LABELS, bounds_in_words, mark_of
from granwave.analysis.quantities import SCAN_COLUMNS, Quantity, quantity
from granwave.analysis.scans.means import means_of
from granwave.analysis.scans.result import REDUCTION, ScanResult, protects
from granwave.analysis.summary_table import lines
from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import InputError, RunError, raise_all
from granwave.lammps_inputs.planning.plan import Plan
from granwave.lammps_inputs.run_directory import SCAN_REPORT
from granwave.workflows.cli.check import expected_cut, static_stage_note
from granwave.workflows.cli.terminal import print_json
from granwave.workflows.scanning.batches import expected_scan_time, expected_time, slowness_of
from granwave.workflows.scanning.directory import check_points, decide, points_left
from granwave.workflows.scanning.driver import STOPPED, ScanOutcome, default_jobs, run_scan
from granwave.workflows.scanning.engine import EXECUTORS, LOCAL, SLURM, check_installed
from granwave.workflows.scanning.scan_file import Scan, load_scan
from granwave.workflows.scanning.slurm import Profile, load_profile
from granwave.workflows.scanning.suite import Suite, check_suite, is_suite, load_suite, run_suite

_WORTH_MEASURING = 20.0  # s; for a longer expected time the speed of this machine is measured first
_PLANNED = 1000  # points that a plan is made of, taken at random: 5 to 20 s
_MOST_ROWS = 40
_MOST_MEANS = 4  # quantities in the table of means


def scan(options: argparse.Namespace) -> int:
    """Run a scan or suite; return the exit status."""
    profile = _executor(options)
    jobs = options.jobs or default_jobs(profile)
    try:
        if is_suite(options.scan):
            return _suite(options, profile, jobs)
        return _scan(options, profile, jobs)
    except BrokenPipeError:
        raise  # the reader of the plan has closed it
    except OSError as error:  # usually a full disk
        place = error.filename or options.directory or options.scan
        reason = error.strerror or error
        raise RunError(f"{place}: {reason}; mend that, then the same command with --resume goes on") from error


def _scan(options: argparse.Namespace, profile: Profile | None, jobs: int) -> int:
    most = _PLANNED if options.plan else None
    found = load_scan(options.scan, options.overrides, here=options.executor == LOCAL, most=most)
    directory = results_directory(options.directory or found.name)
    if not options.plan:
        check_installed(options.executor)
        _check(decide, found, directory, options)
    slowness = _slowness(found, directory, options, jobs)
    if not options.json:
        print(plan_text(found, directory, profile, jobs, slowness, fresh=options.force))
    if options.plan:
        check_points(found, directory, force=options.force)
        if options.json:
            print_json(plan_values(found, directory, profile, jobs, slowness, fresh=options.force))
        return 0
    sys.stdout.flush()
    outcome = run_scan(found, directory, slowness=slowness or 1.0, **_how(options, profile))
    print_json(outcome_values(outcome)) if options.json else print(outcome_text(outcome))
    return _status(outcome.stopped, [outcome])


def _suite(options: argparse.Namespace, profile: Profile | None, jobs: int) -> int:
    if options.overrides:
        raise InputError(
            f"--set: {options.scan} is a suite of scans, which have different cases; set keys in its scan files"
        )
    found = load_suite(options.scan, here=options.executor == LOCAL)
    directory = results_directory(options.directory or found.name)
    if not options.plan:
        check_installed(options.executor)
        _check(check_suite, found, directory, options)
    slowness: dict[str, float] = {}
    plans = []
    for part in found.scans:
        place = directory / part.name
        measured = _slowness(part, place, options, jobs)
        slowness[part.name] = measured or 1.0
        if options.json:
            plans.append(plan_values(part, place, profile, jobs, measured, fresh=options.force))
        else:
            print(plan_text(part, place, profile, jobs, measured, fresh=options.force) + "\n")
    total = sum(
        expected_scan_time(
            points_left(part, directory / part.name, fresh=options.force), profile, jobs, slowness[part.name]
        )
        for part in found.scans
    )
    if not options.json:
        print(f"suite {found.name}: {len(found.scans)} scans, about {duration(total)} in all\n")
    if options.plan:
        raise_all(partial(check_points, part, directory / part.name, force=options.force) for part in found.scans)
        if options.json:
            print_json({"name": found.name, "wall_time_s": total, "directory": directory, "scans": plans})
        return 0
    sys.stdout.flush()
    outcome = run_suite(found, directory, slowness=slowness, **_how(options, profile))
    if options.json:
        scans = [outcome_values(done) for done in outcome.scans]
        print_json({"name": found.name, "directory": directory, "stopped": outcome.stopped, "scans": scans})
        return _status(outcome.stopped, outcome.scans)
    for done in outcome.scans:
        print(f"{outcome_text(done)}\n")
    if not outcome.stopped:
        print(f"report of all: {directory / SCAN_REPORT}")
    return _status(outcome.stopped, outcome.scans)


def _how(options: argparse.Namespace, profile: Profile | None) -> dict[str, Any]:
    return {
        "executor": options.executor,
        "profile": profile,
        "jobs": options.jobs,
        "resume": options.resume,
        "force": options.force,
        "progress": True,
    }


def _check(may_run: Callable[..., None], found: Scan | Suite, directory: Path, options: argparse.Namespace) -> None:
    try:
        may_run(found, directory, resume=options.resume, force=options.force)
    except OSError as error:  # it cannot be looked into
        raise InputError(f"{directory}: {error.strerror or error}; choose another directory with -o") from None


def _status(stopped: str | None, outcomes: Sequence[ScanOutcome]) -> int:
    """Say what is left to do; returns the exit status."""
    if stopped == STOPPED:
        print("granwave: stopped before its end; the same command with --resume goes on", file=sys.stderr)
        return 130
    if stopped:
        print(f"granwave: {stopped}; make room, then the same command with --resume goes on", file=sys.stderr)
        return 1
    for outcome in outcomes:
        left = " and ".join(
            f"{n} {what}" for n, what in ((outcome.failed, "failed"), (outcome.missing, "missing")) if n
        )
        if left:
            print(f"granwave: {left} of the points{_reasons(outcome)}; the reasons are in "
                  f"{outcome.directory / 'scan.csv'}; the same command with --resume tries them again",
                  file=sys.stderr)  # fmt: skip
    return 0 if all(outcome.complete for outcome in outcomes) else 1


def _reasons(outcome: ScanOutcome) -> str:
    """Return the reason why points failed, if all have the same; empty otherwise."""
    found = {point.reason.strip() for point in ScanResult(outcome.directory).points if point.status == "failed"}
    return f" ({' '.join(found.pop().split())})" if len(found) == 1 else ""


def _executor(options: argparse.Namespace) -> Profile | None:
    if options.executor not in EXECUTORS:
        near = difflib.get_close_matches(options.executor, EXECUTORS, n=1)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise InputError(f"--executor: found {options.executor}, expected {' or '.join(EXECUTORS)}{hint}")
    if options.executor == LOCAL:
        if options.profile:
            raise InputError("--profile: is for --executor slurm; leave it out, or choose that")
        return None
    return load_profile(options.profile) if options.profile else Profile()


def _slowness(scan: Scan, directory: Path, options: argparse.Namespace, jobs: int) -> float | None:
    """Measure the time of a point on this machine over the planned one; None if not worth measuring."""
    left = points_left(scan, directory, fresh=options.force)
    if options.executor == SLURM or sum(map(expected_time, left)) / jobs < _WORTH_MEASURING:
        return None
    typical = sorted(left, key=expected_time)[len(left) // 2]
    return slowness_of(typical, jobs)


def plan_text(
    scan: Scan,
    directory: Path,
    profile: Profile | None,
    jobs: int,
    slowness: float | None,
    *,
    fresh: bool = False,
) -> str:
    """Return the table of a planned scan."""
    points = scan.distinct.values()
    left = points_left(scan, directory, fresh=fresh)
    counts = f"{scan.n_points}"
    if scan.scale > 1:
        counts += f", planned from {len(scan.points)} of them, taken at random; a run checks all"
    if len(points) < len(scan.points):
        counts += f", {len(points)} of them different"
    if len(left) < len(points):
        counts += f", {len(points) - len(left)} done already"
    kinds = ", ".join(f"{key} ({scan.n_values_of(key)})" for key in scan.varied)
    at_once = sorted((p.plan.memory for p in left), reverse=True)[:jobs]
    sizes = [p.size for p in points]
    times = [p.plan.times for p in left if isinstance(p.plan, Plan)]
    unknown = [time for time in times if time.most_static > time.static]
    zones = [p.plan.zone for p in points if isinstance(p.plan, Plan) and p.plan.zone]
    cut = sum(bool(zone.reaches and expected_cut(zone)) for zone in zones)
    rows = [
        ("scan", scan.name),
        ("points", counts),
        ("varies", kinds),
        (scan.points[0].kind.parts, f"{min(sizes)}" + (f" to {max(sizes)}" if max(sizes) > min(sizes) else "")),
        ("jobs at once", f"{jobs}"),
        (
            "expected time",
            f"about {duration(scan.scale * expected_scan_time(left, profile, jobs, slowness or 1.0))}"
            + (", from the speed measured here" if slowness else ""),
        ),
        *([("static stages", static_stage_note(unknown, jobs / (slowness or 1.0)))] if unknown else []),
        ("memory", f"about {sum(at_once) / 2**30:.2f} GiB"),
        ("disk", f"about {scan.scale * sum(p.plan.disk for p in left) / 1e9:.3g} GB"),
        *([("plastic zone", f"expected to reach a bound of the packing in {cut} of {len(points)} points")] * bool(cut)),
        ("directory", str(directory)),
    ]
    return lines(rows)


def plan_values(
    scan: Scan, directory: Path, profile: Profile | None, jobs: int, slowness: float | None, *, fresh: bool = False
) -> dict[str, Any]:
    """Return the values of a planned scan; units are part of the names."""
    points, left = scan.distinct.values(), points_left(scan, directory, fresh=fresh)
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
        "jobs": jobs,
        "wall_time_s": scan.scale * expected_scan_time(left, profile, jobs, slowness or 1.0),
        "memory_bytes": sum(sorted((point.plan.memory for point in left), reverse=True)[:jobs]),
        "disk_bytes": scan.scale * sum(point.plan.disk for point in left),
    }


def outcome_values(outcome: ScanOutcome) -> dict[str, Any]:
    """Return the points of a scan with their values; those that are missing have no summary."""
    result = ScanResult(outcome.directory)
    points = [
        {
            "number": point.number,
            "status": point.status,
            "reason": point.reason,
            "directory": point.directory,
            "labels": dict(point.labels),
            "summary": dict(point.summary),
        }
        for point in result.points
    ]
    counts = {name: getattr(outcome, name) for name in ("done", "failed", "missing", "stopped")}
    return {
        "name": result.name,
        "directory": outcome.directory,
        **counts,
        "varied": list(result.varied),
        "points": points,
    }


def outcome_text(outcome: ScanOutcome) -> str:
    """Return the table of the main values of all points, and the place of the results."""
    result = ScanResult(outcome.directory)
    points = [point for point in result.points if point.status != "missing"]
    asked = [quantity(REDUCTION)] if protects(result.varied, [point.summary for point in points]) else []
    columns = [*asked, *SCAN_COLUMNS]
    shown = [one for one in columns if any(point.summary.get(one.name) is not None for point in points)]
    head = ["", *result.varied, *(one.heading for one in shown), ""]
    table = [head]
    for point in points[:_MOST_ROWS]:
        summary = point.summary
        values = [_value(one, summary.get(one.name)) for one in shown]
        labels = [f"{value:.5g}" if isinstance(value, float) else str(value) for value in point.labels.values()]
        ending = "" if point.status == "done" else f"{point.status}: {point.reason}".rstrip(": ")
        table.append([str(point.number), *labels, *values, ending])
    widths = [max(len(row[n]) for row in table) for n in range(len(head) - 1)]
    text = "\n".join(
        "  ".join([*(f"{cell:>{width}}" for cell, width in zip(row, widths, strict=False)), row[-1]]).rstrip()
        for row in table
    )
    if len(points) > _MOST_ROWS:
        text += f"\n... {len(points) - _MOST_ROWS} more in scan.csv"
    text = f"{text}\n\n{_means_text(result)}" if points else ""
    marks = [mark_of(point.summary) for point in points]
    for mark, label in LABELS.items():
        if count := marks.count(mark):
            text += f"plastic zone: {label} in {count} of {len(points)} points, which figures and report mark\n\n"
    counts = ", ".join(
        f"{value} {field.name}"
        for field in dataclasses.fields(outcome)
        if field.name in ("done", "failed", "missing") and (value := getattr(outcome, field.name)) is not None
    )
    there = "table, figures and report.html" if (outcome.directory / "report.html").exists() else "the table"
    return f"{text}{counts}; {there} in {outcome.directory}"


def _means_text(result: ScanResult) -> str:
    """Return what the points say together: means over replicates, if there are some, and a sentence."""
    means = means_of(result)
    shown = [key for _, key in means.quantities()]
    if not shown:
        return ""
    text = f"{means.sentence(shown[0])}\n\n"
    if max(means.counts) < 2:
        return text
    units = [(key.naming.label, key.naming.unit) for key in means.keys]
    units += [(quantity(name).label, quantity(name).unit.replace("^", "")) for name in shown[:_MOST_MEANS]]
    rows = [[f"{label} ({unit})" if unit else label for label, unit in units]]
    for row in range(min(len(means.counts), _MOST_ROWS)):
        values = [means.text(name, row) for name in shown[:_MOST_MEANS]]
        rows.append([*(key.tick(row) for key in means.keys), *values])
    widths = [max(len(row[n]) for row in rows) for n in range(len(units))]
    table = ["  ".join(f"{cell:>{width}}" for cell, width in zip(row, widths, strict=True)) for row in rows]
    counts = sorted(set(means.counts))
    of = f"{counts[0]} to {counts[-1]}" if len(counts) > 1 else f"{counts[0]}"
    return f"means of {of} replicates, with 95 % confidence intervals:\n" + "\n".join(table) + f"\n\n{text}"


def _value(shown: Quantity, value: Any) -> str:
    """A value of a summary for the table at the end; empty where there is none."""
    if value is None:
        return ""
    return bounds_in_words(value) if isinstance(value, list) else format(value, shown.digits)
