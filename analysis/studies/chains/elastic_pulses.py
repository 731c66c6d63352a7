"""Elastic chains of like beads under a steady force A for a time T: one wave or a train, and its peak (thesis 4.1).

Hertz's chain has no scale of its own: in the units of `elastic_scales` a pulse of impulse I = A T is one point of one
curve, F_peak/I^(6/5) against A/I^(6/5) (thesis Fig. 4.3), and the duration at which one wave becomes a train is
T = q A^(-1/6) (Fig. 4.1). The source says neither how a train is recognised nor what q is. Here a pulse is a train if
the second peak of the force at one contact is at least `SECOND` of the first; the contact is at `_SHARE` of the chain,
so that a second wave of that height still passes it before the first one comes to the end.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np
from matplotlib.ticker import LogLocator, NullLocator
from numpy.typing import NDArray

from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, Drawing, new_figure
from granwave.analysis.measures.signals import Power, power
from granwave.analysis.studies.chains.runs import ChainRun, uniform
from granwave.analysis.studies.chains.scales import ChainScales, from_thesis, passed, undisturbed
from granwave.analysis.studies.study import Picture, Row, Study

Array = NDArray[np.float64]

SECOND = 0.01  # of the first peak: from then on a train
SINGLE_LIMIT = 0.719 * (3 / 128) ** 0.6  # (4.5) in normalised units: F_peak/I^(6/5) = 0.0757
DISCRETE_LIMIT = 0.7176 * (3 / 128) ** 0.6
TRAIN_LIMIT = 92.7 / 40  # F_peak/A of thesis 4.1.3
_CROSSING = SINGLE_LIMIT / TRAIN_LIMIT
_CLEAR = 8.0  # times away from the crossing a pulse is counted to a limit
_SHARE = 0.35
_FEWEST_CONTACTS = 80
_FEWEST_DURATIONS = 3
_FEWEST_PULSES = 4
_ALIKE = 1e-3
_COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY)
_EXAMPLES = ((1e-6, "one wave"), (1e-4, "a train"))  # durations of the impulse of 0.40 N s in thesis 4.1.1, s
_EXAMPLE_IMPULSE = 0.40  # N s


@dataclasses.dataclass(frozen=True, eq=False)
class _Pulse:
    """A rectangle of force on the first bead, and what became of it; all in normalised units."""

    run: ChainRun

    @cached_property
    def amplitude(self) -> float:
        return self.run.load.largest / ChainScales(self.run).force

    @cached_property
    def duration(self) -> float:
        return self.run.load.lasts / ChainScales(self.run).time

    @cached_property
    def impulse(self) -> float:
        return self.amplitude * self.duration

    @property
    def reduced(self) -> float:
        """A/I^(6/5)."""
        return float(self.amplitude / self.impulse**1.2)

    @cached_property
    def peak(self) -> float:
        """At the last contact that the leading wave has passed."""
        force = self.run.of_contacts("peak_force")[passed(self.run) - 1]
        return float(force) / ChainScales(self.run).force

    @property
    def contact(self) -> int:
        """From 1, where waves are counted."""
        return round(_SHARE * self.run.force.shape[1])

    @cached_property
    def waves(self) -> Array:
        """Heights of the successive peaks at that contact over the first one's."""
        signal = self.run.force[:, self.contact - 1]
        inner = (signal[1:-1] >= signal[:-2]) & (signal[1:-1] > signal[2:])
        heights = signal[1:-1][inner]
        return heights / heights[0] if len(heights) else heights

    @property
    def second(self) -> float:
        """The highest of the later peaks over the first one; 0 without any."""
        return float(self.waves[1:].max(initial=0.0))


