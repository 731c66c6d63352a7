"""Decorated chains: small beads between large ones.

The chain has ten beads whose diameter decreases by 5 % from one to the next, with a small bead
between neighbouring large beads. The impact at 1 m/s is on the first bead; the last bead is free.
Two limits are known (Harbola and others 2009). In the first, hard spheres collide once each. In the
second, the small beads have no mass and act as two springs in series, so that only the large beads
have inertia.
"""

import numpy as np
from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import Chain

WHERE = "hard spheres, one collision each"
NEWS = "UB Reporter 38 (19)"
AGAIN = "Small beads collide many times and transmit more energy each time."
LIGHT = "Small beads without mass"


def handed_on(diameters):
    """Fraction of the energy that reaches the last hard sphere if each pair collides once."""
    first = diameters[:-1] ** 3
    second = diameters[1:] ** 3
    return float(np.prod(4 * first * second / (first + second) ** 2))


def measured(runs):
    """Ratio of small to large diameter, energy of the last bead divided by the input, and this
    fraction for hard spheres and for large beads only.
    """
    found = []
    for chain in map(Chain, runs):
        diameters = np.full(chain.case.packing.size[0], chain.case.packing.diameter)
        for one in chain.case.replace:
            diameters[np.array(one.index) - 1] = one.diameter
        last = (diameters[-1] / diameters[0]) ** 3 * (
            chain.velocity[-1, -1] / chain.load.velocity
        ) ** 2
        found.append(
            (diameters[1] / diameters[0], last, handed_on(diameters), handed_on(diameters[::2]))
        )
    return np.array(sorted(found)).T


def rows(runs):
    # fmt: off
    small, last, hard, large = measured(runs)
    for f, ours, theory in zip(small, last, hard, strict=True):
        yield gw.Row(f"Energy of the last bead / input, small beads of {f:.2g}", "", ours=ours, theory=theory,
                     where=WHERE, remark=AGAIN if f < 0.7 else "")
    yield gw.Row(f"{LIGHT}: energy of the last bead / input, {small[0]:.2g}", "", ours=last[0], theory=large[0],
                 where="Harbola et al. 2009", remark="The theory has large hard spheres only, "
                                                     "since light beads act as springs.")
    yield gw.Row("Ratio of small and large diameter with the least energy of the last bead", "",
        ours=small[last.argmin()],
                 where=NEWS, digits=2, remark="In the source, smaller beads absorb more energy. "
                                              "In our runs this holds only from 0.9 down to "
                                              "this size; smaller beads absorb less energy.")
    yield gw.Row("Least energy of the last bead / input", "", ours=last.min(), where="ours",
                 remark=f"For hard spheres, a chain with only the large beads has {large[0]:.3f}.")
    # fmt: on


def pictures(runs):
    small, last, hard, large = measured(runs)
    axes = Figure((3.6, 2.7), layout="constrained").subplots()
    axes.plot(small, last, "oC0-", markersize=4, label="simulation")
    axes.plot(small, hard, "0.5", label="hard spheres, one collision each")
    axes.plot(small, large, "0.5", linestyle="--", label="small beads without mass")
    axes.set(xlabel="Small / large diameter", ylabel="Energy of the last bead / input", ylim=(0, 1))
    axes.legend(fontsize=6)
    caption = (
        "Energy of the last bead of a decorated, tapered chain against the size of the small "
        "beads. Neither limit holds in between, and the smallest beads do not protect best: the "
        "curve has a minimum"
    )
    data = {
        "small_over_large": small,
        "last_over_input": last,
        "hard_over_input": hard,
        "light_over_input": large,
    }
    yield gw.Picture("decorated_chain", caption, axes.figure, data)
