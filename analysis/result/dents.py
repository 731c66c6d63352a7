"""Contacts that LAMMPS wrote, sorted by the parts of the spheres."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.lammps_output.frame import Frame
from granwave.analysis.result.scratch import Buckets
from granwave.analysis.result.start import Start


class Dents:
    """Contacts at one instant of a run, by the parts of the spheres; those with faces of bars by themselves.

    Parameters
    ----------
    start
        Particles of the run.
    rows
        Contacts by part of either sphere.
    """

    def __init__(self, start: Start, rows: Buckets) -> None:
        self._start, self._rows = start, rows
        self._at_bars: list[NDArray[np.float64]] = []
        self._like: Frame | None = None

    def add(self, frame: Frame) -> None:
        """Add contacts of particles that there are."""
        self._like = frame
        pairs = frame.vector("i", "j").astype(np.int64)
        between = pairs.max(axis=1, initial=0) <= self._start.last_sphere
        self._at_bars.append(frame.values[~between])
        values = frame.values if between.all() else frame.values[between]
        first, second = (self._start.part_of(ids) for ids in pairs[between].T)
        self._rows.add(first, values)
        if np.any(apart := first != second):
            self._rows.add(second[apart], values[apart])

    def of_part(self, part: int) -> Frame:
        """Return the contacts of the spheres of a part with other spheres."""
        return self._frame(self._rows.rows(part))

    def at_bars(self) -> Frame:
        """Return the contacts of spheres with the faces of bars."""
        return self._frame(np.concatenate(self._at_bars))

    def _frame(self, values: NDArray[np.float64]) -> Frame:
        assert self._like is not None
        return Frame(self._like.step, self._like.box, self._like.columns, values)
