"""Damping in contacts: restitution and decay of waves.

Two equal elastic spheres collide, and a wave travels along an elastic chain. There are three kinds
of damping: a relaxation time, the relaxation time that gives a restitution at a velocity, and
Tsuji's dashpot. If the largest force F of a wave falls slowly, the wave has at each contact the
shape of the solitary wave of force F, with a duration proportional to F^(-1/6) and an energy
proportional to F^(5/3). With a relaxation time, F^(-1/6) therefore rises linearly along the chain;
with a dashpot, ln F falls linearly.
"""

import math

import numpy as np
from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import Chain

KINDS = ("time 0.3 µs", "restitution 0.9 at 1 m/s", "dashpot of restitution 0.9")
SERIES = (
    1.0,
    -1.153449,
    0.798267,
    0.266666,
)  # coefficients of b^0, b, b^2, b^(5/2): Schwager and Poeschel, Phys. Rev. E 78 (2008)
# first contact at which a wave has its final shape; contacts at the end of a chain that are omitted
FIRST = 8
END = 6


class Wave:
    """Largest force of each contact divided by the first of these forces, and the decay law of its
    kind of damping.
    """

    def __init__(self, chain):
        peaks = chain.force.max(axis=0)
        timed = chain.loss[0] == "time"
        self.contact = np.arange(FIRST, len(peaks) - END)
        self.law = "F^(-1/6)" if timed else "ln F"
        self.force = peaks[self.contact] / peaks[FIRST]
        scaled = self.force ** (-1 / 6) if timed else np.log(self.force)
        slope, start = np.polyfit(self.contact, scaled, 1)
        self.misfit = np.abs(start + slope * self.contact - scaled).max() / np.ptp(scaled)
        fall = slope * (self.contact - FIRST)
        self.fitted = (1 + fall) ** -6.0 if timed else np.exp(fall)


def restitution(chain):
    """Restitution from the series for viscoelastic spheres, or for a dashpot from an integrated
    collision.
    """
    (kind, size), law, mass, speed = chain.loss, chain.law, chain.mass / 2, chain.load.velocity
    if kind == "dashpot":
        return law.collide(mass, speed, loss_dashpot=size, steps=4000)["restitution"]
    constant = 4 / 3 * law.effective_modulus * math.sqrt(law.effective_radius)
    b = 1.5 * size * (constant / mass) ** 0.4 * speed**0.2
    return sum(c * b**power for c, power in zip(SERIES, (0, 1, 2, 2.5), strict=True))


def measured(runs):
    """Velocities, restitutions and values of the formula, (n, 3) in order of rising velocity, and
    the wave, for each kind of damping.
    """
    found = {}
    for kind, name in zip(KINDS, ("time", "restitution", "dashpot"), strict=True):
        alike = [Chain(run) for run in runs if getattr(run.case.contact.loss, name) is not None]
        pairs = [chain for chain in alike if chain.case.packing.size[-1] == 2]
        (long,) = [chain for chain in alike if chain not in pairs]
        values = [
            (chain.load.velocity, chain.value("restitution"), restitution(chain)) for chain in pairs
        ]
        found[kind] = np.array(sorted(values)), Wave(long)
    return found


def rows(runs):
    verified = {"verification": True}
    for kind, (pairs, wave) in measured(runs).items():
        dashpot = kind.startswith("dashpot")
        by = "collision by Runge and Kutta" if dashpot else "series of viscoelastic spheres"
        # fmt: off
        for speed, ours, theory in pairs[[0, -1]]:
            yield gw.Row(f"Restitution at {speed:g} m/s, {kind}", ours=ours, theory=theory, where=by, **verified)
        if kind.startswith("restitution"):
            (ours,) = pairs[pairs[:, 0] == 1.0, 1]
            yield gw.Row("Restitution at 1 m/s, specified", ours=ours, theory=0.9, where="case", **verified)
        if dashpot:
            yield gw.Row(f"Restitution at the largest / smallest velocity, {kind}",
                         ours=pairs[-1, 1] / pairs[0, 1], theory=1.0, where="similarity", **verified)
        straight = (f"{wave.law} against the number of the contact deviates from a straight line "
                    f"by {100 * wave.misfit:.2g} % of its rise.")
        yield gw.Row(f"Largest force at contact {wave.contact[-1]} / contact {FIRST}, {kind}",
            ours=wave.force[-1],
                     remark=straight)
        # fmt: on


def pictures(runs):
    figure = Figure((6.8, 3.0), layout="constrained")
    data = {}
    left, right = figure.subplots(1, 2)
    for (kind, (pairs, wave)), style in zip(
        measured(runs).items(), ("C0o", "C1s", "C2^"), strict=True
    ):
        speed, ours, theory = pairs.T
        left.semilogx(speed, theory, "0.5", linewidth=0.9)
        left.semilogx(speed, ours, style, markersize=4, label=kind)
        right.semilogy(wave.contact, wave.fitted, "0.5", linewidth=0.9)
        right.semilogy(wave.contact, wave.force, style, markersize=4)
        name = kind.split()[0]
        data |= {
            f"{name}_velocity_m_s": speed,
            f"{name}_restitution": ours,
            f"{name}_theory_restitution": theory,
        }
        data |= {f"{name}_contact": wave.contact, f"{name}_force_over_first": wave.force}
        data[f"{name}_theory_force_over_first"] = wave.fitted
    left.set(xlabel="Velocity (m/s)", ylabel="Restitution")
    right.set(xlabel="Contact", ylabel="Largest force / force at the first contact")
    figure.legend(loc="outside upper center", ncols=3, fontsize=7)
    caption = (
        "Restitution against velocity, and largest force along chains, by kind of damping; marks "
        "on the grey lines confirm the theory. Only a dashpot dissipates the same fraction at "
        "every velocity"
    )
    yield gw.Picture("losses", caption, figure, data)
