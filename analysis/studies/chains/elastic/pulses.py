"""Peak force of the leading wave against amplitude and impulse of a steady force, on one curve (thesis Fig. 4.3)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.figures.series import COLOURS, label, panels
from granwave.analysis.figures.style import BLUE, GREY, Drawing
from granwave.analysis.measures.chains.force_pulse import ALIKE, SECOND, ForcePulse, force_pulses, grouped
from granwave.analysis.measures.chains.groups import columns
from granwave.analysis.measures.chains.hertz_chain import DISCRETE_LIMIT, IMPULSE_LIMIT
from granwave.analysis.studies.chains.runs import from_thesis, uniform
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row

TITLE = "Peak force of elastic pulses"
_LOAD, _PEAK = 40.0, 92.7  # N, of thesis 4.1.3
TRAIN_LIMIT = _PEAK / _LOAD  # F_peak/A
_CROSSING = IMPULSE_LIMIT / TRAIN_LIMIT
_CLEAR = 8.0  # times away from the crossing a pulse is counted to a limit
_FEWEST_PULSES = 4
_EXAMPLES = ((1e-6, 1.0, "one wave"), (1e-4, None, "a train"))  # thesis 4.1.1: duration, s; number of waves
_EXAMPLE_IMPULSE = 0.40  # N s
_WHERE = "thesis Fig. 4.3"


def select(runs: Sequence[FinishedRun]) -> list[list[ForcePulse]]:
    """Pulses in the order of A/I^(6/5), if they cover a part of the curve."""
    pulses = sorted(force_pulses(uniform(runs, "hertz")), key=lambda pulse: pulse.reduced)
    enough = len(pulses) >= _FEWEST_PULSES and pulses[-1].reduced >= 10 * pulses[0].reduced
    return [pulses] if enough else []


def text(pulses: Sequence[ForcePulse]) -> str:
    """Describe the runs."""
    farthest = [pulse.run.passed for pulse in pulses]
    return (
        f"A steady force on the first bead: {len(pulses)} runs. Peak force of the leading wave, at the last contact "
        f"that it has passed by the end of the run: {min(farthest)} to {max(farthest)}. The two largest impulses of "
        "the source's figure would press beads together by more than R*, where no contact law holds; smaller ones are "
        "as good, since the elastic chain has no scale of its own."
    )


def rows(pulses: Sequence[ForcePulse]) -> Iterator[Row]:
    """Both limits, the spread between impulses, and the source's examples."""
    reduced, peak, impulse = columns(pulses, "reduced", "reduced_peak", "impulse")
    short, long = reduced > _CLEAR * _CROSSING, reduced < _CROSSING / _CLEAR
    if short.any():
        remark = f"Mean of A/I^(6/5) > {_CLEAR * _CROSSING:.2g}. "
        remark += f"Theory: the discrete chain; (4.5) gives {IMPULSE_LIMIT:.4f}."
        yield Row("Short pulses: F_peak/I^(6/5), normalised", "", None, float(peak[short].mean()), _WHERE, remark,
                  DISCRETE_LIMIT)  # fmt: skip
    if long.any():
        remark = f"Mean of A/I^(6/5) < {_CROSSING / _CLEAR:.2g}, where the force only sets the scale."
        ours = float((peak[long] / reduced[long]).mean())
        yield Row(f"Long pulses: peak force of one of {_LOAD:g} N", "N", _PEAK, ours * _LOAD, "thesis 4.1.3", remark)
    alike = (reduced[1:] < (1 + ALIKE) * reduced[:-1]) & (np.abs(np.diff(np.log(impulse))) > 1)
    if alike.any():
        spread = float(np.expm1(np.abs(np.diff(np.log(peak)))[alike].max()))
        yield Row("Largest spread of F_peak/I^(6/5) between impulses at equal A/I^(6/5)", "%", None, 100 * spread,
                  _WHERE, "None, since Hertz's chain has no scale of its own.", 0.0, True)  # fmt: skip
    for duration, source, what in _EXAMPLES:
        for pulse in pulses:
            load, example = pulse.run.load, (_EXAMPLE_IMPULSE, duration)
            if from_thesis(pulse.run) and np.allclose((load.impulse, load.lasts), example, rtol=ALIKE, atol=0):
                yield Row(f"Waves above {100 * SECOND:g} % at contact {pulse.contact}, {_EXAMPLE_IMPULSE} N s within "
                          f"{1e6 * duration:g} us", "", source, int(np.count_nonzero(pulse.waves >= SECOND)),
                          "thesis 4.1.1", f"The source: {what}.")  # fmt: skip


def pictures(pulses: Sequence[ForcePulse]) -> Iterator[Picture]:
    """Thesis Fig. 4.3."""
    names = ("amplitude", "duration", "impulse", "peak")
    data = dict(zip((f"{name}_normalised" for name in names), columns(pulses, *names), strict=True))
    reduced, peak = columns(pulses, "reduced", "reduced_peak")
    data |= {"amplitude_over_impulse_power": reduced, "peak_over_impulse_power": peak}
    figure, left, right = panels(2.8, 2)
    right.plot(reduced, peak, ".", color=BLUE, markersize=3, label="simulation")
    for n, group in enumerate(grouped(pulses, "impulse")[: len(COLOURS) - 1]):
        x, y, u, v = columns(group, "amplitude", "peak", "reduced", "reduced_peak")
        left.plot(x, y, "o-", markersize=3, label=f"{group[0].impulse:.3g}")
        right.plot(u, v, "o", fillstyle="none", markersize=4 + 2 * n)
    label(left, r"Amplitude $A/(E^* R^{*2})$", r"Peak force $F/(E^* R^{*2})$", log="xy")
    if left.lines:
        left.legend(title=r"Impulse $I/(E^* R^{*2} \tau)$", loc="lower right", fontsize=7)
    fine = np.geomspace(0.5 * reduced[0], 2 * reduced[-1], 200)
    right.plot(fine, np.full_like(fine, IMPULSE_LIMIT), "--", color=GREY, label=f"{IMPULSE_LIMIT:.4f} (thesis 4.5)")
    right.plot(fine, TRAIN_LIMIT * fine, ":", color=GREY, label=rf"{TRAIN_LIMIT:.2f} $A/I^{{6/5}}$")
    label(right, r"$A/I^{6/5}$, normalised", r"Peak force $F/I^{6/5}$, normalised",
          log="xy", ylim=(0.5 * peak.min(), 3 * IMPULSE_LIMIT))  # fmt: skip
    right.legend(loc="lower right")
    caption = "Peak force against amplitude, and all impulses on one curve (thesis Fig. 4.3)"
    yield Picture("elastic_master_curve", caption, Drawing(figure, data))
