"""A directory of results: permission to write results, the case of the run, and changes since the
run.

A directory that holds results is rejected by default. ``--resume`` continues them if they are of
the same case, ``--force`` moves them into a directory NAME.old next to it. Files that granwave did
not write stay where they are, see `granwave.lammps_inputs.own_files`. Changes are edits of
case.toml or the LAMMPS input, and output that was truncated, damaged or replaced.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import json
import logging
import math
import os
import tomllib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from granwave.lammps_inputs import run_directory
from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import (
    checksum,
    read_json,
    read_tables,
    regular,
    replace_text,
)
from granwave.lammps_inputs.own_files import AnyPath, OwnFiles
from granwave.lammps_inputs.processes import ALONE, Processes
from granwave.lammps_inputs.rounding import without_rounding

logger = logging.getLogger(__name__)
_TAKEN = (
    "Times, energies, forces and snapshots are the output of LAMMPS; {}material, law, load, "
    "walls, timestep and lattice are read from case.toml, and therefore also the contacts counted "
    "as yielded, the size of the plastic zone, and normalised values; if the change affects one "
    "of these, they are invalid"
)
_REMARKS = {"packing": "source"}  # keys of a case that change no result, by table
_DIGEST_LENGTH = 16
_SHOWN = 3  # keys in a message
_LONGEST = 40  # characters of a value in a message
_HELD: set[Path] = set()  # directories that this process has locked
_OF_AN_ANALYSIS = (run_directory.RESULT_FILE, run_directory.SUMMARY_FILE)


class ResultDirectory(OwnFiles):
    """Directory of a run, a scan or other results, opened once by a command and passed on.

    This object provides all information on the directory: its own files and other files, the case
    that was run, later changes, and the lock. Its names of files are in
    `granwave.lammps_inputs.run_directory`.

    Writers hold the lock (`lock`): a run, a scan, an analysis, a fit. All ranks of a run count as
    one writer; the first rank opens the marker. The points of a scan have separate directories and
    locks, in the processes of its workers. Readers need no lock.
    """

    def __init__(self, path: AnyPath) -> None:
        super().__init__(path)
        self._lock: int | None = None  # descriptor
        self._made: list[Path] = []  # folders that were made for the lock

    # ------------------------------------------------------------------ the lock

    def lock(self, way: str = "; choose another with directory=...") -> None:
        """Lock the directory against other runs; create it if necessary.

        Parameters
        ----------
        way
            Advice in the message if the directory cannot be written to.

        Raises
        ------
        InputError
            Another run uses the directory, or it cannot be written to.
        """
        made = [path for path in (self.path, *self.path.parents) if not path.exists()]
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            self._lock = _locked(self.path / run_directory.LOCK_FILE)
        except BlockingIOError:
            raise InputError(
                f"{self.path}: in use by another run or scan; wait for it, or choose another with "
                "directory=..."
            ) from None
        except OSError as error:
            raise InputError(f"{self.path}: cannot be written to: {error.strerror}{way}") from None
        self._made = made
        _HELD.add(self.path.resolve())

    def unlock(self) -> None:
        """Release the lock; remove the directory if it was made for the lock and is empty."""
        if self._lock is None:
            return
        (self.path / run_directory.LOCK_FILE).unlink(missing_ok=True)
        os.close(self._lock)
        self._lock = None
        _HELD.discard(self.path.resolve())
        with contextlib.suppress(OSError):
            for path in self._made:
                path.rmdir()  # succeeds only if the folder is still empty

    def busy(self) -> bool:
        """Return True if another process has locked the directory."""
        if self.path.resolve() in _HELD:
            return False
        try:
            with (self.path / run_directory.LOCK_FILE).open("r") as lock:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
        except OSError:
            pass
        return False

    # ------------------------------------------------------------------ start or resume

    def decide(
        self,
        kind: str,
        names: Iterable[str],
        *,
        resume: bool,
        force: bool,
        case: Mapping[str, Any],
        read: Callable[[Mapping[str, Any]], Mapping[str, Any]],
    ) -> bool:
        """Decide between resuming the results in the directory and a new start, without changing
        anything.

        Parameters
        ----------
        kind
            Kind of results, see `granwave.lammps_inputs.result_kinds`.
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
            True: keep and continue the results. False: start again, after `clear_for`.

        Raises
        ------
        InputError
            The directory holds results and neither ``resume`` nor ``force`` was given; it holds
            another case, or files that granwave did not write and would overwrite; it is unsuitable
            for results; or both options were given.
        """
        self.check(resume=resume, force=force)
        self.refuse_other_kind(kind)
        if resume and self.result_names() and (as_run := self.tables_as_run()) is not None:
            self.check_case()
            there = without_remarks(read(as_run))
            wanted = without_remarks(case)
            keys = {*there, *wanted}
            different = sorted(key for key in keys if there.get(key) != wanted.get(key))
            if different:
                raise InputError(
                    f"{self.path}: holds another case (different: {', '.join(different)}); "
                    f"{self.by_force}"
                )
            return True
        if not force:
            self.refuse_results()
        self.refuse_foreign(names)
        return False

    def check(self, *, resume: bool = False, force: bool) -> None:
        """Raise InputError if the directory is unsuitable for results, if ``force`` cannot move its
        results, or if both ``resume`` and ``force`` are given.
        """
        if resume and force:
            raise InputError(
                "resume=True and force=True exclude each other: the first continues, the second "
                "restarts from the beginning"
            )
        results_directory(self.path)
        if force and self.result_names():
            self.refuse_immovable()

    def refuse_source(self, name: str, source: Path | None) -> None:
        """Raise InputError if the case ``name`` takes its dents from a file among the results that
        it would replace.
        """
        if source is None:
            return
        there = source.resolve()
        replaced = {(self.path / result).resolve() for result in self.result_names()}
        if not replaced.isdisjoint([there, *there.parents]):
            raise InputError(
                f"{name}: contact.initial_overlap: {source}: is one of the results that would be "
                "replaced; choose another directory with directory=..."
            )

    def make_room(self, *, force: bool, names: Collection[str] | None = None) -> str:
        """Take results out of the directory: with ``force`` they are moved into NAME.old, otherwise
        removed. ``names`` as of `clear`.

        Returns
        -------
        str
            Path of the directory that they were moved into; empty if there is none.
        """
        if not force:
            self.clear(names)
            return ""
        old = self.set_aside(names)
        if old:
            logger.info("%s: the previous results are now in %s", self.path, old)
        return old

    # ------------------------------------------------------------------ the case that was run

    def tables_as_run(self) -> dict[str, Any] | None:
        """Return the tables of case.toml at the start of the run; None if the marker does not hold
        them.
        """
        try:
            return tomllib.loads(self.marker.case) or None
        except ValueError:  # a marker that was edited by hand
            return None

    def check_case(self) -> None:
        """Raise InputError if case.toml was changed after the run, except for the
        table of figures.
        """
        path = self.path / run_directory.CASE_FILE
        there = read_tables(path)
        as_run = self.tables_as_run()
        if there is None or as_run is None:
            return
        drawn = {run_directory.FIGURES_TABLE: None}
        changes = [
            f"{name} is {_shown(now)}, was {_shown(then)}"
            for name, then, now in changed_values(as_run | drawn, there | drawn)
        ]
        if not changes:
            return
        shown = "; ".join(changes[:_SHOWN]) + ("; ..." if len(changes) > _SHOWN else "")
        raise InputError(
            f"{path}: was changed after the run: {shown}. The results belong to the case that was "
            "run. Run the edited case with -o OTHER, or delete case.toml and restore it with  "
            f"granwave analyse {self.path}"
        )

    def restore_case(self) -> bool:
        """Restore a case.toml that is missing or damaged; return True if it was.

        Raises
        ------
        InputError
            The file was changed after the run.
        """
        self.check_case()
        path = self.path / run_directory.CASE_FILE
        if not self.tables_as_run() or read_tables(path) is not None:
            return False
        self.claim([run_directory.CASE_FILE])
        replace_text(path, self.marker.case)
        return True

    # ------------------------------------------------------------------ finished files

    def summary(self) -> dict[str, Any]:
        """Read the values of summary.json, without rounding; empty if missing or damaged."""
        return without_rounding(read_json(self.path / run_directory.SUMMARY_FILE) or {})

    def note_files(self, names: Iterable[str]) -> None:
        """Store sizes and checksums of finished files in the marker, so that `changed_file` detects
        later changes.
        """
        marker = self.marker
        if not marker.kind:
            return
        for name in names:
            path = self.own_path(name)
            marker.files[name] = None if path is None else path.stat().st_size
            if path is not None:
                marker.sums[name] = checksum(path)
        self.write(marker)

    def changed_file(self, names: Iterable[str] | None = None, processes: Processes = ALONE) -> str:
        """Describe the first file that differs from the file of the run; empty if none. Missing
        files are ignored.

        Parameters
        ----------
        names
            Names of the files to look at; None: all that were noted.
        processes
            Processes that read them.
        """
        if not (self.path / run_directory.MARKER).is_file():
            return ""
        marker = self.marker
        noted = {name: size for name, size in marker.files.items() if size is not None}
        wanted = noted if names is None else names
        there = [name for name in wanted if name in noted and (self.path / name).is_file()]
        for name in there:
            path = self.path / name
            size = path.stat().st_size
            if size != noted[name]:
                return (
                    f"{path}: differs from the file that the run wrote: it has {size} bytes, "
                    f"had {noted[name]}"
                )
        summed = [name for name in there if name in marker.sums]
        sums = processes.map(checksum, [self.path / name for name in summed])
        for name, found in zip(summed, sums, strict=True):
            if found != marker.sums[name]:
                return (
                    f"{self.path / name}: differs from the file that the run wrote: its checksum "
                    "differs; it is damaged, or belongs to another run"
                )
        return ""

    def changed_result(self, names: Iterable[str] = _OF_AN_ANALYSIS) -> str:
        """Describe the first result that was changed after the analysis, and the remedy; empty if
        none.
        """
        fault = self.changed_file(names)
        if not fault:
            return ""
        return f"{fault}: {self.kind.remedy.format(self.path)}"

    def fault(self) -> str:
        """Describe the first fault in the results of a finished run; empty if none.

        summary.json must exist. Other files may have been removed, to save disk space for instance.
        """
        summary = self.path / run_directory.SUMMARY_FILE
        result = self.path / run_directory.RESULT_FILE
        record = self.path / run_directory.RECORD_FILE
        if not self.summary():
            return f"{summary}: {'is damaged' if summary.exists() else 'is missing'}"
        if record.exists() and read_json(record) is None:
            return f"{record}: is damaged"
        if result.exists() and not _has_case(result):
            return f"{result}: is damaged"
        return self.changed_file()

    def outputs_complete(self) -> bool:
        """Return True if all output of LAMMPS exists, unchanged since the end of the run."""
        names = [run_directory.DATA_FILE, *self.output_names()]
        there = all((self.path / name).is_file() for name in names)
        return len(names) > 1 and there and not self.changed_file(names)

    # ------------------------------------------------------------------ the deck

    def note_deck(self, names: Iterable[str]) -> None:
        """Store the digests of the files of a deck in the marker, so that `changed_deck` detects
        edits.
        """
        marker = self.marker
        marker.digests |= {name: _digest(self.path / name) for name in names}
        self.write(marker)

    def changed_deck(self) -> list[str]:
        """Return the names of the changed files of an input script; missing files do not
        count.
        """
        return [
            name
            for name, digest in self.marker.digests.items()
            if (self.path / name).is_file() and _digest(self.path / name) != digest
        ]

    def check_deck(self) -> None:
        """Warn if the LAMMPS input was edited by hand before LAMMPS was run.

        Raises
        ------
        InputError
            The data file was changed after granwave ran the case.
        """
        by_hand = not (self.path / run_directory.RECORD_FILE).exists()
        for name in self.changed_deck():
            if by_hand:
                self._warn_of_edit(name)
            elif name == run_directory.DATA_FILE:
                raise InputError(
                    f"{self.path / name}: was changed after the run, and the positions of the "
                    "spheres are read from it: restore the original, or run the case again with "
                    "force=True. To edit an input script, use granwave write"
                )
            else:
                logger.warning(
                    "%s: was changed after the run; the results belong to the original file",
                    self.path / name,
                )

    def _warn_of_edit(self, name: str) -> None:
        """Warn of a file of the deck that was edited before LAMMPS was run by hand."""
        path = self.path / name
        of_file = ""
        if name == run_directory.DATA_FILE:
            of_file = "positions, diameters and densities are read from the file; "
        dumps = (self.path / run_directory.DUMPS).glob("*")
        times = [dump.stat().st_mtime for dump in dumps if dump.is_file()]
        late = ""
        if path.stat().st_mtime > max(times, default=math.inf):
            late = (
                "; it is newer than the output of LAMMPS, so the run may have used another version"
            )
        taken = _TAKEN.format(of_file)
        logger.warning("%s: was changed after granwave wrote it%s. %s", path, late, taken)


def case_digest(tables: Mapping[str, Any]) -> str:
    """Return a digest of the tables of a case that determine its results."""
    # name, derived values, and selection of figures
    other = ("name", "resolved", run_directory.FIGURES_TABLE)
    deciding = {name: table for name, table in tables.items() if name not in other}
    digest = hashlib.sha256(json.dumps(deciding, sort_keys=True).encode()).hexdigest()
    return digest[:_DIGEST_LENGTH]


def changed_values(
    before: Mapping[str, Any], now: Mapping[str, Any], prefix: str = ""
) -> Iterator[tuple[str, Any, Any]]:
    """Yield the dotted key, earlier and present value of each difference of two nested tables; None
    for a value that is omitted.
    """
    for key in dict.fromkeys((*before, *now)):
        old = before.get(key)
        new = now.get(key)
        name = f"{prefix}{key}"
        if isinstance(old, Mapping) and isinstance(new, Mapping):
            yield from changed_values(old, new, f"{name}.")
        elif old != new:
            yield name, old, new


def _shown(value: Any) -> str:
    """Return the value of a key for a message, at most `_LONGEST` characters."""
    text = "left out" if value is None else json.dumps(value, default=str)
    return text if len(text) <= _LONGEST else text[: _LONGEST - 3] + "..."


def _digest(path: Path) -> str:
    with regular(path).open("rb") as stream:
        return hashlib.file_digest(stream, lambda: hashlib.blake2b(digest_size=16)).hexdigest()


def _has_case(path: Path) -> bool:
    """Return True if a ``result.h5`` can be opened and holds the case of granwave."""
    import h5py  # imported on demand: slow to load

    try:
        with h5py.File(path, "r") as file:
            if not {"case", "versions"} <= file.attrs.keys():
                return False
            return bool(tomllib.loads(str(file.attrs["case"])))
    except (OSError, ValueError):
        return False


def _locked(path: Path) -> int:
    """Open and lock a file; try again if its previous holder removed it meanwhile."""
    while True:
        lock = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            with contextlib.suppress(FileNotFoundError):
                if os.path.samestat(os.fstat(lock), os.lstat(path)):
                    return lock
        except OSError:
            os.close(lock)
            raise
        os.close(lock)


def without_remarks(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables of a case without keys that change no result."""
    return {name: _without(_REMARKS.get(name), table) for name, table in tables.items()}


def _without(key: str | None, table: Any) -> Any:
    """Return a table without a key."""
    if key is None or not isinstance(table, Mapping):
        return table
    return {name: value for name, value in table.items() if name != key}
