"""The commands of granwave and their options, as ``granwave --help`` lists them."""

from __future__ import annotations

import argparse
import difflib
import re
from typing import NoReturn

from granwave import __version__
from granwave.lammps_inputs.case.schema import printable, show
from granwave.workflows.cli.options import contacts, package, results, runs, small_waves

WRONG_INPUT = 2  # exit status

_COMMANDS = (
    runs.add_run,
    runs.add_write,
    runs.add_analyse,
    runs.add_scan,
    runs.add_continuum,
    small_waves.add_bands,
    small_waves.add_modes,
    small_waves.add_transmission,
    results.add_report,
    results.add_figures,
    results.add_view,
    results.add_film,
    results.add_export,
    runs.add_check,
    package.add_show,
    package.add_keys,
    contacts.add_law,
    contacts.add_fit,
    contacts.add_infer,
    package.add_bench,
    package.add_cases,
    package.add_doctor,
    package.add_completion,
)


def make_parser() -> argparse.ArgumentParser:
    """Make the parser of all commands."""
    parser = _Parser(prog="granwave", description="Impact and waves in ordered granular packings, on LAMMPS.")
    parser.add_argument("--version", action="version", version=f"granwave {__version__}")
    verbs = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for add in _COMMANDS:
        add(verbs)
    return parser


class _Parser(argparse.ArgumentParser):
    """Parser that reports errors in one line, like other errors."""

    def error(self, message: str) -> NoReturn:
        choice = re.fullmatch(r"argument (\S+): invalid choice: '(.*?)' \(choose from (.*)\)", message, re.DOTALL)
        if choice:
            name, found, listed = choice.groups()
            options = re.findall(r"[\w-]+", listed)
            near = difflib.get_close_matches(found.lower(), options, n=1)
            hint = f"; did you mean {near[0]}?" if near else ""
            message = f"{name}: found {show(found)}, expected one of {', '.join(options)}{hint}"
        elif message.startswith("unrecognized arguments: "):
            message += "; keys of a case are set by --set KEY=VALUE"
        message = message.removeprefix("argument ")
        help_text = "" if "found " in message else f"; {self.prog} --help tells more"
        self.exit(WRONG_INPUT, f"granwave: {printable(' '.join(message.split()))}{help_text}\n")
