"""Runs against each other, and packings against the continuum: figures and tables."""

from __future__ import annotations

from collections.abc import Sequence

from granwave.analysis.document.cells import named
from granwave.analysis.document.model import Block, Note, Section
from granwave.analysis.figures.style import style
from granwave.analysis.reports.inputs import Inputs
from granwave.analysis.reports.sections.studies import pictures_of
from granwave.analysis.studies.packing_and_block.impacts import collect, not_ideal
from granwave.analysis.studies.registry import COMPARISON
from granwave.analysis.studies.runs import ContinuumRun, FinishedRun, read_run
from granwave.analysis.studies.study import Study, make_studies

SLUG = "comparison"


def comparison_section(inputs: Inputs) -> Section:
    """The section of the report; without blocks where there is nothing to compare.

    Runs that are left out are named with the reason.
    """
    blocks: list[Block] = []
    runs = _compared(inputs)
    for study in _studies(runs):
        if study.pictures or study.failed:
            with style():
                pictures = pictures_of(study, inputs, SLUG)
            blocks += [Note(study.text), *pictures, *study.tables]
    if blocks and (refused := [run.label for run in inputs.whole() if run.status == "refused"]):
        blocks.append(Note(f"Left out here, as the energy balance did not close: {', '.join(refused)}.", "bad"))
    if blocks and (others := _left_out(runs)):
        listed = "; ".join(f"{named(labels)} ({reason})" for reason, labels in others.items())
        blocks.append(Note(f"Left out here: {listed}.", "note"))
    return Section("Comparison", SLUG, tuple(blocks))


def comparison_of(inputs: Inputs) -> list[Study]:
    """Comparison of a report's runs; empty if none can be compared."""
    return _studies(_compared(inputs))


def _studies(runs: Sequence[FinishedRun | ContinuumRun]) -> list[Study]:
    impacts = collect(runs)
    if len(impacts.granular) + len(impacts.continuum) < 2:
        return []
    return make_studies(dict.fromkeys(COMPARISON, runs))


def _compared(inputs: Inputs) -> list[FinishedRun | ContinuumRun]:
    """Return the runs of grains and of blocks with a closed balance."""
    whole = [run for run in inputs.whole() if run.has_balance and run.status != "refused"]
    found = [read_run(run.label, run.directory, run.summary) for run in whole]
    return [run for run in found if isinstance(run, FinishedRun | ContinuumRun)]


def _left_out(runs: Sequence[FinishedRun | ContinuumRun]) -> dict[str, list[str]]:
    """Return the labels of the runs that the comparison does not show, by the reason."""
    found: dict[str, list[str]] = {}
    for run in runs:
        if isinstance(run, FinishedRun) and (reason := not_ideal(run)):
            found.setdefault(reason, []).append(run.label)
    for other in collect(runs).other_packings:
        found.setdefault("another packing than the reference's", []).append(other.label)
    return found
