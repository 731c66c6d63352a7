"""Solvers: a case is a packing that LAMMPS runs, or a continuum problem. Its tables tell which."""

from __future__ import annotations

import dataclasses
import importlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Protocol

from granwave.lammps_inputs.directories import check_disk
from granwave.lammps_inputs.errors import raise_all
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.planning.plan import check_run, plan

_OF_CONTINUUM, _OF_SPHERE_CONTACT = ("block", "punch"), ("sphere", "partner")


class AnyCase(Protocol):
    """A case of any kind."""

    @property
    def name(self) -> str:
        """Name of the case."""

    def to_dict(self) -> dict[str, Any]:
        """As nested tables, all defaults filled in."""


class Cost(Protocol):
    """Cost of a run: bytes and seconds, estimates."""

    @property
    def memory(self) -> float:
        """Bytes."""

    @property
    def disk(self) -> float:
        """Bytes."""

    @property
    def disk_reserve(self) -> float:
        """Bytes that must stay free while it runs."""

    @property
    def wall_time(self) -> float:
        """On as many ranks as were asked for, s."""


@dataclasses.dataclass(frozen=True)
class Kind:
    """How cases of one kind are read and run.

    Attributes
    ----------
    verb
        Word of the command line that runs them.
    parts
        What their size counts.
    versions
        Names, in `granwave.workflows.run.versions`, of what their results depend on.
    read
        As `case_from_dict`.
    size
        How many parts a case has.
    cost
        Of a case on a number of ranks, with its figures or without.
    check
        Raises InputError where a case of this cost cannot be run: a file that it names does not serve, memory, disk;
        parameters as of `granwave.lammps_inputs.planning.plan.check_run`.
    """

    verb: str
    parts: str
    versions: tuple[str, ...]
    read: Callable[..., Any]
    size: Callable[[Any], int]
    cost: Callable[[Any, int, bool], Any]
    check: Callable[..., None]
    parallel: bool = False


def solver_of(tables: Mapping[str, Any]) -> Kind:
    """The kind of a case from its tables."""
    if any(name in tables for name in _OF_SPHERE_CONTACT):
        return SPHERE_CONTACT
    return CONTINUUM if any(name in tables for name in _OF_CONTINUUM) else GRANULAR


def _check_mesh(
    case: Any, expected: Any, directory: Path | None = None, *, files: bool = True, memory: bool = True
) -> None:
    from granwave.workflows.finite_elements.frame import check_memory

    checks: list[Callable[[], None]] = [lambda: check_memory(case)] if memory else []
    if directory is not None:
        checks.append(lambda: check_disk(directory, expected.disk, remedy="take fewer elements"))
    raise_all(checks)


def _continuum_kind(package: str, case: str) -> Kind:
    """A kind whose modules are loaded when a case of it is met; ``case`` is its class."""

    def part(module: str, name: str) -> Any:
        return getattr(importlib.import_module(f"granwave.workflows.finite_elements.{package}.{module}"), name)

    return Kind(
        verb="continuum",
        parts="elements",
        versions=("granwave",),
        read=lambda data, source, **options: part("case", case).from_dict(data, source, **options),
        size=lambda found: found.run.elements,
        cost=lambda found, *_: part("plan", "plan")(found),
        check=_check_mesh,
    )


GRANULAR = Kind(
    verb="run",
    parts="spheres",
    versions=("granwave", "lammps", "plugin_built_for_lammps"),
    read=case_from_dict,
    size=lambda case: assemble(case).n_spheres,
    cost=lambda case, n_ranks, figures: plan(case, n_ranks=n_ranks, figures=figures),
    check=check_run,
    parallel=True,
)
CONTINUUM = _continuum_kind("punch", "ContinuumCase")
SPHERE_CONTACT = _continuum_kind("sphere_contact", "SphereContactCase")
