"""`granwave scan` at the terminal: the plan, the bar, what came of it."""

from __future__ import annotations

import argparse
import dataclasses
import difflib
import sys
from pathlib import Path

from granwave.analysis.scan_result import ScanResult
from granwave.lammps_inputs.errors import InputError, RunError
from granwave.workflows.scanning import driver, layout
from granwave.workflows.scanning.batches import expected_time
from granwave.workflows.scanning.calibrate import slowness_of
from granwave.workflows.scanning.driver import ScanOutcome, default_jobs, run_scan
from granwave.workflows.scanning.engine import EXECUTORS, LOCAL, SLURM, check_installed
from granwave.workflows.scanning.profile import Profile, load_profile
from granwave.workflows.scanning.scan_file import Scan, load_scan
from granwave.workflows.tables import duration, lines

_WORTH_MEASURING = 20.0  # s of expected time, beyond which the speed of this machine is measured first
_MOST_ROWS = 40


def scan(options: argparse.Namespace) -> int:
    """Run it; returns the exit status."""
    profile = _executor(options)
    found = load_scan(options.scan, options.overrides, here=options.executor == LOCAL)
    directory = (options.directory or Path(found.name)).absolute()
    jobs = options.jobs or default_jobs(profile)
    if not options.plan:
        check_installed(options.executor)
        try:
            driver.decide(found, directory, resume=options.resume, force=options.force)
        except OSError as error:  # it cannot be looked into
            raise InputError(f"{directory}: {error.strerror or error}; choose another directory with -o") from None
    slowness = _slowness(found, directory, options, jobs)
    print(plan_text(found, directory, jobs, slowness, fresh=options.force))
    if options.plan:
        return 0
    sys.stdout.flush()
    try:
        outcome = run_scan(
            found,
            directory,
            executor=options.executor,
            profile=profile,
            jobs=options.jobs,
            resume=options.resume,
            force=options.force,
            progress=True,
            slowness=slowness or 1.0,
        )
    except OSError as error:  # a full disk, above all
        reason = error.strerror or error
        raise RunError(f"{directory}: {reason}; mend that, then the same command with --resume goes on") from error
    print(outcome_text(outcome))
    if outcome.stopped == driver.STOPPED:
        print("granwave: stopped before its end; the same command with --resume goes on", file=sys.stderr)
        return 130
    if outcome.stopped:
        print(f"granwave: {outcome.stopped}; make room, then the same command with --resume goes on", file=sys.stderr)
    elif not outcome.complete:
        left = " and ".join(
            f"{n} {what}" for n, what in ((outcome.failed, "failed"), (outcome.missing, "missing")) if n
        )
        print(f"granwave: {left} of the points; the reasons are in {directory / 'scan.csv'}; "
              "the same command with --resume tries them again", file=sys.stderr)  # fmt: skip
    return 0 if outcome.complete else 1


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
    """How much longer a point takes here than planned; None where it was not worth measuring."""
    left = [p for p in scan.distinct.values() if options.force or not layout.is_done(directory, p.id)]
    if options.executor == SLURM or sum(map(expected_time, left)) / jobs < _WORTH_MEASURING:
        return None
    typical = sorted(left, key=expected_time)[len(left) // 2]
    return slowness_of(typical)


def plan_text(scan: Scan, directory: Path, jobs: int, slowness: float | None, *, fresh: bool = False) -> str:
    """What the scan would be."""
    points = scan.distinct.values()
    left = [p for p in points if fresh or not layout.is_done(directory, p.id)]
    total = sum(expected_time(p, slowness or 1.0) for p in left)
    longest = max((expected_time(p, slowness or 1.0) for p in left), default=0.0)
    counts = f"{len(scan.points)}"
    if len(points) < len(scan.points):
        counts += f", {len(points)} of them different"
    if len(left) < len(points):
        counts += f", {len(points) - len(left)} done already"
    kinds = ", ".join(f"{key} ({len({str(p.labels[key]) for p in scan.points})})" for key in scan.varied)
    at_once = sorted((p.plan.memory for p in left), reverse=True)[:jobs]
    spheres = [p.plan.n_spheres for p in points]
    rows = [
        ("scan", scan.name),
        ("points", counts),
        ("varies", kinds),
        ("spheres", f"{min(spheres)}" if min(spheres) == max(spheres) else f"{min(spheres)} to {max(spheres)}"),
        ("jobs at once", f"{jobs}"),
        (
            "expected time",
            f"about {duration(max(total / jobs, longest))}" + (", from the speed measured here" if slowness else ""),
        ),
        ("memory", f"about {sum(at_once) / 2**30:.2f} GiB"),
        ("disk", f"about {sum(p.plan.disk for p in left) / 1e9:.3g} GB"),
        ("directory", str(directory)),
    ]
    return lines(rows)


def outcome_text(outcome: ScanOutcome) -> str:
    """The main values of each point, and where everything is."""
    result = ScanResult(outcome.directory)
    points = [point for point in result.points if point.status != "missing"]
    head = ["", *result.varied, "dissipated", "plastic spheres", "peak force (N)", ""]
    table = [head]
    for point in points[:_MOST_ROWS]:
        summary = point.summary
        values = [
            f"{summary['dissipated_fraction']:.5f}" if summary.get("dissipated_fraction") is not None else "",
            f"{summary['n_plastic_spheres']}" if summary else "",
            f"{summary['peak_force_N']:.5g}" if summary else "",
        ]
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
    text = f"{text}\n\n" if points else ""
    counts = ", ".join(
        f"{value} {field.name}"
        for field in dataclasses.fields(outcome)
        if field.name in ("done", "failed", "missing") and (value := getattr(outcome, field.name)) is not None
    )
    there = "table, figures and report.html" if (outcome.directory / "report.html").exists() else "the table"
    return f"{text}{counts}; {there} in {outcome.directory}"
