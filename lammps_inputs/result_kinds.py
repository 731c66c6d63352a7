"""Kinds of results: the content of a directory of results, from its marker, or from its files
without a marker.

The kinds of the core are here; extensions add further kinds, see `Extension`. A marker may name a
kind of an extension that is not installed; such a directory is neither read nor overwritten.
"""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path

from granwave.lammps_inputs import run_directory
from granwave.lammps_inputs.extensions import WITHOUT, entries_left_out, joined, loaded


def _nowhere(_: Path) -> bool:
    """Return False: a kind that only the marker identifies."""
    return False


@dataclasses.dataclass(frozen=True)
class ResultKind:
    """A kind of results.

    Attributes
    ----------
    name
        Name in the marker.
    content
        Description of the content, such as ``a run``: results of different content need different
        directories. Empty for files that may lie in a directory with any results.
    files
        Names of files that are opened for reading where they are there.
    is_in
        Function that returns True for a directory with such results, used if the marker does not
        identify the content.
    no_run
        End of the message of a command that expects a run of spheres; usually from ``content``.
    remedy
        Advice for a changed result, with ``{}`` for the directory.
    loader
        Reference "MODULE:NAME" of the function that `granwave.load` opens the directory with;
        empty: as a run.
    rows
        Reference of the quantities that the terminal shows of a summary; empty: those of a run.
    body
        Noun for the body, in messages on its plastic zone.
    of_spheres
        True for a run of spheres, and for unidentified content.
    installed
        False for a kind that no extension here has.
    """

    name: str
    content: str = ""
    files: tuple[str, ...] = ()
    is_in: Callable[[Path], bool] = _nowhere
    no_run: str = ""
    remedy: str = "recreate it with  granwave analyse {}"
    loader: str = ""
    rows: str = ""
    body: str = "packing"
    of_spheres: bool = False
    installed: bool = True

    @property
    def why_no_run(self) -> str:
        """End of a message on a directory that should hold a run of spheres; empty if it may."""
        if self.of_spheres or not self.content:
            return ""
        return self.no_run or f"holds {self.content}, expected a run"


_OF_THE_CORE = (
    ResultKind(run_directory.RUN, "a run", run_directory.READ_FILES, of_spheres=True),
    ResultKind(run_directory.SCAN, "a scan", of_spheres=True),
    ResultKind(run_directory.SUITE, "a suite of scans", of_spheres=True),
    ResultKind(run_directory.OTHER, of_spheres=True),
)


@cache
def result_kinds() -> dict[str, ResultKind]:
    """Return all kinds by name, the kinds of the core first."""
    own = _by_name(_OF_THE_CORE)
    more = {name: _by_name(kinds) for name, kinds in loaded("result_kinds").items()}
    return joined("kind of results", own, more)


def _by_name(kinds: Iterable[ResultKind]) -> dict[str, ResultKind]:
    return {kind.name: kind for kind in kinds}


@cache
def read_files() -> tuple[str, ...]:
    """Return the names of all files that are opened for reading if they exist."""
    names: dict[str, None] = {}
    for kind in result_kinds().values():
        names |= dict.fromkeys(kind.files)
    return tuple(names)


@cache
def kind_named(name: str) -> ResultKind:
    """Return a kind by its name in a marker; a kind without an extension is not ``installed``."""
    if name in result_kinds():
        return result_kinds()[name]
    if not name:
        return result_kinds()[run_directory.OTHER]
    for extension, kind in entries_left_out("result_kinds"):
        if kind.name == name:
            return _of_left_out(extension, kind)
    content = f'results of the kind "{name}"'
    reason = f"contains {content}, but the extension that reads them is not installed"
    return ResultKind(name, content, no_run=reason, installed=False)


def _of_left_out(extension: str, kind: ResultKind) -> ResultKind:
    """Return a kind of an extension that is disabled, which is not read."""
    if not kind.content:
        return kind
    reason = (
        f"holds {kind.content} of the extension {extension}, which {WITHOUT} hides: remove it "
        f"from {WITHOUT}"
    )
    return ResultKind(kind.name, kind.content, no_run=reason, installed=False)


def kind_in(directory: Path, marked: str) -> ResultKind:
    """Return the kind of the results in a directory.

    Parameters
    ----------
    marked
        Kind in the marker; empty if there is none.
    """
    kind = kind_named(marked)
    if kind.content:
        return kind
    with contextlib.suppress(OSError):  # the directory cannot be looked into
        return next((one for one in result_kinds().values() if one.is_in(directory)), kind)
    return kind
