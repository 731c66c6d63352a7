"""Precompressed elastic chains that are struck: speed and height of the wave against the static force.

Every chain of like Hertz beads is one curve in the units of the static state: speeds over c0, forces over F0, and
velocities over omega alpha0, with alpha0 the static overlap and omega = c0/D.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import ScalarFormatter
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, Drawing, new_figure
from granwave.analysis.measures.signals import Power, first_peak, power
from granwave.analysis.studies.chains.runs import ChainRun, uniform
from granwave.analysis.studies.chains.scales import ChainScales
from granwave.analysis.studies.precompression import theory
from granwave.analysis.studies.precompression.theory import Array
from granwave.analysis.studies.study import Picture, Row, Study

SMALL = 0.05  # F_m/F0 - 1 up to which a pulse is small: the speed of (3) is then within 0.3 % of c0
LARGE = 100.0  # F_m/F0 from which on a chain is as good as uncompressed
_FEWEST = 30  # contacts passed
_FIRST = 10  # contact from which on small pulses are followed
_DISTURBED = 1e-3  # of the largest force added: the far end has felt the wave
_STEADY = 0.01  # by which the crest may fall while its speed is measured
_IMPULSE = 0.7176 * (9 / 16 * 1.5**3) ** 0.2  # (4.5) of the thesis, of the lattice, in units of the static state
_WHERE = "composite (3)"


def precompressed_chains(runs: Sequence[ChainRun]) -> Iterator[Study]:
    """Small pulses against the static force, waves against their height, and one impact at many static forces."""
    waves = [wave for run in uniform(runs, "hertz") if fits(run) and (wave := Wave(run)).last >= _FEWEST]
    waves.sort(key=lambda wave: wave.velocity)
    small = _one_each([wave for wave in waves if wave.ratio < 1 + SMALL], lambda wave: wave.static)
    if len(small) > 1:
        yield _small_pulses(small)
    for force in sorted({wave.static for wave in waves}):
        series = _one_each([wave for wave in waves if wave.static == force], lambda wave: wave.velocity)
        if len(series) > 2:
            yield _solitary_waves(series)
    for velocity in sorted({wave.velocity for wave in waves}):
        series = _one_each([wave for wave in waves if wave.velocity == velocity], lambda wave: wave.static)
        if len(series) > 2 and series[0].ratio > LARGE and series[-1].ratio < 2:
            yield _transition(series)


def fits(run: ChainRun) -> bool:
    """A chain under a uniaxial load whose first bead is struck along it, without dents."""
    case = run.case
    if case.precompression is None or case.precompression.kind != "uniaxial" or case.contact.initial_overlap:
        return False
    return case.load.kind == "impact" and case.load.spheres == 1 and not case.load.angle


class Wave:
    """The wave of a struck bead, measured far down the chain.

    Attributes
    ----------
    static
        F0, N.
    velocity
        Of the struck bead, m/s.
    last
        Contact, from 1, up to which the crest has passed before the far end was felt.
    ratio
        F_m/F0 half-way between the contacts that the speed is from, F_m with F0 in it.
    speed
        Of the crest there, m/s.
    steady
        The crest hardly falls there: it is a solitary wave.
    """

    def __init__(self, run: ChainRun) -> None:
        self.run, self.velocity, self.line = run, run.load.velocity, theory.line_of(run.case, run.law)
        self.static, self.c0 = self.line.force, self.line.speed
        added = run.force - self.static
        far = np.flatnonzero(np.abs(added[:, -1]) > _DISTURBED * added.max())
        self.until = int(far[0]) if len(far) else len(run.time)
        crests = np.array([first_peak(run.time[: self.until], one, floor=0.5) for one in added[: self.until].T])
        running = (crests[:, 0] < run.time[self.until - 1]) & (np.diff(crests[:, 0], prepend=-1) > 0)
        self.last = int(np.argmin(np.append(running, False)))
        if self.last < 2:
            return
        self.window = window = slice(self.last // 2, self.last)
        self.middle = (window.start + window.stop) // 2
        when, height = crests[window].T
        self.speed = self.line.spacing / float(np.polyfit(np.arange(len(when)), when, 1)[0])
        self.added = float(crests[self.middle, 1])
        self.ratio = 1 + self.added / self.static
        self.steady = float(height[-1] / height[0]) > 1 - _STEADY

    @property
    def reduced_velocity(self) -> float:
        """Over omega alpha0."""
        return self.velocity / self.line.velocity

    @property
    def long_wave_speed(self) -> float:
        """c0 by the crests of the beads' velocities, whose dispersion in a linear chain is known, m/s."""
        numbers = np.arange(_FIRST, self.last)
        run = self.run
        time, velocity = run.time[: self.until], run.velocity[: self.until]
        times = [first_peak(time, velocity[:, n - 1], floor=0.5)[0] for n in numbers]
        return self.line.spacing / (2 * float(np.polyfit(theory.crest_times(numbers), times, 1)[0]))

    @property
    def linear_speed(self) -> float:
        """Of the crest there if the chain were linear, m/s."""
        return theory.crest_speed(self.line, np.arange(self.window.start, self.window.stop) + 1)

    @property
    def linear_ratio(self) -> float:
        """F_m/F0 at that contact if the chain were linear."""
        return 1 + 1.5 * self.reduced_velocity * float(theory.crest_force(np.array([self.middle + 1]))[0])


