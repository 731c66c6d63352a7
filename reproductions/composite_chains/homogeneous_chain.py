"""Homogeneous chain from the paper on composite chains.

The chain has 15 elastic spheres of 4.76 mm; the first sphere has an initial velocity of 0.626 m/s.
The speed is 5 diameters divided by the time between the peaks at contacts 5 and 10; the force is
the peak at contact 10. The source uses Nesterenko's formula as theory; here the theory is the
travelling wave of the discrete chain.
"""

import numpy as np
from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import Chain, power_law
from granwave.theory import discrete_speed

CONTACTS = EARLY, LATE = 4, 9  # contacts from 0: of beads 5 and 6, 10 and 11, as in the source
# the source's best model; from where on the mesh is the same; m
CHOSEN = 10
FIRST_PENALTY = 5
ELEMENT = 25e-6
# fmt: off
# finite elements: name, force (N), speed (m/s), printed error of the speed (%), computing time (s)
MODELS = [
    ("mesh 0.2 to 0.4 mm", 7.92, 590, 20.00, 564), ("mesh 0.1 to 0.2 mm", 21.71, 569, 2.14, 1129),
    ("mesh 0.05 to 0.1 mm", 24.55, 566, 4.63, 1876), ("mesh 0.025 to 0.05 mm", 26.62, 586, 2.58, 4140),
    ("mesh 0.01 to 0.02 mm", 27.17, 599, 0.76, 12063), ("penalty 1.1", 26.71, 587, 2.47, np.nan),
    ("penalty 1.2", 26.77, 590, 2.01, np.nan), ("penalty 1.3", 26.81, 592, 1.70, np.nan),
    ("penalty 1.4", 26.86, 592, 1.57, np.nan), ("penalty 1.5, constant solver", 27.36, 590, 2.36, np.nan),
    ("penalty 1.5, automatic solver", 27.22, 595, 0.40, np.nan),
]
# fmt: on
NAMES = [model[0] for model in MODELS]
FORCE, SPEED, PRINTED, TOOK = np.array([model[1:] for model in MODELS]).T


class Wave:
    """Force and speed of the wave, theoretical values for its impulse, and the contact of beads 5
    and 6.
    """

    def __init__(self, run):
        self.chain = chain = Chain(run)
        (early, _), (late, self.force) = (chain.first_peak(contact) for contact in CONTACTS)
        self.speed = (LATE - EARLY) * chain.scales.diameter / (late - early)
        self.expected = 0.719 * chain.scales.impulse_force(chain.impulse)
        self.gap = np.diff(chain.array("chain/displacement"), axis=1)
        pressed = chain.force[:, EARLY] > 0.01 * chain.force[:, EARLY].max()
        self.approach = -self.gap[pressed, EARLY]
        self.pressed = chain.force[pressed, EARLY]
        self.law = power_law(self.approach, self.pressed)
        self.radius = chain.law.contact_radius(chain.scales.overlap(np.array([self.force])))[0]

    def discrete(self, force):
        """Speed of the wave with this force in the discrete chain, m/s."""
        return discrete_speed() * self.chain.scales.nesterenko(force)

    def errors(self, force, speed):
        """Errors of a force relative to the expected force, and of a speed relative to the wave
        with this force; per cent.
        """
        return 100 * abs(force / self.expected - 1), 100 * abs(speed / self.discrete(force) - 1)

    def parting(self, contact):
        """Time at which the force of the first wave at a contact ends, s."""
        force = self.chain.force[:, contact]
        return self.chain.time[force.argmax() :][force[force.argmax() :] <= 0][0]


