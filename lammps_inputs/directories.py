"""Directories of results: start, resume or refuse; what was changed after a run; unsuitable places;
full disks.

A directory that holds results is refused by default. ``--resume`` continues them if they are of the
same case, ``--force`` replaces what granwave wrote. Files that granwave did not write are always
kept, see `granwave.lammps_inputs.run_directory`. Changes are a case.toml or deck that was edited,
and output that was cut, damaged or replaced.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import logging
import math
import os
import re
import shutil
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from granwave.lammps_inputs import ownership, run_directory
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import (
    checksum,
    head,
    read_json,
    read_tables,
    regular,
    replace_text,
)
from granwave.lammps_inputs.processes import ALONE, Processes

logger = logging.getLogger(__name__)
_TAKEN = (
    "Times, energies, forces and snapshots are those that LAMMPS computed; {}material, law, load, walls, timestep and "
    "lattice are those of case.toml, and with them which contacts count as yielded, the size of the plastic zone, and "
    "normalised values: where the change alters one of these, they are wrong"
)
_DIGEST_LENGTH = 16
_SHOWN = 3  # keys in a message
_LONGEST = 40  # characters of a value in a message


def tables_as_run(directory: Path) -> dict[str, Any] | None:
    """Return the tables of case.toml at the start of the run; None if the marker does not hold
    them.
    """
    try:
        return tomllib.loads(ownership.read_marker(directory).case) or None
    except ValueError:  # a marker that somebody edited
        return None


def case_digest(tables: Mapping[str, Any]) -> str:
    """Return a digest of the tables of a case that decide its results."""
    other = (
        "name",
        "resolved",
        run_directory.FIGURES_TABLE,
    )  # name, derived values, and what is drawn
    deciding = {name: table for name, table in tables.items() if name not in other}
    return hashlib.sha256(json.dumps(deciding, sort_keys=True).encode()).hexdigest()[
        :_DIGEST_LENGTH
    ]


def check_case(directory: Path) -> None:
    """Raise InputError if case.toml was changed after the run; the table of figures may be."""
    path = directory / run_directory.CASE_FILE
    there = read_tables(path)
    as_run = tables_as_run(directory)
    if there is None or as_run is None:
        return
    drawn = {run_directory.FIGURES_TABLE: None}
    changes = list(_changes(there | drawn, as_run | drawn))
    if not changes:
        return
    shown = "; ".join(changes[:_SHOWN]) + ("; ..." if len(changes) > _SHOWN else "")
    raise InputError(
        f"{path}: was changed after the run: {shown}. The results are of the case that was run: run "
        f"the changed one into another directory, or delete it: granwave analyse {directory}  puts back what was run"
    )


def restore_case(directory: Path) -> bool:
    """Restore a case.toml that is missing or damaged; return True if it was.

    Raises
    ------
    InputError
        The file was changed after the run.
    """
    check_case(directory)
    if not tables_as_run(directory) or read_tables(directory / run_directory.CASE_FILE) is not None:
        return False
    ownership.claim(directory, [run_directory.CASE_FILE])
    replace_text(directory / run_directory.CASE_FILE, ownership.read_marker(directory).case)
    return True


def _changes(
    there: Mapping[str, Any], as_run: Mapping[str, Any], prefix: str = ""
) -> Iterator[str]:
    for key in dict.fromkeys((*as_run, *there)):
        now = there.get(key)
        then = as_run.get(key)
        name = f"{prefix}{key}"
        if isinstance(now, Mapping) and isinstance(then, Mapping):
            yield from _changes(now, then, f"{name}.")
        elif now != then:
            texts = (
                "left out" if value is None else json.dumps(value, default=str)
                for value in (now, then)
            )
            found, before = (
                text if len(text) <= _LONGEST else text[: _LONGEST - 3] + "..." for text in texts
            )
            yield f"{name} is {found}, was {before}"


def note_files(directory: Path, names: Iterable[str]) -> None:
    """Store sizes and checksums of finished files in the marker, so that `changed_file` detects
    later changes.
    """
    marker = ownership.read_marker(directory)
    if not marker.kind:
        return
    paths = {name: ownership.own_file(directory, name) for name in names}
    marker.files |= {
        name: path.stat().st_size if path is not None else None for name, path in paths.items()
    }
    marker.sums |= {name: checksum(path) for name, path in paths.items() if path is not None}
    marker.write(directory)


def changed_file(
    directory: Path, names: Iterable[str] | None = None, processes: Processes = ALONE
) -> str:
    """Describe the first file that is not what the run wrote; empty if none. Missing files are
    ignored.

    Parameters
    ----------
    names
        Names of the files to look at; None: all that were noted.
    processes
        Processes that read them.
    """
    if not (directory / run_directory.MARKER).is_file():
        return ""
    marker = ownership.read_marker(directory)
    files = {
        name: size
        for name, size in marker.files.items()
        if size is not None and (directory / name).is_file()
    }
    there = [name for name in (files if names is None else names) if name in files]
    for name in there:
        if (size := (directory / name).stat().st_size) != files[name]:
            return f"{directory / name}: is not what the run wrote: it has {size} bytes, had {files[name]}"
    summed = [name for name in there if name in marker.sums]
    for name, found in zip(
        summed, processes.map(checksum, [directory / name for name in summed]), strict=True
    ):
        if found != marker.sums[name]:
            fault = "is not what the run wrote: its checksum differs; it was damaged, or is of another run"
            return f"{directory / name}: {fault}"
    return ""


def changed_result(
    directory: Path, names: Iterable[str] = (run_directory.RESULT_FILE, run_directory.SUMMARY_FILE)
) -> str:
    """Describe the first result of a run that is not what its analysis wrote, and how to mend it;
    empty if none.
    """
    fault = changed_file(directory, names)
    if not fault:
        return ""
    if ownership.read_marker(directory).kind == run_directory.CONTINUUM:
        return f"{fault}: run the case again with resume=True"
    return f"{fault}: make it anew with  granwave analyse {directory}"


def read_summary(directory: Path) -> dict[str, Any]:
    """Read the values of summary.json; empty if missing or damaged."""
    return read_json(directory / run_directory.SUMMARY_FILE) or {}


def result_fault(directory: Path) -> str:
    """Describe the first fault in the results of a finished run; empty if none.

    summary.json must exist. Other files may have been removed, to save disk space for instance.
    """
    files = (run_directory.SUMMARY_FILE, run_directory.RESULT_FILE, run_directory.RECORD_FILE)
    summary, result, record = (directory / name for name in files)
    if not read_summary(directory):
        return f"{summary}: {'is damaged' if summary.exists() else 'is missing'}"
    if record.exists() and read_json(record) is None:
        return f"{record}: is damaged"
    if result.exists() and not ownership.case_of_result(result):
        return f"{result}: is damaged"
    return changed_file(directory)


def outputs_complete(directory: Path) -> bool:
    """Return True if all output of LAMMPS exists as it was at the end of the run."""
    names = [run_directory.DATA_FILE, *ownership.output_names(directory)]
    return (
        len(names) > 1
        and all((directory / name).is_file() for name in names)
        and not changed_file(directory, names)
    )


def note_deck(directory: Path, names: Iterable[str]) -> None:
    """Store the digests of the files of a deck in the marker, so that `changed_files` detects
    edits.
    """
    marker = ownership.read_marker(directory)
    marker.digests |= {name: _digest(directory / name) for name in names}
    marker.write(directory)


def changed_files(directory: Path) -> list[str]:
    """Return the names of the files of a deck that are not as granwave wrote them; missing ones do
    not count.
    """
    noted = ownership.read_marker(directory).digests.items()
    return [
        name
        for name, digest in noted
        if (directory / name).is_file() and _digest(directory / name) != digest
    ]


def check_deck(directory: Path) -> None:
    """Warn if the deck was edited by hand before LAMMPS was run on it.

    Raises
    ------
    InputError
        The data file was changed after granwave ran the case.
    """
    by_hand = not (directory / run_directory.RECORD_FILE).exists()
    for name in changed_files(directory):
        path = directory / name
        is_data = name == run_directory.DATA_FILE
        if by_hand:
            taken = _TAKEN.format(
                "positions, diameters and densities are those of the file; " if is_data else ""
            )
            dumps = [
                one.stat().st_mtime
                for one in (directory / run_directory.DUMPS).glob("*")
                if one.is_file()
            ]
            newer = path.stat().st_mtime > max(dumps, default=math.inf)
            late = (
                "; it is newer than the output of LAMMPS, so the run may have been of another"
                * newer
            )
            logger.warning("%s: was changed after granwave wrote it%s. %s", path, late, taken)
        elif is_data:
            raise InputError(
                f"{path}: was changed after the run, and the positions of the spheres are read from it: put back what "
                f"was run, or run the case again with force=True. A deck to be edited is made by granwave write"
            )
        else:
            logger.warning("%s: was changed after the run; the results are of what was run", path)


def _digest(path: Path) -> str:
    with regular(path).open("rb") as stream:
        return hashlib.file_digest(stream, lambda: hashlib.blake2b(digest_size=16)).hexdigest()


def decide(
    directory: Path,
    kind: str,
    names: Iterable[str],
    *,
    resume: bool,
    force: bool,
    case: Mapping[str, Any],
    read: Callable[[Mapping[str, Any]], Mapping[str, Any]],
) -> bool:
    """Decide between resuming the results in a directory and a new start, without changing
    anything.

    Parameters
    ----------
    kind
        Kind of results, see `granwave.lammps_inputs.run_directory`.
    names
        Names of the files that will be written.
    case
        The case as tables, all defaults filled in.
    read
        Function that returns the same for the tables of the case that was run; called only to
        resume.

    Returns
    -------
    bool
        True: keep and continue the results. False: start anew, after `clear`.

    Raises
    ------
    InputError
        The directory holds results and neither ``resume`` nor ``force`` was given; it holds another
        case, or files that granwave did not write and would overwrite; it is unsuitable for
        results; or both options were given.
    """
    check_directory(directory, resume=resume, force=force)
    ownership.refuse_other_kind(directory, kind)
    if (
        resume
        and ownership.results_in(directory)
        and (there := tables_as_run(directory)) is not None
    ):
        check_case(directory)
        as_run = read(there)
        if different := sorted(
            name for name in {*as_run, *case} if as_run.get(name) != case.get(name)
        ):
            raise InputError(
                f"{directory}: holds another case (different: {', '.join(different)}); force=True replaces it, or choose "
                "another directory with directory=..."
            )
        return True
    if not force:
        ownership.refuse_results(directory)
    ownership.refuse_foreign(directory, names)
    return False


def check_directory(directory: Path, *, resume: bool, force: bool) -> None:
    """Raise InputError if a directory is unsuitable for results, or if both ``resume`` and
    ``force`` are given.
    """
    if resume and force:
        raise InputError(
            "resume=True and force=True exclude each other: one goes on with what is there, the other replaces it"
        )
    results_directory(directory, force=force)


def refuse_source(directory: Path, name: str, source: Path | None) -> None:
    """Raise InputError if the case ``name`` takes its dents from a file among the results that it
    would replace.
    """
    if source is None:
        return
    there = source.resolve()
    replaced = {(directory / result).resolve() for result in ownership.results_in(directory)}
    if not replaced.isdisjoint([there, *there.parents]):
        raise InputError(
            f"{name}: contact.initial_overlap: {source}: is among the results that would be replaced; "
            "choose another directory with directory=..."
        )


def output_path(name: str | Path) -> Path:
    """Return the path of a file or directory to be written.

    Raises
    ------
    InputError
        The name is empty, or begins with a "~" that the shell did not replace.
    """
    if not str(name):
        raise InputError(
            'found the empty name "", expected that of a file or directory (. is the present directory)'
        )
    path = Path(name)
    if path.parts and path.parts[0].startswith("~"):
        raise InputError(
            f"{path}: the shell did not replace {path.parts[0]}; write the whole path, or $HOME"
        )
    return path


def results_directory(name: str | Path, *, force: bool = False) -> Path:
    """Return the absolute path of a directory for results.

    Parameters
    ----------
    force
        True to replace existing results.

    Raises
    ------
    InputError
        As in `output_path`; or it is a file, the root or the home directory, or, with ``force``, a
        link to a directory that holds results.
    """
    path = output_path(name)
    try:
        there = path.resolve()
        is_file = there.exists() and not there.is_dir()
        with contextlib.suppress(FileNotFoundError):
            path.lstat()
    except (OSError, RuntimeError, ValueError) as error:  # too long, links in a circle, a NUL
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{path}: {reason}; choose another directory with directory=...") from None
    if is_file:
        raise InputError(
            f"{path}: is a file, expected a directory; choose another with directory=..."
        )
    places = {Path(there.anchor): "the root directory"}
    with contextlib.suppress(RuntimeError, OSError):  # a user without a home
        places[Path.home().resolve()] = "your home directory"
    if there in places:
        raise InputError(
            f"{path}: is {places[there]}; "
            "choose a directory for the results alone with directory=..."
        )
    if force and path.is_symlink() and ownership.results_in(path):
        raise InputError(
            f"{path}: is a link to {there}, and force=True removes nothing through a link; "
            "give that directory with directory=..."
        )
    return path.absolute()


def refuse_other_file(path: Path, own: bytes) -> None:
    """Raise InputError if a file to be written exists and granwave did not write it.

    Parameters
    ----------
    own
        Regular expression that matches every file of this kind that granwave writes.
    """
    if path.is_dir():
        raise InputError(
            f"{path}: is a directory, expected the name of a file; "
            "choose another with directory=..."
        )
    if not os.access(path.absolute().parent, os.W_OK | os.X_OK):
        raise InputError(
            f"{path}: the directory {path.absolute().parent} cannot be written to; "
            "choose another with directory=..."
        )
    if os.path.lexists(path) and not re.search(own, head(path)):
        raise InputError(
            f"{path}: is there, and granwave did not write it; "
            "choose another name with directory=..."
        )


def check_disk(
    directory: Path,
    needed: float,
    *,
    what: str = "the results",
    spare: float = 0.0,
    remedy: str = "fewer run.frames",
) -> None:
    """Raise InputError if the disk has too little free space.

    Parameters
    ----------
    needed
        Space that ``what`` needs, bytes; 0 is never refused.
    what
        Name of the files, for the message.
    spare
        Space that must stay free, bytes.
    remedy
        Alternative to another directory, for the message.
    """
    if needed and needed + spare > (free := free_space(directory)):
        message = disk_space_message(what, needed, spare, free)
        raise InputError(
            f"{directory}: {message}; choose another directory with directory=..., or {remedy}"
        )


def free_space(directory: Path) -> float:
    """Return the free space on the disk of a directory, bytes; the directory need not exist yet."""
    return shutil.disk_usage(
        next(path for path in (directory, *directory.parents) if path.exists())
    ).free


def disk_space_message(what: str, needed: float, spare: float, free: float) -> str:
    """Describe the disk space that is needed, must stay free and is free; all in bytes."""
    needed, spare, free = (size / 1e9 for size in (needed, spare, free))
    left = f" and {spare:.3g} GB must stay free" if spare else ""
    return f"{what} need about {needed:.3g} GB{left}, {free:.3g} GB are free there"
