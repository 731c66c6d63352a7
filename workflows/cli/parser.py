"""The commands of granwave and their options, as ``granwave --help`` lists them: one table for all."""

from __future__ import annotations

import argparse
import dataclasses
import inspect
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

from granwave import __version__
from granwave._contact_laws import LawParameter
from granwave.extensions.waves.spectra.quantities import MOST_BANDS, MOST_MODES, POINTS
from granwave.lammps_inputs.case.contact import LAWS
from granwave.lammps_inputs.case.law_parameters import PARAMETERS, laws_with, type_of
from granwave.lammps_inputs.case.schema import did_you_mean, printable, show
from granwave.lammps_inputs.extensions import load
from granwave.workflows.cli import arguments as read
from granwave.workflows.cli.arguments import BENCH_PARTS, FILE_KINDS
from granwave.workflows.cli.terminal import BOLD, RED, SHELLS, coloured

WRONG_INPUT = 2  # exit status


@dataclasses.dataclass(frozen=True)
class Option:
    """An argument of a command: its names, and the settings of ``ArgumentParser.add_argument``."""

    names: tuple[str, ...]
    settings: dict[str, Any]


@dataclasses.dataclass(frozen=True)
class Command:
    """A command of granwave.

    Attributes
    ----------
    group
        Heading that it is listed under.
    what
        Its line in the list, and the description in its own help.
    function
        Reference, "MODULE:NAME", of the function that is called with the parsed options and returns
        the exit status; its module is loaded then.
    options
        Its options; of those in a list one alone may be given.
    """

    name: str
    group: str
    what: str
    function: str
    options: tuple[Option | list[Option], ...] = ()

    def run(self, options: argparse.Namespace) -> int:
        """Call the function; return the exit status."""
        return int(load(self.function)(options))


def _option(*names: str, **settings: Any) -> Option:
    return Option(names, settings)


def _flag(name: str, what: str, **settings: Any) -> Option:
    return Option((name,), {"action": "store_true", "help": what, **settings})


def _directory(what: str = "where everything goes (default: ./NAME)", **settings: Any) -> Option:
    return _option(
        "-o", dest="directory", type=read.output_name, metavar="DIR", help=what, **settings
    )


def _output(what: str, metavar: str = "FILE", **settings: Any) -> Option:
    return _option(
        "-o", dest="output", type=read.output_name, metavar=metavar, help=what, **settings
    )


def _law_parameter(parameter: LawParameter) -> Option:
    """Return the option of a parameter of contact laws."""
    name = "--" + parameter.name.replace("_", "-")
    what = f"{parameter.description} (default: {parameter.default})"
    if parameter.words:
        return _option(name, choices=list(parameter.words), help=what)
    kind = read.number_of(type_of(parameter).read)
    return _option(name, type=kind, metavar=parameter.symbol, help=what)


def _json(what: str) -> Option:
    return _flag("--json", f"print {what} as JSON, and nothing else")


def _materials(what: str) -> Option:
    return _option("--material", nargs="+", default=["brass"], metavar="M", help=what)


def _radii(what: str) -> Option:
    return _option("--radius", nargs="+", type=read.radius, default=[0.005], metavar="R", help=what)


