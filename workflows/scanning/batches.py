"""Cost of a scan on this machine or a cluster, batches of points that are jobs, and the time that
is left.
"""

from __future__ import annotations

import dataclasses
import json
import math
import statistics
import subprocess
import sys
import time
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, cast

import tomli_w

from granwave.analysis.formatting.numbers import duration
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.files import available_memory, replace_text
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.planning.cost import seconds_per_step
from granwave.lammps_inputs.planning.plan import Plan
from granwave.workflows.cluster.profile import Profile
from granwave.workflows.run import mpi
from granwave.workflows.run.lammps_engine import open_engine
from granwave.workflows.run.leftovers import scratch_directory
from granwave.workflows.scanning.scan_file import ScanPoint
from granwave.workflows.solvers import GRANULAR

_LOCAL_START = 1.0  # s, start of a job on this machine: Python, libraries
# s, table, figures and report: 2.5 for 8 points, 4 for 24; most of a minute where a study reads
# much
PUBLISH = 4.0
_LONGEST = 1800.0  # s, limit for a batch of several points


@dataclasses.dataclass(frozen=True)
class Batch:
    """Points that a job runs one after another.

    Attributes
    ----------
    ranks
        MPI ranks of each point; a batch with more than one rank has a single point.
    memory
        Expected memory, bytes.
    wall_time
        Expected wall time, s.
    longest
        Expected wall time if no point ends early, s.
    """

    id: str
    points: tuple[ScanPoint, ...]
    ranks: int
    memory: float
    wall_time: float
    longest: float

    def memory_on(self, nodes: int) -> float:
        """Return the expected memory on the fullest of a number of nodes, bytes."""
        return max(memory_on_node(point.plan, self.ranks, nodes) for point in self.points)

    def write(self, path: Path, **settings: Any) -> None:
        """Write the input of the worker."""
        points = [
            {
                "id": point.id,
                "verb": point.kind.verb,
                "case": point.case.to_dict(),
                "disk": point.plan.disk + point.plan.disk_reserve,
            }
            for point in self.points
        ]
        replace_text(path, json.dumps({"points": points, "ranks": self.ranks, **settings}))


