"""Runs of the same impact on packings of other heights and on other bottoms: what reaches the target in each."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.target import Reached, reached
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.runs import FinishedRun, all_but
from granwave.analysis.studies.titles import bottom_words
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.supports import Plate
from granwave.lammps_inputs.packing.assembly import assemble, velocities_of

Array = NDArray[np.float64]

FEWEST_HEIGHTS = 3  # that make a series of packings on one bottom


class TargetRun(FinishedRun):
    """A finished run of a packing between an impact and a bottom that bears it."""

    @property
    def layers(self) -> int:
        """Of spheres, one below the other."""
        return self.assembly.lattice.shape[2]

    @property
    def friction(self) -> float:
        """Coefficient of friction between the spheres."""
        return self.case.contact.friction

    @property
    def plate(self) -> Plate | None:
        """The bottom, if it is a plate on a spring."""
        support = self.case.boundary.bottom_support
        return support.plate if support else None

    @property
    def bottom(self) -> str:
        """What the packing stands on, for people."""
        return bottom_words(self.case)

    @property
    def held(self) -> bool:
        """The bottom is a plane that does not move."""
        return self.case.boundary.bottom == "wall" and not self.moves

    @property
    def moves(self) -> bool:
        """The bottom is a support that moves."""
        return self.case.boundary.bottom_support is not None

    @property
    def momentum(self) -> float:
        """Of what hits the packing, towards the target, kg m/s; NaN under a force or a prescribed motion."""
        if self.case.load.driven:
            return math.nan
        moving = velocities_of(self.assembly).items()
        return sum(self.assembly.mass_of(sphere) * max(velocity[2], 0.0) for sphere, velocity in moving)

    @property
    def reached(self) -> Reached:
        """What reached the bottom, against time."""
        return self._read[0]

    @property
    def energy(self) -> tuple[Array, Array]:
        """Times of the ledger, s, and the work on the target by then, J; 0 if it does not move: (n_instants,) each."""
        return self._read[1]

    @property
    def displacement(self) -> Array:
        """Of the target at the same instants, outward: (n_times,), m."""
        moved = self.reached.displacement
        return np.zeros_like(self.reached.time) if moved is None else moved

    @property
    def largest_of_one(self) -> float:
        """Largest force of a single sphere on the bottom, N; NaN where a last layer is held in place of one."""
        return self._read[2]

    @cached_property
    def _read(self) -> tuple[Reached, tuple[Array, Array], float]:
        with Result(self.directory) as result:
            found = reached(result)
            assert found is not None  # `collect` takes no run without a bottom
            time = result["energy/time"]
            energy = result["energy/target"] if self.moves else np.zeros_like(time)
            single = result["wall_contacts/peak_force"][result["wall_contacts/wall"] == "bottom"]
        return found, (time, energy), float(single.max()) if len(single) else math.nan


def collect(found: Iterable[tuple[str, Path, Mapping[str, Any]]]) -> list[list[TargetRun]]:
    """Groups of finished runs of one impact in which the bottom or the height differs.

    A group has a bottom that moves, or so many heights on one bottom that they make a series; the runs are in the order
    of bottoms, friction and layers.

    Parameters
    ----------
    found
        Label, directory and summary of finished runs.
    """
    groups: dict[str, dict[str, TargetRun]] = {}
    for run in TargetRun.among(found, lambda case: case.boundary.bottom != "free" and not assemble(case).bars):
        group, key = groups.setdefault(_impact(run.case), {}), all_but(run.case)
        if run.value("end_time_s") > group.setdefault(key, run).value("end_time_s"):
            group[key] = run
    ordered = (sorted(group.values(), key=_order) for group in groups.values())
    return [runs for runs in ordered if len(runs) > 1 and (any(run.moves for run in runs) or series(runs))]


def series(runs: Sequence[TargetRun]) -> list[list[TargetRun]]:
    """Runs that differ in nothing but the height, by rising height; at least `FEWEST_HEIGHTS` of them."""
    alike: dict[str, dict[int, TargetRun]] = {}
    for run in runs:
        alike.setdefault(repr((_bottom(run.case), run.friction)), {}).setdefault(run.layers, run)
    return [[one[n] for n in sorted(one)] for one in alike.values() if len(one) >= FEWEST_HEIGHTS]


def names(runs: Sequence[TargetRun]) -> list[str]:
    """What tells runs of a group apart: the bottom, and where they differ layers and friction."""
    parts = [[run.bottom for run in runs]]
    if len({run.layers for run in runs}) > 1:
        parts.append([f"{run.layers} layers" for run in runs])
    if len({run.friction for run in runs}) > 1:
        parts.append([f"friction {run.friction:g}" for run in runs])
    found = [", ".join(words) for words in zip(*parts, strict=True)]
    return [name if found.count(name) == 1 else f"{name} ({found[:n].count(name) + 1})" for n, name in enumerate(found)]


def slug(name: str) -> str:
    """A name as part of a column's or a file's."""
    kept = "".join(letter if letter.isalnum() and letter.isascii() else "_" for letter in name.replace("µ", "u"))
    return "_".join(filter(None, kept.split("_")))


def _impact(case: Case) -> str:
    """Everything but the bottom, the height and friction."""
    base = case.packing.size[:2] if len(case.packing.size) == 3 else ()
    varying = "packing.size", "boundary.bottom", "boundary.friction", "contact.friction"
    return f"{base} {all_but(case, *varying)}"


def _bottom(case: Case) -> list[Any]:
    return [case.to_dict()["boundary"].get(key) for key in ("bottom", "friction")]


def _order(run: TargetRun) -> tuple:
    support = run.case.boundary.bottom_support
    kind = ("plate", "half_space", "bar").index(support.kind) + 1 if support else 0
    mass, stiffness = (run.plate.mass, run.plate.stiffness) if run.plate else (0.0, 0.0)
    return kind, -mass, -stiffness, run.bottom, run.friction, run.layers
