"""Every built-in scan is run to its report: the points that cost least, cut short where they take more than a second."""

from __future__ import annotations

import contextlib
import dataclasses
from pathlib import Path

import pytest

from granwave.analysis.scans.result import ScanResult
from granwave.lammps_inputs.case.parse import apply_overrides
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_toml
from granwave.workflows import library, load_scan
from granwave.workflows.scanning.driver import run_scan
from granwave.workflows.scanning.scan_file import Point, Scan
from granwave.workflows.scanning.suite import is_suite
from granwave.workflows.solvers import GRANULAR

pytestmark = pytest.mark.validation

SCANS = [name for name in library.names(library.SCANS) if not is_suite(name)]
_POINTS = 3
_LONGEST = 1.0  # s, of a point
_LEAST = 0.4  # of the end time of a run with a load that is not an impact
_ELEMENTS = 1000  # of a finite-element mesh


def smallest(scan: Scan) -> Scan:
    """The points that cost least, cut short; among them one with the last value of the first key, to vary it."""
    cheap = sorted(scan.distinct.values(), key=lambda point: point.plan.wall_time)
    first = scan.varied[0]
    unlike = [point for point in cheap if point.labels[first] != cheap[0].labels[first]]
    chosen = {point.id: point for point in [cheap[0], *unlike[:1], *cheap[1:]]}
    points = sorted(list(chosen.values())[:_POINTS], key=lambda point: point.number)
    return dataclasses.replace(scan, points=tuple(map(short, points)))


def short(point: Point) -> Point:
    """The point in a second or so, as far as its case allows: it ends sooner, on a coarser mesh."""
    tables = point.case.to_dict()
    struck = tables.get("load", {}).get("kind") == "impact"  # other loads may begin late
    share = max(_LONGEST / point.plan.wall_time, 0.0 if struck else _LEAST)
    if share >= 1:
        return point
    end = tables.get("run", {}).get("end_time")
    tries = [{"run.elements": _ELEMENTS}] if point.kind is not GRANULAR else []
    tries += [{"run.end_time": end * share}] if isinstance(end, float) else []
    for changes in tries:
        with contextlib.suppress(InputError):
            tables = point.kind.read(apply_overrides(tables, changes), Path("case.toml")).to_dict()
    case = point.kind.read(tables, Path("case.toml"))
    return dataclasses.replace(point, case=case, plan=point.kind.cost(case, 1, False), ranks=1)


@pytest.mark.parametrize("name", SCANS)
def test_a_built_in_scan_ends_with_its_report(tmp_path, name):
    scan = smallest(load_scan(name, here=False))
    outcome = run_scan(scan, tmp_path / name, jobs=1)
    reasons = [point.reason for point in ScanResult(outcome.directory).points if point.status != "done"]
    assert outcome.complete, reasons
    text = (outcome.directory / "report.html").read_text(encoding="utf-8")
    assert "could not be made" not in text


def test_every_suite_is_made_of_these_scans():
    suites = [name for name in library.names(library.SCANS) if name not in SCANS]
    for suite in suites:
        scans = read_toml(library.find(suite, library.SCANS))["scans"]
        assert {Path(one).stem for one in scans} <= set(SCANS)
