"""Filter: peak forces along chains with cylinders (thesis Fig. 7.4).

The impact is on sphere 20 of a chain of steel spheres with aluminium cylinders at its gaps, at 1
m/s. Walls press the cylinders, or just touch them. gamma is the diameter of the cylinders, and a
the approach of the walls, both divided by the diameter of the spheres. Contact n is between spheres
n and n + 1; the second solver, for symmetric motion, counts contacts from 0.
"""

import numpy as np
from filter_row import (
    DENSITY,
    KILO,
    PRINTED_DENSITY,
    SOLVER,
    WHERE,
    FilterRow,
    column,
    second_solver,
)
from matplotlib.figure import Figure

import granwave as gw

CONTACTS = (21, 31, 61, 101, 151, 201)
#: Statements of the source on the curve, by density, gamma and a.
SAID = {
    (DENSITY, 0.56, 0.0): "nearly solitary",
    (DENSITY, 0.56, 8e-4): "rapidly decaying",
    (DENSITY, 0.90, 0.0): "oscillating and decreasing",
    (DENSITY, 0.90, 8e-4): "almost constant",
    (PRINTED_DENSITY, 0.56, 0.0): "nearly solitary, which does not hold with this density",
    (PRINTED_DENSITY, 0.56, 8e-4): "rapidly decaying",
    (PRINTED_DENSITY, 0.90, 0.0): "oscillating and decreasing",
    (PRINTED_DENSITY, 0.90, 8e-4): "almost constant, which does not hold with this density",
}
AXIS = 300.0  # N: end of the figure's axis
# contact; contacts on either side for the speed; fraction of the peak
PROBED = 121
NEAR = 60
FOOT = 0.01


def select(runs):
    """All rows of the figure by density, gamma and a; empty for a single scan, which has only some
    of them.
    """
    found = {row.key: row for row in map(FilterRow, runs)}
    return [{key: found[key] for key in SAID}] if found.keys() >= SAID.keys() else []


def span(row):
    """Length of the wave at the probed contact, from the time above the foot of its peak, in
    spheres.
    """
    time = row.array("probes/time")
    force = row.contact_forces[PROBED]
    low = np.flatnonzero(force < FOOT * force.max())
    end = np.searchsorted(low, force.argmax())
    passed = np.arange(PROBED - NEAR + 1, PROBED + NEAR)
    speed = np.polyfit(row.of_contacts("time_peak")[passed - 1], passed, 1)[0]
    return speed * (time[low[end]] - time[low[end - 1]])


def rows(found):
    figure = {"where": "thesis Fig. 7.4"}
    solved = second_solver()
    # fmt: off
    for key, said in SAID.items():
        for contact in CONTACTS:
            yield gw.Row(f"Peak force at contact {contact}, {found[key].name}", "N", ours=found[key].peaks[contact - 1],
                         theory=solved[key][f"contact_{contact}_N"], verification=True,
                         remark=f"{SOLVER} In the source the wave is {said}.", **figure)
    solitary, decaying, spread, _ = own = [row for key, row in found.items() if key[0] == DENSITY]
    yield gw.Row(f"Largest force between two spheres, {solitary.name}",
                 "N", ours=solitary.peaks.max(),
                 theory=solved[solitary.key]["largest_N"], verification=True, remark=SOLVER, **figure)
    for row in own:
        yield gw.Row(f"Largest force between two spheres, {row.name}, at most",
                     "N", AXIS, row.peaks.max(), bound=True,
                     remark="The bound is the end of the axis.", **figure)
    yield gw.Row(f"Decay per contact, {decaying.name}", "1e-3", ours=KILO * decaying.decay(),
                 theory=KILO * solved[decaying.key]["decay_per_contact"], verification=True, digits=3, remark=SOLVER,
                 **figure)
    yield gw.Row(f"Length of the leading wave in beads at contact {PROBED}, {spread.name}",
        source=10.0,
                 ours=span(spread), where=WHERE, remark="The wave spans the beads with forces "
                                                        "above 1 % of its peak.", digits=3)
    # fmt: on


def pictures(found):
    figure = Figure((3.4, 2.8), layout="constrained")
    contacts = np.arange(20, 202)
    axes = figure.subplots()
    data = {"contact": contacts}
    for (density, *_), row in found.items():
        if density == DENSITY:
            axes.semilogy(contacts, row.peaks[contacts - 1], label=row.name)
            data[f"{column(row.name)}_N"] = row.peaks[contacts - 1]
    axes.set(xlabel="Contact", ylabel="Peak force (N)")
    axes.legend(fontsize=7)
    caption = (
        "Peak force along chains with cylinders between walls (thesis Fig. 7.4). If the "
        "cylinders are pressed, the wave decays along one"
    )
    yield gw.Picture(
        "filter_peaks", f"{caption} chain and keeps its height along the other", figure, data
    )
