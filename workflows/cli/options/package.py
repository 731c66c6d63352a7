"""Options of the commands about the package: built-in cases, keys, speed, installation."""

from __future__ import annotations

import argparse

from granwave.workflows import bench
from granwave.workflows.cli import commands
from granwave.workflows.cli.arguments import bench_parts, input_name, output_name, positive
from granwave.workflows.cli.options import shared
from granwave.workflows.cli.shells import SHELLS


def add_show(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave show``."""
    parser = shared.command(verbs, "show", commands.show, "an editable copy of a built-in study, on stdout")
    parser.add_argument("name", metavar="NAME", help="name of a built-in case or scan")


def add_keys(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave keys``."""
    parser = shared.command(verbs, "keys", commands.keys, "keys of all files: unit, default, accepted values, example")
    parser.add_argument(
        "table",
        nargs="*",
        metavar="TABLE",
        help="a table, as packing; a key, as packing.diameter; or words of keys or descriptions (default: a list)",
    )

    shared.as_json(parser, "the tables and their keys")


def add_bench(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave bench``."""
    parser = shared.command(
        verbs, "bench", commands.bench, "speed beside LAMMPS's own granular styles, on this machine"
    )
    parser.add_argument("--json", type=output_name, metavar="FILE", help="write the results there too")
    parser.add_argument("--repeats", type=positive, default=5, metavar="N", help="timings of each (default: 5)")
    parts = parser.add_mutually_exclusive_group()
    parts.add_argument(
        "--parts",
        type=bench_parts,
        default=bench.PARTS,
        metavar="PART,...",
        help=f"what to measure: {', '.join(bench.PARTS)} (default: all, some ten minutes)",
    )
    parts.add_argument(
        "--styles-only", action="store_const", const=("styles",), dest="parts", help="the same as --parts styles"
    )


def add_cases(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave cases``."""
    parser = shared.command(verbs, "cases", commands.cases, "the studies that come with the package")
    parser.add_argument(
        "words", nargs="*", metavar="WORD", help="list only those whose name or title has all these words"
    )
    parser.add_argument("--all", action="store_true", help="list all, with what each is")
    shared.as_json(parser, "the list")


def add_help(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave help``."""
    parser = shared.command(verbs, "help", commands.show_help, "this list, or the options of a command")
    parser.add_argument("name", nargs="?", choices=[*verbs.choices], metavar="COMMAND", help="name of a command")


def add_doctor(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave doctor``."""
    parser = shared.command(
        verbs, "doctor", commands.doctor, "versions, plugin, MPI: what works and how to mend what does not"
    )
    parser.add_argument(
        "--profile", type=input_name, metavar="FILE", help="also check the profile of a cluster, on its login node"
    )
    shared.as_json(parser, "the findings")


def add_completion(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave completion``."""
    parser = shared.command(verbs, "completion", commands.completion, "code that switches on tab completion in a shell")
    parser.add_argument("shell", choices=SHELLS, help="the shell: bash, zsh or fish")
