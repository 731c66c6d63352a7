"""Readers of the dumps of LAMMPS: snapshots of spheres, contacts, wall contacts; and of the data
file.

A dump is one file of all ranks or several files, each of some ranks, and the files of resumed
runs. All values are float64: overlaps of micrometres in a packing of a metre exceed single
precision. Snapshots are read one at a time; with ``at_once`` in frames of at most this many rows.
All readers raise

MissingOutputError
    There is no such file, or the file of a rank is missing.
OutputFormatError
    The file lacks a column, a snapshot is damaged or cut, or none is complete.
"""

from __future__ import annotations

import dataclasses
import itertools
import logging
import re
from collections.abc import Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.lammps_output.binary import BINARY, binary_frames
from granwave.analysis.lammps_output.frame import (
    AGAIN,
    CUT,
    DAMAGED,
    CutShortError,
    Frame,
    Lines,
    TextRows,
    after_header,
    data_rows,
    joined,
    read_rows,
    rows_without_header,
    text_frames,
    text_rows,
    whole_number,
)
from granwave.lammps_inputs import run_directory as files
from granwave.lammps_inputs.deck import columns
from granwave.lammps_inputs.own_files import AnyPath
from granwave.lammps_inputs.processes import ALONE, Processes
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import DUMPS, RANK, files_of, of_each_rank, shown_dump

# Columns that the readers require; others are optional, see `Frame.get`. Early versions did not
# write "elastic".
SPHERE_COLUMNS = tuple(name for name in columns.names(columns.SNAPSHOT) if name != "elastic")
CONTACT_COLUMNS = columns.names(columns.CONTACTS)
WALL_COLUMNS = columns.names(columns.WALL_CONTACTS)
DATA_COLUMNS = ("id", "type", "diameter", "density", "x", "y", "z")
_PART_NUMBER = re.compile(r"\.\d+(?=\.\w+$)")  # number of the rank, in the name of a file

_ROW_BYTES = 128  # approximate size of a contact in a dump

log = logging.getLogger(__name__)


def read_frames(
    directory: AnyPath, at_once: int | None = None, *, partial: bool = True, unread: bool = False
) -> Iterator[Frame]:
    """Iterate over the snapshots of ``dumps/spheres.bin`` or ``spheres.dump``, `SPHERE_COLUMNS`,
    rows sorted by id.

    Rows in several files are joined. The snapshots of resumed runs follow in separate files. If a
    step was written twice (resumed run), the first is used. With ``at_once`` only the rows of a
    frame are sorted; rows of a snapshot stay in the order in which LAMMPS wrote them: sorted in one
    file, in the order of the ranks in several files.

    Parameters
    ----------
    partial
        True to skip a truncated last snapshot, for instance of a killed run, with a warning;
        otherwise it is an error.
    unread
        True to leave reading and sorting to the caller, `Frame.read` and `Frame.sorted_by`, where
        the dump is binary.
    """
    results = ResultDirectory.at(directory)
    dumps = _dumps_of_frames(results)
    contacts = (
        results / DUMPS / of_each_rank(files.CONTACTS_FILE)
    )  # written by the same ranks as the last snapshot
    paths = [_rank_files(path, like=contacts if path is dumps[-1] else None) for path in dumps]
    pieces = itertools.chain.from_iterable(
        _pieces(one, SPHERE_COLUMNS, at_once, partial=partial) for one in paths
    )
    rising = _rising(joined(pieces) if at_once is None else pieces)
    return rising if unread else (frame.read().sorted_by("id") for frame in rising)


def frames_path(directory: AnyPath) -> Path:
    """Return the path of the dump of snapshots, binary or text; "%" stands for several files."""
    forms = ((name, of_each_rank(name)) for name in files.FRAMES_FILES.values())
    return _present(ResultDirectory.at(directory), [*itertools.chain.from_iterable(forms)])


