"""Numbers of runs with targets, as columns of a table."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence

from granwave.analysis.document.cells import BLANK
from granwave.analysis.document.model import Cell, Column, Table
from granwave.analysis.studies.protection.runs import TargetRun

_DIGITS = 4


@dataclasses.dataclass(frozen=True)
class Quantity:
    """A number of a run.

    Attributes
    ----------
    heading, unit, scale
        As shown, and the unit's size in SI.
    value
        Of a run, SI; NaN where it does not apply.
    """

    heading: str
    unit: str
    scale: float
    value: Callable[[TargetRun], float]


def _of_summary(name: str) -> Callable[[TargetRun], float]:
    return lambda run: run.value(name)


FORCE = Quantity("Peak force on the target", "N", 1.0, _of_summary("wall_peak_force_N"))
LOCAL = Quantity("Largest of one sphere", "N", 1.0, lambda run: run.largest_of_one)
UNPROTECTED = Quantity("Without the packing", "N", 1.0, _of_summary("unprotected_peak_force_N"))
REDUCTION = Quantity("Peak reduction", "", 1.0, _of_summary("peak_reduction"))
PER_MASS = Quantity("Reduction per mass", "1/kg", 1.0, _of_summary("peak_reduction_per_kg"))
GAIN_PER_MASS = Quantity(
    "What a kilogram adds", "1/kg", 1.0, lambda run: (run.value("peak_reduction") - 1) / run.value("packing_mass_kg")
)
PER_HEIGHT = Quantity("Reduction per height", "1/m", 1.0, _of_summary("peak_reduction_per_m"))
MASS = Quantity("Mass", "kg", 1.0, _of_summary("packing_mass_kg"))
HEIGHT = Quantity("Height", "mm", 1e-3, _of_summary("packing_height_m"))
GROUND = Quantity("Peak force on the ground", "N", 1.0, _of_summary("ground_peak_force_N"))
GROUND_REDUCTION = Quantity("Reduction on the ground", "", 1.0, _of_summary("ground_peak_reduction"))
IMPULSE = Quantity("Impulse", "mN s", 1e-3, _of_summary("wall_impulse_Ns"))
MOMENTUM = Quantity(
    "Impulse over the impactor's momentum", "", 1.0,
    lambda run: run.value("wall_impulse_Ns") / run.momentum if run.momentum else math.nan,
)  # fmt: skip
ENERGY = Quantity(
    "Most energy at the target", "% of input", 0.01,
    lambda run: float(run.energy[1].max()) / run.value("energy_input_J") if run.moves else math.nan,
)  # fmt: skip
MOVED = Quantity("Largest displacement", "µm", 1e-6, _of_summary("target_peak_displacement_m"))


def table(caption: str, runs: Sequence[TargetRun], quantities: Sequence[Quantity]) -> Table:
    """A row for each run: bottom, layers, friction, and the quantities that any of them has."""
    found = {one: [one.value(run) for run in runs] for one in quantities}
    shown = [one for one in quantities if any(map(math.isfinite, found[one]))]
    heads = (Column("Bottom", key=True), Column("Layers", numeric=True, key=True), Column("Friction", numeric=True))
    columns = tuple(Column(one.heading, one.unit, numeric=True) for one in shown)
    rows = tuple(
        (
            Cell(run.bottom, run.bottom),
            Cell(str(run.layers), run.layers),
            Cell(f"{run.friction:g}", run.friction),
            *(_cell(found[one][n], one.scale) for one in shown),
        )
        for n, run in enumerate(runs)
    )
    return Table(caption, (*heads, *columns), rows, sortable=True)


def _cell(value: float, scale: float) -> Cell:
    return Cell(f"{value / scale:.{_DIGITS}g}", value) if math.isfinite(value) else Cell(BLANK)
