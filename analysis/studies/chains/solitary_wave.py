"""Elastic chains of like beads whose first bead is struck: one solitary wave (thesis 4.1.2).

Nesterenko's solitary wave, with D the diameter of a bead:

    bead velocity   v = v_max cos^4(2 x / (sqrt(10) D)), |x| up to pi sqrt(10)/4 D
    speed           V = 0.6802 (2 E / (D rho^1.5 (1 - nu^2)))^(1/3) F^(1/6)

A bead of velocity v0 makes a wave of the peak force (4.5) 0.719 (m^3 E*^2 R* v0^6)^(1/5).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from scipy.interpolate import CubicSpline

from granwave.analysis.figures.curves import DOUBLE, few_ticks, label, panels
from granwave.analysis.figures.style import BLUE, GREY, Drawing
from granwave.analysis.measures.hertz_chain import (
    DISCRETE_COEFFICIENT,
    IMPULSE_COEFFICIENT,
    ChainScales,
    discrete_speed,
)
from granwave.analysis.measures.signals import Array, Power, first_peak, power, width
from granwave.analysis.studies.chains.runs import ChainRun, chain_runs, columns, uniform
from granwave.analysis.studies.chains.scales import passed, undisturbed
from granwave.analysis.studies.runs import FinishedRun, rising
from granwave.analysis.studies.study import Picture, Row

TITLE = "Solitary wave of an impulse"
DISCRETE_WIDTH = 1.579  # full width at half maximum of the discrete chain's bead velocity, diameters
_HALF_OF_COS4 = 2 * math.acos(0.5**0.25) * math.sqrt(10) / 2  # full width at half maximum, diameters
_FOOT_OF_COS4 = math.pi * math.sqrt(10) / 2
_FOOT = 1e-3  # of the largest velocity: the discrete wave has no foot
_FEWEST_CONTACTS = 50
_SPLITTING = 10  # points put between two samples
_WHERE = "thesis 4.1.2"


class Wave:
    """The wave of a struck bead, measured far down the chain.

    Attributes
    ----------
    v0, force, speed
        Velocity of the first bead, peak force and speed over their units in this chain.
    coefficient
        Of (4.5).
    nesterenko
        Speed over Nesterenko's.
    x, velocity
        Profile of a bead, finely: place behind the crest in diameters, velocity over the largest.
    """

    def __init__(self, run: ChainRun) -> None:
        self.run, scales = run, ChainScales(run)
        last = passed(run)
        self.window = last // 2, last
        peak = float(run.of_contacts("peak_force")[last - 1])
        crest = [first_peak(run.time, run.force[:, n - 1])[0] for n in range(self.window[0], last + 1)]
        speed = scales.diameter / float(np.polyfit(np.arange(len(crest)), crest, 1)[0])
        self.v0, self.speed = run.load.velocity / scales.velocity, speed / scales.velocity
        self.force = peak / scales.force
        self.coefficient = peak / scales.impulse_force(run.mass * run.load.velocity)
        self.nesterenko = speed / scales.nesterenko(peak)
        time = np.linspace(run.time[0], run.time[-1], _SPLITTING * len(run.time))
        velocity = CubicSpline(run.time, run.velocity[:, sum(self.window) // 2])(time)
        self.x = (time - time[velocity.argmax()]) * speed / scales.diameter
        self.velocity = velocity / velocity.max()

    @property
    def virial(self) -> float:
        """4 K / 5 P on the average of the second half of the run; beads that bounced back are left out."""
        run = self.run
        half = slice(len(run.time) // 2, None)
        kinetic = 0.5 * run.mass * (np.maximum(run.velocity[half], 0) ** 2).sum(axis=1)
        elastic = 0.4 * (run.force[half] * ChainScales(run).overlap(run.force[half])).sum(axis=1)
        return float(np.mean(4 * kinetic) / np.mean(5 * elastic))


def select(runs: Sequence[FinishedRun]) -> list[list[Wave]]:
    """Waves of chains whose first bead is struck, by its velocity."""
    struck = [run for run in uniform(chain_runs(runs), "hertz") if run.load.kind == "impact" and run.load.spheres == 1]
    ordered = rising(struck, lambda run: run.load.velocity / ChainScales(run).velocity)
    waves = [Wave(run) for run in ordered if undisturbed(run) and passed(run) >= _FEWEST_CONTACTS]
    return [waves] if waves else []


def text(waves: Sequence[Wave]) -> str:
    """Describe the runs."""
    first, last = waves[0].window
    return (
        f"The first of {len(waves[0].run.force.T) + 1} elastic beads is given a velocity, in {len(waves)} runs. Peak "
        f"force at contact {last}; speed from the peaks of contacts {first} to {last}; profile of a bead half-way "
        "between them, its time turned into place by the speed."
    )


def rows(waves: Sequence[Wave]) -> Iterator[Row]:
    """Powers, coefficient, speed and width beside Nesterenko's wave and that of the discrete chain."""
    for name, source, fit in zip(("peak force with the velocity of the first bead", "wave's speed with its peak force"),
                                 (1.2, 1 / 6), _powers(waves), strict=False):  # fmt: skip
        yield Row(f"Power of the {name}", "", source, fit.exponent, _WHERE, fit.interval)
    coefficients, speeds = columns(waves, "coefficient", "nesterenko")
    yield Row("Peak force over (m^3 E*^2 R* v^6)^(1/5)", "", IMPULSE_COEFFICIENT, float(coefficients.mean()), _WHERE,
              f"{_spread(coefficients)}Theory: the discrete chain, by an independent solver.",
              DISCRETE_COEFFICIENT)  # fmt: skip
    yield Row("Speed over Nesterenko's at the same peak force", "", 1.0, float(speeds.mean()), "composite (4)",
              f"{_spread(speeds)}Nesterenko's is of the continuum; theory: the discrete chain.",
              discrete_speed())  # fmt: skip
    wave = waves[len(waves) // 2]
    yield Row("Full width at half maximum of the bead velocity, diameters", "", _HALF_OF_COS4,
              width(wave.x, wave.velocity), "Nesterenko's cos^4",
              "The discrete wave is narrower than that of the continuum.", DISCRETE_WIDTH)  # fmt: skip
    yield Row(f"Width of the wave at {_FOOT:g} of its largest velocity, diameters", "", 5.0,
              width(wave.x, wave.velocity, _FOOT), "thesis 4.1",
              f"cos^4 ends after {_FOOT_OF_COS4:.2f} diameters; the discrete wave ends nowhere, and its width "
              "depends on the level.", _FOOT_OF_COS4)  # fmt: skip
    yield Row("Virial 4 K / 5 P of the wave", "", 1.0, wave.virial, "thesis (4.14)",
              "Average of the second half of the run, without the beads that bounced back.")  # fmt: skip


def pictures(waves: Sequence[Wave]) -> Iterator[Picture]:
    """Peak force against velocity, speed against peak force, and profiles."""
    v0, force, speed, coefficient, nesterenko = columns(waves, "v0", "force", "speed", "coefficient", "nesterenko")
    figure, left, middle, right = panels(2.5, 3, width=DOUBLE)
    for axes, x, y, line, name in (
        (left, v0, force, IMPULSE_COEFFICIENT * force / coefficient, f"{IMPULSE_COEFFICIENT} (thesis 4.5)"),
        (middle, force, speed, speed / nesterenko, "Nesterenko"),
    ):
        axes.loglog(x, line, "-", color=GREY, label=name)
        axes.loglog(x, y, "o", color=BLUE, markersize=4, label="simulation")
        axes.legend(loc="upper left")
    for axes, fit in zip((left, middle), _powers(waves), strict=False):
        axes.text(0.95, 0.07, f"power {fit.exponent:.4f}", ha="right", transform=axes.transAxes)
    label(left, r"Velocity of the first bead $v_0 \tau/R^*$", r"Peak force $F/(E^* R^{*2})$")
    label(middle, r"Peak force $F/(E^* R^{*2})$", r"Speed $V \tau/R^*$")
    few_ticks(middle.yaxis, subs=(1, 1.5, 2, 3, 4, 6))
    place = np.linspace(-3.5, 3.5, 281)
    cosine = np.where(np.abs(place) < 0.5 * _FOOT_OF_COS4, np.cos(2 * place / math.sqrt(10)) ** 4, 0.0)
    right.plot(place, cosine, color=GREY, label=r"$\cos^4$")
    shown = np.stack([np.interp(place, wave.x, wave.velocity) for wave in waves])
    right.plot(place, shown.T, color=BLUE, linewidth=0.8)
    right.plot([], [], color=BLUE, label="simulation")
    label(right, "Time as place, diameters", "Bead velocity over its largest", ylim=(0, 1.4))
    right.legend(loc="upper right")
    data = {"velocity_normalised": v0, "peak_force_normalised": force, "speed_normalised": speed,
            "place_diameters": place, "cos4": cosine}  # fmt: skip
    data |= {f"profile_{n}": profile for n, profile in enumerate(shown, start=1)}
    caption = "Solitary wave: peak force, speed and profile against Nesterenko's wave"
    yield Picture("elastic_solitary_wave", caption, Drawing(figure, data))


def _powers(waves: Sequence[Wave]) -> tuple[Power, ...]:
    """Exponents of the force with the velocity, and of the speed with the force; none from one velocity."""
    v0, force, speed = columns(waves, "v0", "force", "speed")
    return (power(v0, force), power(force, speed)) if v0[-1] > 1.5 * v0[0] else ()


def _spread(values: Array) -> str:
    many = len(values) > 1
    return f"Spread of {len(values)} runs {100 * (values.max() / values.min() - 1):.1g} %. " if many else ""