_CASE = _option("case", metavar="CASE", help="a case file, or the name of a built-in study")
_SOURCE = _option(
    "case",
    metavar="CASE",
    help="a case file, the name of a built-in study, or the directory of a finished run",
)
_RUN = _option("directory", type=read.input_name, metavar="DIR", help="directory of a run")
_RUN_OR_SCAN = _option(
    "directory", type=read.input_name, metavar="DIR", help="directory of a run or a scan"
)
_SET = _option(
    "--set", dest="overrides", action="append", default=[], metavar="KEY=VALUE",
    help="override a key: --set load.velocity=10 --set packing.size=[24,24,12] (may be repeated)",
)  # fmt: skip
_RANKS = _option(
    "--np",
    dest="ranks",
    type=read.positive,
    default=1,
    metavar="N",
    help="number of MPI ranks (default: 1)",
)
_NO_FIGURES = _flag("--no-figures", "leave the figures out", dest="figures", action="store_false")
_FORCE = _flag("--force", "move what is there to DIR.old (DIR.old2, ...), and begin anew")
_RESUME_OR_FORCE = [_flag("--resume", "go on with what is there"), _FORCE]
_ALLOW_FLOPPY = _flag("--allow-floppy", "go on where grains can move without resistance")
_DIRECTIONS = _option(
    "--directions", default="", metavar="XYZ",
    help="directions in which grains move (default: those of the packing, z for a chain)",
)  # fmt: skip
_SMALL_WAVES = (
    _DIRECTIONS,
    _directory("where everything goes (default: ./NAME-...)"),
    _NO_FIGURES,
    _json("the summary"),
    _FORCE,
)
_THROUGH = _option(
    "--through", metavar="X,Y,Z", help="a point of that plane, m (default: struck sphere)"
)
#: Keys of ``[figures]`` that have an option.
FIGURE_KEYS = {
    "plane": _option(
        "--plane", metavar="x|y|z|X,Y,Z",
        help="normal of a plane of your own through the struck sphere; its figures end in _section",
    ),
    "colour_map": _option(
        "--colour-map", metavar="NAME", help="colour map of matplotlib, for all figures that have one"
    ),
    "force_limits": _option(
        "--force-limits", metavar="LOW,HIGH", help="ends of the colour scale of forces, in the unit of the figure"
    ),
    "dissipation_limits": _option(
        "--dissipation-limits", metavar="LOW,HIGH",
        help="ends of the colour scale of dissipation, over the energy input",
    ),
    "width": _option("--width", metavar="METRES", help="width of a figure of one column (default: 0.08636)"),
    "formats": _option(
        "--formats", metavar="NAME,...", help="files besides PNG and CSV: pdf, svg, pdf,svg or none (default: pdf)"
    ),
}  # fmt: skip
#: Those of films.
FILM_KEYS = ("plane", "colour_map", "force_limits", "dissipation_limits")


def _figure_options(*keys: str) -> list[Option]:
    return [FIGURE_KEYS["plane"], _THROUGH, *(FIGURE_KEYS[key] for key in keys if key != "plane")]


