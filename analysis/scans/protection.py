"""Scans that ask what reaches a target: their main quantity is how much less it is than without the packing."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

REDUCTION = "peak_reduction"
_TARGET = "boundary.bottom"
_MOVES = "target_peak_displacement_m"  # of targets that are no rigid wall
_WORTH = 1e-3  # difference from 1 below which nothing is protected, as by a single sphere


def protects(varied: Sequence[str], summaries: Iterable[Mapping[str, Any]]) -> bool:
    """Return True for a scan of targets, or of one that is no rigid wall, of which some packing takes a share.

    Parameters
    ----------
    varied
        Keys that vary in the scan.
    summaries
        Summaries of its finished points.
    """
    found = [summary for summary in summaries if isinstance(summary.get(REDUCTION), int | float)]
    asked = any(key == _TARGET or key.startswith(f"{_TARGET}.") for key in varied)
    asked = asked or (bool(found) and all(summary.get(_MOVES) is not None for summary in found))
    return asked and any(abs(summary[REDUCTION] - 1) > _WORTH for summary in found)
