"""Signals of the sensors in a square packing at the source's impacts: peaks, directions, lengths of the pulse."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from granwave.analysis.figures.run.histories import sensors
from granwave.analysis.figures.style import Drawing
from granwave.analysis.measures.chains.hertz_chain import discrete_speed
from granwave.analysis.measures.impact.regions import groups
from granwave.analysis.measures.sensors import sensor_accelerations
from granwave.analysis.measures.signals import first_peak
from granwave.analysis.measures.waves.directions import directions
from granwave.analysis.measures.waves.pulses import MEASURES, lengths, peaks, speed_between, theory
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.square.runs import PackingRun
from granwave.analysis.studies.study import Row

#: Sensors of the source: group of chains, and sphere of the chain with the struck one as 1.
PLACES = {
    "in-plane": {"1A": ("central chains", 6), "1B": ("central chains", 6), "1C": ("central chains", 10),
                 "1D": ("central chains", 15), "2A": ("edge chains", 5), "2B": ("edge chains", 5),
                 "2C": ("edge chains", 8)},
    "out-of-plane": {"3A": ("central chains", 6), "3B": ("central chains", 6), "3C": ("central chains", 8)},
}  # fmt: skip
#: Sensors whose pulse lengths the source draws, by way of impact (Fig. 11).
_DRAWN = {"in-plane": ("1C", "1D", "2B", "2C"), "out-of-plane": ("3B", "3C")}
_QUIET = {"in-plane": ("2D",), "out-of-plane": ("3D",)}
#: Sensors between which the source measures the speed (Figs 8 to 10).
_SPEED = {"in-plane": (("1B", "1C"), ("2B", "2C")), "out-of-plane": (("3B", "3C"),)}
_PATH = "square packing, Wave Propagation Path"
_LENGTH = "square packing, Fig. 11"
_SCALING = "square packing, Particle Velocity - Wave Speed"
_SAMPLING, _TOLERANCE = 2e-6, 1e-5  # s between two samples of the source; m, tolerance of its diameters
_STEEPEST = 3 * math.sqrt(3) / 16  # of cos^3 sin
_PEAK = 0.5  # of the largest acceleration


def signal_rows(run: PackingRun) -> Iterator[Row]:
    """Rows of all sensors: of their acceleration, of speed and its error bar, and of the lengths of the pulse."""
    yield from _accelerations(run)
    yield from _speeds(run)
    yield from _lengths(run)


def accelerations(run: PackingRun) -> Drawing | None:
    """Accelerations of the sensors in time; None without sensors."""
    with Result(run.directory) as result:
        return sensors(result)


def _accelerations(run: PackingRun) -> Iterator[Row]:
    """Peak along the chain with its theory, largest acceleration across it, and that of sensors apart."""
    with Result(run.directory) as result:
        found, ways, time = sensor_accelerations(result), directions(result), result["probes/time"]
        rows = {sensor.name: int(result.rows(np.array([sensor.id]))[0]) for sensor in run.case.sensor}
    if not found:
        return
    largest = max(float(np.linalg.norm(one, axis=1).max()) for one in found.values())
    across = 0.0
    for name, (group, place) in PLACES[run.way].items():
        if name not in found:
            continue
        along = found[name] @ ways[rows[name]]
        when, peak = first_peak(time, along, floor=_PEAK)
        upright = found[name][:, :2] - np.outer(along, ways[rows[name]][:2])
        across = max(across, float(np.abs(upright).max()))
        remark = "Theory: Nesterenko's wave of the same peak velocity; the chain's own is shorter."
        quantity = f"Peak acceleration at sensor {name} ({group}, sphere {place})"
        yield Row(quantity, "m/s²", None, peak, _PATH, remark, _theory_of_peak(run, group, place))
        yield Row(f"Time of it after the impact, sensor {name}", "µs", None, 1e6 * when, _PATH)
    ours = 100 * across / largest
    yield Row(f"Acceleration across the chains, {run.way}", "% of the largest", 0.0, ours, _PATH, "Of its simulations.")
    for name in _QUIET[run.way]:
        if name in found:
            ours = 100 * float(np.linalg.norm(found[name], axis=1).max()) / largest
            remark = "The source: not measurably excited. Theory: symmetry."
            quantity = f"Largest acceleration at sensor {name}, apart from the chains"
            yield Row(quantity, "% of the largest", None, ours, _PATH, remark, 0.0)


def _theory_of_peak(run: PackingRun, group: str, place: int) -> float:
    """Largest acceleration of Nesterenko's wave of the velocity and speed found at a sphere, m/s^2."""
    passed = peaks(run.snapshots.time, groups(run.snapshots)[group][0].speeds(run.snapshots), run.case.packing.diameter)
    velocity, speed = passed.velocity[place - 1], passed.speed[place - 1]
    return float(4 * velocity * speed * math.sqrt(10) / (5 * run.case.packing.diameter) * _STEEPEST)


