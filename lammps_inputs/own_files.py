"""Files of granwave in a directory, which it may overwrite, remove and move; all other files are
left unchanged.

The marker of the directory (`granwave.lammps_inputs.marker`) lists them. A file that it does not
list is never overwritten, moved or deleted, even with ``--force``; without a marker no file belongs
to granwave. A folder is removed only when it is empty, and links are not followed.
"""

from __future__ import annotations

import contextlib
import os
import re
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from pathlib import Path, PurePosixPath
from typing import Self, TypeAlias

from granwave.lammps_inputs import run_directory
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import is_special
from granwave.lammps_inputs.marker import Marker, State, read_marker, state
from granwave.lammps_inputs.result_kinds import ResultKind, kind_in, kind_named, read_files
from granwave.lammps_inputs.run_directory import files_of

AnyPath: TypeAlias = str | os.PathLike[str]  # a path, or an open directory of results
_SHOWN = 3  # names in a message
_OF_A_SCAN = (
    "jobs-*.json",
    "stop",
    "batches",
    "batches/*.json",
    "done",
    "done/*",
    "logs",
    "logs/**/*",
)  # working files
_SCRATCH = re.compile(
    r"\.(.+)\.\d+"
)  # scratch file left by a killed process, see `files.replacing`


class OwnFiles(os.PathLike[str]):
    """Files of granwave in a directory, by its marker.

    The marker is read on first access, and again only after another process has replaced the file;
    it is written, atomically, with every change. Any number of processes may read, and a process
    may keep the object while others write; if two processes changed the marker at the same time,
    the entries of one would be lost, which the lock of `ResultDirectory` prevents. Only the first
    rank of a run reads and changes it.

    It serves as a path: ``open(directory / "run.json")``.

    Parameters
    ----------
    path
        Path of the directory, which need not exist.
    """

    def __init__(self, path: AnyPath) -> None:
        self.path = Path(path)
        self._marker: Marker | None = None
        self._state: State = None  # state of `_marker`

    @classmethod
    def at(cls, place: AnyPath) -> Self:
        """Return the directory at a path; an open directory is returned unchanged."""
        return place if isinstance(place, cls) else cls(place)

    def __fspath__(self) -> str:
        return str(self.path)

    def __str__(self) -> str:
        return str(self.path)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({str(self.path)!r})"

    def __truediv__(self, name: AnyPath) -> Path:
        return self.path / name

    def __reduce__(self) -> tuple[type[Self], tuple[Path]]:
        """Pickle the path: another process reads the marker itself."""
        return type(self), (self.path,)

    # ------------------------------------------------------------------ the marker

    @property
    def marker(self) -> Marker:
        """The marker on the disk; a marker without a kind if there is none.

        Raises
        ------
        InputError
            A later version wrote there, in a format unknown to this version; or a file of
            results is a pipe or a device.
        """
        path = self.path / run_directory.MARKER
        now = state(path)
        if self._marker is None or now != self._state:
            self.refuse_special()
            marker = read_marker(path) if now else Marker()
            self.refuse_special(name for name in marker.files if not name.endswith("/"))
            self._marker = marker
            self._state = now
        return self._marker

    def write(self, marker: Marker) -> None:
        """Replace the marker."""
        self._state = marker.write(self.path / run_directory.MARKER)
        self._marker = marker

    def _remove_marker(self) -> None:
        path = self.path / run_directory.MARKER
        if not path.is_symlink():
            path.unlink(missing_ok=True)
        self._marker = None

    def refuse_special(self, names: Iterable[str] | None = None) -> None:
        """Raise InputError for pipes and devices in place of files, since opening them could block.

        Parameters
        ----------
        names
            Names of the files; None: all that are opened for reading where they are there.
        """
        if names is None:
            names = read_files()
        errors = [
            f"{self.path / file}: is a pipe or a device, expected a file; remove it, or put back "
            "the file of the run"
            for file in self._files(names)
            if is_special(self.path / file)
        ]
        if errors:
            raise InputError(errors)

    # ------------------------------------------------------------------ own files and other files

    def claim(
        self, names: Iterable[str], *, kind: str | None = None, case: str | None = None
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
            A file of such a name exists and granwave did not write it, or the directory holds
            results of another kind; the marker is unchanged.
        """
        names = list(names)
        if kind:
            self.refuse_other_kind(kind)
        self.refuse_foreign(names)
        marker = self.marker
        marker.kind = kind or marker.kind or run_directory.OTHER
        if case is not None:
            marker.case = case
        marker.files |= dict.fromkeys(names)
        self.write(marker)

    def refuse_foreign(self, names: Iterable[str]) -> None:
        """Raise InputError if a file to be written, of these names, exists and granwave did not
        write it.
        """
        if foreign := self.foreign(names):
            it = "it" if len(foreign) == 1 else "them"
            reason = f"granwave did not write {it}"
            if not self.marker.kind and os.path.lexists(self / run_directory.MARKER):
                reason = f"{run_directory.MARKER}, the list of what granwave wrote, is damaged"
            raise InputError(
                f"{self.path}: {_few(foreign)} would be overwritten, and {reason}; move {it} "
                "elsewhere, or choose another directory with directory=..."
            )

    def foreign(self, names: Iterable[str]) -> list[str]:
        """Return the files among ``names``, or obstacles to them, that granwave did not write;
        folders may be shared.
        """
        own = self._own_names()
        foreign: list[str] = []
        for name in names:
            if obstacle := self._obstacle(name):
                foreign.append(obstacle)
            elif name not in own and not name.endswith("/"):
                files = files_of(self.path, name)
                there = [file for file in files if os.path.lexists(self.path / file)]
                foreign += [file for file in there if file not in own]
        return list(dict.fromkeys(foreign))

    def _files(self, names: Iterable[str]) -> list[str]:
        """Return the files for names of a marker."""
        files: list[str] = []
        for name in names:
            files += files_of(self.path, name)
        return files

    def _own_names(self) -> set[str]:
        """Return all names of the marker, and their files."""
        names = self.marker.files
        return {*names, *self._files(names)}

    def _obstacle(self, name: str) -> str:
        """Return the first link, file instead of a folder or the reverse on the path to a file;
        empty if none.
        """
        parts = PurePosixPath(name).parts
        for n in range(1, len(parts) + 1):
            path = self.path.joinpath(*parts[:n])
            shown = "/".join(parts[:n])
            if path.is_symlink():
                return f"{shown} (a link)"
            if not path.exists():
                return ""
            folder = n < len(parts) or name.endswith("/")
            if path.is_dir() != folder:
                return f"{shown} (a {'file' if folder else 'folder'})"
        return ""

    def own_path(self, name: str) -> Path | None:
        """Return the path of a file or directory of the marker; None if missing or reached through
        a link.
        """
        path = self.path / name
        return path if os.path.lexists(path) and not self._obstacle(name) else None

    def output_names(self) -> list[str]:
        """Return the names of the files that LAMMPS writes to dumps/.

        If each rank writes its own file, the existing files; without any, the name with
        "%".
        """
        prefix = f"{run_directory.DUMPS}/"
        names = [name for name in self.marker.files if name.startswith(prefix)]
        files: list[str] = []
        for name in names:
            files += files_of(self.path, name) or [name]
        return list(dict.fromkeys(files))

    def result_names(self) -> list[str]:
        """Return the names of the existing results, without the files that a scan keeps next to the
        run of a point.
        """
        names = [name for name in self.marker.files if name not in run_directory.POINT_FILES]
        return [name for name in names if self._is_there(name)]

    def _is_there(self, name: str) -> bool:
        return any(self.own_path(file) is not None for file in files_of(self.path, name))

    @property
    def kind(self) -> ResultKind:
        """Kind of the results, according to the marker, or otherwise to the files in the
        directory.
        """
        return kind_in(self.path, self.marker.kind)

    def refuse_other_kind(self, kind: str) -> None:
        """Raise InputError if the directory holds results of another group than ``kind``, such as a
        scan instead of a run.
        """
        there = kind_named(self.marker.kind).content
        here = kind_named(kind).content
        if there and here and there != here and self.result_names():
            raise InputError(
                f"{self.path}: holds {there}, expected {here} or nothing; "
                "choose another with directory=..."
            )

    def refuse_results(self, resume: str = "resume=True continues with them, ") -> None:
        """Raise InputError if the directory holds results; ``resume`` describes the effect of
        --resume on them.
        """
        if names := self.result_names():
            raise InputError(
                f"{self.path}: already holds results ({_few(names)}); {resume}{self.by_force}"
            )

    @property
    def by_force(self) -> str:
        """Advice for existing results: the effect of --force."""
        old = self.free_old_path().name
        return (
            f"force=True moves the results to {old} first, "
            "or choose another directory with directory=..."
        )

    # ------------------------------------------------------------------ removing, setting aside

    def clear(self, names: Collection[str] | None = None) -> None:
        """Remove the files of granwave, and empty folders.

        Parameters
        ----------
        names
            Names of the files to remove; None: all but those that a scan keeps next to the run of a
            point.
        """

        def remove(path: Path) -> None:
            if path.is_dir():
                point = type(self)(path)
                point.clear()
                point.clear(run_directory.POINT_FILES)
            else:
                path.unlink()

        self._take_out(names, remove)

    def set_aside(self, names: Collection[str] | None = None, into: Path | None = None) -> str:
        """Move the files of granwave into another directory of results, and remove empty
        folders. Files that granwave did not write stay.

        Parameters
        ----------
        names
            Names of the files; None: all but those that a scan keeps next to the run of a point.
        into
            Directory to be made; None: the first of NAME.old, NAME.old2, ... that does not exist.

        Returns
        -------
        str
            Path of the directory; empty if there was nothing to move.

        Raises
        ------
        InputError
            The directory cannot be made, or is on another disk.
        """
        wanted = self.result_names()
        if names is not None:
            wanted = [name for name in wanted if name in names]
        if not wanted:
            self.clear(names)
            return ""
        if into is None:
            self.refuse_immovable()
        old = type(self)(into or self.free_old_path())
        old.path.mkdir(parents=True)
        try:
            self._move(old, names)
        except OSError:
            with contextlib.suppress(OSError):  # the marker is empty if the disk is full
                old.path.rmdir()
            raise
        return str(old)

    def put_back(self, old: str) -> None:
        """Move all files back that `set_aside` moved into the directory ``old``; empty: none."""
        if not old:
            return
        files = sorted(path for path in Path(old).rglob("*") if not path.is_dir())
        for path in files:
            target = self.path / path.relative_to(old)
            target.parent.mkdir(parents=True, exist_ok=True)
            path.replace(target)
        folders = sorted(path for path in Path(old).rglob("*") if path.is_dir())
        for path in [*reversed(folders), Path(old)]:
            path.rmdir()

    def _move(self, old: Self, names: Collection[str] | None) -> None:
        """Move files into a directory that has been made, which gets a marker first: if the move is
        interrupted, the marker of each directory lists its files.
        """
        kept = self.marker.copy()
        kept.files = {name: kept.files[name] for name in self._chosen(names)}
        old.write(kept)

        def move(path: Path) -> None:
            target = old.path / path.relative_to(self.path)
            target.parent.mkdir(parents=True, exist_ok=True)
            if not path.is_dir() or type(self)(path).has_own_files_only():
                path.rename(target)
            elif path.is_dir():
                target.mkdir(exist_ok=True)
                point = type(self)(path)
                point._move(type(self)(target), (*point.marker.files,))

        self._take_out(names, move)

    def has_own_files_only(self) -> bool:
        """Return True if granwave wrote all files of the directory, folders included."""
        own = self._own_names() | {run_directory.MARKER, run_directory.LOCK_FILE}
        for folder, folders, files in os.walk(self.path):
            here = Path(folder).relative_to(self.path)
            if any((here / name).as_posix() not in own for name in files):
                return False
            if any(os.path.islink(os.path.join(folder, name)) for name in folders):
                return False
        return True

    def old_path(self) -> Path:
        """Return the path NAME.old next to the directory."""
        place = self.path
        if place.name in ("", ".."):
            place = place.resolve()
        return place.with_name(f"{place.name}.old")

    def free_old_path(self) -> Path:
        """Return the first of the paths NAME.old, NAME.old2, ... that does not exist."""
        first = self.old_path()
        path = first
        number = 1
        while os.path.lexists(path):
            number = number + 1
            path = first.with_name(f"{first.name}{number}")
        return path

    def refuse_immovable(self) -> None:
        """Raise InputError if existing results cannot be moved into NAME.old."""
        place = self.path.resolve()
        if not place.exists():
            return
        if self.path.is_symlink():
            raise InputError(
                f"{self.path}: is a link to {place}, and force=True does not move results through "
                "a link; give the target directory with directory=..."
            )
        old = self.free_old_path()
        fault = ""
        if place.is_mount() or place.stat().st_dev != place.parent.stat().st_dev:
            fault = "it would be on another disk"
        elif not os.access(place.parent, os.W_OK | os.X_OK):
            fault = f"{place.parent} cannot be written to"
        if fault:
            raise InputError(
                f"{self.path}: force=True cannot move the results to {old}: {fault}; move them "
                "elsewhere, or choose another directory with directory=..."
            )

    def clear_scratch(self, names: Collection[str]) -> None:
        """Remove scratch files of these names that killed processes left."""
        _clear_scratch(self.path, names)

    def _chosen(self, names: Collection[str] | None) -> list[str]:
        """Return the names of the marker that match ``names``, see `clear`."""
        if names is None:
            return [name for name in self.marker.files if name not in run_directory.POINT_FILES]
        wanted = set(names)
        return [
            name
            for name in self.marker.files
            if not wanted.isdisjoint([name, *files_of(self.path, name)])
        ]

    def _take_out(self, names: Collection[str] | None, take: Callable[[Path], None]) -> None:
        """Take files out of the directory and the marker, and remove folders left empty.

        Parameters
        ----------
        names
            As of `clear`.
        take
            Function that removes a file or a directory of results, or moves it.
        """
        marker = self.marker
        chosen = self._chosen(names)
        if not marker.kind or not (chosen or names is None):
            return
        files = self._files(chosen)
        if names is None and marker.kind == run_directory.SCAN:
            files += self._working_files()
        names_in = self._names_by_folder(files)
        for file in files:
            path = self.own_path(file)
            if path is not None:
                take(path)
        self._remove_empty(names_in)
        if names is None:
            marker.case = ""
        marker.files = {name: size for name, size in marker.files.items() if name not in chosen}
        if marker.files:
            self.write(marker)
        else:
            self._remove_marker()

    def _working_files(self) -> Iterator[str]:
        """Return the names of the files and folders that a scan works with."""
        work = self.own_path(f"{run_directory.SCAN_WORK}/")
        if work is None:
            return
        for pattern in _OF_A_SCAN:
            for path in work.glob(pattern):
                yield path.relative_to(self.path).as_posix()

    def _names_by_folder(self, files: Iterable[str]) -> dict[PurePosixPath, set[str]]:
        """Return the names of files by folder, including folders without files."""
        names_in: defaultdict[PurePosixPath, set[str]] = defaultdict(set)
        for file in map(PurePosixPath, files):
            names_in[file.parent].add(file.name)
            folders = [*file.parents]
            if (self.path / file).is_dir():
                folders.append(file)
            for folder in folders:
                names_in[folder].update()
        return names_in

    def _remove_empty(self, names_in: dict[PurePosixPath, set[str]]) -> None:
        """Remove folders that are empty except for scratch files of these names; the innermost
        folders first.
        """
        for folder in sorted(names_in, key=lambda folder: -len(folder.parts)):
            path = self.path / folder
            if self._obstacle(f"{folder}/") or not path.is_dir():
                continue
            _clear_scratch(path, names_in[folder])
            if folder.name:
                with contextlib.suppress(OSError):
                    path.rmdir()


def _clear_scratch(folder: Path, names: Collection[str]) -> None:
    for path in list(folder.iterdir()):
        left = _SCRATCH.fullmatch(path.name)
        if left and left[1] in names and path.is_file() and not path.is_symlink():
            path.unlink()


def _few(names: Sequence[str]) -> str:
    return ", ".join(names[:_SHOWN]) + (", ..." if len(names) > _SHOWN else "")


def figure_files(name: str) -> list[str]:
    """Return the file names that a figure may have: PNG, PDF, data, and further forms."""
    suffixes = (*run_directory.FIGURE_SUFFIXES, *run_directory.MORE_FIGURE_SUFFIXES)
    return [f"{run_directory.FIGURES_DIRECTORY}/{name}{suffix}" for suffix in suffixes]
