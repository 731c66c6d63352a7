"""Command of searches for a design: ``granwave design``."""

from __future__ import annotations

from granwave.workflows.cli import arguments as read
from granwave.workflows.cli.commands import (
    CHAIN,
    PRINT,
    RANKS,
    RESUME_OR_FORCE,
    RUNNING,
    SUBMIT,
    Command,
    as_json,
    directory,
    option,
)

COMMANDS = (
    Command(
        "design",
        RUNNING,
        "optimise a packing: variables, limits, objective, checks of the best design",
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
                help="number of simultaneous runs (default: the cores of this machine)",
            ),
            option(
                "--budget",
                type=read.positive,
                metavar="N",
                help="number of designs to run; overrides search.evaluations of the file",
            ),
            SUBMIT,
            CHAIN,
            PRINT,
            as_json("the best design and its checks"),
            RESUME_OR_FORCE,
        ),
        after="scan",
    ),
)
