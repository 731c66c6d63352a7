"""Influence of scattered diameters on the power of the wave speed with the force, which is 1/6 of like spheres."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise

import numpy as np

from granwave.analysis.figures.series import COLOURS, MARKS, column_name, legend_outside, panels
from granwave.analysis.figures.style import Drawing
from granwave.analysis.measures.impact.regions import groups
from granwave.analysis.measures.precompressed.line_waves import speed_along_layers
from granwave.analysis.measures.precompressed.loaded_line import line_of
from granwave.analysis.measures.signals import Array, power
from granwave.analysis.measures.waves.pulses import peaks, speed_between
from granwave.analysis.result.reader import Result
from granwave.analysis.statistics import estimate
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.square.runs import PackingRun, packings
from granwave.analysis.studies.square.signals import mean_peak_force
from granwave.analysis.studies.study import Picture, Row

TITLE = "Wave speed with defects"
TEXT = (
    "Power of the wave speed with the force. Of like spheres it is 1/6; the source quotes 1/4 for packings with "
    "defects and little precompression, from others' work on hexagonal ones, and gives neither tolerance nor load. "
    "Ours: small waves in precompressed packings (the force of a contact goes with the pressure), and waves of an "
    "impact in a square packing whose scattered spheres stay at their sites, with gaps (peak force of the contacts, "
    "sphere 6 to 10 of a central chain, means over seeds). Local powers are those of two neighbouring loads."
)
_WHERE = "square packing, 2-D Background"
_FEWEST = 3
_PLACES = (6, 10)  # spheres between which the speed is measured, from the struck one as 1
_SMALL = 0.1  # impact velocity over omega alpha0 up to which everything is linear enough


@dataclasses.dataclass(frozen=True, eq=False)
class Speeds:
    """Wave speed against load of packings of one tolerance.

    Attributes
    ----------
    packing
        In words.
    scatter
        Tolerance of the diameters, m.
    load, speed
        Pressure, Pa, or peak force, N, in rising order, and speed, m/s: (n_loads,).
    static
        The load is a pressure before the wave.
    """

    packing: str
    scatter: float
    load: Array
    speed: Array
    static: bool

    @property
    def label(self) -> str:
        """Packing and tolerance."""
        return f"{self.packing}, " + (f"scatter {1e6 * self.scatter:g} µm" if self.scatter else "like spheres")

    @property
    def local(self) -> Array:
        """Powers between neighbouring loads: (n_loads - 1,)."""
        return np.diff(np.log(self.speed)) / np.diff(np.log(self.load))


def select(runs: Sequence[FinishedRun]) -> list[list[Speeds]]:
    """One group of all tolerances of elastic packings, precompressed ones with small waves and square ones struck."""
    found = [*_precompressed(runs), *_struck(runs)]
    return [found] if any(one.scatter for one in found) else []


def rows(found: Sequence[Speeds]) -> Iterator[Row]:
    """The power over all loads, and the largest and smallest local one."""
    for one in found:
        span = f"{one.load[0]:.3g} to {one.load[-1]:.3g} {'Pa' if one.static else 'N'}"
        fit, local = power(one.load, one.speed), one.local
        quantity = f"Power of the wave speed with the force, {one.label}, {span}"
        if not one.scatter:
            remark = "Similarity forces it on any correct elastic code."
            yield Row(quantity, "", None, fit.exponent, _WHERE, remark, 1 / 6, verification=not one.static)
            continue
        remark = (
            f"No single power: from {local[0]:.3f} at the lowest loads to {local[-1]:.3f} at the highest. Defects make "
            "waves slower, weak ones most; the source says faster."
        )
        yield Row(quantity, "", 0.25, fit.exponent, _WHERE, remark)
        yield Row(f"The same at the lowest loads, {one.label}", "", None, float(local[0]), _WHERE)
        yield Row(f"The same at the highest loads, {one.label}", "", None, float(local[-1]), _WHERE, "", 1 / 6)


def pictures(found: Sequence[Speeds]) -> Iterator[Picture]:
    """Speed against load: precompressed packings, and struck ones."""
    for static, name, xlabel in ((True, "_pressure", "Pressure (Pa)"), (False, "_force", "Peak force (N)")):
        shown = [one for one in found if one.static is static]
        if not shown:
            continue
        figure, axes = panels(2.8)
        columns: dict[str, Array] = {}
        for one, colour, mark in zip(shown, COLOURS, MARKS, strict=False):
            axes.loglog(one.load, one.speed, mark + "-", color=colour, markersize=3.5, label=one.label)
            word = column_name(one.label)
            columns |= {f"{word}_{'Pa' if static else 'N'}": one.load, f"{word}_speed_m_s": one.speed}
        one = shown[-1]
        for exponent, line, label in ((1 / 6, ":", "1/6"), (1 / 4, "--", "1/4")):
            axes.loglog(
                one.load, one.speed[-1] * (one.load / one.load[-1]) ** exponent, line, color="black", label=label
            )
        axes.set(xlabel=xlabel, ylabel="Wave speed (m/s)")
        legend_outside(figure, 2, fontsize=7)
        caption = "Wave speed against " + ("the static pressure" if static else "the peak force of the wave")
        yield Picture(name, f"{caption}, with scattered diameters", Drawing(figure, columns))


def _precompressed(runs: Iterable[FinishedRun]) -> Iterator[Speeds]:
    """Small waves along the layers of fcc and hcp under uniaxial pressure, by kind and tolerance."""
    series: dict[tuple[str, float], list[tuple[float, float]]] = {}
    for run in runs:
        case, stage = run.case, run.case.precompression
        if stage is None or stage.kind != "uniaxial" or case.packing.kind not in ("fcc", "hcp") or case.contact.yields:
            continue
        line = line_of(case)
        if not run.assembly.like or case.packing.vacancies or case.load.velocity >= _SMALL * line.velocity:
            continue
        with Result(run.directory) as result:
            speed = speed_along_layers(result, line)
        if np.isfinite(speed) and stage.pressure is not None:
            series.setdefault((case.packing.kind, case.packing.diameter_scatter), []).append((stage.pressure, speed))
    for (kind, scatter), points in sorted(series.items()):
        yield from _speeds(f"{kind} under pressure", scatter, points, static=True)


def _struck(runs: Iterable[FinishedRun]) -> Iterator[Speeds]:
    """Square packings struck in their plane, by tolerance; each point a mean over seeds."""
    series: dict[float, dict[float, list[tuple[float, float]]]] = {}
    for run in packings(runs):
        case, sites = run.case, run.assembly.sites
        if case.packing.kind != "square" or run.way != "in-plane" or case.contact.law != "hertz":
            continue
        aligned = not any(any(one.offset) or any(one.misalignment) for one in case.striker)
        at_sites = case.packing.tilt is None and not case.packing.vacancies and (sites is None or sites.like)
        if aligned and at_sites and (point := _point(run)) is not None:
            series.setdefault(case.packing.diameter_scatter, {}).setdefault(run.speed, []).append(point)
    for scatter, points in sorted(series.items()):
        means = [tuple(estimate(part).mean for part in zip(*found, strict=True)) for found in points.values()]
        yield from _speeds("square struck in its plane", scatter, means, static=False)


def _point(run: PackingRun) -> tuple[float, float] | None:
    """Peak force, N, and speed, m/s, of the wave in a central chain; None if it did not pass."""
    seen, diameter = run.snapshots, run.case.packing.diameter
    chain = groups(seen)["central chains"][0]
    if len(chain.rows) <= _PLACES[1]:
        return None
    _, speed = speed_between(peaks(seen.time, chain.speeds(seen), diameter), *_PLACES, diameter)
    return (mean_peak_force(run, chain.rows[_PLACES[0] - 1 : _PLACES[1] + 1]), speed) if np.isfinite(speed) else None


def _speeds(packing: str, scatter: float, points: Iterable[Sequence[float]], *, static: bool) -> Iterator[Speeds]:
    ordered = sorted({tuple(point) for point in points})
    if len(ordered) >= _FEWEST and all(low[0] < high[0] for low, high in pairwise(ordered)):
        load, speed = np.array(ordered).T
        yield Speeds(packing, scatter, load, speed, static)