def _speeds(run: PackingRun) -> Iterator[Row]:
    """Factor of the speed against the force, and the source's error bar of its measured speed."""
    case, diameter, seen = run.case, run.case.packing.diameter, run.snapshots
    material = case.material
    scale = material.youngs_modulus / (diameter / 2 * material.density**1.5 * (1 - material.poisson_ratio**2))
    for pair in _SPEED[run.way]:
        (group, first), (_, second) = (PLACES[run.way][name] for name in pair)
        chain = groups(seen)[group][0]
        if second + 1 >= len(chain.rows):
            continue
        passed = peaks(seen.time, chain.speeds(seen), diameter)
        _, speed = speed_between(passed, first, second, diameter)
        if not np.isfinite(speed):
            continue
        where = f"{group}, {run.way}"
        force = mean_peak_force(run, chain.rows[first - 1 : second + 1])
        factor = speed / (scale ** (1 / 3) * force ** (1 / 6))
        remark = "Theory: the wave of the chain of beads itself, not of the continuum."
        quantity = f"Factor of the speed against the peak force (equation 3), {where}"
        yield Row(quantity, "", 0.68, factor, _SCALING, remark, 0.6802 * discrete_speed())
        way = (second - first) * diameter
        error = 100 * (_SAMPLING * speed / way + _TOLERANCE / way)
        remark = "By the source's formula, of 2 µs and 0.01 mm; it leaves gaps out, which make far more."
        yield Row(f"Error bar of the speed, {where}", "%", None, error, _SCALING, remark)


def mean_peak_force(run: PackingRun, rows: np.ndarray) -> float:
    """Mean of the peak forces of the contacts between neighbours of a chain, given by their rows, N."""
    with Result(run.directory) as result:
        ids = result["spheres/id"][rows]
        i, j, force = (result[f"contacts/{name}"] for name in ("i", "j", "peak_force"))
    pairs = [sorted(pair) for pair in zip(ids[:-1].tolist(), ids[1:].tolist(), strict=True)]
    return float(np.mean([force[(i == low) & (j == high)][0] for low, high in pairs]))


def _lengths(run: PackingRun) -> Iterator[Row]:
    """The four lengths of the pulse at the sensors that the source draws."""
    seen, diameter, expected = run.snapshots, run.case.packing.diameter, theory()
    for name in _DRAWN[run.way]:
        group, place = PLACES[run.way][name]
        chain = groups(seen)[group][0]
        if place + 1 >= len(chain.rows):
            continue
        found = lengths(seen.time, chain.speeds(seen), diameter)
        for n, measure in enumerate(MEASURES):
            ours = float(found[measure][place - 1])
            if np.isfinite(ours):
                where = f"sensor {name} ({group}, sphere {place})"
                remark = "Theory: the dotted line, Nesterenko's wave."
                panel = f"{_LENGTH}({'abcd'[n]})"
                yield Row(
                    f"Pulse length, {measure}, {where}", "diameters", None, ours, panel, remark, expected[measure]
                )
