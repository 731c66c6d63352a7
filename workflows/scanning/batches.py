"""What a scan will cost, and its points in batches: each batch is one job, so that small points share its start-up."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from granwave.workflows.scanning.scan_file import Point

LOCAL_START = 2.5  # s, of a job on this machine: Snakemake, Python, libraries
_ENGINE_START = 3.0  # s, of Snakemake, before it starts the first job
PUBLISH = 6.0  # s, of table, figures and report: 4 to 11 for 8 scans of 5 to 43 points, 50 for protected-height
_LONGEST = 1800.0  # s, of a batch of several points


@dataclasses.dataclass(frozen=True)
class Batch:
    """Points that one job does one after the other.

    Attributes
    ----------
    ranks
        MPI ranks of each of its points; more than one only in a batch of one point.
    memory
        Bytes.
    wall_time
        Expected, s.
    """

    id: str
    points: tuple[Point, ...]
    ranks: int
    memory: float
    wall_time: float

    def write(self, path: Path, **settings: Any) -> None:
        """Write what the worker needs."""
        points = [
            {"id": point.id, "verb": point.kind.verb, "case": point.case.to_dict(), "disk": point.plan.disk}
            for point in self.points
        ]
        path.write_text(json.dumps({"points": points, "ranks": self.ranks, **settings}), encoding="utf-8")


def expected_time(point: Point, slowness: float = 1.0) -> float:
    """Wall time of a point, s; ``slowness`` is measured over planned time."""
    return point.plan.wall_time * slowness


def expected_scan_time(
    points: Iterable[Point], *, workers: int, job_start: float = LOCAL_START, slowness: float = 1.0
) -> float:
    """Wall time of a scan that has these points left, s; as of `make_batches`."""
    batches = make_batches(points, workers=workers, job_start=job_start, prefix="", slowness=slowness)
    times = [job_start + batch.wall_time for batch in batches]
    if not times:
        return PUBLISH
    return _ENGINE_START + max(sum(times) / workers, max(times)) + PUBLISH


def make_batches(
    points: Iterable[Point], *, workers: int, job_start: float, prefix: str, slowness: float = 1.0
) -> list[Batch]:
    """Share the points out, the longest first.

    A batch lasts about ``sqrt(2 job_start T / workers)``, which balances the start-up of many jobs against workers that
    wait for the last one (T: the time of all points together), and no less than ``job_start``.

    Parameters
    ----------
    job_start
        Time that it takes to start a job, s.
    prefix
        Of the ids, so that those of two rounds differ.
    """
    ordered = sorted(points, key=lambda point: (-expected_time(point, slowness), point.number))
    total = sum(expected_time(point, slowness) for point in ordered)
    length = min(max(math.sqrt(2 * job_start * total / workers), job_start), _LONGEST)
    groups: list[list[Point]] = []
    lengths: list[float] = []
    for point in ordered:
        time = expected_time(point, slowness)
        if groups and point.ranks == 1 == groups[-1][0].ranks and lengths[-1] + time <= length:
            groups[-1].append(point)
            lengths[-1] += time
        else:
            groups.append([point])
            lengths.append(time)
    return [
        _batch(f"{prefix}x{n:04d}", group, time) for n, (group, time) in enumerate(zip(groups, lengths, strict=True))
    ]


def _batch(name: str, points: Sequence[Point], time: float) -> Batch:
    return Batch(name, tuple(points), points[0].ranks, max(point.plan.memory for point in points), time)
