"""The commands of the core and their options, and the parser of all commands, including
extensions.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn

from granwave import __version__
from granwave._contact_laws import LawParameter
from granwave.analysis.exports.names import export_names
from granwave.lammps_inputs.case.contact.contact import LAWS
from granwave.lammps_inputs.case.contact.law_parameters import PARAMETERS, laws_with, type_of
from granwave.lammps_inputs.case.schema import did_you_mean, printable, show
from granwave.lammps_inputs.extensions import owner_left_out, with_added
from granwave.workflows.cli import arguments as read
from granwave.workflows.cli.arguments import BENCH_PARTS
from granwave.workflows.cli.commands import (
    CASE,
    CHAIN,
    CONTACTS,
    FIGURE_KEYS,
    FIND,
    FORCE,
    LOOK,
    NO_FIGURES,
    PACKAGE,
    PRINT,
    RANKS,
    RESUME_OR_FORCE,
    RUN,
    RUN_OR_SCAN,
    RUNNING,
    SET,
    SUBMIT,
    Command,
    Option,
    as_json,
    directory,
    figure_options,
    flag,
    materials,
    option,
    output,
    radii,
)
from granwave.workflows.cli.terminal import BOLD, RED, SHELLS, coloured
from granwave.workflows.cluster.schedulers import SCHEDULERS
from granwave.workflows.file_kinds import file_kinds

WRONG_INPUT = 2  # exit status
_NEGATIVE_NUMBER = re.compile(r"-(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$", re.IGNORECASE)
_COMMAND = "COMMAND"  # stands for the name of a command in the help
_HELP = "help"


def _law_parameter(parameter: LawParameter) -> Option:
    """Return the option of a parameter of contact laws."""
    name = "--" + parameter.name.replace("_", "-")
    what = f"{parameter.description} (default: {parameter.default})"
    if parameter.words:
        return option(name, choices=list(parameter.words), help=what)
    kind = read.number_of(type_of(parameter).read)
    return option(name, type=kind, metavar=parameter.symbol, help=what)


def _compare() -> Command:
    """Return the command that compares runs."""
    return Command(
        "compare",
        LOOK,
        "compare runs: largest differences, tables, a page, figures",
        "granwave.workflows.cli.compare:compare",
        (
            option(
                "directories",
                nargs="+",
                type=read.input_name,
                metavar="DIR",
                help="directories of runs, and of scans (all their points)",
            ),
            option(
                "--quantity",
                dest="quantities",
                action="extend",
                nargs="+",
                default=[],
                metavar="NAME",
                help="values of summary.json and figures of the comparison (default: all)",
            ),
            option(
                "--measured",
                type=read.input_name,
                metavar="FILE.csv",
                help="a measured curve: two columns with units in their names, such as time_us, "
                "force_N",
            ),
            option(
                "--as",
                dest="measured_as",
                default="bottom_force",
                metavar="NAME",
                help="figure with the measured curve: bottom_force (default), peak_force_depth or "
                "fronts",
            ),
            option(
                "--shift",
                type=read.finite,
                default=0.0,
                metavar="X",
                help="add X (s or m) to the measured times or lengths",
            ),
            option(
                "--scale",
                type=read.factor,
                default=1.0,
                metavar="Y",
                help="multiply the measured values by Y",
            ),
            output(
                "a file that ends in .html, .pdf or .md (default: compare.html); figures go to "
                "NAME_figures next to it",
                default=Path("compare.html"),
            ),
        ),
    )


def _core() -> tuple[Command, ...]:
    """Return the commands of the core."""
    files = [kind.name for kind in file_kinds()]
    return (
        Command("cases", FIND, "list the built-in cases and "
            "scans", "granwave.workflows.cli.package:cases", (
            option("words", nargs="*", metavar="WORD", help="list only entries whose name or "
                "title contains all these words"),
            flag("--all", "list all entries, with descriptions"),
            as_json("the list"),
        )),
        Command("show", FIND, "print an editable copy of a built-in case or "
            "scan", "granwave.workflows.cli.package:show", (
            option("name", metavar="NAME", help="name of a built-in case or scan"),
        )),
        Command("keys", FIND, "list the keys of all files: unit, default, accepted values, "
            "example", "granwave.workflows.cli.package:keys", (
            option("table", nargs="*", metavar="TABLE", help="a table, such as packing; a key, "
                "such as packing.diameter; or words of keys or descriptions (default: a list)"),
            [as_json("the tables and their keys"),
             option("--schema", choices=files, metavar="FILE",
                     help="print the JSON Schema of a kind of file, for editors: "
                         f"{', '.join(files)}")],
        )),
        Command("quantities", FIND, "list the values of summary.json: label, unit, meaning",
                "granwave.workflows.cli.package:quantities", (
            option("names", nargs="*", metavar="NAME",
                   help="values, such as zone_depth_90_m, or words (default: a list)"),
        )),
        Command("check", FIND, "check a case and estimate size, memory, disk, timestep, time, "
            "overlap", "granwave.workflows.cli.check:check", (
            CASE, SET, RANKS,
            option("--picture", type=read.output_name, metavar="FILE.png",
                   help="draw the packing from the side and from above (.png or .pdf; both are written, and the grains as .csv)"),
            option("--profile", type=read.input_name, metavar="FILE",
                    help="plan for this cluster instead of this machine: nodes, ranks, time, memory"),
            as_json("the plan"),
        )),
        Command("run", RUNNING, "run a case: input script, LAMMPS, analysis, "
            "figures", "granwave.workflows.cli.running:run", (
            CASE, SET, directory(), RANKS,
            option("--checkpoint", type=read.seconds, default=60.0, metavar="SECONDS",
                    help="wall time between checkpoints (default: 60)"),
            NO_FIGURES, SUBMIT, CHAIN, PRINT, as_json("the summary"), RESUME_OR_FORCE,
        )),
        Command("scan", RUNNING, "run a case repeatedly with varied keys; table, figures and "
            "report", "granwave.workflows.cli.scan:scan", (
            option("scan", metavar="SCAN", help="a scan file, or the name of a built-in scan"),
            SET, directory(),
            option("--executor", default="local", metavar="local|SCHEDULER",
                    help=f"where to run the points: local (default), or a scheduler: {', '.join(SCHEDULERS)}"),
            option("--profile", type=read.input_name, metavar="FILE",
                    help="profile of the cluster: partition, account, time, ..."),
            SUBMIT, PRINT,
            option("--jobs", type=read.positive, metavar="N",
                    help=("number of simultaneous jobs (default: the cores of this machine; 100 "
                          "on a cluster)")),
            flag("--plan", "print the plan of the scan without running it"),
            as_json("the plan, or all points and their values at the end,"), RESUME_OR_FORCE,
        )),
        Command("write", RUNNING, "write only the LAMMPS input; run it with lmp -in "
            "in.granwave", "granwave.workflows.cli.running:write", (
            CASE, SET, directory("directory of the LAMMPS input; required", required=True), FORCE,
        )),
        Command("analyse", RUNNING, "repeat the analysis of the dumps: result.h5, figures, "
            "summary.json", "granwave.workflows.cli.running:analyse", (
            RUN, RANKS, NO_FIGURES, as_json("the summary"),
        )),
        Command("report", LOOK, "write a report of any number of runs and "
            "scans", "granwave.workflows.cli.results:report", (
            option("directories", nargs="+", type=read.input_name, metavar="DIR", help="directories of runs and scans"),
            output("a file that ends in .html, .pdf or .md (default: report.html)", default=Path("report.html")),
            option("--study", action="append", default=[], metavar="NAME|FILE.py",
                    help="a study of all runs, by name or as a Python file, in addition to the "
                        "studies of scan and suite files; may be repeated"),
        )),
        _compare(),
        Command("figures", LOOK, "redraw all or some figures of a "
            "run", "granwave.workflows.cli.results:figures", (
            RUN,
            option("names", nargs="*", metavar="NAME",
                    help="names of figures (default: the figures selected in the case, or the "
                        "main figures)"),
            option("--only", type=read.words, metavar="NAME,...",
                   help="names of figures, separated by commas"),
            flag("--all", "all applicable figures"),
            *figure_options(*FIGURE_KEYS),
        )),
        Command("export", LOOK, "export results to other programs: ParaView, pandas, xarray, "
            "OVITO", "granwave.workflows.cli.results:export", (
            RUN_OR_SCAN, option("--to", required=True, metavar="FORMAT", help=f"one of {', '.join(export_names())}"),
            option("--only", type=read.words, metavar="NAME,...",
                    help="tables of a run to export to csv, such as contacts,energy (default: "
                        "all, or all tables to which a selection of rows applies)"),
            option("--spheres", type=read.whole_numbers, metavar="ID,...",
                    help="rows of these spheres and their contacts, such as 1,5,10-20"),
            option("--layers", type=read.whole_numbers, metavar="N,...",
                    help="rows of these layers and their contacts, such as 1,3-5; 1 is the top"),
            option("--depth", type=read.bounds, metavar="LOW,HIGH",
                    help="rows at these depths below the impacted sphere, m"),
            option("--region", metavar="WORDS",
                    help='rows in a LAMMPS region, in m, such as "sphere 0.04 0.04 0 0.02"'),
            option("--time", type=read.bounds, metavar="FROM,TO",
                    help="time range of histories and snapshots, s"),
            output("directory or file of the export (default: DIR/export)", "DIR"),
        )),
        Command("law", CONTACTS, "plot or tabulate force-overlap curves of a "
            "contact", "granwave.workflows.cli.contacts:law", (
            materials("one or two materials: a name, or FILE.toml:NAME (default: brass)"),
            radii("one or two radii, m; the second may be inf, a plane (default: 0.005)"),
            option("--law", default="elastoplastic", choices=list(LAWS), help="contact law (default: elastoplastic)"),
            *(_law_parameter(p) for p in PARAMETERS.values() if set(laws_with(p)) & set(LAWS)),
            option("--cohesion", nargs=2, metavar=("KIND", "W"), help="jkr or dmt, and the work of adhesion, J/m^2"),
            option("--max-overlap", type=read.overlap, default=200.0, metavar="A",
                    help="largest overlap, in units of the overlap at first yield (default: 200)"),
            option("--velocity", type=read.speed, default=0.0, metavar="V",
                    help="approach velocity, m/s, with --rate-sensitivity (default: quasi-static)"),
            flag("--restitution", "plot the coefficient of restitution against velocity instead, "
                "for two spheres and for a sphere on a rigid wall"),
            output("a file that ends in .png, .pdf or .csv (default: law.png, restitution.png)"),
        )),
        Command("doctor", PACKAGE, "check the installation (versions, plugin, MPI) and suggest "
            "fixes", "granwave.workflows.cli.installation.doctor:doctor", (
            option("--profile", type=read.input_name, metavar="FILE",
                    help="also check the profile of a cluster, on its login node"),
            as_json("the findings"),
        )),
        Command("selftest", PACKAGE, "verify the installation: reference values, plugin, MPI and "
            "restart",
                "granwave.workflows.cli.installation.selftest:selftest", (
            option("--np", dest="ranks", type=read.positive, default=2, metavar="N",
                    help="number of MPI ranks to compare with a single rank (default: 2; 1 skips "
                        "this check)"),
            option("--profile", type=read.input_name, metavar="FILE",
                    help="profile of a cluster; its launcher starts the ranks (default: mpiexec)"),
            as_json("the checks"),
        )),
        Command("bench", PACKAGE, "compare the speed with the granular styles of LAMMPS on this "
            "machine", "granwave.workflows.cli.package:bench", (
            option("--json", type=read.output_name, metavar="FILE", help="also write the results "
                "to this file"),
            option("--repeats", type=read.positive, default=5, metavar="N", help="timings of each "
                "style (default: 5)"),
            [option("--parts", type=read.bench_parts, default=BENCH_PARTS, metavar="PART,...",
                     help=f"parts to measure: {', '.join(BENCH_PARTS)} (default: all, "
                         "ten minutes)"),
             option("--styles-only", action="store_const", const=("styles",), dest="parts",
                     help="the same as --parts styles")],
        )),
        Command("completion", PACKAGE, "print code that enables tab completion in a "
            "shell", "granwave.workflows.cli.completion:completion", (
            option("shell", choices=SHELLS, help="the shell: bash, zsh or fish"),
        )),
        Command(_HELP, PACKAGE, "show this list, or the options of a "
            "command", "granwave.workflows.cli.package:show_help"),
    )  # fmt: skip


def commands() -> tuple[Command, ...]:
    """Return all commands, with those of extensions, in the order of the list of commands."""
    listed = with_added(_core(), "commands")
    groups = list(dict.fromkeys(command.group for command in listed))
    return tuple(sorted(listed, key=lambda command: groups.index(command.group)))


def make_parser(words: Sequence[str] = ()) -> argparse.ArgumentParser:
    """Make the parser of all commands.

    Parameters
    ----------
    words
        Words of a command line: the parser then has only the named command, if there is one.
    """
    parser = _Parser(
        prog="granwave", description="Impact and waves in ordered granular packings, on LAMMPS."
    )
    parser.add_argument("--version", action="version", version=f"granwave {__version__}")
    verbs = parser.add_subparsers(required=True, metavar=_COMMAND)
    parser._positionals._group_actions.clear()  # the groups list them
    listed = commands()
    named = [command for command in listed if words and command.name == words[0] != _HELP]
    if named:
        listed = tuple(named)
    for title in dict.fromkeys(command.group for command in listed):
        group = parser.add_argument_group(title)
        first = len(verbs._choices_actions)
        for command in (command for command in listed if command.group == title):
            verb = verbs.add_parser(command.name, help=command.what, description=command.what)
            verb.set_defaults(command=command)
            _add_options(verb, command)
        group._group_actions.extend(verbs._choices_actions[first:])
    if not named:
        _add_names(verbs.choices[_HELP], parser, verbs.choices)
    return parser


def _add_names(
    shown: argparse.ArgumentParser,
    parser: argparse.ArgumentParser,
    verbs: Mapping[str, argparse.ArgumentParser],
) -> None:
    """Give `granwave help` the names of all commands, and their parsers."""
    shown.add_argument(
        "name", nargs="?", choices=[*verbs], metavar=_COMMAND, help="name of a command"
    )
    shown.set_defaults(parsers={None: parser, **verbs})


def _add_options(verb: argparse.ArgumentParser, command: Command) -> None:
    """Add the options of a command to its parser."""
    for entry in command.options:
        if isinstance(entry, Option):
            verb.add_argument(*entry.names, **entry.settings)
            continue
        exclusive = verb.add_mutually_exclusive_group()
        for alternative in entry:
            exclusive.add_argument(*alternative.names, **alternative.settings)


class _Parser(argparse.ArgumentParser):
    """Parser that reports errors in one line, like other errors, and accepts values such as
    ``-12e-6``, which argparse takes for options.
    """

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._negative_number_matcher = _NEGATIVE_NUMBER

    def format_help(self) -> str:
        """Return the help, with emphasised titles on a terminal."""
        return re.sub(
            r"(?m)^\S[^\n]*:$",
            lambda title: coloured(title[0], BOLD, sys.stdout),
            super().format_help(),
        )

    def _get_values(self, action: argparse.Action, arg_strings: list[str]) -> Any:
        """Return the value of an option; after "=", "--" is an ordinary value."""
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
            if name == _COMMAND:
                owner = owner_left_out("commands", lambda command: command.name == found)
                hint = f"; {owner}" if owner else hint
            message = f"{name}: found {show(found)}, expected one of {', '.join(options)}{hint}"
        elif message.startswith("unrecognized arguments: "):
            message += _meant(message.split()[2].partition("=")[0])
        message = message.removeprefix("argument ")
        help_text = "" if "found " in message else f"; see {self.prog} --help"
        self.exit(
            WRONG_INPUT,
            f"{coloured('granwave:', RED, sys.stderr)} {printable(' '.join(message.split()))}{help_text}\n",
        )


def _meant(unknown: str) -> str:
    """Suggest the intended option for an unknown option of a command."""
    keys = "; keys of a case are set by --set KEY=VALUE"
    commands_by_option: dict[str, list[str]] = {}
    for command in commands():
        for entry in command.each_option():
            for name in entry.names:
                commands_by_option.setdefault(name, []).append(command.name)
    if having := commands_by_option.get(unknown):
        return keys * (unknown != "--set") + f"; it is an option of {', '.join(having)}"
    return did_you_mean(unknown, list(commands_by_option), cutoff=0.8) or keys
