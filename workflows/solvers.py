"""Solvers by kind of case: LAMMPS for packings, finite elements for continuum problems."""

from __future__ import annotations

import dataclasses
import importlib
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, Protocol

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.parse import apply_overrides, parse_overrides
from granwave.lammps_inputs.contact.initial_dents import earlier_result
from granwave.lammps_inputs.directories import check_disk
from granwave.lammps_inputs.errors import raise_all
from granwave.lammps_inputs.files import read_toml
from granwave.lammps_inputs.load_case import case_from_dict, stored_case
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.planning.plan import afford, check_files, plan

_OF_CONTINUUM = ("block", "punch")
_OF_SPHERE_CONTACT = ("sphere", "partner")


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
    parts
        Unit of their size: spheres or elements.
    versions
        Names, in `granwave.workflows.run.record.versions`, of the programs that their results
        depend on.
    read
        Function that makes a case, as `case_from_dict`.
    stored
        Function that makes the case of a run that was made, as `stored_case`.
    assemble
        Function that makes of a case what `size` and `cost` take: all bodies of a packing; a case
        of finite elements is that itself.
    size
        Function that returns the number of parts.
    cost
        Function that returns the cost on a number of ranks, with figures or without.
    check
        Function that raises InputError if files that a case names are not what it needs.
    afford
        Function of a case, its cost and the directory of its results or None that raises
        InputError if this machine lacks the memory or the disk space.
    run
        Function that runs a case of finite elements into a directory, as `run_continuum`; None for
        those that `granwave.workflows.run.driver.run_case` runs.
    parallel
        True if cases can run on several ranks.
    """

    verb: str
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

    def load(self, path: str | Path, overrides: Iterable[str] | Mapping[str, Any] = ()) -> Any:
        """Read a case file; ``overrides`` as in `granwave.lammps_inputs.load_case`."""
        changes = parse_overrides(overrides)
        return self.read(apply_overrides(read_toml(path), changes), path, overridden=changes)


def solver_of(tables: Mapping[str, Any]) -> CaseKind:
    """Return the kind of a case from its tables."""
    if any(name in tables for name in _OF_SPHERE_CONTACT):
        return SPHERE_CONTACT
    return CONTINUUM if any(name in tables for name in _OF_CONTINUUM) else GRANULAR


def _afford_mesh(case: Any, expected: Any, directory: Path | None) -> None:
    from granwave.extensions.continuum.frame import check_memory

    checks: list[Callable[[], None]] = [lambda: check_memory(case)]
    if directory is not None:
        checks.append(lambda: check_disk(directory, expected.disk, remedy="take fewer elements"))
    raise_all(checks)


def _continuum_kind(package: str, case: str, run: str) -> CaseKind:
    """Make a kind whose modules are imported on demand, from the names of its class and its
    function.
    """

    def part(module: str, name: str) -> Any:
        return getattr(
            importlib.import_module(f"granwave.extensions.continuum.{package}.{module}"), name
        )

    return CaseKind(
        verb="continuum",
        parts="elements",
        versions=("granwave",),
        read=lambda data, source, **options: part("case", case).from_dict(data, source, **options),
        stored=lambda data, source: part("case", case).from_dict(data, source),
        assemble=lambda found: found,
        size=lambda found: found.run.elements,
        cost=lambda found, *_: part("mesh", "plan")(found),
        check=lambda _: None,  # such a case names no files
        afford=_afford_mesh,
        run=lambda *given, **how: part("run", run)(*given, **how),
    )


def _check_files(case: Case) -> None:
    if earlier_result(case) is not None:
        check_files(assemble(case))


GRANULAR = CaseKind(
    verb="run",
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
CONTINUUM = _continuum_kind("punch", "ContinuumCase", "run_continuum")
SPHERE_CONTACT = _continuum_kind("sphere_contact", "SphereContactCase", "run_sphere_contact")
