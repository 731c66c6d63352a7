"""Readers of what LAMMPS dumps: snapshots of the spheres, contacts, wall contacts, and the data file.

All values are float64: overlaps are micrometres in a packing of a metre, which single precision loses.
Snapshots are read one at a time.
"""

from __future__ import annotations

import dataclasses
import itertools
import logging
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.lammps_inputs.deck import columns

# What the readers cannot do without; runs have more or fewer of the others, see `Frame.get`.
SPHERE_COLUMNS = tuple(
    name for name in columns.names(columns.SNAPSHOT) if name != "elastic"
)  # of runs before it came in
CONTACT_COLUMNS = columns.names(columns.CONTACTS)
WALL_COLUMNS = columns.names(columns.WALL_CONTACTS)
HISTORY_COLUMNS = columns.names(columns.HISTORY)
DATA_COLUMNS = ("id", "type", "diameter", "density", "x", "y", "z")

log = logging.getLogger(__name__)


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
        What the columns are called.
    values
        The rows: (n_rows, n_columns).
    """

    step: int
    box: NDArray[np.float64]
    columns: tuple[str, ...]
    values: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """One column: (n_rows,)."""
        return self.values[:, self.columns.index(name)]

    def get(self, name: str) -> NDArray[np.float64]:
        """One column, zeros in a run that did not record it: (n_rows,)."""
        return self[name] if name in self.columns else np.zeros(len(self))

    def rows(self, ids: NDArray[np.int64]) -> NDArray[np.int64]:
        """Rows of the spheres with these ids, of a frame sorted by id; raises as `rows_of`."""
        return rows_of(self["id"].astype(np.int64), ids)

    def up_to(self, number: int) -> Frame:
        """The rows of ids up to ``number``, of a frame sorted by id."""
        n = int(np.searchsorted(self["id"], number, side="right"))
        return self if n == len(self) else Frame(self.step, self.box, self.columns, self.values[:n])

    def vector(self, *names: str) -> NDArray[np.float64]:
        """Several columns side by side: (n_rows, len(names))."""
        return self.values[:, [self.columns.index(name) for name in names]]

    @property
    def displacement(self) -> NDArray[np.float64]:
        """Displacements of spheres from the start: (n_rows, 3), m."""
        return self.vector("ux", "uy", "uz")

    @property
    def velocity(self) -> NDArray[np.float64]:
        """Velocities of spheres: (n_rows, 3), m/s."""
        return self.vector("vx", "vy", "vz")


def rows_of(ids: NDArray[np.int64], wanted: ArrayLike) -> NDArray[np.int64]:
    """Where some spheres stand in a table by id: id - 1 unless spheres are missing.

    Parameters
    ----------
    ids
        Of the table, rising: (n,).
    wanted
        Ids, of any shape.

    Raises
    ------
    KeyError
        There is no such sphere, such as one that was left out of the packing.
    """
    wanted = np.asarray(wanted, dtype=np.int64)
    if not len(ids) or ids[-1] == len(ids):  # none is missing
        rows, found = wanted - 1, (wanted >= 1) & (wanted <= len(ids))
    else:
        rows = np.minimum(np.searchsorted(ids, wanted), len(ids) - 1)
        found = ids[rows] == wanted
    if not np.all(found):
        raise KeyError(f"there is no sphere {wanted[~found].flat[0]} among the {len(ids)} of the packing")
    return rows


def read_frames(directory: str | Path) -> Iterator[Frame]:
    """Snapshots of ``dumps/spheres.dump`` in turn, `SPHERE_COLUMNS`, rows sorted by id.

    A last snapshot cut short by a killed run is left out with a warning; of a step written twice (a resumed
    run) the first counts.

    Raises
    ------
    MissingOutputError
        There is no such file.
    OutputFormatError
        It lacks a column, a snapshot in its middle is damaged, or it holds no complete one.
    """
    yield from _rising(_frames(_dump(directory, "spheres.dump"), SPHERE_COLUMNS, sort_by="id"))


def read_history(directory: str | Path) -> Iterator[Frame]:
    """Instants of ``dumps/history.dump`` in turn, `HISTORY_COLUMNS`, rows sorted by id; raises as `read_frames`."""
    yield from _rising(_frames(_dump(directory, "history.dump"), HISTORY_COLUMNS, sort_by="id"))


def read_forces(directory: str | Path) -> Iterator[Frame]:
    """Contacts at the same instants (``dumps/forces.dump``), columns i, j, force; raises as `read_frames`."""
    yield from _rising(_frames(_dump(directory, "forces.dump"), ("i", "j", "force")))


def read_contacts(directory: str | Path) -> Frame:
    """Contacts at the end of the run (``dumps/contacts.dump``), forgotten dents as rows of their own.

    Columns `CONTACT_COLUMNS`, and as far as recorded tangential_force, elastic_tangential, friction (loss) and initial
    (dent before the run): overlaps in m, forces in N, energies in J, times in s (-1: never). Raises as
    `read_frames`.
    """
    return _only_frame(_dump(directory, "contacts.dump"), CONTACT_COLUMNS)


def read_wall_contacts(directory: str | Path) -> dict[str, Frame]:
    """Contacts with each plane at the end of the run (``dumps/wall_NAME.dump``), by its name.

    Columns id, `WALL_COLUMNS`, and as far as recorded tangential_force, friction and initial.

    Empty when there is no plane.
    """
    found: dict[str, list[Frame]] = {}
    for path in sorted(
        (Path(directory) / "dumps").glob("wall_*.dump")
    ):  # wall_NAME, and wall_NAME_2 of further materials
        found.setdefault(path.stem.split("_")[1], []).append(_only_frame(path, ("id", *WALL_COLUMNS), sort_by="id"))
    return {
        name: _sorted(dataclasses.replace(parts[0], values=np.concatenate([part.values for part in parts])), "id")
        for name, parts in found.items()
    }


def read_data(directory: str | Path) -> Frame:
    """The particles at the start (``data.granwave``), `DATA_COLUMNS` in m and kg/m^3, rows sorted by id.

    The nodes of bars come last: their diameter is 0, and their density is their mass in kg.

    Raises
    ------
    MissingOutputError
        There is no such file.
    OutputFormatError
        It does not hold the spheres it announces.
    """
    path = Path(directory) / "data.granwave"
    if not path.exists():
        raise MissingOutputError(f"{path} is missing: write the deck again (granwave write CASE -o {directory})")
    n_spheres = 0
    columns: tuple[str, ...] = DATA_COLUMNS
    box = np.zeros((3, 2))
    with open(path, encoding="ascii") as file:
        file.readline()  # the title
        for line in file:
            words = line.split()
            if words[1:] == ["atoms"]:
                n_spheres = int(words[0])
            elif len(words) == 4 and words[3] in ("xhi", "yhi", "zhi"):
                box["xyz".index(words[3][0])] = float(words[0]), float(words[1])
            elif words and words[0] == "Atoms":
                columns = tuple(line.partition(":")[2].split()) or DATA_COLUMNS
                break
        file.readline()
        values = _numbers(list(itertools.islice(file, n_spheres)), n_spheres, len(columns))
    if values is None or not n_spheres:
        raise OutputFormatError(f"{path}: expected {n_spheres} rows of {' '.join(columns)} under Atoms")
    frame = Frame(0, box, columns, values)
    return _sorted(Frame(0, box, DATA_COLUMNS, np.ascontiguousarray(frame.vector(*DATA_COLUMNS))), "id")


def _rising(frames: Iterator[Frame]) -> Iterator[Frame]:
    """Each step once: of one that is there twice (a resumed run) the first counts."""
    last_step = -1
    for frame in frames:
        if frame.step > last_step:
            last_step = frame.step
            yield frame


def _dump(directory: str | Path, name: str) -> Path:
    path = Path(directory) / "dumps" / name
    if not path.exists():
        raise MissingOutputError(
            f"{path} is missing: the run did not get as far as writing it; finish the run "
            f"(granwave run {Path(directory) / 'case.toml'} -o {directory} --resume)"
        )
    return path


def _only_frame(path: Path, required: tuple[str, ...], sort_by: str | None = None) -> Frame:
    *_, frame = _frames(path, required, sort_by)
    return frame


def _frames(path: Path, required: tuple[str, ...], sort_by: str | None = None) -> Iterator[Frame]:
    number = 0
    with open(path, encoding="ascii") as file:
        while (frame := _next_frame(file, path, number)) is not None:
            missing = [name for name in required if name not in frame.columns]
            if missing:
                raise OutputFormatError(
                    f"{path}: snapshot {number} lacks the columns {', '.join(missing)}; it has "
                    f"{' '.join(frame.columns)}"
                )
            number += 1
            yield _sorted(frame, sort_by) if sort_by else frame
    if not number:
        raise OutputFormatError(f"{path} holds no complete snapshot; finish the run or run it again")


def _next_frame(file: TextIO, path: Path, number: int) -> Frame | None:
    """The snapshot that begins at the present place of the file; None at its end or when it is cut short."""
    header: dict[str, list[str]] = {}
    title = ""
    for title in file:
        if not title.startswith("ITEM:"):
            raise OutputFormatError(f"{path}: expected the header of snapshot {number}, found {title[:60]!r}")
        if title.startswith(("ITEM: ATOMS", "ITEM: ENTRIES")):
            break
        n_lines = 3 if title.startswith("ITEM: BOX") else 1
        header[" ".join(title.split()[1:3])] = list(itertools.islice(file, n_lines))
    if not header:
        return None
    columns = tuple(title.split()[2:])
    complete = title.startswith(("ITEM: ATOMS", "ITEM: ENTRIES")) and title.endswith("\n")
    n_rows = int(header["NUMBER OF"][0]) if complete else 0
    rows = list(itertools.islice(file, n_rows)) if complete else []
    if not complete or len(rows) < n_rows or (rows and not rows[-1].endswith("\n")):
        log.warning("%s: snapshot %d is cut short and left out", path, number)
        return None
    values = _numbers(rows, n_rows, len(columns))
    if values is None:
        raise OutputFormatError(f"{path}: snapshot {number} does not hold {n_rows} rows of {len(columns)} numbers")
    box = np.array([line.split()[:2] for line in header["BOX BOUNDS"]], dtype=float)
    return Frame(int(header["TIMESTEP"][0]), box, columns, values)


def _numbers(rows: list[str], n_rows: int, n_columns: int) -> NDArray[np.float64] | None:
    """The numbers in rows of text, (n_rows, n_columns), or None when they are not so many."""
    if n_rows == 0:
        return np.empty((0, n_columns))
    text = "".join(rows)
    if len(rows) != n_rows or len(rows[-1].split()) != n_columns:
        return None
    try:
        values = np.fromstring(text, dtype=float, sep=" ")  # the fastest reader of text that numpy has
    except ValueError:
        return None
    return values.reshape(n_rows, n_columns) if values.size == n_rows * n_columns else None


def _sorted(frame: Frame, name: str) -> Frame:
    key = frame[name]
    if np.any(key[1:] < key[:-1]):
        frame.values[:] = frame.values[np.argsort(key, kind="stable")]
    return frame
