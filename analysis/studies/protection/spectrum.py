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
from numpy.typing import NDArray

from granwave.analysis.figures.style import BLUE, GREY, ORANGE, Drawing, new_figure
from granwave.analysis.formatting.numbers import number
from granwave.analysis.measures.signals import width
from granwave.analysis.measures.target import period_of
from granwave.analysis.studies.protection.runs import TargetRun, slug
from granwave.analysis.studies.protection.theory import after_impulse, response
from granwave.analysis.studies.study import Picture, Row, Study
from granwave.analysis.studies.titles import impact_words, time_words
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.case.supports import Plate

Array = NDArray[np.float64]

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
    runs
        By rising period.
    held
        The same packing on a wall of the plates' material.
    """

    runs: tuple[TargetRun, ...]
    held: TargetRun

    @property
    def plates(self) -> list[Plate]:
        """Of the runs."""
        return [run.plate for run in self.runs if run.plate]

    @property
    def period(self) -> Array:
        """Of the plates: (n_runs,), s."""
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
    def width(self) -> float:
        """Of the peak of the force on the wall at half its height, s."""
        return width(self.held.reached.time, self.held.reached.force)

    @property
    def lasts(self) -> float:
        """How long most of the impulse on the wall takes, s."""
        time, impulse = self.held.reached.time, self.held.reached.impulse
        part = np.array([1 - _MOST_OF_IT, 1 + _MOST_OF_IT]) / 2 * impulse[-1]
        return float(np.diff(np.interp(part, impulse, time))[0])

    def expected(self, plate: Plate, end: float) -> float:
        """Largest displacement of a plate under the force on the wall, up to a time (s): m."""
        time, force = self.held.reached.time, self.held.reached.force
        if end > time[-1]:
            step = time[1] - time[0]
            time = np.append(time, np.arange(time[-1] + step, end, step))
            force = np.append(force, np.zeros(len(time) - len(force)))
        return float(response(time, force, plate.mass, plate.stiffness, plate.damping).max())


def spectrum(runs: Sequence[TargetRun], suffix: str) -> Iterator[Study]:
    """One study of all plates of at least four stiffnesses, beside the same packing on a wall of their material."""
    found = spectra(runs)
    if not found:
        return
    one_height = len({one.held.layers for one in found}) == 1
    caption = "Largest displacement of the plate against its period, with what an oscillator does under the same force"
    yield Study(
        f"protected-spectrum{suffix}",
        f"Protected target, shock spectrum: {impact_words(found[0].held.case, height=one_height)}",
        "How far a plate on a spring moves below the packing, and without it. The line is an oscillator under the "
        "force that the same packing gives a wall of the plate's material, held in place; its limits are those of a "
        "short impulse, J/(M omega), and of a slow force, F/k. A light plate gives way: less force reaches it, and the "
        "points lie below the line.",
        tuple(row for one in found for row in _rows(one)),
        (Picture(f"protected_spectrum{suffix.replace('-', '_')}", caption, _draw(found)),),
        verdict=tuple(filter(None, map(_verdict, found))),
    )


def spectra(runs: Sequence[TargetRun]) -> list[Spectrum]:
    """By height, friction and mass of the plate."""
    groups: dict[tuple, list[TargetRun]] = {}
    for run in runs:
        if run.plate and run.displacement.argmax() < _TURNED * len(run.displacement):
            groups.setdefault((run.layers, run.friction, run.plate.mass, run.plate.damping), []).append(run)
    found = []
    for (layers, friction, *_), group in sorted(groups.items()):
        alike = [run for run in runs if (run.layers, run.friction) == (layers, friction)]
        held = [run for run in alike if run.held and _surface(run) == _surface(group[0])]
        if held and len(group) >= _FEWEST:
            found.append(Spectrum(tuple(sorted(group, key=_by_period)), held[0]))
    return found


def _surface(run: TargetRun) -> Material | None:
    return run.case.boundary.bottom_material


def _by_period(run: TargetRun) -> float:
    return period_of(run.plate) if run.plate else 0.0


def _verdict(one: Spectrum) -> str:
    """Which plates the packing helps."""
    ratio = one.without / one.displacement
    if not np.isfinite(ratio).all():
        return ""
    ends = (int(ratio.argmax()), int(ratio.argmin()))
    most, least = (f"{number(ratio[n])} times at a period of {time_words(one.period[n])}" for n in ends)
    return (
        f"{one.held.layers} layers make the largest displacement of a plate of {one.plates[0].mass:g} kg smaller by "
        f"{most} and {least} (below 1: larger). A slow plate feels the impulse, which a packing adds to."
    )


def _rows(one: Spectrum) -> Iterator[Row]:
    force, impulse = one.held.reached.peak_force, float(one.held.reached.impulse[-1])
    for run, plate, period, moved in zip(one.runs, one.plates, one.period, one.displacement, strict=True):
        expected = one.expected(plate, max(run.reached.time[-1], one.held.reached.time[-1]))
        theory = "oscillator"
        if period < _FAST * one.width:
            expected, theory = force / plate.stiffness, "slow force, F/k"
        elif period > _SLOW * one.lasts and not plate.damping:
            expected = after_impulse(impulse, plate.mass, plate.stiffness)
            theory = "short impulse, J/(M omega)"
        remark = "The plate gives way, and less force reaches it." if moved < _GIVES_WAY * expected else ""
        what = f"Largest displacement of the plate, {plate.mass:g} kg, {time_words(period)}"
        yield Row(what, "µm", None, _MICRO * moved, theory, remark, _MICRO * expected)


def _draw(found: Sequence[Spectrum]) -> Drawing:
    figure = new_figure(4.4, 4.6)
    axes = figure.subplots()
    columns: dict[str, Array] = {}
    for one, colour, marker in zip(found, (BLUE, ORANGE, GREY), "os^", strict=False):
        plate, period = one.plates[0], one.period
        friction = f", friction {one.held.friction:g}" if one.held.case.rubs else ""
        word = f"{plate.mass:g} kg, {one.held.layers} layers{friction}"
        line = np.geomspace(period.min(), period.max(), _CURVE)
        springs = plate.mass * (2 * math.pi / line) ** 2
        last = one.held.reached.time[-1]
        theory = np.array(
            [
                one.expected(Plate(mass=plate.mass, stiffness=spring, damping=plate.damping), last + time)
                for spring, time in zip(springs, line, strict=True)
            ]
        )
        slow = one.held.reached.peak_force / springs
        short = after_impulse(float(one.held.reached.impulse[-1]), plate.mass, 1.0) / np.sqrt(springs)
        curves = {"oscillator": (theory, "-"), "slow force, F/k": (slow, ":"), "short impulse, J/(Mω)": (short, "--")}
        points = {f"below the packing: {word}": (one.displacement, colour), "without it": (one.without, "none")}
        for label, (values, face) in points.items():
            axes.loglog(_MICRO * period, _MICRO * values, marker, color=colour, markerfacecolor=face, markersize=4,
                        label=label)  # fmt: skip
        for label, (values, dashes) in curves.items():
            axes.loglog(_MICRO * line, _MICRO * values, dashes, color=colour, linewidth=0.9, label=label)
        name = slug(word)
        columns |= {
            f"{name}_period_s": period, f"{name}_displacement_m": one.displacement, f"{name}_without_m": one.without,
            f"{name}_line_period_s": line, f"{name}_oscillator_m": theory, f"{name}_slow_force_m": slow,
            f"{name}_short_impulse_m": short,
        }  # fmt: skip
    axes.set_ylim(0.3 * _MICRO * min(one.displacement.min() for one in found))
    axes.set_xlabel("Period of the plate (µs)")
    axes.set_ylabel("Largest displacement (µm)")
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=2, fontsize=7)
    return Drawing(figure, columns)