def rows(runs):
    one = Wave(runs[0])
    nesterenko = one.chain.scales.nesterenko
    where = {"where": "composite chain, Tables 2 and 3"}
    coarse = ["This mesh is too coarse for the contact."] + [""] * (len(MODELS) - 1)
    over = [
        f"{abs(x):.1f} % {'below' if x < 0 else 'above'}"
        for x in 100 * (SPEED / one.discrete(FORCE) - 1)
    ]
    printed = 100 * abs(SPEED[CHOSEN] / nesterenko(FORCE[CHOSEN]) - 1)
    of_force, of_speed = one.errors(FORCE, SPEED)
    our_force, our_speed = one.errors(one.force, one.speed)
    late = (
        "The printed time is ten times too large: at the printed speed the wave reaches the "
        "end of the chain after 0.12 ms."
    )
    # fmt: off
    for name, force, remark in zip(NAMES, FORCE, coarse, strict=True):
        yield gw.Row(f"Peak force; source: {name}", "N", force, one.force, theory=one.expected, remark=remark, **where)
    for name, speed, much in zip(NAMES, SPEED, over, strict=True):
        yield gw.Row(f"Wave speed; source: {name}", "m/s", speed, one.speed, theory=one.discrete(one.force),
                     remark=f"Their speed is {much} the speed of a discrete wave with their "
                            "force.", **where)
    yield gw.Row("Error of the speed relative to Nesterenko's formula at the computed force, best "
                 "model", "%", PRINTED[CHOSEN],
                 100 * abs(one.speed / nesterenko(one.force) - 1), theory=100 * (discrete_speed() - 1),
                 remark=f"The source value is printed; its force and speed give {printed:.2f}. Our "
                        "value is the error of the formula, which treats the chain as a "
                        "continuum: the discrete wave is faster.", **where)
    yield gw.Row("Exponent of force against approach, beads 5 and 6", "", 1.554, one.law.exponent, theory=1.5,
                 where="composite chain, Fig. 5",
                 remark=f"The contact radius spans only {one.radius / ELEMENT:.1f} elements of "
                        "0.025 mm. Such elements give 1.43 to 1.62, depending on their penalty "
                        "and the range of the fit. Resolved elements give 1.503, since "
                        "half-spheres are stiffer than half-spaces "
                        "(tests/extensions/continuum/test_coarse_contact.py).")
    for contact, source, remark in ((EARLY, 0.6, late), (LATE, None, "")):
        yield gw.Row(f"Beads {contact + 1} and {contact + 2} separate",
                     "ms", source, 1e3 * one.parting(contact),
                     where="composite chain, Fig. 4", remark=remark)
    yield gw.Row("Error of the speed relative to the wave of the discrete chain at the computed "
                 "force",
        "%", ours=our_speed,
                 theory=0.0, remark=f"The source prints errors of {PRINTED.min():.2f} to "
                                    f"{PRINTED.max():.0f} "
                                    "% for the speeds of its 11 models. The recomputed errors are "
                                    f"{of_speed.min():.1f} to {of_speed.max():.0f} %.", **where)
    yield gw.Row("Error of the force relative to thesis 4.5",
                 "%", ours=our_force, theory=0.0, remark=(
        f"The recomputed errors of the 11 models of the source are {of_force.min():.1f} to {of_force.max():.0f} "
        "%."), **where)
    # fmt: on


def pictures(runs):
    one = Wave(runs[0])
    time = one.chain.time
    force = one.chain.force[:, CONTACTS]
    gap = one.gap[:, CONTACTS]
    pairs = [f"beads {contact + 1} and {contact + 2}" for contact in CONTACTS]
    figure = Figure((7, 2.6), layout="constrained")
    left, middle, right = figure.subplots(1, 3)
    left.plot(1e6 * time, force, label=pairs)
    left.set(
        xlabel="Time (µs)",
        ylabel="Contact force (N)",
        xlim=(0, 1e6 * time[-1]),
        ylim=(0, 1.35 * force.max()),
    )
    left.legend()
    middle.plot(1e6 * time, 1e6 * gap, label=pairs)
    middle.axhline(0, color="0.6", linewidth=0.6)
    middle.set(xlabel="Time (µs)", ylabel="Gap (µm)", xlim=(0, 1e6 * time[-1]))
    right.loglog(1e6 * one.approach, one.pressed, ".", label=pairs[0])
    fine = np.geomspace(one.approach.min(), one.approach.max(), 50)
    right.loglog(1e6 * fine, one.law(fine), label=f"power {one.law.exponent:.3f}")
    right.set(xlabel="Approach (µm)", ylabel="Contact force (N)")
    right.set_xticks([0.5, 1, 2], ["0.5", "1", "2"])
    right.set_xticks([], minor=True)
    right.legend()
    caption = (
        "Force and gap of two contacts against time (source Figs 3, 4): the same pulse arrives "
        "later at the second. Right: force against approach, with the fitted power (source Fig. "
        "5); Hertz's law has the power 3/2"
    )
    data = {f"contact_{k + 1}_N": force[:, n] for n, k in enumerate(CONTACTS)}
    data |= {f"gap_{k + 1}_m": gap[:, n] for n, k in enumerate(CONTACTS)}
    data |= {"time_s": time, "approach_m": one.approach, "force_N": one.pressed}
    yield gw.Picture("homogeneous_contact", caption, figure, data)

    theirs = one.errors(FORCE, SPEED)
    ours = one.errors(one.force, one.speed)
    axes = Figure((3.5, 2.7), layout="constrained").subplots()
    for mark, part, name in (
        ("s-C1", slice(FIRST_PENALTY), "source, mesh made finer"),
        ("^C2", slice(FIRST_PENALTY, None), "source, penalty and solver"),
    ):
        axes.loglog(theirs[0][part], theirs[1][part], mark, markersize=4, label=name)
    axes.loglog(*ours, "oC0", label="ours")
    axes.set(xlabel="Error of the peak force (%)", ylabel="Error of the wave speed (%)")
    axes.legend(loc="upper left")
    table = {
        "force_N": [*FORCE, one.force],
        "speed_m_s": [*SPEED, one.speed],
        "took_s": [*TOOK, np.nan],
    }
    table |= {"model": [*NAMES, "ours"], "printed_speed_error_percent": [*PRINTED, np.nan]}
    for n, what in enumerate(("force", "speed")):
        table[f"{what}_error_percent"] = [*theirs[n], ours[n]]
    caption = (
        "Errors of the wave speed and of the peak force relative to the discrete chain: "
        f"finite elements of the source (Tables 2 and 3) and ours, with errors of {ours[0]:.2g} % "
        f"in force and {ours[1]:.2g} % in speed"
    )
    yield gw.Picture("homogeneous_errors", caption, axes.figure, table)
