"""Shock spectrum of what a packing transmits: how far a plate on a spring moves, against its period."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from granwave.analysis.figures.series import column_name, label, legend_outside, panels
from granwave.analysis.figures.style import BLUE, GREY, ORANGE, Drawing
from granwave.analysis.formatting.numbers import number
from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.target import period_of
from granwave.analysis.measures.target_theory import expected_displacement, spectrum_curves
from granwave.analysis.studies.protection.runs import TargetRun, impacts
from granwave.analysis.studies.runs import FinishedRun, impact_title, time_label
from granwave.analysis.studies.study import Picture, Row
from granwave.lammps_inputs.case.boundary import Plate

TEXT = (
    "How far a plate on a spring moves below the packing, and without it. The line is an oscillator under the "
    "force that the same packing gives a wall of the plate's material, held in place; its limits are those of a "
    "short impulse, J/(M omega), and of a slow force, F/k. A light plate gives way: less force reaches it, and the "
    "points lie below the line."
)
_FEWEST = 4  # stiffnesses
_MICRO = 1e6
_CURVE = 60  # points of the theory
_GIVES_WAY = 0.95  # of the displacement by theory: below it a remark says so
_TURNED = 0.98  # of the run: a displacement that is largest later may still grow


@dataclasses.dataclass(frozen=True, eq=False)
class Spectrum:
    """Plates of one mass on springs, by rising period, and the same packing on a wall of their material."""

    runs: list[TargetRun]
    held: TargetRun

    @property
    def plates(self) -> list[Plate]:
        """The plate of each run."""
        return [plate for run in self.runs if (plate := run.plate)]

    @property
    def period(self) -> Array:
        """Period of the plates: (n_runs,), s."""
        return np.array([period_of(plate) for plate in self.plates])

    @property
    def displacement(self) -> Array:
        """The largest of each: (n_runs,), m."""
        return np.array([run.displacement.max() for run in self.runs])

    @property
    def without(self) -> Array:
        """The same without the packing, of undamped plates: (n_runs,), m; NaN where it is not known."""
        force = np.array([run.value("unprotected_ground_peak_force_N") for run in self.runs])
        return force / [math.nan if plate.damping else plate.stiffness for plate in self.plates]


def select(runs: Sequence[FinishedRun]) -> list[list[Spectrum]]:
    """All plates of at least four stiffnesses beside the same packing on a wall of their material, for each impact."""
    return [found for group in impacts(runs) if (found := spectra(group))]


def spectra(runs: Sequence[TargetRun]) -> list[Spectrum]:
    """Group the runs by height, friction and mass of the plate."""
    groups: dict[tuple, list[tuple[float, TargetRun]]] = {}
    for run in runs:
        plate = run.plate
        if plate and run.displacement.argmax() < _TURNED * len(run.displacement):
            kind = (run.layers, run.friction, plate.mass, plate.damping)
            groups.setdefault(kind, []).append((period_of(plate), run))
    found = []
    for (layers, friction, *_), group in sorted(groups.items()):
        by_period = [run for _, run in sorted(group, key=lambda one: one[0])]
        surface = group[0][1].case.boundary.bottom_material
        alike = [run for run in runs if run.held and (run.layers, run.friction) == (layers, friction)]
        held = [run for run in alike if run.case.boundary.bottom_material == surface]
        if held and len(group) >= _FEWEST:
            found.append(Spectrum(by_period, held[0]))
    return found


def title(found: Sequence[Spectrum]) -> str:
    """Title with packing and impact."""
    one_height = len({one.held.layers for one in found}) == 1
    return f"Protected target, shock spectrum: {impact_title(found[0].held.case, height=one_height)}"


def rows(found: Sequence[Spectrum]) -> Iterator[Row]:
    """The displacement of each plate."""
    for one in found:
        for run, plate, moved in zip(one.runs, one.plates, one.displacement, strict=True):
            expected, theory = expected_displacement(one.held.reached, plate, run.reached.time[-1])
            remark = "The plate gives way, and less force reaches it." if moved < _GIVES_WAY * expected else ""
            what = f"Largest displacement of the plate, {plate.mass:g} kg, {time_label(period_of(plate))}"
            yield Row(what, "µm", None, _MICRO * moved, theory, remark, _MICRO * expected)


def verdict(found: Sequence[Spectrum]) -> Iterator[str]:
    """Say which plates the packing helps."""
    for one in found:
        ratio = one.without / one.displacement
        if np.isfinite(ratio).all():
            ends = (int(ratio.argmax()), int(ratio.argmin()))
            most, least = (f"{number(ratio[n])} times at a period of {time_label(one.period[n])}" for n in ends)
            yield (
                f"{one.held.layers} layers make the largest displacement of a plate of {one.plates[0].mass:g} kg "
                f"smaller by {most} and {least} (below 1: larger). A slow plate feels the impulse, which a packing "
                "adds to."
            )


def pictures(found: Sequence[Spectrum]) -> Iterator[Picture]:
    """Displacement against period, with the theory."""
    figure, axes = panels(4.4, width=4.6)
    label(axes, "Period of the plate (µs)", "Largest displacement (µm)", log="xy")
    columns: dict[str, Array] = {}
    for one, colour, marker in zip(found, (BLUE, ORANGE, GREY), "os^", strict=False):
        friction = f", friction {one.held.friction:g}" if one.held.case.has_friction else ""
        name = f"{one.plates[0].mass:g} kg, {one.held.layers} layers{friction}"
        points: dict[str, Any] = {"color": colour, "markersize": 4}
        axes.plot(_MICRO * one.period, _MICRO * one.displacement, marker, label=f"below the packing: {name}", **points)
        axes.plot(
            _MICRO * one.period, _MICRO * one.without, marker, markerfacecolor="none", label="without it", **points
        )
        period = np.geomspace(one.period.min(), one.period.max(), _CURVE)
        theory = spectrum_curves(one.held.reached, one.plates[0], period)
        for values, line, called in (
            (theory.oscillator, "-", "oscillator"),
            (theory.slow_force, ":", "slow force, F/k"),
            (theory.short_impulse, "--", "short impulse, J/(Mω)"),
        ):
            axes.plot(_MICRO * period, _MICRO * values, line, label=called, color=colour, linewidth=0.9)
        word = column_name(name)
        columns |= {
            f"{word}_period_s": one.period, f"{word}_displacement_m": one.displacement,
            f"{word}_without_m": one.without, f"{word}_line_period_s": period,
            f"{word}_oscillator_m": theory.oscillator, f"{word}_slow_force_m": theory.slow_force,
            f"{word}_short_impulse_m": theory.short_impulse,
        }  # fmt: skip
    axes.set_ylim(0.3 * _MICRO * min(one.displacement.min() for one in found))
    legend_outside(figure, 2, fontsize=7)
    caption = (
        "Largest displacement of the plate against its period, with the packing and without, and of an oscillator "
        "under the force on a plate held in place. The packing helps where full marks lie below open ones"
    )
    yield Picture("", caption, Drawing(figure, columns))
