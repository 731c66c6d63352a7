"""Runs of the same impact on packings of other heights and on other bottoms: what reaches the target in each."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

from granwave.analysis.finished import FinishedRun
from granwave.analysis.result import Result
from granwave.analysis.target import Reached, reached
from granwave.lammps_inputs.assembly import velocities_of
from granwave.lammps_inputs.case import Case
from granwave.lammps_inputs.supports import Plate

Array = NDArray[np.float64]

FEWEST_HEIGHTS = 3  # that make a series of packings on one bottom
_SQUARE_CM, _MICRO, _MILLI = 1e4, 1e6, 1e3


class TargetRun(FinishedRun):
    """A finished run of a packing between an impact and a bottom that bears it."""

    @property
    def layers(self) -> int:
        """Of spheres, one below the other."""
        return self.case.lattice.shape[2]

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
        boundary = self.case.boundary
        support, material = boundary.bottom_support, boundary.bottom_material
        name = (material.name or "elastic") if material else "rigid"
        if support is None:
            return "fixed last layer" if boundary.bottom == "fixed" else f"{name} wall"
        if support.plate:
            damped = ", damped" if support.plate.damping else ""
            return f"plate of {support.plate.mass:g} kg, {shown_time(period_of(support.plate))}{damped}"
        if support.half_space:
            radius = support.half_space.radius
            return f"{name} half-space" + (f", disc of {_MILLI * radius:g} mm" if radius else "")
        assert support.bar is not None
        end = "" if support.bar.end == "infinite" else f", far end {support.bar.end}"
        return f"{name} bar of {_SQUARE_CM * support.bar.area:.3g} cm²{end}"

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
        moving = velocities_of(self.case).items()
        return sum(self.case.assembly.mass_of(sphere) * max(velocity[2], 0.0) for sphere, velocity in moving)

    @cached_property
    def reached(self) -> Reached:
        """What reached the bottom, against time."""
        return self._read[0]

    @cached_property
    def energy(self) -> Array:
        """Work on the target at the instants of `reached`: (n_times,), J; none on one that does not move."""
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
    def _read(self) -> tuple[Reached, Array, float]:
        with Result(self.directory) as result:
            found = reached(result)
            assert found is not None  # `collect` takes no run without a bottom
            speed = result["walls/bottom/velocity"] if self.moves else np.zeros_like(found.time)
            single = result["wall_contacts/peak_force"][result["wall_contacts/wall"] == "bottom"]
        energy = cumulative_trapezoid(found.force * speed, found.time, initial=0.0)
        return found, energy, float(single.max()) if len(single) else math.nan


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
    for run in TargetRun.among(found, lambda case: case.boundary.bottom != "free" and not case.assembly.bars):
        group, key = groups.setdefault(_impact(run.case), {}), _text(run.case.to_dict())
        if run.value("end_time_s") > group.setdefault(key, run).value("end_time_s"):
            group[key] = run
    ordered = (sorted(group.values(), key=_order) for group in groups.values())
    return [runs for runs in ordered if len(runs) > 1 and (any(run.moves for run in runs) or series(runs))]


def series(runs: Sequence[TargetRun]) -> list[list[TargetRun]]:
    """Runs that differ in nothing but the height, by rising height; at least `FEWEST_HEIGHTS` of them."""
    alike: dict[str, dict[int, TargetRun]] = {}
    for run in runs:
        alike.setdefault(_text([_bottom(run.case), run.friction]), {}).setdefault(run.layers, run)
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


def period_of(plate: Plate) -> float:
    """Of a plate on its spring, undamped, s."""
    return 2 * math.pi * math.sqrt(plate.mass / plate.stiffness)


def shown_time(seconds: float) -> str:
    """A time for people."""
    return f"{_MILLI * seconds:.3g} ms" if seconds >= 1e-3 else f"{_MICRO * seconds:.3g} µs"


def slug(name: str) -> str:
    """A name as part of a column's or a file's."""
    kept = "".join(letter if letter.isalnum() and letter.isascii() else "_" for letter in name.replace("µ", "u"))
    return "_".join(filter(None, kept.split("_")))


def impact(run: TargetRun) -> str:
    """Who is hit and how fast, in a few words."""
    case = run.case
    kind = "Chain" if case.packing.kind == "chain" else f"{case.packing.kind.upper()} packing"
    base = "" if case.packing.kind == "chain" else f", {' x '.join(map(str, case.packing.size[:2]))} a layer"
    speeds = [math.hypot(*striker.velocity) for striker in case.striker] or [case.load.velocity]
    load = f"{max(speeds):g} m/s" if case.load.kind in ("impact", "striker") else f"{case.load.kind} on top"
    return (
        f"{kind} of {1e3 * case.packing.diameter:.4g} mm, {case.material.name or 'own material'}, "
        f"{case.contact.law}{base}, {load}"
    )


def _impact(case: Case) -> str:
    """Everything but the bottom, the height, friction, and how the run was followed."""
    tables = case.to_dict()
    for name in ("name", "run", "output", "sensor", "resolved"):
        tables.pop(name, None)
    size = case.packing.size
    tables["packing"]["size"] = list(size[:2]) if len(size) == 3 else []
    for key in ("bottom", "friction"):
        tables["boundary"].pop(key, None)
    tables["contact"].pop("friction", None)
    return _text(tables)


def _bottom(case: Case) -> list[Any]:
    return [case.to_dict()["boundary"].get(key) for key in ("bottom", "friction")]


def _order(run: TargetRun) -> tuple:
    support = run.case.boundary.bottom_support
    kind = ("plate", "half_space", "bar").index(support.kind) + 1 if support else 0
    mass, stiffness = (run.plate.mass, run.plate.stiffness) if run.plate else (0.0, 0.0)
    return kind, -mass, -stiffness, run.bottom, run.friction, run.layers


def _text(tables: Any) -> str:
    return json.dumps(tables, sort_keys=True)