def wave_train(runs: Sequence[ChainRun]) -> Iterator[Study]:
    """The duration from which on a steady force makes a train of waves, against its amplitude."""
    groups = [group for group in _grouped(_pulses(runs), "amplitude") if len(group) >= _FEWEST_DURATIONS]
    found = [(group, duration) for group in groups if math.isfinite(duration := _critical(group))]
    if not found:
        return
    amplitude = np.array([group[0].amplitude for group, _ in found])
    critical = np.array([each for _, each in found])
    fit = power(amplitude, critical) if len(found) > 1 else None
    rows = []
    if fit is not None:
        remark = f"95 % confidence interval: ± {fit.margin:.1g}." if math.isfinite(fit.margin) else ""
        rows.append(
            Row("Power of the critical loading time with the amplitude", "", -1 / 6, fit.exponent, "thesis Fig. 4.1",
                remark)
        )  # fmt: skip
    factor = float(np.mean(critical * amplitude ** (1 / 6)))
    rows.append(
        Row("Critical loading time T/tau times (A/(E* R*^2))^(1/6)", "", None, factor, "thesis Fig. 4.1",
            f"Depends on what is called a train: here a second peak of {100 * SECOND:g} % of the first.")
    )  # fmt: skip
    middle = found[len(found) // 2][0]
    text = (
        f"A steady force on the first bead, for three durations and more at each of {len(found)} amplitudes. A pulse "
        f"is a train if the second peak at contact {middle[0].contact} is at least {100 * SECOND:g} % of the first; "
        "the critical duration is interpolated between two runs."
    )
    caption = "From one wave to a train: critical loading time (thesis Fig. 4.1), and forces"
    drawing = _draw_train([group for group, _ in found], critical, fit, middle)
    picture = Picture("elastic_wave_train", caption, drawing)
    yield Study("wave-train", "From one solitary wave to a train", text, tuple(rows), (picture,))


def master_curve(runs: Sequence[ChainRun]) -> Iterator[Study]:
    """Peak force of the leading wave against amplitude and impulse, on one curve."""
    pulses = sorted(_pulses(runs), key=lambda pulse: pulse.reduced)
    if len(pulses) < _FEWEST_PULSES or pulses[-1].reduced < 10 * pulses[0].reduced:
        return
    reduced = np.array([pulse.reduced for pulse in pulses])
    peak = np.array([pulse.peak / pulse.impulse**1.2 for pulse in pulses])
    rows = list(_rows_of_limits(pulses, reduced, peak))
    farthest = sorted({passed(pulse.run) for pulse in pulses})
    text = (
        f"A steady force on the first bead: {len(pulses)} runs. Peak force of the leading wave, at the last contact "
        f"that it has passed by the end of the run: {farthest[0]} to {farthest[-1]}. The two largest impulses of the "
        "source's figure would press beads together by more than R*, where no contact law holds; smaller ones are as "
        "good, since the elastic chain has no scale of its own."
    )
    caption = "Peak force against amplitude, and all impulses on one curve (thesis Fig. 4.3)"
    picture = Picture("elastic_master_curve", caption, _draw_master(pulses, reduced, peak))
    yield Study("elastic-pulses", "Peak force of elastic pulses", text, tuple(rows), (picture,))


def _pulses(runs: Sequence[ChainRun]) -> list[_Pulse]:
    """Of runs that go on after the force has ended and stop before the end of the chain."""
    return [
        _Pulse(run) for run in uniform(runs, "hertz")
        if run.load.kind == "force" and run.load.shape == "rectangle" and run.load.spheres == 1
        and run.load.lasts < run.time[-1] and passed(run) >= _FEWEST_CONTACTS and undisturbed(run)
    ]  # fmt: skip


def _grouped(pulses: Sequence[_Pulse], key: str) -> list[list[_Pulse]]:
    """Pulses of one amplitude or impulse, in rising order of it, each group in that of its durations."""
    groups: list[list[_Pulse]] = []
    for pulse in sorted(pulses, key=lambda pulse: float(getattr(pulse, key))):
        if not groups or getattr(pulse, key) > (1 + _ALIKE) * getattr(groups[-1][0], key):
            groups.append([])
        groups[-1].append(pulse)
    return [sorted(group, key=lambda pulse: pulse.duration) for group in groups]


def _critical(group: Sequence[_Pulse]) -> float:
    """The duration at which the second peak is `SECOND` of the first, by a straight line; NaN: outside of the runs."""
    second = np.array([pulse.second for pulse in group])
    above = np.flatnonzero(second >= SECOND)
    if not len(above) or above[0] == 0:
        return math.nan
    k = int(above[0])
    part = (SECOND - second[k - 1]) / (second[k] - second[k - 1])
    return float(group[k - 1].duration + part * (group[k].duration - group[k - 1].duration))


def _rows_of_limits(pulses: Sequence[_Pulse], reduced: Array, peak: Array) -> Iterator[Row]:
    where = "thesis Fig. 4.3"
    short, long = reduced > _CLEAR * _CROSSING, reduced < _CROSSING / _CLEAR
    if short.any():
        yield Row("Short pulses: F_peak/I^(6/5), normalised", "", SINGLE_LIMIT, float(peak[short].mean()), where,
                  f"Mean of A/I^(6/5) > {_CLEAR * _CROSSING:.2g}. Source: from (4.5); theory: the discrete chain.",
                  DISCRETE_LIMIT)  # fmt: skip
    if long.any():
        yield Row("Long pulses: F_peak/A", "", TRAIN_LIMIT, float((peak[long] / reduced[long]).mean()), where,
                  f"Mean of A/I^(6/5) < {_CROSSING / _CLEAR:.2g}. Source: 92.7 N for 40 N.")  # fmt: skip
    gaps = [
        math.expm1(abs(math.log(peak[k + 1] / peak[k])))
        for k in range(len(pulses) - 1)
        if reduced[k + 1] < (1 + _ALIKE) * reduced[k] and abs(math.log(pulses[k + 1].impulse / pulses[k].impulse)) > 1
    ]
    if gaps:
        yield Row("Largest spread of F_peak/I^(6/5) between impulses at equal A/I^(6/5)", "%", None, 100 * max(gaps),
                  where, "Theory: none, since Hertz's chain has no scale of its own.", 0.0)  # fmt: skip
    for duration, name in _EXAMPLES:
        for pulse in pulses:
            load = pulse.run.load
            same = math.isclose(load.impulse, _EXAMPLE_IMPULSE, rel_tol=_ALIKE)
            if from_thesis(pulse.run) and same and math.isclose(load.lasts, duration, rel_tol=_ALIKE):
                count = int(np.count_nonzero(pulse.waves >= SECOND))
                what = f"Waves above {100 * SECOND:g} % at contact {pulse.contact}"
                yield Row(f"{what}, {_EXAMPLE_IMPULSE} N s within {1e6 * duration:g} us", "",
                          1.0 if duration < 1e-5 else None, count, "thesis 4.1.1", f"The source: {name}.")  # fmt: skip


def _draw_train(
    groups: Sequence[Sequence[_Pulse]], critical: Array, fit: Power | None, middle: Sequence[_Pulse]
) -> Drawing:
    figure = new_figure(2.8, 7.0)
    left, right = figure.subplots(1, 2)
    pulses = [pulse for group in groups for pulse in group]
    amplitude, duration = (np.array([getattr(pulse, name) for pulse in pulses]) for name in ("amplitude", "duration"))
    second = np.array([pulse.second for pulse in pulses])
    train = second >= SECOND
    left.loglog(amplitude[~train], duration[~train], "o", color=BLUE, fillstyle="none", markersize=4, label="one wave")
    left.loglog(amplitude[train], duration[train], "o", color=BLUE, markersize=4, label="train")
    at = np.array([group[0].amplitude for group in groups])
    left.loglog(at, critical, "_", color=ORANGE, markersize=12, label="critical")
    if fit is not None:
        left.loglog(at, fit(at), color=ORANGE, linewidth=0.8, label=f"power {fit.exponent:.4f}")
    left.yaxis.set_major_locator(LogLocator(subs=(1, 1.5, 2, 3, 4, 6, 8)))
    left.yaxis.set_major_formatter("{x:g}")
    left.yaxis.set_minor_locator(NullLocator())
    left.set_xlabel(r"Amplitude $A/(E^* R^{*2})$")
    left.set_ylabel(r"Duration $T/\tau$")
    left.legend()
    for pulse, colour in zip(middle, _COLOURS, strict=False):
        signal = pulse.run.force[:, pulse.contact - 1]
        since = (pulse.run.time - pulse.run.time[_first_crest(signal)]) / pulse.run.load.lasts
        label = f"{pulse.duration * pulse.amplitude ** (1 / 6):.1f}"
        right.semilogy(since, signal / pulse.run.load.largest, color=colour, linewidth=0.9, label=label)
    right.set_xlim(-3, 36)
    right.set_ylim(1e-3, 3)
    right.set_xlabel("Time after the first peak, over the duration T")
    right.set_ylabel(f"Force at contact {middle[0].contact} over A")
    right.legend(title=r"$T/\tau\; (A/E^* R^{*2})^{1/6}$", ncols=2, loc="upper right")
    columns = {"amplitude_normalised": amplitude, "duration_normalised": duration, "second_over_first_peak": second,
               "amplitude_of_critical": at, "critical_duration": critical}  # fmt: skip
    return Drawing(figure, columns)


def _draw_master(pulses: Sequence[_Pulse], reduced: Array, peak: Array) -> Drawing:
    """Thesis Fig. 4.3."""
    figure = new_figure(2.8, 7.0)
    left, right = figure.subplots(1, 2)
    groups = [group for group in _grouped(pulses, "impulse") if len(group) >= _FEWEST_DURATIONS]
    right.loglog(reduced, peak, ".", color=BLUE, markersize=3, label="simulation")
    for n, (group, colour) in enumerate(zip(groups, _COLOURS, strict=False)):
        x, y, impulse = (np.array([getattr(p, name) for p in group]) for name in ("amplitude", "peak", "impulse"))
        left.loglog(x, y, "o-", color=colour, markersize=3, linewidth=0.8, label=f"{impulse[0]:.3g}")
        right.loglog(x / impulse**1.2, y / impulse**1.2, "o", color=colour, fillstyle="none", markersize=4 + 2 * n)
    left.set_xlabel(r"Amplitude $A/(E^* R^{*2})$")
    left.set_ylabel(r"Peak force $F/(E^* R^{*2})$")
    if groups:
        left.legend(title=r"Impulse $I/(E^* R^{*2} \tau)$", loc="lower right", fontsize=7)
    fine = np.geomspace(0.5 * reduced[0], 2 * reduced[-1], 200)
    right.loglog(fine, np.full_like(fine, SINGLE_LIMIT), "--", color=GREY, label=f"{SINGLE_LIMIT:.4f} (thesis 4.5)")
    right.loglog(fine, TRAIN_LIMIT * fine, ":", color=GREY, label=rf"{TRAIN_LIMIT:.2f} $A/I^{{6/5}}$")
    right.set_ylim(0.5 * peak.min(), 3 * SINGLE_LIMIT)
    right.set_xlabel(r"$A/I^{6/5}$, normalised")
    right.set_ylabel(r"Peak force $F/I^{6/5}$, normalised")
    right.legend(loc="lower right")
    names = ("amplitude", "duration", "impulse", "peak")
    columns = {f"{name}_normalised": [getattr(pulse, name) for pulse in pulses] for name in names}
    return Drawing(figure, columns | {"amplitude_over_impulse_power": reduced, "peak_over_impulse_power": peak})


def _first_crest(signal: Array) -> int:
    """Of a signal that is zero at first."""
    return int(np.flatnonzero((signal[1:-1] >= signal[:-2]) & (signal[1:-1] > signal[2:]))[0]) + 1
