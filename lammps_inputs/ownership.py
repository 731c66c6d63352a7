"""The marker of a directory of results, and the rules that follow from it: what may be overwritten
and deleted.

The marker, ``.granwave`` (JSON), holds the kind of results, the case that was run, and all files
that granwave wrote there. A file that it does not list is never overwritten and never deleted, even
with ``--force``. A folder is removed only when it is empty, and links are not followed. Directories
of version 0.1.0 have no marker; `recognise` tells them by the content of their files.
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
import os
import re
import tomllib
from collections import defaultdict
from collections.abc import Collection, Iterable, Sequence
from pathlib import Path, PurePosixPath

from granwave import __version__
from granwave.lammps_inputs import run_directory
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import head, is_special, read_json, read_tables, replace_text
from granwave.lammps_inputs.run_directory import files_of

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
)  # of a scan
_SCRATCH = re.compile(
    r"\.(.+)\.\d+"
)  # scratch file left by a killed process, see `files.replacing`


@dataclasses.dataclass
class Marker:
    """Record of the files that granwave wrote into a directory.

    Attributes
    ----------
    kind
        Kind of the results, such as `run_directory.RUN`; empty if granwave wrote nothing there.
    version
        Version of granwave that last wrote there.
    case
        Text of case.toml at the start of the run; empty if there is none.
    files
        Sizes in bytes by name relative to the directory; None for files whose size was not noted. A
        name that ends in "/" is a directory of results with a marker of its own; one with "%"
        stands for the files of all ranks.
    digests
        Digests of the files of the deck as granwave wrote them, by name.
    sums
        CRC-32 of finished files by name, as their sizes in ``files``.
    format
        Format of the results; 0 of versions that gave none.
    """

    kind: str = ""
    version: str = __version__
    case: str = ""
    files: dict[str, int | None] = dataclasses.field(default_factory=dict)
    digests: dict[str, str] = dataclasses.field(default_factory=dict)
    sums: dict[str, int] = dataclasses.field(default_factory=dict)
    format: int = run_directory.FORMAT

    def write(self, directory: Path) -> None:
        """Replace the marker in ``directory`` atomically."""
        self.version = __version__
        self.format = run_directory.FORMAT
        self.digests = {name: digest for name, digest in self.digests.items() if name in self.files}
        self.sums = {
            name: one for name, one in self.sums.items() if self.files.get(name) is not None
        }
        replace_text(
            directory / run_directory.MARKER, json.dumps(dataclasses.asdict(self), indent=1) + "\n"
        )


def read_marker(directory: Path) -> Marker:
    """Read the marker of a directory; without one, recognise results of version 0.1.0.

    Raises
    ------
    InputError
        A later version wrote there, in a format that this one does not know; or a file of results
        is a pipe or a device.
    """
    refuse_special(directory)
    path = directory / run_directory.MARKER
    if not path.is_symlink() and (found := read_json(path)) is not None:
        kind = found.get("kind")
        case = found.get("case", "")
        listed = found.get("files")
        digests, sums = (
            noted if isinstance(noted := found.get(one), dict) else {}
            for one in ("digests", "sums")
        )
        if isinstance(kind, str) and isinstance(case, str) and isinstance(listed, dict):
            paths = {name: PurePosixPath(name) for name in listed}
            inside = {
                name: listed[name]
                for name, path in paths.items()
                if path.parts and not path.is_absolute() and ".." not in path.parts
            }
            version = str(found.get("version", ""))
            made = found.get("format", 0)
            if newer := run_directory.newer_format(made, version):
                raise InputError(f"{directory}: {newer}")
            refuse_special(directory, [name for name in inside if not name.endswith("/")])
            return Marker(kind, version, case, inside, digests, sums, made)
    return recognise(directory)


def refuse_special(directory: Path, names: Iterable[str] = run_directory.READ_FILES) -> None:
    """Raise InputError for files that are pipes or devices, which opening would wait for."""
    errors = [
        f"{directory / file}: is a pipe or a device, expected a file; remove it, or put back the file of the run"
        for name in names
        for file in files_of(directory, name)
        if is_special(directory / file)
    ]
    if errors:
        raise InputError(errors)


def claim(
    directory: Path, names: Iterable[str], *, kind: str | None = None, case: str | None = None
) -> None:
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
        A file of such a name exists and granwave did not write it, or the directory holds results
        of another kind; the marker is unchanged.
    """
    names = list(names)
    marker = read_marker(directory)
    if kind:
        refuse_other_kind(directory, kind)
    refuse_foreign(directory, names)
    marker.kind = kind or marker.kind or run_directory.OTHER
    marker.case = marker.case if case is None else case
    marker.files |= dict.fromkeys(names)
    marker.write(directory)


