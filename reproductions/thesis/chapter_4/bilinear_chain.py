"""Chains with the bilinear law, and the linear chain in closed form.

Loading has the slope k; unloading and reloading have the slope k_u = k/(1 - beta), so that a
contact dissipates beta F^2/2k. In units of I/m and sqrt(k/m) I, beta is the only parameter of the
chain.
"""

import math

import numpy as np
from scipy.optimize import brentq
from scipy.special import jv

from granwave.measures import Chain

# labels of the figures
FORCE = r"Force $F/E^*R^{*2}$"
PEAK_FORCE = r"Peak force $F/E^*R^{*2}$"
VELOCITY = r"Velocity $v\,\tau/R^*$"


class BilinearChain(Chain):
    """A chain, and the slope of its contacts."""

    def __init__(self, run):
        super().__init__(run)
        overlap = 1e-3 * self.law.effective_radius
        self.stiffness = self.law.loading_force(np.array([overlap]))[0] / overlap
        self.beta = run.case.contact.beta
        self.rate = math.sqrt(
            self.stiffness / self.mass
        )  # contacts that a wave of loading passes in a second
        # speed of loading waves over the speed of unloading waves
        self.share = math.sqrt(1 - self.beta)
        self.largest = self.of_contacts("peak_force")


def bead_velocity(bead, phase):
    """Velocity of a bead (from 1) of a half-infinite linear chain after an impulse I, in I/m, at
    the phase sqrt(k/m) t.
    """
    return jv(2 * bead - 2, 2 * phase) + jv(2 * bead, 2 * phase)


def contact_force(contact, phase):
    """Force of a contact (from 1) of that chain, in sqrt(k/m) I."""
    return jv(2 * contact - 1, 2 * phase) + jv(2 * contact + 1, 2 * phase)


def first_coefficients():
    """v_m, F_p and F_2 of (4.19) to (4.21): at the peak of contact 1, when beads 1 and 2 have the
    same velocity.
    """
    phase = brentq(lambda s: bead_velocity(1, s) - bead_velocity(2, s), 0.5, 2.0)
    return bead_velocity(1, phase), contact_force(1, phase), contact_force(2, phase)
