"""Restitution of metal spheres against velocity, compared with formulas.

Two equal brass spheres collide at 0.01 to 100 m/s, with the elasto-plastic law and with the law of
C. Thornton (J. Appl. Mech. 64 (1997) 383: elastic, perfectly plastic). Thornton's formula is the
integral of his law, in which contacts yield and flow at one pressure (a yield factor of 1). With a
factor of 1.6, as in the thesis, our law yields at 1.6 times the strength and flows at the strength;
the restitution is then smaller. K. L. Johnson (Contact Mechanics, 1985, 11.3) takes a constant
dynamic pressure of 3 times the yield strength and elastic unloading after Hertz; then restitution
falls with the power -1/4 of the velocity. His formula is not valid for contacts that yield only
slightly. A yield strength that grows with the strain rate (G. R. Johnson and W. H. Cook 1983, C =
0.009 of cartridge brass) gives a larger restitution at high velocities. By his formula the
restitution grows as the power 5/8 of the strength at the rate 0.2 d(a/R)/dt of the two spheres,
with his largest contact radius and the velocity of impact. Published fits to finite elements and
measurements are omitted, because their numbers were not available.
"""

import math

import numpy as np
from matplotlib.figure import Figure

import granwave as gw

JOHNSON = "Johnson 1985, 11.3"
THORNTON = "Thornton 1997"
LAWS = ("elastoplastic", "thornton", "thornton of 1997", "elastoplastic with a rate")
THESIS = (
    "The contact yields at 1.6 times the strength and flows at the strength, so that it "
    "unloads more softly than in the paper."
)
SOFTER = (
    "The pressure rises slowly from 1.6 to 2.5 times the strength; Johnson's pressure is 3 "
    "times the strength from the start."
)
DEEP = "The pressure is not constant, and the contact unloads with its own exponent."


def name_of(case):
    """Name of the law of a case."""
    if case.material.rate_sensitivity:
        return LAWS[3]
    return LAWS[2] if case.contact.yield_factor == 1 else case.contact.law


class Curve:
    """Restitution against velocity, for a contact law and by the formulas."""

    def __init__(self, law, runs):
        chosen = sorted(
            (run.case.load.velocity, run["restitution"]) for run in runs if name_of(run.case) == law
        )
        self.law, (self.velocity, self.restitution) = law, np.array(chosen).T
        case = next(run.case for run in runs if run.case.contact.law == "elastoplastic")
        self.material = case.material
        self.radius = case.packing.diameter / 4
        self.mass = case.sphere_mass / 2
        self.modulus = self.material.youngs_modulus / (2 * (1 - self.material.poisson_ratio**2))

    def at_yield(self):
        """Velocity at which Hertz's pressure reaches 1.6 times the yield strength, m/s."""
        pressure = 1.6 * self.material.yield_strength
        return 3.194 * math.sqrt(pressure**5 * self.radius**3 / (self.modulus**4 * self.mass))

    def thornton(self):
        """Thornton's formula; 1 below the velocity of yield."""
        ratio = np.minimum(self.at_yield() / self.velocity, 1.0)
        tail = ratio / (ratio + 2 * np.sqrt(1.2 - 0.2 * ratio**2))
        return np.sqrt(1.2 * math.sqrt(3) * (1 - ratio**2 / 6) * np.sqrt(tail))

    def johnson(self):
        """Johnson's formula."""
        pressure = 3 * self.material.yield_strength
        energy = 0.5 * self.mass * self.velocity**2 / (pressure * self.radius**3)
        return np.sqrt(0.3 * math.pi**1.25 * 4**0.75 * pressure / self.modulus * energy**-0.25)

    def stronger(self, sensitivity):
        """Factor of the yield strength at the rate of Johnson's largest contact, at least 1."""
        radius = (
            2
            * self.mass
            * self.velocity**2
            * self.radius
            / (math.pi * 3 * self.material.yield_strength)
        ) ** 0.25
        return 1 + sensitivity * np.log(np.maximum(0.1 * self.velocity / radius, 1.0))

    def slope(self, first, last):
        """Power of the velocity in the restitution, between two velocities."""
        within = (self.velocity >= 0.99 * first) & (self.velocity <= 1.01 * last)
        return np.polyfit(np.log(self.velocity[within]), np.log(self.restitution[within]), 1)[0]


