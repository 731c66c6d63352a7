"""Notes on plastic zones that the size of a packing or block limits."""

from __future__ import annotations

from collections.abc import Sequence

from granwave.analysis.document.cells import named
from granwave.analysis.document.model import Note
from granwave.analysis.measures.zone_size import NOTED_SHARE, Mark, bounds_in_words, mark_of
from granwave.analysis.reports.inputs import Run


def zone_notes(runs: Sequence[Run], section: str = "") -> list[Note]:
    """Return notes on runs whose zone reaches a boundary, and on runs in which a wave returned from one.

    Parameters
    ----------
    section
        Name of the section with details.
    """
    notes = []
    cut = _with_bounds(_marked(runs, Mark.CUT))
    if cut:
        text = "The plastic zone reaches a bound, which cuts its outermost depth or radius, and may change what holds "
        notes.append(Note(f"{text}99 % of its energy: {cut}.", "note", section))
    waves = [f"{run.label} ({100 * run.summary['wave_return_share']:.2g} %)" for run in _marked(runs, Mark.WAVE)]
    if waves:
        text = f"More than {100 * NOTED_SHARE:g} % of the energy of yielding was dissipated after a wave could be back "
        notes.append(Note(f"{text}from a bound: {named(waves)}.", "note", section))
    return notes


def _with_bounds(runs: Sequence[Run]) -> str:
    """Name runs with the bounds that their zones reach; those that all reach only once."""
    labels, bounds = [run.label for run in runs], [bounds_in_words(run.summary["zone_cut"]) for run in runs]
    if len(runs) > 1 and len(set(bounds)) == 1:
        return f"{named(labels)} (all: {bounds[0]})"
    return named([f"{label} ({one})" for label, one in zip(labels, bounds, strict=True)])


def _marked(runs: Sequence[Run], mark: Mark) -> list[Run]:
    return [run for run in runs if mark_of(run.summary) is mark]
