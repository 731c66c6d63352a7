"""Section comparing values of the sources with the same cases of a report, with errata of the sources."""

from __future__ import annotations

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
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.errors import GranwaveError
from granwave.lammps_inputs.load_case import load_case
from granwave.lammps_inputs.run_directory import CASE_FILE

SLUG = "sources"
_FILE = Path(__file__).with_name("source_values.toml")
_SAME = 1e-9  # relative difference of numbers that count as equal
_OF_CONTACT = ("F_y", "alpha_y", "yield_force_N", "yield_overlap_m")
_MOST_NAMED = 4

_COLUMNS = (
    Column("Quantity", key=True),
    Column("Run", key=True),
    Column("Source gives", numeric=True),
    Column("Ours", numeric=True),
    Column("Difference", numeric=True),
    Column("Within its rounding"),
    Column("Source"),
    Column("Remark"),
)


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
    rows = [row for entry in values["values"] for row in _rows(entry, runs, values)]
    blocks: list[Table | Note | Group] = []
    if rows:
        blocks.append(
            Note(
                "Single values that the sources give for a case of this report. The rounding is half a unit of the "
                "last digit that a source gives, unless the remark says otherwise."
            )
        )
        blocks.append(Table("Source against ours", _COLUMNS, tuple(rows), sortable=True, captioned=False, by_row=True))
    errata = [entry for entry in values["errata"] if any(applies(entry, run.case, values) for run in runs)]
    if errata:
        columns = (Column("Where", key=True), Column("Printed"), Column("Right, or what to make of it"))
        lines = tuple((Cell(e["where"], e["where"]), Cell(e["printed"]), Cell(e["right"])) for e in errata)
        table = Table("Errata of the sources", columns, lines, captioned=False)
        blocks.append(Group("Errata of the sources that bear on these cases", (table,), folded=True))
    return Section("Source against ours" if rows else "Errata of the sources", SLUG, tuple(blocks))


def _rows(entry: Mapping[str, Any], runs: Iterable[Run], values: Mapping[str, Any]) -> Iterator[tuple[Cell, ...]]:
    """Iterate over rows, one for each of our values; runs with exactly equal values share a row."""
    found: dict[float, list[str]] = {}
    for run in runs:
        if applies(entry, run.case, values):
            ours = _ours(entry, run)
            if ours is not None:
                found.setdefault(ours, []).append(run.label)
    scale, label = entry.get("scale", ""), quantity(entry["quantity"]).label
    unit = scale if scale in _OF_CONTACT else "" if scale else unit_of_value(entry["quantity"])
    if scale and scale not in _OF_CONTACT:
        name = f"{label} over {quantity(scale).label.lower()}"
    else:
        name = label + (f" ({unit})" if unit else "")
    theirs = entry["value"]
    for ours, labels in found.items():
        difference = 100 * (ours - theirs) / theirs
        within = abs(ours - theirs) <= entry["rounding"] * (1 + 1e-6)
        yield (
            Cell(name, name),
            Cell(named(labels, _MOST_NAMED), labels[0]),
            value_cell(theirs),
            value_cell(ours),
            Cell(percent(difference), difference),
            Cell("yes" if within else "no", "yes" if within else "no", tone="good" if within else "note"),
            Cell(entry["source"], entry["source"]),
            Cell(entry.get("remark", ""), entry.get("remark", "")),
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
