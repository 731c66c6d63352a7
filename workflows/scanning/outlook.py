"""Remaining time of a scan: as planned until a point is done, then from the pace of finished points."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence

from granwave.analysis.formatting.numbers import duration
from granwave.workflows.scanning.batches import PUBLISH, expected_scan_time, expected_time, spread
from granwave.workflows.scanning.profile import Profile
from granwave.workflows.scanning.scan_file import Point


class Outlook:
    """Estimate of the remaining time of a scan that begins now.

    Parameters
    ----------
    points
        Points to be run.
    profile, workers, slowness
        As in `expected_scan_time`.
    """

    def __init__(self, points: Sequence[Point], profile: Profile | None, workers: int, slowness: float) -> None:
        self._profile, self._workers = profile, workers
        self._ids = {point.id for point in points}
        self._planned = expected_scan_time(points, profile, workers, slowness)
        self._taken = self._expected = 0.0  # by the points that are done, s
        self._begin = time.monotonic()

    def done(self, point: Point, seconds: float) -> None:
        """Register a finished point and its wall time (s); points done earlier are ignored."""
        if point.id not in self._ids:
            return
        self._taken += seconds
        self._expected += expected_time(point)

    def text(self, left: Sequence[Point], ages: Mapping[str, float]) -> str:
        """Return elapsed and remaining time as text.

        Parameters
        ----------
        left
            Unfinished points.
        ages
            Elapsed time of running points, by id, s.
        """
        seconds = time.monotonic() - self._begin
        passed = duration(seconds)
        if not left:
            return f"{passed}; table, figures and report are next"
        if not self._expected:
            longer = seconds > self._planned
            return f"{passed}{', longer than the planned' if longer else ' of about'} {duration(self._planned)}"
        pace = self._taken / self._expected
        times = [max(0.0, expected_time(point, pace) - ages.get(point.id, 0.0)) for point in left]
        rest = spread(times, [point.ranks for point in left], self._profile, self._workers) + PUBLISH
        return f"{passed}, about {duration(rest)} left"
