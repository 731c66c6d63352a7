"""Commands that show finished runs: reports, figures and exports; each returns the exit status."""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.case.figures import NO_NORMAL, Figures, figure_names
from granwave.lammps_inputs.case.schema import (
    ValidationError,
    declared_fields,
    did_you_mean,
    info_of,
)
from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import EXPORT_DIRECTORY
from granwave.workflows.cli.commands import FIGURE_KEYS
from granwave.workflows.run.directory import held


@contextlib.contextmanager
def as_wrong_input() -> Iterator[None]:
    """Raise InputError for results that are missing or damaged."""
    from granwave.analysis.errors import MissingOutputError, OutputFormatError

    try:
        yield
    except (MissingOutputError, OutputFormatError) as error:
        raise InputError(str(error)) from None


def existing(directory: Path, expected: str = "run a case in this directory first") -> Path:
    """Return a directory; raise InputError if there is none."""
    if not directory.is_dir():
        raise InputError(f"{directory}: no such directory; {expected}")
    return directory


def report(options: argparse.Namespace) -> int:
    """Execute ``granwave report``."""
    from granwave.analysis.reports.report import write_report

    print(write_report(options.directories, options.output, options.study))
    return 0


def export(options: argparse.Namespace) -> int:
    """Execute ``granwave export``."""
    from granwave.analysis.exports.export import export as export_directory
    from granwave.analysis.exports.selection import selection

    output = options.output or options.directory / EXPORT_DIRECTORY
    existing(options.directory, "expected the directory of a run or a scan")
    selected = selection(
        options.spheres, options.layers, options.depth, options.region, options.time
    )
    with held(ResultDirectory(results_directory(output))):
        placed = export_directory(
            options.directory, options.to, options.output, options.only or (), selected
        )
    for path in placed:
        print(path)
    return 0


def figures(options: argparse.Namespace) -> int:
    """Execute ``granwave figures``."""
    from granwave.analysis.figures.side_by_side import helpers, number_expected

    wanted = _names_of_figures(options)
    results = ResultDirectory(existing(options.directory))
    with (
        held(results, way=""),
        as_wrong_input(),
        helpers(number_expected(Figures(all=options.all), wanted)) as others,
    ):
        # loaded while the helpers load them too
        from granwave.analysis.figures.run_figures import draw_figures, why_not_drawn
        from granwave.analysis.figures.style import FigureFolder
        from granwave.analysis.result.reader import Result

        with Result(results) as result:
            changed = apply_options(options, result.figure_options)
        if options.all:
            changed = dataclasses.replace(changed, all=True, only=())
        if changed.plane is None and (
            cut := [name for name in wanted or () if name.endswith("_section")]
        ):
            raise InputError(
                f"--only: {', '.join(cut)}: requires a plane; set --plane x, or figures.plane of "
                "the case"
            )
        drawn = draw_figures(results, names=wanted, helpers=others, options=changed)
    for path in drawn:
        print(path)
    failed = FigureFolder(results).not_drawn()
    if failed.keys() & set(wanted or failed):
        return 1
    if options.all:
        return 0
    if left := [name for name in wanted or () if name not in {path.stem for path in drawn}]:
        raise InputError([f"--only: {name}: {why_not_drawn(name)}" for name in left])
    return 0


def _names_of_figures(options: argparse.Namespace) -> tuple[str, ...] | None:
    """Return the names of the figures on the command line; None if it names none.

    Raises
    ------
    InputError
        There is no figure of a name, or names come together with ``--all``.
    """
    names = (*options.names, *(options.only or ()))
    unknown = [name for name in names if name not in figure_names()]
    if unknown:
        expected = f"; expected one or more of {', '.join(figure_names())}"
        hint = did_you_mean(unknown[0], figure_names()) or expected
        where = "--only: " if unknown[0] in (options.only or ()) else ""
        raise InputError(f"{where}unknown figure {unknown[0]}{hint}")
    if names and options.all:
        raise InputError("--all: draws all figures; remove it, or the names of figures")
    return tuple(dict.fromkeys(names)) or None


# ---------------------------------------------------------------------- options of figures


def apply_options(options: argparse.Namespace, given: Figures, *names: str) -> Figures:
    """Return the options of figures with the changes of the command line, in keys ``names``, by
    default `FIGURE_KEYS`.

    Raises
    ------
    InputError
        A value is invalid; the message lists all faults.
    """
    types = {name: info_of(field).type for name, field in declared_fields(Figures).items()}
    changes = {}
    faults = []
    for name in names or FIGURE_KEYS:
        text = getattr(options, name)
        through = options.through
        if text is None:
            continue
        try:
            changes[name] = types[name].read(_value(name, text, through))
        except ValidationError as error:
            option = FIGURE_KEYS[name].names[0]
            if name == "plane" and through is not None:
                option = f"{option} --through"
                text = f"{text} and {through}"
            faults.append(f"{option}: found {text}, expected {_in_words(name, error.expected)}")
    if options.through is not None and options.plane is None:
        faults.append("--through: requires --plane, whose point it sets")
    if faults:
        raise InputError(faults)
    return dataclasses.replace(given, **changes)


def _value(name: str, text: str, through: str | None) -> Any:
    """Return the value of a key as in a case file."""
    if name == "formats":
        return [] if text == "none" else text.split(",")
    value = _toml(text) if name != "colour_map" else text
    if name == "depths" and not isinstance(value, list):
        return [value]
    if name == "plane" and isinstance(value, list):
        value = {"normal": value}
    if name == "plane" and through is not None:
        if isinstance(value, str) and value in "xyz":
            value = {"normal": [float(value == axis) for axis in "xyz"]}
        value = {**value, "through": _toml(through)} if isinstance(value, dict) else value
    return value


def _toml(text: str) -> Any:
    """Read a number, or numbers separated by commas; other texts are unchanged."""
    try:
        values = tomllib.loads(f"value = [{text}]")["value"]
    except ValueError:
        return text
    return values[0] if len(values) == 1 else values


def _in_words(name: str, expected: str) -> str:
    """Return the expected values of a key, in the notation of the command line."""
    if name == "plane" and expected != NO_NORMAL:
        return (
            "x, y, z, or the three components of a normal, such as 1,1,0; --through requires "
            "three numbers in m"
        )
    if name.endswith("limits"):
        return f"{expected}, such as 0.1,100"
    if name == "depths":
        return "depths above 0 in m, such as 0.02,0.05"
    return expected
