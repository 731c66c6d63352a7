"""Points of a force or displacement against time, in a case or in a file of two columns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.case.schema import ErrorList, ValidationError, finite, show
from granwave.lammps_inputs.case.si_values import impossible
from granwave.lammps_inputs.files import read_text

_TABLE_FORM = "rows [time in s, value], at least two, times rising from 0 on"


def parse_load_table(value: Any) -> tuple[tuple[float, float], ...]:
    if not isinstance(value, list | tuple) or len(value) < 2:
        raise ValidationError(_TABLE_FORM)
    if any(not isinstance(row, list | tuple) or len(row) != 2 for row in value):
        raise ValidationError(_TABLE_FORM)
    rows = tuple((finite(time, _TABLE_FORM), finite(size, _TABLE_FORM)) for time, size in value)
    if rows[0][0] < 0 or any(later[0] <= earlier[0] for earlier, later in pairwise(rows)):
        raise ValidationError(_TABLE_FORM)
    if expected := impossible([time for time, _ in rows], "s"):
        raise ValidationError(f"times of {expected}")
    if not any(size for _, size in rows):
        raise ValidationError("a value other than zero")
    return rows


def read_load_file(table: Mapping[str, Any], errors: ErrorList) -> dict[str, Any]:
    name = table["file"]
    if "table" in table:
        errors.add("load.file", "found beside load.table; give one of them")
        return {}
    if not isinstance(name, str) or not name:
        errors.add("load.file", f"found {show(name)}, expected the path of a file of two columns, time and value")
        return {}
    try:
        rows = _numbers(read_text(Path(name)).splitlines())
    except OSError as error:
        errors.add("load.file", f"{name}: cannot be read: {error.strerror or error}")
        return {}
    except ValueError as error:
        errors.add("load.file", f"{name}: {error}; expected two columns of numbers, {_TABLE_FORM}")
        return {}
    try:
        return {"table": parse_load_table(rows)}
    except ValidationError as error:
        errors.add("load.file", f"{name}: found {show(rows)}, expected {error}")
        return {}


def _numbers(lines: Sequence[str]) -> list[list[float]]:
    """Read two numbers from each line; raise ValueError naming the first line that has others."""
    rows = []
    for n, line in enumerate(lines, start=1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        try:
            time, size = map(float, words)
        except ValueError:
            raise ValueError(f"found {show(line.strip())} in line {n}") from None
        rows.append([time, size])
    return rows
