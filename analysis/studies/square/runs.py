"""Finished runs of packings that strikers hit."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from functools import cached_property

import numpy as np

from granwave.analysis.measures.impact.regions import Snapshots, settled, striker_velocity
from granwave.analysis.measures.waves.directions import Spread, energy_of_spheres, spread, travelling_frame
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.runs import FinishedRun, rising
from granwave.lammps_inputs.case.material import material

WAYS = ("in-plane", "out-of-plane")
SOURCE_SIZE, SOURCE_DIAMETER, SOURCE_MATERIAL = (20, 20), 0.01905, "stainless-steel-316"
SOURCE_VELOCITY = {"in-plane": 0.29, "out-of-plane": 0.65}  # m/s, of the striker
_SAME = 1e-6


class PackingRun(FinishedRun):
    """A finished run of a packing that is no chain, hit by strikers."""

    @cached_property
    def speed(self) -> float:
        """Speed of the fastest striker, m/s."""
        return float(np.linalg.norm(striker_velocity(self.case)))

    @property
    def way(self) -> str:
        """``in-plane`` or ``out-of-plane``, of a square packing."""
        return WAYS[int(np.argmax(np.abs(striker_velocity(self.case))) == 2)]

    @property
    def alike(self) -> bool:
        """All spheres of the packing are; where their values come from does not matter."""
        theirs = self.case.material
        others = self.assembly.materials.values()
        return all(dataclasses.replace(one, source=theirs.source) == theirs for one in others)

    @property
    def ideal(self) -> bool:
        """Diameters do not scatter, and no striker is misaligned."""
        aside = any(any(striker.offset) or any(striker.misalignment) for striker in self.case.striker)
        return not (self.case.packing.diameter_scatter or aside)

    @property
    def is_source_impact(self) -> bool:
        """The source's packing at the source's velocity, whatever the law and single spheres."""
        ours, theirs, packing = self.case.material, material(SOURCE_MATERIAL), self.case.packing
        same = all(getattr(ours, key) == getattr(theirs, key) for key in ("youngs_modulus", "poisson_ratio", "density"))
        sizes = (packing.diameter / SOURCE_DIAMETER, self.speed / SOURCE_VELOCITY[self.way])
        return same and packing.size == SOURCE_SIZE and all(abs(ratio - 1) < _SAME for ratio in sizes)

    @cached_property
    def snapshots(self) -> Snapshots:
        """Snapshots of a square packing."""
        with Result(self.directory) as result:
            return Snapshots.of(result)

    @cached_property
    def settled(self) -> dict[str, float]:
        """Share of the input that each region got; see `granwave.analysis.measures.impact.regions.settled`."""
        return settled(self.snapshots)

    @cached_property
    def spreads(self) -> tuple[Spread | None, Spread | None]:
        """By direction: of the travelling energy, and of dissipation."""
        with Result(self.directory) as result:
            energy = energy_of_spheres(result, travelling_frame(result))
            return spread(result, energy), spread(result, result["spheres/dissipated_energy"])


def packings(runs: Iterable[FinishedRun]) -> list[PackingRun]:
    """Runs of packings, no chains, that strikers hit."""
    return [
        run.seen_as(PackingRun)
        for run in runs
        if run.case.packing.kind != "chain" and any(striker.moves for striker in run.case.striker)
    ]


def squares(runs: Iterable[FinishedRun], way: str, law: str) -> list[PackingRun]:
    """Runs of like spheres in an ideal square packing, by rising speed of the striker, one of a speed."""
    chosen = [run for run in packings(runs) if run.case.packing.kind == "square" and run.way == way]
    like = (run for run in chosen if run.alike and run.ideal and run.case.contact.law == law)
    return rising(like, lambda run: run.speed)
