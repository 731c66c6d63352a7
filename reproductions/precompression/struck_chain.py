"""The wave of an impact on the first bead of a precompressed elastic chain, measured far along the
chain.

In the units of the static state (speeds over c0, forces over F0, velocities over omega alpha0)
the results of all such chains lie on one curve. c0 is the speed of long waves, sqrt(3/2 F0 D^2/(m
alpha0)).
"""

import math

import numpy as np

from granwave.measures import Chain, first_peak, long_wave_speed
from granwave.theory import crest_force, crest_speed, lattice_speed, precompressed_line

WHERE = "composite (3)"
SMALL = 0.05  # F_m/F0 - 1 up to which a pulse is small: the speed of (3) is then within 0.3 % of c0
PRINTED_FACTOR = 0.9314  # factor of c0, (3)
EXACT_FACTOR = math.sqrt(9 / math.pi) * 3 ** (-1 / 3) * 4 ** (-1 / 6)  # factor for the lattice
FIRST_BEAD = 10  # first contact at which the crests of small pulses are followed
DISTURBED = 1e-3  # fraction of the largest added force: the wave has reached the far end
STEADY = 0.01  # fraction by which the crest may decrease while its speed is measured


def solitary_speed(ratio):
    """Speed of the solitary wave divided by c0 by (3), for the continuum, from F_m/F0."""
    eps = ratio ** (2 / 3) - 1
    bracket = 4 / 15 * (3 + 2 * ratio ** (5 / 3) - 5 * ratio ** (2 / 3))
    near = 1 + eps / 12  # the next term; the bracket cancels there
    return np.where(
        eps < 1e-4, near, np.sqrt(np.maximum(bracket, 0)) / np.where(eps < 1e-4, 1, eps)
    )


class Wave:
    """Speed and force of the crest over the second half of the contacts that it passes before the
    wave reaches the far end.
    """

    def __init__(self, run):
        self.chain = chain = Chain(run)
        self.line = precompressed_line(run.case)
        self.static, self.c0, self.velocity = self.line.force, self.line.speed, chain.load.velocity
        self.reduced_velocity = self.velocity / self.line.velocity
        added = chain.force - self.static
        far = np.flatnonzero(np.abs(added[:, -1]) > DISTURBED * added.max())
        self.until = until = slice(int(far[0]) if len(far) else len(chain.time))
        time = chain.time[until]
        crests = np.array([first_peak(time, one, floor=0.5) for one in added[until].T])
        running = (crests[:, 0] < time[-1]) & (np.diff(crests[:, 0], prepend=-1) > 0)
        self.last = int(
            np.argmin(np.append(running, False))
        )  # number of the contact, from 1, that the crest has passed
        self.window = window = slice(self.last // 2, self.last)
        self.middle = (window.start + window.stop) // 2
        when, height = crests[window].T
        self.speed = self.line.spacing / np.polyfit(np.arange(len(when)), when, 1)[0]
        self.added = crests[self.middle, 1]
        self.ratio = 1 + self.added / self.static
        self.steady = height[-1] / height[0] > 1 - STEADY
        self.of_lattice = self.c0 * float(lattice_speed(np.array(self.ratio)))

    @property
    def printed_c0(self):
        """c0 according to (3), m/s."""
        own = self.chain.case.material
        diameter = self.chain.case.packing.diameter
        modulus = own.youngs_modulus / (1 - own.poisson_ratio**2)
        return PRINTED_FACTOR * (4 * modulus**2 * self.static / (diameter**2 * own.density**3)) ** (
            1 / 6
        )

    @property
    def printed(self):
        """Speed of a solitary wave with this crest according to (3), m/s."""
        return self.printed_c0 * float(solitary_speed(np.array(self.ratio)))

    @property
    def long_wave_speed(self):
        """c0 from the crests of the velocities of the beads, whose dispersion in a linear chain is
        known, m/s.
        """
        numbers = np.arange(FIRST_BEAD, self.last)
        chain = self.chain
        until = self.until
        times = [
            first_peak(chain.time[until], chain.velocity[until, n - 1], floor=0.5)[0]
            for n in numbers
        ]
        return long_wave_speed(self.line, numbers, np.array(times))

    @property
    def linear_speed(self):
        """Speed of the crest there if the chain were linear, m/s."""
        return crest_speed(self.line, np.arange(self.window.start, self.window.stop) + 1)

    def linear_height(self, reduced_velocity):
        """F_m/F0 - 1 at that contact if the chain were linear."""
        return 1.5 * reduced_velocity * float(crest_force(np.array([self.middle + 1]))[0])

    @property
    def uncompressed_speed(self):
        """Speed of Nesterenko's wave with the same largest dynamic force, m/s."""
        return self.chain.scales.nesterenko(self.added)
