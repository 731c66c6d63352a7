"""Dumps of LAMMPS and LIGGGHTS: ``dump custom``, ``atom`` and ``cfg``-like columns as text, one or
several steps.

https://docs.lammps.org/dump.html
"""

from __future__ import annotations

import dataclasses
import re

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.readers.columns import (
    DIAMETER,
    PLACE,
    RADIUS,
    ColumnReader,
    GrainColumn,
    find_columns,
)
from granwave.lammps_inputs.readers.grain_table import GrainTable
from granwave.lammps_inputs.readers.source import FileOptions, GrainSource
from granwave.lammps_inputs.tables.layout import BLANKS, Layout
from granwave.lammps_inputs.tables.text_table import TextTable, table_of
from granwave.lammps_inputs.tables.units import in_si

NAME = "lammps-dump"
LABEL = "LAMMPS dump"
_ITEM = "ITEM: "
_STEP = "ITEM: TIMESTEP"
_ATOMS = "ITEM: ATOMS"
_PERIODIC = "pp"
_SCALED = {"xs": "x", "ys": "y", "zs": "z", "xsu": "x", "ysu": "y", "zsu": "z"}
#: Powers of ten of the metre by the style of the units; styles without a length of their own lack.
UNIT_STYLES = {"si": 0, "cgs": -2, "micro": -6, "nano": -9}


def recognises(source: GrainSource) -> bool:
    """Return True for a text that begins with an item of a dump."""
    return source.head.lstrip().startswith(_ITEM)


def read(source: GrainSource) -> GrainTable:
    """Read a step of a dump, by default the last.

    Raises
    ------
    ValueError
        There is no such step, it is truncated, or it lacks places or sizes.
    """
    text = source.text
    starts = [match.start() for match in re.finditer(f"^{_STEP}", text, re.MULTILINE)]
    if not starts:
        raise ValueError(f"found no {_STEP}, expected a dump of LAMMPS with one or more steps")
    ends = [*starts[1:], len(text)]
    chosen = _chosen(text, starts, source.options.step)
    first_line = text.count("\n", 0, starts[chosen]) + 1
    frame = _DumpFrame.read(text[starts[chosen] : ends[chosen]], first_line)
    frame.check_complete(_step_of(text, starts[chosen - 1]) if chosen else None)
    return frame.grains(source.options, len(starts))


def power_of_style(style: str, options: FileOptions) -> int:
    """Return the power of ten of the lengths of a style of units; raise ValueError without one."""
    if options.units or not style:
        return options.power()
    if style not in UNIT_STYLES:
        raise ValueError(
            f"found the units {style}, expected {', '.join(UNIT_STYLES)}; give the unit of the "
            'lengths, such as packing.units = "mm"'
        )
    return UNIT_STYLES[style]


def _step_of(text: str, start: int) -> int:
    """Return the step of a frame that begins at a place of the text."""
    lines = text[start : start + len(_STEP) + 100].splitlines()
    if len(lines) < 2 or not lines[1].strip().lstrip("-").isdigit():
        line = text.count("\n", 0, start) + 2
        raise ValueError(f"line {line}: found no number of a step below {_STEP}")
    return int(lines[1])


def _chosen(text: str, starts: list[int], step: int | None) -> int:
    """Return the number of the frame that is read, from 0."""
    if step is None:
        return len(starts) - 1
    steps = [_step_of(text, start) for start in starts]
    if step not in steps:
        some = ", ".join(map(str, steps[:5])) + (f" ... {steps[-1]}" if len(steps) > 5 else "")
        raise ValueError(f"found no step {step} (packing.step), expected one of {some}")
    return len(steps) - 1 - steps[::-1].index(step)


