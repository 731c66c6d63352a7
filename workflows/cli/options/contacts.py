"""Options of the commands about single contacts: laws, fits, and forces inferred from measurements."""

from __future__ import annotations

import argparse

from granwave.lammps_inputs.case.contact import LAWS
from granwave.workflows.cli import commands
from granwave.workflows.cli.arguments import count, hertz, input_name, number, output_name, overlap, radius, shares
from granwave.workflows.cli.options import shared


def add_law(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave law``."""
    parser = shared.command(verbs, "law", commands.law, "force-overlap curves of a contact: a plot or a table")
    parser.add_argument(
        "--material", nargs="+", default=["brass"], metavar="M", help="one material or two (default: brass)"
    )
    parser.add_argument(
        "--radius", nargs="+", type=radius, default=[0.005], metavar="R", help="one radius or two, m (default: 0.005)"
    )
    parser.add_argument(
        "--law", default="elastoplastic", choices=list(LAWS), help="contact law (default: elastoplastic)"
    )
    parser.add_argument(
        "--variant",
        default="continuous",
        choices=["continuous", "published"],
        help="constants of the elasto-plastic law, as contact.variant (default: continuous)",
    )
    parser.add_argument(
        "--max-overlap",
        type=overlap,
        default=200.0,
        metavar="A",
        help="largest overlap, in units of that at first yield (default: 200)",
    )
    parser.add_argument(
        "--restitution",
        action="store_true",
        help="coefficient of restitution against velocity instead, of two spheres and of a sphere and a rigid wall",
    )
    parser.add_argument(
        "-o",
        dest="output",
        type=output_name,
        metavar="FILE",
        help="a file that ends in .png, .pdf or .csv (default: law.png, restitution.png)",
    )


def add_fit(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave fit``."""
    parser = shared.command(
        verbs, "fit", commands.fit, "fit the contact law's constants to a measured or computed curve"
    )
    parser.add_argument(
        "curve",
        type=input_name,
        metavar="CURVE.csv",
        help="columns overlap_m and force_N (or overlap_um, force_kN, ...), perhaps branch",
    )
    parser.add_argument(
        "--material", nargs="+", default=["brass"], metavar="M", help="one or two: a name, or FILE.toml:NAME"
    )
    parser.add_argument(
        "--radius", nargs="+", type=radius, default=[0.005], metavar="R",
        help="one radius or two, m; the second may be inf, a plane (default: 0.005)",
    )  # fmt: skip
    parser.add_argument(
        "--free", nargs="+", metavar="NAME", help="constants to fit (default: all that the curve can tell)"
    )
    parser.add_argument(
        "--pair", nargs=2, metavar=("A", "B"), help="also write pair.toml: the law of these two materials in a case"
    )
    parser.add_argument("--fit-yield", action="store_true", help="fit the yield strength too")
    parser.add_argument(
        "-o", dest="directory", type=output_name, metavar="DIR", help="where everything goes (default: ./fit)"
    )
    parser.add_argument("--force", action="store_true", help="replace the fit that is there")


def add_infer(verbs: argparse._SubParsersAction) -> None:
    """Add ``granwave infer``."""
    parser = shared.command(
        verbs, "infer", commands.infer, "contact forces from measured grains, or from measurements made of a run"
    )
    parser.add_argument(
        "measurement",
        type=input_name,
        metavar="GRAINS.csv|RUN",
        help="table of measured grains; or directory of a run with output.contact_forces, to plan an experiment",
    )
    parser.add_argument(
        "--case", type=input_name, metavar="FILE", help="file with [material] and [infer]; a run can do without"
    )
    parser.add_argument(
        "--noise",
        type=shares,
        metavar="SHARE,...",
        help="errors of strains and accelerations of a run, over their root mean squares; several for a curve",
    )
    parser.add_argument(
        "--frame-rate",
        type=hertz,
        metavar="HZ",
        help="accelerations of a run from the places in three frames of such a camera",
    )
    parser.add_argument(
        "--position-noise", type=radius, metavar="M", help="errors of the places in these frames (default: none)"
    )
    parser.add_argument(
        "--time", type=number, metavar="S", help="instant of a run (default: the snapshot with the largest forces)"
    )
    parser.add_argument(
        "--repeat", type=count, metavar="N", help="repetitions with noise (default: infer.repetitions; of a run 10)"
    )
    shared.output_directory(parser)
    shared.no_figures(parser)
    shared.as_json(parser, "the summary")
    parser.add_argument("--force", action="store_true", help="replace what is there")
