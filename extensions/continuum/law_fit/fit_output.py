"""Output files of a fit of the contact law: fit.toml, pair.toml, fit.csv, misfit.csv, and the
figure fit.
"""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import tomli_w

from granwave.analysis.figures.series import panels
from granwave.analysis.figures.style import (
    BLUE,
    GREY,
    ORANGE,
    Columns,
    Drawing,
    FigureFolder,
    style,
    write_csv,
)
from granwave.extensions.continuum.files import (
    FIT,
    FIT_FILES,
    FIT_MISFIT,
    FIT_PAIR,
    FIT_TABLE,
    FIT_TOML,
)
from granwave.extensions.continuum.law_fit.fit import Fit, bearing, deviation
from granwave.extensions.continuum.law_fit.fitted_law import YIELD, FittedLaw
from granwave.extensions.continuum.law_fit.zero import ZERO
from granwave.lammps_inputs.case.contact.contact import LAW_CONSTANTS
from granwave.lammps_inputs.files import replace_text, replacing
from granwave.lammps_inputs.own_files import AnyPath, figure_files
from granwave.lammps_inputs.result_directory import ResultDirectory

FIGURE = "fit"
WRITTEN = (*FIT_FILES, *figure_files(FIGURE))

_MICRO = 1e6  # micrometres in a metre
_POINTS = 300


def write_fit(
    fit: FittedLaw,
    directory: AnyPath,
    drawing: Callable[[], Drawing],
    pair: Sequence[str] | None = None,
) -> list[Path]:
    """Write fit.toml, fit.csv, misfit.csv and figures/fit (.png, .pdf, .csv) into a directory,
    created if necessary.

    An existing fit is replaced.

    Parameters
    ----------
    drawing
        Function that draws the figure.
    pair
        Names of two materials for pair.toml, see `pair_toml`; None: it is not written.

    Returns
    -------
    list of Path
        Paths of the files.

    Raises
    ------
    InputError
        A file of such a name exists, and granwave did not write it.
    """
    results = ResultDirectory.at(directory)
    directory = results.path
    directory.mkdir(parents=True, exist_ok=True)
    results.clear(WRITTEN)
    files = [FIT_TOML, *([FIT_PAIR] if pair else []), FIT_TABLE, FIT_MISFIT]
    results.claim([*files, *figure_files(FIGURE)], kind=results.marker.kind or FIT)
    replace_text(directory / FIT_TOML, fit_toml(fit))
    misfit = fit.misfit.assign(part=fit.misfit.part.str.strip()).to_dict("list")
    for name, table in ((FIT_TABLE, constants_table(fit)), (FIT_MISFIT, misfit)):
        with replacing(directory / name) as scratch:
            write_csv(table, scratch)
    if pair:
        replace_text(directory / FIT_PAIR, pair_toml(fit, pair))
    folder = FigureFolder(results)
    with style():
        folder.draw(drawing, FIGURE)
    return [directory / name for name in files] + folder.written


def constants_table(fit: FittedLaw) -> Columns:
    """Return the columns of fit.csv: a row for each constant, and for the yield strength (Pa) and
    the zero of the overlap (m) if they were fitted.
    """
    names = [*LAW_CONSTANTS, *(name for name in (YIELD, ZERO) if name in fit.uncertainty)]
    return {
        "constant": names,
        "value": np.array([fit.value(name) for name in names]),
        "standard_uncertainty": np.array([fit.uncertainty.get(name, math.nan) for name in names]),
        "published": np.array([fit.published_value(name) for name in names]),
        "state": [fit.state(name) for name in names],
    }


def fit_toml(fit: FittedLaw) -> str:
    """Return the text of a case of two such spheres, whose tables [contact] and [material] may be
    copied to other cases.
    """
    softer = fit.softer_material
    material = {
        key: value for key, value in dataclasses.asdict(softer).items() if value is not None
    }
    diameter = 2 * min(fit.radii)
    lines = [
        f"# Elasto-plastic contact law fitted to {Path(fit.source).name} ({fit.n_rows} rows).",
        "# Copy [contact] and [material] into your case, and run it: granwave run case.toml",
        "# This file is also a case, with two such spheres: granwave run fit.toml",
        *(
            f"# off by {part.rms_percent:.3g} % rms, {part.largest_percent:.3g} % at most: "
            f"{part.part}"
            for part in fit.misfit.itertuples()
            if not part.part.startswith(" ")
        ),
    ]
    lines += [f"# {note}" for note in fit.notes]
    if len(fit.materials) == 2 and fit.materials[0] != fit.materials[1]:
        lines.append(
            "# The curve belongs to two materials: [material] below is the softer; --pair A B "
            "writes the law for the pair."
        )
    lines += ["", 'name = "fitted"', "", "[contact]", *_law_lines(fit), "", ""]
    tables = {
        "material": material,
        "packing": {"kind": "chain", "size": 2, "diameter": diameter},
        "load": {"velocity": 1.0},
        "boundary": {"bottom": "free"},
        "run": {"end_time": "auto"},
    }
    return "\n".join(lines) + tomli_w.dumps(tables)


