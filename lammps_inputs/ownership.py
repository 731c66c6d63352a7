"""Rules for overwriting and deleting files: only those in the marker of the directory."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Collection, Iterable, Sequence
from pathlib import Path, PurePosixPath

from granwave.lammps_inputs import run_directory
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_json
from granwave.lammps_inputs.run_directory import Marker, files_of, recognise

GROUPS = {
    run_directory.RUN: "a run",
    run_directory.CONTINUUM: "a run",
    run_directory.SCAN: "a scan",
    run_directory.SUITE: "a suite of scans",
    run_directory.SPECTRA: "bands or modes",
    run_directory.INFERENCE: "inferred forces",
    run_directory.DESIGN: "a search for a design",
}  # what a directory holds, one group each
_SHOWN = 3  # names in a message
_WORK_FILES = (
    "jobs-*.json",
    "stop",
    "batches",
    "batches/*.json",
    "done",
    "done/*",
    "logs",
    "logs/**/*",
)  # in run_directory.SCAN_WORK
_SCRATCH = re.compile(r"\.(.+)\.\d+")  # scratch file left by a killed process, see `files.replacing`


def read_marker(directory: Path) -> Marker | None:
    """Read the marker of a directory; without one, recognise results of version 0.1.0.

    Returns
    -------
    Marker or None
        None if granwave wrote nothing there.

    Raises
    ------
    InputError
        A later version wrote there, in a format that this one does not know.
    """
    path = directory / run_directory.MARKER
    if not path.is_symlink() and (found := read_json(path)) is not None:
        kind, case, files = found.get("kind"), found.get("case", ""), found.get("files")
        digests, sums = (noted if isinstance(noted := found.get(one), dict) else {} for one in ("digests", "sums"))
        if isinstance(kind, str) and isinstance(case, str) and isinstance(files, dict):
            inside = {name: size for name, size in files.items() if _is_inside(name)}
            version, made = str(found.get("version", "")), found.get("format", 0)
            if newer := run_directory.newer_format(made, version):
                raise InputError(f"{directory}: {newer}")
            return Marker(kind, version, case, inside, digests, sums, made)
    return recognise(directory)


def _is_inside(name: str) -> bool:
    """Return True if a relative name stays inside the directory."""
    path = PurePosixPath(name)
    return bool(path.parts) and not path.is_absolute() and ".." not in path.parts


def claim(directory: Path, names: Iterable[str], *, kind: str | None = None, case: str | None = None) -> None:
    """Enter files in the marker as granwave's own, before they are written.

    Parameters
    ----------
    names
        As in `Marker.files`.
    kind
        Kind of results; None: add files to the existing ones.
    case
        Text of case.toml at the start of a run.

    Raises
    ------
    InputError
        A file of such a name exists and granwave did not write it, or the directory holds results of another kind; the
        marker is unchanged.
    """
    names = list(names)
    marker = read_marker(directory) or Marker(kind or run_directory.OTHER)
    if kind:
        refuse_other_kind(directory, kind)
    refuse_foreign(directory, names, marker)
    marker.kind = kind or marker.kind
    marker.case = marker.case if case is None else case
    marker.files |= dict.fromkeys(names)
    marker.write(directory)


def refuse_foreign(directory: Path, names: Iterable[str], marker: Marker | None = None) -> None:
    """Raise InputError if a file to be written exists and granwave did not write it.

    Parameters
    ----------
    names
        Names of the files to be written.
    marker
        Marker of the directory, if already read.
    """
    if found := foreign(directory, names, marker):
        raise InputError(
            f"{directory}: {_few(found)} would be overwritten, and granwave did not write "
            f"{(it := 'it' if len(found) == 1 else 'them')}; move {it} away, or choose another directory with -o"
        )


def foreign(directory: Path, names: Iterable[str], marker: Marker | None = None) -> list[str]:
    """Return those of ``names``, or obstacles to them, that granwave did not write; folders may be shared."""
    marker = marker or read_marker(directory)
    own = {file for name in (marker.files if marker else ()) for file in (name, *files_of(directory, name))}
    found = []
    for name in names:
        if obstacle := _obstacle(directory, name):
            found.append(obstacle)
        elif name not in own and not name.endswith("/"):
            found += [
                file for file in files_of(directory, name) if file not in own and os.path.lexists(directory / file)
            ]
    return list(dict.fromkeys(found))


def _obstacle(directory: Path, name: str) -> str:
    """Return the first link, file instead of a folder or the reverse on the path to a file; empty if none."""
    parts = PurePosixPath(name).parts
    for n in range(1, len(parts) + 1):
        path, shown = directory.joinpath(*parts[:n]), "/".join(parts[:n])
        if path.is_symlink():
            return f"{shown} (a link)"
        if not path.exists():
            return ""
        folder = n < len(parts) or name.endswith("/")
        if path.is_dir() != folder:
            return f"{shown} (a {'file' if folder else 'folder'})"
    return ""


def own_file(directory: Path, name: str) -> Path | None:
    """Return the path of a file or directory of the marker; None if missing or reached through a link."""
    path = directory / name
    return path if os.path.lexists(path) and not _obstacle(directory, name) else None


def figure_files(name: str) -> list[str]:
    """Return the file names that a figure may have: PNG, PDF, data, and further forms."""
    return [
        f"{run_directory.FIGURES_DIRECTORY}/{name}{suffix}"
        for suffix in (*run_directory.FIGURE_SUFFIXES, *run_directory.MORE_FIGURE_SUFFIXES)
    ]


def output_names(directory: Path) -> list[str]:
    """Return the names of the files that LAMMPS writes to dumps/ for the deck in a directory.

    Where each rank writes its own file they are those that there are; without any it is the name with "%".
    """
    marker = read_marker(directory)
    names = [name for name in (marker.files if marker else ()) if name.startswith(f"{run_directory.DUMPS}/")]
    return list(dict.fromkeys(file for name in names for file in files_of(directory, name) or [name]))


def results_in(directory: Path) -> list[str]:
    """Return the names of the results in a directory, without the files that a scan keeps beside the run of a point."""
    marker = read_marker(directory)
    names = [name for name in (marker.files if marker else ()) if name not in run_directory.POINT_FILES]
    return [name for name in names if any(own_file(directory, file) is not None for file in files_of(directory, name))]


def held(directory: Path) -> str:
    """Return what a directory holds by its marker, such as ``a run``; empty if nothing is known."""
    marker = read_marker(directory)
    return GROUPS.get(marker.kind, "") if marker else ""


def refuse_other_kind(directory: Path, kind: str) -> None:
    """Raise InputError if a directory holds results of another group than ``kind``, such as a scan instead of a run."""
    there, here = held(directory), GROUPS.get(kind)
    if there and here and there != here and results_in(directory):
        raise InputError(f"{directory}: holds {there}, expected {here} or nothing; choose another with -o")


def refuse_results(directory: Path, ways: str = "--resume goes on with them, --force replaces them") -> None:
    """Raise InputError if a directory holds results; ``ways`` tells how to continue."""
    if found := results_in(directory):
        raise InputError(
            f"{directory}: already holds results ({_few(found)}); {ways}, or choose another directory with -o"
        )


def _few(names: Sequence[str]) -> str:
    return ", ".join(names[:_SHOWN]) + (", ..." if len(names) > _SHOWN else "")


def clear(directory: Path, names: Collection[str] | None = None) -> None:
    """Remove what granwave wrote into a directory, and folders left empty.

    Parameters
    ----------
    names
        Names of the files to remove; None: all but those that a scan keeps beside the run of a point.
    """
    marker = read_marker(directory)
    if marker is None:
        return
    if names is None:
        chosen = [name for name in marker.files if name not in run_directory.POINT_FILES]
        marker.case = ""
    else:
        chosen = [name for name in marker.files if not set(names).isdisjoint([name, *files_of(directory, name)])]
        if not chosen:
            return
    files = [file for name in chosen for file in files_of(directory, name)]
    if names is None and marker.kind == run_directory.SCAN and own_file(directory, f"{run_directory.SCAN_WORK}/"):
        work = directory / run_directory.SCAN_WORK
        files += [str(path.relative_to(directory)) for pattern in _WORK_FILES for path in work.glob(pattern)]
    names_in: dict[PurePosixPath, set[str]] = {}  # by folder
    for file in map(PurePosixPath, files):
        for folder in (*file.parents, *([file] if (directory / file).is_dir() else [])):
            names_in.setdefault(folder, set())
        names_in[file.parent].add(file.name)
    for path in (own_file(directory, file) for file in files):
        if path is not None and path.is_dir():
            clear(path)
            clear(path, run_directory.POINT_FILES)
        elif path is not None:
            path.unlink()
    for folder in sorted(names_in, key=lambda folder: -len(folder.parts)):
        if not _obstacle(directory, f"{folder}/") and (directory / folder).is_dir():
            clear_scratch(directory / folder, names_in[folder])
            if folder.name:
                with contextlib.suppress(OSError):
                    (directory / folder).rmdir()
    for name in chosen:
        del marker.files[name]
    if marker.files:
        marker.write(directory)
    elif not (directory / run_directory.MARKER).is_symlink():
        (directory / run_directory.MARKER).unlink(missing_ok=True)


def clear_scratch(folder: Path, names: Collection[str]) -> None:
    """Remove scratch files of some names that killed processes left."""
    for path in list(folder.iterdir()):
        left = _SCRATCH.fullmatch(path.name)
        if left and left[1] in names and path.is_file() and not path.is_symlink():
            path.unlink()
