"""The command line.

Exit status: 0 done; 1 failed while running; 2 wrong input, nothing was run; 130 stopped by Ctrl-C; 141 the reader of
the output, such as another command in a pipe, has closed it.
"""

from __future__ import annotations

import argparse
import contextlib
import difflib
import errno
import io
import logging
import os
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from granwave import __version__
from granwave.lammps_inputs.case.contact import LAWS
from granwave.lammps_inputs.case.schema import printable, show
from granwave.lammps_inputs.errors import GranwaveError, InputError
from granwave.lammps_inputs.files import DISK_IS_FULL
from granwave.workflows import bench
from granwave.workflows.cli import commands, pictures, spectra
from granwave.workflows.cli.arguments import (
    bench_parts,
    count,
    hertz,
    input_name,
    number,
    output_name,
    overlap,
    positive,
    radius,
    seconds,
    shares,
    words,
)
from granwave.workflows.cli.figure_options import FILM_OPTIONS, add_options
from granwave.workflows.cli.shells import SHELLS
from granwave.workflows.run import mpi
from granwave.workflows.run.messages import each_warning_once, not_enough_memory

DONE, FAILED, WRONG_INPUT, STOPPED, READER_LEFT = 0, 1, 2, 130, 141

_LONGEST_SHOWN = 300  # characters of a path in a message
_NO_ROOM_FOR_LIBRARY = ("failed to map segment", "annot allocate memory")  # what the loader of libraries says
_OF_NAMES = (errno.ENAMETOOLONG, errno.ELOOP)  # errors of a path itself, which is wrong input


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    if "_ARGCOMPLETE" in os.environ:  # the shell asks for completions
        from granwave.workflows.cli.completion import complete

        complete(make_parser())
    words = list(sys.argv[1:] if arguments is None else arguments)
    _set_up_output()
    options = make_parser().parse_args(words)
    _set_up_logging()
    try:
        status = int(options.command(options, words))
        sys.stdout.flush()  # here, where an error can still be reported
        return status
    except InputError as error:
        return _report(error.errors, WRONG_INPUT)
    except GranwaveError as error:
        return _report([str(error)], FAILED)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # discards the rest of the output without an error
        return READER_LEFT
    except OSError as error:
        return _report_file(error, words)
    except MemoryError as error:
        return _report([not_enough_memory(str(error) or "none left")], FAILED)
    except ImportError as error:
        if any(words in str(error) for words in _NO_ROOM_FOR_LIBRARY):
            return _report([not_enough_memory(str(error))], FAILED)
        raise
    except KeyboardInterrupt:
        return _report(["stopped"], STOPPED)


def _set_up_output() -> None:
    """Make printing and drawing work independently of terminal and settings."""
    if sys.stdout is None:  # it was closed
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    os.environ["MPLBACKEND"] = "agg"  # figures go to files


def _report_file(error: OSError, words: Sequence[str]) -> int:
    """Report the error of a file; it counts as wrong input if the command line names the file."""
    try:
        named = [os.path.abspath(word) for word in words if word]
        wrong = error.errno in _OF_NAMES or (
            error.filename is not None and os.path.abspath(os.fsdecode(error.filename)) in named
        )
    except OSError:
        return _report(["the working directory does not exist any more; change to another"], WRONG_INPUT)
    # errors of writing name their file, see `granwave.lammps_inputs.files`
    name = error.filename or ("standard output" if error.errno in DISK_IS_FULL else "a file")
    shown = str(name) if len(str(name)) <= _LONGEST_SHOWN else f"{str(name)[:_LONGEST_SHOWN]}..."
    fault = f"{shown}: {error.strerror or error}"
    return _report([fault], WRONG_INPUT if wrong else FAILED)


def _set_up_logging() -> None:
    """Show granwave's messages from INFO, each warning once, and of libraries errors only.

    Of several ranks only the first shows messages below ERROR.
    """
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(_Messages())
    handler.addFilter(each_warning_once())
    logging.basicConfig(level=logging.ERROR, handlers=[handler])
    logging.getLogger("granwave").setLevel(logging.INFO if mpi.is_first() else logging.ERROR)


