"""Dumps of LAMMPS and LIGGGHTS: ``dump custom``, ``atom`` and ``cfg``-like columns as text, one or
several steps.

https://docs.lammps.org/dump.html
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.readers.columns import (
    PLACE,
    ColumnReader,
    GrainColumn,
    find_columns,
    gives_sizes,
)
from granwave.lammps_inputs.readers.grain_table import GrainTable
from granwave.lammps_inputs.readers.source import FileOptions, GrainSource
from granwave.lammps_inputs.tables.layout import BLANKS, Layout
from granwave.lammps_inputs.tables.text_table import TextTable, table_of
from granwave.lammps_inputs.tables.units import (
    ANGULAR_VELOCITY,
    DENSITY,
    LENGTH,
    MASS,
    VELOCITY,
    in_si,
)

NAME = "lammps-dump"
LABEL = "LAMMPS dump"
_ITEM = "ITEM: "
_STEP = "ITEM: TIMESTEP"
_ATOMS = "ITEM: ATOMS"
_BOX = "ITEM: BOX BOUNDS"
_OF_CONTACTS = "ITEM: NUMBER OF ENTRIES"  # header of dump local, whose rows may have any label
_OF_GRID = "ITEM: GRID"
_UNITS = re.compile(r"^ITEM: UNITS[ \t]*\r?\n[ \t]*(\S+)", re.MULTILINE)
_FRAME = re.compile(  # LAMMPS writes its units and the time above the step
    rf"^(?:ITEM: (?:UNITS|TIME)[ \t]*\r?\n.*\n)*({_STEP})", re.MULTILINE
)
_GENERAL = ["abc", "origin"]  # box whose edges have any direction
_PERIODIC = "pp"
_SCALED = {"xs": "x", "ys": "y", "zs": "z", "xsu": "x", "ysu": "y", "zsu": "z"}
#: Powers of ten of the SI units by the style of the units (https://docs.lammps.org/units.html);
#: styles without a length of their own lack.
UNIT_STYLES: dict[str, dict[str, int]] = {
    "si": {},
    "cgs": {LENGTH: -2, VELOCITY: -2, MASS: -3, DENSITY: 3},
    "micro": {LENGTH: -6, VELOCITY: 0, MASS: -15, DENSITY: 3, ANGULAR_VELOCITY: 6},
    "nano": {LENGTH: -9, VELOCITY: 0, MASS: -21, DENSITY: 6, ANGULAR_VELOCITY: 9},
}


def recognises(source: GrainSource) -> bool:
    """Return True for a text that begins with an item of a dump."""
    return source.head.lstrip().startswith(_ITEM)


def read(source: GrainSource) -> GrainTable:
    """Read a step of a dump, by default the last.

    Raises
    ------
    ValueError
        There is no such step, it is truncated, or it lacks positions or sizes.
    """
    text = source.text
    matches = list(_FRAME.finditer(text))
    starts = [match.start() for match in matches]
    places = [match.start(1) for match in matches]
    if not starts:
        raise ValueError(f"found no {_STEP}, expected a dump of LAMMPS with one or more steps")
    ends = [*starts[1:], len(text)]
    chosen = _chosen(text, places, source.options.step)
    first_line = text.count("\n", 0, starts[chosen]) + 1
    frame = DumpFrame.read(text[starts[chosen] : ends[chosen]], first_line)
    frame.check_complete(_step_of(text, places[chosen - 1]) if chosen else None)
    units = _UNITS.search(text, 0, places[0])  # once in a file
    if units is not None and not frame.units:
        frame.units = units[1]
    grains = frame.grains(source.options, len(starts))
    if chosen == len(starts) - 1 and not text.endswith("\n"):
        grains.notes.append("the last line is incomplete; the dump may be truncated there")
    return grains


def powers_of_style(style: str, options: FileOptions) -> Mapping[str, float]:
    """Return the powers of ten of the units of a style by kind of quantity; none for a file without
    a style.

    Raises
    ------
    ValueError
        The style has no unit of length, and the user gives none.
    """
    if options.units:
        return dict.fromkeys((LENGTH, VELOCITY), options.power())
    if not style:
        return {}
    if style not in UNIT_STYLES:
        raise ValueError(
            f"found the units {style}, expected {', '.join(UNIT_STYLES)}; give the unit of the "
            'lengths, such as packing.units = "mm"'
        )
    return UNIT_STYLES[style]


def _step_of(text: str, start: int) -> int:
    """Return the step of a frame that begins at a position in the text."""
    lines = text[start : start + len(_STEP) + 100].splitlines()
    if len(lines) < 2 or not lines[1].strip().lstrip("-").isdigit():
        line = text.count("\n", 0, start) + 2
        raise ValueError(f"line {line}: found no step number below {_STEP}")
    return int(lines[1])


def _chosen(text: str, places: list[int], step: int | None) -> int:
    """Return the number of the frame that is read, from 0."""
    if step is None:
        return len(places) - 1
    return frame_of_step([_step_of(text, place) for place in places], step)


def frame_of_step(steps: list[int], step: int) -> int:
    """Return the number, from 0, of the last frame of a step; raise ValueError if there is none."""
    if step not in steps:
        some = ", ".join(map(str, steps[:5])) + (f" ... {steps[-1]}" if len(steps) > 5 else "")
        raise ValueError(f"found no step {step} (packing.step), expected one of {some}")
    return len(steps) - 1 - steps[::-1].index(step)


@dataclasses.dataclass(frozen=True, eq=False)
class DumpBox:
    """Box of a step of a dump, in the unit of the file.

    https://docs.lammps.org/Howto_triclinic.html

    Attributes
    ----------
    origin
        Corner from which the edges start: (3,).
    edges
        Edges of the box, in rows: (3, 3).
    """

    origin: NDArray[np.float64]
    edges: NDArray[np.float64]

    @classmethod
    def read(cls, numbers: NDArray[np.float64], *, is_general: bool) -> DumpBox:
        """Return the box of three rows of a dump.

        Parameters
        ----------
        numbers
            Lowest and highest coordinate, and the tilts xy, xz, yz, if there are any: (3, 2) or
            (3, 3). Of a general box its edges and its origin: (3, 4).
        is_general
            The edges have any direction.

        Raises
        ------
        ValueError
            There are more or fewer numbers.
        """
        if is_general and numbers.shape == (3, 4):
            return cls(numbers[:, 3], numbers[:, :3])
        if numbers.shape not in ((3, 2), (3, 3)):
            raise ValueError("no three rows of two or three numbers")
        low = numbers[:, 0].copy()
        high = numbers[:, 1].copy()
        edges = np.zeros((3, 3))
        if numbers.shape == (3, 3):  # the bounds are those of a straight box around the tilted
            xy, xz, yz = numbers[:, 2].tolist()
            tilts = (0.0, xy, xz, xy + xz)
            low[:2] -= [min(tilts), min(0.0, yz)]
            high[:2] -= [max(tilts), max(0.0, yz)]
            edges[1, 0] = xy
            edges[2, :2] = xz, yz
        return cls(low, edges + np.diag(high - low))

    @property
    def is_straight(self) -> bool:
        """True if the edges are along the axes."""
        return not (self.edges - np.diag(np.diag(self.edges))).any()

    @property
    def bounds(self) -> NDArray[np.float64]:
        """Lowest and highest coordinates of a straight box: (3, 2)."""
        return np.stack([self.origin, self.origin + np.diag(self.edges)], axis=1)


@dataclasses.dataclass(kw_only=True)
class DumpFrame:
    """One step of a dump.

    Attributes
    ----------
    step
        Its number.
    n_atoms
        Number of atoms that it is said to have.
    units
        Style of units; empty if the dump says none.
    box
        The box, in the unit of the file; None without one.
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
    box: DumpBox | None = None
    flags: tuple[str, ...] = ()
    heads: tuple[str, ...] = ()
    head_line: int = 0
    rows: tuple[str, ...] = ()

    @classmethod
    def read(cls, text: str, first_line: int) -> DumpFrame:
        """Read a frame whose first line has this number."""
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
            for start, content in ((_OF_CONTACTS, "contacts"), (_OF_GRID, "a grid")):
                if item.startswith(start):
                    raise ValueError(
                        f"line {first_line + k}: found a dump of {content} ({start}), expected "
                        "one of atoms: dump custom ... x y z radius"
                    )
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
        if item.startswith(_BOX):
            words = item.removeprefix(_BOX).split()
            self.flags = tuple(word for word in words if len(word) == 2 and "_" not in word)[-3:]
            numbers = np.array([line.split() for line in values[:3]], dtype=np.float64)
            self.box = DumpBox.read(numbers, is_general=words[:2] == _GENERAL)
            return 4
        if item.startswith(_STEP):
            self.step = int(values[0])
        elif item.startswith("ITEM: NUMBER OF ATOMS"):
            self.n_atoms = int(values[0])
        elif item.startswith("ITEM: UNITS"):
            self.units = values[0].strip()
        return 2

    def check_complete(self, before: int | None) -> None:
        """Raise ValueError if atoms are missing; ``before`` is the previous step."""
        n_rows = len(self.rows)
        remedy = "" if before is None else f"; packing.step = {before} reads the previous step"
        if not n_rows and not self.n_atoms:
            raise ValueError(f"found no atom in the step {self.step}, expected one or more{remedy}")
        if n_rows == self.n_atoms:
            return
        if n_rows > self.n_atoms:
            raise ValueError(
                f"found {n_rows} atoms in the step {self.step}, expected {self.n_atoms} as in its "
                f"NUMBER OF ATOMS: the dump is damaged, or that number was edited{remedy}"
            )
        raise ValueError(
            f"found {n_rows} of {self.n_atoms} atoms in the step {self.step}: the dump is "
            f"truncated{remedy}"
        )

    def grains(self, options: FileOptions, n_steps: int, label: str = LABEL) -> GrainTable:
        """Return the grains of the frame.

        Parameters
        ----------
        n_steps
            Number of steps of the file.
        label
            Name of the format.
        """
        heads = self.heads if not options.heads else tuple(options.heads)
        layout = Layout(
            range(self.head_line + 1, self.head_line + 1 + len(self.rows)), self.rows, BLANKS, "."
        )
        table = table_of(layout, heads, self.head_line)
        notes: list[str] = []
        columns = find_columns(table, options, notes, repeated=True)
        scaled = self._scaled(table, columns)
        self._require(columns, options)
        powers = powers_of_style(self.units, options)
        of_steps = f", step {self.step}" + (f" of {n_steps} steps" if n_steps > 1 else "")
        grains = ColumnReader(table, columns, options, powers).grains(label + of_steps, notes)
        if self.box is not None:
            self._add_box(self.box, grains, scaled, powers.get(LENGTH, 0))
        elif scaled:
            raise ValueError("found scaled coordinates without a box; dump x, y, z")
        return grains

    def _add_box(self, box: DumpBox, grains: GrainTable, scaled: set[str], power: float) -> None:
        """Add the box to the grains, and convert positions that are fractions of the box."""
        periodic = [flag == _PERIODIC for flag in self.flags] or [False] * 3
        if box.is_straight:
            grains.bounds = in_si(box.bounds, power)
            grains.periodic = periodic[0], periodic[1], periodic[2]
        elif any(periodic):
            grains.notes.append("the box is tilted; its periods are ignored")
        if not scaled:
            return
        if len(scaled) < len(PLACE) and not box.is_straight:
            raise ValueError(
                "found both scaled and unscaled coordinates in a tilted box; dump x, y, z"
            )
        fractions = grains.position / 10.0**power
        places = in_si(box.origin + fractions @ box.edges, power)
        lengths = np.linalg.norm(box.edges, axis=1)
        for axis, quantity in enumerate(PLACE):
            if quantity in scaled:
                grains.position[:, axis] = places[:, axis]
                grains.half_unit[:, axis] *= lengths[axis]

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
        """Raise ValueError unless the atoms have positions and sizes."""
        has_size = gives_sizes(columns, options)
        missing = [name for name in PLACE if name not in columns]
        if missing or not has_size:
            what = ", ".join(missing or ["radius or diameter"])
            more = "" if missing else ", or packing.diameter for all grains"
            raise ValueError(
                f"line {self.head_line}: found no {what} among the columns "
                f"{' '.join(self.heads)}; dump it (dump custom ... x y z radius){more}, or name "
                "a column by packing.columns"
            )
