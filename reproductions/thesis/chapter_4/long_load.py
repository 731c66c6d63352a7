"""Long loading of an elastic chain, 40 N.

A constant force of 40 N acts on the first of 510 elastic beads for 10 ms. The peak force is at the
last contact that the front has passed. The speed of the front is taken at half the force, over the
last nine tenths of its path. The plateau is the first quarter of the path.
"""

import math

import numpy as np
from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import Chain, arrival
from granwave.theory import discrete_speed

PRINTED = f"The printed speed is too large by the factor 10^(1/6) = {10 ** (1 / 6):.4f}. "


class Front:
    """The front, and the plateau behind it: speed between c_l = D sqrt(A/(m alpha)) (4.16),
    sqrt(10/9) c_l (4.12).
    """

    def __init__(self, run):
        self.chain = chain = Chain(run)
        self.scales = chain.scales
        self.force = chain.load.largest
        self.last = chain.passed
        self.momentum = (
            self.scales.diameter * self.force / chain.mass
        )  # bead velocity times speed (4.9)
        self.lower = self.scales.diameter * math.sqrt(
            self.force / (chain.mass * self.scales.overlap(self.force))
        )
        self.upper = math.sqrt(10 / 9) * self.lower
        numbers = np.arange(self.last // 10, self.last + 1)
        times = [arrival(chain.time, chain.force[:, n - 1], 0.5 * self.force) for n in numbers]
        per_contact = np.polyfit(numbers, times, 1)[0]
        self.speed = self.scales.diameter / per_contact
        front = self.last + (chain.time[-1] - times[-1]) / per_contact
        self.mean_velocity = chain.velocity[-1].sum() / front
        late = slice(-len(chain.time) // 10, None)
        plateau = slice(self.last // 50, self.last // 4)
        self.plateau_force, self.plateau_velocity = (
            array[late, plateau].mean() for array in (chain.force, chain.velocity)
        )
        self.largest = chain.of_contacts("peak_force")
        half = run.energies.index > 0.5 * run.energies.index[-1]
        self.virial = 0.8 * run.energies.kinetic[half].mean() / run.energies.elastic[half].mean()


def rows(runs):
    one = Front(runs[0])
    s = one.scales
    peak = one.largest[one.last - 1]
    bound = (
        "The theory is the force whose speed by Nesterenko's formula is the bound, with the "
        "stated constants."
    )
    thesis = {"where": "thesis 4.1.3"}
    faster = 100 * (discrete_speed() - 1)
    # fmt: off
    return [
        gw.Row("Peak force", "N", 92.7, peak, remark=f"The peak is at contact {one.last} and still "
                                                     "rises slowly.", **thesis),
        gw.Row("Lower bound of the peak force", "N", 78.15, theory=s.force_at_speed(one.lower), remark=bound, **thesis),
        gw.Row("Upper bound of the peak force", "N", 107.2, theory=s.force_at_speed(one.upper), remark=bound, **thesis),
        gw.Row("Lower bound of the speed (4.16)", "m/s", 668.0, theory=one.lower, remark=PRINTED, **thesis),
        gw.Row("Upper bound of the speed (4.12)", "m/s", 704.0, theory=one.upper, remark=PRINTED, **thesis),
        gw.Row("Speed of the front", "m/s", 687.2, one.speed, theory=s.nesterenko(peak), **thesis,
               remark=f"{PRINTED}Theory: Nesterenko's speed for our peak force; the discrete wave "
                      f"is {faster:.1f} % faster."),
        gw.Row("Force of the plateau", "N", ours=one.plateau_force, theory=one.force, where="balance of forces",
               verification=True),
        gw.Row("Bead velocity of the plateau", "m/s", ours=one.plateau_velocity, theory=one.momentum / one.lower,
               where="thesis (4.9)", remark="Theory: (4.9) with the lower bound of the speed, for "
                                            f"which the virial holds; the upper bound gives {one.momentum / one.upper:.4g} "
                                            "m/s."),
        gw.Row("Mean velocity of all beads behind the front", "m/s", ours=one.mean_velocity,
               theory=one.momentum / one.speed, where="thesis (4.9)",
               remark="Theory: (4.9) with the speed of the front, which follows from the balance "
                      "of momentum."),
        gw.Row("Virial 4 K / 5 P of the chain", ours=one.virial, theory=1.0, where="thesis (4.14)",
               remark="The value is an average over the second half of the run."),
    ]
    # fmt: on


def pictures(runs):
    one = Front(runs[0])
    chain = one.chain
    last = one.last
    contact = np.arange(1, len(chain.force[-1]) + 1)
    bead = np.arange(1, len(chain.velocity[-1]) + 1)
    figure = Figure((3.5, 4.2), layout="constrained")
    top, bottom = figure.subplots(2, sharex=True)
    top.plot(contact, chain.force[-1], linewidth=0.7, label=f"at {1e3 * chain.time[-1]:.3g} ms")
    top.plot(contact[:last], one.largest[:last], label="largest so far")
    for speed, line, name in ((one.lower, "--", "lower bound"), (one.upper, ":", "upper bound")):
        top.axhline(one.scales.force_at_speed(speed), color="0.5", linestyle=line, label=name)
    top.set(ylabel="Contact force (N)", ylim=(0, 180))
    top.legend(ncols=2, loc="upper left")
    bottom.plot(bead, chain.velocity[-1], linewidth=0.7)
    bottom.set(
        xlabel="Contact, bead", ylabel="Bead velocity (m/s)", ylim=(0, None), xlim=(0, len(bead))
    )
    data = {
        "contact": contact,
        "force_N": chain.force[-1],
        "largest_force_N": one.largest,
        "bead": bead,
    }
    caption = (
        "Force and bead velocity along the chain under a constant force, at the end of the run "
        f"(thesis Fig. 4.2). The largest force approaches {one.largest[last - 1]:.3g} N, between "
        "the bounds; far behind the front both become constant"
    )
    yield gw.Picture(
        "elastic_long_load", caption, figure, data | {"velocity_m_s": chain.velocity[-1]}
    )
