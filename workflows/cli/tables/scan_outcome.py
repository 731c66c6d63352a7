"""Outcome of a scan, as values and as a table."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

from granwave.analysis.document.model import named
from granwave.analysis.measures.incomplete_values import incomplete_in
from granwave.analysis.measures.law_range import contacts_beyond_law
from granwave.analysis.measures.zone_size import LABELS, bounds_in_words, zone_marks
from granwave.analysis.quantities import Quantity, quantity, scan_columns
from granwave.analysis.scans.headline import headline
from granwave.analysis.scans.means import means_of
from granwave.analysis.scans.result import REDUCTION, PointResult, ScanResult, protects
from granwave.workflows.cli.terminal import columns, in_shell
from granwave.workflows.scanning.driver import ScanOutcome

_MOST_ROWS = 40
_MOST_LABELS = 6  # values that a sentence names
_MOST_MEANS = 4  # quantities in the table of means


def outcome_values(outcome: ScanOutcome) -> dict[str, Any]:
    """Return the points of a scan with their values; missing points have no summary."""
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
    """Return the table of the main values of all points, and the directory of the results."""
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
    marks = [zone_marks(point.summary) for point in points]
    for mark, label in LABELS.items():
        if count := sum(mark in of_point for of_point in marks):
            text += (
                f"plastic zone: {label} in {count} of {len(points)} points, as marked in "
                "report and data of figures\n\n"
            )
    beyond = sum(contacts_beyond_law(point.summary) > 0 for point in points)
    if beyond:
        text += (
            f"contacts beyond the range of the law (0.2 R*) in {beyond} of {len(points)} points, "
            "as marked in figures and report\n\n"
        )
    text += _ends_in_words(points)
    counts = ", ".join(f"{getattr(outcome, name)} {name}" for name in ("done", "failed", "missing"))
    there = "the table"
    if (outcome.directory / "report.html").exists():
        there = "table, figures and report.html"
    return f"{text}{counts}; {there} in {outcome.directory}"


def _ends_in_words(points: Sequence[PointResult]) -> str:
    """Return a paragraph on values that the ends of runs limit, with the number of points; empty
    without such values.
    """
    limited = [incomplete_in(point.summary) for point in points]
    names = dict.fromkeys(itertools.chain.from_iterable(limited))
    labels = [quantity(name).label for name in names]
    labels = [f"{label[:1].lower()}{label[1:]}" for label in dict.fromkeys(filter(None, labels))]
    if not labels:
        return ""
    return (
        f"values that still change at the end of the run, in {sum(map(bool, limited))} of "
        f"{len(points)} points, as marked in figures: {named(labels, _MOST_LABELS)}; increase "
        "run.end_time\n\n"
    )


def _means_text(result: ScanResult) -> str:
    """Return the results of all points: means over replicates, if there are any, and a
    sentence.
    """
    means = means_of(result)
    shown = [key for _, key in means.quantities()]
    if not shown:
        return ""
    text = f"{headline(means)}\n\n"
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
    head = f"means of {of} replicates, with 95 % confidence intervals"
    if remark := means.remark(shown[:_MOST_MEANS]):
        head = f"{head} ({remark})"
    return f"{head}:\n{columns(rows)}\n\n{text}"


def _value(shown: Quantity, value: Any) -> str:
    """A value of a summary for the table at the end; empty where there is none."""
    if value is None:
        return ""
    return bounds_in_words(value) if isinstance(value, list) else format(value, shown.digits)