def read_instants(
    directory: Path, name: str, required: tuple[str, ...], sort_by: str = ""
) -> Iterator[Frame]:
    """Iterate over the snapshots of another dump by its name, with these columns, sorted by one of
    them.
    """
    path = directory / DUMPS / name
    if not path.exists():
        raise _missing_dump(directory, path)
    for frame in _rising(joined(_pieces([path], required))):
        yield frame.sorted_by(sort_by) if sort_by else frame


def read_frame_forces(directory: Path) -> Iterator[Frame]:
    """Iterate over the contacts at every snapshot: i, j, force, tx, ty, tz (N, on sphere i)."""
    return read_instants(
        directory, files.FRAME_FORCES_FILE, columns.names(columns.FORCES_AT_FRAMES)
    )


@dataclasses.dataclass(frozen=True)
class ContactDump:
    """Contacts at one instant: one or several files, with the number of rows that LAMMPS counted.

    Attributes
    ----------
    path
        Path of the dump, with "%" if it has several files.
    like
        Another dump of the same ranks, if there is one.
    required
        Columns that it must have.
    count
        Name of the file with the number of rows in all files.
    """

    path: Path
    like: Path | None
    required: tuple[str, ...]
    count: str

    @property
    def paths(self) -> list[Path]:
        """Files of the dump."""
        return _rank_files(self.path, self.like)

    def frames(self, at_once: int | None = None) -> Iterator[Frame]:
        """Iterate over the rows; without ``at_once`` they are one frame."""
        rows = self._frames(at_once)
        return joined(rows) if at_once is None else rows

    def _frames(self, at_once: int | None) -> Iterator[Frame]:
        first, *others = self.paths
        n_rows = 0
        frame = None
        in_parts = RANK in self.path.name
        for frame in _pieces([first], self.required, at_once):
            n_rows += len(frame)
            yield frame.with_rows(frame.values, more=True) if in_parts else frame
        if not in_parts:
            return
        assert frame is not None  # else there was no complete snapshot
        for other in others:
            try:
                for rows in rows_without_header(other, frame, at_once):
                    n_rows += len(rows)
                    yield rows
            except CutShortError as error:
                raise OutputFormatError(f"{error}; {CUT}") from None
        expected = self._noted()
        if n_rows != expected:
            raise OutputFormatError(
                f"{shown_dump(self.path)}: found {n_rows} contacts, {self.count} says {expected}: "
                f"a file is truncated or belongs to another run; {AGAIN}"
            )
        yield frame.with_rows(frame.values[:0])

    def unread(self, at_once: int) -> tuple[Frame, Iterator[Frame], int]:
        """Return a frame without rows, the rows in pieces of about this size that any process can
        read, and their expected number. For a file with fewer or more rows, `frames` raises the
        error of a damaged file.
        """
        like = next(self.frames(1))  # checks header and columns
        paths = self.paths
        begin, expected = after_header(paths[0])
        if RANK in self.path.name:
            expected = self._noted()
        begins = itertools.chain([begin], itertools.repeat(0))
        pieces = map(partial(text_rows, n_bytes=_ROW_BYTES * at_once), paths, begins)
        rows = (like.with_rows(piece) for piece in itertools.chain.from_iterable(pieces))  # type: ignore[arg-type]
        return like.with_rows(like.values[:0]), rows, expected

    def _noted(self) -> int:
        noted = self.path.with_name(self.count)
        if not noted.exists():
            raise MissingOutputError(f"{noted} is missing; {AGAIN}")
        return whole_number(
            noted.read_text(encoding="ascii", errors="replace"), "number of contacts", str(noted)
        )


def contacts_at_end(directory: AnyPath) -> ContactDump:
    """Return the contacts at the end of the run (``dumps/contacts.dump``); a forgotten dent has a
    separate row.

    Columns `CONTACT_COLUMNS` and, as far as recorded, tangential_force, elastic_tangential,
    friction (dissipation) and initial (initial dent): overlaps in m, forces in N, energies in J,
    times in s (-1: never).
    """
    results = ResultDirectory.at(directory)
    path = _present(results, [files.CONTACTS_FILE, of_each_rank(files.CONTACTS_FILE)])
    return ContactDump(path, _dumps_of_frames(results)[-1], CONTACT_COLUMNS, files.COUNT_FILE)


