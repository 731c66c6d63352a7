"""Confined chains with yielding: two equal pulses.

This study goes beyond the source, whose chains are elastic: two equal force pulses act on a bead.
The first pulse indents the contacts between beads and in the rings. For the second pulse these
contacts are stiffer, and some of them have gaps. The rows give the peak forces of contacts between
beads for each pulse, in a yielding chain and in an elastic chain. In the elastic chain the second
pulse meets the oscillations that the first pulse leaves behind. The name of each row of the decay
states the contacts over which it was fitted.
"""

import numpy as np
from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import GrainRow, decay_rate, largest_of_pulses, push_starts

COMPARED = (25, 45, 65)  # contacts
DECAY = (35, 65)
PULSES = ("First", "Second")


class Pushed(GrainRow):
    """A row with two equal pulses; ``pulses``: largest force of each pulse at the recorded
    contacts, N.
    """

    def __init__(self, run):
        super().__init__(run)
        stage = self.case.precompression
        self.a = 2 * stage.tube / self.case.packing.diameter if stage else 0.0
        self.yields = self.case.contact.yields
        self.words = f"{'yielding' if self.yields else 'elastic'}, a = {self.a:.3g}"
        first, second = push_starts(self.load.table)
        self.contacts = np.array(list(self.contact_forces))
        forces = self.contact_forces.values()
        time = self.array("probes/time")
        self.pulses = np.array(
            [largest_of_pulses(time, force, second - first) for force in forces]
        ).T

    def at(self, contact):
        """Largest forces of both pulses at a contact, N."""
        return self.pulses[:, self.contacts == contact][:, 0]


def select(runs):
    return [sorted(map(Pushed, runs), key=lambda run: (run.a, run.yields))]


def rows(runs):
    # fmt: off
    law = runs[1].law_between(1, 2)
    yield gw.Row("Force at which a contact of beads yields", "N", ours=law.yield_force, where="ours")
    for run in runs:
        fitted = (run.contacts >= DECAY[0]) & (run.contacts <= DECAY[1])
        for k, which in enumerate(PULSES):
            for contact in COMPARED:
                yield gw.Row(f"{which} pulse at contact {contact}, {run.words}", "N", ours=run.at(contact)[k],
                             where="ours", digits=4)
            yield gw.Row(f"Decay per contact of the {which.lower()} pulse, contacts {DECAY[0]} to {DECAY[1]}, "
                         f"{run.words}", ours=decay_rate(run.contacts[fitted], run.pulses[k, fitted]), where="ours",
                         digits=2)
        if run.yields:
            yield gw.Row(f"Energy dissipated, {run.words}", "%", ours=100 * run.value("dissipated_fraction"),
                         where="ours", digits=3)
    # fmt: on


def verdict(runs):
    last = COMPARED[-1]
    for elastic, yielding in zip(runs[::2], runs[1::2], strict=True):
        (mine, second), theirs = yielding.at(last), elastic.at(last)[0]
        yield (
            f"a = {yielding.a:.2g}: at contact {last} the first pulse has {mine:.3g} N, {100 * mine / theirs:.3g} "
            f"% of the {theirs:.3g} N in the elastic chain, and the second pulse has {second:.3g} "
            "N."
        )


def pictures(runs):
    figure = Figure((6, 2.8), layout="constrained")
    data = {}
    axes = figure.subplots()
    for n, run in enumerate(runs):
        for which, force, look in zip(PULSES, run.pulses, ("o-", "o--"), strict=True):
            label = f"{run.words}, {which.lower()}"
            axes.semilogy(run.contacts, force, look, color=f"C{n}", label=label, markersize=3.5)
            data |= {
                "contact": run.contacts,
                f"{label.replace(', ', '_').replace(' = ', '_')}_N": force,
            }
    axes.set(xlabel="Contact", ylabel="Peak force (N)")
    figure.legend(loc="outside right upper", fontsize="small")
    caption = (
        "Peak forces of two equal pulses along elastic and yielding chains; yielding "
        "removes most of the first pulse"
    )
    yield gw.Picture("confined_yielding", caption, figure, data)
