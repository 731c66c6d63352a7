"""Elastic chains of like beads: one solitary wave, and a load that lasts (thesis 4.1.2 and 4.1.3).

Nesterenko's solitary wave, with D the diameter of a bead:

    bead velocity   v = v_max cos^4(2 x / (sqrt(10) D)), |x| up to pi sqrt(10)/4 D
    speed           V = 0.6802 (2 E / (D rho^1.5 (1 - nu^2)))^(1/3) F^(1/6)

A bead of velocity v0 makes a wave of the peak force (4.5) 0.719 (m^3 E*^2 R* v0^6)^(1/5). A force A that lasts makes
a plateau of force A whose speed is, by momentum and the virial 4 K = 5 P, c_l = D sqrt(A/(m alpha_A)) (4.16), at most
c_u = sqrt(10/9) c_l (4.12); the bead velocity is then D A/(m c) (4.9).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.ticker import LogLocator, NullLocator
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from granwave.analysis.figures.style import BLUE, GREY, ORANGE, Drawing, new_figure
from granwave.analysis.measures.signals import Power, arrival, first_peak, power, width
from granwave.analysis.studies.chains.runs import ChainRun, by, uniform
from granwave.analysis.studies.chains.scales import ChainScales, discrete_speed, from_thesis, passed, undisturbed
from granwave.analysis.studies.study import Picture, Row, Study

Array = NDArray[np.float64]

IMPULSE_COEFFICIENT = 0.719  # (4.5)
DISCRETE_COEFFICIENT = 0.7176  # of the same, of the discrete chain, by an independent solver (tests/chain_twin.py)
DISCRETE_WIDTH = 1.579  # full width at half maximum of its bead velocity, diameters
_HALF_OF_COS4 = 2 * math.acos(0.5**0.25) * math.sqrt(10) / 2  # full width at half maximum, diameters
_FOOT_OF_COS4 = math.pi * math.sqrt(10) / 2
_FOOT = 1e-3  # of the largest velocity: the discrete wave has no foot
_FEWEST_CONTACTS = 50
_FEWEST_OF_PLATEAU = 200
_SPLITTING = 10  # points put between two samples
_WHERE = "thesis 4.1.2"
_LONG = "thesis 4.1.3"


def solitary(runs: Sequence[ChainRun]) -> Iterator[Study]:
    """Chains whose first bead is struck: force, speed and profile of the wave."""
    found = [run for run in uniform(runs, "hertz") if run.load.kind == "impact" and run.load.spheres == 1]
    waves = [_Wave(run) for run in by(found, lambda run: run.load.velocity / ChainScales(run).velocity)
             if undisturbed(run) and passed(run) >= _FEWEST_CONTACTS]  # fmt: skip
    if not waves:
        return
    v0, force, speed = (np.array([getattr(wave, name) for wave in waves]) for name in ("v0", "force", "speed"))
    rows = list(_rows_of_waves(waves))
    fits: tuple[Power, ...] = ()
    if len(waves) > 1 and v0[-1] > 1.5 * v0[0]:
        fits = power(v0, force), power(force, speed)
        rows[:0] = [
            Row("Power of the peak force with the velocity of the first bead", "", 1.2, fits[0].exponent, _WHERE,
                _interval(fits[0])),
            Row("Power of the wave's speed with its peak force", "", 1 / 6, fits[1].exponent, _WHERE,
                _interval(fits[1])),
        ]  # fmt: skip
    first, last = waves[0].window
    text = (
        f"The first of {len(waves[0].run.force.T) + 1} elastic beads is given a velocity, in {len(waves)} runs. Peak "
        f"force at contact {last}; speed from the peaks of contacts {first} to {last}; profile of a bead half-way "
        "between them, its time turned into place by the speed."
    )
    picture = Picture("elastic_solitary_wave", "Solitary wave: peak force, speed and profile against Nesterenko's wave",
                      _draw_waves(waves, v0, force, speed, fits))  # fmt: skip
    yield Study("solitary-wave", "Solitary wave of an impulse", text, tuple(rows), (picture,))


class _Wave:
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
        self.v0, self.force, self.speed = (
            run.load.velocity / scales.velocity,
            peak / scales.force,
            speed / scales.velocity,
        )
        self.coefficient = peak / scales.impulse_force(run.mass * run.load.velocity)
        self.nesterenko = speed / scales.nesterenko(peak)
        bead = sum(self.window) // 2
        time = np.linspace(run.time[0], run.time[-1], _SPLITTING * len(run.time))
        velocity = CubicSpline(run.time, run.velocity[:, bead])(time)
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


def _rows_of_waves(waves: Sequence[_Wave]) -> Iterator[Row]:
    coefficients = np.array([wave.coefficient for wave in waves])
    spread = _spread(coefficients)
    yield Row("Peak force over (m^3 E*^2 R* v^6)^(1/5)", "", IMPULSE_COEFFICIENT, float(coefficients.mean()),
              _WHERE, f"{spread}Theory: the discrete chain, by an independent solver.",
              DISCRETE_COEFFICIENT)  # fmt: skip
    speeds = np.array([wave.nesterenko for wave in waves])
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


def _draw_waves(waves: Sequence[_Wave], v0: Array, force: Array, speed: Array, fits: tuple[Power, ...]) -> Drawing:
    figure = new_figure(2.5, 7.0)
    left, middle, right = figure.subplots(1, 3)
    law = IMPULSE_COEFFICIENT * force / [wave.coefficient for wave in waves]
    for axes, x, y, line, name in (
        (left, v0, force, law, f"{IMPULSE_COEFFICIENT} (thesis 4.5)"),
        (middle, force, speed, speed / [wave.nesterenko for wave in waves], "Nesterenko"),
    ):
        axes.loglog(x, line, "-", color=GREY, label=name)
        axes.loglog(x, y, "o", color=BLUE, markersize=4, label="simulation")
        axes.legend(loc="upper left")
    for axes, fit in zip((left, middle), fits, strict=False):
        axes.text(0.95, 0.07, f"power {fit.exponent:.4f}", ha="right", transform=axes.transAxes)
    left.set_xlabel(r"Velocity of the first bead $v_0 \tau/R^*$")
    left.set_ylabel(r"Peak force $F/(E^* R^{*2})$")
    middle.set_xlabel(r"Peak force $F/(E^* R^{*2})$")
    middle.yaxis.set_major_locator(LogLocator(subs=(1, 1.5, 2, 3, 4, 6)))
    middle.yaxis.set_major_formatter("{x:g}")
    middle.yaxis.set_minor_locator(NullLocator())
    middle.set_ylabel(r"Speed $V \tau/R^*$")
    place = np.linspace(-3.5, 3.5, 281)
    inside = np.abs(place) < 0.5 * _FOOT_OF_COS4
    cosine = np.where(inside, np.cos(2 * place / math.sqrt(10)) ** 4, 0.0)
    right.plot(place, cosine, color=GREY, label=r"$\cos^4$")
    shown = np.stack([np.interp(place, wave.x, wave.velocity) for wave in waves])
    right.plot(place, shown.T, color=BLUE, linewidth=0.8)
    right.plot([], [], color=BLUE, label="simulation")
    right.set_xlabel("Time as place, diameters")
    right.set_ylabel("Bead velocity over its largest")
    right.set_ylim(0, 1.4)
    right.legend(loc="upper right")
    columns = {"velocity_normalised": v0, "peak_force_normalised": force, "speed_normalised": speed,
               "place_diameters": place, "cos4": cosine}  # fmt: skip
    profiles = {f"profile_{n}": profile for n, profile in enumerate(shown, start=1)}
    return Drawing(figure, columns | profiles)


def long_load(runs: Sequence[ChainRun]) -> Iterator[Study]:
    """Chains under a steady force that lasts to the end of the run: plateau and leading wave."""
    found = [
        run for run in uniform(runs, "hertz")
        if run.load.kind == "force" and run.load.shape == "rectangle" and run.load.lasts >= 0.999 * run.time[-1]
        and undisturbed(run) and passed(run) >= _FEWEST_OF_PLATEAU
    ]  # fmt: skip
    for n, run in enumerate(found, start=1):
        name = "elastic-long-load" + (f"-{n}" if len(found) > 1 else "")
        title = f"Long loading of an elastic chain, {run.load.largest:g} N"
        text = (
            f"A steady force of {run.load.largest:g} N on the first of {run.velocity.shape[1]} elastic beads for "
            f"{1e3 * run.time[-1]:.4g} ms; the front is then at contact {passed(run)}. Peak force there; speed of "
            "the front at half the force, over the last nine tenths of its way; plateau: the first quarter of it."
        )
        caption = "Force and bead velocity along the chain under a steady force (thesis Fig. 4.2)"
        picture = Picture(name.replace("-", "_"), caption, _draw_long(run))
        yield Study(name, title, text, tuple(_rows_of_plateau(run)), (picture,))


def _bounds(run: ChainRun) -> tuple[float, float]:
    """Speeds (4.16) and (4.12), m/s."""
    scales, force = ChainScales(run), run.load.largest
    lower = scales.diameter * math.sqrt(force / (run.mass * float(scales.overlap(np.array(force)))))
    return lower, math.sqrt(10 / 9) * lower


def _front(run: ChainRun) -> tuple[float, float]:
    """Speed of the front, m/s, and the contact that it has reached at the end."""
    last, level = passed(run), 0.5 * run.load.largest
    numbers = np.arange(last // 10, last + 1)
    times = [arrival(run.time, run.force[:, n - 1], level) for n in numbers]
    per_contact = float(np.polyfit(numbers, times, 1)[0])
    return run.case.packing.diameter / per_contact, last + (float(run.time[-1]) - times[-1]) / per_contact


def _rows_of_plateau(run: ChainRun) -> Iterator[Row]:
    scales, amplitude = ChainScales(run), run.load.largest
    thesis = from_thesis(run) and math.isclose(amplitude, 40.0, rel_tol=1e-3)

    def source(value: float) -> float | None:
        return value if thesis else None

    last = passed(run)
    peak, (lower, upper), (speed, front) = float(run.of_contacts("peak_force")[last - 1]), _bounds(run), _front(run)
    plateau = slice(last // 50, last // 4)
    late = slice(-len(run.time) // 10, None)
    yield Row("Peak force", "N", source(92.7), peak, _LONG, f"At contact {last}; it still rises slowly.",
              None if thesis else 92.7 / 40 * amplitude)  # fmt: skip
    of_bound = "By its formula alone: the force whose speed by Nesterenko is the bound."
    yield Row("Lower bound of the peak force", "N", source(78.15), scales.force_at_speed(lower), _LONG, of_bound)
    yield Row("Upper bound of the peak force", "N", source(107.2), scales.force_at_speed(upper), _LONG, of_bound)
    printed = "The printed speed is 10^(1/6) too large. " if thesis else ""
    ten = 10 ** (1 / 6)
    yield Row("Lower bound of the speed (4.16)", "m/s", source(668.0), lower, _LONG, printed,
              668.0 / ten if thesis else None)  # fmt: skip
    yield Row("Upper bound of the speed (4.12)", "m/s", source(704.0), upper, _LONG, printed,
              704.0 / ten if thesis else None)  # fmt: skip
    yield Row("Speed of the front", "m/s", source(687.2), speed, _LONG,
              f"{printed}Theory: Nesterenko's of our peak force; the discrete wave is 1.2 % faster.",
              scales.nesterenko(peak))  # fmt: skip
    yield Row("Force of the plateau", "N", source(40.0), float(run.force[late, plateau].mean()), _LONG,
              expected=amplitude)  # fmt: skip
    of_plateau = float(run.velocity[late, plateau].mean())
    low, high = (scales.diameter * amplitude / (run.mass * c) for c in (upper, lower))
    yield Row("Bead velocity of the plateau", "m/s", None, of_plateau, "thesis (4.9)",
              f"Theory: (4.9) with the lower bound of the speed, for which the virial holds; with the upper one "
              f"{low:.4g} m/s.", high)  # fmt: skip
    mean = float(run.velocity[-1].sum()) / front
    yield Row("Mean velocity of all beads behind the front", "m/s", None, mean, "thesis (4.9)",
              "Theory: (4.9) with the speed of the front, which is the balance of momentum.",
              scales.diameter * amplitude / (run.mass * speed))  # fmt: skip
    time = run.array("energy/time")
    half = time > 0.5 * time[-1]
    virial = 0.8 * run.array("energy/kinetic")[half].mean() / run.array("energy/elastic")[half].mean()
    yield Row("Virial 4 K / 5 P of the chain", "", 1.0, float(virial), "thesis (4.14)",
              "Average of the second half of the run.")  # fmt: skip


def _draw_long(run: ChainRun) -> Drawing:
    """Thesis Fig. 4.2."""
    lower, upper = (ChainScales(run).force_at_speed(speed) for speed in _bounds(run))
    force, velocity, largest = run.force[-1], run.velocity[-1], run.of_contacts("peak_force")
    contact, bead = np.arange(1, len(force) + 1), np.arange(1, len(velocity) + 1)
    figure = new_figure(4.2)
    top, bottom = figure.subplots(2, 1, sharex=True)
    top.plot(contact, force, color=BLUE, linewidth=0.7, label=f"at {1e3 * run.time[-1]:.3g} ms")
    top.plot(contact[: passed(run)], largest[: passed(run)], color=ORANGE, label="largest so far")
    for bound, style in ((lower, "--"), (upper, ":")):
        top.axhline(bound, color=GREY, linestyle=style, linewidth=0.8)
    top.plot([], [], "--", color=GREY, linewidth=0.8, label="lower bound")
    top.plot([], [], ":", color=GREY, linewidth=0.8, label="upper bound")
    top.set_ylabel("Contact force (N)")
    top.set_ylim(0, 1.65 * upper)
    top.legend(ncols=2, loc="upper left")
    bottom.plot(bead, velocity, color=BLUE, linewidth=0.7)
    bottom.set_xlabel("Contact, bead")
    bottom.set_ylabel("Bead velocity (m/s)")
    bottom.set_ylim(bottom=0)
    bottom.set_xlim(0, len(bead))
    columns = {"contact": contact, "force_N": force, "largest_force_N": largest, "bead": bead, "velocity_m_s": velocity}
    return Drawing(figure, columns)


def _spread(values: Array) -> str:
    if len(values) < 2:
        return ""
    return f"Spread of {len(values)} runs {100 * (values.max() / values.min() - 1):.1g} %. "


def _interval(fit: Power) -> str:
    return f"95 % confidence interval: ± {fit.margin:.1g}." if math.isfinite(fit.margin) else ""