def measured(runs):
    return [Curve(law, runs) for law in LAWS]


def rows(runs):
    own, thesis, thornton, fast = measured(runs)
    # fmt: off
    for at in (2, 4, 6, 8, 10, 12):
        yield gw.Row(f"Restitution at {thornton.velocity[at]:.3g} m/s, yield factor 1", ours=thornton.restitution[at],
                     theory=thornton.thornton()[at], where=THORNTON, verification=True)
    for at in (4, 8, 12):
        yield gw.Row(f"Restitution at {thesis.velocity[at]:.3g} m/s, law thornton, yield factor 1.6",
                     theory=thesis.thornton()[at], ours=thesis.restitution[at], where=THORNTON, remark=THESIS)
    for at in (8, 10, 12):
        yield gw.Row(f"Restitution at {own.velocity[at]:.3g} m/s, elasto-plastic law", ours=own.restitution[at],
                     theory=own.johnson()[at], where=JOHNSON, remark=SOFTER)
    sensitivity = max(run.case.material.rate_sensitivity or 0.0 for run in runs)
    for at in (8, 10, 12):
        yield gw.Row(f"Restitution at {own.velocity[at]:.3g} m/s with / without rate-dependent yielding",
                     ours=fast.restitution[at] / own.restitution[at],
                     theory=own.stronger(sensitivity)[at] ** 0.625, where=f"{JOHNSON}, similarity",
                     remark="The largest overlap is reached while the pressure is still rising.")
    for first, last in ((1, 10), (10, 100)):
        for one in (own, thesis, thornton, fast):
            yield gw.Row(f"Exponent of restitution against velocity, {first} to {last} m/s, {one.law}", ours=one.slope(first, last),
                         theory=-0.25, where=f"{JOHNSON}, similarity", remark=DEEP if one in (own, fast) else "")
    # fmt: on


def pictures(runs):
    own, thesis, thornton, fast = measured(runs)
    axes = Figure((4.6, 3.2), layout="constrained").subplots()
    axes.loglog(own.velocity, own.restitution, "C0o-", markersize=4, label="elasto-plastic law")
    axes.loglog(
        fast.velocity,
        fast.restitution,
        "C3--",
        linewidth=0.9,
        label="with a yield strength that grows with the rate",
    )
    axes.loglog(
        thornton.velocity,
        thornton.restitution,
        "C1s",
        markersize=4,
        label="law thornton, yield factor 1",
    )
    axes.loglog(
        thesis.velocity,
        thesis.restitution,
        "C2^",
        markersize=4,
        label="law thornton, yield factor 1.6",
    )
    axes.loglog(
        thornton.velocity, thornton.thornton(), "C1", linewidth=0.9, label="Thornton's formula"
    )
    beyond = own.johnson() <= 1
    axes.loglog(
        own.velocity[beyond], own.johnson()[beyond], "0.5", linewidth=0.9, label="Johnson's formula"
    )
    axes.set(xlabel="Velocity (m/s)", ylabel="Restitution")
    axes.legend(fontsize=8)
    data = {"velocity_m_s": own.velocity, "restitution": own.restitution, "johnson": own.johnson()}
    data |= {"thornton_law": thornton.restitution, "thornton_formula": thornton.thornton()}
    data["thornton_law_factor_1.6"] = thesis.restitution
    data["elastoplastic_law_with_rate"] = fast.restitution
    caption = (
        "Restitution of two brass spheres of 10 mm against velocity. Thornton's law agrees with "
        "his formula if yield and flow have one pressure; the elasto-plastic law approaches the "
        "power -1/4 only beyond 10 m/s"
    )
    yield gw.Picture("", caption, axes.figure, data)
