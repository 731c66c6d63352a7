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

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.lammps_output.binary_dump import BINARY, binary_frames
from granwave.analysis.lammps_output.frame import CutShortError, Frame
from granwave.analysis.lammps_output.number_rows import AGAIN, CUT, DAMAGED, read_rows, whole_number
from granwave.analysis.lammps_output.text_dump import Lines, text_frames
from granwave.lammps_inputs.deck import columns
from granwave.lammps_inputs.ownership import output_names
from granwave.lammps_inputs.run_directory import (
    CASE_FILE,
    CONTACTS_FILE,
    DATA_FILE,
    DUMPS,
    FORCES_FILE,
    FRAMES_FILES,
    FRAMES_PART,
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
DATA_COLUMNS = ("id", "type", "diameter", "density", "x", "y", "z")

log = logging.getLogger(__name__)


def read_frames(directory: str | Path, *, partial: bool = True) -> Iterator[Frame]:
    """Iterate over the snapshots of ``dumps/spheres.bin`` or ``spheres.dump``, `SPHERE_COLUMNS`, rows sorted by id.

    Those of a resumed run with binary dumps follow in files of their own.

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
    paths = [frames_path(directory), *_parts_of_resumed(Path(directory))]
    parts = (_frames(path, SPHERE_COLUMNS, sort_by="id", partial=partial) for path in paths)
    yield from _rising(itertools.chain.from_iterable(parts))


def frames_path(directory: str | Path) -> Path:
    """Return the path of the dump of snapshots, binary or text; raise MissingOutputError if there is none."""
    names = [*FRAMES_FILES.values()]
    there = [name for name in names if (Path(directory) / DUMPS / name).exists()]
    listed = [name for name in names if f"{DUMPS}/{name}" in output_names(Path(directory))]
    return _dump(directory, (there or listed or names)[0])


def _parts_of_resumed(directory: Path) -> list[Path]:
    """Return the paths of the snapshots that resumed runs wrote, in order of time; a part may have none."""
    before, after = FRAMES_PART.split("{}")
    found = {
        int(step): path
        for path in (directory / DUMPS).glob(FRAMES_PART.format("*"))
        if (step := path.name.removeprefix(before).removesuffix(after)).isdecimal() and path.stat().st_size
    }
    own = output_names(directory)
    return [found[step] for step in sorted(found) if not own or f"{DUMPS}/{found[step].name}" in own]


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
    read = binary_frames if path.suffix == BINARY else text_frames
    try:
        for frame in read(path):
            if missing := [name for name in required if name not in frame.columns]:
                raise OutputFormatError(
                    f"{path}: snapshot {number} lacks the columns {', '.join(missing)}; it has "
                    f"{' '.join(frame.columns)}; {AGAIN}"
                )
            number += 1
            yield _sorted(frame, sort_by) if sort_by else frame
    except CutShortError as error:
        if not partial:
            raise OutputFormatError(f"{error}; {CUT}") from None
        log.warning("%s: snapshot %d is cut short and left out", path, number)
    if not number:
        raise OutputFormatError(f"{path} holds no complete snapshot; {AGAIN}")


def _sorted(frame: Frame, name: str) -> Frame:
    key = frame[name]
    if np.any(key[1:] < key[:-1]):
        frame.values[:] = frame.values[np.argsort(key, kind="stable")]
    return frame
