"""Kinds of cases and files of the finite-element problems: a punch on a block, and the contact of
two spheres.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.directories import check_disk
from granwave.lammps_inputs.errors import raise_all
from granwave.workflows.check_part import CheckPart
from granwave.workflows.file_kinds import FileKind
from granwave.workflows.solvers import CaseKind

CONTINUUM = "continuum"  # command, and kind of files
_SPHERE_CONTACT = "sphere-contact"


def _afford_mesh(case: Any, expected: Any, directory: Path | None) -> None:
    from granwave.extensions.continuum.frame import check_memory

    checks: list[Callable[[], None]] = [lambda: check_memory(case)]
    if directory is not None:
        checks.append(lambda: check_disk(directory, expected.disk, remedy="use fewer elements"))
    raise_all(checks)


def _check_punch(case: Any) -> CheckPart:
    from granwave.extensions.continuum.counterpart import check_of_punch

    return check_of_punch(case)


def _kind(
    package: str,
    case_class: str,
    run: str,
    tables: tuple[str, ...],
    file_kind: str,
    check_part: Callable[[Any], CheckPart] | None = None,
) -> CaseKind:
    """Make a kind whose modules are imported on demand.

    Parameters
    ----------
    package
        Package of the problem.
    case_class, run
        Names of the class of its cases and of the function that runs one.
    tables, file_kind, check_part
        As of `CaseKind`.
    """

    def part(module: str, name: str) -> Any:
        found = importlib.import_module(f"granwave.extensions.continuum.{package}.{module}")
        return getattr(found, name)

    return CaseKind(
        verb=CONTINUUM,
        noun="a continuum case",
        tables=tables,
        file_kind=file_kind,
        parts="elements",
        versions=("granwave",),
        read=lambda data, source, **options: part("case", case_class).from_dict(
            data, source, **options
        ),
        stored=lambda data, source: part("case", case_class).from_dict(data, source),
        assemble=lambda case: case,
        size=lambda case: case.run.elements,
        cost=lambda case, *_: part("mesh", "plan")(case),
        check=lambda _: None,  # such a case names no files
        afford=_afford_mesh,
        run=lambda *arguments, **keywords: part("run", run)(*arguments, **keywords),
        heading="Finite elements (granwave continuum)",
        modules=(f"granwave.extensions.continuum.{package}.run",),
        check_part=check_part,
    )


CASE_KINDS = (
    _kind(
        "sphere_contact",
        "SphereContactCase",
        "run_sphere_contact",
        ("sphere", "partner"),
        _SPHERE_CONTACT,
    ),
    _kind("punch", "ContinuumCase", "run_continuum", ("block", "punch"), CONTINUUM, _check_punch),
)
FILE_KINDS = (
    FileKind(
        CONTINUUM,
        "Continuum cases (granwave continuum)",
        "granwave.extensions.continuum.key_sections:punch_sections",
        after="case",
    ),
    FileKind(
        _SPHERE_CONTACT,
        "Cases of the contact of two spheres (granwave continuum)",
        "granwave.extensions.continuum.key_sections:sphere_contact_sections",
        may_be_missing=("partner",),
        given_elsewhere=("partner",),
        after=CONTINUUM,
    ),
)
