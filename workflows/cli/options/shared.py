"""Options that several commands have."""

from __future__ import annotations

import argparse

from granwave.workflows.cli.arguments import output_name, positive


def source(parser: argparse.ArgumentParser) -> None:
    """Add the case file or run that a command reads, with overrides."""
    parser.add_argument(
        "case", metavar="CASE", help="a case file, the name of a built-in study, or the directory of a finished run"
    )
    overrides(parser)


def allow_floppy(parser: argparse.ArgumentParser) -> None:
    """Add ``--allow-floppy``."""
    parser.add_argument("--allow-floppy", action="store_true", help="go on where grains can move without resistance")


def command(verbs: argparse._SubParsersAction, name: str, function: object, what: str) -> argparse.ArgumentParser:
    """Add a command; return the parser of its options."""
    parser: argparse.ArgumentParser = verbs.add_parser(name, help=what, description=what)
    parser.set_defaults(command=function)
    return parser


def case(parser: argparse.ArgumentParser) -> None:
    """Add the case that a command reads, with overrides."""
    parser.add_argument("case", metavar="CASE", help="a case file, or the name of a built-in study")
    overrides(parser)


def overrides(parser: argparse.ArgumentParser) -> None:
    """Add ``--set``."""
    parser.add_argument(
        "--set",
        dest="overrides",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="override a key: --set load.velocity=10 --set packing.size=[24,24,12] (may be repeated)",
    )


def output_directory(parser: argparse.ArgumentParser) -> None:
    """Add ``-o DIR``."""
    parser.add_argument(
        "-o", dest="directory", type=output_name, metavar="DIR", help="where everything goes (default: ./NAME)"
    )


def ranks(parser: argparse.ArgumentParser) -> None:
    """Add ``--np N``."""
    parser.add_argument("--np", type=positive, default=1, metavar="N", help="number of MPI ranks (default: 1)")


def resume_or_force(parser: argparse.ArgumentParser) -> None:
    """Add ``--resume`` and ``--force``."""
    again = parser.add_mutually_exclusive_group()
    again.add_argument("--resume", action="store_true", help="go on with what is there")
    again.add_argument("--force", action="store_true", help="replace what is there")


def as_json(parser: argparse.ArgumentParser, what: str) -> None:
    """Add ``--json``; ``what`` is printed."""
    parser.add_argument("--json", action="store_true", help=f"print {what} as JSON, and nothing else")


def no_figures(parser: argparse.ArgumentParser) -> None:
    """Add ``--no-figures``."""
    parser.add_argument("--no-figures", dest="figures", action="store_false", help="leave the figures out")
