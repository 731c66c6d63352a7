"""Shock spectrum of what a packing transmits: how far a plate on a spring moves, against its period.

A plate much slower than the force only feels its impulse and moves by J/(M omega); one much faster follows it and
moves by F/k. In between the oscillator under the force on a wall that is held in place, of the plate's material, tells
what to expect of a plate that does not give way.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.figures.series import column_name, legend_outside, one_panel
from granwave.analysis.figures.style import BLUE, GREY, ORANGE, Drawing
from granwave.analysis.formatting.numbers import number
from granwave.analysis.measures.hertz_impact import Array, after_impulse, largest_displacement
from granwave.analysis.measures.signals import width
from granwave.analysis.measures.target import period_of
from granwave.analysis.studies.protection.runs import TargetRun, impacts
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row
from granwave.analysis.studies.titles import impact_title, time_label
from granwave.lammps_inputs.case.supports import Plate

TEXT = (
    "How far a plate on a spring moves below the packing, and without it. The line is an oscillator under the "
    "force that the same packing gives a wall of the plate's material, held in place; its limits are those of a "
    "short impulse, J/(M omega), and of a slow force, F/k. A light plate gives way: less force reaches it, and the "
    "points lie below the line."
)
_FEWEST = 4  # stiffnesses
_MICRO = 1e6
_CURVE = 60  # points of the theory
_FAST, _SLOW = 0.25, 10.0  # periods at which the limits hold, over the peak's width and the time the impulse takes
_MOST_OF_IT = 0.9  # of the impulse: the time that it takes is that of this part, from its middle
_GIVES_WAY = 0.95  # of the displacement by theory: below it a remark says so
_TURNED = 0.98  # of the run: a displacement that is largest later may still grow


@dataclasses.dataclass(frozen=True, eq=False)
class Spectrum:
    """Plates of one mass on springs, and the force on a wall.

    Attributes
    ----------
    runs, plates
        By rising period.
    held
        The same packing on a wall of the plates' material.
    """

    runs: list[TargetRun]
    plates: list[Plate]
    held: TargetRun

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
        springs = np.array([math.nan if plate.damping else plate.stiffness for plate in self.plates])
        return force / springs

    @property
    def lasts(self) -> float:
        """How long most of the impulse on the wall takes, s."""
        time, impulse = self.held.reached.time, self.held.reached.impulse
        part = np.array([1 - _MOST_OF_IT, 1 + _MOST_OF_IT]) / 2 * impulse[-1]
        return float(np.diff(np.interp(part, impulse, time))[0])

    def expected(self, plate: Plate, end: float) -> float:
        """Largest displacement of a plate under the force on the wall, up to a time (s): m."""
        return largest_displacement(plate, self.held.reached.time, self.held.reached.force, end)


def select(runs: Sequence[FinishedRun]) -> list[list[Spectrum]]:
    """All plates of at least four stiffnesses beside the same packing on a wall of their material, for each impact."""
    return [found for group in impacts(runs) if (found := spectra(group))]


def spectra(runs: Sequence[TargetRun]) -> list[Spectrum]:
    """By height, friction and mass of the plate."""
    groups: dict[tuple, list[tuple[float, TargetRun, Plate]]] = {}
    for run in runs:
        plate = run.plate
        if plate and run.displacement.argmax() < _TURNED * len(run.displacement):
            kind = (run.layers, run.friction, plate.mass, plate.damping)
            groups.setdefault(kind, []).append((period_of(plate), run, plate))
    found = []
    for (layers, friction, *_), group in sorted(groups.items()):
        surface = group[0][1].case.boundary.bottom_material
        alike = [run for run in runs if run.held and (run.layers, run.friction) == (layers, friction)]
        held = [run for run in alike if run.case.boundary.bottom_material == surface]
        if held and len(group) >= _FEWEST:
            _, by_period, plates = zip(*sorted(group, key=lambda one: one[0]), strict=True)
            found.append(Spectrum(list(by_period), list(plates), held[0]))
    return found


def title(found: Sequence[Spectrum]) -> str:
    """By packing and impact."""
    one_height = len({one.held.layers for one in found}) == 1
    return f"Protected target, shock spectrum: {impact_title(found[0].held.case, height=one_height)}"


def rows(found: Sequence[Spectrum]) -> Iterator[Row]:
    """The displacement of each plate."""
    for one in found:
        reached = one.held.reached
        force, impulse, peak = reached.peak_force, float(reached.impulse[-1]), width(reached.time, reached.force)
        for run, plate, period, moved in zip(one.runs, one.plates, one.period, one.displacement, strict=True):
            expected, theory = one.expected(plate, max(run.reached.time[-1], reached.time[-1])), "oscillator"
            if period < _FAST * peak:
                expected, theory = force / plate.stiffness, "slow force, F/k"
            elif period > _SLOW * one.lasts and not plate.damping:
                expected = after_impulse(impulse, plate.mass, plate.stiffness)
                theory = "short impulse, J/(M omega)"
            remark = "The plate gives way, and less force reaches it." if moved < _GIVES_WAY * expected else ""
            what = f"Largest displacement of the plate, {plate.mass:g} kg, {time_label(period)}"
            yield Row(what, "µm", None, _MICRO * moved, theory, remark, _MICRO * expected)


def verdict(found: Sequence[Spectrum]) -> Iterator[str]:
    """Which plates the packing helps."""
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
    figure, axes = one_panel(4.4, "Period of the plate (µs)", "Largest displacement (µm)", 4.6)
    columns: dict[str, Array] = {}
    for one, colour, marker in zip(found, (BLUE, ORANGE, GREY), "os^", strict=False):
        plate, period, reached = one.plates[0], one.period, one.held.reached
        friction = f", friction {one.held.friction:g}" if one.held.case.has_friction else ""
        word = f"{plate.mass:g} kg, {one.held.layers} layers{friction}"
        line = np.geomspace(period.min(), period.max(), _CURVE)
        springs = plate.mass * (2 * math.pi / line) ** 2
        plates = (dataclasses.replace(plate, stiffness=spring) for spring in springs)
        ends = reached.time[-1] + line
        theory = np.array([one.expected(other, end) for other, end in zip(plates, ends, strict=True)])
        short = after_impulse(float(reached.impulse[-1]), plate.mass, 1.0) / np.sqrt(springs)
        slow = reached.peak_force / springs
        points = {f"below the packing: {word}": (one.displacement, colour), "without it": (one.without, "none")}
        for label, (values, face) in points.items():
            axes.loglog(_MICRO * period, _MICRO * values, marker, color=colour, markerfacecolor=face, markersize=4,
                        label=label)  # fmt: skip
        curves = {"oscillator": (theory, "-"), "slow force, F/k": (slow, ":"), "short impulse, J/(Mω)": (short, "--")}
        for label, (values, dashes) in curves.items():
            axes.loglog(_MICRO * line, _MICRO * values, dashes, color=colour, linewidth=0.9, label=label)
        name = column_name(word)
        columns |= {
            f"{name}_period_s": period, f"{name}_displacement_m": one.displacement, f"{name}_without_m": one.without,
            f"{name}_line_period_s": line, f"{name}_oscillator_m": theory, f"{name}_slow_force_m": slow,
            f"{name}_short_impulse_m": short,
        }  # fmt: skip
    axes.set_ylim(0.3 * _MICRO * min(one.displacement.min() for one in found))
    legend_outside(figure, 2, fontsize=7)
    caption = "Largest displacement of the plate against its period, with what an oscillator does under the same force"
    yield Picture("", caption, Drawing(figure, columns))
