"""Readers of the dumps of LAMMPS: snapshots of spheres, contacts, wall contacts; and of the data file.

All values are float64: overlaps of micrometres in a packing of a metre exceed single precision. Snapshots are read one
at a time.
"""

from __future__ import annotations

import dataclasses
import itertools
import logging
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.lammps_output.dump_files import (
    contacts_files,
    contacts_path,
    frames_dumps,
    frames_of_all,
    initial_forces_path,
    missing_dump,
    rank_files,
)
from granwave.analysis.lammps_output.dump_formats import Lines, rows_without_header
from granwave.analysis.lammps_output.frame import (
    AGAIN,
    CUT,
    DAMAGED,
    CutShortError,
    Frame,
    joined,
    read_rows,
    whole_number,
)
from granwave.lammps_inputs.deck import columns
from granwave.lammps_inputs.ownership import output_names
from granwave.lammps_inputs.run_directory import (
    COUNT_FILE,
    DATA_FILE,
    DUMPS,
    FORCES_FILE,
    FRAME_FORCES_FILE,
    HISTORY_FILE,
    INITIAL_COUNT_FILE,
    INITIAL_WALL_FORCES_FILE,
    RANK,
    WALL_CONTACTS_FILE,
    files_of,
)

# Columns that the readers require; others are optional, see `Frame.get`.
SPHERE_COLUMNS = tuple(
    name for name in columns.names(columns.SNAPSHOT) if name != "elastic"
)  # which early versions did not write
CONTACT_COLUMNS = columns.names(columns.CONTACTS)
WALL_COLUMNS = columns.names(columns.WALL_CONTACTS)
HISTORY_COLUMNS = columns.names(columns.HISTORY)
DATA_COLUMNS = ("id", "type", "diameter", "density", "x", "y", "z")

log = logging.getLogger(__name__)


