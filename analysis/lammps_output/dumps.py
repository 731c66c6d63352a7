"""Readers of the dumps of LAMMPS: snapshots of spheres, contacts, wall contacts; and of the data file.

All values are float64: overlaps of micrometres in a packing of a metre exceed single precision. Snapshots are read one
at a time.
"""

from __future__ import annotations

import dataclasses
import itertools
import logging
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.lammps_output.number_rows import AGAIN, CUT, DAMAGED, read_rows, whole_number
from granwave.lammps_inputs.deck import columns
from granwave.lammps_inputs.ownership import output_names
from granwave.lammps_inputs.run_directory import (
    CASE_FILE,
    CONTACTS_FILE,
    DATA_FILE,
    DUMPS,
    FORCES_FILE,
    FRAMES_FILE,
    HISTORY_FILE,
    WALL_CONTACTS_FILE,
)

# Columns that the readers require; others are optional, see `Frame.get`.
SPHERE_COLUMNS = tuple(
    name for name in columns.names(columns.SNAPSHOT) if name != "elastic"
)  # which early versions did not write
CONTACT_COLUMNS = columns.names(columns.CONTACTS)
WALL_COLUMNS = columns.names(columns.WALL_CONTACTS)
HISTORY_COLUMNS = columns.names(columns.HISTORY)
_COUNTS = {"TIMESTEP": "timestep", "NUMBER OF": "number of rows"}  # in the header of a snapshot
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
        Names of the columns.
    values
        Rows: (n_rows, n_columns).
    """

    step: int
    box: NDArray[np.float64]
    columns: tuple[str, ...]
    values: NDArray[np.float64]

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
        return self if n == len(self) else Frame(self.step, self.box, self.columns, self.values[:n])

    def vector(self, *names: str) -> NDArray[np.float64]:
        """Return several columns: (n_rows, len(names))."""
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
    if not len(ids) or ids[-1] == len(ids):  # none is missing
        rows, found = wanted - 1, (wanted >= 1) & (wanted <= len(ids))
    else:
        rows = np.minimum(np.searchsorted(ids, wanted), len(ids) - 1)
        found = ids[rows] == wanted
    if not np.all(found):
        raise KeyError(f"there is no sphere {wanted[~found].flat[0]} among the {len(ids)} of the packing")
    return rows


def read_frames(directory: str | Path, *, partial: bool = True) -> Iterator[Frame]:
    """Iterate over the snapshots of ``dumps/spheres.dump``, `SPHERE_COLUMNS`, rows sorted by id.

    If a step was written twice (resumed run), the first is used.

    Parameters
    ----------
    partial
        True to skip a truncated last snapshot, of a killed run for instance, with a warning; else it is an error.

    Raises
    ------
    MissingOutputError
        There is no such file.
    OutputFormatError
        The file lacks a column, a snapshot is damaged, or none is complete.
    """
    yield from _rising(_frames(_dump(directory, FRAMES_FILE), SPHERE_COLUMNS, sort_by="id", partial=partial))


def read_history(directory: str | Path) -> Iterator[Frame]:
    """Iterate over the instants of ``dumps/history.dump``, `HISTORY_COLUMNS`, sorted by id; raise as `read_frames`."""
    yield from _rising(_frames(_dump(directory, HISTORY_FILE), HISTORY_COLUMNS, sort_by="id"))


def read_forces(directory: str | Path) -> Iterator[Frame]:
    """Iterate over the contacts at these instants (``dumps/forces.dump``: i, j, force); raise as `read_frames`."""
    yield from _rising(_frames(_dump(directory, FORCES_FILE), ("i", "j", "force")))


def read_contacts(directory: str | Path) -> Frame:
    """Read the contacts at the end of the run (``dumps/contacts.dump``), with forgotten dents as separate rows.

    Columns `CONTACT_COLUMNS` and, as far as recorded, tangential_force, elastic_tangential, friction (dissipation) and
    initial (initial dent): overlaps in m, forces in N, energies in J, times in s (-1: never). Raise as
    `read_frames`.
    """
    return _only_frame(_dump(directory, CONTACTS_FILE), CONTACT_COLUMNS)


def read_wall_contacts(directory: str | Path) -> dict[str, Frame]:
    """Read the contacts with each plane at the end of the run (``dumps/wall_NAME.dump``), by its name.

    Columns id, `WALL_COLUMNS` and, as far as recorded, tangential_force, friction and initial.

    The result is empty if there is no plane.
    """
    found: dict[str, list[Frame]] = {}
    for path in _wall_dumps(Path(directory)):  # wall_NAME, and wall_NAME_2 for further materials
        found.setdefault(path.stem.split("_")[1], []).append(_only_frame(path, ("id", *WALL_COLUMNS), sort_by="id"))
    return {
        name: _sorted(dataclasses.replace(parts[0], values=np.concatenate([part.values for part in parts])), "id")
        for name, parts in found.items()
    }


def _wall_dumps(directory: Path) -> list[Path]:
    """Return the paths of the dumps of walls; only those of the deck, if it lists them."""
    paths, own = sorted((directory / DUMPS).glob(WALL_CONTACTS_FILE.format("*"))), output_names(directory)
    return [path for path in paths if not own or f"{DUMPS}/{path.name}" in own]


def check_ids(path: Path, frame: Frame, everything: Frame) -> None:
    """Raise OutputFormatError if a dump names a particle that is not in ``everything``, read by `read_data`."""
    for column in [name for name in ("i", "j", "id") if name in frame.columns]:
        strange = np.setdiff1d(frame[column], everything["id"])
        if len(strange):
            raise OutputFormatError(
                f"{path}: found a contact of particle {strange[0]:.0f}, which data.granwave does not hold: the files "
                f"belong to different runs, or one is damaged; {AGAIN}"
            )


def read_data(directory: str | Path) -> Frame:
    """Read the particles at the start (``data.granwave``), `DATA_COLUMNS` in m and kg/m^3, rows sorted by id.

    The nodes of bars come last; they have diameter 0 and their mass in kg as density.

    Raises
    ------
    MissingOutputError
        There is no such file.
    OutputFormatError
        The file holds fewer spheres than its header says, or is damaged.
    """
    path = Path(directory) / DATA_FILE
    if not path.exists():
        raise MissingOutputError(f"{path} is missing; {AGAIN}")
    n_spheres = 0
    columns: tuple[str, ...] = DATA_COLUMNS
    box = np.zeros((3, 2))
    with _Lines(path) as lines:
        lines.take(1)  # the title
        while found := lines.take(1):
            words = found[0].split()
            if words[1:] == ["atoms"]:
                n_spheres = whole_number(words[0], "number of atoms", lines.place())
            elif len(words) == 4 and words[3] in ("xhi", "yhi", "zhi"):
                edges = read_rows([" ".join(words[:2])], (words[2], words[3]), lambda _: lines.place())
                box["xyz".index(words[3][0])] = edges[0]
            elif words and words[0] == "Atoms":
                columns = tuple(found[0].partition(":")[2].split()) or DATA_COLUMNS
                break
        if not n_spheres:
            raise OutputFormatError(f"{path} does not say how many atoms it holds; {DAMAGED}")
        lines.take(1)
        rows = lines.take(n_spheres)
        if len(rows) < n_spheres:
            raise OutputFormatError(
                f"{lines.place()}: found {len(rows)} of {n_spheres} rows under Atoms ({' '.join(columns)}); {CUT}"
            )
        values = read_rows(rows, columns, lambda row: lines.place(n_spheres - 1 - row))
    if missing := [name for name in DATA_COLUMNS if name not in columns]:
        raise OutputFormatError(f"{path} lacks the columns {', '.join(missing)}; it has {' '.join(columns)}; {AGAIN}")
    frame = Frame(0, box, columns, values)
    return _sorted(Frame(0, box, DATA_COLUMNS, np.ascontiguousarray(frame.vector(*DATA_COLUMNS))), "id")


def _rising(frames: Iterator[Frame]) -> Iterator[Frame]:
    """Skip repeated steps of resumed runs; the first is used."""
    last_step = -1
    for frame in frames:
        if frame.step > last_step:
            last_step = frame.step
            yield frame


def _dump(directory: str | Path, name: str) -> Path:
    path = Path(directory) / DUMPS / name
    if not path.exists():
        raise MissingOutputError(
            f"{path} is missing: the run did not get as far as writing it; finish the run "
            f"(granwave run {Path(directory) / CASE_FILE} -o {directory} --resume)"
        )
    return path


def _only_frame(path: Path, required: tuple[str, ...], sort_by: str | None = None) -> Frame:
    *_, frame = _frames(path, required, sort_by)
    return frame


def _frames(
    path: Path, required: tuple[str, ...], sort_by: str | None = None, *, partial: bool = False
) -> Iterator[Frame]:
    """Iterate over the snapshots of a dump; with ``partial`` a truncated last one is skipped with a warning."""
    number = 0
    with _Lines(path) as lines:
        try:
            while (frame := _next_frame(lines, number)) is not None:
                if missing := [name for name in required if name not in frame.columns]:
                    raise OutputFormatError(
                        f"{path}: snapshot {number} lacks the columns {', '.join(missing)}; it has "
                        f"{' '.join(frame.columns)}; {AGAIN}"
                    )
                number += 1
                yield _sorted(frame, sort_by) if sort_by else frame
        except _CutShortError:
            if not partial:
                raise OutputFormatError(f"{lines.place()}: snapshot {number} is cut short; {CUT}") from None
            log.warning("%s: snapshot %d is cut short and left out", path, number)
    if not number:
        raise OutputFormatError(f"{path} holds no complete snapshot; {AGAIN}")


class _Lines:
    """Lines of a text file, counted for messages."""

    def __init__(self, path: Path) -> None:
        self.path, self.n_read = path, 0

    def __enter__(self) -> _Lines:
        self._file = open(self.path, encoding="ascii", errors="replace")  # other bytes give an error with their line
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def take(self, n: int) -> list[str]:
        """Return the next n lines, or those that are left."""
        found = list(itertools.islice(self._file, n))
        self.n_read += len(found)
        return found

    def place(self, back: int = 0) -> str:
        """Return the file and the number of the last line read, or of one ``back`` lines before it."""
        return f"{self.path}: line {self.n_read - back}"


class _CutShortError(Exception):
    """Error of a snapshot that ends before its last row."""


def _next_frame(lines: _Lines, number: int) -> Frame | None:
    """Read the next snapshot; None at the end of the file."""
    header = _header(lines, number)
    if header is None:
        return None
    columns, n_rows = tuple(header["columns"][0].split()[2:]), int(header["NUMBER OF"][0])
    rows = lines.take(n_rows)
    if len(rows) < n_rows or (rows and not rows[-1].endswith("\n")):
        raise _CutShortError
    values = read_rows(rows, columns, lambda row: f"{lines.place(n_rows - 1 - row)} (snapshot {number})")
    bounds = [" ".join(line.split()[:2]) for line in header["BOX BOUNDS"]]
    box = read_rows(bounds, ("low", "high"), lambda _: f"{lines.path}: box of snapshot {number}")
    return Frame(int(header["TIMESTEP"][0]), box, columns, values)


def _header(lines: _Lines, number: int) -> dict[str, list[str]] | None:
    """Read the header of a snapshot: lines by title, and that of its rows as ``columns``; None at the file's end."""
    header: dict[str, list[str]] = {}
    while titles := lines.take(1):
        title = titles[0]
        if not title.endswith("\n"):
            raise _CutShortError
        if not title.startswith("ITEM:"):
            raise OutputFormatError(
                f"{lines.place()}: expected the header of snapshot {number}, found {title.strip()[:60]!r}; {DAMAGED}"
            )
        if title.startswith(("ITEM: ATOMS", "ITEM: ENTRIES")):
            header["columns"] = titles
            break
        name = " ".join(title.split()[1:3])
        if name in header:
            raise OutputFormatError(f"{lines.place()}: a second {name} in snapshot {number}; {DAMAGED}")
        header[name] = lines.take(3 if name == "BOX BOUNDS" else 1)
        if name in _COUNTS and header[name]:
            whole_number(header[name][0], _COUNTS[name], lines.place())
    if not header:
        return None
    if "columns" not in header:
        raise _CutShortError
    if missing := [name for name in (*_COUNTS, "BOX BOUNDS") if name not in header]:
        raise OutputFormatError(f"{lines.place()}: snapshot {number} lacks its {', '.join(missing)}; {DAMAGED}")
    return header


def _sorted(frame: Frame, name: str) -> Frame:
    key = frame[name]
    if np.any(key[1:] < key[:-1]):
        frame.values[:] = frame.values[np.argsort(key, kind="stable")]
    return frame
