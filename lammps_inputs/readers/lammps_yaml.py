"""Dumps of LAMMPS in YAML (``dump yaml``), one or several steps.

LAMMPS writes each key and each row of atoms on a separate line, so that no library is needed.

https://docs.lammps.org/dump.html
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from granwave.lammps_inputs.readers.grain_table import GrainTable
from granwave.lammps_inputs.readers.lammps_dump import DumpBox, DumpFrame, frame_of_step
from granwave.lammps_inputs.readers.source import GrainSource

NAME = "lammps-yaml"
LABEL = "LAMMPS YAML dump"
_CREATOR = "creator: LAMMPS"
_DOCUMENT = re.compile(r"^---[ \t]*$", re.MULTILINE)
_KEY = re.compile(r"([a-z]+):(.*)")
_ROW = re.compile(r"[ \t]*-[ \t]*\[(.*)\][ \t]*")
_END = "..."
_EMPTY = "-"  # LAMMPS leaves labels of types empty
_N_OF_EDGES = 3  # rows of the box; a fourth one has the tilts


def recognises(source: GrainSource) -> bool:
    """Return True for a first document by LAMMPS."""
    lines = source.head.lstrip().splitlines()[:2]
    return lines == ["---", _CREATOR]


def read(source: GrainSource) -> GrainTable:
    """Read a step of a dump, by default the last.

    Raises
    ------
    ValueError
        There is no such step, it is truncated, or it lacks positions or sizes.
    """
    text = source.text
    starts = [match.start() for match in _DOCUMENT.finditer(text)]
    if not starts:
        raise ValueError("found no line ---, expected a dump of LAMMPS in YAML")
    ends = [*starts[1:], len(text)]
    chosen = len(starts) - 1
    if source.options.step is not None:
        documents = zip(starts, ends, strict=True)
        steps = [_step_of(text[start:end]) for start, end in documents]
        chosen = frame_of_step(steps, source.options.step)
    first_line = text.count("\n", 0, starts[chosen]) + 1
    frame = _frame(text[starts[chosen] : ends[chosen]], first_line)
    before = _step_of(text[starts[chosen - 1] : starts[chosen]]) if chosen else None
    frame.check_complete(before)
    return frame.grains(source.options, len(starts), LABEL)


def _step_of(document: str) -> int:
    """Return the step of a document; -1 if it has none."""
    match = re.search(r"^timestep:[ \t]*([0-9]+)", document, re.MULTILINE)
    return -1 if match is None else int(match[1])


def _frame(document: str, first_line: int) -> DumpFrame:
    """Return the step of a document that begins at a line."""
    values: dict[str, str] = {}
    rows: dict[str, list[str]] = {}
    lines: dict[str, int] = {}
    key = ""
    for number, line in enumerate(document.splitlines(), start=first_line):
        if line.startswith(_END):
            break
        if match := _KEY.fullmatch(line):
            key = match[1]
            values[key] = match[2].strip()
            rows[key] = []
            lines[key] = number
        elif match := _ROW.fullmatch(line):
            rows.setdefault(key, []).append(" ".join(_items(match[1])))
        elif key == "data" and line.strip():
            raise ValueError(f"line {number}: found {line.strip()!r}: the dump is truncated")
    missing = [name for name in ("timestep", "natoms", "keywords", "data") if name not in values]
    if missing:
        raise ValueError(
            f"line {first_line}: found no {missing[0]} in the step that begins here; the dump is "
            "damaged or truncated"
        )
    try:
        return DumpFrame(
            step=int(values["timestep"]),
            n_atoms=int(values["natoms"]),
            units=values.get("units", ""),
            box=_box(rows.get("box", [])),
            flags=_flags(values.get("boundary", "")),
            heads=tuple(_items(values["keywords"].strip("[]"))),
            head_line=lines["data"],
            rows=tuple(rows["data"]),
        )
    except (ValueError, IndexError):
        raise ValueError(
            f"line {first_line}: found a step whose timestep, natoms or box is not a number: the "
            "dump is damaged"
        ) from None


def _items(text: str) -> list[str]:
    """Return the items of a list, which ends with a comma."""
    return [item.strip() or _EMPTY for item in text.rstrip(", ").split(",")]


def _flags(text: str) -> tuple[str, ...]:
    """Return the boundaries of both faces along each axis, such as ``pp``."""
    letters = _items(text.strip("[]"))
    return tuple("".join(letters[k : k + 2]) for k in range(0, len(letters), 2))


def _box(rows: Sequence[str]) -> DumpBox | None:
    """Return the box of its rows; None without such rows."""
    if not rows:
        return None
    numbers = np.array([row.split() for row in rows[:_N_OF_EDGES]], dtype=np.float64)
    tilts = rows[_N_OF_EDGES].split() if len(rows) > _N_OF_EDGES else []
    if tilts:
        numbers = np.column_stack([numbers, np.array(tilts, dtype=np.float64)])
    return DumpBox.read(numbers, is_general=False)
