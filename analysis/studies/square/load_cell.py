"""Influence of spheres with sensors in a chain on what a load cell at its end reads."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from granwave.analysis.figures.series import COLOURS, legend_outside, one_panel
from granwave.analysis.figures.style import Drawing
from granwave.analysis.measures.signals import Array, first_peak, width
from granwave.analysis.measures.target.record import Reached, reached
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.chains.runs import ChainRun
from granwave.analysis.studies.runs import FinishedRun, all_but
from granwave.analysis.studies.study import Picture, Row

TITLE = "Spheres with sensors in a chain on a load cell"
TEXT = (
    "A struck chain with a load cell at its end: a plate on a spring, whose force is what the cell reads. Spheres 6, "
    "11 and 16, one by one and together, have the mass of a sphere with a sensor. Given are the change of the first "
    "peak that the cell reads and of its width at half maximum, against like spheres. The source sees no change of "
    "the wave length and no clear trend of the amplitude in ten impacts each; it tells neither mass nor stiffness of "
    "the cell, nor how well impacts repeat. Ours of the cell are assumed; a rigid wall in its place changes as much."
)
_WHERE = "square packing, Experimental Setup"


class CellRun(ChainRun):
    """A run of a chain on a target."""

    @cached_property
    def record(self) -> Reached:
        """Record of the target."""
        with Result(self.directory) as result:
            found = reached(result)
        assert found is not None
        return found

    @property
    def reading(self) -> Array:
        """Force that the cell reads, that of its spring; on a wall, that of the contact: (n_times,), N."""
        return self.record.force if self.record.ground_force is None else self.record.ground_force

    @cached_property
    def peak(self) -> tuple[float, float, float]:
        """Time (s), height (N) and width at half maximum (s) of the first peak that the cell reads."""
        time, force = self.record.time, self.reading
        when, height = first_peak(time, force, floor=0.5)
        near = time < when + 2 * (when - self.record.arrival) if self.record.arrival else time > -math.inf
        return when, height, width(time[near], force[near])

    @property
    def lighter(self) -> tuple[int, ...]:
        """Ids of the spheres of another mass."""
        return tuple(self.assembly.materials)

    @property
    def mass_ratio(self) -> float:
        """Mass of the lightest sphere over that of the others."""
        own = self.case.material.density
        return min((one.density / own for one in self.assembly.materials.values()), default=1.0)


@dataclasses.dataclass(frozen=True, eq=False)
class Chain:
    """Runs of one chain, that of like spheres and those with lighter ones."""

    plain: CellRun
    others: list[CellRun]

    @property
    def end(self) -> str:
        """Target at the end of the chain, in words."""
        return "load cell" if self.plain.case.boundary.bottom_support else "rigid wall"


def select(runs: Sequence[FinishedRun]) -> list[list[Chain]]:
    """One group of all elastic chains on a target that a striker hits, with lighter spheres and without."""
    series: dict[str, list[CellRun]] = {}
    for run in runs:
        case = run.case
        on_target = case.boundary.bottom == "wall" and case.packing.kind == "chain" and len(case.striker) == 1
        if on_target and not case.contact.yields and not run.assembly.diameters:
            series.setdefault(all_but(case, "replace"), []).append(run.seen_as(CellRun))
    found = []
    for group in series.values():
        plain = [run for run in group if not run.lighter]
        others = sorted((run for run in group if run.lighter), key=lambda run: (len(run.lighter), run.lighter))
        if plain and others:
            found.append(Chain(plain[0], others))
    found.sort(key=lambda chain: chain.end)
    return [found] if found else []


def rows(chains: Sequence[Chain]) -> Iterator[Row]:
    """Changes of the peak and of its width for each set of lighter spheres."""
    for chain in chains:
        _, height, length = chain.plain.peak
        yield Row(f"First peak, like spheres, {chain.end}", "N", None, height, _WHERE)
        for run in chain.others:
            where = f"{chain.end}, {run.mass_ratio:.3g} of the mass: {_spheres(run)}"
            higher, longer = run.peak[1] / height - 1, run.peak[2] / length - 1
            trend, same = "The source: no clear trend.", "The source: no measurable change."
            yield Row(f"Change of the first peak, {where}", "%", None, 100 * higher, _WHERE, trend)
            yield Row(f"Change of its width, {where}", "%", None, 100 * longer, _WHERE, same)


def pictures(chains: Sequence[Chain]) -> Iterator[Picture]:
    """Force at the end in time, for each set of lighter spheres."""
    for chain in chains:
        figure, axes = one_panel(2.6, "Time (µs)", "Force (N)")
        columns: dict[str, Array] = {}
        last = max(run.peak[0] + 1.5 * run.peak[2] for run in (chain.plain, *chain.others))
        first = min(run.peak[0] - 1.5 * run.peak[2] for run in (chain.plain, *chain.others))
        for run, colour in zip((chain.plain, *chain.others), COLOURS, strict=False):
            time, force = run.record.time, run.reading
            axes.plot(1e6 * time, force, color=colour, linewidth=0.9, label=_spheres(run))
            word = "_".join(["spheres", *map(str, run.lighter)]) if run.lighter else "like_spheres"
            grid = np.linspace(first, last, 400)
            columns |= {"time_s": grid, f"{word}_N": np.interp(grid, time, force)}
        axes.set(xlim=(1e6 * first, 1e6 * last), ylim=(0, None))
        legend_outside(figure, 3, fontsize=7)
        caption = f"Force that the {chain.end} at the end of the chain feels"
        yield Picture(f"_{chain.end.replace(' ', '_')}", caption, Drawing(figure, columns))


def _spheres(run: CellRun) -> str:
    numbers = [str(one) for one in run.lighter]
    if not numbers:
        return "like spheres"
    return "sphere " + numbers[0] if len(numbers) == 1 else f"spheres {', '.join(numbers[:-1])} and {numbers[-1]}"
