"""Command of searches for a design: ``granwave design``."""

from __future__ import annotations

from granwave.workflows.cli import arguments as read
from granwave.workflows.cli.commands import (
    RANKS,
    RESUME_OR_FORCE,
    RUNNING,
    Command,
    as_json,
    directory,
    option,
)

COMMANDS = (
    Command(
        "design",
        RUNNING,
        "search for the best packing: variables, limits, an objective, checks of the best",
        "granwave.extensions.design.terminal:design",
        (
            option(
                "file",
                type=read.input_name,
                metavar="FILE",
                help="a design file: base, variables, limits, objective",
            ),
            directory(),
            RANKS,
            option(
                "--jobs",
                type=read.positive,
                metavar="N",
                help="runs at once (default: the cores of this machine)",
            ),
            option(
                "--budget",
                type=read.positive,
                metavar="N",
                help="designs to run, in place of search.evaluations of the file",
            ),
            as_json("the best design and its checks"),
            RESUME_OR_FORCE,
        ),
        after="scan",
    ),
)
