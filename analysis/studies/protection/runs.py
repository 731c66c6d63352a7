"""Runs of the same impact on packings of different heights and on different bottoms, with the force
and energy that reach the target.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property

import numpy as np

from granwave.analysis.document.model import BLANK, Cell, DocumentTable, TableColumn
from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.target_record import Reached, reached
from granwave.analysis.result.reader import Result
from granwave.analysis.statistics import exactly
from granwave.analysis.studies.runs import FinishedRun, all_but, bottom_label
from granwave.analysis.studies.study import numeric, span, table_of
from granwave.lammps_inputs.case.boundary import SUPPORTS, Plate
from granwave.lammps_inputs.packing.motion import velocities_of

_Z = 2  # component of a velocity towards the target
FEWEST_HEIGHTS = 3  # smallest number of heights in a series of packings on a bottom
_DIGITS = 4  # significant digits of values in tables
#: Values of a run: heading, unit, factor from SI, and the tables that show them: by Height, by
#: Bottom.
QUANTITIES: dict[str, tuple[str, str, float, str]] = {
    "packing_height_m": ("Height", "mm", 1e3, "H"),
    "packing_mass_kg": ("Mass", "kg", 1.0, "H"),
    "wall_peak_force_N": ("Peak force on the target", "N", 1.0, "HB"),
    "largest_of_one_N": ("Largest of one sphere", "N", 1.0, "B"),
    "unprotected_peak_force_N": ("Without the packing", "N", 1.0, "HB"),
    "peak_reduction": ("Peak reduction", "", 1.0, "HB"),
    "peak_reduction_per_kg": ("Reduction per mass", "1/kg", 1.0, "H"),
    "peak_reduction_per_m": ("Reduction per height", "1/m", 1.0, "H"),
    "gain_per_kg": ("Gain per kilogram", "1/kg", 1.0, "H"),
    "ground_peak_force_N": ("Peak force on the ground", "N", 1.0, "B"),
    "ground_peak_reduction": ("Reduction on the ground", "", 1.0, "B"),
    "wall_impulse_Ns": ("Impulse", "mN s", 1e3, "HB"),
    "impulse_over_momentum": ("Impulse / momentum of the impactor", "", 1.0, "B"),
    "energy_over_input": ("Largest energy at the target", "% of input", 100.0, "HB"),
    "target_peak_displacement_m": ("Largest displacement", "µm", 1e6, "B"),
}


class TargetRun(FinishedRun):
    """A finished run of a packing between an impact and a bottom that supports it."""

    def value(self, name: str) -> float:
        """A number of the summary, or one of the further `QUANTITIES`; NaN if not applicable."""
        if name == "largest_of_one_N":
            with Result(self.directory) as result:
                at_bottom = result["wall_contacts/wall"] == "bottom"
                forces = result["wall_contacts/peak_force"][at_bottom]
            return float(forces.max()) if len(forces) else math.nan  # none where a layer is held
        if name == "gain_per_kg":
            return (self.value("peak_reduction") - 1) / self.value("packing_mass_kg")
        if name == "impulse_over_momentum":
            return self.value("wall_impulse_Ns") / self.momentum if self.momentum else math.nan
        if name == "energy_over_input":
            if not self.moves:
                return math.nan
            _, work = self.energy
            return float(work.max()) / self.value("energy_input_J")
        return super().value(name)

    @property
    def layers(self) -> int:
        """Number of layers of spheres."""
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
        """True if the bottom is a fixed plane."""
        return self.case.boundary.bottom_rule.has_plane and not self.moves

    @property
    def moves(self) -> bool:
        """True if the bottom is a support that moves."""
        return self.case.boundary.bottom_support is not None

    @property
    def momentum(self) -> float:
        """Momentum of the impactor towards the target, kg m/s; NaN under a force or a prescribed
        motion.
        """
        if self.case.load.driven:
            return math.nan
        velocities = velocities_of(self.assembly)
        return sum(
            self.assembly.mass_of(sphere) * max(velocity[_Z], 0.0)
            for sphere, velocity in velocities.items()
        )

    @cached_property
    def reached(self) -> Reached:
        """Record of the bottom against time."""
        with Result(self.directory) as result:
            arrival = reached(result)
        assert arrival is not None  # `impacts` takes no run without a bottom
        return arrival

    @cached_property
    def energy(self) -> tuple[Array, Array]:
        """Times of the energy balance, s, and the work on the target up to then, J, 0 if it does
        not move: (n_instants,) each.
        """
        with Result(self.directory) as result:
            time = result["energy/time"]
            work = result["energy/target"] if self.moves else np.zeros_like(time)
            return time, work

    @property
    def displacement(self) -> Array:
        """Displacement of the target at the same instants, outward: (n_times,), m."""
        moved = self.reached.displacement
        return np.zeros_like(self.reached.time) if moved is None else moved


def impacts(runs: Iterable[FinishedRun]) -> list[list[TargetRun]]:
    """Group the runs by impact; in a group the bottom, the height or friction differs.

    A group has a bottom that moves, or a series of heights on a bottom. Its runs are in the order
    of bottoms, friction and layers. Of runs with equal cases only the longest counts.
    """
    groups: dict[str, dict[str, TargetRun]] = {}
    for run in runs:
        if run.case.boundary.bottom_rule.bears and not run.assembly.bars:
            target_run = run.seen_as(TargetRun)
            group = groups.setdefault(_impact(run), {})
            longest = group.setdefault(all_but(run.case), target_run)
            if target_run.value("end_time_s") > longest.value("end_time_s"):
                group[all_but(run.case)] = target_run
    ordered = (sorted(group.values(), key=_order) for group in groups.values())
    return [group for group in ordered if len(group) > 1 and _is_comparable(group)]


def _is_comparable(runs: Sequence[TargetRun]) -> bool:
    """Return True if a bottom moves, or the runs have a series of heights."""
    return any(run.moves for run in runs) or bool(series(runs))


def series(runs: Sequence[TargetRun]) -> list[list[TargetRun]]:
    """Series of at least `FEWEST_HEIGHTS` runs that differ only in the height, by rising height."""
    alike: dict[str, list[TargetRun]] = {}
    for run in runs:
        boundary = run.case.to_dict()["boundary"]
        key = repr((boundary.get("bottom"), boundary.get("friction"), run.friction))
        alike.setdefault(key, []).append(run)
    by_height = [_by_height(runs) for runs in alike.values()]
    return [runs for runs in by_height if len(runs) >= FEWEST_HEIGHTS]


def _by_height(runs: Sequence[TargetRun]) -> list[TargetRun]:
    """Return the first run of each number of layers, by increasing height."""
    first_runs = {run.layers: run for run in reversed(runs)}
    return [first_runs[layers] for layers in sorted(first_runs)]


def names(runs: Sequence[TargetRun]) -> list[str]:
    """Label each run of a group by its bottom, and by layers and friction if these differ."""
    parts = [[run.bottom for run in runs]]
    if len({run.layers for run in runs}) > 1:
        parts.append([f"{run.layers} layers" for run in runs])
    if len({run.friction for run in runs}) > 1:
        parts.append([f"friction {run.friction:g}" for run in runs])
    labels = [", ".join(words) for words in zip(*parts, strict=True)]
    return [
        label if labels.count(label) == 1 else f"{label} ({labels[:n].count(label) + 1})"
        for n, label in enumerate(labels)
    ]


def _impact(run: FinishedRun) -> str:
    """Text of all keys of an impact except the bottom, the height and friction."""
    size = run.case.packing.size
    varying = "packing.size", "boundary.bottom", "boundary.friction", "contact.friction"
    return f"{size[:2] if len(size) == 3 else ()} {all_but(run.case, *varying)}"


def _order(run: TargetRun) -> tuple:
    """Order of a run: by bottom, heavy and stiff plates first, then by friction and layers."""
    support = run.case.boundary.bottom_support
    kind = list(SUPPORTS).index(support.kind) + 1 if support else 0
    mass = 0.0
    stiffness = 0.0
    if run.plate:
        mass = run.plate.mass
        stiffness = run.plate.stiffness
    return kind, -mass, -stiffness, run.bottom, run.friction, run.layers


def table(caption: str, runs: Sequence[TargetRun], kind: str) -> DocumentTable:
    """Table with a row for each run: bottom, layers, friction, and the quantities of a kind of
    table ("H" or "B") that any of the runs has.
    """
    headings = []
    factors = {}  # factors of the shown quantities
    for name, (heading, unit, factor, kinds) in QUANTITIES.items():
        if kind in kinds and any(math.isfinite(run.value(name)) for run in runs):
            headings.append((heading, unit))
            factors[name] = factor
    keys = (TableColumn("Bottom", key=True), *numeric("Layers", key=True), *numeric("Friction"))
    rows = []
    for run in runs:
        cells = [_cell(factor * run.value(name)) for name, factor in factors.items()]
        rows.append((run.bottom, run.layers, Cell(f"{run.friction:g}", run.friction), *cells))
    return table_of(caption, (*keys, *numeric(*headings)), rows, sortable=True)


def _cell(value: float) -> Cell:
    """Cell of a value, blank for NaN."""
    return Cell(f"{value:.{_DIGITS}g}", value) if math.isfinite(value) else Cell(BLANK)


def spans(runs: Sequence[TargetRun], *quantities: str) -> Iterator[str]:
    """Sentences with the range of each quantity, and the bottoms of its ends."""
    for name in quantities:
        heading, unit, factor, _ = QUANTITIES[name]
        values = {run.bottom: run.value(name) for run in runs if math.isfinite(run.value(name))}
        if values:
            scaled = {bottom: exactly(factor * value) for bottom, value in values.items()}
            yield span(heading, scaled, unit)
