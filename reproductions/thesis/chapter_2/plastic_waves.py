"""Elasto-plastic chains after a pulse, in the units of the chain, and the two laws of the source
for the peak force.

With the impulse I in units of E* R*^2 tau, the number n of the contact (from 1) and x/R* = 4n,
F/(E* R*^2 I) is a exp(-b (n - 1)) up to contact 7 (2.25), and C/(4n) from there (2.26). The source
prints b as a decay per R*; its figures agree with b only as a decay per contact.
"""

import math
from functools import cached_property
from itertools import groupby

import numpy as np

from granwave.measures import Chain, arrival, power_law

# a, b, C
START = 3.74e-2
DECAY = 0.256
INVERSE = 0.268
SWITCH = 7  # contact: x_t/R* = 28
SWITCHES = (6, 10)  # contacts between which it was seen
SPACING = 4.0  # R* from contact to contact
# factor of the leading peak of a contact, above which a later wave has a larger force
OVERTAKEN = 1.005
HALF = 5  # contacts on either side over which a speed is taken
PLACE = r"Distance $x/R^*$"  # label of the figures


class PlasticWave(Chain):
    """A pulse along a chain, whose contacts are numbered from 1 at the impacted end."""

    def __init__(self, run):
        super().__init__(run)
        scales = self.scales
        load = self.load
        self.reduced = self.impulse / scales.impulse
        self.duration = load.lasts / scales.time
        self.peak_force = self.of_contacts("peak_force")
        self.contacts = min(100, len(self.peak_force) - 2 * HALF)
        self.number, self.largest = (
            np.arange(1.0, self.contacts + 1),
            self.peak_force[: self.contacts],
        )
        self.x, self.unit = SPACING * self.number, scales.force * self.reduced
        self.normalised = self.largest / self.unit
        self.name = f"{load.largest / 1e3:g} kN, {load.lasts * 1e6:.3g} µs"
        self.tag, self.label = (
            f"I {self.reduced:.3g} ({self.name})",
            rf"$\bar I$ = {self.reduced:.3g}",
        )

    @property
    def transition(self):
        """First contact at which a later wave has a larger force than the leading wave."""
        return next(
            n + 1 for n, top in enumerate(self.largest) if top > OVERTAKEN * self.first_peak(n)[1]
        )

    @cached_property
    def leading(self):
        """Peak of the leading wave at each contact, N."""
        return np.array([self.first_peak(n)[1] for n in range(self.contacts)])

    @property
    def merger(self):
        """Contact at which the leading wave stops decreasing, because a trailing wave meets it."""
        return int(np.flatnonzero(np.diff(self.leading) > 0)[0]) + 1

    def pressed_more(self, contact):
        """Largest force of a contact relative to the peak of the leading wave there, minus 1."""
        return self.largest[contact - 1] / self.leading[contact - 1] - 1

    def decay(self, first, last):
        """Decay of the logarithm of the leading wave's peak, per contact."""
        return math.log(self.leading[first - 1] / self.leading[last - 1]) / (last - first)

    def force_power(self, first, last):
        """Exponent of the largest force against the distance."""
        return power_law(self.number[first - 1 : last], self.largest[first - 1 : last])

    def inverse_constant(self):
        """Mean of (x/R*) F/(E* R*^2 I) from contact 10 on."""
        return np.mean(self.x[9:] * self.normalised[9:])

    def speed(self, level=0.01):
        """Contacts, and the speed (contacts/s) of the point at which a fraction of the largest
        force of each contact is first reached.
        """
        pairs = zip(self.force.T, self.peak_force, strict=True)
        time = np.array([arrival(self.time, force, level * top) for force, top in pairs])[
            : self.contacts
        ]
        return self.number[HALF:-HALF], 2 * HALF / (time[2 * HALF :] - time[: -2 * HALF])

    def speed_powers(self, first, last, level=0.01):
        """Exponents of this speed against the distance, and against the largest force (itself a
        power law of the distance).
        """
        number, speed = self.speed(level)
        inside = (number >= first) & (number <= last)
        force = self.force_power(first, last)(number[inside])
        return power_law(number[inside], speed[inside]), power_law(force, speed[inside])


def peak_force(contact):
    """Peak force divided by E* R*^2 I according to the source."""
    return np.where(
        contact <= SWITCH, START * np.exp(-DECAY * (contact - 1)), INVERSE / (SPACING * contact)
    )


def common_decay(waves, last):
    """Constants a and b of one law 2.25 for the leading peaks of several waves.

    Least squares of ln(F/(E* R*^2 I)) against the contact, over contacts 1 to ``last`` of all waves.
    """
    contact = np.tile(np.arange(last), len(waves))
    peaks = np.concatenate([wave.leading[:last] / wave.unit for wave in waves])
    slope, start = np.polyfit(contact, np.log(peaks), 1)
    return math.exp(start), -slope


def groups(runs):
    """Waves by impulse, the largest first, each group by duration."""
    waves = [PlasticWave(run) for run in runs if run.case.contact.law == "elastoplastic"]
    waves.sort(key=lambda wave: (-float(f"{wave.reduced:.3g}"), wave.duration))
    return [list(group) for _, group in groupby(waves, key=lambda wave: f"{wave.reduced:.3g}")]


def usual(group):
    """The wave of a group whose pulse lasts 10 us, a duration that occurs for all impulses."""
    return next(wave for wave in group if math.isclose(wave.load.lasts, 1e-5))
