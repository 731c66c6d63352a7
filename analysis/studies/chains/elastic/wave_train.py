"""From one solitary wave to a train: the duration from which on a force makes more than one (thesis Fig. 4.1)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.figures.series import COLOURS, label, panels
from granwave.analysis.figures.style import BLUE, ORANGE, Drawing
from granwave.analysis.measures.chains.force_pulse import SECOND, ForcePulse, force_pulses, grouped
from granwave.analysis.measures.chains.groups import columns
from granwave.analysis.measures.signals import Array, Power, arrival, power
from granwave.analysis.studies.chains.runs import uniform
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row

TITLE = "From one solitary wave to a train"
Groups = list[list[ForcePulse]]


def select(runs: Sequence[FinishedRun]) -> list[Groups]:
    """Pulses of three durations and more at each of some amplitudes, on both sides of the critical one."""
    found = grouped(force_pulses(uniform(runs, "hertz")), "amplitude")
    groups = [group for group in found if math.isfinite(_critical(group))]
    return [groups] if groups else []


def text(groups: Groups) -> str:
    """Describe the runs."""
    return (
        f"A steady force on the first bead, for three durations and more at each of {len(groups)} amplitudes. A pulse "
        f"is a train if the second peak at contact {_middle(groups)[0].contact} is at least {100 * SECOND:g} % of the "
        "first; the critical duration is interpolated between two runs."
    )


def rows(groups: Groups) -> Iterator[Row]:
    """Power of the critical duration with the amplitude, and its factor."""
    amplitude, critical, fit = _curve(groups)
    where = "thesis Fig. 4.1"
    if fit is not None:
        what = "Power of the critical loading time with the amplitude"
        remark = f"{fit.interval} Similarity forces it on any correct code."
        yield Row(what, "", None, fit.exponent, where, remark, -1 / 6, True)
    factor = float(np.mean(critical * amplitude ** (1 / 6)))
    remark = f"Depends on what is called a train: here a second peak of {100 * SECOND:g} % of the first."
    yield Row("Critical loading time T/tau times (A/(E* R*^2))^(1/6)", "", None, factor, where, remark)


def pictures(groups: Groups) -> Iterator[Picture]:
    """Waves and trains by amplitude and duration, and forces at one contact."""
    at, critical, fit = _curve(groups)
    pulses, middle = [pulse for group in groups for pulse in group], _middle(groups)
    amplitude, duration, second = columns(pulses, "amplitude", "duration", "second")
    figure, left, right = panels(2.8, 2)
    for chosen, fill, what in ((second < SECOND, "none", "one wave"), (second >= SECOND, "full", "train")):
        left.plot(amplitude[chosen], duration[chosen], "o", color=BLUE, fillstyle=fill, markersize=4, label=what)
    left.plot(at, critical, "_", color=ORANGE, markersize=12, label="critical")
    if fit is not None:
        left.plot(at, fit(at), color=ORANGE, label=f"power {fit.exponent:.4f}")
    label(left, r"Amplitude $A/(E^* R^{*2})$", r"Duration $T/\tau$", log="xy")
    left.legend()
    for pulse in middle[: len(COLOURS) - 1]:
        load, scaled = pulse.run.load, f"{pulse.duration * pulse.amplitude ** (1 / 6):.1f}"
        right.plot((pulse.run.time - pulse.first_peak) / load.lasts, pulse.signal / load.largest, label=scaled)
    label(right, "Time after the first peak, over the duration T", f"Force at contact {middle[0].contact} over A",
          log="y", xlim=(-3, 36), ylim=(1e-3, 3))  # fmt: skip
    right.legend(title=r"$T/\tau\; (A/E^* R^{*2})^{1/6}$", ncols=2, loc="upper right")
    data = {"amplitude_normalised": amplitude, "duration_normalised": duration, "second_over_first_peak": second,
            "amplitude_of_critical": at, "critical_duration": critical}  # fmt: skip
    caption = "From one wave to a train: critical loading time (thesis Fig. 4.1), and forces"
    yield Picture("elastic_wave_train", caption, Drawing(figure, data))


def _middle(groups: Groups) -> list[ForcePulse]:
    return groups[len(groups) // 2]


def _critical(group: Sequence[ForcePulse]) -> float:
    """The duration at which the second peak is `SECOND` of the first, by a straight line; NaN: outside of the runs."""
    duration, second = columns(group, "duration", "second")
    return arrival(duration, second, SECOND) if second[0] < SECOND else math.nan


def _curve(groups: Groups) -> tuple[Array, Array, Power | None]:
    """Amplitudes, critical durations, and the power law through them."""
    amplitude, critical = np.array([(group[0].amplitude, _critical(group)) for group in groups]).T
    return amplitude, critical, power(amplitude, critical) if len(groups) > 1 else None