_FIND = "find and check a case"
_RUNNING = "run"
_LOOK = "look at results"
_WAVES = "small waves"
_CONTACTS = "contacts"
_PACKAGE = "the installation"
COMMANDS = (
    Command("cases", _FIND, "the studies that come with the package", "granwave.workflows.cli.package:cases", (
        _option("words", nargs="*", metavar="WORD", help="list only those whose name or title has all these words"),
        _flag("--all", "list all, with what each is"),
        _json("the list"),
    )),
    Command("show", _FIND, "an editable copy of a built-in study, on stdout", "granwave.workflows.cli.package:show", (
        _option("name", metavar="NAME", help="name of a built-in case or scan"),
    )),
    Command("keys", _FIND, "keys of all files: unit, default, accepted values, example", "granwave.workflows.cli.package:keys", (
        _option("table", nargs="*", metavar="TABLE", help="a table, as packing; a key, as packing.diameter; or words "
                "of keys or descriptions (default: a list)"),
        [_json("the tables and their keys"),
         _option("--schema", choices=FILE_KINDS, metavar="FILE",
                 help=f"print the JSON Schema of a kind of files, for editors: {', '.join(FILE_KINDS)}")],
    )),
    Command("check", _FIND, "what a run would be: size, memory, disk, timestep, time, overlap", "granwave.workflows.cli.check:check", (
        _CASE, _SET, _RANKS, _json("the plan"),
    )),
    Command("bed", _FIND, "make the bed of a case whose grains are poured, and its statistics", "granwave.extensions.packings.terminal:bed", (
        _CASE, _SET, _output("figure of the bed (.png, .pdf) or its table (.csv)"), _json("the statistics"),
    )),
    Command("run", _RUNNING, "run a case: deck, LAMMPS, analysis, figures", "granwave.workflows.cli.running:run", (
        _CASE, _SET, _directory(), _RANKS,
        _option("--checkpoint", type=read.seconds, default=60.0, metavar="SECONDS",
                help="wall time between checkpoints (default: 60)"),
        _NO_FIGURES, _json("the summary"), _RESUME_OR_FORCE,
    )),
    Command("scan", _RUNNING, "run a case many times with some keys varied; table, figures and report", "granwave.workflows.cli.scan:scan", (
        _option("scan", metavar="SCAN", help="a scan file, or the name of a built-in scan"),
        _SET, _directory(),
        _option("--executor", default="local", metavar="local|slurm", help="where the points run (default: local)"),
        _option("--profile", type=read.input_name, metavar="FILE",
                help="how to use the cluster: partition, account, time, ..."),
        _option("--jobs", type=read.positive, metavar="N",
                help="jobs at once (default: the cores of this machine; 100 on a cluster)"),
        _flag("--plan", "say what the scan would be, and run nothing"),
        _json("the plan, or at the end all points and their values,"), _RESUME_OR_FORCE,
    )),
    Command("design", _RUNNING, "search for the best packing: variables, limits, an objective, checks of the best",
            "granwave.extensions.design.terminal:design", (
        _option("file", type=read.input_name, metavar="FILE", help="a design file: base, variables, limits, objective"),
        _directory(), _RANKS,
        _option("--jobs", type=read.positive, metavar="N", help="runs at once (default: the cores of this machine)"),
        _option("--budget", type=read.positive, metavar="N",
                help="designs to run, in place of search.evaluations of the file"),
        _json("the best design and its checks"), _RESUME_OR_FORCE,
    )),
    Command("continuum", _RUNNING, "the continuum reference: a rigid punch on an elastic-plastic block",
            "granwave.workflows.cli.running:continuum", (_CASE, _SET, _directory(), _NO_FIGURES, _json("the summary"), _RESUME_OR_FORCE)),
    Command("write", _RUNNING, "write the LAMMPS deck alone; it runs by hand: lmp -in in.granwave", "granwave.workflows.cli.running:write", (
        _CASE, _SET, _directory("where the deck goes; required", required=True), _FORCE,
    )),
    Command("analyse", _RUNNING, "once more from the dumps: result.h5, figures, summary.json", "granwave.workflows.cli.running:analyse", (
        _RUN, _RANKS, _NO_FIGURES, _json("the summary"),
    )),
    Command("report", _LOOK, "a page that compares any number of runs and scans", "granwave.workflows.cli.results:report", (
        _option("directories", nargs="+", type=read.input_name, metavar="DIR", help="directories of runs and scans"),
        _output("a file that ends in .html, .pdf or .md (default: report.html)", default=Path("report.html")),
        _option("--study", action="append", default=[], metavar="NAME|FILE.py",
                help="a study to make of all runs, by name or in a file of yours, beside those that scan and suite "
                "files name; may be repeated"),
    )),
    Command("figures", _LOOK, "draw the figures of a run again, all or some", "granwave.workflows.cli.results:figures", (
        _RUN,
        _option("--only", type=read.words, metavar="NAME,...",
                help="names of figures (default: those of the case, or all)"),
        *_figure_options(*FIGURE_KEYS),
    )),
    Command("view", _LOOK, "a page to turn and cut the packing of a run in a browser", "granwave.workflows.cli.results:view", (
        _RUN, _output("name of the page, .html (default: DIR/view.html)"),
        [_option("--spheres", type=read.positive, metavar="N",
                 help="at most so many spheres, those nearest to the struck one (default: 250000)"),
         _flag("--all", "all spheres and snapshots, however many")],
        _option("--frames", type=read.positive, metavar="N", help="at most so many snapshots"),
    )),
    Command("film", _LOOK, "a film of a run: planes, the cut packing, or a chain in space-time", "granwave.workflows.cli.results:film", (
        _RUN, _output("a file that ends in .mp4, .gif or .webp", required=True),
        _option("--quantity", default="force", metavar="NAME",
                help="what is shown: force, velocity or dissipation (default: force)"),
        _option("--view", metavar="NAME",
                help="what is seen: orthogonal, principal, section, 3d or chain (default: what there is)"),
        [_option("--width", type=read.positive, default=1200, metavar="PIXELS",
                 help="width of the pictures (default: 1200)"),
         _option("--size", metavar="NAME|WxH", help="slide (1920x1080), page (1200x900), or width x height in pixels")],
        *_figure_options(*FILM_KEYS),
        _option("--rate", type=read.number, metavar="N", help="pictures per second (default: 3 to 25)"),
    )),
    Command("export", _LOOK, "the results for other programs: ParaView, pandas, xarray, OVITO", "granwave.workflows.cli.results:export", (
        _RUN_OR_SCAN, _option("--to", required=True, metavar="FORMAT", help="one of vtp, csv, netcdf, ovito"),
        _output("where to (default: DIR/export)", "DIR"),
    )),
    Command("bands", _WAVES, "bands of an endless packing under a static load: gaps, speeds, modes", "granwave.extensions.waves.terminal:bands", (
        _SOURCE, _SET,
        _option("--path", default="", metavar="PATH", help='wave vectors in rad/m, "0,0,0; 0,0,314", or points of the '
                "Brillouin zone, G-X-M-G (default: standard)"),
        _option("--points", type=read.positive, default=POINTS, metavar="N",
                help=f"wave vectors a stretch (default: {POINTS})"),
        _option("--bands", dest="n_bands", type=read.positive, metavar="N",
                help=f"how many bands (default: all of a small cell, {MOST_BANDS} of a large one)"),
        _option("--plane", default="", metavar="NAME",
                help="plane of slowness and equal-frequency curves: xy, xz or yz"),
        _flag("--slab", "the packing as it ends above and below, with its wall or held layer; sides periodic: surface "
              "waves"),
        _ALLOW_FLOPPY, *_SMALL_WAVES,
    )),
    Command("modes", _WAVES, "modes of a finite packing under a static load, density of states", "granwave.extensions.waves.terminal:modes", (
        _SOURCE, _SET,
        _option("--modes", dest="n_modes", type=read.positive, metavar="N",
                help=f"how many modes (default: all of a small packing, {MOST_MODES} of a large one)"),
        _ALLOW_FLOPPY, *_SMALL_WAVES,
    )),
    Command("transmission", _WAVES, "steady response of a finite packing to a grain that is shaken",
            "granwave.extensions.waves.terminal:transmission", (
        _SOURCE, _SET,
        _option("--drive", type=read.ids, required=True, metavar="ID",
                help="grain that is shaken, or several, with commas, that are shaken alike; required"),
        _option("--sensor", dest="sensors", type=read.ids, required=True, metavar="ID,...",
                help="grains that are watched"),
        _option("--frequencies", type=read.frequencies, required=True, metavar="F,...",
                help="frequencies in Hz, or START:END:COUNT; required"),
        _option("--axis", default="", metavar="AXIS", help="direction of the motion, x, y or z (default: z)"),
        _option("--end", default="", metavar="END", help="far end: reflecting, matched (as if it went on) or layer:N, "
                "N grains damped (default: reflecting)"),
        *_SMALL_WAVES,
    )),
    Command("law", _CONTACTS, "force-overlap curves of a contact: a plot or a table", "granwave.workflows.cli.contacts:law", (
        _materials("one or two: a name, or FILE.toml:NAME (default: brass)"),
        _radii("one radius or two, m; the second may be inf, a plane (default: 0.005)"),
        _option("--law", default="elastoplastic", choices=list(LAWS), help="contact law (default: elastoplastic)"),
        *(_law_parameter(p) for p in PARAMETERS.values() if set(laws_with(p)) & set(LAWS)),
        _option("--cohesion", nargs=2, metavar=("KIND", "W"), help="jkr or dmt, and the work of adhesion, J/m^2"),
        _option("--max-overlap", type=read.overlap, default=200.0, metavar="A",
                help="largest overlap, in units of that at first yield (default: 200)"),
        _option("--velocity", type=read.speed, default=0.0, metavar="V",
                help="approach velocity, m/s, with --rate-sensitivity (default: slow)"),
        _flag("--restitution", "coefficient of restitution against velocity instead, of two spheres and of a sphere "
              "and a rigid wall"),
        _output("a file that ends in .png, .pdf or .csv (default: law.png, restitution.png)"),
    )),
    Command("fit", _CONTACTS, "fit the contact law's constants to a measured or computed curve", "granwave.workflows.cli.contacts:fit", (
        _option("curve", type=read.input_name, metavar="CURVE.csv",
                help="columns overlap_m and force_N (or overlap_um, force_kN, ...), perhaps branch"),
        _materials("one or two: a name, or FILE.toml:NAME"),
        _radii("one radius or two, m; the second may be inf, a plane (default: 0.005)"),
        _option("--free", nargs="+", metavar="NAME", help="constants to fit (default: all that the curve can tell)"),
        _option("--pair", nargs=2, metavar=("A", "B"),
                help="also write pair.toml: the law of these two materials in a case"),
        _flag("--fit-yield", "fit the yield strength too"),
        _directory("where everything goes (default: ./fit)"), _flag("--force", "move the fit that is there to DIR.old (DIR.old2, ...)"),
    )),
    Command("infer", _CONTACTS, "contact forces from measured grains, or from measurements made of a run",
            "granwave.workflows.cli.contacts:infer", (
        _option("measurement", type=read.input_name, metavar="GRAINS.csv|RUN",
                help="table of measured grains; or directory of a run with output.contact_forces, to plan an "
                "experiment"),
        _option("--case", type=read.input_name, metavar="FILE",
                help="file with [material] and [infer]; a run can do without"),
        _option("--noise", type=read.shares, metavar="SHARE,...", help="errors of strains and accelerations of a run, "
                "over their root mean squares; several for a curve"),
        _option("--frame-rate", type=read.hertz, metavar="HZ",
                help="accelerations of a run from the places in three frames of such a camera"),
        _option("--position-noise", type=read.radius, metavar="M",
                help="errors of the places in these frames (default: none)"),
        _option("--time", type=read.number, metavar="S",
                help="instant of a run (default: the snapshot with the largest forces)"),
        _option("--repeat", type=read.count, metavar="N",
                help="repetitions with noise (default: infer.repetitions; of a run 10)"),
        _directory(), _NO_FIGURES, _json("the summary"), _FORCE,
    )),
    Command("doctor", _PACKAGE, "versions, plugin, MPI: what works and how to mend what does not", "granwave.workflows.cli.doctor:doctor", (
        _option("--profile", type=read.input_name, metavar="FILE",
                help="also check the profile of a cluster, on its login node"),
        _json("the findings"),
    )),
    Command("selftest", _PACKAGE, "known answers, plugin, MPI and restart, computed on this machine: run it first",
            "granwave.workflows.cli.selftest:selftest", (
        _option("--np", dest="ranks", type=read.positive, default=2, metavar="N",
                help="MPI ranks that must give the numbers of one (default: 2; 1 leaves that out)"),
        _option("--profile", type=read.input_name, metavar="FILE",
                help="profile of a cluster, whose launcher starts the ranks (default: mpiexec)"),
        _json("the checks"),
    )),
    Command("bench", _PACKAGE, "speed beside LAMMPS's own granular styles, on this machine", "granwave.workflows.cli.package:bench", (
        _option("--json", type=read.output_name, metavar="FILE", help="write the results there too"),
        _option("--repeats", type=read.positive, default=5, metavar="N", help="timings of each (default: 5)"),
        [_option("--parts", type=read.bench_parts, default=BENCH_PARTS, metavar="PART,...",
                 help=f"what to measure: {', '.join(BENCH_PARTS)} (default: all, some ten minutes)"),
         _option("--styles-only", action="store_const", const=("styles",), dest="parts",
                 help="the same as --parts styles")],
    )),
    Command("completion", _PACKAGE, "code that switches on tab completion in a shell", "granwave.workflows.cli.completion:completion", (
        _option("shell", choices=SHELLS, help="the shell: bash, zsh or fish"),
    )),
    Command("help", _PACKAGE, "this list, or the options of a command", "granwave.workflows.cli.package:show_help"),
)  # fmt: skip


