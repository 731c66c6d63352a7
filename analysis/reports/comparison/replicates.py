"""Random packings among compared runs: sets of replicates, and their means with intervals.

Replicates are runs of random packings whose cases differ only in the seed. A single run of a random
packing contains the scatter between packings, so that its rank among other runs is no result.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from granwave.analysis.document.model import label_of, unit_of_value
from granwave.analysis.formatting.numbers import in_any_unit, interval_in_any_unit
from granwave.analysis.scans.means import has_random_packing, is_of_packing
from granwave.analysis.scans.result import SEED
from granwave.analysis.statistics import Estimate, estimate, exactly

if TYPE_CHECKING:
    from granwave.analysis.reports.comparison.subjects import ComparedRun
    from granwave.analysis.reports.kinds import ReportRun

#: Values whose means are stated, of the first that all runs have.
_MAIN = ("wall_peak_force_N", "dissipated_fraction", "transmission")
_SINGLE = (
    "Each random packing was run once: these differences include the scatter between random "
    "packings, which is unknown."
)


def replicate_sets(runs: Sequence[ReportRun], random: Sequence[bool]) -> list[list[int]]:
    """Return the positions of the runs, grouped by replicates; other runs are alone.

    Parameters
    ----------
    random
        True for runs of random packings: (n_runs,).
    """
    sets: dict[tuple[object, ...], list[int]] = {}
    for place, run in enumerate(runs):
        case = tuple((key, str(value)) for key, value in run.case.items() if key != SEED)
        setting = (run.kind.result_kind, *case) if random[place] else (place,)
        sets.setdefault(setting, []).append(place)
    return list(sets.values())


def is_of_random_packing(run: ReportRun) -> bool:
    """Return True if the packing of a run depends on the seed; only such cases have one."""
    return SEED in run.case and has_random_packing(run.directory)


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
    packings = {tuple(_packing_of(run)) for run in random}
    if len(packings) < 2:
        return ""
    sets: dict[int, list[ComparedRun]] = {}
    for run in runs:
        sets.setdefault(run.set_number, []).append(run)
    if max(map(len, sets.values())) < 2:
        return _SINGLE
    name = next((name for name in _MAIN if all(run.run.number(name) for run in runs)), "")
    if not name or len(sets) < 2:
        return ""
    return _sentence_on_means(name, list(sets.values()))


def _packing_of(run: ComparedRun) -> list[tuple[str, str]]:
    """Return the keys and values that determine the packing of a run."""
    return [(key, str(value)) for key, value in run.run.case.items() if is_of_packing(key)]


def _sentence_on_means(name: str, sets: Sequence[Sequence[ComparedRun]]) -> str:
    """Return a sentence with the smallest and the largest mean of sets of replicates."""
    means = sorted(map(lambda runs: _mean_of(name, runs), sets), key=lambda mean: mean.value.mean)
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
