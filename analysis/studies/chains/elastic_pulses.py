"""Peak force of the leading wave against amplitude and impulse of a steady force, on one curve (thesis Fig. 4.3)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.figures.curves import COLOURS, label, panels
from granwave.analysis.figures.style import BLUE, GREY, Drawing
from granwave.analysis.measures.hertz_chain import DISCRETE_COEFFICIENT, IMPULSE_COEFFICIENT
from granwave.analysis.measures.signals import Array
from granwave.analysis.studies.chains.force_pulses import ALIKE, SECOND, ForcePulse, force_pulses, grouped
from granwave.analysis.studies.chains.runs import columns
from granwave.analysis.studies.chains.scales import from_thesis, passed
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row

TITLE = "Peak force of elastic pulses"
#: (4.5) in normalised units, F_peak/I^(6/5) = 0.0757, and the same of the discrete chain.
SINGLE_LIMIT, DISCRETE_LIMIT = (one * (3 / 128) ** 0.6 for one in (IMPULSE_COEFFICIENT, DISCRETE_COEFFICIENT))
TRAIN_LIMIT = 92.7 / 40  # F_peak/A of thesis 4.1.3
_CROSSING = SINGLE_LIMIT / TRAIN_LIMIT
_CLEAR = 8.0  # times away from the crossing a pulse is counted to a limit
_FEWEST_PULSES = 4
_EXAMPLES = ((1e-6, "one wave"), (1e-4, "a train"))  # durations of the impulse of 0.40 N s in thesis 4.1.1, s
_EXAMPLE_IMPULSE = 0.40  # N s
_WHERE = "thesis Fig. 4.3"


def select(runs: Sequence[FinishedRun]) -> list[list[ForcePulse]]:
    """Pulses in the order of A/I^(6/5), if they cover a part of the curve."""
    pulses = sorted(force_pulses(runs), key=lambda pulse: pulse.reduced)
    enough = len(pulses) >= _FEWEST_PULSES and pulses[-1].reduced >= 10 * pulses[0].reduced
    return [pulses] if enough else []


def text(pulses: Sequence[ForcePulse]) -> str:
    """Describe the runs."""
    farthest = sorted({passed(pulse.run) for pulse in pulses})
    return (
        f"A steady force on the first bead: {len(pulses)} runs. Peak force of the leading wave, at the last contact "
        f"that it has passed by the end of the run: {farthest[0]} to {farthest[-1]}. The two largest impulses of the "
        "source's figure would press beads together by more than R*, where no contact law holds; smaller ones are as "
        "good, since the elastic chain has no scale of its own."
    )


def rows(pulses: Sequence[ForcePulse]) -> Iterator[Row]:
    """Both limits, the spread between impulses, and the source's examples."""
    reduced, peak = _curve(pulses)
    short, long = reduced > _CLEAR * _CROSSING, reduced < _CROSSING / _CLEAR
    if short.any():
        yield Row("Short pulses: F_peak/I^(6/5), normalised", "", SINGLE_LIMIT, float(peak[short].mean()), _WHERE,
                  f"Mean of A/I^(6/5) > {_CLEAR * _CROSSING:.2g}. Source: from (4.5); theory: the discrete chain.",
                  DISCRETE_LIMIT)  # fmt: skip
    if long.any():
        yield Row("Long pulses: F_peak/A", "", TRAIN_LIMIT, float((peak[long] / reduced[long]).mean()), _WHERE,
                  f"Mean of A/I^(6/5) < {_CROSSING / _CLEAR:.2g}. Source: 92.7 N for 40 N.")  # fmt: skip
    impulse = np.array([pulse.impulse for pulse in pulses])
    alike = (reduced[1:] < (1 + ALIKE) * reduced[:-1]) & (np.abs(np.diff(np.log(impulse))) > 1)
    if alike.any():
        spread = float(np.expm1(np.abs(np.diff(np.log(peak)))[alike].max()))
        yield Row("Largest spread of F_peak/I^(6/5) between impulses at equal A/I^(6/5)", "%", None, 100 * spread,
                  _WHERE, "Theory: none, since Hertz's chain has no scale of its own.", 0.0)  # fmt: skip
    for duration, what in _EXAMPLES:
        for pulse in pulses:
            load = pulse.run.load
            same = math.isclose(load.impulse, _EXAMPLE_IMPULSE, rel_tol=ALIKE)
            if from_thesis(pulse.run) and same and math.isclose(load.lasts, duration, rel_tol=ALIKE):
                yield Row(f"Waves above {100 * SECOND:g} % at contact {pulse.contact}, {_EXAMPLE_IMPULSE} N s within "
                          f"{1e6 * duration:g} us", "", 1.0 if duration < 1e-5 else None,
                          int(np.count_nonzero(pulse.waves >= SECOND)), "thesis 4.1.1",
                          f"The source: {what}.")  # fmt: skip


def pictures(pulses: Sequence[ForcePulse]) -> Iterator[Picture]:
    """Thesis Fig. 4.3."""
    reduced, peak = _curve(pulses)
    figure, left, right = panels(2.8, 2)
    right.plot(reduced, peak, ".", color=BLUE, markersize=3, label="simulation")
    groups = grouped(pulses, "impulse")
    for n, (group, colour) in enumerate(zip(groups, COLOURS[:5], strict=False)):
        x, y, impulse = columns(group, "amplitude", "peak", "impulse")
        left.plot(x, y, "o-", color=colour, markersize=3, linewidth=0.8, label=f"{impulse[0]:.3g}")
        right.plot(x / impulse**1.2, y / impulse**1.2, "o", color=colour, fillstyle="none", markersize=4 + 2 * n)
    label(left, r"Amplitude $A/(E^* R^{*2})$", r"Peak force $F/(E^* R^{*2})$", log="xy")
    if groups:
        left.legend(title=r"Impulse $I/(E^* R^{*2} \tau)$", loc="lower right", fontsize=7)
    fine = np.geomspace(0.5 * reduced[0], 2 * reduced[-1], 200)
    right.plot(fine, np.full_like(fine, SINGLE_LIMIT), "--", color=GREY, label=f"{SINGLE_LIMIT:.4f} (thesis 4.5)")
    right.plot(fine, TRAIN_LIMIT * fine, ":", color=GREY, label=rf"{TRAIN_LIMIT:.2f} $A/I^{{6/5}}$")
    label(right, r"$A/I^{6/5}$, normalised", r"Peak force $F/I^{6/5}$, normalised",
          log="xy", ylim=(0.5 * peak.min(), 3 * SINGLE_LIMIT))  # fmt: skip
    right.legend(loc="lower right")
    names = ("amplitude", "duration", "impulse", "peak")
    data = dict(zip((f"{name}_normalised" for name in names), columns(pulses, *names), strict=True))
    data |= {"amplitude_over_impulse_power": reduced, "peak_over_impulse_power": peak}
    caption = "Peak force against amplitude, and all impulses on one curve (thesis Fig. 4.3)"
    yield Picture("elastic_master_curve", caption, Drawing(figure, data))


def _curve(pulses: Sequence[ForcePulse]) -> tuple[Array, Array]:
    """A/I^(6/5) and F_peak/I^(6/5)."""
    reduced, peak, impulse = columns(pulses, "reduced", "peak", "impulse")
    return reduced, peak / impulse**1.2
