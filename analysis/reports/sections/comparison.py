"""Runs against each other, and packings against the continuum: figures and tables as of thesis chapter 5."""

from __future__ import annotations

from collections.abc import Sequence

from granwave.analysis.document.cells import named
from granwave.analysis.document.model import Block, Note, Section
from granwave.analysis.figures.style import style
from granwave.analysis.reports.inputs import Inputs
from granwave.analysis.reports.sections.studies import pictures_of, row_tables
from granwave.analysis.studies.granular_continuum.impacts import collect, why_not
from granwave.analysis.studies.registry import COMPARISON
from granwave.analysis.studies.runs import ContinuumRun, FinishedRun, read_run
from granwave.analysis.studies.study import Study, make_studies

SLUG = "comparison"


def comparison_section(inputs: Inputs) -> Section:
    """The section of the report; without blocks where there is nothing to compare.

    Runs whose energy balance was refused are left out, with a line that says so.
    """
    blocks: list[Block] = []
    runs = _runs(inputs)
    for study in _compared(runs):
        if study.pictures or study.failed:
            with style():
                pictures = pictures_of(study, inputs, SLUG)
            blocks += [Note(study.text), *pictures, *row_tables(study), *study.tables]
    if blocks and (refused := [run.label for run in inputs.whole() if run.status == "refused"]):
        blocks.append(Note(f"Left out here, as the energy balance did not close: {', '.join(refused)}.", "bad"))
    left_out: dict[str, list[str]] = {}
    for run in runs:
        if blocks and isinstance(run, FinishedRun) and (reason := why_not(run)):
            left_out.setdefault(reason, []).append(run.label)
    if left_out:
        texts = "; ".join(f"{named(labels)} ({reason})" for reason, labels in left_out.items())
        blocks.append(Note(f"Left out here, as only impacts on ideal elasto-plastic packings are compared: {texts}."))
    return Section("Comparison", SLUG, tuple(blocks))


def comparison_of(inputs: Inputs) -> list[Study]:
    """Comparison of a report's runs; empty if none can be compared."""
    return _compared(_runs(inputs))


def _runs(inputs: Inputs) -> list[FinishedRun | ContinuumRun]:
    whole = [run for run in inputs.whole() if run.status != "refused"]
    found = [read_run(run.label, run.directory, run.summary) for run in whole]
    return [run for run in found if isinstance(run, FinishedRun | ContinuumRun)]


def _compared(runs: Sequence[FinishedRun | ContinuumRun]) -> list[Study]:
    impacts = collect(runs)
    if len(impacts.granular) + len(impacts.continuum) < 2:
        return []
    return make_studies(dict.fromkeys(COMPARISON, runs))