def refuse_foreign(directory: Path, names: Iterable[str]) -> None:
    """Raise InputError if a file to be written, of these names, exists and granwave did not write
    it.
    """
    if found := foreign(directory, names):
        it = "it" if len(found) == 1 else "them"
        raise InputError(
            f"{directory}: {_few(found)} would be overwritten, and granwave did not write {it}; move {it} away, or "
            "choose another directory with directory=..."
        )


def foreign(directory: Path, names: Iterable[str]) -> list[str]:
    """Return those of ``names``, or obstacles to them, that granwave did not write; folders may be
    shared.
    """
    own = {
        file for name in read_marker(directory).files for file in (name, *files_of(directory, name))
    }
    found = []
    for name in names:
        if obstacle := _obstacle(directory, name):
            found.append(obstacle)
        elif name not in own and not name.endswith("/"):
            there = [
                file for file in files_of(directory, name) if os.path.lexists(directory / file)
            ]
            found += [file for file in there if file not in own]
    return list(dict.fromkeys(found))


def _obstacle(directory: Path, name: str) -> str:
    """Return the first link, file instead of a folder or the reverse on the path to a file; empty
    if none.
    """
    parts = PurePosixPath(name).parts
    for n in range(1, len(parts) + 1):
        path = directory.joinpath(*parts[:n])
        shown = "/".join(parts[:n])
        if path.is_symlink():
            return f"{shown} (a link)"
        if not path.exists():
            return ""
        folder = n < len(parts) or name.endswith("/")
        if path.is_dir() != folder:
            return f"{shown} (a {'file' if folder else 'folder'})"
    return ""


def own_file(directory: Path, name: str) -> Path | None:
    """Return the path of a file or directory of the marker; None if missing or reached through a
    link.
    """
    path = directory / name
    return path if os.path.lexists(path) and not _obstacle(directory, name) else None


def figure_files(name: str) -> list[str]:
    """Return the file names that a figure may have: PNG, PDF, data, and further forms."""
    suffixes = (*run_directory.FIGURE_SUFFIXES, *run_directory.MORE_FIGURE_SUFFIXES)
    return [f"{run_directory.FIGURES_DIRECTORY}/{name}{suffix}" for suffix in suffixes]


def output_names(directory: Path) -> list[str]:
    """Return the names of the files that LAMMPS writes to dumps/ for the deck in a directory.

    Where each rank writes its own file they are those that there are; without any it is the name
    with "%".
    """
    names = [
        name for name in read_marker(directory).files if name.startswith(f"{run_directory.DUMPS}/")
    ]
    return list(
        dict.fromkeys(file for name in names for file in files_of(directory, name) or [name])
    )


def results_in(directory: Path) -> list[str]:
    """Return the names of the results in a directory, without the files that a scan keeps beside
    the run of a point.
    """
    names = [name for name in read_marker(directory).files if name not in run_directory.POINT_FILES]
    return [
        name
        for name in names
        if any(own_file(directory, file) is not None for file in files_of(directory, name))
    ]


def held(directory: Path) -> str:
    """Return what a directory holds by its marker, such as ``a run``; empty if nothing is known."""
    return GROUPS.get(read_marker(directory).kind, "")


def refuse_other_kind(directory: Path, kind: str) -> None:
    """Raise InputError if a directory holds results of another group than ``kind``, such as a scan
    instead of a run.
    """
    there = held(directory)
    here = GROUPS.get(kind)
    if there and here and there != here and results_in(directory):
        raise InputError(
            f"{directory}: holds {there}, expected {here} or nothing; "
            "choose another with directory=..."
        )


def refuse_results(
    directory: Path, ways: str = "resume=True goes on with them, force=True replaces them"
) -> None:
    """Raise InputError if a directory holds results; ``ways`` tells how to continue."""
    if found := results_in(directory):
        raise InputError(
            f"{directory}: already holds results ({_few(found)}); "
            f"{ways}, or choose another directory with directory=..."
        )


