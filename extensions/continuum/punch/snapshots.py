"""Snapshots of the stresses of a block: at equal intervals, and more densely during the event.

The event is the time in which the punch touches the block or elements are at yield. It can be a
hundredth of the run, so that snapshots at equal intervals miss it.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

Stress = NDArray[np.float32]

MOST = 64  # snapshots at equal intervals; if there are more, every second one is dropped
MOST_OF_EVENT = 24  # the same for the snapshots of the event


@dataclasses.dataclass(frozen=True, eq=False)
class Snapshot:
    """Time (s) and von Mises stresses ((n_z, n_r), Pa)."""

    time: float
    stress: Stress


class StressSnapshots:
    """StressSnapshots of a run, in a number that does not grow with its duration.

    Parameters
    ----------
    interval
        First interval between snapshots outside the event, s; doubled whenever there are more than
        `MOST`.
    """

    def __init__(self, interval: float) -> None:
        self._interval = interval
        self._due = 0.0
        self._at_intervals: list[Snapshot] = []
        self._of_event: list[Snapshot] = []
        self._stride = 1
        self._n_instants = 0
        self._largest = 0.0
        self._of_largest: list[Snapshot] = []

    def is_due(self, time: float) -> bool:
        """Return True if the interval since the last snapshot has passed."""
        return time >= self._due

    def add(self, snapshot: Snapshot) -> None:
        """Add a snapshot at the end of an interval."""
        if len(self._at_intervals) >= MOST:
            del self._at_intervals[1::2]
            self._interval *= 2
        self._at_intervals.append(snapshot)
        self._due = (int(snapshot.time / self._interval) + 1) * self._interval

    def add_to_event(self, snapshot: Snapshot, yielding: float) -> None:
        """Add a snapshot within the event, if it is one of those that are kept.

        Parameters
        ----------
        yielding
            Volume at yield, m^3; the snapshot of the largest one is kept.
        """
        if yielding > self._largest:
            self._largest = yielding
            self._of_largest = [snapshot]
        if self._n_instants % self._stride == 0:
            self._of_event.append(snapshot)
        self._n_instants += 1
        if len(self._of_event) > MOST_OF_EVENT:
            del self._of_event[1::2]
            self._stride *= 2

    def end(self, snapshot: Snapshot) -> None:
        """Add the snapshot of the end of the run."""
        self._at_intervals.append(snapshot)

    @property
    def in_order(self) -> list[Snapshot]:
        """All snapshots in order of time, each instant once."""
        by_time = {
            snapshot.time: snapshot
            for snapshot in (*self._at_intervals, *self._of_event, *self._of_largest)
        }
        return [by_time[time] for time in sorted(by_time)]
