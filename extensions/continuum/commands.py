"""Commands of finite elements and of fits: ``granwave continuum`` and ``fit``."""

from __future__ import annotations

from granwave.workflows.cli import arguments as read
from granwave.workflows.cli.commands import (
    CASE,
    CONTACTS,
    NO_FIGURES,
    RESUME_OR_FORCE,
    RUNNING,
    SET,
    Command,
    as_json,
    directory,
    flag,
    materials,
    option,
    radii,
)

COMMANDS = (
    Command(
        "continuum",
        RUNNING,
        "run the continuum reference: a rigid punch on an elastic-plastic block",
        "granwave.extensions.continuum.terminal:continuum",
        (CASE, SET, directory(), NO_FIGURES, as_json("the summary"), RESUME_OR_FORCE),
        after="scan",
    ),
    Command(
        "fit",
        CONTACTS,
        "fit the contact law to a force-overlap curve, or to measured restitution",
        "granwave.extensions.continuum.terminal:fit",
        (
            option(
                "curve",
                type=read.input_name,
                metavar="CURVE.csv",
                help="columns overlap_m and force_N (or overlap_um, force_kN, ...), and "
                "optionally branch; or velocity_m_s and restitution",
            ),
            materials("one or two materials: a name, or FILE.toml:NAME"),
            radii("one or two radii, m; the second may be inf, a plane (default: 0.005)"),
            option(
                "--free",
                nargs="+",
                metavar="NAME",
                help="constants to fit (default: all constants that the curve determines)",
            ),
            option(
                "--pair",
                nargs=2,
                metavar=("A", "B"),
                help="also write pair.toml: the law of these two materials in a case",
            ),
            flag("--fit-yield", "also fit the yield strength"),
            flag("--fit-zero", "also fit the zero of the overlap: the reading at first contact, m"),
            directory("directory of the results (default: ./fit)"),
            flag("--force", "move an existing fit to DIR.old (DIR.old2, ...)"),
        ),
        after="law",
    ),
)
