"""Resonances of a confined row in the density of its small spheres (thesis figure 6.7)."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from granwave.analysis.figures.chains import confined as figures
from granwave.analysis.measures.signals import Array
from granwave.analysis.studies.confined.runs import ConfinedRun, confined_runs, decay_of, of_source, symmetric_waves
from granwave.analysis.studies.confined.waves import WHERE
from granwave.analysis.studies.runs import FinishedRun, rising
from granwave.analysis.studies.study import Picture, Row

_FEWEST = 4
_SETTLED = 2.0  # density ratio up to which the wave decays uniformly from contact 60 on
_FORGETS = "Heavy small spheres: the wave does not yet decay uniformly so near the struck bead."
_RESONANCES = {0.10: 6.4e-3, 0.24: 2.8e-3, 5.0: 2.7e-3}  # by density ratio: decay of the source's model
_ANTI_RESONANCES = (0.056, 0.18, 0.42, 0.75, 2.0)


@dataclasses.dataclass(frozen=True, eq=False)
class Densities:
    """Rows that differ in the density of the small spheres alone, by rising density."""

    runs: list[ConfinedRun]

    @cached_property
    def theory(self) -> Array:
        """Decay by the equations, over the contacts that each run has passed: (n_runs,)."""
        forces = symmetric_waves(self.runs).force
        return np.array([decay_of(force[: run.passed]) for run, force in zip(self.runs, forces, strict=True)])

    @property
    def ratio(self) -> Array:
        """Density of the small spheres over that of the beads: (n_runs,)."""
        return np.array([ratio_of(run) for run in self.runs])

    @property
    def decay(self) -> Array:
        """Decay per contact: (n_runs,)."""
        return np.array([run.decay for run in self.runs])


def select(runs: Sequence[FinishedRun]) -> list[Densities]:
    """Rows that differ in the density of the small spheres alone, by rising density."""
    groups: dict[tuple, list[ConfinedRun]] = {}
    for run in confined_runs(runs):
        row = run.row
        key = (
            run.n,
            run.a,
            row.bead[0],
            row.modulus[0],
            row.small_modulus[0],
            row.density[0],
            run.velocity,
            run.struck,
        )
        if math.isfinite(run.decay):
            groups.setdefault(key, []).append(run)
    found = [rising(group, ratio_of) for group in groups.values()]
    return [Densities(group) for group in found if len(group) >= _FEWEST]


def ratio_of(run: ConfinedRun) -> float:
    """Density of the small spheres over that of the beads."""
    return float((run.row.small_density / run.row.density)[0])


def title(found: Densities) -> str:
    """By the ring."""
    return f"Confined row: resonances in the density of {found.runs[0].n} small spheres"


def text(found: Densities) -> str:
    """Describe the resonances."""
    return (
        f"n = {found.runs[0].n}, a = {found.runs[0].a:g}; the density of the small spheres alone varies. Where they "
        "still swing when the wave "
        "has passed, it loses energy to them: resonances with rapid decay, and anti-resonances between them at which "
        "the wave "
        "is nearly solitary. The source draws (1/F) dF/dx, which is minus the decay, between -7e-3 and 1e-3, with "
        "several peaks "
        "and troughs. Theory: the equations of symmetric motion, over the same contacts."
    )


def rows(found: Densities) -> Iterator[Row]:
    """Decay at each density, and where it is largest and smallest."""
    for run, expected in zip(found.runs, found.theory, strict=True):
        remark = " ".join(filter(None, (_FORGETS if ratio_of(run) > _SETTLED else "", _program(run))))
        what = f"Decay per contact, density ratio {ratio_of(run):.3g}"
        yield Row(what, "", None, run.decay, WHERE, remark, float(expected), True, 3)
    light = [run for run in found.runs if ratio_of(run) <= _SETTLED]
    worst = max(light, key=lambda run: run.decay)
    yield Row("Density ratio of the most rapid decay", "", None, ratio_of(worst), "thesis figure 6.7",
              "Of the densities that were run.", digits=3)  # fmt: skip
    yield Row("Largest decay per contact", "", None, worst.decay, "thesis figure 6.7", digits=3)


def _program(run: ConfinedRun) -> str:
    """Say what the source's model has at this density."""
    if not of_source(run):
        return ""
    ratio = round(ratio_of(run), 6)
    if ratio in _RESONANCES:
        return f"A resonance of the source's model in our second program: {_RESONANCES[ratio]:g}."
    return "An anti-resonance of the source's model." if ratio in _ANTI_RESONANCES else ""


def verdict(found: Densities) -> Iterator[str]:
    """Name resonances and anti-resonances."""
    decay, ratio = found.decay, found.ratio
    inner = np.arange(1, len(ratio) - 1)
    high = inner[(decay[inner] > decay[inner - 1]) & (decay[inner] > decay[inner + 1])]
    low = inner[(decay[inner] < decay[inner - 1]) & (decay[inner] < decay[inner + 1])]
    if len(high) and len(low):
        words = [", ".join(f"{one:g}" for one in ratio[chosen]) for chosen in (high, low)]
        yield f"The wave decays most at density ratios near {words[0]}, and is nearly solitary near {words[1]}."


def pictures(found: Densities) -> Iterator[Picture]:
    """Decay against the density ratio."""
    theory, points = ("equations", found.ratio, found.theory), ("simulation", found.ratio, found.decay)
    caption = "Decay of the wave against the density of the small spheres (thesis figure 6.7)"
    drawing = figures.decays(theory, points, "Density of small spheres over that of beads", log="x", column="ratio")
    yield Picture("", caption, drawing)
