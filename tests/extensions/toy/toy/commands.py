"""Commands of the extension, which are listed without loading what they run."""

from pathlib import Path

from granwave.workflows.cli.commands import LOOK, Command, option

COMMANDS = (
    Command(
        "participation",
        LOOK,
        "participation of the contacts in an impact",
        "toy.results:participation",
        (option("directory", type=Path, metavar="DIR", help="directory of a run"),),
    ),
)
