"""Random packings among compared runs: sets of replicates.

Replicates are runs of random packings whose cases differ only in the seed. A single run of a random
packing contains the scatter between packings, so that its rank among other runs is no result.
"""

from __future__ import annotations

from collections.abc import Sequence

from granwave.analysis.reports.kinds import ReportRun
from granwave.analysis.scans.means import has_random_packing
from granwave.analysis.scans.result import SEED


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