def _few(names: Sequence[str]) -> str:
    return ", ".join(names[:_SHOWN]) + (", ..." if len(names) > _SHOWN else "")


def clear(directory: Path, names: Collection[str] | None = None) -> None:
    """Remove what granwave wrote into a directory, and folders left empty.

    Parameters
    ----------
    names
        Names of the files to remove; None: all but those that a scan keeps beside the run of a
        point.
    """
    marker = read_marker(directory)
    if names is None:
        chosen = [name for name in marker.files if name not in run_directory.POINT_FILES]
        marker.case = ""
    else:
        chosen = [
            name
            for name in marker.files
            if not set(names).isdisjoint([name, *files_of(directory, name)])
        ]
    if not marker.kind or not (chosen or names is None):
        return
    removed = [file for name in chosen for file in files_of(directory, name)]
    if (
        names is None
        and marker.kind == run_directory.SCAN
        and own_file(directory, f"{run_directory.SCAN_WORK}/")
    ):
        work = directory / run_directory.SCAN_WORK
        removed += [
            str(path.relative_to(directory)) for one in _WORK_FILES for path in work.glob(one)
        ]
    names_in: defaultdict[PurePosixPath, set[str]] = defaultdict(set)  # by folder
    for file in map(PurePosixPath, removed):
        names_in[file.parent].add(file.name)
        above = (*file.parents, file) if (directory / file).is_dir() else file.parents
        names_in.update((folder, set()) for folder in above if folder not in names_in)
    for path in (own_file(directory, file) for file in removed):
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
    marker.files = {name: size for name, size in marker.files.items() if name not in chosen}
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


_VERSION = "0.1.0"
_SCANS = (
    run_directory.SCAN_FILE,
    run_directory.SCAN_INDEX,
    run_directory.SCAN_TABLE,
    run_directory.SCAN_DATA,
    run_directory.SCAN_MEANS,
    run_directory.SCAN_REPORT,
)
_SUITES = (run_directory.SCAN_FILE, run_directory.SUITE_INDEX, run_directory.SCAN_REPORT)
_DECK = re.compile(
    r"(case\.toml|in\.granwave|data\.granwave|log\.lammps|(dents|load|preload_[xyz])\.txt|checkpoint-\d+\.restart)"
    r"|dumps/((energy|walls|probes|prestage)\.txt|(spheres|history|forces|contacts|wall_\w+)\.dump|spheres(-\d+)?\.bin"
    r"|static\.lmp)"
)
_EXPORTS = re.compile(
    r"export/((spheres|contacts|wall_contacts|energy|probes|prestage|snapshots|points|(walls|snapshot|chain|bar)_\w+)\.csv"
    r"|result\.nc|(spheres|contacts)(\.pvd|_\d{4,}\.vtp)|open_in_ovito\.py)"
)
_OF_SCANS = re.compile(
    r"\w+_vs_\w+|collapse_\w+|\w+_map"
)  # figures of scans, without PDF until all points are done