def contacts_after_static_stage(directory: AnyPath) -> ContactDump | None:
    """Return the contact forces after the static stage: i, j, force (N).

    None if there was no such stage. A file that the run lists must exist.
    """
    results = ResultDirectory.at(directory)
    folder = results / DUMPS
    own = results.output_names()
    for name in (files.INITIAL_FORCES_FILE, of_each_rank(files.INITIAL_FORCES_FILE)):
        there = files_of(folder, name) or [name]
        path = folder / name
        exist = [(folder / file).exists() for file in there]
        if any(f"{DUMPS}/{file}" in own for file in there) or (not own and any(exist)):
            if not all(exist):
                raise MissingOutputError(f"{shown_dump(path)} is missing; {AGAIN}")
            return ContactDump(path, None, columns.names(columns.FORCES), files.INITIAL_COUNT_FILE)
    return None


def read_wall_contacts(directory: AnyPath, *, after_static_stage: bool = False) -> dict[str, Frame]:
    """Read the contacts with each plane at the end of the run (``dumps/wall_NAME.dump``), by its
    name; none: empty.

    Columns id, `WALL_COLUMNS` and, as far as recorded, tangential_force, friction and initial. Only
    dumps listed in the input script count, if it lists any; a plane has NAME, and NAME_2 for a
    further material.

    Parameters
    ----------
    after_static_stage
        True to read the forces after the static stage instead: id and force (N).
    """
    before, after = files.WALL_CONTACTS_FILE.split("{}")
    required = columns.names(columns.WALL_FORCES) if after_static_stage else WALL_COLUMNS
    found: dict[str, list[Frame]] = {}
    results = ResultDirectory.at(directory)
    own = results.output_names()
    for path in sorted((results / DUMPS).glob(f"{before}*{after}")):
        if own and f"{DUMPS}/{path.name}" not in own:
            continue
        fix = path.name.removeprefix(before).removesuffix(after)
        source = (
            path.with_name(files.INITIAL_WALL_FORCES_FILE.format(fix))
            if after_static_stage
            else path
        )
        if not source.exists():
            raise MissingOutputError(f"{source} is missing; {AGAIN}")
        *_, frame = joined(_pieces([source], ("id", *required)))
        found.setdefault(fix.split("_")[0], []).append(frame)
    return {
        name: parts[0].with_rows(np.concatenate([part.values for part in parts])).sorted_by("id")
        for name, parts in found.items()
    }


def refuse_ids(path: Path, strange: NDArray[np.float64]) -> None:
    """Raise OutputFormatError if a dump contains particles that the data file lacks."""
    if len(strange):
        raise OutputFormatError(
            f"{path}: found a contact of particle {strange.min():.0f}, which data.granwave does "
            f"not contain: the files belong to different runs, or one of them is damaged; {AGAIN}"
        )


def read_data(
    directory: Path, at_once: int | None = None, processes: Processes = ALONE
) -> Iterator[Frame]:
    """Iterate over the particles at the start (``data.granwave``), `DATA_COLUMNS` in m and kg/m^3,
    as in the file.

    The nodes of bars come last; they have diameter 0 and their mass in kg as density. Without
    ``at_once`` it is one frame.
    """
    path = directory / files.DATA_FILE
    if not path.exists():
        raise MissingOutputError(f"{path} is missing; {AGAIN}")
    with Lines(path) as lines:
        header = _data_header(lines)
        size = at_once or header.n_spheres
        blocks = _data_blocks(lines, header, size, processes)
        before = lines.n_read
        n_read = 0
        rest = np.empty((0, len(header.names)))
        for values in blocks:
            n_left = header.n_spheres - n_read
            rest = np.concatenate([rest, values])[:n_left] if len(rest) else values[:n_left]
            while len(rest) >= min(size, header.n_spheres - n_read) > 0:
                table = Frame(0, header.box, header.names, rest[:size]).vector(*DATA_COLUMNS)
                rest = rest[size:]
                n_read += len(table)
                more = n_read < header.n_spheres
                rows = np.ascontiguousarray(table)
                yield Frame(0, header.box, DATA_COLUMNS, rows, more=more)
        if n_read < header.n_spheres:
            n_read += len(rest)
            raise _cut_data(header, before + n_read, n_read)


