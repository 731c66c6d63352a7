"""Tables of the settings that runs of a report share."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from granwave.analysis.document.cells import show
from granwave.analysis.document.model import Block, Cell, Column, Group, Table
from granwave.analysis.formatting.units import unit_in_cases
from granwave.analysis.reports.inputs import Inputs, Run
from granwave.analysis.reports.sections.results import differing


def settings_blocks(inputs: Inputs) -> list[Block]:
    """Make tables of the settings that runs share, for each scan and for the runs given directly."""
    groups: list[tuple[str, list[Run], list[str]]] = []
    if inputs.runs:
        groups.append(("runs" if len(inputs.runs) > 1 else f"run {inputs.runs[0].label}", list(inputs.runs), []))
    groups += [
        (f"scan {scan.label}", [point.run for point in scan.points if point.run], list(scan.source.varied))
        for scan in inputs.scans
    ]
    blocks: list[Block] = []
    for title, runs, varied in groups:
        known = [run for run in runs if run.case]
        if not known:
            continue
        different = {*differing(known), *varied}
        shared = {key: value for key, value in known[0].case.items() if key not in different}
        cases = [run.case for run in known]
        rows = tuple((Cell(key), Cell(show(one)), Cell(unit_in_cases(key, cases))) for key, one in _spelt_out(shared))
        columns = (Column("Key", key=True), Column("Value"), Column("Unit"))
        who = f"all points of {title}" if varied else f"all {title}"
        name = f"Settings that {who} share" if len(known) > 1 else f"Settings of {title}"
        blocks.append(Group(name, (Table(name, columns, rows, captioned=False),), folded=True))
    return blocks


def _spelt_out(tables: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Iterate over values by full dotted key, including those of nested tables."""
    for name, value in tables.items():
        if isinstance(value, dict) and value:
            yield from _spelt_out(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value
