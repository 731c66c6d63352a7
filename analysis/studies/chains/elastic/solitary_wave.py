"""Elastic chains of like beads whose first bead is struck: one solitary wave (thesis 4.1.2)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import BLUE, GREY, Drawing
from granwave.analysis.measures.chains.groups import columns
from granwave.analysis.measures.chains.hertz_chain import (
    DISCRETE_COEFFICIENT,
    IMPULSE_COEFFICIENT,
    discrete_speed,
)
from granwave.analysis.measures.chains.solitary_wave import (
    DISCRETE_WIDTH,
    HALF_OF_COS4,
    SolitaryWave,
    cos4,
)
from granwave.analysis.measures.signals import Array, Power, power, width
from granwave.analysis.measures.waves.pulses import LENGTH
from granwave.analysis.studies.chains.runs import uniform
from granwave.analysis.studies.runs import FinishedRun, rising
from granwave.analysis.studies.study import Picture, Row

TITLE = "Solitary wave of an impulse"
_FOOT = 1e-3  # of the largest velocity: the discrete wave has no foot
_FEWEST_CONTACTS = 50
_WHERE = "thesis 4.1.2"
_SIMILAR = "The elastic chain has no scale of its own: similarity forces one value on any correct code."


def select(runs: Sequence[FinishedRun]) -> list[list[SolitaryWave]]:
    """Waves of chains whose first bead is struck, by its velocity."""
    struck = [run for run in uniform(runs, "hertz") if run.load.kind == "impact" and run.load.spheres == 1]
    ordered = rising(struck, lambda run: run.load.velocity / run.scales.velocity)
    waves = [SolitaryWave(run) for run in ordered if run.undisturbed and run.passed >= _FEWEST_CONTACTS]
    return [waves] if waves else []


def text(waves: Sequence[SolitaryWave]) -> str:
    """Describe the runs."""
    first, last = waves[0].window
    return (
        f"The first of {len(waves[0].run.force.T) + 1} elastic beads is given a velocity, in {len(waves)} runs. Peak "
        f"force at contact {last}; speed from the peaks of contacts {first} to {last}; profile of a bead half-way "
        "between them, its time turned into place by the speed."
    )


def rows(waves: Sequence[SolitaryWave]) -> Iterator[Row]:
    """Powers, coefficient, speed and width beside Nesterenko's wave and that of the discrete chain."""
    for name, theory, fit in zip(("peak force with the velocity of the first bead", "wave's speed with its peak force"),
                                 (1.2, 1 / 6), _powers(waves), strict=False):  # fmt: skip
        yield Row(f"Power of the {name}", "", None, fit.exponent, _WHERE, f"{fit.interval} {_SIMILAR}", theory, True)
    coefficients, speeds = columns(waves, "coefficient", "nesterenko")
    of_discrete = "Theory: the discrete chain, by our second solver."
    what = "Peak force over (m^3 E*^2 R* v^6)^(1/5)"
    yield Row(what, "", IMPULSE_COEFFICIENT, None, "thesis (4.5)", of_discrete, DISCRETE_COEFFICIENT)
    yield Row(f"{what}, of the runs", "", None, float(coefficients.mean()), "our second solver",
              f"{_spread(coefficients)}{_SIMILAR}", DISCRETE_COEFFICIENT, True)  # fmt: skip
    what = "Speed over Nesterenko's at the same peak force"
    yield Row(
        what, "", 1.0, None, "composite (4)", f"Nesterenko's is of the continuum. {of_discrete}", discrete_speed()
    )
    yield Row(f"{what}, of the runs", "", None, float(speeds.mean()), "our second solver",
              f"{_spread(speeds)}{_SIMILAR}", discrete_speed(), True)  # fmt: skip
    wave = waves[len(waves) // 2]
    found, what = width(wave.x, wave.velocity), "Full width at half maximum of the bead velocity, diameters"
    yield Row(what, "", None, found, "Nesterenko's cos^4", "The discrete wave is narrower than that of the continuum.",
              HALF_OF_COS4)  # fmt: skip
    yield Row(f"{what}, discrete chain", "", None, found, "our second solver", _SIMILAR, DISCRETE_WIDTH, True)
    yield Row(f"Width of the wave at {_FOOT:g} of its largest velocity, diameters", "", 5.0,
              width(wave.x, wave.velocity, _FOOT), "thesis 4.1",
              f"cos^4 ends after {LENGTH:.2f} diameters; the discrete wave ends nowhere, and its width "
              "depends on the level.", LENGTH)  # fmt: skip
    yield Row("Virial 4 K / 5 P of the wave", "", None, wave.virial, "thesis (4.14)",
              "Average of the second half of the run, without the beads that bounced back.", 1.0)  # fmt: skip


def pictures(waves: Sequence[SolitaryWave]) -> Iterator[Picture]:
    """Peak force against velocity, speed against peak force, and profiles."""
    v0, force, speed, coefficient, nesterenko = columns(waves, "v0", "force", "speed", "coefficient", "nesterenko")
    figure, left, middle, right = panels(2.5, 3)
    for axes, x, y, line, name in (
        (left, v0, force, IMPULSE_COEFFICIENT * force / coefficient, f"{IMPULSE_COEFFICIENT} (thesis 4.5)"),
        (middle, force, speed, speed / nesterenko, "Nesterenko"),
    ):
        axes.plot(x, line, color=GREY, label=name)
        axes.plot(x, y, "o", color=BLUE, markersize=4, label="simulation")
        axes.legend(loc="upper left")
    for axes, fit in zip((left, middle), _powers(waves), strict=False):
        axes.text(0.95, 0.07, f"power {fit.exponent:.4f}", ha="right", transform=axes.transAxes)
    label(left, r"Velocity of the first bead $v_0 \tau/R^*$", r"Peak force $F/(E^* R^{*2})$", log="xy")
    label(middle, r"Peak force $F/(E^* R^{*2})$", r"Speed $V \tau/R^*$", log="xy")
    place = np.linspace(-3.5, 3.5, 281)
    profiles = [np.interp(place, wave.x, wave.velocity) for wave in waves]
    right.plot(place, cos4(place), color=GREY, label=r"$\cos^4$")
    for n, profile in enumerate(profiles):
        right.plot(place, profile, color=BLUE, linewidth=0.8, label="simulation" if n == 0 else None)
    label(right, "Time as place, diameters", "Bead velocity over its largest", ylim=(0, 1.4))
    right.legend(loc="upper right")
    data = {"velocity_normalised": v0, "peak_force_normalised": force, "speed_normalised": speed,
            "place_diameters": place, "cos4": cos4(place)}  # fmt: skip
    data |= {f"profile_{n}": profile for n, profile in enumerate(profiles, start=1)}
    caption = "Solitary wave: peak force, speed and profile against Nesterenko's wave"
    yield Picture("elastic_solitary_wave", caption, Drawing(figure, data))


def _powers(waves: Sequence[SolitaryWave]) -> tuple[Power, ...]:
    """Exponents of the force with the velocity, and of the speed with the force; none from one velocity."""
    v0, force, speed = columns(waves, "v0", "force", "speed")
    return (power(v0, force), power(force, speed)) if v0[-1] > 1.5 * v0[0] else ()


def _spread(values: Array) -> str:
    many = len(values) > 1
    return f"Spread of {len(values)} runs {100 * (values.max() / values.min() - 1):.1g} %. " if many else ""
