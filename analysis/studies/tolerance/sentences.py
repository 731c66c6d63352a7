"""Name, title and sentences of a study of tolerances."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.formatting.numbers import with_interval
from granwave.analysis.measures.target_record import reached
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import span
from granwave.analysis.studies.tolerance.quantities import AXES, IDEAL, PERFORMANCE, in_words
from granwave.analysis.studies.tolerance.runs import PackingRuns, imperfections

TEXT = (
    "The values are means over the seeds, with their 95 % confidence intervals (Student). "
    "Values without an interval belong to packings without random quantities, or to a "
    "single seed. With a diameter scatter, diameters lie between the nominal diameter minus "
    "this value and the nominal diameter. A lower peak force and a larger dissipated fraction "
    "mean better protection."
)
_LATE = 0.05  # fraction of a run


def name(packing: PackingRuns) -> str:
    """``tolerances``, ``tolerances-2``."""
    return packing.name


def title(packing: PackingRuns) -> str:
    """Title with packing and impact."""
    suffix = "" if packing.label in packing.title else packing.suffix
    return f"Tolerances: {packing.title}{suffix}"


def verdict(packing: PackingRuns) -> Iterator[str]:
    """Sentences on the range of each measure of performance, and on runs that ended too early."""
    for quantity in packing.shown(PERFORMANCE):
        if len(packing.left(quantity)) < 2:
            continue
        means = {
            in_words(setting): mean.over(quantity.scale)
            for setting, mean in packing.means(quantity).items()
        }
        ideal = with_interval(means[in_words(IDEAL)], unit=quantity.unit)
        yield span(f"{quantity.heading}, {ideal} in the ideal packing", means, quantity.unit)
    short = 0
    for runs in packing.runs.values():
        short += sum(_cut_short(run) for run in runs)
    if short:
        yield (
            f"In {short} runs the force on the bottom was largest at the end of the run and may "
            "still increase: use a later run.end_time."
        )


def missing(packing: PackingRuns, undone: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Return a note if the ideal packing is a point of a scan but has not finished."""
    present = imperfections(packing.case)["setting"]
    asked = any(_is_ideal(present._asdict(), labels) for labels in undone)
    if IDEAL not in packing.runs and asked:
        yield (
            "The ideal packing (no scatter, no friction) has not finished, so the retained "
            "performance is unknown."
        )


def _is_ideal(imperfections: Mapping[str, float], labels: Mapping[str, Any]) -> bool:
    """Return True if values of the varied keys leave a packing without these imperfections."""
    return not any(labels.get(axis.key, imperfections[axis.name]) for axis in AXES)


def _cut_short(run: FinishedRun) -> bool:
    """Return True if the force on the bottom was largest in the last part of the run and may still
    grow.
    """
    try:
        with Result(run.directory) as result:
            target = reached(result)
    except (MissingOutputError, OutputFormatError):  # only the summary was kept
        return False
    if target is None:
        return False
    peak_time = target.time[target.force.argmax()]
    return bool(peak_time > (1 - _LATE) * target.time[-1])
