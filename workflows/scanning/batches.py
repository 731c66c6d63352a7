"""Cost of a scan on this machine or a cluster, batches of points that are jobs, and the time that is left."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import math
import statistics
import subprocess
import sys
import tempfile
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
from granwave.workflows.run import mpi
from granwave.workflows.run.lammps_engine import Engine, open_engine
from granwave.workflows.scanning.scan_file import Point
from granwave.workflows.scanning.slurm import Profile
from granwave.workflows.solvers import GRANULAR

_LOCAL_START = 1.0  # s, start of a job on this machine: Python, libraries
PUBLISH = 4.0  # s, table, figures and report: 2.5 for 8 points, 4 for 24; most of a minute where a study reads much
_LONGEST = 1800.0  # s, limit for a batch of several points


@dataclasses.dataclass(frozen=True)
class Batch:
    """Points that one job runs one after the other.

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
    points: tuple[Point, ...]
    ranks: int
    memory: float
    wall_time: float
    longest: float

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


def expected_time(point: Point, slowness: float = 1.0) -> float:
    """Return the expected wall time of a point, s; ``slowness`` is measured over planned time."""
    return point.plan.wall_time * slowness


def expected_scan_time(points: Iterable[Point], profile: Profile | None, workers: int, slowness: float = 1.0) -> float:
    """Return the expected wall time of a scan with these points left, without waiting in a queue, s.

    Parameters
    ----------
    profile
        Profile of the cluster; None for this machine.
    workers
        Simultaneous jobs; on this machine cores, of which a point takes one for each rank.
    """
    start = start_of_job(profile)
    batches = make_batches(points, workers=workers, job_start=start, prefix="", slowness=slowness)
    if not batches:
        return PUBLISH
    times = [start + batch.wall_time for batch in batches]
    return spread(times, [batch.ranks for batch in batches], profile, workers) + PUBLISH


def spread(times: Sequence[float], ranks: Sequence[int], profile: Profile | None, workers: int) -> float:
    """Return the wall time of jobs of given times (s) and ranks on ``workers``, as in `expected_scan_time`."""
    cores = [1 if profile else min(n, workers) for n in ranks]
    return max(sum(time * n for time, n in zip(times, cores, strict=True)) / workers, max(times, default=0.0))


def start_of_job(profile: Profile | None) -> float:
    """Return the time to start a job, s."""
    return profile.job_start if profile else _LOCAL_START


def make_batches(
    points: Iterable[Point], *, workers: int, job_start: float, prefix: str, slowness: float = 1.0
) -> list[Batch]:
    """Distribute points over batches, the longest first.

    A batch lasts about ``sqrt(2 job_start T / workers)``, with the total time T of all points, and at least
    ``job_start``. This balances the start-up of many jobs against idle workers at the end.

    Parameters
    ----------
    job_start
        Time to start a job, s.
    prefix
        Prefix of the ids, different for each round.
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
        _batch(f"{prefix}x{n:04d}", group, time, slowness)
        for n, (group, time) in enumerate(zip(groups, lengths, strict=True))
    ]


def _batch(name: str, points: Sequence[Point], time: float, slowness: float) -> Batch:
    plans = [point.plan for point in points]
    longest = slowness * sum(one.times.longest if isinstance(one, Plan) else one.wall_time for one in plans)
    return Batch(name, tuple(points), points[0].ranks, max(one.memory for one in plans), time, longest)


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


_WARM, _SPAN = 1.5, 1.0  # s of wall time: warm-up, in which contacts get loaded, and measurement
_MEASURED_WITHIN = 60.0  # s after which the measurement is given up


def slowness_of(point: Point, jobs: int) -> float | None:
    """Measure the wall time of a granular point over the planned one; None if not possible.

    The first part of the impact is timed, in which nearly all contacts are elastic, without the static stage.

    Parameters
    ----------
    jobs
        Number of simultaneous measurements, limited by memory: cores that share a cache slow each other down.
    """
    if point.kind is not GRANULAR:
        return None
    case = dataclasses.replace(cast(Case, point.case), precompression=None)
    document = tomli_w.dumps(case.to_dict())
    at_once = max(1, min(jobs, int(available_memory() / point.plan.memory)))
    with ThreadPoolExecutor(at_once) as pool:
        times = list(pool.map(_timed, [document] * at_once))
    found = [seconds for seconds in times if seconds is not None]
    return statistics.fmean(found) / seconds_per_step(assemble(case)) if found else None


def _timed(document: str) -> float | None:
    """Measure the wall time of a step in a separate process, s; None on failure."""
    command = [*mpi.PYTHON, "-m", "granwave.workflows.scanning.batches"]
    try:
        done = subprocess.run(
            command,
            input=document,
            capture_output=True,
            text=True,
            timeout=_MEASURED_WITHIN,
            env=mpi.alone(),
            check=True,
        )
        return float(json.loads(done.stdout.splitlines()[-1]))
    except (subprocess.SubprocessError, OSError, ValueError, IndexError):
        return None


def _measure(document: str) -> float:
    """Measure the wall time of a step on one rank, s."""
    from granwave.lammps_inputs.deck.deck import write_deck
    from granwave.lammps_inputs.deck.script import part
    from granwave.lammps_inputs.load_case import load_case

    with tempfile.TemporaryDirectory(prefix="granwave-") as scratch:
        path = Path(scratch) / "case.toml"
        path.write_text(document, encoding="utf-8")
        deck = write_deck(load_case(path), Path(scratch) / "deck")
        with contextlib.chdir(deck.directory), open_engine(mpi.world(), log="none") as engine:
            engine.commands(part(deck.script.read_text(encoding="utf-8"), "setup"))
            engine.commands("run 20 post no")
            _run_for(engine, _WARM)
            return _run_for(engine, _SPAN)


def _run_for(engine: Engine, span: float) -> float:
    """Run for ``span`` seconds of wall time; return the wall time of a step, s."""
    piece, steps, begin = 50, 0, time.monotonic()
    while (elapsed := time.monotonic() - begin) < span:
        engine.commands(f"run {piece} pre no post no")
        steps += piece
    return elapsed / steps


if __name__ == "__main__":
    print(json.dumps(_measure(sys.stdin.read())))
