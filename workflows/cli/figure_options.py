"""Options of ``granwave figures`` and ``granwave film``: the keys of ``[figures]``, as texts of the command line."""

from __future__ import annotations

import argparse
import dataclasses
import tomllib
from typing import Any

from granwave.lammps_inputs.case.run import Figures
from granwave.lammps_inputs.case.schema import ValidationError
from granwave.lammps_inputs.errors import InputError

#: Keys that have an option, with its metavar and what it says in the help.
OPTIONS = {
    "plane": ("x|y|z|X,Y,Z", "normal of a plane of your own through the struck sphere; its figures end in _section"),
    "colour_map": ("NAME", "colour map of matplotlib, for all figures that have one"),
    "force_limits": ("LOW,HIGH", "ends of the colour scale of forces, in the unit of the figure"),
    "dissipation_limits": ("LOW,HIGH", "ends of the colour scale of dissipation, over the energy input"),
    "width": ("METRES", "width of a figure of one column (default: 0.08636)"),
    "formats": ("NAME,...", "files besides PNG and CSV: pdf, svg, pdf,svg or none (default: pdf)"),
}
#: Those of films.
FILM_OPTIONS = ("plane", "colour_map", "force_limits", "dissipation_limits")


def add_options(parser: argparse.ArgumentParser, *names: str) -> None:
    """Add options for keys of ``[figures]``, by default for all of `OPTIONS`."""
    for name in names or OPTIONS:
        metavar, what = OPTIONS[name]
        parser.add_argument(f"--{name.replace('_', '-')}", dest=name, metavar=metavar, help=what)
        if name == "plane":
            parser.add_argument("--through", metavar="X,Y,Z", help="a point of that plane, m (default: struck sphere)")


def apply_options(options: argparse.Namespace, given: Figures, *names: str) -> Figures:
    """Return the options of figures with the changes that the command line makes; ``names`` as in `add_options`.

    Raises
    ------
    InputError
        A value is wrong; the message lists all faults.
    """
    fields = {field.name: field for field in dataclasses.fields(Figures)}
    changes, faults = {}, []
    for name in names or OPTIONS:
        text = getattr(options, name, None)
        if text is None:
            continue
        try:
            changes[name] = fields[name].metadata["parse"](_value(name, text, getattr(options, "through", None)))
        except ValidationError as error:
            option, through = f"--{name.replace('_', '-')}", getattr(options, "through", None)
            if name == "plane" and through is not None:
                option, text = f"{option} --through", f"{text} and {through}"
            faults.append(f"{option}: found {text}, expected {_in_words(name, str(error))}")
    if getattr(options, "through", None) is not None and getattr(options, "plane", None) is None:
        faults.append("--through: it is a point of the plane of --plane, which is not given")
    if faults:
        raise InputError(faults)
    return dataclasses.replace(given, **changes)


def _value(name: str, text: str, through: str | None) -> Any:
    """Return the value of a key as in a case file."""
    if name == "formats":
        return [] if text == "none" else text.split(",")
    value = _toml(text) if name != "colour_map" else text
    if name == "plane" and isinstance(value, list):
        value = {"normal": value}
    if name == "plane" and through is not None:
        if isinstance(value, str) and value in "xyz":
            value = {"normal": [float(value == axis) for axis in "xyz"]}
        value = {**value, "through": _toml(through)} if isinstance(value, dict) else value
    return value


def _toml(text: str) -> Any:
    """Read a number, or numbers with commas between them; other texts stay as they are."""
    try:
        values = tomllib.loads(f"value = [{text}]")["value"]
    except ValueError:
        return text
    return values[0] if len(values) == 1 else values


def _in_words(name: str, expected: str) -> str:
    """Return what a key expects, as the command line writes it."""
    if name == "plane" and expected.startswith('"x"'):
        return "x, y, z, or the three numbers of a normal, as 1,1,0; --through takes three numbers in m"
    if name.endswith("limits"):
        return f"{expected}, as 0.1,100"
    return expected
