"""Command ``granwave infer``."""

from __future__ import annotations

import argparse

from granwave.extensions.inference import run as inference
from granwave.workflows.cli.commands import chosen
from granwave.workflows.cli.results import as_wrong_input
from granwave.workflows.cli.terminal import print_json


@as_wrong_input()
def infer(options: argparse.Namespace) -> int:
    """Execute ``granwave infer``."""
    from granwave.extensions.inference.forces.tables import in_words

    directory = inference.results_place(options.directory or "infer", force=options.force)
    how = chosen(options, inference.infer)
    found = inference.infer(options.measurement, options.case, progress=True, **how)
    inference.save(found, directory, force=options.force, figures=options.figures)
    if options.json:
        print_json(found.summary)
    else:
        print(f"{in_words(found.summary)}\n\nresults in {directory}")
    return 0
