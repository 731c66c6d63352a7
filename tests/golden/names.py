"""Golden names: what users type and read, kept in `NAMES`.

Commands with their options, keys of all files, values of summaries, figures, built-in cases, scans
and studies, and the names of Python. They are taken from the public interfaces of the package. A
missing name breaks the code of users; new names are added by

    .venv/bin/python -m tests.golden.names        # all golden outputs: -m tests.golden.outputs
"""

from __future__ import annotations

import argparse
import dataclasses
import inspect
import sys
import tomllib
from collections.abc import Iterable
from operator import attrgetter
from pathlib import Path
from types import ModuleType
from typing import Any

import tomli_w

import granwave
from granwave import measures, theory
from granwave.analysis.quantities import all_scan_figures, entries
from granwave.analysis.reports.kinds import report_kinds
from granwave.analysis.studies.registry import COMPARISON, STUDIES
from granwave.extensions.continuum.punch.figures import FIGURES as PUNCH_FIGURES
from granwave.extensions.continuum.sphere_contact.figures import FIGURES as CONTACT_FIGURES
from granwave.extensions.inference.forces.output import FIGURES as INFERENCE_FIGURES
from granwave.extensions.waves.small_waves import FIGURES as SPECTRA_FIGURES
from granwave.lammps_inputs import presets
from granwave.lammps_inputs.case.figures import figure_names
from granwave.workflows import library
from granwave.workflows.cli.keys.reference import tables
from granwave.workflows.cli.parser import make_parser

NAMES = Path(__file__).parent / "names.toml"
HEADING = """\
# Written by `python -m tests.golden.names`: the names that users type and read. None of them goes
# away or changes without a line in the CHANGELOG.

"""
HELP = ("-h", "--help")  # of every command
COMPARISON_MEMBERS = (
    "table", "values", "differences", "misfits",
    "sentence", "headline", "protection", "notes",
    "figures", "figure", "data", "caption",
    "truncated",
)  # fmt: skip
MODULES = {"granwave": granwave, "granwave.measures": measures, "granwave.theory": theory}


def commands() -> dict[str, list[str]]:
    """Options of each command: words that are typed, and names of arguments."""
    actions = make_parser()._actions
    verbs = next(action for action in actions if isinstance(action, argparse._SubParsersAction))
    return {name: options(parser) for name, parser in verbs.choices.items()}


def options(parser: argparse.ArgumentParser) -> list[str]:
    """Options of one command, in the order of its help."""
    words: list[str] = []
    for action in parser._actions:
        words += action.option_strings or [str(action.metavar or action.dest)]
    return [word for word in words if word not in HELP]


def keys() -> dict[str, dict[str, list[str]]]:
    """Keys of each table of each kind of file."""
    files: dict[str, dict[str, list[str]]] = {}
    for table in tables():
        names = [key.name for key in table.keys]
        files.setdefault(table.file, {})[table.heading or "top level"] = names
    return files


def quantities() -> dict[str, list[str]]:
    """Values of the summary of each kind of result."""
    tables = {"run": entries()}
    for kind in report_kinds():
        tables |= kind.tables
    return {name: [*map(attrgetter("name"), table)] for name, table in tables.items()}


def figures() -> dict[str, list[str]]:
    """Figures of each kind of result; of scans the beginnings of their names."""
    return {
        "run": list(figure_names()),
        "continuum": list(PUNCH_FIGURES),
        "sphere-contact": list(CONTACT_FIGURES),
        "inference": list(INFERENCE_FIGURES),
        **{kind: list(functions) for kind, functions in SPECTRA_FIGURES.items()},
        "scan": list(all_scan_figures()),
    }


def built_in() -> dict[str, list[str]]:
    """Names of cases, scans, studies and materials that come with the package."""
    return {
        "cases": sorted(library.names()),
        "scans": sorted(library.names(library.SCANS)),
        "studies": sorted({*STUDIES, *COMPARISON}),
        "materials": sorted(presets()),
    }


def python() -> dict[str, list[str]]:
    """Public names of each module, parameters of its functions, members of its classes."""
    return {name: sorted(names_of(module)) for name, module in MODULES.items()}


def names_of(module: ModuleType) -> Iterable[str]:
    """Iterate over the public names of a module: ``run(case, ranks)``, ``Run``, ``Run.case``."""
    for name in module.__all__:
        value = getattr(module, name)
        if inspect.isclass(value):
            yield name
            yield from (f"{name}.{member}" for member in members(value))
        elif inspect.isfunction(value):
            yield f"{name}({', '.join(inspect.signature(value).parameters)})"
        else:
            yield name


def members(cls: type) -> set[str]:
    """Public attributes and methods of a class that the package defines, fields included.

    Of a case only its tables and the methods that write it, and of a comparison only the members
    that the page "Compatibility" names; their other attributes are internal.
    """
    if cls is granwave.Case:
        return {*tables_of_a_case(), "name", "to_dict", "to_toml"}
    if cls is granwave.Comparison:
        return set(COMPARISON_MEMBERS)
    own = [base for base in cls.__mro__ if base.__module__.startswith("granwave")]
    words: set[str] = set()
    for base in own:
        words.update(vars(base))
        words.update(vars(base).get("__annotations__", {}))
    return {word for word in words if not word.startswith("_")}


def tables_of_a_case() -> set[str]:
    """Attributes of a case that are tables of its file."""
    present = {field.name for field in dataclasses.fields(granwave.Case)}
    headings = (heading.strip("[]").partition(".")[0] for heading in keys()["case"])
    return present.intersection(headings)


def names() -> dict[str, Any]:
    """All names, in the form of `NAMES`."""
    return {
        "commands": commands(),
        "keys": keys(),
        "quantities": quantities(),
        "figures": figures(),
        "built_in": built_in(),
        "python": python(),
    }


def kept() -> dict[str, Any]:
    """Content of `NAMES`."""
    return tomllib.loads(NAMES.read_text(encoding="utf-8"))


def flat(content: Any, path: str = "") -> set[str]:
    """Names with the tables that contain them: ``commands: run: --np``."""
    if isinstance(content, str):
        return {f"{path}{content}"}
    if isinstance(content, list):
        return {f"{path}{word}" for word in content}
    parts = [flat(value, f"{path}{key}: ") for key, value in content.items()]
    return set().union(*parts)


def write() -> None:
    """Write `NAMES` anew."""
    NAMES.write_text(HEADING + tomli_w.dumps(names()), encoding="utf-8")


if __name__ == "__main__":
    sys.exit(write())
