"""Runs of the same impact on packings of other heights and on other bottoms: what reaches the
target in each.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property

import numpy as np

from granwave.analysis.document.model import BLANK, Cell, DocumentTable, TableColumn
from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.target import Reached, reached
from granwave.analysis.result.reader import Result
from granwave.analysis.statistics import exactly
from granwave.analysis.studies.runs import FinishedRun, all_but, bottom_label
from granwave.analysis.studies.study import numeric, span, table_of
from granwave.lammps_inputs.case.boundary import SUPPORTS, Plate
from granwave.lammps_inputs.packing.motion import velocities_of

FEWEST_HEIGHTS = 3  # that make a series of packings on one bottom
_DIGITS = 4
#: Numbers of a run: heading and unit, what SI values are multiplied by for it, and the tables: by Height, by Bottom.
QUANTITIES: dict[str, tuple[str, str, float, str]] = {
    "packing_height_m": ("Height", "mm", 1e3, "H"),
    "packing_mass_kg": ("Mass", "kg", 1.0, "H"),
    "wall_peak_force_N": ("Peak force on the target", "N", 1.0, "HB"),
    "largest_of_one_N": ("Largest of one sphere", "N", 1.0, "B"),
    "unprotected_peak_force_N": ("Without the packing", "N", 1.0, "HB"),
    "peak_reduction": ("Peak reduction", "", 1.0, "HB"),
    "peak_reduction_per_kg": ("Reduction per mass", "1/kg", 1.0, "H"),
    "peak_reduction_per_m": ("Reduction per height", "1/m", 1.0, "H"),
    "gain_per_kg": ("What a kilogram adds", "1/kg", 1.0, "H"),
    "ground_peak_force_N": ("Peak force on the ground", "N", 1.0, "B"),
    "ground_peak_reduction": ("Reduction on the ground", "", 1.0, "B"),
    "wall_impulse_Ns": ("Impulse", "mN s", 1e3, "HB"),
    "impulse_over_momentum": ("Impulse over the impactor's momentum", "", 1.0, "B"),
    "energy_over_input": ("Most energy at the target", "% of input", 100.0, "HB"),
    "target_peak_displacement_m": ("Largest displacement", "µm", 1e6, "B"),
}


class TargetRun(FinishedRun):
    """A finished run of a packing between an impact and a bottom that bears it."""

    def value(self, name: str) -> float:
        """A number of the summary, or one of the further `QUANTITIES`; NaN where it does not apply."""
        if name == "largest_of_one_N":
            with Result(self.directory) as result:
                single = result["wall_contacts/peak_force"][
                    result["wall_contacts/wall"] == "bottom"
                ]
            return float(single.max()) if len(single) else math.nan  # where a layer is held
        if name == "gain_per_kg":
            return (self.value("peak_reduction") - 1) / self.value("packing_mass_kg")
        if name == "impulse_over_momentum":
            return self.value("wall_impulse_Ns") / self.momentum if self.momentum else math.nan
        if name == "energy_over_input":
            return (
                float(self.energy[1].max()) / self.value("energy_input_J")
                if self.moves
                else math.nan
            )
        return super().value(name)

    @property
    def layers(self) -> int:
        """Layers of spheres, one below the other."""
        return self.assembly.lattice.shape[2]

    @property
    def friction(self) -> float:
        """Coefficient of friction between the spheres."""
        return self.case.contact.friction

    @property
    def plate(self) -> Plate | None:
        """The bottom, if it is a plate on a spring."""
        support = self.case.boundary.bottom_support
        return support if isinstance(support, Plate) else None

    @property
    def bottom(self) -> str:
        """Label of the bottom."""
        return bottom_label(self.case)

    @property
    def held(self) -> bool:
        """The bottom is a plane that does not move."""
        return self.case.boundary.bottom_rule.has_plane and not self.moves

    @property
    def moves(self) -> bool:
        """The bottom is a support that moves."""
        return self.case.boundary.bottom_support is not None

    @property
    def momentum(self) -> float:
        """Momentum of what hits the packing, towards the target, kg m/s; NaN under a force or a
        prescribed motion.
        """
        if self.case.load.driven:
            return math.nan
        moving = velocities_of(self.assembly).items()
        return sum(
            self.assembly.mass_of(sphere) * max(velocity[2], 0.0) for sphere, velocity in moving
        )

    @cached_property
    def reached(self) -> Reached:
        """Record of the bottom against time."""
        with Result(self.directory) as result:
            found = reached(result)
        assert found is not None  # `impacts` takes no run without a bottom
        return found

    @cached_property
    def energy(self) -> tuple[Array, Array]:
        """Times of the ledger, s, and the work on the target by then, J; 0 if it does not move:
        (n_instants,) each.
        """
        with Result(self.directory) as result:
            time = result["energy/time"]
            return time, result["energy/target"] if self.moves else np.zeros_like(time)

    @property
    def displacement(self) -> Array:
        """Displacement of the target at the same instants, outward: (n_times,), m."""
        moved = self.reached.displacement
        return np.zeros_like(self.reached.time) if moved is None else moved


def impacts(runs: Iterable[FinishedRun]) -> list[list[TargetRun]]:
    """Runs of one impact in which the bottom, the height or friction differs, for each impact.

    A group has a bottom that moves, or so many heights on one bottom that they make a series; the
    runs are in the order of bottoms, friction and layers. Of equal cases the longest run counts.
    """
    groups: dict[str, dict[str, TargetRun]] = {}
    for run in runs:
        if run.case.boundary.bottom_rule.bears and not run.assembly.bars:
            one = run.seen_as(TargetRun)
            group = groups.setdefault(_impact(run), {})
            key = all_but(run.case)
            if one.value("end_time_s") > group.setdefault(key, one).value("end_time_s"):
                group[key] = one
    ordered = (sorted(group.values(), key=_order) for group in groups.values())
    return [
        runs
        for runs in ordered
        if len(runs) > 1 and (any(run.moves for run in runs) or series(runs))
    ]


def series(runs: Sequence[TargetRun]) -> list[list[TargetRun]]:
    """Runs that differ in nothing but the height, by rising height; at least `FEWEST_HEIGHTS` of
    them.
    """
    alike: dict[str, list[TargetRun]] = {}
    for run in runs:
        boundary = run.case.to_dict()["boundary"]
        alike.setdefault(
            repr((boundary.get("bottom"), boundary.get("friction"), run.friction)), []
        ).append(run)
    found = [
        {run.layers: run for run in reversed(one)} for one in alike.values()
    ]  # of equal heights the first
    return [[one[layers] for layers in sorted(one)] for one in found if len(one) >= FEWEST_HEIGHTS]


def names(runs: Sequence[TargetRun]) -> list[str]:
    """Label each run of a group by what differs: the bottom, and where they differ layers and
    friction.
    """
    parts = [[run.bottom for run in runs]]
    if len({run.layers for run in runs}) > 1:
        parts.append([f"{run.layers} layers" for run in runs])
    if len({run.friction for run in runs}) > 1:
        parts.append([f"friction {run.friction:g}" for run in runs])
    found = [", ".join(words) for words in zip(*parts, strict=True)]
    return [
        name if found.count(name) == 1 else f"{name} ({found[:n].count(name) + 1})"
        for n, name in enumerate(found)
    ]


def _impact(run: FinishedRun) -> str:
    """Text of all of the impact but the bottom, the height and friction."""
    size = run.case.packing.size
    varying = "packing.size", "boundary.bottom", "boundary.friction", "contact.friction"
    return f"{size[:2] if len(size) == 3 else ()} {all_but(run.case, *varying)}"


def _order(run: TargetRun) -> tuple:
    support = run.case.boundary.bottom_support
    kind = list(SUPPORTS).index(support.kind) + 1 if support else 0
    mass, stiffness = (run.plate.mass, run.plate.stiffness) if run.plate else (0.0, 0.0)
    return kind, -mass, -stiffness, run.bottom, run.friction, run.layers


def table(caption: str, runs: Sequence[TargetRun], kind: str) -> DocumentTable:
    """A row for each run: bottom, layers, friction, and the quantities of a kind of table that any
    of the runs has.
    """
    named = {
        name: (heading, unit, size)
        for name, (heading, unit, size, kinds) in QUANTITIES.items()
        if kind in kinds
    }
    shown = {
        name: entry
        for name, entry in named.items()
        if any(math.isfinite(run.value(name)) for run in runs)
    }
    heads = (TableColumn("Bottom", key=True), *numeric("Layers", key=True), *numeric("Friction"))
    rows = [
        (
            run.bottom,
            run.layers,
            Cell(f"{run.friction:g}", run.friction),
            *(
                Cell(f"{value:.{_DIGITS}g}", value)
                if math.isfinite(value := size * run.value(name))
                else Cell(BLANK)
                for name, (_, _, size) in shown.items()
            ),
        )
        for run in runs
    ]
    columns = (*heads, *numeric(*((heading, unit) for heading, unit, _ in shown.values())))
    return table_of(caption, columns, rows, sortable=True)


def spans(runs: Sequence[TargetRun], *quantities: str) -> Iterator[str]:
    """Say between which values quantities lie, and on which bottoms."""
    for name in quantities:
        heading, unit, size, _ = QUANTITIES[name]
        found = {
            run.bottom: size * run.value(name) for run in runs if math.isfinite(run.value(name))
        }
        if found:
            yield span(heading, {bottom: exactly(value) for bottom, value in found.items()}, unit)