class DataHeader(NamedTuple):
    """Header of a data file: number of atoms, columns of their rows, and box, (3, 2), m."""

    path: Path
    n_spheres: int
    names: tuple[str, ...]
    box: NDArray[np.float64]


def _data_header(lines: Lines) -> DataHeader:
    """Read the header of a data file up to its first row.

    Raises
    ------
    OutputFormatError
        It lacks the number of atoms, or a column.
    """
    path = lines.path
    n_spheres = 0
    names: tuple[str, ...] = DATA_COLUMNS
    box = np.zeros((3, 2))
    lines.take(1)  # the title
    while found := lines.take(1):
        (line,) = found
        match line.split():
            case [number, "atoms"]:
                n_spheres = whole_number(number, "number of atoms", lines.place())
            case [low, high, ("xlo" | "ylo" | "zlo") as low_name, ("xhi" | "yhi" | "zhi") as name]:
                edges = read_rows([f"{low} {high}"], (low_name, name), lambda _: lines.place())
                box["xyz".index(name[0])] = edges[0]
            case ["Atoms", *_]:
                names = tuple(line.partition(":")[2].split()) or DATA_COLUMNS
                break
    if not n_spheres:
        raise OutputFormatError(f"{path} does not state the number of atoms; {DAMAGED}")
    missing = [name for name in DATA_COLUMNS if name not in names]
    if missing:
        raise OutputFormatError(
            f"{path} has no columns {', '.join(missing)}; it has {' '.join(names)}; {AGAIN}"
        )
    lines.take(1)
    return DataHeader(path, n_spheres, names, box)


def _data_blocks(
    lines: Lines, header: DataHeader, size: int, processes: Processes
) -> Iterator[NDArray[np.float64]]:
    """Iterate over the rows of a data file in blocks of about ``size``; several processes read a
    large file.
    """
    path, n_spheres, names, _ = header
    if n_spheres > size and (pieces := data_rows(path, _ROW_BYTES * size)):
        yield from processes.map(partial(TextRows.read, columns=names), pieces)
        return
    for first in range(0, n_spheres, size):
        n_rows = min(size, n_spheres - first)
        rows = lines.take(n_rows)
        if len(rows) < n_rows:
            raise _cut_data(header, lines.n_read, first + len(rows))
        yield read_rows(rows, names, partial(_line_of, path, lines.n_read - n_rows))


def _line_of(path: Path, n_above: int, row: int) -> str:
    return f"{path}: line {n_above + row + 1}"


def _cut_data(header: DataHeader, line: int, n_read: int) -> OutputFormatError:
    """Return the error of a data file that ends after some rows, at a line."""
    rows = f"{n_read} of {header.n_spheres} rows under Atoms ({' '.join(header.names)})"
    return OutputFormatError(f"{header.path}: line {line}: found {rows}; {CUT}")


def _rising(frames: Iterable[Frame]) -> Iterator[Frame]:
    """Skip repeated steps of resumed runs; the first is used."""
    last_step = -1
    for frame in frames:
        if frame.step > last_step:
            yield frame
            last_step = last_step if frame.more else frame.step