def read_frames(directory: str | Path, *, partial: bool = True) -> Iterator[Frame]:
    """Iterate over the snapshots of ``dumps/spheres.bin`` or ``spheres.dump``, `SPHERE_COLUMNS`, rows sorted by id.

    Where each rank wrote a file of its own, their rows are joined. The snapshots of resumed runs follow in files of
    their own. If a step was written twice (resumed run), the first is used.

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
    dumps = frames_dumps(Path(directory))
    yield from _rising(
        itertools.chain.from_iterable(_frames(one, SPHERE_COLUMNS, "id", partial=partial) for one in dumps)
    )


def read_frames_in_parts(directory: str | Path, at_once: int) -> Iterator[Frame]:
    """Iterate over the same snapshots, each in frames of at most so many rows; raise as `read_frames`.

    Only the rows of a frame are sorted; those of a snapshot are, as LAMMPS writes them.
    """
    dumps = frames_dumps(Path(directory))
    pieces = itertools.chain.from_iterable(_pieces(one, SPHERE_COLUMNS, at_once) for one in dumps)
    yield from (frame.sorted_by("id") for frame in _rising(pieces))


def read_history(directory: str | Path) -> Iterator[Frame]:
    """Iterate over the instants of ``dumps/history.dump``, `HISTORY_COLUMNS`, sorted by id; raise as `read_frames`."""
    return instants(directory, HISTORY_FILE, HISTORY_COLUMNS)


def instants(directory: str | Path, name: str, columns: tuple[str, ...]) -> Iterator[Frame]:
    """Iterate over the instants of the dump of this name, sorted by id; raise as `read_frames`."""
    yield from _rising(_frames(_dump(directory, name), columns, sort_by="id"))


def read_forces(directory: str | Path) -> Iterator[Frame]:
    """Iterate over the contacts at these instants (``dumps/forces.dump``: i, j, force); raise as `read_frames`."""
    yield from _rising(_frames(_dump(directory, FORCES_FILE), ("i", "j", "force")))


def read_frame_forces(directory: str | Path) -> Iterator[Frame]:
    """Iterate over the contacts at every snapshot: i, j, force, tx, ty, tz (N, on sphere i); raise as `read_frames`."""
    names = tuple(column.name for column in columns.FORCES_AT_FRAMES)
    yield from _rising(_frames(_dump(directory, FRAME_FORCES_FILE), names))


def read_contacts(directory: str | Path) -> Frame:
    """Read the contacts at the end of the run (``dumps/contacts.dump``), with forgotten dents as separate rows.

    Columns `CONTACT_COLUMNS` and, as far as recorded, tangential_force, elastic_tangential, friction (dissipation) and
    initial (initial dent): overlaps in m, forces in N, energies in J, times in s (-1: never). Raise as
    `read_frames`.
    """
    *_, frame = joined(read_contacts_in_parts(directory))
    return frame


def read_contacts_in_parts(directory: str | Path, at_once: int | None = None) -> Iterator[Frame]:
    """Iterate over the rows of `read_contacts`, at most so many at once; raise as `read_frames`.

    Raises
    ------
    OutputFormatError
        The files of all ranks together hold fewer or more rows than were written.
    """
    path = contacts_path(directory)
    yield from _contacts(path, contacts_files(Path(directory)), CONTACT_COLUMNS, COUNT_FILE, at_once)


def read_initial_forces_in_parts(directory: str | Path, at_once: int | None = None) -> Iterator[Frame]:
    """Iterate over the contact forces after the static stage: i, j, force (N), at most so many rows at once.

    There are none if `initial_forces_path` finds no dump; else raise as `read_contacts_in_parts`.
    """
    if (path := initial_forces_path(directory)) is None:
        return
    if not all((path.parent / name).exists() for name in files_of(path.parent, path.name) or [path.name]):
        raise MissingOutputError(f"{path} is missing; {AGAIN}")
    yield from _contacts(path, rank_files(path), columns.names(columns.FORCES), INITIAL_COUNT_FILE, at_once)


def _contacts(
    path: Path, files: list[Path], required: tuple[str, ...], count: str, at_once: int | None
) -> Iterator[Frame]:
    """Iterate over the rows of a dump of contacts, the files of all ranks; ``count``: file with their number."""
    first, *others = files
    n_rows, frame, in_parts = 0, None, RANK in path.name
    for frame in _pieces([first], required, at_once):
        n_rows += len(frame)
        yield frame.followed() if in_parts else frame
    assert frame is not None  # else there was no complete snapshot
    for other in others:
        try:
            for rows in rows_without_header(other, frame, at_once):
                n_rows += len(rows)
                yield rows
        except CutShortError as error:
            raise OutputFormatError(f"{error}; {CUT}") from None
    if in_parts:
        _check_count(path, path.with_name(count), n_rows)
        yield dataclasses.replace(frame, values=frame.values[:0], more=False)


def _check_count(path: Path, noted: Path, n_rows: int) -> None:
    """Compare the number of contacts in the files of all ranks with that which LAMMPS noted."""
    if not noted.exists():
        raise MissingOutputError(f"{noted} is missing; {AGAIN}")
    expected = whole_number(noted.read_text(encoding="ascii", errors="replace"), "number of contacts", str(noted))
    if n_rows != expected:
        raise OutputFormatError(
            f"{path} (all ranks): found {n_rows} contacts, {noted.name} says {expected}: a file was cut or "
            f"belongs to another run; {AGAIN}"
        )


def read_wall_contacts(directory: str | Path) -> dict[str, Frame]:
    """Read the contacts with each plane at the end of the run (``dumps/wall_NAME.dump``), by its name.

    Columns id, `WALL_COLUMNS` and, as far as recorded, tangential_force, friction and initial.

    The result is empty if there is no plane.
    """
    return _by_wall(_wall_dumps(Path(directory)), WALL_COLUMNS)


def read_initial_wall_forces(directory: str | Path) -> dict[str, Frame]:
    """Read the forces on each plane after the static stage, id and force (N), by its name.

    Raises
    ------
    MissingOutputError
        The file of a plane is missing.
    """
    paths = {}
    for fix, path in _wall_dumps(Path(directory)).items():
        paths[fix] = path.with_name(INITIAL_WALL_FORCES_FILE.format(fix))
        if not paths[fix].exists():
            raise MissingOutputError(f"{paths[fix]} is missing; {AGAIN}")
    return _by_wall(paths, columns.names(columns.WALL_FORCES))


def _by_wall(paths: dict[str, Path], required: tuple[str, ...]) -> dict[str, Frame]:
    """Read dumps of the fixes of planes; a plane has NAME, and NAME_2 for a further material."""
    found: dict[str, list[Frame]] = {}
    for fix, path in paths.items():
        *_, frame = _frames([path], ("id", *required), sort_by="id")
        found.setdefault(fix.split("_")[0], []).append(frame)
    return {
        name: dataclasses.replace(parts[0], values=np.concatenate([part.values for part in parts])).sorted_by("id")
        for name, parts in found.items()
    }


def _wall_dumps(directory: Path) -> dict[str, Path]:
    """Return the paths of the dumps of walls by fix; only those of the deck, if it lists them."""
    before, after = WALL_CONTACTS_FILE.split("{}")
    paths, own = sorted((directory / DUMPS).glob(WALL_CONTACTS_FILE.format("*"))), output_names(directory)
    return {
        path.name.removeprefix(before).removesuffix(after): path
        for path in paths
        if not own or f"{DUMPS}/{path.name}" in own
    }


def refuse_ids(path: Path, strange: NDArray[np.float64]) -> None:
    """Raise OutputFormatError if a dump names particles that the data file does not hold."""
    if len(strange):
        raise OutputFormatError(
            f"{path}: found a contact of particle {strange.min():.0f}, which data.granwave does not hold: the files "
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
    (frame,) = joined(read_data_in_parts(directory))
    return frame.sorted_by("id")


def read_data_in_parts(directory: str | Path, at_once: int | None = None) -> Iterator[Frame]:
    """Iterate over the rows of `read_data` as they are in the file, at most so many at once; raise as it does."""
    path = Path(directory) / DATA_FILE
    if not path.exists():
        raise MissingOutputError(f"{path} is missing; {AGAIN}")
    n_spheres = 0
    columns: tuple[str, ...] = DATA_COLUMNS
    box = np.zeros((3, 2))
    with Lines(path) as lines:
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
        if missing := [name for name in DATA_COLUMNS if name not in columns]:
            raise OutputFormatError(
                f"{path} lacks the columns {', '.join(missing)}; it has {' '.join(columns)}; {AGAIN}"
            )
        lines.take(1)
        n_read = 0
        while n_read < n_spheres:
            n_rows = min(at_once or n_spheres, n_spheres - n_read)
            rows = lines.take(n_rows)
            n_read += len(rows)
            if len(rows) < n_rows:
                raise OutputFormatError(
                    f"{lines.place()}: found {n_read} of {n_spheres} rows under Atoms ({' '.join(columns)}); {CUT}"
                )
            read = read_rows(rows, columns, lambda row, last=n_rows - 1: lines.place(last - row))  # type: ignore[misc]
            frame = Frame(0, box, columns, read)
            values = np.ascontiguousarray(frame.vector(*DATA_COLUMNS))
            yield Frame(0, box, DATA_COLUMNS, values, more=n_read < n_spheres)


def _rising(frames: Iterator[Frame]) -> Iterator[Frame]:
    """Skip repeated steps of resumed runs; the first is used."""
    last_step = -1
    for frame in frames:
        if frame.step > last_step:
            yield frame
            last_step = last_step if frame.more else frame.step


def _dump(directory: str | Path, name: str) -> list[Path]:
    path = Path(directory) / DUMPS / name
    if not path.exists():
        raise missing_dump(directory, path)
    return [path]


def _frames(
    paths: list[Path], required: tuple[str, ...], sort_by: str | None = None, *, partial: bool = False
) -> Iterator[Frame]:
    """Iterate over the snapshots of a dump; with ``partial`` a truncated last one is skipped with a warning."""
    for frame in joined(_pieces(paths, required, partial=partial)):
        yield frame.sorted_by(sort_by) if sort_by else frame


def _pieces(
    paths: list[Path], required: tuple[str, ...], at_once: int | None = None, *, partial: bool = False
) -> Iterator[Frame]:
    """Iterate over the snapshots of a dump as `frames_of_all` does; check their columns, and that there is one."""
    number, path = 0, paths[0]
    try:
        for frame in frames_of_all(paths, at_once):
            if missing := [name for name in required if name not in frame.columns]:
                raise OutputFormatError(
                    f"{path}: snapshot {number} lacks the columns {', '.join(missing)}; it has "
                    f"{' '.join(frame.columns)}; {AGAIN}"
                )
            yield frame
            number += not frame.more
    except CutShortError as error:
        if not partial:
            raise OutputFormatError(f"{error}; {CUT}") from None
        log.warning("%s: snapshot %d is cut short and left out", path, number)
    if not number:
        raise OutputFormatError(f"{path} holds no complete snapshot; {AGAIN}")
