"""Rebound of a sphere from a rigid plane with partial slip, by an integration that shares no code
with the program.

The contact is a row of springs along the diameter of its circle (method of dimensionality
reduction, V. L. Popov and M. Hess, 2015): it gives Hertz's law, and the partial slip of Mindlin and
Deresiewicz under any history of both forces (J. Jaeger, 1993), without the shear that normal
loading of dissimilar bodies causes. Each spring sticks where it comes into contact, and slips if
its force exceeds the coefficient of friction times its pressure; the contact slides if all springs
slip.
"""

import math

import numpy as np

import granwave as gw

# steps of a contact time and of the reach: spins change by less than 0.5 % if both are doubled
STEPS = 2000
SPRINGS = 400


class Rebound:
    """Impact of a run's sphere on the plane or on a second sphere: velocities and spin about y,
    before and after.
    """

    def __init__(self, run):
        self.run = run
        self.case = run.case
        self.radius = run.case.packing.diameter / 2
        self.normal = run.case.load.velocity
        self.across = 0.0
        self.spin = run.case.load.spin[1]
        before, after = run.fields.velocity.values[[0, -1], 0]
        self.normal = before[2]
        self.across = before[0]
        self.normal_after = -after[2]
        self.across_after = after[0]
        self.spin_after = (
            self.spin + 2.5 * (self.across_after - self.across) / self.radius
        )  # angular momentum

    @property
    def surface(self):
        """Velocity of the contact point along the plane, before and after the impact, m/s."""
        pairs = ((self.across, self.spin), (self.across_after, self.spin_after))
        return np.array([across + self.radius * spin for across, spin in pairs])

    def with_partial_slip(self):
        """The same impact computed with the row of springs: velocity away from the plane, along it,
        and spin afterwards.
        """
        loss = gw.measures.Chain(self.run).loss
        motion = self.normal, self.across, self.spin
        return rebound(
            self.case.material,
            self.radius,
            self.case.contact.friction,
            loss[1] if loss else 0.0,
            *motion,
        )


def rebound(material, radius, friction, dashpot, normal, across, spin):
    """Velocity away from the plane and along it, m/s, and spin, rad/s, of a sphere after its
    impact.
    """
    young = material.youngs_modulus
    poisson = material.poisson_ratio
    stiff = young / (1 - poisson**2)
    shear = 2 * young / ((1 + poisson) * (2 - poisson))  # 4 G / (2 - nu)
    mass = material.density * 4 / 3 * math.pi * radius**3
    hertz = 4 / 3 * stiff * math.sqrt(radius)
    deepest = (1.25 * mass * normal**2 / hertz) ** 0.4
    step = 3 * deepest / abs(normal) / STEPS
    width = 1.05 * math.sqrt(radius * deepest) / SPRINGS
    profile = ((np.arange(SPRINGS) + 0.5) * width) ** 2 / radius
    stretch = np.zeros(SPRINGS)
    overlap = 0.0
    lever = radius

    def pressing(overlap, speed):
        viscous = dashpot * math.sqrt(mass * hertz) * max(overlap, 0.0) ** 0.25 * speed
        return max(0.0, hertz * max(overlap, 0.0) ** 1.5 + viscous)

    while overlap >= 0:
        half = normal - 0.5 * step * pressing(overlap, normal) / mass
        force = pressing(overlap + 0.5 * step * normal, half)
        if force == 0.0 and normal < 0:
            break
        normal = normal - step * force / mass
        overlap = overlap + step * half
        pressed = np.maximum(overlap - profile, 0.0)
        share = (
            force / (2 * stiff * width * pressed.sum()) if pressed.any() else 0.0
        )  # fraction of the elastic pressure
        most = friction * share * stiff / shear * pressed
        stretch = np.clip(stretch + step * (across + lever * spin), -most, most)
        pull = -2 * shear * width * stretch.sum() * step
        across = across + pull / mass
        spin = spin + 2.5 * pull / (mass * radius)
    return -normal, across, spin
