"""Options of the commands that show finished runs: reports, figures, films, exports."""

from __future__ import annotations

import argparse
from pathlib import Path

from granwave.workflows.cli import commands, pictures
from granwave.workflows.cli.arguments import input_name, number, output_name, positive, words
from granwave.workflows.cli.figure_options import FILM_OPTIONS, add_options
from granwave.workflows.cli.options import shared


def add_report(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave report``."""
    parser = shared.command(verbs, "report", commands.report, "a page that compares any number of runs and scans")
    parser.add_argument("directories", nargs="+", type=input_name, metavar="DIR", help="directories of runs and scans")
    parser.add_argument(
        "-o",
        dest="output",
        type=output_name,
        default=Path("report.html"),
        metavar="FILE",
        help="a file that ends in .html, .pdf or .md (default: report.html)",
    )
    parser.add_argument(
        "--study",
        action="append",
        default=[],
        metavar="NAME|FILE.py",
        help="a study to make of all runs, by name or in a file of yours, beside those that scan and suite files name; "
        "may be repeated",
    )


def add_figures(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave figures``."""
    parser = shared.command(verbs, "figures", pictures.figures, "draw the figures of a run again, all or some")
    parser.add_argument("directory", type=input_name, metavar="DIR", help="directory of a run")
    parser.add_argument(
        "--only", type=words, metavar="NAME,...", help="names of figures (default: those of the case, or all)"
    )
    add_options(parser)


def add_view(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave view``."""
    parser = shared.command(verbs, "view", pictures.view, "a page to turn and cut the packing of a run in a browser")
    parser.add_argument("directory", type=input_name, metavar="DIR", help="directory of a run")
    parser.add_argument(
        "-o", dest="output", type=output_name, metavar="FILE", help="name of the page, .html (default: DIR/view.html)"
    )
    shown = parser.add_mutually_exclusive_group()
    shown.add_argument(
        "--spheres",
        type=positive,
        metavar="N",
        help="at most so many spheres, those nearest to the struck one (default: 250000)",
    )
    shown.add_argument("--all", action="store_true", help="all spheres and snapshots, however many")
    parser.add_argument("--frames", type=positive, metavar="N", help="at most so many snapshots")


def add_film(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave film``."""
    parser = shared.command(
        verbs, "film", pictures.film, "a film of a run: planes, the cut packing, or a chain in space-time"
    )
    parser.add_argument("directory", type=input_name, metavar="DIR", help="directory of a run")
    parser.add_argument(
        "-o",
        dest="output",
        type=output_name,
        required=True,
        metavar="FILE",
        help="a file that ends in .mp4, .gif or .webp",
    )
    parser.add_argument(
        "--quantity",
        default="force",
        metavar="NAME",
        help="what is shown: force, velocity or dissipation (default: force)",
    )
    parser.add_argument(
        "--view",
        metavar="NAME",
        help="what is seen: orthogonal, principal, section, 3d or chain (default: what there is)",
    )
    sizes = parser.add_mutually_exclusive_group()
    sizes.add_argument(
        "--width", type=positive, default=1200, metavar="PIXELS", help="width of the pictures (default: 1200)"
    )
    sizes.add_argument(
        "--size", metavar="NAME|WxH", help="slide (1920x1080), page (1200x900), or width x height in pixels"
    )
    add_options(parser, *FILM_OPTIONS)
    parser.add_argument("--rate", type=number, metavar="N", help="pictures per second (default: 3 to 25)")


def add_export(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave export``."""
    parser = shared.command(
        verbs, "export", commands.export, "the results for other programs: ParaView, pandas, xarray, OVITO"
    )
    parser.add_argument("directory", type=input_name, metavar="DIR", help="directory of a run or a scan")
    parser.add_argument("--to", required=True, metavar="FORMAT", help="one of vtp, csv, netcdf, ovito")
    parser.add_argument("-o", dest="output", type=output_name, metavar="DIR", help="where to (default: DIR/export)")
