"""Command of poured and compressed packings: ``granwave bed``."""

from granwave.workflows.cli.commands import CASE, FIND, SET, Command, as_json, output

COMMANDS = (
    Command(
        "bed",
        FIND,
        "generate the bed of a case with poured or compressed grains, and print its statistics",
        "granwave.extensions.packings.terminal:bed",
        (
            CASE,
            SET,
            output("figure of the bed (.png, .pdf) or its table (.csv)"),
            as_json("the statistics"),
        ),
        after="check",
    ),
)
