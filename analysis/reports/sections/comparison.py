"""Runs against each other, and packings against the continuum: figures and tables as of thesis chapter 5."""

from __future__ import annotations

from granwave.analysis.document.model import Block, Gallery, Note, Section
from granwave.analysis.figures.style import style
from granwave.analysis.reports.inputs import Inputs
from granwave.analysis.reports.sections.studies import pictures_of, row_tables
from granwave.analysis.studies.granular_continuum.impacts import collect
from granwave.analysis.studies.registry import COMPARISON
from granwave.analysis.studies.runs import ContinuumRun, FinishedRun, read_run
from granwave.analysis.studies.study import Study, make_studies

SLUG = "comparison"


def comparison_section(inputs: Inputs) -> Section:
    """The section of the report; without blocks where there is nothing to compare.

    Runs whose energy balance was refused are left out, with a line that says so.
    """
    blocks: list[Block] = []
    for study in comparison_of(inputs):
        if study.pictures:
            with style():
                gallery = Gallery(pictures_of(study, inputs, SLUG))
            blocks += [Note(study.text), gallery, *row_tables(study), *study.tables]
    if blocks and (refused := [run.label for run in inputs.whole() if run.status == "refused"]):
        blocks.append(Note(f"Left out here, as the energy balance did not close: {', '.join(refused)}.", "bad"))
    return Section("Comparison", SLUG, tuple(blocks))


def comparison_of(inputs: Inputs) -> list[Study]:
    """Comparison of a report's runs; empty if none can be compared."""
    whole = [run for run in inputs.whole() if run.has_balance and run.status != "refused"]
    found = [read_run(run.label, run.directory, run.summary) for run in whole]
    runs = [run for run in found if isinstance(run, FinishedRun | ContinuumRun)]
    impacts = collect(runs)
    if len(impacts.granular) + len(impacts.continuum) < 2:
        return []
    return make_studies(dict.fromkeys(COMPARISON, runs))
