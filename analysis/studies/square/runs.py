"""Finished runs of packings that strikers hit."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from functools import cached_property

import numpy as np

from granwave.analysis.measures.impact.regions import Snapshots, striker_velocity
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.runs import FinishedRun

WAYS = ("in-plane", "out-of-plane")


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

    @cached_property
    def snapshots(self) -> Snapshots:
        """Snapshots of a square packing."""
        with Result(self.directory) as result:
            return Snapshots.of(result)


def packings(runs: Iterable[FinishedRun]) -> list[PackingRun]:
    """Runs of packings, no chains, that strikers hit."""
    return [
        run.seen_as(PackingRun)
        for run in runs
        if run.case.packing.kind != "chain" and any(striker.moves for striker in run.case.striker)
    ]
