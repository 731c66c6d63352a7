"""Filter after a strong pulse.

This study goes beyond the source, whose contacts are elastic. A weak pulse acts on a sphere of a
pressed chain, either undamaged or after a strong pulse. Yielding dissipates far more of the weak
pulse than the filter does. A strong pulse indents the contacts, which are then elastic up to larger
forces, and reduces the force of the walls. In the elastic chain the weak pulse meets the
oscillations behind the strong pulse, so that its peaks contain both. In yielding chains grains
rattle: with other timesteps single peaks change by up to a quarter, and the decay changes by 2 %.
Contact n is between spheres n and n + 1; the decay is the slope of ln(peak force) over the contacts
in the name of its row.
"""

import numpy as np
from filter_row import column
from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import GrainRow, decay_rate, largest_of_pulses, push_starts

# contacts
COMPARED = (26, 41, 61)
DECAY = (26, 61)
BEFORE = 2e-5  # s: time over which the force on the walls is averaged before the weak pulse


class PushedFilter(GrainRow):
    """A row with a weak pulse at the end, with or without a strong pulse before it."""

    def __init__(self, run):
        super().__init__(run)
        starts = push_starts(self.load.table)
        time = self.array("probes/time")
        forces = self.contact_forces
        self.yields = self.case.contact.law != "hertz"
        self.after = len(starts) == 2
        state = "after a strong pulse" if self.after else "whole"
        self.words = f"{'yielding' if self.yields else 'elastic'}, {state}"
        apart = starts[-1] - starts[0]
        self.contacts = np.array(list(forces))
        self.strong, self.weak = np.array(
            [
                largest_of_pulses(time, force, apart) if self.after else (0.0, force.max())
                for force in forces.values()
            ]
        ).T
        fitted = (self.contacts >= DECAY[0]) & (self.contacts <= DECAY[1])
        self.decay = decay_rate(self.contacts[fitted], self.weak[fitted])
        time = self.array("walls/xlo/time")
        wall = self.array("walls/xlo/force")
        self.pressed = wall[(time >= starts[-1] - BEFORE) & (time <= starts[-1])].mean() / wall[0]

    def at(self, contact):
        """Largest force of the strong and of the weak pulse at a contact, N."""
        k = list(self.contacts).index(contact)
        return self.strong[k], self.weak[k]


def measured(runs):
    return sorted(map(PushedFilter, runs), key=lambda row: (row.yields, row.after))


def number(value):
    return f"{float(f'{value:.3g}'):g}"


def rows(runs):
    found = measured(runs)
    where = {"where": "not in the source"}
    *_, whole, dented = found
    # fmt: off
    for row in found:
        for contact in COMPARED:
            strong, weak = row.at(contact)
            yield gw.Row(f"Weak pulse at contact {contact}, {row.words}", "N", ours=weak, digits=2 if row.yields else 4,
                         remark=f"The preceding strong pulse has {number(strong)} N." if row.after else "", **where)
        if row.yields or not row.after:
            yield gw.Row(f"Decay per contact of the weak pulse, contacts {DECAY[0]} to {DECAY[1]}, {row.words}",
                         ours=row.decay, digits=2 if row.yields else 3, **where)
        if row.after:
            yield gw.Row(f"Force of a wall before the weak pulse / at the start, {row.words}",
                digits=3,
                         ours=row.pressed, remark="" if row.yields else ("Spheres that still "
                                                                         "oscillate push the "
                                                                         "cylinders outwards."), **where)
    yield gw.Row("Decay of the weak pulse in the indented / undamaged chain",
                 ours=dented.decay / whole.decay, digits=2,
                 remark="The decay includes the remaining effect of the filter and the "
                        "dissipation by yielding.", **where)
    # fmt: on


def verdict(runs):
    *_, whole, dented = measured(runs)
    last = COMPARED[-1]
    yield (
        f"After the strong pulse {100 * dented.pressed:.0f} % of the force of the walls remain. At "
        f"contact {last} the weak pulse then has {number(dented.at(last)[1])} N, compared with {number(whole.at(last)[1])} "
        "N in the undamaged chain."
    )


def pictures(runs):
    figure = Figure((3.4, 2.8), layout="constrained")
    data = {}
    axes = figure.subplots()
    for row, mark in zip(measured(runs), "os^D", strict=True):
        axes.semilogy(row.contacts, row.weak, f"{mark}-", markersize=3.5, label=row.words)
        data |= {"contact": row.contacts, f"{column(row.words)}_N": row.weak}
    axes.set(xlabel="Contact", ylabel="Peak force (N)")
    axes.legend(fontsize=7)
    caption = (
        "Peak forces of a weak pulse along chains with cylinders. In a yielding chain the "
        "pulse dies away, but it passes after a "
    )
    caption += "strong pulse has indented the contacts; elastic chains are shown for comparison"
    yield gw.Picture("filter_dented", caption, figure, data)
