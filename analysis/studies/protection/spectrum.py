"""Shock spectrum of a packing: displacement of a plate on a spring against its period."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from pandas import DataFrame

from granwave.analysis.figures.series import column_name, label, legend_outside, panels
from granwave.analysis.figures.style import BLUE, GREY, ORANGE, Drawing
from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.target_theory import expected_displacement, spectrum_curves
from granwave.analysis.statistics import exactly
from granwave.analysis.studies.protection.runs import TargetRun, impacts
from granwave.analysis.studies.runs import FinishedRun, impact_title
from granwave.analysis.studies.study import Picture, Row, span
from granwave.lammps_inputs.case.boundary import Plate, time_label

TEXT = (
    "The displacement of a plate on a spring is given with and without the packing. The line is "
    "the displacement of an oscillator under the force of the same packing on a fixed wall of "
    "the plate's material. Its limits are J/(M omega) for a short impulse and F/k for a slow "
    "force. If a plate moves, the force on the plate is smaller than on a fixed wall, and its "
    "point is below the line."
)
_FEWEST = 4  # smallest number of stiffnesses
NEEDS = (
    "the same packing and impact on plates of equal mass on springs with at least "
    f"{_FEWEST} stiffnesses"
)
_MICRO = 1e6
_CURVE = 60  # points of the theoretical curve
_BELOW = 0.05  # relative deviation below the theory above which a remark is printed
_TURNED = 0.98  # fraction of a run: a displacement that is largest later may still grow

#: A packing on a wall of the plates' material, and the runs with plates of one mass below it, by
#: rising period. Columns of the runs: run, plate, period (s), largest displacement with the packing
#: (m) and without (NaN if it is not known, as for damped plates).
Spectrum = tuple[TargetRun, DataFrame]


def select(runs: Sequence[FinishedRun]) -> list[list[Spectrum]]:
    """Spectra of plates with at least four stiffnesses, for each impact.

    Each has True if the same packing was also run on a wall of the plates' material.
    """
    all_spectra = [spectra(impact) for impact in impacts(runs)]
    return [spectra_of_impact for spectra_of_impact in all_spectra if spectra_of_impact]


def spectra(runs: Sequence[TargetRun]) -> list[Spectrum]:
    """Group the runs by height, friction and mass of the plate."""
    rows = [_plate_row(run, run.plate) for run in runs if run.plate and _has_turned(run)]
    if not rows:
        return []
    spectra_of_plates = []
    for _, plates in DataFrame(rows).groupby(["layers", "friction", "mass", "damping"]):
        held_run = _held_run(runs, plates.run.iloc[0])
        if held_run is not None and len(plates) >= _FEWEST:
            spectra_of_plates.append((held_run, plates.sort_values("period", kind="stable")))
    return spectra_of_plates


def _has_turned(run: TargetRun) -> bool:
    """Return True if the target has reached its largest displacement before the end of the run."""
    return bool(run.displacement.argmax() < _TURNED * len(run.displacement))


def _plate_row(run: TargetRun, plate: Plate) -> dict[str, Any]:
    """Row of a run on a plate."""
    force = run.value("unprotected_ground_peak_force_N")
    return {
        "layers": run.layers,
        "friction": run.friction,
        "mass": plate.mass,
        "damping": plate.damping or 0.0,
        "run": run,
        "plate": plate,
        "period": plate.period,
        "displacement": run.displacement.max(),
        "without": math.nan if plate.damping else force / plate.stiffness,
    }


def _held_run(runs: Sequence[TargetRun], plate_run: TargetRun) -> TargetRun | None:
    """First run of the same packing on a wall of a plate's material; None without one."""
    material = plate_run.case.boundary.bottom_material
    for run in runs:
        is_same_packing = (run.layers, run.friction) == (plate_run.layers, plate_run.friction)
        if run.held and is_same_packing and run.case.boundary.bottom_material == material:
            return run
    return None


def title(groups: Sequence[Spectrum]) -> str:
    """Title with packing and impact."""
    one_height = len({held_run.layers for held_run, _ in groups}) == 1
    impact = impact_title(groups[0][0].assembly, height=one_height)
    return f"Protected target, shock spectrum: {impact}"


def rows(groups: Sequence[Spectrum]) -> Iterator[Row]:
    """The displacement of each plate."""
    for held_run, plates in groups:
        for run in plates.itertuples():
            expected, theory = expected_displacement(
                held_run.reached, run.plate, run.run.reached.time[-1]
            )
            below = 1 - run.displacement / expected
            remark = ""
            if below > _BELOW:
                remark = (
                    f"The displacement is {100 * below:.2g} % smaller than the displacement of the "
                    "oscillator, since the plate moves under the force."
                )
            what = f"Largest displacement of the plate, {run.mass:g} kg, {time_label(run.period)}"
            yield Row(
                what, "µm", None, _MICRO * run.displacement, theory, remark, _MICRO * expected
            )


def verdict(groups: Sequence[Spectrum]) -> Iterator[str]:
    """Ratio of displacements without and below the packing, with the periods of its ends."""
    for held_run, plates in groups:
        ratio = plates.without / plates.displacement
        if np.isfinite(ratio).all():
            what = (
                f"Displacement of a plate of {plates.mass.iloc[0]:g} kg without packing, divided "
                f"by the displacement below {held_run.layers} layers"
            )
            periods = [f"a period of {time_label(period)}" for period in plates.period]
            yield span(what, dict(zip(periods, map(exactly, ratio), strict=True)))


def pictures(groups: Sequence[Spectrum]) -> Iterator[Picture]:
    """Displacement against period, with the theory."""
    figure, axes = panels(4.4, width=4.6)
    label(axes, "Period of the plate (µs)", "Largest displacement (µm)", log="xy")
    columns: dict[str, Array] = {}
    for (held_run, plates), colour, marker in zip(
        groups, (BLUE, ORANGE, GREY), "os^", strict=False
    ):
        friction = f", friction {held_run.friction:g}" if held_run.case.has_friction else ""
        name = f"{plates.mass.iloc[0]:g} kg, {held_run.layers} layers{friction}"
        period = np.geomspace(plates.period.min(), plates.period.max(), _CURVE)
        theory = spectrum_curves(held_run.reached, plates.plate.iloc[0], period)
        word = column_name(name)
        columns |= {f"{word}_period_s": plates.period, f"{word}_line_period_s": period}
        for column, x, values, line, called in (
            (
                "displacement",
                plates.period,
                plates.displacement,
                marker,
                f"below the packing: {name}",
            ),
            ("without", plates.period, plates.without, marker, "without it"),
            ("oscillator", period, theory.oscillator, "-", "oscillator"),
            ("slow_force", period, theory.slow_force, ":", "slow force, F/k"),
            ("short_impulse", period, theory.short_impulse, "--", "short impulse, J/(Mω)"),
        ):
            full = "none" if column == "without" else colour
            axes.plot(
                _MICRO * x,
                _MICRO * values,
                line,
                color=colour,
                label=called,
                markersize=4,
                linewidth=0.9,
                markerfacecolor=full,
            )
            columns[f"{word}_{column}_m"] = values
    axes.set_ylim(0.3 * _MICRO * min(plates.displacement.min() for _, plates in groups))
    legend_outside(figure, 2, fontsize=7)
    caption = (
        "Largest displacement of the plate against its period, with the packing and without, "
        "and of an oscillator under the force on a fixed plate. The packing protects where full "
        "marks are below open marks"
    )
    yield Picture("", caption, Drawing(figure, columns))
