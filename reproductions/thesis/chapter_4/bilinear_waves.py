"""The leading wave of a bilinear chain after an impulse, and the source's model of it (thesis 4.23
to 4.31).
"""

import math

import numpy as np
from bilinear_chain import BilinearChain
from scipy.optimize import brentq

from granwave.measures import at_time

PRINTED = (
    0.482,
    0.721,
    0.199,
    0.599,
)  # (4.19) to (4.22): v_m, F_p, F_2, and the factor of sqrt(1 - beta) in v_t
CONTACTS = 12  # contacts of the leading wave
# factor of the leading peak of a contact, above which a later wave has a larger force
OVERTAKEN = 1.005


class LeadingWave:
    """The wave under the assumption of self-similarity: at every contact, velocities of F/sqrt(k m)
    follow from the peak force F.
    """

    def __init__(self, beta):
        moving, peak, second, trailing = PRINTED
        self.residual = (moving - trailing * math.sqrt(1 - beta)) / peak
        self.beta = beta
        lost = beta + self.residual**2
        energy = 1 + (second / peak) ** 2 + 2 * (moving / peak) ** 2
        self.ratio = math.sqrt(
            1 - lost / energy
        )  # ratio of peak forces from contact to contact: energy balance (4.26)
        self.decay = 1 - self.ratio  # the balance as a differential equation (4.28)
        self.transition = brentq(lambda n: self.secondary(n) - self.printed(n), 1.0, 200.0)

    def printed(self, contact):
        """Peak force divided by the peak force of contact 1 (4.28)."""
        return np.exp(-self.decay * (contact - 1))

    def discrete(self, contact):
        """Peak force divided by the peak force of contact 1, contact by contact from the energy
        balance.
        """
        return self.ratio ** (contact - 1)

    def secondary(self, contact):
        """Peak force of collisions behind the wave divided by the force of contact 1: sqrt(k_u m/2)
        omega (F_1
        - F_(i+1)) (4.31).
        """
        return math.sqrt(0.5 / (1 - self.beta)) * self.residual * (1 - self.printed(contact + 1))


class ShortPulse:
    """Two chains with the same beta after an impulse: one recorded in short steps, and one followed
    over a long distance.
    """

    def __init__(self, near, far):
        self.near = near
        self.far = far
        self.beta = near.beta
        self.largest = far.largest
        self.model = LeadingWave(self.beta)
        self.velocity_unit = near.impulse / near.mass
        self.force_unit = near.impulse * near.rate
        crests, heights = np.array([near.first_peak(contact) for contact in range(CONTACTS)]).T
        # the parabola overshoots where unloading is much steeper than loading; peaks of every step
        # limit it
        self.leading = np.minimum(heights, near.largest[:CONTACTS])
        self.transition = int(np.argmax(self.largest[:CONTACTS] > OVERTAKEN * self.leading)) + 1
        free = (near.time > crests[0]) & (near.force[:, 0] == 0)
        # velocity of bead 1 after the wave has left it
        self.residual = near.velocity[free.argmax(), 0]

    def excess(self, contact):
        """Excess of the largest force at a contact (from 1) over the leading peak, per cent."""
        return 100 * (self.largest[contact - 1] / self.leading[contact - 1] - 1)

    def at_peak(self, contact):
        """Forces and velocities when the beads of a contact (from 1) first have equal velocities
        after touching.
        """
        closing = self.near.velocity[:, contact - 1] - self.near.velocity[:, contact]
        k = np.flatnonzero((closing <= 0) & (self.near.force[:, contact - 1] > 0))[0]
        time = np.interp(0.0, -closing[k - 1 : k + 1], self.near.time[k - 1 : k + 1])
        return (
            at_time(time, self.near.time, array) for array in (self.near.force, self.near.velocity)
        )


def measured(runs):
    """Pulses by beta, each with the short and the long chain."""
    chains = sorted(map(BilinearChain, runs), key=lambda chain: (chain.beta, len(chain.largest)))
    return [ShortPulse(near, far) for near, far in zip(chains[::2], chains[1::2], strict=True)]
