"""Options of the commands for small waves about a static state."""

from __future__ import annotations

import argparse

from granwave.analysis.spectra.quantities import MOST_BANDS, MOST_MODES, POINTS
from granwave.workflows.cli import spectra
from granwave.workflows.cli.arguments import output_name, positive
from granwave.workflows.cli.options import shared


def add_bands(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave bands``."""
    parser = shared.command(
        verbs, "bands", spectra.bands, "bands of an endless packing under a static load: gaps, speeds, modes"
    )
    shared.source(parser)
    parser.add_argument(
        "--path",
        default="",
        metavar="PATH",
        help='wave vectors in rad/m, "0,0,0; 0,0,314", or points of the Brillouin zone, G-X-M-G (default: standard)',
    )
    parser.add_argument(
        "--points", type=positive, default=POINTS, metavar="N", help=f"wave vectors a stretch (default: {POINTS})"
    )
    parser.add_argument(
        "--bands",
        type=positive,
        metavar="N",
        help=f"how many bands (default: all of a small cell, {MOST_BANDS} of a large one)",
    )
    parser.add_argument(
        "--plane", default="", metavar="NAME", help="plane of slowness and equal-frequency curves: xy, xz or yz"
    )
    parser.add_argument(
        "--slab",
        action="store_true",
        help="the packing as it ends above and below, with its wall or held layer; sides periodic: surface waves",
    )
    shared.allow_floppy(parser)
    _alike(parser)


def add_modes(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave modes``."""
    parser = shared.command(
        verbs, "modes", spectra.modes, "modes of a finite packing under a static load, density of states"
    )
    shared.source(parser)
    parser.add_argument(
        "--modes",
        type=positive,
        metavar="N",
        help=f"how many modes (default: all of a small packing, {MOST_MODES} of a large one)",
    )
    shared.allow_floppy(parser)
    _alike(parser)


def add_transmission(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave transmission``."""
    parser = shared.command(
        verbs, "transmission", spectra.transmission, "steady response of a finite packing to a grain that is shaken"
    )
    shared.source(parser)
    parser.add_argument(
        "--drive",
        type=spectra.ids,
        required=True,
        metavar="ID",
        help="grain that is shaken, or several, with commas, that are shaken alike; required",
    )
    parser.add_argument("--sensor", type=spectra.ids, required=True, metavar="ID,...", help="grains that are watched")
    parser.add_argument(
        "--frequencies",
        type=spectra.frequencies,
        required=True,
        metavar="F,...",
        help="frequencies in Hz, or START:END:COUNT; required",
    )
    parser.add_argument("--axis", default="", metavar="AXIS", help="direction of the motion, x, y or z (default: z)")
    parser.add_argument(
        "--end",
        default="",
        metavar="END",
        help="far end: reflecting, matched (as if it went on) or layer:N, N grains damped (default: reflecting)",
    )
    _alike(parser)


def _alike(parser: argparse.ArgumentParser) -> None:
    """Add the options that all of them have."""
    parser.add_argument(
        "--directions",
        default="",
        metavar="XYZ",
        help="directions in which grains move (default: those of the packing, z for a chain)",
    )
    parser.add_argument(
        "-o", dest="directory", type=output_name, metavar="DIR", help="where everything goes (default: ./NAME-...)"
    )
    shared.no_figures(parser)
    shared.as_json(parser, "the summary")
    parser.add_argument("--force", action="store_true", help="replace what is there")
