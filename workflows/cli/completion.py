"""Tab completion: commands, options, built-in cases and scans, presets, and keys for ``--set`` with
their values.

The shell calls ``granwave`` with ``_ARGCOMPLETE`` set, see https://kislyuk.github.io/argcomplete.
Names are collected on demand, because most need modules that the parser does not need.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Collection, Iterable
from typing import TYPE_CHECKING, Any

from granwave.analysis.exports.names import export_names
from granwave.analysis.quantities import entries
from granwave.analysis.studies.registry import STUDIES
from granwave.lammps_inputs.case.figures import figure_names
from granwave.lammps_inputs.case.material import presets
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_toml
from granwave.workflows import library
from granwave.workflows.cli.arguments import BENCH_PARTS
from granwave.workflows.scanning.engine import EXECUTORS
from granwave.workflows.solvers import GRANULAR, case_commands, case_kinds, solver_of

if TYPE_CHECKING:
    from granwave.workflows.cli.commands import Command, Option
    from granwave.workflows.cli.keys.reference import Key

Names = Callable[[argparse.Namespace], Iterable[str]]


def completion(options: argparse.Namespace) -> int:
    """Execute ``granwave completion``: print the code that enables completion in a shell; return
    the exit status.
    """
    from argcomplete.shell_integration import shellcode

    print(shellcode(["granwave"], shell=options.shell))
    return 0


def complete(parser: argparse.ArgumentParser) -> None:
    """Answer the shell and end the process."""
    import argcomplete

    argcomplete.autocomplete(with_completers(parser), always_complete_options=False)


def with_completers(parser: argparse.ArgumentParser) -> argparse.ArgumentParser:
    """Add completers to the arguments of all commands; other arguments complete the names of
    files.
    """
    (verbs,) = (
        action for action in parser._actions if isinstance(action, argparse._SubParsersAction)
    )
    for name, verb in verbs.choices.items():
        completers = _completers_of(verb.get_default("command"))
        for action in verb._actions:
            completer = completers.get(action.dest) or _COMPLETERS.get((name, action.dest))
            if completer is None:
                completer = _COMPLETERS.get(("", action.dest))
            if completer is not None and not action.choices:
                action.completer = completer  # type: ignore[attr-defined]
    return parser


def _completers_of(command: Command) -> dict[str, Callable[..., list[str]]]:
    """Return the completers of a command: of its options that list words, and of its case if it
    runs cases.
    """
    completers = {
        option.destination: _words_of(option)
        for option in command.each_option()
        if option.words is not None
    }
    if command.name in case_commands():
        completers["case"] = _studies(library.CASES, command.name)
    return completers


def _words_of(option: Option) -> Callable[..., list[str]]:
    """Return the completer of an option with a list of words."""
    words = option.words
    assert words is not None
    return _names(lambda _: words())


def _names(names: Names) -> Callable[..., list[str]]:
    """Return the completer of a name, or of names separated by commas."""

    def completer(prefix: str, parsed_args: argparse.Namespace, **_: Any) -> list[str]:
        before, comma, last = prefix.rpartition(",")
        return [f"{before}{comma}{name}" for name in names(parsed_args) if name.startswith(last)]

    return completer


def _studies(kind: str, *verbs: str) -> Callable[..., list[str]]:
    """Return the completer of built-in cases or scans, for these commands, and of TOML files."""

    def completer(prefix: str, **options: Any) -> list[str]:
        from argcomplete.completers import FilesCompleter

        found = [name for name in library.names(kind) if name.startswith(prefix)]
        if verbs:
            found = [name for name in found if library.verb_of(library.find(name, kind)) in verbs]
        return [*found, *FilesCompleter(allowednames=(".toml",))(prefix, **options)]

    return completer


def _overrides(prefix: str, parsed_args: argparse.Namespace, **_: Any) -> list[str]:
    """Complete KEY=VALUE: keys with their ``=``, then the words that a key accepts."""
    key, equals, written = prefix.partition("=")
    if equals:
        return [f"{key}={value}" for value in _values(key) if value.startswith(written)]
    return [
        f"{name}="
        for name in _keys(*_kinds_of_file(parsed_args), first=".1")
        if name.startswith(prefix)
    ]


def _keys(*files: str, first: str = "") -> dict[str, Key]:
    """Return the keys of kinds of files by dotted name; entries of lists have the number
    ``first``.
    """
    from granwave.workflows.cli.keys.reference import tables

    lists = {table.name for table in tables() if table.heading.startswith("[[")}
    keys: dict[str, Key] = {}
    for table in reversed(tables()):  # the first of several is used
        if table.file in (files or (table.file,)):
            prefix = f"{_numbered(table.name, lists, first)}." if table.heading else ""
            keys |= {f"{prefix}{key.name}": key for key in table.keys}
    return keys


def _numbered(name: str, lists: Collection[str], first: str) -> str:
    """Return the dotted name of a table with the number ``first`` behind each array of tables."""
    numbered = ""
    parts = name.split(".")
    for n, part in enumerate(parts, start=1):
        number = first if ".".join(parts[:n]) in lists else ""
        numbered += f".{part}{number}"
    return numbered.removeprefix(".")


def _kinds_of_file(options: argparse.Namespace) -> list[str]:
    """Return the kind of the case on the command line, or the possible kinds."""
    try:
        tables = read_toml(library.find(getattr(options, "case", None) or ""))
        return [solver_of(tables).file_kind]
    except InputError:  # no case is given yet
        command = options.command.name
    kinds = [kind.file_kind for kind in case_kinds() if kind.verb == command]
    return kinds or [GRANULAR.file_kind]


def _values(name: str) -> list[str]:
    """Return the words that a key accepts."""
    if name.rpartition(".")[2] in ("material", "preset"):
        return list(presets())
    key = _keys().get(re.sub(r"\.\d+", "", name))
    return [show(word).strip('"') for word in key.words] if key else []


def _tables(_: argparse.Namespace) -> Iterable[str]:
    from granwave.workflows.cli.keys.reference import tables

    names = [table.name for table in tables()]
    for table in tables():
        names += [f"{table.name}.{key.name}" for key in table.keys]
    return dict.fromkeys(names)


_OVERRIDES = "overrides"
#: Completers by command and name of the argument; an empty command stands for all. Options that give
#: their words need none.
_COMPLETERS: dict[tuple[str, str], Callable[..., list[str]]] = {
    ("", _OVERRIDES): _overrides,
    ("write", "case"): _studies(library.CASES, GRANULAR.verb),
    ("check", "case"): _studies(library.CASES),
    ("scan", "scan"): _studies(library.SCANS),
    ("scan", "executor"): _names(lambda _: EXECUTORS),
    ("show", "name"): _names(
        lambda _: [*library.names(library.CASES), *library.names(library.SCANS)]
    ),
    ("quantities", "name"): _names(
        lambda _: [entry.name for entry in entries() if "*" not in entry.name]
    ),
    ("keys", "table"): _names(_tables),
    ("report", "study"): _names(lambda _: STUDIES),
    ("compare", "quantities"): _names(
        lambda _: [entry.name for entry in entries() if "*" not in entry.name]
    ),
    ("figures", "only"): _names(lambda _: figure_names()),
    ("figures", "names"): _names(lambda _: figure_names()),
    ("export", "to"): _names(lambda _: export_names()),
    ("bench", "parts"): _names(lambda _: BENCH_PARTS),
}
