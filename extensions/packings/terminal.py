"""Command ``granwave bed``: makes the bed of a case, prints and draws its statistics."""

from __future__ import annotations

import argparse

from granwave.analysis.summary_table import lines
from granwave.extensions.packings.makers import MAKERS
from granwave.extensions.packings.recipe import bed_file, bed_of
from granwave.lammps_inputs.case.packing.made_packing import maker_input
from granwave.lammps_inputs.case.parse import apply_overrides, parse_overrides
from granwave.lammps_inputs.case.schema import ErrorList, show
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_toml
from granwave.workflows import library
from granwave.workflows.cli.terminal import print_json
from granwave.workflows.solvers import GRANULAR


def bed(options: argparse.Namespace) -> int:
    """Execute ``granwave bed``; return the exit status."""
    from granwave.analysis.figures.style import save_as
    from granwave.extensions.packings.bed_statistics import (
        statistics_of,
        statistics_rows,
        statistics_values,
    )
    from granwave.extensions.packings.figures import bed_figure

    path = library.find_for(options.case, GRANULAR.verb)
    tables = apply_overrides(read_toml(path), parse_overrides(options.overrides))
    errors = ErrorList(str(path))
    given = maker_input(tables, path, errors)
    kind = given.tables["packing"].get("kind") if given is not None else None
    maker = next((maker for maker in MAKERS if maker.kind == kind), None)
    if given is not None and maker is None:
        kinds = " or ".join(show(maker.kind) for maker in MAKERS)
        raise InputError(
            f"{path}: packing.kind: found {show(kind or '')}, expected {kinds}: other packings "
            "have no bed"
        )
    recipe = maker.read(given, errors) if given is not None and maker is not None else None
    errors.report(path.stem)
    assert given is not None
    assert recipe is not None
    made = bed_of(recipe, given)
    found = statistics_of(recipe, made)
    file = bed_file(recipe, given.source)
    if options.output is not None:
        drawing = bed_figure(recipe, made)
        save_as(options.output, drawing.columns, lambda: drawing)
    if options.json:
        print_json({"bed": str(file.path), **statistics_values(found)})
        return 0
    rows = statistics_rows(found, friction=bool(recipe.friction))
    print(f"{lines(rows)}\n\nbed in {file.path}")
    return 0
