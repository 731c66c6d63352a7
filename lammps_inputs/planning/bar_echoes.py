"""Warnings of bars that are too short for the run: a reflection from their end returns earlier."""

from __future__ import annotations

from collections.abc import Iterator

from granwave.lammps_inputs.case.boundary import time_label
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.bodies import BAR, echoes
from granwave.lammps_inputs.planning.arrival import earliest_passage


def echo_warnings(assembly: Assembly) -> Iterator[str]:
    """Yield warnings of bars whose end reflects waves back into the chain during the run."""
    if not assembly.bars:
        return
    end = assembly.case.run.longest
    loaded = assembly.case.load.first_time
    passage = earliest_passage(assembly)
    for name, echo in echoes(assembly.bars).items():
        earliest = loaded + echo
        if name == BAR:
            earliest += passage
        if end > earliest:
            yield (
                f"a reflection from the end of the {name} can reach the chain after "
                f"{time_label(earliest)}, before the end of the run at {time_label(end)}: use a "
                "longer bar, or a shorter run"
            )
