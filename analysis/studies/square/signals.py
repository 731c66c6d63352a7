"""Peak forces along chains of a square packing."""

from __future__ import annotations

import numpy as np

from granwave.analysis.result.reader import Result
from granwave.analysis.studies.square.runs import PackingRun


def mean_peak_force(run: PackingRun, rows: np.ndarray) -> float:
    """Mean of the peak forces of the contacts between neighbours of a chain, given by their rows, N."""
    with Result(run.directory) as result:
        ids = result["spheres/id"][rows]
        i, j, force = (result[f"contacts/{name}"] for name in ("i", "j", "peak_force"))
    pairs = [sorted(pair) for pair in zip(ids[:-1].tolist(), ids[1:].tolist(), strict=True)]
    return float(np.mean([force[(i == low) & (j == high)][0] for low, high in pairs]))
