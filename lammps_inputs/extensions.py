"""Extensions: features outside the core, by entry points of the group ``granwave.extensions``.

An entry point names one `Extension`, an object that lists its additions. The core iterates over
these objects and refers to no extension by name; granwave's own extensions are registered in the
same way as external ones. Additions are given by references, "MODULE:NAME", which are loaded on
demand: a command starts without the modules of the others.

The environment variable ``GRANWAVE_WITHOUT`` disables extensions by names, separated by commas;
``all`` disables all.
"""

from __future__ import annotations

import contextlib
import dataclasses
import importlib
import logging
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any, Protocol, TypeVar

from granwave.lammps_inputs.errors import InputError

GROUP = "granwave.extensions"
WITHOUT = "GRANWAVE_WITHOUT"
ALL = "all"

_LOG = logging.getLogger(__name__)


class ListEntry(Protocol):
    """An entry of a list that extensions add to."""

    @property
    def name(self) -> str:
        """Name, unique in the list."""

    @property
    def after(self) -> str:
        """Name of the preceding entry; empty: at the end."""


Listed = TypeVar("Listed", bound=ListEntry)


@dataclasses.dataclass(frozen=True)
class Extension:
    """Lists of the additions of an extension; only its name and title are required.

    A field that is called a reference is a text "MODULE:NAME" for an object of the type that is
    given here; a mapping of references has a reference for each name.

    Attributes
    ----------
    name
        Name of the extension, one word.
    title
        Description in one line, for ``granwave doctor``.
    uses
        Names of other extensions that it imports; without them it is omitted too.
    packages
        Python packages that only it needs: name in pip by name in ``import``.
    extra
        Extra of the distribution that installs these packages, as ``granwave[design]``.
    folder
        Folder with built-in cases in ``cases/``, scans in ``scans/``, and examples of keys in
        ``key_examples.toml``: a table for each table of each kind of file.
    lattices
        Reference: mapping of names to `granwave.lammps_inputs.packing_kind.PackingKind`.
    packings
        Reference: sequence of subclasses of
        `granwave.lammps_inputs.case.packing.made_packing.PackingMaker`: packings whose grains are
        made before the case is read.
    loads
        Reference: sequence of subclasses of `granwave.lammps_inputs.case.loads.load.Load`.
    result_kinds
        Reference: sequence of `granwave.lammps_inputs.result_kinds.ResultKind`, one for each kind
        of directories of results that it writes.
    case_keys
        Reference: mapping of dotted keys of its cases to
        `granwave.analysis.formatting.values.Naming`, their labels and units.
    quantities
        Reference: sequence of `granwave.analysis.quantities.Quantity`: values that it writes.
    summary
        Reference: function of a `granwave.analysis.result.reader.Result` that returns values of
        summary.json by name; their `Quantity` is among ``quantities``.
    figures
        Figures of a run: reference to a `granwave.analysis.figures.run_figures.RunFigure` by name.
    figures_on_request
        Names of ``figures`` that are drawn only by name or with all figures.
    products
        Files of a run in addition to figures, requested in ``[figures]`` of its case: reference to
        a sequence of `granwave.analysis.products.Product`.
    exports
        Formats of ``granwave export``: reference to a
        `granwave.analysis.exports.formats.ExportFormat` by name of the format.
    studies
        Studies of runs by name: module, see `granwave.analysis.studies.registry`.
    comparisons
        Studies that every report and suite makes of all its runs, by name: module, likewise.
    report
        Reference: sequence of `granwave.analysis.reports.kinds.ReportKind`, one for each kind of
        results with its own part of a report.
    case_kinds
        Reference: sequence of `granwave.workflows.solvers.CaseKind`: cases that are not of
        spheres.
    file_kinds
        Reference: sequence of `granwave.workflows.file_kinds.FileKind`: files that users write,
        with the tables of their keys.
    commands
        Reference: sequence of `granwave.workflows.cli.commands.Command`.
    check
        Reference: function of an assembly that returns additional output of ``granwave check``, a
        `granwave.workflows.check_part.CheckPart`.
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
    case_keys: str = ""
    quantities: str = ""
    summary: str = ""
    figures: Mapping[str, str] = dataclasses.field(default_factory=dict)
    figures_on_request: tuple[str, ...] = ()
    products: str = ""
    exports: Mapping[str, str] = dataclasses.field(default_factory=dict)
    studies: Mapping[str, str] = dataclasses.field(default_factory=dict)
    comparisons: Mapping[str, str] = dataclasses.field(default_factory=dict)
    report: str = ""
    case_kinds: str = ""
    file_kinds: str = ""
    commands: str = ""
    check: str = ""
    python: Mapping[str, str] = dataclasses.field(default_factory=dict)


@cache
def extensions() -> tuple[Extension, ...]:
    """Return the extensions that are installed, by name; extensions in `WITHOUT` are omitted.

    An extension that cannot be loaded is omitted with a warning.
    """
    unwanted = {name.strip() for name in os.environ.get(WITHOUT, "").split(",")}
    if ALL in unwanted:
        return ()
    found: dict[str, Extension] = {}
    for point in _points():
        extension = None if point.name in unwanted else _load(point)
        if extension is not None:
            found[extension.name] = extension
    while lacking := [name for name, one in found.items() if set(one.uses) - found.keys()]:
        for name in lacking:
            del found[name]
    return tuple(found.values())


def left_out() -> tuple[Extension, ...]:
    """Return the extensions that are installed but not among `extensions`, for messages.

    Extensions that cannot be loaded are skipped.
    """
    names = {extension.name for extension in extensions()}
    others = []
    for point in _points():
        if point.name not in names:
            # an error in someone's extension that was not requested
            with contextlib.suppress(Exception):
                others.append(point.load())
    return tuple(extension for extension in others if isinstance(extension, Extension))


def owner_left_out(field: str, is_it: Callable[[Any], bool]) -> str:
    """Return a message if the requested object belongs to a disabled extension; empty if not.

    Parameters
    ----------
    field
        Name of a field that refers to a sequence, such as ``commands``.
    is_it
        Function that returns True for a requested entry.
    """
    for extension, entry in entries_left_out(field):
        if is_it(entry):
            return of_left_out(extension)
    return ""


def of_left_out(extension: str) -> str:
    """Return the message that an object belongs to a disabled extension, with the remedy."""
    owner = f"it belongs to the extension {extension}"
    return f"{owner}, which {WITHOUT} hides: remove it from {WITHOUT}"


def entries_left_out(field: str) -> list[tuple[str, Any]]:
    """Return the entries of the extensions of `left_out`, each with the name of its extension.

    Parameters
    ----------
    field
        Name of a field that refers to a sequence, such as ``commands``.
    """
    entries: list[tuple[str, Any]] = []
    for extension in left_out():
        if reference := getattr(extension, field):
            with contextlib.suppress(Exception):  # as in `left_out`
                entries += [(extension.name, entry) for entry in load(reference)]
    return entries


def distribution_of(extension: Extension) -> str:
    """Return name and version of the distribution that contains an extension; empty if unknown."""
    for point in _points():
        if point.name == extension.name and point.dist is not None:
            return f"{point.dist.name} {point.dist.version}"
    return ""


def _distribution_name(extension: Extension) -> str:
    return distribution_of(extension).partition(" ")[0] or "granwave"


@cache
def _points() -> tuple[EntryPoint, ...]:
    """Return the entry points of all installed extensions by name."""
    return tuple(sorted(entry_points(group=GROUP), key=lambda point: point.name))


def _load(point: EntryPoint) -> Extension | None:
    try:
        extension = point.load()
    except Exception as error:  # an error in someone's extension; granwave continues without it
        reason = f"{type(error).__name__}: {error}"
    else:
        if isinstance(extension, Extension):
            return extension
        reason = f"{point.value} is a {type(extension).__name__}, expected an Extension"
    _LOG.warning(
        "extension %s cannot be loaded and is ignored: %s; %s=%s suppresses this message",
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
    """Iterate over the objects to which a field of all extensions refers.

    Parameters
    ----------
    field
        Name of a field that holds one reference, such as ``commands``.
    """
    yield from loaded(field).values()


def loaded(field: str) -> dict[str, Any]:
    """Return the objects to which a field of all extensions refers, by extension.

    Parameters
    ----------
    field
        Name of a field that holds one reference, such as ``lattices``.

    Raises
    ------
    InputError
        A reference cannot be loaded; the message says which extension to leave out.
    """
    return {
        extension.name: _loaded(extension, field, getattr(extension, field))
        for extension in extensions()
        if getattr(extension, field)
    }


def _loaded(extension: Extension, field: str, reference: str) -> Any:
    """Return the object of a reference of an extension."""
    try:
        return load(reference)
    except ModuleNotFoundError as error:
        reason = missing_package(error) or str(error)
    except Exception as error:  # an error in someone's extension
        reason = f"{type(error).__name__}: {error}"
    raise InputError(
        f"extension {extension.name}: {field} {reference} cannot be loaded: {reason}; fix it, or "
        f"hide the extension with {WITHOUT}={extension.name}"
    )


def added_by_key(field: str, noun: str, key: str = "key") -> dict[str, Any]:
    """Return the objects in the sequences of a field of all extensions by one of their attributes.

    Parameters
    ----------
    field
        Name of a field that is a reference to a sequence, such as ``products``.
    noun
        Noun for the objects, in messages.
    key
        Name of the attribute.

    Raises
    ------
    InputError
        A reference cannot be loaded, or two objects have the same attribute.
    """
    return joined(noun, {}, _by_key(field, key))


def _by_key(field: str, key: str) -> dict[str, dict[str, Any]]:
    """Return the objects in the sequences of a field by one of their attributes, by extension."""
    tables = {}
    for extension, entries in loaded(field).items():
        tables[extension] = {getattr(entry, key): entry for entry in entries}
    return tables


def with_added(own: Iterable[Listed], field: str) -> tuple[Listed, ...]:
    """Return entries of the core and of extensions, in the order of lists.

    An entry whose ``after`` is the name of another follows this entry; others are at the end.

    Parameters
    ----------
    own
        Entries of the core, which have a ``name``, like entries of extensions.
    field
        Name of a field that refers to a sequence of entries, such as ``commands``.

    Raises
    ------
    InputError
        Two entries have the same name.
    """
    entries = list(own)
    table = joined(field, {entry.name: entry for entry in entries}, _by_key(field, "name"))
    for entry in list(table.values())[len(entries) :]:
        names = [other.name for other in entries]
        place = names.index(entry.after) + 1 if entry.after in names else len(entries)
        entries.insert(place, entry)
    return tuple(entries)


def added_by_name(field: str) -> dict[str, str]:
    """Return the references of a field of all extensions by name.

    Parameters
    ----------
    field
        Name of a field that is a mapping, such as ``figures``.
    """
    return joined(field, {}, {one.name: getattr(one, field) for one in extensions()})


def joined(
    noun: str, own: Mapping[str, Any], added: Mapping[str, Mapping[str, Any]]
) -> dict[str, Any]:
    """Return the entries of the core and of extensions in one table.

    Parameters
    ----------
    noun
        Noun for the entries, in the message.
    own
        Entries of the core by name.
    added
        Entries by name, of each extension by its name.

    Raises
    ------
    InputError
        Two entries have the same name; the message names the extensions.
    """
    table = dict(own)
    owners = dict.fromkeys(own, "granwave itself")
    for extension, entries in added.items():
        for name, entry in entries.items():
            if name in table:
                raise InputError(
                    f"{noun} {name}: both {owners[name]} and the extension {extension} define it; "
                    f"rename one, or hide the extension with {WITHOUT}={extension}"
                )
            table[name] = entry
            owners[name] = f"the extension {extension}"
    return table


def install_command(extension: Extension) -> str:
    """Return the command that installs the packages that only an extension needs."""
    if extension.extra:
        return f'pip install "{_distribution_name(extension)}[{extension.extra}]"'
    return f"pip install {' '.join(extension.packages.values())}"


def missing_package(error: ModuleNotFoundError) -> str:
    """Return how a package that an extension needs is installed; empty if none needs it."""
    package = (error.name or "").partition(".")[0]
    for extension in extensions():
        if package in extension.packages:
            what = extension.packages[package]
            command = install_command(extension)
            return (
                f"{what} is not installed, but the extension {extension.name} requires it: "
                f"{command}"
            )
    return ""
