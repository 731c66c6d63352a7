"""Options of the commands that run cases and scans, or say what a run would be."""

from __future__ import annotations

import argparse

from granwave.workflows.cli import commands
from granwave.workflows.cli.arguments import input_name, output_name, positive, seconds
from granwave.workflows.cli.options import shared


def add_run(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave run``."""
    parser = shared.command(verbs, "run", commands.run, "run a case: deck, LAMMPS, analysis, figures")
    shared.case(parser)
    shared.output_directory(parser)
    shared.ranks(parser)
    parser.add_argument(
        "--checkpoint",
        type=seconds,
        default=60.0,
        metavar="SECONDS",
        help="wall time between checkpoints (default: 60)",
    )
    shared.no_figures(parser)
    shared.as_json(parser, "the summary")
    shared.resume_or_force(parser)


def add_write(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave write``."""
    parser = shared.command(
        verbs, "write", commands.write, "write the LAMMPS deck alone; it runs by hand: lmp -in in.granwave"
    )
    shared.case(parser)
    parser.add_argument(
        "-o", dest="directory", type=output_name, metavar="DIR", required=True, help="where the deck goes; required"
    )
    parser.add_argument("--force", action="store_true", help="replace what is there")


def add_analyse(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave analyse``."""
    parser = shared.command(
        verbs, "analyse", commands.analyse, "once more from the dumps: result.h5, figures, summary.json"
    )
    parser.add_argument("directory", type=input_name, metavar="DIR", help="directory of a run")
    shared.no_figures(parser)
    shared.as_json(parser, "the summary")


def add_scan(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave scan``."""
    parser = shared.command(
        verbs, "scan", commands.scan, "run a case many times with some keys varied; table, figures and report"
    )
    parser.add_argument("scan", metavar="SCAN", help="a scan file, or the name of a built-in scan")
    shared.overrides(parser)
    shared.output_directory(parser)
    parser.add_argument(
        "--executor", default="local", metavar="local|slurm", help="where the points run (default: local)"
    )
    parser.add_argument(
        "--profile", type=input_name, metavar="FILE", help="how to use the cluster: partition, account, time, ..."
    )
    parser.add_argument(
        "--jobs",
        type=positive,
        metavar="N",
        help="jobs at once (default: the cores of this machine; 100 on a cluster)",
    )
    parser.add_argument("--plan", action="store_true", help="say what the scan would be, and run nothing")
    shared.as_json(parser, "the plan, or at the end all points and their values,")
    shared.resume_or_force(parser)


def add_continuum(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave continuum``."""
    parser = shared.command(
        verbs, "continuum", commands.continuum, "the continuum reference: a rigid punch on an elastic-plastic block"
    )
    shared.case(parser)
    shared.output_directory(parser)
    shared.no_figures(parser)
    shared.as_json(parser, "the summary")
    shared.resume_or_force(parser)


def add_check(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave check``."""
    parser = shared.command(
        verbs, "check", commands.check, "what a run would be: size, memory, disk, timestep, time, overlap"
    )
    shared.case(parser)
    shared.ranks(parser)
    shared.as_json(parser, "the plan")