@dataclasses.dataclass
class _DumpFrame:
    """One step of a dump.

    Attributes
    ----------
    step
        Its number.
    n_atoms
        Number of atoms that it is said to have.
    units
        Style of units; empty if the dump says none.
    bounds
        Box: (3, 2), in the unit of the file; None without one.
    tilts
        Tilts of the box, in the unit of the file.
    flags
        Boundary along each axis.
    heads
        Names of the columns.
    head_line
        Line of the names.
    rows
        Rows of the atoms.
    """

    step: int = 0
    n_atoms: int = 0
    units: str = ""
    bounds: NDArray[np.float64] | None = None
    tilts: tuple[float, ...] = ()
    flags: tuple[str, ...] = ()
    heads: tuple[str, ...] = ()
    head_line: int = 0
    rows: tuple[str, ...] = ()

    @classmethod
    def read(cls, text: str, first_line: int) -> _DumpFrame:
        """Read a frame of which the first line has this number."""
        frame = cls()
        lines = text.splitlines()
        k = 0
        while k < len(lines):
            item = lines[k].strip()
            if item.startswith(_ATOMS):
                frame.heads = tuple(item.removeprefix(_ATOMS).split())
                frame.head_line = first_line + k
                frame.rows = tuple(line for line in lines[k + 1 :] if line.strip())
                return frame
            try:
                k += frame._read_item(item, lines[k + 1 : k + 4])
            except (ValueError, IndexError):
                raise ValueError(
                    f"line {first_line + k}: found {item!r} without its values: the dump is "
                    "damaged or truncated"
                ) from None
        raise ValueError(
            f"line {first_line + len(lines) - 1}: found no {_ATOMS} in the step {frame.step}, "
            "expected a dump of atoms; it may be truncated"
        )

    def _read_item(self, item: str, values: list[str]) -> int:
        """Read an item before the atoms from the lines below it; return its number of lines."""
        if item.startswith("ITEM: BOX BOUNDS"):
            words = item.removeprefix("ITEM: BOX BOUNDS").split()
            self.flags = tuple(word for word in words if len(word) == 2 and "_" not in word)[-3:]
            numbers = np.array([line.split() for line in values[:3]], dtype=np.float64)
            if numbers.shape not in ((3, 2), (3, 3)):
                raise ValueError("no three rows of two or three numbers")
            self.bounds = numbers[:, :2]
            self.tilts = tuple(numbers[:, 2:].ravel().tolist())
            return 4
        if item.startswith(_STEP):
            self.step = int(values[0])
        elif item.startswith("ITEM: NUMBER OF ATOMS"):
            self.n_atoms = int(values[0])
        elif item.startswith("ITEM: UNITS"):
            self.units = values[0].strip()
        return 2

    def check_complete(self, before: int | None) -> None:
        """Raise ValueError if atoms are missing; ``before`` is the step before this one."""
        n_rows = len(self.rows)
        if n_rows == self.n_atoms:
            return
        remedy = "" if before is None else f"; packing.step = {before} takes the step before"
        raise ValueError(
            f"found {n_rows} of {self.n_atoms} atoms in the step {self.step}: the dump is "
            f"truncated{remedy}"
        )

    def grains(self, options: FileOptions, n_steps: int) -> GrainTable:
        """Return the grains of the frame; ``n_steps`` is the number of steps of the file."""
        heads = self.heads if not options.heads else tuple(options.heads)
        layout = Layout(
            range(self.head_line + 1, self.head_line + 1 + len(self.rows)), self.rows, BLANKS, "."
        )
        if not self.rows:
            raise ValueError(f"found no atom in the step {self.step}, expected one or more")
        table = table_of(layout, heads, self.head_line)
        notes: list[str] = []
        columns = find_columns(table, options, notes, repeated=True)
        scaled = self._scaled(table, columns)
        self._require(columns, options)
        power = power_of_style(self.units, options)
        of_steps = f", step {self.step}" + (f" of {n_steps} steps" if n_steps > 1 else "")
        grains = ColumnReader(table, columns, options, power).grains(LABEL + of_steps, notes)
        if any(self.tilts) or self.bounds is None:
            if scaled:
                raise ValueError("found scaled places in a tilted box; dump x, y, z")
            return grains
        grains.bounds = in_si(self.bounds, power)
        periodic = [flag == _PERIODIC for flag in self.flags] or [False] * 3
        grains.periodic = periodic[0], periodic[1], periodic[2]
        for axis, quantity in enumerate(PLACE):
            if quantity in scaled:
                low, high = grains.bounds[axis]
                share = grains.position[:, axis] / 10.0**power
                grains.position[:, axis] = low + share * (high - low)
                grains.half_unit[:, axis] *= (high - low) / 10.0**power
        return grains

    def _scaled(self, table: TextTable, columns: dict[str, GrainColumn]) -> set[str]:
        """Return the coordinates that are fractions of the box, whose columns are added."""
        scaled: set[str] = set()
        for index, head in enumerate(table.heads):
            quantity = _SCALED.get(head)
            if quantity is not None and quantity not in columns:
                columns[quantity] = GrainColumn(index, head)
                scaled.add(quantity)
        return scaled

    def _require(self, columns: dict[str, GrainColumn], options: FileOptions) -> None:
        """Raise ValueError unless the atoms have places and sizes."""
        has_size = options.diameter is not None or {DIAMETER, RADIUS} & set(columns)
        missing = [name for name in PLACE if name not in columns]
        if missing or not has_size:
            what = ", ".join(missing or ["radius or diameter"])
            more = "" if missing else ", or packing.diameter for all grains"
            raise ValueError(
                f"line {self.head_line}: found no {what} among the columns "
                f"{' '.join(self.heads)}; dump it (dump custom ... x y z radius){more}, or name "
                "a column by packing.columns"
            )
