"""Finished runs of packings that strikers hit, with their snapshots."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.directions import Spread, energy_of_spheres, spread, struck_rows, travelling_frame
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.runs import FinishedRun
from granwave.lammps_inputs.case.material import material

Array = NDArray[np.float64]

SOURCE_SIZE, SOURCE_DIAMETER, SOURCE_MATERIAL = (20, 20), 0.01905, "stainless-steel-316"
SOURCE_VELOCITY = {"in-plane": 0.29, "out-of-plane": 0.65}  # m/s, of the striker
_SAME = 1e-6


class PackingRun(FinishedRun):
    """A finished run of a packing that is no chain, hit by strikers."""

    @cached_property
    def velocity_in(self) -> Array:
        """Velocity of the fastest striker: (3,), m/s."""
        return np.array(max((striker.velocity for striker in self.case.striker), key=np.linalg.norm))

    @property
    def speed(self) -> float:
        """Of the fastest striker, m/s."""
        return float(np.linalg.norm(self.velocity_in))

    @property
    def axis(self) -> int:
        """Along which it comes: 0, 1, 2."""
        return int(np.argmax(np.abs(self.velocity_in)))

    @property
    def way(self) -> str:
        """``in-plane`` or ``out-of-plane``, of a square packing."""
        return "out-of-plane" if self.axis == 2 else "in-plane"

    @property
    def law(self) -> str:
        """The contact law."""
        return self.case.contact.law

    @property
    def alike(self) -> bool:
        """All spheres of the packing are; where their values come from does not matter."""
        theirs = self.case.material
        others = self.assembly.materials.values()
        return all(dataclasses.replace(one, source=theirs.source) == theirs for one in others)

    @property
    def is_source(self) -> bool:
        """The source's packing, whatever the velocity, the law and single spheres."""
        ours, theirs = self.case.material, material(SOURCE_MATERIAL)
        same = all(getattr(ours, key) == getattr(theirs, key) for key in ("youngs_modulus", "poisson_ratio", "density"))
        packing = self.case.packing
        return same and packing.size == SOURCE_SIZE and abs(packing.diameter / SOURCE_DIAMETER - 1) < _SAME

    @property
    def is_source_impact(self) -> bool:
        """The source's packing at the source's velocity."""
        return self.is_source and abs(self.speed / SOURCE_VELOCITY[self.way] - 1) < _SAME

    @cached_property
    def _arrays(self) -> dict[str, NDArray]:
        """Snapshots as they are needed of every sphere; small packings only."""
        with Result(self.directory) as result:
            frames = range(result.n_frames)
            found: dict[str, NDArray] = {
                "time": result.frame_times,
                "position": result["spheres/position"],
                "struck": struck_rows(result),
                "velocity": np.stack([result.frame(frame, "velocity") for frame in frames]),
                "energy": np.stack([energy_of_spheres(result, frame) for frame in frames]) / result.energy_input,
            }
            found |= {name: result[f"energy/{name}"] for name in ("elastic_wall", "dissipated", "input")}
            found["ledger"] = result["energy/time"]
        return found

    @property
    def time(self) -> Array:
        """Of the snapshots: (n_frames,), s."""
        return self._arrays["time"]

    @property
    def velocity(self) -> Array:
        """Of the spheres: (n_frames, n_spheres, 3), m/s."""
        return self._arrays["velocity"]

    @property
    def energy(self) -> Array:
        """Of the spheres, elastic energy halved between them, over the input: (n_frames, n_spheres)."""
        return self._arrays["energy"]

    @property
    def position(self) -> Array:
        """Of the spheres at the start: (n_spheres, 3), m."""
        return self._arrays["position"]

    @property
    def struck(self) -> NDArray[np.int64]:
        """Rows of the spheres that a striker touches."""
        return self._arrays["struck"]

    def of_ledger(self, name: str) -> Array:
        """``elastic_wall`` or ``dissipated`` over the input at the snapshots: (n_frames,)."""
        share = self._arrays[name] / self._arrays["input"][-1]
        return np.interp(self.time, self._arrays["ledger"], share)

    def chain(self, row: int, axis: int, sign: int) -> NDArray[np.int64]:
        """Rows of the spheres of a square packing from one on, itself among them, along an axis of the lattice."""
        nx, ny = self.case.packing.size
        place = [row % nx, row // nx]
        count = (nx, ny)[axis] - place[axis] if sign > 0 else place[axis] + 1
        return row + sign * (1, nx)[axis] * np.arange(count)

    @cached_property
    def spreads(self) -> tuple[Spread | None, Spread | None]:
        """By direction: of the travelling energy, and of dissipation."""
        with Result(self.directory) as result:
            energy = energy_of_spheres(result, travelling_frame(result))
            return spread(result, energy), spread(result, result["spheres/dissipated_energy"])


def collect(found: Iterable[tuple[str, Path, Mapping[str, Any]]]) -> tuple[PackingRun, ...]:
    """Of finished runs, given by label, directory and summary, those of packings that strikers hit."""
    return PackingRun.among(
        found, lambda case: case.packing.kind != "chain" and any(striker.moves for striker in case.striker)
    )


def squares(runs: Sequence[PackingRun], way: str, law: str | None = None) -> list[PackingRun]:
    """Runs of like spheres in a square packing, by rising speed of the striker, one of a speed."""
    unique: dict[tuple[str, float], PackingRun] = {}
    for run in runs:
        fits = run.case.packing.kind == "square" and run.way == way and law in (None, run.law)
        if fits and run.alike:
            unique.setdefault((run.law, run.speed), run)
    return sorted(unique.values(), key=lambda run: run.speed)
