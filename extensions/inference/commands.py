"""Command of measured grains: ``granwave infer``."""

from __future__ import annotations

import argparse
import math

from granwave.workflows.cli import arguments as read
from granwave.workflows.cli.commands import (
    CONTACTS,
    FORCE,
    NO_FIGURES,
    Command,
    as_json,
    directory,
    option,
)

hertz = read.number_that("a number above 0 (Hz)", lambda value: 0 < value < math.inf)


def shares(text: str) -> tuple[float, ...]:
    """Read fractions, 0 or from 1e-12 to 10, separated by commas."""
    found = tuple(read.number(word) for word in read.words(text))
    if not all(value == 0 or 1e-12 <= value <= 10 for value in found):
        raise argparse.ArgumentTypeError(
            f"found {text}, expected 0, or shares from 1e-12 to 10, such as 0.05 for 5 %"
        )
    return found


COMMANDS = (
    Command(
        "infer",
        CONTACTS,
        "infer contact forces from measured grains, or from synthetic measurements of a run",
        "granwave.extensions.inference.terminal:infer",
        (
            option(
                "measurement",
                type=read.input_name,
                metavar="GRAINS.csv|RUN",
                help="table of measured grains; or directory of a run with "
                "output.contact_forces, to plan an experiment",
            ),
            option(
                "--case",
                type=read.input_name,
                metavar="FILE",
                help="file with [material] and [infer]; optional for a run",
            ),
            option(
                "--noise",
                type=shares,
                metavar="SHARE,...",
                help="errors of strains and accelerations of a run, relative to their root mean "
                "squares; several values for a curve",
            ),
            option(
                "--frame-rate",
                type=hertz,
                metavar="HZ",
                help="derive the accelerations of a run from positions in three frames of a "
                "camera with this rate",
            ),
            option(
                "--position-noise",
                type=read.radius,
                metavar="M",
                help="errors of the positions in these frames (default: none)",
            ),
            option(
                "--time",
                type=read.number,
                metavar="S",
                help="instant of a run (default: the snapshot with the largest forces)",
            ),
            option(
                "--repeat",
                type=read.count,
                metavar="N",
                help="repetitions with noise (default: infer.repetitions; for a run 10)",
            ),
            directory(),
            NO_FIGURES,
            as_json("the summary"),
            FORCE,
        ),
    ),
)