def memory_on_node(plan: Any, ranks: int, nodes: int) -> float:
    """Return the expected memory on the node of the first rank, the fullest, bytes.

    Parameters
    ----------
    plan
        Plan of the run; the memory of runs without packings is on one node.
    """
    if nodes == 1 or not isinstance(plan, Plan):
        return float(plan.memory)
    here = -(-ranks // nodes)
    analysing = min(here, plan.n_analysing)
    others = (analysing - 1) * plan.other_rank
    return plan.first_rank + others + (here - analysing) * plan.idle_rank


@dataclasses.dataclass(frozen=True)
class Machine:
    """This machine or a cluster, where points run.

    Attributes
    ----------
    jobs
        Simultaneous jobs; on this machine the number of cores: a point takes a core for each rank.
    profile
        Profile of the cluster; None for this machine.
    slowness
        Measured time of a point divided by the planned time.
    """

    jobs: int
    profile: Profile | None = None
    slowness: float = 1.0

    def batches(self, points: Iterable[ScanPoint], prefix: str) -> list[Batch]:
        """Distribute points over batches, the longest first.

        A batch lasts about ``sqrt(2 s T / jobs)``, with the time s to start a job and the total
        time T of all points, and at least s. This balances the start-up of many jobs against idle
        jobs at the end.

        Parameters
        ----------
        prefix
            Prefix of the ids, different for each round.
        """
        points = list(points)
        times = {point.id: self.slowness * point.plan.wall_time for point in points}
        length = min(
            max(math.sqrt(2 * self._start * sum(times.values()) / self.jobs), self._start), _LONGEST
        )
        groups: list[list[ScanPoint]] = []
        lasts = 0.0  # the last group
        for point in sorted(points, key=lambda point: (-times[point.id], point.number)):
            if (
                groups
                and point.ranks == 1 == groups[-1][0].ranks
                and lasts + times[point.id] <= length
            ):
                groups[-1].append(point)
                lasts += times[point.id]
            else:
                groups.append([point])
                lasts = times[point.id]
        return [
            Batch(
                id=f"{prefix}x{n:04d}",
                points=tuple(group),
                ranks=group[0].ranks,
                memory=max(point.plan.memory for point in group),
                wall_time=sum(times[point.id] for point in group),
                longest=self.slowness
                * sum(
                    p.plan.times.longest if isinstance(p.plan, Plan) else p.plan.wall_time
                    for p in group
                ),
            )
            for n, group in enumerate(groups)
        ]

    def time(self, points: Iterable[ScanPoint]) -> float:
        """Return the expected wall time of a scan with these remaining points, without waiting in a
        queue, s.
        """
        batches = self.batches(points, prefix="")
        return self.spread(
            [self._start + batch.wall_time for batch in batches], [batch.ranks for batch in batches]
        )

    def spread(self, times: Sequence[float], ranks: Sequence[int]) -> float:
        """Return the wall time of jobs of these times (s) and ranks, and of table, figures and
        report, s.
        """
        cores = [1 if self.profile else min(n, self.jobs) for n in ranks]
        shared = sum(time * n for time, n in zip(times, cores, strict=True)) / self.jobs
        return max(shared, max(times, default=0.0)) + PUBLISH

    @property
    def _start(self) -> float:
        return self.profile.job_start if self.profile else _LOCAL_START


class Outlook:
    """Estimate of the remaining time of a scan that begins now.

    Parameters
    ----------
    points
        Points to be run.
    machine
        Where they run.
    """

    def __init__(self, points: Sequence[ScanPoint], machine: Machine) -> None:
        self._machine = machine
        self._ids = {point.id for point in points}
        self._planned = machine.time(points)
        self._taken = self._expected = 0.0  # time taken and expected, of the completed points, s
        self._begin = time.monotonic()

    def done(self, point: ScanPoint, seconds: float) -> None:
        """Register a finished point and its wall time (s); points done earlier are ignored."""
        if point.id in self._ids:
            self._taken += seconds
            self._expected += point.plan.wall_time

    def text(self, left: Sequence[ScanPoint], ages: Mapping[str, float]) -> str:
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
        times = [max(0.0, pace * point.plan.wall_time - ages.get(point.id, 0.0)) for point in left]
        rest = self._machine.spread(times, [point.ranks for point in left])
        return f"{passed}, about {duration(rest)} left"


# s of wall time: warm-up, in which contacts are loaded, and measurement
_WARM = 1.5
_SPAN = 1.0
_PIECE = 50  # steps between checks of the clock
_MEASURED_WITHIN = 60.0  # s after which the measurement is abandoned


def slowness_of(point: ScanPoint, jobs: int) -> float | None:
    """Measure the wall time of a granular point divided by the planned time; None if not possible.

    The first part of the impact is timed, in which nearly all contacts are elastic, without the
    static stage.

    Parameters
    ----------
    jobs
        Number of simultaneous measurements, limited by memory: cores that share a cache slow each
        other down.
    """
    if point.kind is not GRANULAR:
        return None
    case = dataclasses.replace(cast(Case, point.case), precompression=None)
    document = tomli_w.dumps(case.to_dict())
    at_once = max(1, min(jobs, int(available_memory() / point.plan.memory)))
    command = [*mpi.PYTHON, "-m", "granwave.workflows.scanning.batches"]

    def timed(_: int) -> float:
        """Measure the wall time of a step in a separate process, s; NaN on failure."""
        try:
            done = subprocess.run(
                command, input=document, capture_output=True, text=True, timeout=_MEASURED_WITHIN, env=mpi.alone(),
                check=True,
            )  # fmt: skip
            return float(json.loads(done.stdout.splitlines()[-1]))
        except (subprocess.SubprocessError, OSError, ValueError, IndexError):
            return math.nan

    with ThreadPoolExecutor(at_once) as pool:
        found = [seconds for seconds in pool.map(timed, range(at_once)) if seconds == seconds]
    return statistics.fmean(found) / seconds_per_step(assemble(case)) if found else None


def _measure(document: str) -> float:
    """Measure the wall time of a step on one rank, s."""
    from granwave.lammps_inputs.deck.deck import write_deck
    from granwave.lammps_inputs.deck.script import part
    from granwave.lammps_inputs.load_case import load_assembly

    with scratch_directory() as scratch:
        path = scratch / "case.toml"
        path.write_text(document, encoding="utf-8")
        deck = write_deck(load_assembly(path), scratch / "deck")
        with open_engine(mpi.world(), "none", deck.directory) as engine:
            engine.commands(part(deck.script.read_text(encoding="utf-8"), "setup"))
            engine.commands("run 20 post no")
            for span in (_WARM, _SPAN):
                steps = 0
                begin = time.monotonic()
                while (elapsed := time.monotonic() - begin) < span:
                    engine.commands(f"run {_PIECE} pre no post no")
                    steps += _PIECE
            return elapsed / steps


if __name__ == "__main__":
    print(json.dumps(_measure(sys.stdin.read())))
