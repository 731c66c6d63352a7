"""Rectangular force pulses on the first bead of an elastic chain, in the units of the chain.

A chain of Hertzian contacts has no scale: a pulse of impulse I = A T is a point of a single curve,
F_peak/I^(6/5) against A/I^(6/5), and the duration at which one wave becomes a train is T = q
A^(-1/6). A pulse is a train here if the second peak at one contact is at least `SECOND` of the
first; the contact is at 0.35 of the chain, so that a second wave still passes it before the first
one comes to the end.
"""

from itertools import groupby

from granwave.measures import Chain, maxima

SECOND = 0.01  # fraction of the first peak above which the pulse is a train


class ForcePulse:
    """A rectangular force on the first bead, and the resulting waves: forces in E* R*^2, times in
    tau.
    """

    def __init__(self, run):
        self.chain = chain = Chain(run)
        load = chain.load
        scales = chain.scales
        self.amplitude = load.largest / scales.force
        self.duration = load.lasts / scales.time
        self.impulse = self.amplitude * self.duration
        self.peak = chain.of_contacts("peak_force")[chain.passed - 1] / scales.force
        self.reduced, self.reduced_peak = (
            self.amplitude / self.impulse**1.2,
            self.peak / self.impulse**1.2,
        )
        # contact from 1, at which waves are counted
        self.contact = round(0.35 * chain.force.shape[1])
        self.signal = chain.force[:, self.contact - 1]
        places = maxima(self.signal)
        self.first_peak, self.waves = (
            chain.time[places[0]],
            self.signal[places] / self.signal[places[0]],
        )
        self.second = self.waves[1:].max(initial=0.0)


def groups(pulses, key, least=3):
    """Groups of pulses of equal amplitude or impulse (to three digits), in rising order, each group
    in order of duration.
    """
    ordered = sorted(
        pulses, key=lambda pulse: (float(f"{getattr(pulse, key):.3g}"), pulse.duration)
    )
    found = [
        list(group) for _, group in groupby(ordered, key=lambda pulse: f"{getattr(pulse, key):.3g}")
    ]
    return [group for group in found if len(group) >= least]
