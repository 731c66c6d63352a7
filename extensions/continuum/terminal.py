"""Commands ``granwave continuum`` and ``granwave fit``; each returns the exit status."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from granwave.analysis.summary_table import rows_of, summary_table
from granwave.extensions.continuum.kinds import CONTINUUM
from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_toml
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.workflows import library
from granwave.workflows.cli.contacts import RADII, are_radii, at_most_two, material_of
from granwave.workflows.cli.running import how_to_run, warn_of_zone
from granwave.workflows.cli.terminal import columns, print_json
from granwave.workflows.run.directory import held
from granwave.workflows.solvers import solver_of

if TYPE_CHECKING:
    from granwave.analysis.figures.style import Drawing
    from granwave.extensions.continuum.law_fit.fitted_law import FittedLaw
    from granwave.lammps_inputs.case.material import Material


def continuum(options: argparse.Namespace) -> int:
    """Execute ``granwave continuum``."""
    path = library.find_for(options.case, CONTINUUM)
    kind = solver_of(read_toml(path))
    case = kind.load(path, options.overrides)
    directory = results_directory(options.directory or case.name)
    if not options.resume:  # a finished run needs no resources
        kind.afford(case, kind.cost(case, 1, options.figures), directory)
    assert kind.run is not None  # continuum cases have a run
    results = ResultDirectory(directory)
    with held(results):
        summary = kind.run(case, directory, progress=True, **how_to_run(options))
    if options.json:
        print_json(summary)
    else:
        table = summary_table(summary, rows_of(results.kind.rows))
        print(f"{table}\n\nresults in {directory}")
    warn_of_zone(summary, results.path, results.kind.body)
    return 0


def fit(options: argparse.Namespace) -> int:
    """Execute ``granwave fit``."""
    from granwave.extensions.continuum.law_fit.fit_output import WRITTEN, pair_toml, write_fit

    at_most_two(options)
    if not are_radii(options.radius):
        raise InputError(RADII)
    pair: list[str] | None = options.pair
    directory: Path = options.directory or Path("fit")
    results = ResultDirectory(results_directory(directory))
    if not results.path.parent.is_dir():
        raise InputError(f"-o {directory}: no such directory: {directory.absolute().parent}")
    if set(WRITTEN) & set(results.result_names()):
        if not options.force:
            raise InputError(f"{directory}: already holds a fit; {results.by_force}")
        results.refuse_immovable()
    results.refuse_foreign(WRITTEN)
    materials = [material_of(text) for text in options.material]
    found, drawing = _fitted(options, materials)
    with held(results):
        results.make_room(force=options.force, names=WRITTEN)
        written = write_fit(found, results, drawing, pair)
    print(fit_summary(found))
    if pair:
        print(f"\n{pair_toml(found, pair)}")
    print(
        f"\n{written[0]} contains [contact] for a case file, and can be run: granwave run "
        f"{written[0]}"
    )
    return 0


def _fitted(
    options: argparse.Namespace, materials: Sequence[Material]
) -> tuple[FittedLaw, Callable[[], Drawing]]:
    """Fit the law to the measurements of a file, and return the function that draws the figure."""
    from granwave.extensions.continuum.law_fit.rebounds import holds_rebounds

    if holds_rebounds(options.curve):
        return _fitted_to_rebounds(options, materials)
    from granwave.analysis.contact_law.curves import read_curve
    from granwave.extensions.continuum.law_fit.fit import fit_law
    from granwave.extensions.continuum.law_fit.fit_output import fit_drawing

    found = fit_law(
        read_curve(options.curve, any_zero=options.fit_zero),
        materials,
        options.radius,
        options.free,
        fit_yield=options.fit_yield,
        fit_zero=options.fit_zero,
    )
    return found, partial(fit_drawing, found)


def _fitted_to_rebounds(
    options: argparse.Namespace, materials: Sequence[Material]
) -> tuple[FittedLaw, Callable[[], Drawing]]:
    from granwave.extensions.continuum.law_fit.rebound_drawing import rebound_drawing
    from granwave.extensions.continuum.law_fit.rebounds import read_rebounds
    from granwave.extensions.continuum.law_fit.restitution_fit import fit_restitution

    if options.fit_zero:
        raise InputError(
            f"--fit-zero: found with {options.curve}, a table of restitution; remove the option, "
            "or use a force-overlap curve"
        )
    found = fit_restitution(
        read_rebounds(options.curve), materials, options.radius, options.free or ()
    )
    return found, partial(rebound_drawing, found)


def fit_summary(found: FittedLaw) -> str:
    """Format the constants with their uncertainties, and the misfits, for the terminal."""
    from granwave.extensions.continuum.law_fit.fit_output import constants_table

    rows = [["constant", "value", "+-", "published", ""]]
    for name, value, spread, published, how in zip(*constants_table(found).values(), strict=True):
        rows.append(
            [
                name,
                f"{value:.5g}",
                f"{spread:.2g}" if spread == spread else "",
                f"{published:.5g}",
                how,
            ]
        )
    fits = [["error (%)", "rows", "rms", "largest", "published rms", "largest"]]
    for part, n_rows, *numbers in found.misfit.itertuples(index=False):
        fits.append([part, str(n_rows), *(f"{number:.3g}" for number in numbers)])
    text = f"{columns(rows, left=(0, 4))}\n\n{columns(fits, left=(0,))}\n"
    text += f"({found.scale})"
    if found.correlation:
        text += (
            f"\nerrors of neighbouring rows are correlated ({found.correlation:.2f}): the "
            "uncertainties account for this"
        )
    return text
