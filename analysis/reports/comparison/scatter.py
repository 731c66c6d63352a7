"""Sentence on the scatter between the random packings of a comparison: means with intervals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from granwave.analysis.document.model import label_of, unit_of_value
from granwave.analysis.formatting.numbers import in_any_unit, interval_in_any_unit
from granwave.analysis.reports.comparison.subjects import ComparedRun
from granwave.analysis.scans.means import is_of_packing
from granwave.analysis.statistics import Estimate, estimate, exactly

#: Values whose means are stated, of the first that all runs have.
_MAIN = ("wall_peak_force_N", "dissipated_fraction", "transmission")
_SINGLE = (
    "Each random packing was run once: these differences include the scatter between random "
    "packings, which is unknown."
)


@dataclass(frozen=True)
class _SetMean:
    """Mean of a set of replicates, or the value of another run."""

    name: str
    value: Estimate

    def in_words(self, unit: str) -> str:
        """Return the mean with its interval, if it has one."""
        if self.value.n > 1:
            return interval_in_any_unit(self.value.mean, self.value.half_width, unit)
        return in_any_unit(self.value.mean, unit)


def scatter_sentence(runs: Sequence[ComparedRun]) -> str:
    """Return a sentence on the means of replicates, or on single random packings; empty if no
    random packings are compared with other packings.
    """
    random = [run for run in runs if run.is_random]
    packings = set(map(_packing_of, random))
    if len(packings) < 2:
        return ""
    sets: dict[int, list[ComparedRun]] = {}
    for run in runs:
        sets.setdefault(run.set_number, []).append(run)
    if max(map(len, sets.values())) < 2:
        return _SINGLE
    known = [name for name in _MAIN if _all_have(name, runs)]
    if not known or len(sets) < 2:
        return ""
    return _sentence_on_means(known[0], list(sets.values()))


def _all_have(name: str, runs: Sequence[ComparedRun]) -> bool:
    """Return True if all runs have a value other than zero."""
    return all(run.run.number(name) for run in runs)


def _packing_of(run: ComparedRun) -> tuple[tuple[str, str], ...]:
    """Return the keys and values that determine the packing of a run."""
    case = run.run.case
    return tuple((key, str(value)) for key, value in case.items() if is_of_packing(key))


def _sentence_on_means(name: str, sets: Sequence[Sequence[ComparedRun]]) -> str:
    """Return a sentence with the smallest and the largest mean of sets of replicates."""
    means = [_mean_of(name, runs) for runs in sets]
    means.sort(key=lambda mean: mean.value.mean)
    low = means[0]
    high = means[-1]
    unit = unit_of_value(name)
    label = label_of(name, "spheres")
    return (
        "Values of replicates include the scatter between random packings. Means over replicates, "
        f"with 95 % confidence intervals: {label[:1].lower()}{label[1:]} from "
        f"{low.in_words(unit)} ({low.name}) to {high.in_words(unit)} ({high.name}). "
        f"{_verdict(low.value, high.value)}"
    )


def _verdict(low: Estimate, high: Estimate) -> str:
    """Return a sentence on the difference of two means relative to their intervals."""
    combined = math.hypot(low.half_width, high.half_width)
    if math.isnan(combined):
        return "The scatter of a single random packing among them is unknown."
    relation = "exceeds" if high.mean - low.mean > combined else "is within"
    return f"This difference {relation} their combined interval."


def _mean_of(name: str, runs: Sequence[ComparedRun]) -> _SetMean:
    """Return the mean of a value over a set of replicates."""
    first = runs[0]
    values = [run.run.number(name) or 0.0 for run in runs]
    count = f", {len(runs)} replicates" if len(runs) > 1 else ""
    mean = estimate(values) if first.is_random else exactly(values[0])
    return _SetMean(f"{first.label}{count}", mean)
