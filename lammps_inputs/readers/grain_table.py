"""Grains in the form of a file of a packing."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

#: Axes of the file that become x, y and z, with their signs, by the direction that is up in it: +z
#: is down here, and the axes stay right-handed.
TURNS: dict[str, tuple[tuple[int, int, int], tuple[int, int, int]]] = {
    "-z": ((0, 1, 2), (1, 1, 1)),
    "z": ((0, 1, 2), (1, -1, -1)),
    "-x": ((1, 2, 0), (1, 1, 1)),
    "x": ((1, 2, 0), (1, -1, -1)),
    "-y": ((2, 0, 1), (1, 1, 1)),
    "y": ((2, 0, 1), (1, -1, -1)),
}


@dataclasses.dataclass(eq=False, kw_only=True)
class GrainTable:
    """Grains of a file, in the order of their ids, or of their rows if they have none.

    Attributes
    ----------
    format
        Name of the format, and description in the file.
    position
        Centres: (n, 3), m.
    half_unit
        Half a unit of the last digit of each coordinate: (n, 3), m; zero where it is not known.
    radius
        (n,), m; None if the file has none.
    ids
        Ids in the file: (n,); None if it has none.
    types
        Names of types: (n,); empty if it has none.
    density
        (n,), kg/m^3; None if the file has none.
    mass
        (n,), kg; None if the file has none.
    velocity
        (n, 3), m/s; None if the file has none.
    spin
        Angular velocities: (n, 3), rad/s; None if the file has none.
    clump
        Numbers of clumps, 0 for grains in none: (n,); None if the file has none.
    words
        Further columns of words, such as material and group, by name: (n,) each.
    numbers
        Further columns of numbers, such as the length of cylinders, by name: (n,) each, m.
    bounds
        Lowest and highest x, y, z of the box: (3, 2), m; None if there is none.
    periodic
        Axes along which the box is periodic.
    cell
        Vectors after which the grains repeat, m.
    lines
        Lines of the file, from 1: (n,); None if grains have no lines.
    notes
        Warnings for the user.
    """

    format: str
    position: NDArray[np.float64]
    half_unit: NDArray[np.float64]
    radius: NDArray[np.float64] | None = None
    ids: NDArray[np.int64] | None = None
    types: Sequence[str] = ()
    density: NDArray[np.float64] | None = None
    mass: NDArray[np.float64] | None = None
    velocity: NDArray[np.float64] | None = None
    spin: NDArray[np.float64] | None = None
    clump: NDArray[np.int64] | None = None
    words: dict[str, list[str]] = dataclasses.field(default_factory=dict)
    numbers: dict[str, NDArray[np.float64]] = dataclasses.field(default_factory=dict)
    bounds: NDArray[np.float64] | None = None
    periodic: tuple[bool, bool, bool] = (False, False, False)
    cell: list[list[float]] = dataclasses.field(default_factory=list)
    lines: NDArray[np.int64] | None = None
    notes: list[str] = dataclasses.field(default_factory=list)

    def __len__(self) -> int:
        return len(self.position)

    def place(self, row: int) -> str:
        """Return the place of a grain in the file, in words."""
        return f"grain {row + 1}" if self.lines is None else f"line {self.lines[row]}"

    @property
    def period(self) -> tuple[float, float] | None:
        """Periods along x and y, m; None unless the box is periodic along both."""
        if self.bounds is None or not all(self.periodic[:2]):
            return None
        x, y = (self.bounds[:2, 1] - self.bounds[:2, 0]).tolist()
        return x, y

    def in_order(self) -> GrainTable:
        """Return the grains in the order of their ids, and back in their periodic box.

        Raises
        ------
        ValueError
            Two grains have the same id.
        """
        self._wrap()
        if self.ids is None:
            return self
        order = np.argsort(self.ids, kind="stable")
        ids = self.ids[order]
        twice = np.flatnonzero(np.diff(ids) == 0)
        if len(twice):
            second = int(order[twice[0] + 1])
            raise ValueError(
                f"{self.place(second)}: found the id {ids[twice[0]]} twice, "
                "expected a unique id for each grain"
            )
        if ids[0] != 1 or ids[-1] != len(ids):
            self.notes.append(
                f"ids from {ids[0]} to {ids[-1]}; the {len(ids)} grains are numbered from 1 in "
                "this order"
            )
        return self.taken(order)

    def turn(self, up: str) -> None:
        """Turn the grains until a direction of the file, a key of `TURNS`, is up."""
        axes, signs = TURNS[up]
        order = list(axes)
        sign = np.array(signs, dtype=np.float64)
        self.position = self.position[:, order] * sign
        self.half_unit = self.half_unit[:, order]
        self.periodic = (self.periodic[axes[0]], self.periodic[axes[1]], self.periodic[axes[2]])
        if self.velocity is not None:
            self.velocity = self.velocity[:, order] * sign
        if self.spin is not None:
            self.spin = self.spin[:, order] * sign
        if self.bounds is not None:
            self.bounds = np.sort(self.bounds[order] * sign[:, None], axis=1)
        self.cell = [(np.array(vector)[order] * sign).tolist() for vector in self.cell]

    def _wrap(self) -> None:
        """Put grains outside of a periodic box back into it, with a note."""
        if self.bounds is None:
            return
        n_outside = 0
        for axis in range(3):
            low, high = self.bounds[axis]
            if not self.periodic[axis] or not high > low:
                continue
            images = np.floor((self.position[:, axis] - low) / (high - low))
            n_outside = max(n_outside, int(np.count_nonzero(images)))
            self.position[:, axis] -= images * (high - low)
        if n_outside:
            grains = "grain" if n_outside == 1 else "grains"
            self.notes.append(
                f"{n_outside} {grains} outside of the periodic box wrapped back into it"
            )

    def taken(self, order: NDArray[np.int64]) -> GrainTable:
        """Return the grains of some rows, in their order."""
        arrays = ("position", "half_unit", "radius", "ids", "density", "mass", "velocity", "spin")
        changed: dict[str, object] = {}
        for name in (*arrays, "clump", "lines"):
            values = getattr(self, name)
            changed[name] = None if values is None else values[order]
        rows = order.tolist()
        if self.types:
            changed["types"] = [self.types[row] for row in rows]
        changed["words"] = {
            name: list(map(words.__getitem__, rows)) for name, words in self.words.items()
        }
        changed["numbers"] = {name: values[order] for name, values in self.numbers.items()}
        return dataclasses.replace(self, **changed)  # type: ignore[arg-type]