class _Messages(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        text = super().format(record)
        return f"granwave: warning: {text}" if record.levelno == logging.WARNING else text


def _report(lines: Sequence[str], status: int) -> int:
    if not mpi.launched() or mpi.world().rank == 0:
        with contextlib.suppress(OSError):  # standard error is closed
            for line in lines:
                print(f"granwave: {printable(line)}", file=sys.stderr)
    return status


def make_parser() -> argparse.ArgumentParser:
    """Make the parser of all commands."""
    parser = _Parser(prog="granwave", description="Impact and waves in ordered granular packings, on LAMMPS.")
    parser.add_argument("--version", action="version", version=f"granwave {__version__}")
    verbs = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")

    run = _verb(verbs, "run", commands.run, "run a case: deck, LAMMPS, analysis, figures")
    _case(run)
    _into(run)
    run.add_argument("--np", type=positive, default=1, metavar="N", help="number of MPI ranks (default: 1)")
    run.add_argument(
        "--checkpoint",
        type=seconds,
        default=60.0,
        metavar="SECONDS",
        help="wall time between checkpoints (default: 60)",
    )
    _figures(run)
    _json(run, "the summary")
    _again(run)

    write = _verb(verbs, "write", commands.write, "write the LAMMPS deck alone; it runs by hand: lmp -in in.granwave")
    _case(write)
    write.add_argument(
        "-o", dest="directory", type=output_name, metavar="DIR", required=True, help="where the deck goes; required"
    )
    write.add_argument("--force", action="store_true", help="replace what is there")

    analyse = _verb(verbs, "analyse", commands.analyse, "once more from the dumps: result.h5, figures, summary.json")
    analyse.add_argument("directory", type=input_name, metavar="DIR", help="directory of a run")
    _figures(analyse)
    _json(analyse, "the summary")

    scan = _verb(verbs, "scan", commands.scan, "run a case many times with some keys varied; table, figures and report")
    scan.add_argument("scan", metavar="SCAN", help="a scan file, or the name of a built-in scan")
    _overrides(scan)
    _into(scan)
    scan.add_argument(
        "--executor", default="local", metavar="local|slurm", help="where the points run (default: local)"
    )
    scan.add_argument(
        "--profile", type=input_name, metavar="FILE", help="how to use the cluster: partition, account, time, ..."
    )
    scan.add_argument(
        "--jobs",
        type=positive,
        metavar="N",
        help="jobs at once (default: the cores of this machine; 100 on a cluster)",
    )
    scan.add_argument("--plan", action="store_true", help="say what the scan would be, and run nothing")
    _json(scan, "the plan, or at the end all points and their values,")
    _again(scan)

    continuum = _verb(
        verbs, "continuum", commands.continuum, "the continuum reference: a rigid punch on an elastic-plastic block"
    )
    _case(continuum)
    _into(continuum)
    _figures(continuum)
    _json(continuum, "the summary")
    _again(continuum)

    _spectra(verbs)

    report = _verb(verbs, "report", commands.report, "a page that compares any number of runs and scans")
    report.add_argument("directories", nargs="+", type=input_name, metavar="DIR", help="directories of runs and scans")
    report.add_argument(
        "-o",
        dest="output",
        type=output_name,
        default=Path("report.html"),
        metavar="FILE",
        help="a file that ends in .html, .pdf or .md (default: report.html)",
    )
    report.add_argument(
        "--study",
        action="append",
        default=[],
        metavar="NAME",
        help="a study to make of all runs, beside those that scan and suite files name; may be repeated",
    )

    figures = _verb(verbs, "figures", pictures.figures, "draw the figures of a run again, all or some")
    figures.add_argument("directory", type=input_name, metavar="DIR", help="directory of a run")
    figures.add_argument(
        "--only", type=words, metavar="NAME,...", help="names of figures (default: those of the case, or all)"
    )
    add_options(figures)

    view = _verb(verbs, "view", pictures.view, "a page to turn and cut the packing of a run in a browser")
    view.add_argument("directory", type=input_name, metavar="DIR", help="directory of a run")
    view.add_argument(
        "-o", dest="output", type=output_name, metavar="FILE", help="name of the page, .html (default: DIR/view.html)"
    )
    shown = view.add_mutually_exclusive_group()
    shown.add_argument(
        "--spheres",
        type=positive,
        metavar="N",
        help="at most so many spheres, those nearest to the struck one (default: 250000)",
    )
    shown.add_argument("--all", action="store_true", help="all spheres and snapshots, however many")
    view.add_argument("--frames", type=positive, metavar="N", help="at most so many snapshots")

    film = _verb(verbs, "film", pictures.film, "a film of a run: planes, the cut packing, or a chain in space-time")
    film.add_argument("directory", type=input_name, metavar="DIR", help="directory of a run")
    film.add_argument(
        "-o",
        dest="output",
        type=output_name,
        required=True,
        metavar="FILE",
        help="a file that ends in .mp4, .gif or .webp",
    )
    film.add_argument(
        "--quantity",
        default="force",
        metavar="NAME",
        help="what is shown: force, velocity or dissipation (default: force)",
    )
    film.add_argument(
        "--view",
        metavar="NAME",
        help="what is seen: orthogonal, principal, section, 3d or chain (default: what there is)",
    )
    sizes = film.add_mutually_exclusive_group()
    sizes.add_argument(
        "--width", type=positive, default=1200, metavar="PIXELS", help="width of the pictures (default: 1200)"
    )
    sizes.add_argument(
        "--size", metavar="NAME|WxH", help="slide (1920x1080), page (1200x900), or width x height in pixels"
    )
    add_options(film, *FILM_OPTIONS)
    film.add_argument("--rate", type=number, metavar="N", help="pictures per second (default: 3 to 25)")

    export = _verb(verbs, "export", commands.export, "the results for other programs: ParaView, pandas, xarray, OVITO")
    export.add_argument("directory", type=input_name, metavar="DIR", help="directory of a run or a scan")
    export.add_argument("--to", required=True, metavar="FORMAT", help="one of vtp, csv, netcdf, ovito")
    export.add_argument("-o", dest="output", type=output_name, metavar="DIR", help="where to (default: DIR/export)")

    check = _verb(verbs, "check", commands.check, "what a run would be: size, memory, disk, timestep, time, overlap")
    _case(check)
    check.add_argument("--np", type=positive, default=1, metavar="N", help="number of MPI ranks (default: 1)")
    _json(check, "the plan")

    show = _verb(verbs, "show", commands.show, "an editable copy of a built-in study, on stdout")
    show.add_argument("name", metavar="NAME", help="name of a built-in case or scan")

    listing = _verb(verbs, "keys", commands.keys, "keys of all files: unit, default, accepted values, example")
    listing.add_argument(
        "table",
        nargs="*",
        metavar="TABLE",
        help="a table, as packing, or a key, as packing.diameter or packing diameter (default: a list)",
    )

    _json(listing, "the tables and their keys")

    law = _verb(verbs, "law", commands.law, "force-overlap curves of a contact: a plot or a table")
    law.add_argument(
        "--material", nargs="+", default=["brass"], metavar="M", help="one material or two (default: brass)"
    )
    law.add_argument(
        "--radius", nargs="+", type=radius, default=[0.005], metavar="R", help="one radius or two, m (default: 0.005)"
    )
    law.add_argument("--law", default="elastoplastic", choices=list(LAWS), help="contact law (default: elastoplastic)")
    law.add_argument(
        "--variant",
        default="continuous",
        choices=["continuous", "published"],
        help="constants of the elasto-plastic law, as contact.variant (default: continuous)",
    )
    law.add_argument(
        "--max-overlap",
        type=overlap,
        default=200.0,
        metavar="A",
        help="largest overlap, in units of that at first yield (default: 200)",
    )
    law.add_argument(
        "--restitution",
        action="store_true",
        help="coefficient of restitution against velocity instead, of two spheres and of a sphere and a rigid wall",
    )
    law.add_argument(
        "-o",
        dest="output",
        type=output_name,
        metavar="FILE",
        help="a file that ends in .png, .pdf or .csv (default: law.png, restitution.png)",
    )

    fit = _verb(verbs, "fit", commands.fit, "fit the contact law's constants to a measured or computed curve")
    fit.add_argument("curve", type=input_name, metavar="CURVE.csv", help="columns overlap_m, force_N, perhaps branch")
    fit.add_argument(
        "--material", nargs="+", default=["brass"], metavar="M", help="one or two: a name, or FILE.toml:NAME"
    )
    fit.add_argument(
        "--radius", nargs="+", type=radius, default=[0.005], metavar="R",
        help="one radius or two, m; the second may be inf, a plane (default: 0.005)",
    )  # fmt: skip
    fit.add_argument(
        "--free", nargs="+", metavar="NAME", help="constants to fit (default: all that the curve can tell)"
    )
    fit.add_argument(
        "--pair", nargs=2, metavar=("A", "B"), help="also write pair.toml: the law of these two materials in a case"
    )
    fit.add_argument("--fit-yield", action="store_true", help="fit the yield strength too")
    fit.add_argument(
        "-o", dest="directory", type=output_name, metavar="DIR", help="where everything goes (default: ./fit)"
    )
    fit.add_argument("--force", action="store_true", help="replace the fit that is there")

    infer = _verb(
        verbs, "infer", commands.infer, "contact forces from measured grains, or from measurements made of a run"
    )
    infer.add_argument(
        "measurement",
        type=input_name,
        metavar="GRAINS.csv|RUN",
        help="table of measured grains; or directory of a run with output.contact_forces, to plan an experiment",
    )
    infer.add_argument(
        "--case", type=input_name, metavar="FILE", help="file with [material] and [infer]; a run can do without"
    )
    infer.add_argument(
        "--noise",
        type=shares,
        metavar="SHARE,...",
        help="errors of strains and accelerations of a run, over their root mean squares; several for a curve",
    )
    infer.add_argument(
        "--frame-rate",
        type=hertz,
        metavar="HZ",
        help="accelerations of a run from the places in three frames of such a camera",
    )
    infer.add_argument(
        "--position-noise", type=radius, metavar="M", help="errors of the places in these frames (default: none)"
    )
    infer.add_argument(
        "--time", type=number, metavar="S", help="instant of a run (default: the snapshot with the largest forces)"
    )
    infer.add_argument(
        "--repeat", type=count, metavar="N", help="repetitions with noise (default: infer.repetitions; of a run 10)"
    )
    _into(infer)
    _figures(infer)
    _json(infer, "the summary")
    infer.add_argument("--force", action="store_true", help="replace what is there")

    timing = _verb(verbs, "bench", commands.bench, "speed beside LAMMPS's own granular styles, on this machine")
    timing.add_argument("--json", type=output_name, metavar="FILE", help="write the results there too")
    timing.add_argument("--repeats", type=positive, default=5, metavar="N", help="timings of each (default: 5)")
    parts = timing.add_mutually_exclusive_group()
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

    cases = _verb(verbs, "cases", commands.cases, "the studies that come with the package")
    cases.add_argument(
        "words", nargs="*", metavar="WORD", help="list only those whose name or title has all these words"
    )
    _json(cases, "the list")
    doctor = _verb(verbs, "doctor", commands.doctor, "versions, plugin, MPI: what works and how to mend what does not")
    doctor.add_argument(
        "--profile", type=input_name, metavar="FILE", help="also check the profile of a cluster, on its login node"
    )
    _json(doctor, "the findings")
    completion = _verb(verbs, "completion", commands.completion, "code that switches on tab completion in a shell")
    completion.add_argument("shell", choices=SHELLS, help="the shell: bash, zsh or fish")
    return parser


def _spectra(verbs: argparse._SubParsersAction) -> None:
    """Add the commands for small waves about a static state."""
    bands = _verb(verbs, "bands", spectra.bands, "bands of an endless packing under a static load: gaps, speeds, modes")
    _source(bands)
    bands.add_argument(
        "--path",
        default="",
        metavar="PATH",
        help='wave vectors in rad/m, "0,0,0; 0,0,314", or points of the Brillouin zone, G-X-M-G (default: standard)',
    )
    bands.add_argument("--points", type=positive, default=61, metavar="N", help="wave vectors a stretch (default: 61)")
    bands.add_argument(
        "--bands", type=positive, metavar="N", help="how many bands (default: all of a small cell, 30 of a large one)"
    )
    bands.add_argument(
        "--plane", default="", metavar="NAME", help="plane of slowness and equal-frequency curves: xy, xz or yz"
    )
    bands.add_argument(
        "--slab",
        action="store_true",
        help="the packing as it ends above and below, with its wall or held layer; sides periodic: surface waves",
    )
    _floppy(bands)
    modes = _verb(verbs, "modes", spectra.modes, "modes of a finite packing under a static load, density of states")
    _source(modes)
    modes.add_argument(
        "--modes",
        type=positive,
        metavar="N",
        help="how many modes (default: all of a small packing, 60 of a large one)",
    )
    _floppy(modes)
    steady = _verb(
        verbs, "transmission", spectra.transmission, "steady response of a finite packing to a grain that is shaken"
    )
    _source(steady)
    steady.add_argument(
        "--drive",
        type=spectra.ids,
        required=True,
        metavar="ID",
        help="grain that is shaken, or several, with commas, that are shaken alike; required",
    )
    steady.add_argument("--sensor", type=spectra.ids, required=True, metavar="ID,...", help="grains that are watched")
    steady.add_argument(
        "--frequencies",
        type=spectra.frequencies,
        required=True,
        metavar="F,...",
        help="frequencies in Hz, or START:END:COUNT; required",
    )
    steady.add_argument("--axis", default="", metavar="AXIS", help="direction of the motion, x, y or z (default: z)")
    steady.add_argument(
        "--end",
        default="",
        metavar="END",
        help="far end: reflecting, matched (as if it went on) or layer:N, N grains damped (default: reflecting)",
    )
    for parser in (bands, modes, steady):
        parser.add_argument(
            "--directions",
            default="",
            metavar="XYZ",
            help="directions in which grains move (default: those of the packing, z for a chain)",
        )
        parser.add_argument(
            "-o", dest="directory", type=output_name, metavar="DIR", help="where everything goes (default: ./NAME-...)"
        )
        _figures(parser)
        _json(parser, "the summary")
        parser.add_argument("--force", action="store_true", help="replace what is there")


def _source(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "case", metavar="CASE", help="a case file, the name of a built-in study, or the directory of a finished run"
    )
    _overrides(parser)


def _floppy(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--allow-floppy", action="store_true", help="go on where grains can move without resistance")


def _verb(verbs: argparse._SubParsersAction, name: str, command: object, what: str) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = verbs.add_parser(name, help=what, description=what)
    parser.set_defaults(command=command)
    return parser


def _case(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("case", metavar="CASE", help="a case file, or the name of a built-in study")
    _overrides(parser)


def _overrides(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--set",
        dest="overrides",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="override a key: --set load.velocity=10 --set packing.size=[24,24,12] (may be repeated)",
    )


def _into(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "-o", dest="directory", type=output_name, metavar="DIR", help="where everything goes (default: ./NAME)"
    )


def _again(parser: argparse.ArgumentParser) -> None:
    again = parser.add_mutually_exclusive_group()
    again.add_argument("--resume", action="store_true", help="go on with what is there")
    again.add_argument("--force", action="store_true", help="replace what is there")


def _json(parser: argparse.ArgumentParser, what: str) -> None:
    parser.add_argument("--json", action="store_true", help=f"print {what} as JSON, and nothing else")


def _figures(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--no-figures", dest="figures", action="store_false", help="leave the figures out")


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
