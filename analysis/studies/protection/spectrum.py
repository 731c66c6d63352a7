"""Shock spectrum of what a packing transmits: how far a plate on a spring moves, against its
period.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

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
from granwave.lammps_inputs.case.boundary import time_label

TEXT = (
    "How far a plate on a spring moves below the packing, and without it. The line is an oscillator under the "
    "force that the same packing gives a wall of the plate's material, held in place; its limits are those of a "
    "short impulse, J/(M omega), and of a slow force, F/k. Where a plate gives way, less force reaches it than a wall "
    "held in place, and its point lies below the line."
)
_FEWEST = 4  # stiffnesses
_MICRO = 1e6
_CURVE = 60  # points of the theory
_BELOW = 0.05  # of the displacement by theory, by which it falls short where a remark says so
_TURNED = 0.98  # of the run: a displacement that is largest later may still grow

#: A packing on a wall of the plates' material, and runs of plates of one mass below it, by rising period: run, plate,
#: period (s), largest displacement with the packing (m), and without (NaN where it is not known, as of damped plates).
Spectrum = tuple[TargetRun, DataFrame]


def select(runs: Sequence[FinishedRun]) -> list[list[Spectrum]]:
    """All plates of at least four stiffnesses beside the same packing on a wall of their material,
    for each impact.
    """
    return [found for group in impacts(runs) if (found := spectra(group))]


def spectra(runs: Sequence[TargetRun]) -> list[Spectrum]:
    """Group the runs by height, friction and mass of the plate."""
    rows = [
        {
            "layers": run.layers, "friction": run.friction, "mass": plate.mass, "damping": plate.damping or 0.0,
            "run": run, "plate": plate, "period": plate.period, "displacement": run.displacement.max(),
            "without": run.value("unprotected_ground_peak_force_N") / (math.nan if plate.damping else plate.stiffness),
        }
        for run in runs
        if (plate := run.plate) and run.displacement.argmax() < _TURNED * len(run.displacement)
    ]  # fmt: skip
    found = []
    for (layers, friction, *_), group in DataFrame(rows).groupby(
        ["layers", "friction", "mass", "damping"] if rows else []
    ):
        like = layers, friction, group.run.iloc[0].case.boundary.bottom_material
        held = [
            one
            for one in runs
            if one.held and (one.layers, one.friction, one.case.boundary.bottom_material) == like
        ]
        if held and len(group) >= _FEWEST:
            found.append((held[0], group.sort_values("period", kind="stable")))
    return found


def title(found: Sequence[Spectrum]) -> str:
    """Title with packing and impact."""
    one_height = len({held.layers for held, _ in found}) == 1
    return (
        f"Protected target, shock spectrum: {impact_title(found[0][0].assembly, height=one_height)}"
    )


def rows(found: Sequence[Spectrum]) -> Iterator[Row]:
    """The displacement of each plate."""
    for held, plates in found:
        for run in plates.itertuples():
            expected, theory = expected_displacement(
                held.reached, run.plate, run.run.reached.time[-1]
            )
            below = 1 - run.displacement / expected
            remark = f"{100 * below:.2g} % below the oscillator: the plate gives way to the force."
            remark = remark if below > _BELOW else ""
            what = f"Largest displacement of the plate, {run.mass:g} kg, {time_label(run.period)}"
            yield Row(
                what, "µm", None, _MICRO * run.displacement, theory, remark, _MICRO * expected
            )


def verdict(found: Sequence[Spectrum]) -> Iterator[str]:
    """Say which plates the packing helps."""
    for held, plates in found:
        ratio = plates.without / plates.displacement
        if np.isfinite(ratio).all():
            what = f"Displacement of a plate of {plates.mass.iloc[0]:g} kg without {held.layers} layers over that below"
            periods = map("a period of {}".format, map(time_label, plates.period))
            yield span(what, dict(zip(periods, map(exactly, ratio), strict=True)))


def pictures(found: Sequence[Spectrum]) -> Iterator[Picture]:
    """Displacement against period, with the theory."""
    figure, axes = panels(4.4, width=4.6)
    label(axes, "Period of the plate (µs)", "Largest displacement (µm)", log="xy")
    columns: dict[str, Array] = {}
    for (held, plates), colour, marker in zip(found, (BLUE, ORANGE, GREY), "os^", strict=False):
        friction = f", friction {held.friction:g}" if held.case.has_friction else ""
        name = f"{plates.mass.iloc[0]:g} kg, {held.layers} layers{friction}"
        period = np.geomspace(plates.period.min(), plates.period.max(), _CURVE)
        theory = spectrum_curves(held.reached, plates.plate.iloc[0], period)
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
            axes.plot(_MICRO * x, _MICRO * values, line, color=colour, label=called, markersize=4, linewidth=0.9,
                      markerfacecolor=full)  # fmt: skip
            columns[f"{word}_{column}_m"] = values
    axes.set_ylim(0.3 * _MICRO * min(plates.displacement.min() for _, plates in found))
    legend_outside(figure, 2, fontsize=7)
    caption = (
        "Largest displacement of the plate against its period, with the packing and without, and of an oscillator "
        "under the force on a plate held in place. The packing helps where full marks lie below open ones"
    )
    yield Picture("", caption, Drawing(figure, columns))
