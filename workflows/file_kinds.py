"""Kinds of files that users write: cases, scans, profiles of clusters, and files of extensions."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.extensions import owner_left_out, with_added
from granwave.workflows.solvers import GRANULAR, has_tables_of_a_case

SCAN = "scan"  # command that runs scans
_OF_SCAN = ("case", "scans", "grid", "zip", "points")


@dataclasses.dataclass(frozen=True)
class FileKind:
    """One kind of files that a user writes.

    Attributes
    ----------
    name
        Name for ``granwave keys --schema``, one word.
    title
        Heading of its tables, with the command that reads it: "Scan files (granwave scan)".
    sections
        Reference, "MODULE:NAME", of a function that returns a mapping: heading of each table, as
        "[search]", to the dataclass of its keys and its description. The heading of the keys above
        all tables is empty; a description that is empty is the first line of the dataclass.
    recognises
        Function of the tables of a file that returns True for this kind. None for cases, which
        `granwave.workflows.solvers.solver_of` recognises, and for files that no command takes for
        a case.
    noun
        Noun with its article, for messages: "a scan". Cases have the name of their `CaseKind`.
    command
        Words between ``granwave`` and the name of the file in the command that reads it.
    check
        Reference of a function of the path and the parsed options that executes ``granwave check``
        and returns the exit status; empty: cannot be checked, or is a case.
    may_be_missing
        Tables that may be omitted although some of their keys are required.
    given_elsewhere
        Tables whose required keys may be omitted, as another table gives their values.
    after
        Name of the kind that it is listed behind; empty: it is the last.
    """

    name: str
    title: str
    sections: str
    recognises: Callable[[Mapping[str, Any]], bool] | None = None
    noun: str = ""
    command: str = ""
    check: str = ""
    may_be_missing: tuple[str, ...] = ()
    given_elsewhere: tuple[str, ...] = ()
    after: str = ""

    def is_of(self, tables: Mapping[str, Any]) -> bool:
        """Return True for the tables of a file that is recognised as one of this kind."""
        return self.recognises is not None and self.recognises(tables)


def is_scan(tables: Mapping[str, Any]) -> bool:
    """Return True for the tables of a scan file or a suite."""
    return any(name in tables for name in _OF_SCAN) and not has_tables_of_a_case(tables)


CASE_FILE = FileKind(
    GRANULAR.file_kind,
    "Case files (granwave run)",
    "granwave.workflows.cli.keys.sections:case_sections",
)
SCAN_FILE = FileKind(
    "scan",
    "Scan files (granwave scan)",
    "granwave.workflows.cli.keys.sections:scan_sections",
    recognises=is_scan,
    noun="a scan",
    command=SCAN,
    may_be_missing=("ranks",),
)
SUITE_FILE = FileKind(
    "suite",
    "Suites of scans (granwave scan)",
    "granwave.workflows.cli.keys.sections:suite_sections",
)
PROFILE_FILE = FileKind(
    "profile",
    "Profiles of a cluster (granwave run --submit)",
    "granwave.workflows.cli.keys.sections:profile_sections",
    may_be_missing=("cluster", "slurm"),
)
_CORE = (CASE_FILE, SCAN_FILE, SUITE_FILE, PROFILE_FILE)


def file_kinds() -> tuple[FileKind, ...]:
    """Return all kinds of files, with those of extensions, in the order of ``granwave keys``."""
    return with_added(_CORE, "file_kinds")


def other_than_a_case(tables: Mapping[str, Any]) -> FileKind | None:
    """Return the kind of a file from its tables; None for a case.

    Raises
    ------
    InputError
        The kind is known to an extension that is omitted.
    """
    for kind in reversed(file_kinds()):  # kinds of extensions first: their files may vary keys too
        if kind.is_of(tables):
            return kind
    if owner := owner_left_out("file_kinds", lambda kind: kind.is_of(tables)):
        raise InputError(f"unknown kind of file; {owner}")
    return None
