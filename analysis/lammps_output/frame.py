"""One snapshot of a dump of LAMMPS: step, box, and a table of values."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True, eq=False)
class Frame:
    """One snapshot of a dump.

    Attributes
    ----------
    step
        Timestep.
    box
        Lower and upper bound along x, y, z: (3, 2), m.
    columns
        Names of the columns.
    values
        Rows: (n_rows, n_columns).
    more
        True if further rows of the snapshot follow in another frame.
    """

    step: int
    box: NDArray[np.float64]
    columns: tuple[str, ...]
    values: NDArray[np.float64]
    more: bool = False

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """Return one column: (n_rows,)."""
        return self.values[:, self.columns.index(name)]

    def get(self, name: str) -> NDArray[np.float64]:
        """Return one column, or zeros if it was not recorded: (n_rows,)."""
        return self[name] if name in self.columns else np.zeros(len(self))

    def rows(self, ids: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the rows of the spheres with these ids in a frame sorted by id; raise as `rows_of`."""
        return rows_of(self["id"].astype(np.int64), ids)

    def up_to(self, number: int) -> Frame:
        """Return the rows with ids up to ``number`` of a frame sorted by id."""
        n = int(np.searchsorted(self["id"], number, side="right"))
        return self if n == len(self) else Frame(self.step, self.box, self.columns, self.values[:n], self.more)

    def vector(self, *names: str) -> NDArray[np.float64]:
        """Return several columns: (n_rows, len(names))."""
        return self.values[:, [self.columns.index(name) for name in names]]

    def sorted_by(self, name: str) -> Frame:
        """Return the frame with its rows sorted by a column; they are moved in place."""
        key = self[name]
        if np.any(key[1:] < key[:-1]):
            self.values[:] = self.values[np.argsort(key, kind="stable")]
        return self

    def followed(self) -> Frame:
        """Return the frame as one that is followed by further rows of its snapshot."""
        return dataclasses.replace(self, more=True)

    @property
    def displacement(self) -> NDArray[np.float64]:
        """Displacements of spheres from the start: (n_rows, 3), m."""
        return self.vector("ux", "uy", "uz")

    @property
    def velocity(self) -> NDArray[np.float64]:
        """Velocities of spheres: (n_rows, 3), m/s."""
        return self.vector("vx", "vy", "vz")


def joined(frames: Iterable[Frame]) -> Iterator[Frame]:
    """Join the rows of each snapshot that come in several frames."""
    parts: list[Frame] = []
    for frame in frames:
        parts.append(frame)
        if not frame.more:
            values = frame.values if len(parts) == 1 else np.concatenate([part.values for part in parts])
            yield Frame(frame.step, frame.box, frame.columns, values)
            parts = []


def rows_of(ids: NDArray[np.int64], wanted: ArrayLike) -> NDArray[np.int64]:
    """Return the rows of spheres in a table sorted by id: id - 1 unless spheres are missing.

    Parameters
    ----------
    ids
        Ids in the table, rising: (n,).
    wanted
        Ids of the spheres, of any shape.

    Raises
    ------
    KeyError
        There is no such sphere, for instance at a vacancy.
    """
    wanted = np.asarray(wanted, dtype=np.int64)
    if not len(ids) or ids[-1] == len(ids):
        return rows_of_all(len(ids), wanted)
    rows = np.minimum(np.searchsorted(ids, wanted), len(ids) - 1)
    _refuse_unknown(wanted, ids[rows] == wanted, len(ids))
    return rows


def rows_of_all(n_spheres: int, wanted: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the rows of spheres in a table in which none is missing; raise as `rows_of`."""
    _refuse_unknown(wanted, (wanted >= 1) & (wanted <= n_spheres), n_spheres)
    return wanted - 1


def _refuse_unknown(wanted: NDArray[np.int64], found: NDArray[np.bool_], n_spheres: int) -> None:
    if not np.all(found):
        raise KeyError(f"there is no sphere {wanted[~found].flat[0]} among the {n_spheres} of the packing")


class CutShortError(Exception):
    """Error of a dump that ends within a snapshot.

    Parameters
    ----------
    place
        File and place in it, for messages.
    number
        Number of the snapshot, from 0.
    """

    def __init__(self, place: str, number: int) -> None:
        super().__init__(f"{place}: snapshot {number} is cut short")
