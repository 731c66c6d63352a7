"""Commands of small waves: ``granwave bands``, ``modes`` and ``transmission``."""

from __future__ import annotations

import argparse
import re
from typing import TYPE_CHECKING

from granwave.extensions.waves.spectra.defaults import (
    LARGE,
    MOST_BANDS,
    MOST_MODES,
    POINTS,
    POINTS_OF_LARGE,
)
from granwave.lammps_inputs.files import read_number, read_whole
from granwave.workflows.cli import arguments as read
from granwave.workflows.cli.commands import (
    FORCE,
    NO_FIGURES,
    SET,
    SOURCE,
    Command,
    as_json,
    directory,
    flag,
    option,
)

if TYPE_CHECKING:
    import numpy
    from numpy.typing import NDArray

_ID = re.compile("[0-9]+")
_MOST_FREQUENCIES = 1_000_000  # most frequencies of START:END:COUNT


def ids(text: str) -> list[int]:
    """Read ids that are separated by commas."""
    found = text.split(",")
    if not all(_ID.fullmatch(one.strip()) and int(one) > 0 for one in found):
        raise argparse.ArgumentTypeError(
            f"found {text or 'nothing'}, expected ids from 1 up with commas between them"
        )
    return [int(one) for one in found]


def frequencies(text: str) -> NDArray[numpy.float64]:
    """Read frequencies, Hz: numbers separated by commas, or START:END:COUNT."""
    import numpy

    try:
        if ":" in text:
            start, end, count = text.split(":")
            points = read_whole(count)
            if not 1 <= points <= _MOST_FREQUENCIES:
                raise ValueError
            values = numpy.linspace(read_number(start), read_number(end), points)
        else:
            values = numpy.array([read_number(one) for one in text.split(",")])
    except ValueError:
        values = numpy.empty(0)
    if not len(values) or not numpy.isfinite(values).all() or (values < 0).any():
        raise argparse.ArgumentTypeError(
            f"found {text or 'nothing'}, expected numbers from 0 up with commas between them "
            f"(Hz), or START:END:COUNT with a COUNT from 1 to {_MOST_FREQUENCIES}"
        )
    return values


_GROUP = "small waves"
_ALLOW_FLOPPY = flag("--allow-floppy", "continue even if grains can move without resistance")
_OF_ALL = (
    option(
        "--directions",
        default="",
        metavar="XYZ",
        help="directions in which grains move (default: the directions of the packing, z for a chain)",
    ),
    directory("directory of the results (default: ./NAME-...)"),
    NO_FIGURES,
    as_json("the summary"),
    FORCE,
)
COMMANDS = (
    Command(
        "bands",
        _GROUP,
        "compute the bands of an infinite periodic packing under a static load: gaps, speeds, "
        "modes",
        "granwave.extensions.waves.terminal:bands",
        (
            SOURCE,
            SET,
            option(
                "--path",
                default="",
                metavar="PATH",
                help='wave vectors in rad/m, "0,0,0; 0,0,314", or points of the '
                "Brillouin zone, G-X-M-G (default: standard)",
            ),
            option(
                "--points",
                type=read.positive,
                metavar="N",
                help=f"wave vectors per stretch (default: {POINTS}; {POINTS_OF_LARGE} for a cell with "
                f"more than {LARGE} degrees of freedom)",
            ),
            option(
                "--bands",
                dest="n_bands",
                type=read.positive,
                metavar="N",
                help=f"number of bands (default: all for a small cell, {MOST_BANDS} for a large "
                "cell)",
            ),
            option(
                "--plane",
                default="",
                metavar="NAME",
                help="plane of slowness and equal-frequency curves: xy, xz or yz",
            ),
            flag(
                "--slab",
                "surface waves: keep the ends of the packing above and below, with its wall or "
                "fixed layer, and periodic sides",
            ),
            _ALLOW_FLOPPY,
            *_OF_ALL,
        ),
        after="export",
    ),
    Command(
        "modes",
        _GROUP,
        "compute the modes of a finite packing under a static load, and the density of states",
        "granwave.extensions.waves.terminal:modes",
        (
            SOURCE,
            SET,
            option(
                "--modes",
                dest="n_modes",
                type=read.positive,
                metavar="N",
                help=f"number of modes (default: all for a small packing, {MOST_MODES} for a "
                "large packing)",
            ),
            _ALLOW_FLOPPY,
            *_OF_ALL,
        ),
    ),
    Command(
        "transmission",
        _GROUP,
        "compute the steady response of a finite packing to a driven grain",
        "granwave.extensions.waves.terminal:transmission",
        (
            SOURCE,
            SET,
            option(
                "--drive",
                type=ids,
                required=True,
                metavar="ID",
                help="id of the driven grain, or several ids separated by commas for grains "
                "driven in phase; required",
            ),
            option(
                "--sensor",
                dest="sensors",
                type=ids,
                required=True,
                metavar="ID,...",
                help="ids of the sensor grains",
            ),
            option(
                "--frequencies",
                type=frequencies,
                required=True,
                metavar="F,...",
                help="frequencies in Hz, or START:END:COUNT; required",
            ),
            option(
                "--axis",
                default="",
                metavar="AXIS",
                help="direction of the motion, x, y or z (default: z)",
            ),
            option(
                "--end",
                default="",
                metavar="END",
                help="far end: reflecting, matched (non-reflecting) or layer:N, with N damped "
                "grains (default: reflecting)",
            ),
            *_OF_ALL,
        ),
    ),
)