def pair_toml(fit: FittedLaw, materials: Sequence[str]) -> str:
    """Return the fitted law as a table ``[[pair]]`` for two materials of a case; "rigid" is a rigid
    wall.

    Parameters
    ----------
    materials
        Names of the two materials in the case.
    """
    softer = fit.softer_material
    lines = [
        f"# Elasto-plastic contact law fitted to {Path(fit.source).name}; append it to a case.",
        f"# It requires a yield strength of {softer.yield_strength:g} Pa of the softer material.",
        "[[pair]]",
        f"materials = {json.dumps(list(materials))}",
        *_law_lines(fit),
    ]
    return "\n".join(lines) + "\n"


def _law_lines(fit: FittedLaw) -> list[str]:
    """Return the keys of the law, each constant with its uncertainty."""
    lines = ['law = "elastoplastic"', 'variant = "continuous"']
    for name, value, spread, published, how in zip(*constants_table(fit).values(), strict=True):
        if name not in (YIELD, ZERO):
            note = f"+- {spread:.2g}, " if math.isfinite(spread) else ""
            lines.append(f"{name} = {toml_number(value)}  # {note}{how}; published {published:g}")
    return lines


def toml_number(value: float) -> str:
    """Format a number with ten digits, always as a float of TOML."""
    text = f"{value:.10g}"
    return text if any(mark in text for mark in ".e") else f"{text}.0"


def fit_drawing(fit: Fit) -> Drawing:
    """Draw the curve with both laws, and their deviations below."""
    curve = fit.curve
    off = deviation(curve, fit.law)
    published_off = deviation(curve, fit.published)
    figure, above, below = panels(4.0, rows=2, sharex=True, height_ratios=(3, 2))
    loading = curve.loading
    overlap = curve.overlap * _MICRO
    few = slice(None, None, max(curve.force.size // 400, 1))
    above.plot(
        overlap[few], curve.force[few], "o", color="black", ms=2, mfc="none", mew=0.4, label="curve"
    )
    grid = np.linspace(0, curve.peak.max(), _POINTS)
    for law, colour, line, label in (
        (fit.published, GREY, "--", "published constants"),
        (fit.law, BLUE, "-", "fit"),
    ):
        above.plot(grid * _MICRO, law.loading_force(grid), line, color=colour, lw=0.8, label=label)
        for turn in curve.turns:
            path = np.linspace(float(law.residual_overlap(np.array([turn]))[0]), turn, _POINTS)
            above.plot(
                path * _MICRO, law.force(path, np.full_like(path, turn)), line, color=colour, lw=0.8
            )
    for rows, colour, label in (
        (loading, BLUE, "loading"),
        (~loading & bearing(curve), ORANGE, "unloading and reloading"),
    ):
        if rows.any():
            below.plot(overlap[rows], off[rows], ".", color=colour, ms=2, label=label)
    below.axhline(0, color="black", lw=0.5)
    limit = 1.1 * float(np.abs(off[curve.peak > fit.law.yield_overlap]).max(initial=0.0))
    below.set_ylim(-max(limit, 1e-3), 1.4 * max(limit, 1e-3))
    above.set(ylabel="Force (N)", xlim=(0, None), ylim=(0, None))
    below.set(xlabel="Overlap (µm)", ylabel="Fit minus curve (%)")
    above.legend(loc="upper left")
    below.legend(loc="upper left", ncols=2, markerscale=3)
    return Drawing(
        figure,
        {
            "branch": curve.branch,
            "overlap_m": curve.overlap,
            "force_N": curve.force,
            "fit_N": fit.law.force(curve.overlap, curve.peak),
            "deviation_percent": off,
            "published_N": fit.published.force(curve.overlap, curve.peak),
            "published_deviation_percent": published_off,
        },
    )