def recognise(directory: Path) -> Marker:
    """Return the marker that version 0.1.0 would have written; one without a kind if granwave wrote
    nothing.

    Names prove nothing: other programs may write a ``case.toml`` or a ``figures``. Deck and output
    of LAMMPS are recognised by the header of ``in.granwave`` or the table ``[resolved]`` of
    ``case.toml``; ``run.json``, ``summary.json``, ``result.h5`` and the files of a scan by their
    keys, or, if damaged, by other files of granwave beside them; figures by a PDF of matplotlib
    without a date.
    """
    folders = (run_directory.DUMPS, run_directory.EXPORT_DIRECTORY, run_directory.FIGURES_DIRECTORY)
    paths = [path for folder in (directory, *(directory / one for one in folders if not (directory / one).is_symlink()))
             for path in sorted(folder.glob("*")) if path.is_file()]  # fmt: skip
    names = [path.relative_to(directory).as_posix() for path in paths]
    kind = run_directory.OTHER
    case = ""
    indexed = _has(directory / run_directory.SCAN_INDEX, "name", "case", "varied", "points")
    if indexed or (directory / run_directory.SCAN_WORK / "batches").is_dir():
        places = (directory / folder for folder in (run_directory.POINTS, run_directory.UNFINISHED))
        points = (
            path.parent for place in places for path in place.glob(f"*/{run_directory.POINT_FILE}")
        )
        kind = run_directory.SCAN
        found = [*_SCANS, *(f"{point.relative_to(directory)}/" for point in points)]
    elif _has(directory / run_directory.SUITE_INDEX, "name", "scans"):
        kind = run_directory.SUITE
        found = list(_SUITES)
    elif head(directory / run_directory.FIT_TOML, 99).startswith(
        b"# Elasto-plastic contact law fitted to "
    ):
        kind = run_directory.FIT
        found = list(run_directory.FIT_FILES)
    else:
        kind, case, found = _run(directory, names)
    if not found:
        return Marker()
    there = [
        name
        for name in found
        if (Path.is_dir if name.endswith("/") else Path.is_file)(directory / name)
    ]
    for name in (
        one
        for one in names
        if one.startswith(f"{run_directory.FIGURES_DIRECTORY}/") and one.endswith(".png")
    ):
        png, pdf, data = (
            name.removesuffix(".png") + suffix for suffix in run_directory.FIGURE_SUFFIXES
        )
        content = head(directory / pdf)
        drawn = b"/Producer (Matplotlib pdf backend" in content and b"/CreationDate" not in content
        if data in names and (drawn or (pdf not in names and _OF_SCANS.fullmatch(Path(name).stem))):
            there += [file for file in (png, pdf, data) if file in names]
    return Marker(kind, _VERSION, case, dict.fromkeys(there))


def _has(path: Path, *keys: str) -> bool:
    """Return True if a JSON file has some keys."""
    return set(keys) <= (read_json(path) or {}).keys()


def _run(directory: Path, names: list[str]) -> tuple[str, str, list[str]]:
    """Return the kind, the text of the case and the file names of a LAMMPS or finite-element run."""
    tables = read_tables(directory / run_directory.CASE_FILE) or {}
    summary = read_json(directory / run_directory.SUMMARY_FILE)
    script = head(directory / run_directory.SCRIPT_FILE, 4096)
    deck = b"\n# Written by granwave from case.toml.\n" in script or "struck" in tables.get(
        "resolved", {}
    )
    point = _has(directory / run_directory.POINT_FILE, "attempts")
    record = read_json(directory / run_directory.RECORD_FILE)
    case = case_of_result(directory / run_directory.RESULT_FILE)
    own = {
        run_directory.SUMMARY_FILE: "granwave" in ((summary or {}).get("versions") or {}),
        run_directory.RECORD_FILE: "n_steps" in (record or {}),
        run_directory.RESULT_FILE: bool(case),
    }
    if not deck and not point and not any(own.values()):
        return run_directory.RUN, "", []
    damaged = (summary is None, record is None, case is None)
    found = [
        name for (name, is_own), lost in zip(own.items(), damaged, strict=True) if is_own or lost
    ]
    found += [
        name for name in names if (deck and _DECK.fullmatch(name)) or _EXPORTS.fullmatch(name)
    ]
    found += [run_directory.CASE_FILE, *run_directory.POINT_FILES] if point else []
    if case and tables == tomllib.loads(case):
        found.append(run_directory.CASE_FILE)
    if head(directory / run_directory.CONTACT_TABLE, 99).startswith(b"branch,overlap_m,force_N,"):
        found.append(run_directory.CONTACT_TABLE)
    if not case and run_directory.CASE_FILE in found and tables:
        case = (directory / run_directory.CASE_FILE).read_text(encoding="utf-8")
    return (
        run_directory.RUN if deck or own[run_directory.RECORD_FILE] else run_directory.CONTINUUM,
        case or "",
        found,
    )


def case_of_result(path: Path) -> str | None:
    """Return the text of the case in a ``result.h5``; empty if it is missing or of others, None if
    it is damaged.
    """
    if not path.is_file():
        return ""
    import h5py  # takes longer to load than most commands need

    try:
        with h5py.File(path, "r") as file:
            case = str(file.attrs["case"]) if {"case", "versions"} <= file.attrs.keys() else ""
            return case if tomllib.loads(case) else ""
    except (OSError, ValueError):
        return None
