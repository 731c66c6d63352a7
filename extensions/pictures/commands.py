"""Commands of views and animations: ``granwave view`` and ``film``."""

from __future__ import annotations

from collections.abc import Iterable

from granwave.workflows.cli import arguments as read
from granwave.workflows.cli.commands import (
    LOOK,
    RUN,
    Command,
    figure_options,
    flag,
    option,
    output,
)

#: Keys of ``[figures]`` with an option for animations.
FILM_KEYS = ("plane", "colour_map", "force_limits", "dissipation_limits")


def _quantities() -> Iterable[str]:
    from granwave.extensions.pictures.films import QUANTITIES

    return QUANTITIES


def _views() -> Iterable[str]:
    from granwave.extensions.pictures.films import VIEWS

    return VIEWS


COMMANDS = (
    Command(
        "view",
        LOOK,
        "make a page to rotate and cut the packing of a run in a browser",
        "granwave.extensions.pictures.terminal:view",
        (
            RUN,
            output("name of the page, .html (default: DIR/view.html)"),
            [
                option(
                    "--spheres",
                    type=read.positive,
                    metavar="N",
                    help="largest number of spheres, nearest to the impacted sphere (default: "
                    "250000)",
                ),
                flag("--all", "all spheres and snapshots, without limits"),
            ],
            option("--frames", type=read.positive, metavar="N", help="largest number of snapshots"),
        ),
        after="figures",
    ),
    Command(
        "film",
        LOOK,
        "make an animation of a run: planes, the cut packing, or a chain in space-time",
        "granwave.extensions.pictures.terminal:film",
        (
            RUN,
            output("a file that ends in .mp4, .gif or .webp", required=True),
            option(
                "--quantity",
                default="force",
                metavar="NAME",
                words=_quantities,
                help="quantity: force, velocity or dissipation (default: force)",
            ),
            option(
                "--view",
                metavar="NAME",
                words=_views,
                help="view: principal, orthogonal, section, 3d or chain (default: the chain in "
                "space-time, or the first plane that the packing has)",
            ),
            [
                option(
                    "--width",
                    type=read.positive,
                    default=1200,
                    metavar="PIXELS",
                    help="width of the frames in pixels (default: 1200)",
                ),
                option(
                    "--size",
                    metavar="NAME|WxH",
                    help="slide (1920 × 1080), page (1200 × 900), or width × height in pixels",
                ),
            ],
            *figure_options(*FILM_KEYS),
            option(
                "--rate",
                type=read.number,
                metavar="N",
                help="frames per second (default: 3 to 25)",
            ),
        ),
        after="view",
    ),
)