def make_parser() -> argparse.ArgumentParser:
    """Make the parser of all commands."""
    parser = _Parser(
        prog="granwave", description="Impact and waves in ordered granular packings, on LAMMPS."
    )
    parser.add_argument("--version", action="version", version=f"granwave {__version__}")
    verbs = parser.add_subparsers(required=True, metavar="COMMAND")
    parser._positionals._group_actions.clear()  # the groups list them
    for title in dict.fromkeys(command.group for command in COMMANDS):
        group = parser.add_argument_group(title)
        first = len(verbs._choices_actions)
        for command in (command for command in COMMANDS if command.group == title):
            verb = verbs.add_parser(command.name, help=command.what, description=command.what)
            verb.set_defaults(command=command)
            for option in command.options:
                options, into = ([option], verb) if isinstance(option, Option) else (option, None)
                add = (into or verb.add_mutually_exclusive_group()).add_argument
                for one in options:
                    add(*one.names, **one.settings)
        group._group_actions.extend(verbs._choices_actions[first:])
    shown = verbs.choices["help"]
    shown.add_argument(
        "name", nargs="?", choices=[*verbs.choices], metavar="COMMAND", help="name of a command"
    )
    shown.set_defaults(parsers={None: parser, **verbs.choices})
    return parser


def chosen(options: argparse.Namespace, function: Callable[..., Any]) -> dict[str, Any]:
    """Return the options that a function has parameters for, by name."""
    return {
        name: getattr(options, name)
        for name in inspect.signature(function).parameters
        if hasattr(options, name)
    }