def _one_each(waves: Sequence[Wave], key: Callable[[Wave], float]) -> list[Wave]:
    unique: dict[float, Wave] = {}
    for wave in waves:
        unique.setdefault(key(wave), wave)
    return [unique[value] for value in sorted(unique)]


# ---------------------------------------------------------------------- small pulses


def _small_pulses(waves: Sequence[Wave]) -> Study:
    force = np.array([wave.static for wave in waves])
    speed = np.array([wave.long_wave_speed for wave in waves])
    printed = np.array([theory.printed_speed(wave.run.case, wave.static) for wave in waves])
    fit = power(force, speed)
    rows = [
        Row("Power of the speed of small pulses with the static force", "", 1 / 6, fit.exponent, _WHERE),
        Row("Factor of c0 in (4 E^2 F0/(a^2 rho^3 (1-nu^2)^2))^(1/6)", "", theory.PRINTED_FACTOR,
            theory.PRINTED_FACTOR * float(np.mean(speed / printed)), _WHERE,
            "Theory: long waves of the lattice, sqrt(9/pi) 3^(-1/3) 4^(-1/6), with a the diameter.",
            theory.EXACT_FACTOR),
        *(Row(f"Speed of small pulses, F0 = {wave.static:g} N", "m/s", of_source, ours, _WHERE, "", wave.c0)
          for wave, of_source, ours in zip(waves, printed, speed, strict=True)),
    ]  # fmt: skip
    crest = waves[len(waves) // 2]
    text = (
        f"The first bead of a precompressed chain is struck so that F_m/F0 stays below {1 + SMALL:g}, at {len(waves)} "
        f"static forces. Such a pulse spreads, and its crest is slower than long waves (here by "
        f"{100 * (1 - crest.speed / crest.c0):.2g} %): c0 is found by the times of the crests at beads {_FIRST} to "
        f"{crest.last}, which are known for a linear chain. The source prints the formula."
    )
    caption = "Speed of small pulses against the static force (composite 3)"
    picture = Picture("precompressed_chain_small_pulses", caption, _draw_small(force, speed, printed, fit))
    return Study("precompressed-small-pulses", "Precompressed chain: small pulses", text, tuple(rows), (picture,))


def _draw_small(force: Array, speed: Array, printed: Array, fit: Power) -> Drawing:
    figure = new_figure(2.4)
    axes = figure.subplots()
    axes.loglog(force, printed, "-", color=GREY, label="c0 (composite 3)")
    axes.loglog(force, speed, "o", color=BLUE, markersize=4, label=f"simulation: power {fit.exponent:.4f}")
    axes.yaxis.set_minor_formatter(ScalarFormatter())
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set_xlabel("Static force F0 (N)")
    axes.set_ylabel("Speed of small pulses (m/s)")
    axes.legend(loc="upper left")
    return Drawing(figure, {"static_force_N": force, "speed_m_s": speed, "printed_m_s": printed})


# ---------------------------------------------------------------------- solitary waves


def _solitary_waves(waves: Sequence[Wave]) -> Study:
    one = waves[0]
    ratio = np.array([wave.ratio for wave in waves])
    printed = theory.printed_speed(one.run.case, one.static) * theory.solitary_speed(ratio)
    lattice = one.c0 * theory.lattice_speed(ratio)
    rows = []
    for wave, of_source, expected in zip(waves, printed, lattice, strict=True):
        remark = ""
        if not wave.steady:
            remark = "The crest still spreads and falls: no solitary wave yet, and slower than one."
        if wave.ratio < 1 + SMALL:
            remark += " Theory: the crest in the linear chain."
            expected = wave.linear_speed
        quantity = f"Speed of the wave, F_m/F0 = {wave.ratio:.4g}, impact at {wave.velocity:g} m/s"
        rows.append(Row(quantity, "m/s", float(of_source), wave.speed, _WHERE, remark, float(expected)))
    x = np.array([wave.reduced_velocity for wave in waves])
    rows += _rows_of_height(waves, x)
    slug = f"precompressed_chain_waves_{one.static:g}_N".replace(".", "_")
    title = f"Precompressed chain: waves on {one.static:g} N"
    text = (
        f"A chain under a static force of {one.static:g} N is struck at {waves[0].velocity:g} to "
        f"{waves[-1].velocity:g} m/s. F_m, with F0 in it, and the speed of its crest are taken around contact "
        f"{one.middle + 1}. Source: equation 3, a continuum's; theory: the travelling wave of the lattice, which is up "
        "to 1.2 % faster. In the limits the equation is right: its last factors go to 1 for f_r = F_m/F0 to 1, and "
        "0.9314 sqrt(8/15) = 0.6802 makes it equation 4 for large f_r."
    )
    picture = Picture(slug, "Speed of the wave and height of its crest on a precompressed chain",
                      _draw_waves(waves, x))  # fmt: skip
    return Study(slug.replace("_", "-"), title, text, tuple(rows), (picture,))


def _rows_of_height(waves: Sequence[Wave], x: Array) -> Iterator[Row]:
    if x[0] < SMALL:
        yield Row(
            f"F_m/F0 at {waves[0].velocity:g} m/s", "", None, waves[0].ratio, "ours",
            f"Theory: the linear chain at contact {waves[0].middle + 1}.", waves[0].linear_ratio,
        )  # fmt: skip
    if waves[-1].ratio > LARGE:
        yield Row(
            f"F_m/F0 at {waves[-1].velocity:g} m/s", "", None, waves[-1].ratio, "thesis 4.5",
            "Theory: the uncompressed chain of the same impact, plus 1: the limit for small F0.",
            1 + _IMPULSE * float(x[-1]) ** 1.2,
        )  # fmt: skip


def _draw_waves(waves: Sequence[Wave], x: Array) -> Drawing:
    figure = new_figure(2.7, 6.6)
    left, right = figure.subplots(1, 2)
    ratio = np.array([wave.ratio for wave in waves])
    speed = np.array([wave.speed / wave.c0 for wave in waves])
    steady = np.array([wave.steady for wave in waves])
    line = np.geomspace(1, 1.5 * ratio.max(), 200)
    left.semilogx(line, theory.solitary_speed(line), "-", color=GREY, label="composite (3)")
    left.semilogx(line, theory.lattice_speed(line), ":", color="black", label="lattice")
    _points(left, ratio, speed, steady)
    left.set_xlabel(r"$f_r = F_m/F_0$")
    left.set_ylabel(r"Speed over $c_0$")
    left.legend(loc="upper left")
    added = ratio - 1
    fine = np.geomspace(x.min(), x.max(), 50)
    linear = 1.5 * float(theory.crest_force(np.array([waves[0].middle + 1]))[0])
    right.loglog(fine, linear * fine, ":", color=GREEN, label="linear chain")
    right.loglog(fine, _IMPULSE * fine**1.2, "--", color=ORANGE, label="uncompressed: power 6/5")
    _points(right, x, added, steady)
    right.set_xlabel(r"Impact velocity over $\omega\alpha_0$")
    right.set_ylabel(r"Crest $F_m/F_0 - 1$")
    right.legend(loc="upper left")
    columns: dict[str, ArrayLike] = {
        "static_force_N": [wave.static for wave in waves],
        "impact_velocity_m_s": [wave.velocity for wave in waves],
        "reduced_velocity": x,
        "force_ratio": ratio,
        "speed_over_c0": speed,
        "solitary_over_c0": theory.solitary_speed(ratio),
        "lattice_over_c0": theory.lattice_speed(ratio),
        "steady": steady.astype(int),
    }
    return Drawing(figure, columns)


def _points(axes: Axes, x: Array, y: Array, steady: NDArray[np.bool_]) -> None:
    axes.plot(x[steady], y[steady], "o", color=BLUE, markersize=4, label="simulation")
    if not steady.all():
        axes.plot(
            x[~steady], y[~steady], "o", color=BLUE, markersize=4, markerfacecolor="white", label="still spreading"
        )


# ---------------------------------------------------------------------- to the uncompressed chain


def _transition(waves: Sequence[Wave]) -> Study:
    force = np.array([wave.static for wave in waves])
    speed = np.array([wave.speed for wave in waves])
    first, scales = waves[0], ChainScales(waves[0].run)
    free = scales.nesterenko(first.added)
    height = float(scales.impulse_force(first.run.mass * first.velocity)) * 0.7176
    last = waves[-1]
    rows = [
        Row(f"Speed at F0 = {first.static:g} N over that of an uncompressed chain", "", 1.0, first.speed / free,
            "composite (4)", "At the same largest force added; theory: the travelling wave of the lattice under F0.",
            first.c0 * float(theory.lattice_speed(np.array(first.ratio))) / free),
        Row(f"Largest force at F0 = {first.static:g} N", "N", None, first.static + first.added, "thesis 4.5",
            "Theory: the uncompressed lattice, 0.7176 (m^3 E*^2 R* v^6)^(1/5), and F0.", height + first.static),
        Row(f"Speed at F0 = {last.static:g} N", "m/s",
            theory.printed_speed(last.run.case, last.static) * float(theory.solitary_speed(np.array(last.ratio))),
            last.speed, _WHERE, "" if last.steady else "The crest still spreads: it is slower than a solitary wave.",
            last.c0 * float(theory.lattice_speed(np.array(last.ratio)))),
    ]  # fmt: skip
    crossing = (free / last.c0) ** 6 * last.static
    text = (
        f"One impact, at {first.velocity:g} m/s, on a chain under {len(waves)} static forces from {first.static:g} to "
        f"{last.static:g} N: the wave is that of an uncompressed chain as long as c0 is far below its speed, and a "
        f"small pulse beyond; the two lines cross at F0 = {crossing:.3g} N."
    )
    figure = new_figure(2.6)
    axes = figure.subplots()
    line = np.geomspace(force.min(), force.max(), 50)
    axes.loglog(line, last.c0 * (line / last.static) ** (1 / 6), "-", color=GREY, label="c0")
    axes.axhline(free, color=ORANGE, linestyle="--", label="uncompressed (composite 4)")
    axes.loglog(force, speed, "o", color=BLUE, markersize=4, label="simulation")
    axes.set_xlabel("Static force F0 (N)")
    axes.set_ylabel("Speed of the wave (m/s)")
    axes.set_ylim(top=1.5 * speed.max())
    axes.legend(loc="upper left")
    columns: dict[str, ArrayLike] = {
        "static_force_N": force,
        "speed_m_s": speed,
        "force_ratio": [wave.ratio for wave in waves],
        "c0_m_s": [wave.c0 for wave in waves],
    }
    slug = f"precompressed_chain_{first.velocity:g}_m_s".replace(".", "_")
    picture = Picture(
        slug, f"One impact at {first.velocity:g} m/s on chains under static forces", Drawing(figure, columns)
    )
    return Study(slug.replace("_", "-"), f"Precompressed to uncompressed chain, {first.velocity:g} m/s", text,
                 tuple(rows), (picture,))  # fmt: skip
