"""Protectors: best order of hard and soft beads in front of a wall.

Fraternali, Porter and Daraio (arXiv:0802.1451) let an evolutionary algorithm arrange beads of steel
and PTFE so that the largest force on a wall is smallest. Our chains have twelve beads of 10 mm and
an impact at 1 m/s. They have equal beads, two halves, alternating beads, or the order that
`granwave design` found in 80 runs among the 4096 orders.
"""

import numpy as np
from matplotlib.figure import Figure

import granwave as gw

WHERE = "Fraternali et al. 2008, abstract"
ORDERS = {"SSSSSSSSSSSS": "steel", "PPPPPPPPPPPP": "PTFE", "SSSSSSPPPPPP": "PTFE at the wall"}
ORDERS |= {
    "PPPPPPSSSSSS": "PTFE at the striker",
    "SPSPSPSPSPSP": "alternating",
    "PSSSSSPSPPPP": "by design",
}


def order(case):
    """S for steel, P for PTFE, from the impacted end."""
    beads = ["S"] * case.packing.size[0]
    for one in case.replace:
        for bead in one.index:
            beads[bead - 1] = "P" if one.material.poisson_ratio > 0.4 else "S"
    return "".join(beads)


def measured(runs):
    """Largest force on the wall, N, by order of the beads."""
    found = {order(run.case): run["target_peak_force_N"] for run in runs}
    return {beads: found[beads] for beads in ORDERS if beads in found}


def rows(runs):
    forces = measured(runs)
    for beads, force in forces.items():
        yield gw.Row(
            f"Largest force on the wall, {ORDERS[beads]} ({beads})",
            "N",
            ours=force,
            where="ours",
            digits=4,
        )
    best = min(forces, key=forces.get)
    soft_first = forces["PPPPPPSSSSSS"] / forces["SSSSSSPPPPPP"]
    yield gw.Row(
        "Largest force, soft beads at the striker / at the wall",
        "",
        ours=soft_first,
        digits=4,
        where=WHERE,
        remark="The source places soft, light beads near the wall and hard, heavy beads at the "
        "loaded end.",
    )
    yield gw.Row("Fraction of soft beads in the half at the wall, of the best order", "",
        ours=best[6:].count("P") / 6,
                 where=WHERE, digits=3, remark=f"The order is {best}. It agrees with the source "
                                               "except for the first bead, which is soft and "
                                               "lengthens the impact of the steel striker.")  # fmt: skip


def pictures(runs):
    forces = measured(runs)
    figure = Figure((5.0, 2.4), layout="constrained")
    values = np.array(list(forces.values()))
    axes = figure.subplots()
    axes.barh([f"{ORDERS[beads]}\n{beads}" for beads in forces], values, color="C0", height=0.6)
    axes.set(xlabel="Largest force on the wall (N)", xscale="log")
    axes.tick_params(axis="y", labelsize=6)
    axes.invert_yaxis()
    caption = (
        "Largest force on a wall behind twelve beads of steel (S) or PTFE (P), from the impacted "
        "end. The order matters as much as the material: compare the two orders of halves, and "
        "the order that the search found"
    )
    yield gw.Picture("protectors", caption, figure, {"force_N": values})
