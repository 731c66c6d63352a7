"""Extensions: features outside the core, found by entry points of the group ``granwave.extensions``.

An entry point names one `Extension`, an object that says what the extension adds. The core goes
through these objects and knows no extension by its name; granwave's own extensions are registered
in the same way as anyone's. What an extension adds is given by references, "MODULE:NAME", which
are loaded when they are needed: a command starts without the modules of all others.

The environment variable ``GRANWAVE_WITHOUT`` leaves extensions out, by names with commas between
them; ``all`` leaves out all.
"""

from __future__ import annotations

import dataclasses
import importlib
import logging
import os
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

GROUP = "granwave.extensions"
WITHOUT = "GRANWAVE_WITHOUT"
ALL = "all"

_LOG = logging.getLogger(__name__)


@dataclasses.dataclass(frozen=True)
class Extension:
    """What an extension adds; everything but its name and title may be left out.

    A field that is called a reference is a text "MODULE:NAME" for an object of the type that is
    given here; a mapping of references has a reference for each name.

    Attributes
    ----------
    name
        Name of the extension, one word.
    title
        Description in one line, for ``granwave doctor``.
    uses
        Names of other extensions that it imports; without them it is left out too.
    packages
        Python packages that only it needs: name in pip by name in ``import``.
    extra
        Extra of the distribution that installs these packages, as ``granwave[design]``.
    folder
        Folder with built-in cases in ``cases/`` and scans in ``scans/``.
    lattices
        Reference: mapping of names to `granwave.lammps_inputs.lattices.PackingKind`.
    packings
        Reference: sequence of `granwave.lammps_inputs.case.made_packing.PackingMaker`: kinds of
        packings whose grains are made before the case is read.
    loads
        Reference: sequence of subclasses of `granwave.lammps_inputs.case.loads.load.Load`.
    result_kinds
        Reference: sequence of `granwave.lammps_inputs.result_kinds.ResultKind`, one for each kind
        of directories of results that it writes.
    quantities
        Reference: sequence of `granwave.analysis.quantities.Quantity`: values that it writes.
    summary
        Reference: function of a `granwave.analysis.result.reader.Result` that returns values of
        summary.json by name; their `Quantity` is among ``quantities``.
    figures
        Figures of a run: reference to a `granwave.analysis.figures.run_figures.RunFigure` by name.
    products
        Files that a run leaves besides figures, as ``[figures]`` of its case asks: reference to a
        sequence of `granwave.analysis.products.Product`.
    exports
        Formats of ``granwave export``: reference to a function by name of the format.
    studies
        Studies of runs by name: module, see `granwave.analysis.studies.registry`.
    report
        Reference: sequence of `granwave.analysis.reports.kinds.ReportKind`, one for each kind of
        results that a report shows in its own way.
    case_kinds
        Reference: sequence of `granwave.workflows.solvers.CaseKind`: cases that are not of
        spheres.
    file_kinds
        Reference: sequence of `granwave.workflows.cli.file_kinds.FileKind`: files that users
        write, with the tables of their keys.
    commands
        Reference: sequence of `granwave.workflows.cli.commands.Command`.
    check
        Reference: function of an assembly that returns what ``granwave check`` says beside the
        plan, a `granwave.workflows.cli.check_parts.CheckPart`.
    python
        Names of ``import granwave``: reference to a function or class by name.
    """

    name: str
    title: str
    uses: tuple[str, ...] = ()
    packages: Mapping[str, str] = dataclasses.field(default_factory=dict)
    extra: str = ""
    folder: Path | None = None
    lattices: str = ""
    packings: str = ""
    loads: str = ""
    result_kinds: str = ""
    quantities: str = ""
    summary: str = ""
    figures: Mapping[str, str] = dataclasses.field(default_factory=dict)
    products: str = ""
    exports: Mapping[str, str] = dataclasses.field(default_factory=dict)
    studies: Mapping[str, str] = dataclasses.field(default_factory=dict)
    report: str = ""
    case_kinds: str = ""
    file_kinds: str = ""
    commands: str = ""
    check: str = ""
    python: Mapping[str, str] = dataclasses.field(default_factory=dict)


@cache
def extensions() -> tuple[Extension, ...]:
    """Return the extensions that are installed, by name; those of `WITHOUT` are left out.

    One that cannot be loaded is left out with a warning.
    """
    left_out = {name.strip() for name in os.environ.get(WITHOUT, "").split(",")}
    if ALL in left_out:
        return ()
    found: dict[str, Extension] = {}
    for point in sorted(entry_points(group=GROUP), key=lambda point: point.name):
        extension = None if point.name in left_out else _load(point)
        if extension is not None:
            found[extension.name] = extension
    while lacking := [name for name, one in found.items() if set(one.uses) - found.keys()]:
        for name in lacking:
            del found[name]
    return tuple(found.values())


def _load(point: EntryPoint) -> Extension | None:
    try:
        extension = point.load()
    except Exception as error:  # of anyone's package; granwave goes on without it
        reason = f"{type(error).__name__}: {error}"
    else:
        if isinstance(extension, Extension):
            return extension
        reason = f"{point.value} is a {type(extension).__name__}, expected an Extension"
    _LOG.warning(
        "extension %s is left out, it cannot be loaded: %s; %s=%s silences this",
        point.name,
        reason,
        WITHOUT,
        point.name,
    )
    return None


def load(reference: str) -> Any:
    """Return the object of a reference "MODULE:NAME"."""
    module, _, name = reference.partition(":")
    return getattr(importlib.import_module(module), name)


def added(field: str) -> Iterator[Any]:
    """Yield what the references of a field of all extensions stand for, one after the other.

    Parameters
    ----------
    field
        Name of a field that holds one reference, such as ``commands``.
    """
    for extension in extensions():
        if reference := getattr(extension, field):
            yield load(reference)


def added_by_name(field: str) -> dict[str, str]:
    """Return the references of a field of all extensions by name.

    Parameters
    ----------
    field
        Name of a field that is a mapping, such as ``figures``.
    """
    found: dict[str, str] = {}
    for extension in extensions():
        found |= getattr(extension, field)
    return found


def missing_package(error: ModuleNotFoundError) -> str:
    """Return how a package that an extension needs is installed; empty if none needs it."""
    package = (error.name or "").partition(".")[0]
    for extension in extensions():
        if package in extension.packages:
            what = extension.packages[package]
            return f'{what} is not installed, which {extension.name} needs: pip install "granwave[{extension.extra}]"'
    return ""