def _pieces(
    paths: list[Path],
    required: tuple[str, ...],
    at_once: int | None = None,
    *,
    partial: bool = False,
) -> Iterator[Frame]:
    """Iterate over the snapshots of a dump of one or more files; check their columns, and that
    there is one.

    With ``partial`` a truncated last snapshot is skipped with a warning.
    """
    number = 0
    path = paths[0]
    try:
        for frame in _of_all_parts(paths, at_once):
            if missing := [name for name in required if name not in frame.columns]:
                raise OutputFormatError(
                    f"{path}: snapshot {number} has no columns {', '.join(missing)}; it has "
                    f"{' '.join(frame.columns)}; {AGAIN}"
                )
            yield frame
            number += not frame.more
    except CutShortError as error:
        if not partial:
            raise OutputFormatError(f"{error}; {CUT}") from None
        log.warning("%s: snapshot %d is truncated and ignored", path, number)
    if not number:
        raise OutputFormatError(f"{path} holds no complete snapshot; {AGAIN}")


def _of_all_parts(paths: list[Path], at_once: int | None) -> Iterator[Frame]:
    """Iterate over the snapshots of a dump in several files, with the rows of each in turn."""
    readers = [
        (binary_frames if path.suffix == BINARY else text_frames)(path, at_once) for path in paths
    ]
    for number in itertools.count():
        step = None
        for path, reader in zip(paths, readers, strict=True):
            if (frame := next(reader, None)) is None:
                if path is not paths[0] or any(next(other, None) is not None for other in readers):
                    raise CutShortError(str(path), number)
                return
            if step not in (None, frame.step):
                raise OutputFormatError(
                    f"{path}: found step {frame.step} in snapshot {number}, {paths[0].name} has step {step}: the files "
                    f"belong to different runs; {AGAIN}"
                )
            step = frame.step
            while frame.more:
                yield frame
                frame = next(reader)
            yield frame.with_rows(frame.values, more=path is not paths[-1])


def _rank_files(path: Path, like: Path | None = None) -> list[Path]:
    """Return the files of a dump: the dump itself, or all its parts if its name contains "%";
    ``like`` is another dump of the same session, with as many parts.
    """
    if RANK not in path.name:
        return [path]

    def numbers(dump: Path) -> set[int]:
        before, after = dump.name.split(RANK)
        return {
            int(name.removeprefix(before).removesuffix(after))
            for name in files_of(dump.parent, dump.name)
        }

    found = numbers(path)
    expected = max(found | (numbers(like) if like is not None and RANK in like.name else set())) + 1
    parts = [path.with_name(path.name.replace(RANK, str(number))) for number in range(expected)]
    if missing := sorted(set(range(expected)) - found):
        more = f" (and {len(missing) - 1} more)" if len(missing) > 1 else ""
        raise MissingOutputError(
            f"{parts[missing[0]]} is missing{more}: the dump has {expected} files; copy it "
            f"back, or {AGAIN}"
        )
    return parts


def _missing_dump(directory: Path, path: Path) -> MissingOutputError:
    return MissingOutputError(
        f"{path} is missing: the run stopped before writing it; finish the run (granwave run "
        f"{directory / files.CASE_FILE} -o {directory} --resume)"
    )


def _present(results: ResultDirectory, names: list[str]) -> Path:
    """Return the dumps among these that exist."""
    folder = results / DUMPS
    own = results.output_names()
    there = [
        name for name in names if any((folder / file).exists() for file in files_of(folder, name))
    ]
    listed = [name for name in names if f"{DUMPS}/{name}" in own]
    if not there:
        raise _missing_dump(results.path, folder / (listed or names)[0])
    return folder / there[0]


def _dumps_of_frames(results: ResultDirectory) -> list[Path]:
    """Return the dumps of snapshots of a run and of its resumptions, in order of time."""
    found = {}
    own = results.output_names()
    for name in files.FRAMES_RESUMED.values():
        before, after = name.split("{}")
        for path in (results / DUMPS).glob(f"{before}*{after}"):
            dump = _PART_NUMBER.sub(f".{RANK}", path.name)
            step = dump.removeprefix(before).removesuffix(after).removesuffix(f".{RANK}")
            if (
                step.isdecimal()
                and path.stat().st_size
                and (not own or f"{DUMPS}/{path.name}" in own)
            ):
                found[int(step)] = path.with_name(dump)
    return [frames_path(results), *(found[step] for step in sorted(found))]
