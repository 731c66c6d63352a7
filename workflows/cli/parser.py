"""The commands of the core and their options, and the parser of all commands, those of extensions too."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn

from granwave import __version__
from granwave._contact_laws import LawParameter
from granwave.analysis.exports.names import export_names
from granwave.lammps_inputs.case.contact import LAWS
from granwave.lammps_inputs.case.law_parameters import PARAMETERS, laws_with, type_of
from granwave.lammps_inputs.case.schema import did_you_mean, printable, show
from granwave.lammps_inputs.extensions import owner_left_out, with_added
from granwave.workflows.cli import arguments as read
from granwave.workflows.cli.arguments import BENCH_PARTS
from granwave.workflows.cli.commands import (
    CASE,
    CONTACTS,
    FIGURE_KEYS,
    FIND,
    FORCE,
    LOOK,
    NO_FIGURES,
    PACKAGE,
    RANKS,
    RESUME_OR_FORCE,
    RUN,
    RUN_OR_SCAN,
    RUNNING,
    SET,
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
from granwave.workflows.file_kinds import file_kinds

WRONG_INPUT = 2  # exit status
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
        "what differs most between runs: a sentence, tables, a page, figures",
        "granwave.workflows.cli.compare:compare",
        (
            option(
                "directories",
                nargs="+",
                type=read.input_name,
                metavar="DIR",
                help="directories of runs, and of scans for all their points",
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
                help="a measured curve: two columns, units in their names, as time_us, force_N",
            ),
            option(
                "--as",
                dest="measured_as",
                default="bottom_force",
                metavar="NAME",
                help="figure that the measured curve lies over: bottom_force (default), "
                "peak_force_depth or fronts",
            ),
            option(
                "--shift",
                type=read.finite,
                default=0.0,
                metavar="X",
                help="add X, s or m, to the times or lengths that were measured",
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
        Command("cases", FIND, "the studies that come with the package", "granwave.workflows.cli.package:cases", (
            option("words", nargs="*", metavar="WORD", help="list only those whose name or title has all these words"),
            flag("--all", "list all, with what each is"),
            as_json("the list"),
        )),
        Command("show", FIND, "an editable copy of a built-in study, on stdout", "granwave.workflows.cli.package:show", (
            option("name", metavar="NAME", help="name of a built-in case or scan"),
        )),
        Command("keys", FIND, "keys of all files: unit, default, accepted values, example", "granwave.workflows.cli.package:keys", (
            option("table", nargs="*", metavar="TABLE", help="a table, as packing; a key, as packing.diameter; or words "
                    "of keys or descriptions (default: a list)"),
            [as_json("the tables and their keys"),
             option("--schema", choices=files, metavar="FILE",
                     help=f"print the JSON Schema of a kind of files, for editors: {', '.join(files)}")],
        )),
        Command("check", FIND, "what a run would be: size, memory, disk, timestep, time, overlap", "granwave.workflows.cli.check:check", (
            CASE, SET, RANKS,
            option("--picture", type=read.output_name, metavar="FILE.png",
                   help="draw the packing from the side and from above, .png or .pdf; both are written, with its grains as .csv"),
            as_json("the plan"),
        )),
        Command("run", RUNNING, "run a case: deck, LAMMPS, analysis, figures", "granwave.workflows.cli.running:run", (
            CASE, SET, directory(), RANKS,
            option("--checkpoint", type=read.seconds, default=60.0, metavar="SECONDS",
                    help="wall time between checkpoints (default: 60)"),
            NO_FIGURES, as_json("the summary"), RESUME_OR_FORCE,
        )),
        Command("scan", RUNNING, "run a case many times with some keys varied; table, figures and report", "granwave.workflows.cli.scan:scan", (
            option("scan", metavar="SCAN", help="a scan file, or the name of a built-in scan"),
            SET, directory(),
            option("--executor", default="local", metavar="local|slurm", help="where the points run (default: local)"),
            option("--profile", type=read.input_name, metavar="FILE",
                    help="how to use the cluster: partition, account, time, ..."),
            option("--jobs", type=read.positive, metavar="N",
                    help="jobs at once (default: the cores of this machine; 100 on a cluster)"),
            flag("--plan", "say what the scan would be, and run nothing"),
            as_json("the plan, or at the end all points and their values,"), RESUME_OR_FORCE,
        )),
        Command("write", RUNNING, "write the LAMMPS deck alone; it runs by hand: lmp -in in.granwave", "granwave.workflows.cli.running:write", (
            CASE, SET, directory("where the deck goes; required", required=True), FORCE,
        )),
        Command("analyse", RUNNING, "once more from the dumps: result.h5, figures, summary.json", "granwave.workflows.cli.running:analyse", (
            RUN, RANKS, NO_FIGURES, as_json("the summary"),
        )),
        Command("report", LOOK, "a page that compares any number of runs and scans", "granwave.workflows.cli.results:report", (
            option("directories", nargs="+", type=read.input_name, metavar="DIR", help="directories of runs and scans"),
            output("a file that ends in .html, .pdf or .md (default: report.html)", default=Path("report.html")),
            option("--study", action="append", default=[], metavar="NAME|FILE.py",
                    help="a study to make of all runs, by name or in a file of yours, beside those that scan and suite "
                    "files name; may be repeated"),
        )),
        _compare(),
        Command("figures", LOOK, "draw the figures of a run again, all or some", "granwave.workflows.cli.results:figures", (
            RUN,
            option("--only", type=read.words, metavar="NAME,...",
                    help="names of figures (default: those of the case, or all)"),
            *figure_options(*FIGURE_KEYS),
        )),
        Command("export", LOOK, "the results for other programs: ParaView, pandas, xarray, OVITO", "granwave.workflows.cli.results:export", (
            RUN_OR_SCAN, option("--to", required=True, metavar="FORMAT", help=f"one of {', '.join(export_names())}"),
            output("where to (default: DIR/export)", "DIR"),
        )),
        Command("law", CONTACTS, "force-overlap curves of a contact: a plot or a table", "granwave.workflows.cli.contacts:law", (
            materials("one or two: a name, or FILE.toml:NAME (default: brass)"),
            radii("one radius or two, m; the second may be inf, a plane (default: 0.005)"),
            option("--law", default="elastoplastic", choices=list(LAWS), help="contact law (default: elastoplastic)"),
            *(_law_parameter(p) for p in PARAMETERS.values() if set(laws_with(p)) & set(LAWS)),
            option("--cohesion", nargs=2, metavar=("KIND", "W"), help="jkr or dmt, and the work of adhesion, J/m^2"),
            option("--max-overlap", type=read.overlap, default=200.0, metavar="A",
                    help="largest overlap, in units of that at first yield (default: 200)"),
            option("--velocity", type=read.speed, default=0.0, metavar="V",
                    help="approach velocity, m/s, with --rate-sensitivity (default: slow)"),
            flag("--restitution", "coefficient of restitution against velocity instead, of two spheres and of a sphere "
                  "and a rigid wall"),
            output("a file that ends in .png, .pdf or .csv (default: law.png, restitution.png)"),
        )),
        Command("doctor", PACKAGE, "versions, plugin, MPI: what works and how to mend what does not", "granwave.workflows.cli.doctor:doctor", (
            option("--profile", type=read.input_name, metavar="FILE",
                    help="also check the profile of a cluster, on its login node"),
            as_json("the findings"),
        )),
        Command("selftest", PACKAGE, "known answers, plugin, MPI and restart, computed on this machine: run it first",
                "granwave.workflows.cli.selftest:selftest", (
            option("--np", dest="ranks", type=read.positive, default=2, metavar="N",
                    help="MPI ranks that must give the numbers of one (default: 2; 1 leaves that out)"),
            option("--profile", type=read.input_name, metavar="FILE",
                    help="profile of a cluster, whose launcher starts the ranks (default: mpiexec)"),
            as_json("the checks"),
        )),
        Command("bench", PACKAGE, "speed beside LAMMPS's own granular styles, on this machine", "granwave.workflows.cli.package:bench", (
            option("--json", type=read.output_name, metavar="FILE", help="write the results there too"),
            option("--repeats", type=read.positive, default=5, metavar="N", help="timings of each (default: 5)"),
            [option("--parts", type=read.bench_parts, default=BENCH_PARTS, metavar="PART,...",
                     help=f"what to measure: {', '.join(BENCH_PARTS)} (default: all, some ten minutes)"),
             option("--styles-only", action="store_const", const=("styles",), dest="parts",
                     help="the same as --parts styles")],
        )),
        Command("completion", PACKAGE, "code that switches on tab completion in a shell", "granwave.workflows.cli.completion:completion", (
            option("shell", choices=SHELLS, help="the shell: bash, zsh or fish"),
        )),
        Command(_HELP, PACKAGE, "this list, or the options of a command", "granwave.workflows.cli.package:show_help"),
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
        Words of the command line, if it is for these alone: then only the command that they name
        has its options.
    """
    parser = _Parser(
        prog="granwave", description="Impact and waves in ordered granular packings, on LAMMPS."
    )
    parser.add_argument("--version", action="version", version=f"granwave {__version__}")
    verbs = parser.add_subparsers(required=True, metavar=_COMMAND)
    parser._positionals._group_actions.clear()  # the groups list them
    listed = commands()
    used = {command.name for command in listed}
    if words and words[0] in used - {_HELP}:
        used = {words[0]}
    for title in dict.fromkeys(command.group for command in listed):
        group = parser.add_argument_group(title)
        first = len(verbs._choices_actions)
        for command in (command for command in listed if command.group == title):
            verb = verbs.add_parser(command.name, help=command.what, description=command.what)
            verb.set_defaults(command=command)
            if command.name in used:
                _add_options(verb, command)
        group._group_actions.extend(verbs._choices_actions[first:])
    shown = verbs.choices[_HELP]
    shown.add_argument(
        "name", nargs="?", choices=[*verbs.choices], metavar=_COMMAND, help="name of a command"
    )
    shown.set_defaults(parsers={None: parser, **verbs.choices})
    return parser


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
            if name == _COMMAND:
                owner = owner_left_out("commands", lambda command: command.name == found)
                hint = f"; {owner}" if owner else hint
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
    commands_by_option: dict[str, list[str]] = {}
    for command in commands():
        for entry in command.each_option():
            for name in entry.names:
                commands_by_option.setdefault(name, []).append(command.name)
    if having := commands_by_option.get(unknown):
        return keys * (unknown != "--set") + f"; it is an option of {', '.join(having)}"
    return did_you_mean(unknown, list(commands_by_option), cutoff=0.8) or keys
