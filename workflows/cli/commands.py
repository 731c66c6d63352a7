"""Commands and their options as data, and the options that several commands share.

A command is declared here or by an extension; its function is loaded when the command is run, so
that a module of declarations imports neither numpy nor the code of the command.
"""

from __future__ import annotations

import argparse
import dataclasses
import inspect
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from granwave.lammps_inputs.case.material import presets
from granwave.lammps_inputs.extensions import load
from granwave.workflows.cli import arguments as read

# headings of the list of commands
FIND = "find and check a case"
RUNNING = "run"
LOOK = "look at results"
CONTACTS = "contacts"
PACKAGE = "the installation"


@dataclasses.dataclass(frozen=True)
class Option:
    """An argument of a command.

    Attributes
    ----------
    names
        Its names, as ``("-o",)``; of a positional argument the name of its value.
    settings
        Settings of ``ArgumentParser.add_argument``.
    words
        Function that returns the words that a shell completes its value by. None: names of files,
        or the choices of the settings.
    """

    names: tuple[str, ...]
    settings: dict[str, Any]
    words: Callable[[], Iterable[str]] | None = None

    @property
    def destination(self) -> str:
        """Name of the value among the parsed options."""
        name: str = self.settings.get("dest") or self.names[0].lstrip("-").replace("-", "_")
        return name


@dataclasses.dataclass(frozen=True)
class Command:
    """A command of granwave.

    Attributes
    ----------
    group
        Heading that it is listed under, as `RUNNING`.
    what
        Its line in the list of commands, and the description in its help.
    function
        Reference, "MODULE:NAME", of the function that is called with the parsed options and returns
        the exit status; its module is loaded then.
    options
        Its options; of options in a list only one may be given.
    after
        Command that it is listed behind; empty: it is the last one of its group.
    """

    name: str
    group: str
    what: str
    function: str
    options: tuple[Option | list[Option], ...] = ()
    after: str = ""

    def run(self, options: argparse.Namespace) -> int:
        """Call the function; return the exit status."""
        return int(load(self.function)(options))

    def each_option(self) -> Iterator[Option]:
        """Iterate over all options, including options in lists."""
        for entry in self.options:
            if isinstance(entry, Option):
                yield entry
            else:
                yield from entry


def chosen(options: argparse.Namespace, function: Callable[..., Any]) -> dict[str, Any]:
    """Return the options that a function has parameters for, by name."""
    return {
        name: getattr(options, name)
        for name in inspect.signature(function).parameters
        if hasattr(options, name)
    }


# ----------------------------------------------------------------------------- functions that make
# options


def option(
    *names: str, words: Callable[[], Iterable[str]] | None = None, **settings: Any
) -> Option:
    """Make an option; settings as of ``ArgumentParser.add_argument``, words as of `Option`."""
    return Option(names, settings, words)


def flag(name: str, what: str, **settings: Any) -> Option:
    """Make an option without a value."""
    return Option((name,), {"action": "store_true", "help": what, **settings})


def directory(what: str = "directory of the results (default: ./NAME)", **settings: Any) -> Option:
    """Make the option of a directory of results, ``options.directory``."""
    return option(
        "-o", dest="directory", type=read.output_name, metavar="DIR", help=what, **settings
    )


def output(what: str, metavar: str = "FILE", **settings: Any) -> Option:
    """Make the option of a file that is written, ``options.output``."""
    return option(
        "-o", dest="output", type=read.output_name, metavar=metavar, help=what, **settings
    )


def as_json(what: str) -> Option:
    """Make the option ``--json``."""
    return flag("--json", f"print {what} as JSON, and nothing else")


def materials(what: str) -> Option:
    """Make the option for the materials of one or two bodies."""
    return option(
        "--material",
        nargs="+",
        default=["brass"],
        metavar="M",
        help=what,
        words=presets,
    )


def radii(what: str) -> Option:
    """Make the option for the radii of one or two bodies, m."""
    return option("--radius", nargs="+", type=read.radius, default=[0.005], metavar="R", help=what)


# --------------------------------------------------------------------- options of several commands

CASE = option("case", metavar="CASE", help="a case file, or the name of a built-in case")
SOURCE = option(
    "case",
    metavar="CASE",
    help="a case file, the name of a built-in case, or the directory of a finished run",
)
RUN = option("directory", type=read.input_name, metavar="DIR", help="directory of a run")
RUN_OR_SCAN = option(
    "directory", type=read.input_name, metavar="DIR", help="directory of a run or a scan"
)
SET = option(
    "--set", dest="overrides", action="append", default=[], metavar="KEY=VALUE",
    help="override a key: --set load.velocity=10 --set packing.size=[24,24,12] (may be repeated)",
)  # fmt: skip
RANKS = option(
    "--np",
    dest="ranks",
    type=read.positive,
    default=1,
    metavar="N",
    help="number of MPI ranks (default: 1)",
)
NO_FIGURES = flag("--no-figures", "do not draw figures", dest="figures", action="store_false")
FORCE = flag(
    "--force", "move existing results to DIR.old (DIR.old2, ...) and restart from the beginning"
)
RESUME_OR_FORCE = [flag("--resume", "continue with existing results"), FORCE]
SUBMIT = option(
    "--submit",
    nargs="?",
    const=True,
    type=read.input_name,
    metavar="PROFILE",
    help=(
        "submit it as jobs to the cluster described by PROFILE (default: a standard Slurm "
        "installation)"
    ),
)
PRINT = flag("--print", "with --submit: print the script of the (first) job, and submit nothing")
CHAIN = option(
    "--chain",
    type=read.positive,
    metavar="N",
    help="with --submit: N jobs, each of which continues from the checkpoint of the previous one",
)

# ----------------------------------------------------------------------- options of figures

THROUGH = option(
    "--through", metavar="X,Y,Z", help="a point of the plane, m (default: the impacted sphere)"
)
#: Keys of ``[figures]`` that have an option.
FIGURE_KEYS = {
    "plane": option(
        "--plane", metavar="x|y|z|X,Y,Z",
        help="normal of an additional plane through the impacted sphere; the names of its figures "
            "end in _section",
    ),
    "depths": option(
        "--depths", metavar="METRES,...",
        help="depths of the figure force_at_depths, below the impacted sphere",
    ),
    "colour_map": option(
        "--colour-map", metavar="NAME", help="matplotlib colour map of all figures that use one"
    ),
    "force_limits": option(
        "--force-limits", metavar="LOW,HIGH", help="limits of the colour scale of forces, in the "
            "unit of the figure"
    ),
    "dissipation_limits": option(
        "--dissipation-limits", metavar="LOW,HIGH",
        help="limits of the colour scale of dissipation, relative to the energy input",
    ),
    "width": option("--width", metavar="METRES", help="width of a single-column figure, m "
        "(default: 0.08636)"),
    "formats": option(
        "--formats", metavar="NAME,...", help="formats in addition to PNG and CSV: pdf, svg, "
            "pdf,svg or none (default: pdf)"
    ),
}  # fmt: skip


def figure_options(*keys: str) -> list[Option]:
    """Return the options of a plane, and of further keys of `FIGURE_KEYS`."""
    further = (FIGURE_KEYS[key] for key in keys if key != "plane")
    return [FIGURE_KEYS["plane"], THROUGH, *further]
