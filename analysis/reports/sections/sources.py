"""Section comparing values of the sources with the same cases of a report, with errata of the sources."""

from __future__ import annotations

import dataclasses
import math
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from granwave.analysis.document.cells import named, percent, unit_of_value, value_cell
from granwave.analysis.document.model import Cell, Column, Group, Note, Section, Table
from granwave.analysis.quantities import quantity
from granwave.analysis.reports.inputs import Inputs, Run
from granwave.analysis.studies.study import Row
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.errors import GranwaveError
from granwave.lammps_inputs.load_case import load_case
from granwave.lammps_inputs.run_directory import CASE_FILE

SLUG = "sources"
_FILE = Path(__file__).with_name("source_values.toml")
_SAME = 1e-9  # relative difference of numbers that count as equal
_OF_CONTACT = ("F_y", "alpha_y", "yield_force_N", "yield_overlap_m")
_MOST_NAMED = 4

_TABLES = (
    (False, "Source against ours",
     "Single values that the sources give for a case of this report. The rounding is half a unit of the last digit "
     "that a source gives, unless the remark says otherwise. A formula takes the case alone, and no run."),
    (True, "Verification of the code",
     "Values of our second solver, or of a formula by hand: they test the code, not a source."),
)  # fmt: skip


@dataclasses.dataclass(frozen=True)
class Compared:
    """A value of the sources beside ours, from runs of one value."""

    row: Row
    labels: tuple[str, ...]
    within: bool


@cache
def source_values() -> dict[str, Any]:
    """Read ``source_values.toml``."""
    return tomllib.loads(_FILE.read_text(encoding="utf-8"))


def applies(entry: Mapping[str, Any], case: Mapping[str, Any], values: Mapping[str, Any]) -> bool:
    """Return True if a case fulfils all conditions of an entry.

    Parameters
    ----------
    entry
        Entry of ``[[values]]`` or ``[[errata]]``.
    case
        Case by dotted key.
    values
        Content of ``source_values.toml``, for its named conditions.
    """
    wanted = dict(entry.get("conditions", {}))
    for name in entry.get("cases", ()):
        wanted |= values["cases"][name]
    return bool(wanted) and all(key in case and _same(case[key], value) for key, value in wanted.items())


def sources_section(inputs: Inputs) -> Section:
    """Make the section of the report; without blocks if the sources do not cover its cases."""
    values = source_values()
    runs = list(inputs.results())
    found = [one for entry in values["values"] for one in _compared(entry, runs, values)]
    blocks: list[Table | Note | Group] = []
    for verification, caption, text in _TABLES:
        rows = tuple(_cells(one) for one in found if one.row.verification is verification)
        if rows:
            columns = _columns("Must be" if verification else "Source gives")
            blocks += [Note(text), Table(caption, columns, rows, sortable=True, captioned=verification, by_row=True)]
    errata = [entry for entry in values["errata"] if any(applies(entry, run.case, values) for run in runs)]
    if errata:
        columns = (Column("Where", key=True), Column("Printed"), Column("Right, or what to make of it"))
        lines = tuple((Cell(e["where"], e["where"]), Cell(e["printed"]), Cell(e["right"])) for e in errata)
        table = Table("Errata of the sources", columns, lines, captioned=False)
        blocks.append(Group("Errata of the sources that bear on these cases", (table,), folded=True))
    return Section("Source against ours" if found else "Errata of the sources", SLUG, tuple(blocks))


def source_rows(inputs: Inputs) -> list[Row]:
    """Rows of all values that the sources give for the cases of a report."""
    values, runs = source_values(), list(inputs.results())
    return [one.row for entry in values["values"] for one in _compared(entry, runs, values)]


def _compared(entry: Mapping[str, Any], runs: Iterable[Run], values: Mapping[str, Any]) -> Iterator[Compared]:
    """Iterate over our values; runs with exactly equal values share one."""
    found: dict[float, list[str]] = {}
    for run in runs:
        if applies(entry, run.case, values):
            ours = _ours(entry, run)
            if ours is not None:
                found.setdefault(ours, []).append(run.label)
    scale, label = entry.get("scale", ""), quantity(entry["quantity"]).label
    unit = scale if scale in _OF_CONTACT else "" if scale else unit_of_value(entry["quantity"])
    name = label
    if scale and scale not in _OF_CONTACT:
        name = f"{label} over {quantity(scale).label.lower()}"
    theirs, kind = entry["value"], entry.get("kind", "source")
    for ours, labels in found.items():
        row = Row(
            name,
            unit,
            None if kind == "verification" else theirs,
            None if kind == "formula" else ours,
            entry["source"],
            entry.get("remark", ""),
            {"source": None, "formula": ours, "verification": theirs}[kind],
            kind == "verification",
        )
        yield Compared(row, tuple(labels), abs(ours - theirs) <= entry["rounding"] * (1 + 1e-6))


def _columns(given: str) -> tuple[Column, ...]:
    numbers = (given, "Ours", "Formula", "Difference")
    return (
        Column("Quantity", key=True), Column("Run", key=True), *(Column(one, numeric=True) for one in numbers),
        Column("Within its rounding"), Column("Source"), Column("Remark"),
    )  # fmt: skip


def _cells(one: Compared) -> tuple[Cell, ...]:
    row = one.row
    given, formula = (row.theory, None) if row.verification else (row.source, row.theory)
    ours = formula if row.ours is None else row.ours
    assert given is not None and ours is not None
    name = f"{row.quantity} ({row.unit})" if row.unit else row.quantity
    difference, within = 100 * (ours / given - 1), "yes" if one.within else "no"
    return (
        Cell(name, name),
        Cell(named(one.labels, _MOST_NAMED), one.labels[0]),
        value_cell(given),
        value_cell(row.ours),
        value_cell(formula),
        Cell(percent(difference), difference),
        Cell(within, within, tone="good" if one.within else "note"),
        Cell(row.where, row.where),
        Cell(row.remark, row.remark),
    )


def _ours(entry: Mapping[str, Any], run: Run) -> float | None:
    value = _value(entry["quantity"], run)
    scale = _value(entry["scale"], run) if "scale" in entry else 1.0
    if value is None or not scale or not math.isfinite(value / scale):
        return None
    return value / scale


def _value(key: str, run: Run) -> float | None:
    if key not in _OF_CONTACT:
        return run.number(key)
    try:
        law = sphere_contact(load_case(run.directory / CASE_FILE))
    except GranwaveError:
        return None
    return law.yield_force if key in ("F_y", "yield_force_N") else law.yield_overlap


def _same(found: Any, wanted: Any) -> bool:
    if isinstance(wanted, list):
        return (
            isinstance(found, list)
            and len(found) == len(wanted)
            and all(_same(a, b) for a, b in zip(found, wanted, strict=True))
        )
    if isinstance(found, (int, float)) and isinstance(wanted, (int, float)):
        return math.isclose(found, wanted, rel_tol=_SAME)
    return found == wanted
