"""Influence of spheres with a sensor, of another mass, on the waves in a square packing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.measures.sensors import sensor_velocities
from granwave.analysis.measures.signals import first_peak
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.square.runs import PackingRun, packings
from granwave.analysis.studies.study import Row

Pair = tuple[PackingRun, PackingRun]

TITLE = "Sensor spheres in a square packing"
TEXT = (
    "What lighter spheres with sensors change at the sensors, beside spheres alike: peak velocity, and its "
    "time. The source found no trend in its experiments with a chain."
)
_WHERE = "square packing, Experimental Setup"
_FELT = 0.01  # of the largest velocity: the wave passes a sensor


def select(runs: Sequence[FinishedRun]) -> list[list[Pair]]:
    """One group of all packings with sensors in lighter spheres, each with the same one of like spheres."""
    chosen = [run for run in packings(runs) if run.case.sensor]
    plain = {_key(run): run for run in chosen if run.alike}
    pairs = [(run, plain[_key(run)]) for run in chosen if not run.alike and _key(run) in plain]
    return [pairs] if any(rows([pair]) for pair in pairs) else []


def rows(pairs: Sequence[Pair]) -> list[Row]:
    """Changes at every sensor that the wave passes."""
    return [row for run, other in pairs for row in _changes(run, other)]


def _changes(run: PackingRun, other: PackingRun) -> Iterator[Row]:
    with Result(run.directory) as with_sensors, Result(other.directory) as without:
        found = sensor_velocities(with_sensors), sensor_velocities(without)
        times = with_sensors["probes/time"], without["probes/time"]
    mass = run.assembly.mass_of(run.case.sensor[0].id) / run.case.sphere_mass
    largest = max(float(np.abs(one).max()) for one in found[1].values())
    for name in found[0]:
        (late, ours), (early, theirs) = (
            first_peak(time, np.linalg.norm(one[name], axis=1), floor=0.5)
            for time, one in zip(times, found, strict=True)
        )
        if theirs > _FELT * largest:
            where = f"sensor {name}, {mass:.3g} of the others' mass"
            yield Row(f"Change of peak velocity, {where}", "%", None, 100 * (ours / theirs - 1), _WHERE)
            yield Row(f"Delay of the peak, {where}", "µs", None, 1e6 * (late - early), _WHERE)


def _key(run: PackingRun) -> tuple:
    case = run.case
    return case.packing, case.material, case.striker, case.contact, case.boundary, case.run.end_time, case.sensor
