"""Finished runs of plane crystals of cylinders that a plate strikes, with a line of grains down their middle.

The source calls the centred-square crystal BCC and the hexagonal one HCP. Widths and depths are in diameters D. The
front of the wave and what the top corners send run down together along the close-packed lines, at 45 degrees in the
centred-square crystal and at 30 degrees from the vertical in the hexagonal one: they meet on the middle line at W/2 and
at sqrt(3)/2 W.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.lines.decay import Decay, fit_decay
from granwave.analysis.measures.lines.record import LineRecord, lines_of
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.runs import FinishedRun

NAMES = {"centred-square": "BCC", "hexagonal": "HCP"}  # in the source
DOWN = "down"  # line of grains in the middle
_MEETING = {"centred-square": 0.5, "hexagonal": math.sqrt(3) / 2}  # depth over width


class LateralRun(FinishedRun):
    """A run of a plane crystal of cylinders under a plate."""

    @property
    def crystal(self) -> str:
        """Name of the crystal in the source."""
        return NAMES[self.case.packing.kind]

    @cached_property
    def lines(self) -> dict[str, LineRecord]:
        """Lines of grains, by name."""
        with Result(self.directory) as result:
            return {line.name: line for line in lines_of(result)}

    @property
    def down(self) -> LineRecord:
        """Line down the middle."""
        return self.lines[DOWN]

    @property
    def depth(self) -> NDArray[np.float64]:
        """Depths of the grains of the line, D."""
        return self.down.distance / self.case.packing.diameter

    @property
    def width(self) -> float:
        """Width between the walls if they touch, D."""
        return self.assembly.lattice.lengths[0] / self.case.packing.diameter

    @property
    def meeting(self) -> float:
        """Depth at which the signals of the sides meet on the middle line, D."""
        return _MEETING[self.case.packing.kind] * self.width

    @property
    def whole_decay(self) -> Decay | None:
        """Decay fitted to all grains of the line, those that the floor holds included."""
        return fit_decay(self.down.distance, self.down.peak_speed)

    @property
    def plate(self) -> float:
        """Mass of the plate per length of the cylinders, kg/m."""
        return (self.case.load.mass or 0.0) / (self.case.packing.length or 1.0)

    @property
    def loss_time(self) -> float:
        """Loss time of contacts, s."""
        loss = self.case.contact.loss
        return (loss.time or 0.0) if loss is not None else 0.0

    def array(self, name: str) -> NDArray:
        """Return an array of the result, read anew."""
        with Result(self.directory) as result:
            return result[name]


def lateral_runs(runs: Iterable[FinishedRun], load: str = "plate") -> list[LateralRun]:
    """Select the runs of plane crystals of cylinders under a load that recorded the line down their middle."""
    return [
        run.seen_as(LateralRun)
        for run in runs
        if isinstance(run, FinishedRun)
        and run.case.packing.kind in NAMES
        and run.case.packing.shape == "cylinder"
        and run.case.load.kind == load
        and any(line.name == DOWN and line.index is None for line in run.case.line)
    ]
