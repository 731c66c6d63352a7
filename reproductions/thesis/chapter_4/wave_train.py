"""Pulses from one solitary wave to a train.

A constant force acts on the first of 180 elastic beads, for five durations at each of four
amplitudes. A pulse is a train if the second peak at contact 63 is at least 1 % of the first. The
critical duration is interpolated between two runs.
"""

import numpy as np
from force_pulses import SECOND, ForcePulse, groups
from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import arrival, power_law


def measured(runs):
    """Pulses by amplitude; amplitudes, critical durations, and the power law through them."""
    found = groups(map(ForcePulse, runs), "amplitude")
    amplitude = np.array([group[0].amplitude for group in found])
    durations, seconds = (
        [np.array([getattr(p, name) for p in group]) for group in found]
        for name in ("duration", "second")
    )
    critical = np.array([arrival(*pair, SECOND) for pair in zip(durations, seconds, strict=True)])
    return found, amplitude, critical, power_law(amplitude, critical)


def rows(runs):
    _, amplitude, critical, fit = measured(runs)
    yield gw.Row(
        "Exponent of the critical loading time against the amplitude", ours=fit.exponent, theory=-1 / 6, verification=True,
        where="thesis Fig. 4.1", remark=f"{fit.interval} Every correct code gives this value, "
                                        "because of similarity.",
    )  # fmt: skip
    yield gw.Row(
        "Critical loading time T/tau times (A/(E* R*^2))^(1/6)", ours=np.mean(critical * amplitude ** (1 / 6)),
        where="thesis Fig. 4.1", remark="The value depends on the definition of a train, which is "
                                        "here a second peak of 1 % of the first.",
    )  # fmt: skip


def pictures(runs):
    found, at, critical, fit = measured(runs)
    names = ("amplitude", "duration", "second")
    amplitude, duration, second = np.array(
        [[getattr(p, n) for n in names] for group in found for p in group]
    ).T
    figure = Figure((7, 2.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    for chosen, fill, what in (
        (second < SECOND, "none", "one wave"),
        (second >= SECOND, "full", "train"),
    ):
        left.loglog(
            amplitude[chosen], duration[chosen], "oC0", fillstyle=fill, markersize=4, label=what
        )
    left.loglog(at, fit(at), "C1", label=f"critical: power {fit.exponent:.4f}")
    left.plot(at, critical, "_C1", markersize=12)
    left.set(xlabel=r"Amplitude $A/(E^* R^{*2})$", ylabel=r"Duration $T/\tau$")
    left.legend()
    for pulse in found[len(found) // 2]:
        load = pulse.chain.load
        scaled = f"{pulse.duration * pulse.amplitude ** (1 / 6):.1f}"
        right.semilogy(
            (pulse.chain.time - pulse.first_peak) / load.lasts,
            pulse.signal / load.largest,
            label=scaled,
        )
    right.set(
        xlabel="Time after the first peak / duration T",
        ylabel=f"Force at contact {pulse.contact} / A",
    )
    right.set(xlim=(-3, 36), ylim=(1e-3, 3))
    right.legend(title=r"$T/\tau\; (A/E^* R^{*2})^{1/6}$", ncols=2, loc="upper right")
    data = {
        "amplitude_normalised": amplitude,
        "duration_normalised": duration,
        "second_over_first_peak": second,
    }
    caption = (
        "Loads that cause one wave and loads that cause a train, by amplitude and duration, with "
        "the critical duration between them (thesis Fig. 4.1). Right: forces. A train has a "
        f"second peak above {100 * SECOND:g} % of the first"
    )
    data |= {"amplitude_of_critical": at, "critical_duration": critical}
    yield gw.Picture("elastic_wave_train", caption, figure, data)
