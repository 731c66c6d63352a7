"""Note on static stages of unknown length."""

from __future__ import annotations

from collections.abc import Sequence

from granwave.analysis.formatting.numbers import duration
from granwave.lammps_inputs.planning.cost import WallTime


def static_stage_note(times: Sequence[WallTime], jobs: float = 1.0) -> str:
    """Return the plan's note on static stages of unpredictable length, given the number of
    simultaneous jobs.
    """
    counted = sum(time.static for time in times) / jobs
    most = sum(time.most_static for time in times) / jobs
    return (
        f"estimated as {duration(counted)}, but unpredictable in a disordered packing: up to "
        f"{duration(most)}"
    )
