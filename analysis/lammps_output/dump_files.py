"""Files of the dumps of a run: one of all ranks or one of each, and those of resumed runs."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.lammps_output.dump_formats import BINARY, binary_frames, text_frames
from granwave.analysis.lammps_output.frame import AGAIN, CutShortError, Frame
from granwave.lammps_inputs.ownership import output_names
from granwave.lammps_inputs.run_directory import (
    CASE_FILE,
    CONTACTS_FILE,
    DUMPS,
    FRAMES_FILES,
    FRAMES_RESUMED,
    INITIAL_FORCES_FILE,
    RANK,
    files_of,
    of_each_rank,
)

_PART_NUMBER = re.compile(r"\.\d+(?=\.\w+$)")  # of the rank, in the name of a file


def frames_path(directory: str | Path) -> Path:
    """Return the path of the dump of snapshots, binary or text, with "%" if each rank wrote its own.

    Raises
    ------
    MissingOutputError
        There is none.
    """
    names = [form for name in FRAMES_FILES.values() for form in (name, of_each_rank(name))]
    return Path(directory) / DUMPS / _present(Path(directory), names)


def contacts_path(directory: str | Path) -> Path:
    """Return the path of the dump of contacts as `frames_path` does, and raise as it does."""
    return Path(directory) / DUMPS / _present(Path(directory), [CONTACTS_FILE, of_each_rank(CONTACTS_FILE)])


def initial_forces_path(directory: str | Path) -> Path | None:
    """Return the path of the dump of contact forces after the static stage, with "%" if each rank wrote its own.

    None if there was no such stage, or an early version ran it, which did not write it. A file that is listed among
    those of the run counts, even if it is missing.
    """
    folder, own = Path(directory) / DUMPS, output_names(Path(directory))
    for name in (INITIAL_FORCES_FILE, of_each_rank(INITIAL_FORCES_FILE)):
        files = files_of(folder, name)
        if any(f"{DUMPS}/{file}" in own for file in files or [name]):
            return folder / name
        if not own and any((folder / file).exists() for file in files):
            return folder / name
    return None


def frames_dumps(directory: Path) -> list[list[Path]]:
    """Return the files of the dumps of snapshots, one list for the run and each resumption, in order of time.

    A list holds one file, or one of each rank. A resumption may have no snapshot.

    Raises
    ------
    MissingOutputError
        There is no dump, or the file of a rank is missing.
    """
    dumps = _dumps_of_frames(directory)
    contacts = directory / DUMPS / of_each_rank(CONTACTS_FILE)  # written by the same ranks as the last snapshot
    return [rank_files(path, like=contacts if path is dumps[-1] else None) for path in dumps]


def contacts_files(directory: Path) -> list[Path]:
    """Return the files of the dump of contacts, one or that of each rank; raise as `frames_dumps`."""
    return rank_files(contacts_path(directory), like=_dumps_of_frames(directory)[-1])


def rank_files(path: Path, like: Path | None = None) -> list[Path]:
    """Return the files of a dump: itself, or those of all ranks where its name has "%".

    Parameters
    ----------
    like
        Another dump of the same ranks, if there is one.

    Raises
    ------
    MissingOutputError
        The file of a rank is missing.
    """
    if RANK not in path.name:
        return [path]
    found = _numbers(path)
    others = _numbers(like) if like is not None and RANK in like.name else set()
    expected = max(found | others) + 1
    if missing := sorted(set(range(expected)) - found):
        lost = path.with_name(path.name.replace(RANK, str(missing[0])))
        more = f" (and {len(missing) - 1} more)" if len(missing) > 1 else ""
        raise MissingOutputError(
            f"{lost} is missing{more}: each of {expected} ranks wrote a part of {path.name}; copy it back, or {AGAIN}"
        )
    return [path.with_name(path.name.replace(RANK, str(number))) for number in range(expected)]


def frames_of_all(paths: list[Path], at_once: int | None = None) -> Iterator[Frame]:
    """Iterate over the snapshots of a dump whose rows lie in several files, one range of ids in each, rising.

    Parameters
    ----------
    paths
        Files in the order of the ranks.
    at_once
        Largest number of rows in a frame; None: a frame holds all rows of a file.

    Raises
    ------
    CutShortError
        A file ends within a snapshot, or before it.
    OutputFormatError
        A file is damaged, or belongs to another run.
    """
    readers = [(binary_frames if path.suffix == BINARY else text_frames)(path, at_once) for path in paths]
    number, step = 0, None
    while True:
        for rank, (path, reader) in enumerate(zip(paths, readers, strict=True)):
            if (frame := next(reader, None)) is None:
                if any(next(other, None) is not None for other in readers) or rank:
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
            yield frame if path is paths[-1] else frame.followed()
        number, step = number + 1, None


def missing_dump(directory: str | Path, path: Path) -> MissingOutputError:
    """Return the error of a dump that a run did not write."""
    return MissingOutputError(
        f"{path} is missing: the run did not get as far as writing it; finish the run "
        f"(granwave run {Path(directory) / CASE_FILE} -o {directory} --resume)"
    )


def _numbers(path: Path) -> set[int]:
    """Return the numbers of the ranks whose files of a dump are there."""
    before, after = path.name.split(RANK)
    return {int(name.removeprefix(before).removesuffix(after)) for name in files_of(path.parent, path.name)}


def _present(directory: Path, names: list[str]) -> str:
    """Return which of these dumps there is."""
    folder = directory / DUMPS
    there = [name for name in names if any((folder / file).exists() for file in files_of(folder, name))]
    listed = [name for name in names if f"{DUMPS}/{name}" in output_names(directory)]
    if not there:
        raise missing_dump(directory, folder / (listed or names)[0])
    return there[0]


def _dumps_of_frames(directory: Path) -> list[Path]:
    """Return the dump of snapshots of a run, and those of its resumptions, in order of time."""
    found, own = {}, output_names(directory)
    for name in FRAMES_RESUMED.values():
        before, after = name.split("{}")
        for path in (directory / DUMPS).glob(f"{before}*{after}"):
            dump = _PART_NUMBER.sub(f".{RANK}", path.name)
            step = dump.removeprefix(before).removesuffix(after).removesuffix(f".{RANK}")
            if step.isdecimal() and path.stat().st_size and (not own or f"{DUMPS}/{path.name}" in own):
                found[int(step)] = path.with_name(dump)
    return [frames_path(directory), *(found[step] for step in sorted(found))]