class _Parser(argparse.ArgumentParser):
    """Parser that reports errors in one line, like other errors."""

    def format_help(self) -> str:
        """Return the help, with titles that stand out on a terminal."""
        return re.sub(
            r"(?m)^\S[^\n]*:$",
            lambda title: coloured(title[0], BOLD, sys.stdout),
            super().format_help(),
        )

    def _get_values(self, action: argparse.Action, arg_strings: list[str]) -> Any:
        """Return the value of an option; "--" behind its "=" is a value as any other."""
        if action.option_strings and action.nargs is None and arg_strings == ["--"]:
            return self._get_value(action, "--")
        return super()._get_values(action, arg_strings)

    def error(self, message: str) -> NoReturn:
        choice = re.fullmatch(
            r"argument (\S+): invalid choice: '(.*?)' \(choose from (.*)\)", message, re.DOTALL
        )
        if choice:
            name, found, listed = choice.groups()
            options = re.findall(r"[\w-]+", listed)
            hint = did_you_mean(found, options)
            message = f"{name}: found {show(found)}, expected one of {', '.join(options)}{hint}"
        elif message.startswith("unrecognized arguments: "):
            message += _meant(message.split()[2].partition("=")[0])
        message = message.removeprefix("argument ")
        help_text = "" if "found " in message else f"; {self.prog} --help tells more"
        self.exit(
            WRONG_INPUT,
            f"{coloured('granwave:', RED, sys.stderr)} {printable(' '.join(message.split()))}{help_text}\n",
        )


def _meant(unknown: str) -> str:
    """Suggest what an option that a command does not have was probably meant to be."""
    keys = "; keys of a case are set by --set KEY=VALUE"
    options = [
        (name, command.name)
        for command in COMMANDS
        for entry in command.options
        for option in (entry if isinstance(entry, list) else [entry])
        for name in option.names
    ]
    if having := [command for name, command in options if name == unknown]:
        return keys * (unknown != "--set") + f"; it is an option of {', '.join(having)}"
    return did_you_mean(unknown, [name for name, _ in options], cutoff=0.8) or keys
