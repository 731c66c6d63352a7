"""Tapered chains: the energy that reaches the last bead.

The chains have 20 beads, whose diameters decrease by the fraction q from bead to bead. The impact
at 1 m/s is on the first bead, of 10 mm; the last bead is free. Doney and Sen assumed hard spheres
that collide one after another: each bead then passes on the fraction 4 e^3/(1 + e^3)^2 of the
energy, with e = 1 - q. Melo and others measured that the front of the wave falls in this way (q =
5.60 and 8.27 %).
"""

import numpy as np
from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import Chain

HARD = "Doney and Sen 2005, hard spheres"
MEASURED = "Melo et al. 2006, abstract"
NEWS = "UB Reporter 38 (19)"
# beads between which the front has developed its shape and has not reached the end
FIRST = 6
LAST = 17
SOURCE = (
    "In the source hard spheres describe the measured front well, and better with a small "
    "loss. Our front falls faster."
)
SLOW = "The remaining energy stays in beads that continue to move slowly."
LEFT = (
    "A wave in a Hertzian chain extends over about five beads. The energy that it leaves "
    "behind does not reach the front again."
)


class Tapered:
    """Taper, energy of the last bead at the end / input, and the decrease of the front from
    bead to bead.
    """

    def __init__(self, run):
        chain = Chain(run)
        diameters = np.full(chain.case.packing.size[0], chain.case.packing.diameter)
        for one in chain.case.replace:
            diameters[np.array(one.index) - 1] = one.diameter
        self.taper = round(1 - diameters[1] / diameters[0], 4)
        energy = diameters**3 * chain.velocity**2 / diameters[0] ** 3 / chain.load.velocity**2
        self.last = energy[-1, -1]
        fronts = energy.max(axis=0)
        beads = np.arange(FIRST, LAST)
        self.front = np.exp(np.polyfit(beads, np.log(fronts[beads - 1]), 1)[0])
        ratio = (1 - self.taper) ** 3
        self.hard = 4 * ratio / (1 + ratio) ** 2
        self.hard_last = self.hard ** (len(diameters) - 1)


def measured(runs):
    return sorted(map(Tapered, runs), key=lambda chain: chain.taper)


def rows(runs):
    chains = measured(runs)
    for chain in chains:
        at = f"q = {100 * chain.taper:g} %"
        yield gw.Row(
            f"Energy of the last bead / input, {at}",
            "",
            ours=chain.last,
            theory=chain.hard_last,
            where=HARD,
            remark=LEFT if chain.taper else SLOW,
        )
        where = MEASURED if chain.taper in (0.056, 0.0827) else HARD
        remark = SOURCE if where == MEASURED else ""
        yield gw.Row(
            f"Kinetic energy of the front from bead to bead, {at}",
            "",
            ours=chain.front,
            theory=chain.hard,
            where=where,
            remark=remark,
        )
    most = chains[-1]
    yield gw.Row(
        f"Fraction of the input that does not reach the last bead, {100 * most.taper:g} %",
        "%",
        80,
        100 * (1 - most.last),
        NEWS,
        "According to the source the fraction is well above 80 %; it states neither the taper "
        "nor the length of the chain. Our chain has no dissipation.",
        bound=True,
    )


def pictures(runs):
    chains = measured(runs)
    taper, last, hard, front, hard_front = np.array(
        [(100 * c.taper, c.last, c.hard_last, c.front, c.hard) for c in chains]
    ).T
    figure = Figure((6.8, 2.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.plot(taper, hard, "0.5", label="hard spheres")
    left.plot(taper, last, "oC0", markersize=4, label="simulation")
    right.plot(taper, hard_front, "0.5")
    right.plot(taper, front, "oC0", markersize=4)
    left.set(xlabel="Taper q (%)", ylabel="Energy of the last bead / input", ylim=(0, None))
    right.set(xlabel="Taper q (%)", ylabel="Energy of the front, next bead / this bead")
    left.legend()
    caption = (
        "Energy of the last of 20 beads, and decrease of the kinetic energy of the front from "
        "bead to bead, against the taper. Marks lie below the grey line because a wave over "
        "several beads leaves more energy behind than hard spheres do"
    )
    data = {"taper_percent": taper, "last_over_input": last, "hard_last_over_input": hard}
    yield gw.Picture(
        "tapered_chain",
        caption,
        figure,
        data | {"front_ratio": front, "hard_front_ratio": hard_front},
    )
