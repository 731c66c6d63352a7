"""Solvers by kind of case: LAMMPS for packings, other programs for the cases of extensions."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, Protocol

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.parse import apply_overrides, parse_overrides
from granwave.lammps_inputs.contact.initial_dents import earlier_result
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.extensions import added, owner_left_out
from granwave.lammps_inputs.files import read_toml
from granwave.lammps_inputs.load_case import case_from_dict, stored_case
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.planning.plan import afford, check_files, plan
from granwave.workflows.check_part import CheckPart


class AnyCase(Protocol):
    """A case of any kind."""

    @property
    def name(self) -> str:
        """Name of the case."""

    def to_dict(self) -> dict[str, Any]:
        """Return the case as nested tables, all defaults filled in."""


class Cost(Protocol):
    """Estimated cost of a run."""

    @property
    def memory(self) -> float:
        """Memory, bytes."""

    @property
    def disk(self) -> float:
        """Disk space, bytes."""

    @property
    def disk_reserve(self) -> float:
        """Disk space that must stay free during the run, bytes."""

    @property
    def wall_time(self) -> float:
        """Wall time on the requested number of ranks, s."""


@dataclasses.dataclass(frozen=True)
class CaseKind:
    """Functions and properties of the cases of one kind.

    Attributes
    ----------
    verb
        Command that runs them.
    noun
        Noun with its article, for messages: "a granular case".
    tables
        Tables by which a case of this kind is recognised: a case has one of these tables.
    file_kind
        Name of the `granwave.workflows.file_kinds.FileKind` that lists their keys.
    parts
        Unit of their size, as spheres or elements.
    versions
        Names, in `granwave.workflows.run.record.versions`, of the programs that their results
        depend on.
    read
        Function that makes a case, as `case_from_dict`.
    stored
        Function that makes the case of a run that was made, as `stored_case`.
    assemble
        Function that converts a case to the argument of `size` and `cost`: all bodies of a packing;
        other cases may be that themselves.
    size
        Function that returns the number of parts.
    cost
        Function that returns the cost on a number of ranks, with figures or without.
    check
        Function that raises InputError if files named in a case are unsuitable.
    afford
        Function of a case, its cost and the directory of its results or None that raises
        InputError if this machine lacks the memory or the disk space.
    run
        Function of a case and the directory of its results that runs it and returns its summary;
        keywords ``figures``, ``force``, ``resume`` and ``progress`` as of
        `granwave.workflows.run.driver.run_case`, which runs packings: theirs is None.
    parallel
        True if cases can run on several ranks.
    heading
        Heading of built-in cases in their list; packings have several.
    modules
        Modules that a process loads once for many runs.
    check_part
        Function of an assembled case that returns the additional output of ``granwave check``;
        None: none.
    """

    verb: str
    noun: str
    tables: tuple[str, ...]
    file_kind: str
    parts: str
    versions: tuple[str, ...]
    read: Callable[..., Any]
    stored: Callable[..., Any]
    assemble: Callable[[Any], Any]
    size: Callable[[Any], int]
    cost: Callable[[Any, int, bool], Any]
    check: Callable[[Any], None]
    afford: Callable[[Any, Any, Path | None], None]
    run: Callable[..., dict[str, Any]] | None = None
    parallel: bool = False
    heading: str = ""
    modules: tuple[str, ...] = ()
    check_part: Callable[[Any], CheckPart] | None = None

    def recognises(self, tables: Mapping[str, Any]) -> bool:
        """Return True for the tables of a case of this kind."""
        return any(name in tables for name in self.tables)

    def load(self, path: str | Path, overrides: Iterable[str] | Mapping[str, Any] = ()) -> Any:
        """Read a case file; ``overrides`` as in `granwave.lammps_inputs.load_case`."""
        changes = parse_overrides(overrides)
        return self.read(apply_overrides(read_toml(path), changes), path, overridden=changes)


def case_kinds() -> tuple[CaseKind, ...]:
    """Return all kinds of cases, packings first."""
    return (GRANULAR, *_of_extensions())


def _of_extensions() -> Iterator[CaseKind]:
    return itertools.chain.from_iterable(added("case_kinds"))


def case_commands() -> tuple[str, ...]:
    """Return the commands that run cases, the command for packings first."""
    return tuple(dict.fromkeys(kind.verb for kind in case_kinds()))


def has_tables_of_a_case(tables: Mapping[str, Any]) -> bool:
    """Return True if a file has a table by which cases of some kind are recognised."""
    return any(kind.recognises(tables) for kind in case_kinds())


def solver_of(tables: Mapping[str, Any]) -> CaseKind:
    """Return the kind of a case from its tables.

    Raises
    ------
    InputError
        The kind is known to an extension that is omitted.
    """
    for kind in _of_extensions():
        if kind.recognises(tables):
            return kind
    if GRANULAR.recognises(tables):
        return GRANULAR
    if owner := owner_left_out("case_kinds", lambda kind: kind.recognises(tables)):
        raise InputError(f"unknown kind of case; {owner}")
    return GRANULAR


def _check_files(case: Case) -> None:
    if earlier_result(case) is not None:
        check_files(assemble(case))


GRANULAR = CaseKind(
    verb="run",
    noun="a granular case",
    tables=("packing",),
    file_kind="case",
    parts="spheres",
    versions=("granwave", "lammps", "plugin_built_for_lammps"),
    read=case_from_dict,
    stored=stored_case,
    assemble=assemble,
    size=lambda assembly: assembly.n_spheres,
    cost=lambda assembly, n_ranks, figures: plan(assembly, n_ranks=n_ranks, figures=figures),
    check=_check_files,
    afford=lambda _, expected, directory: afford(expected, directory),
    parallel=True,
)
