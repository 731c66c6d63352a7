"""Numbers of runs with targets, as columns of a table."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from granwave.analysis.document.model import Cell, Column, Table
from granwave.analysis.studies.protection.runs import TargetRun
from granwave.analysis.studies.tables import Quantity, of_summary, values_table

_DIGITS = 4


def _gain_per_mass(run: TargetRun) -> float:
    return (run.value("peak_reduction") - 1) / run.value("packing_mass_kg")


def _momentum(run: TargetRun) -> float:
    return run.value("wall_impulse_Ns") / run.momentum if run.momentum else math.nan


def _energy(run: TargetRun) -> float:
    return float(run.energy[1].max()) / run.value("energy_input_J") if run.moves else math.nan


def _shown(key: str, heading: str, unit: str = "", per_unit: float = 1.0) -> Quantity:
    return Quantity(key, heading, unit, of_summary(key), per_unit)


FORCE = _shown("wall_peak_force_N", "Peak force on the target", "N")
LOCAL = Quantity("largest_of_one_N", "Largest of one sphere", "N", lambda run: run.largest_of_one)
UNPROTECTED = _shown("unprotected_peak_force_N", "Without the packing", "N")
REDUCTION = _shown("peak_reduction", "Peak reduction")
PER_MASS = _shown("peak_reduction_per_kg", "Reduction per mass", "1/kg")
GAIN_PER_MASS = Quantity("gain_per_kg", "What a kilogram adds", "1/kg", _gain_per_mass)
PER_HEIGHT = _shown("peak_reduction_per_m", "Reduction per height", "1/m")
MASS = _shown("packing_mass_kg", "Mass", "kg")
HEIGHT = _shown("packing_height_m", "Height", "mm", 1e3)
GROUND = _shown("ground_peak_force_N", "Peak force on the ground", "N")
GROUND_REDUCTION = _shown("ground_peak_reduction", "Reduction on the ground")
IMPULSE = _shown("wall_impulse_Ns", "Impulse", "mN s", 1e3)
MOMENTUM = Quantity("impulse_over_momentum", "Impulse over the impactor's momentum", "", _momentum)
ENERGY = Quantity("energy_over_input", "Most energy at the target", "% of input", _energy, 100.0)
MOVED = _shown("target_peak_displacement_m", "Largest displacement", "µm", 1e6)

_KEYS: tuple[tuple[Column, Callable[[TargetRun], Cell]], ...] = (
    (Column("Bottom", key=True), lambda run: Cell(run.bottom, run.bottom)),
    (Column("Layers", numeric=True, key=True), lambda run: Cell(str(run.layers), run.layers)),
    (Column("Friction", numeric=True), lambda run: Cell(f"{run.friction:g}", run.friction)),
)


def table(caption: str, runs: Sequence[TargetRun], quantities: Sequence[Quantity]) -> Table:
    """A row for each run: bottom, layers, friction, and the quantities that any of them has."""
    shown = [one for one in quantities if any(math.isfinite(one.value(run)) for run in runs)]
    return values_table(caption, runs, shown, _KEYS, lambda value: Cell(f"{value:.{_DIGITS}g}", value))
