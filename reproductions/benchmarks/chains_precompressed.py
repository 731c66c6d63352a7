"""Chains under a static force: speed against force.

Coste, Falcon and Fauve (Phys. Rev. E 56, 6104, 1997) measured impacts on chains of 8 mm steel beads
under three static forces. Daraio and others (Phys. Rev. E 73, 026610, 2006) precompressed chains of
PTFE and of steel with a magnet. The values in their abstracts can be compared without a modulus,
since all such chains are equivalent in units of the static state.
"""

import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import brentq

import granwave as gw
from granwave.measures import Chain, first_peak, width
from granwave.theory import discrete_speed, lattice_speed, precompressed_line

COSTE = "Coste et al. 1997, abstract"
DARAIO = "Daraio et al. 2006, abstract"
# contacts
FIRST = 20
LAST = 40
CURVE = "The source finds one curve for its three static forces, which follows Nesterenko's theory."
SPREADS = " The wave in our run still spreads and is slightly slower."
LEAST = 0.01  # fraction of the pulse's largest velocity at its ends


def measured(runs):
    """Largest and static force, and speed divided by c0 and by the speed without a static force, of
    each precompressed chain.
    """
    found = []
    for chain in map(Chain, runs):
        line = precompressed_line(chain.case)
        peaks = [
            first_peak(chain.time, one - line.force, floor=0.5) for one in chain.force.T[FIRST:LAST]
        ]
        times, added = np.array(peaks).T
        speed = line.spacing / np.polyfit(np.arange(len(times)), times, 1)[0]
        alone = chain.scales.nesterenko(added.mean()) * discrete_speed()
        found.append((added.mean() / line.force, line.force, speed / line.speed, speed / alone))
    return np.array(sorted(found)).T


def faster(added):
    """Speed of a travelling wave divided by its speed without a static force, for the same dynamic
    force, in units of the static force.
    """
    weakest = 1e6  # far above the static force
    alone = float(lattice_speed(np.array(weakest))) * (added / weakest) ** (1 / 6)
    return float(lattice_speed(np.array(1 + added))) / alone


def pulse(runs):
    """Length of the pulse under the smallest static force, divided by the length of the chain."""
    chain = min(
        map(Chain, runs), key=lambda one: (one.case.precompression.force, -one.load.velocity)
    )
    when = chain.velocity[:, 29].argmax()
    beads = chain.case.packing.size[0]
    return width(np.arange(beads), chain.velocity[when], LEAST) / beads


def rows(runs):
    # fmt: off
    added, static, speed, gain = measured(runs)
    for f, force, ours in zip(added, static, speed, strict=True):
        yield gw.Row(f"Speed / c0 at F_m/F0 = {f:.3g}, F0 = {force:g} N", "", ours=ours, where=COSTE, digits=4,
                     theory=float(lattice_speed(np.array(1 + f))), remark=CURVE if f > 2 else CURVE + SPREADS)
    yield gw.Row("Length of the pulse / length of the chain", "", 0.1, pulse(runs), COSTE,
        "The source states typically a tenth. In our chain of 51 beads the pulse is measured "
        f"between points of {100 * LEAST:g} % of the largest velocity.", digits=2)
    most = gain.argmax()
    twice = brentq(lambda f: faster(f) - 2, 1e-3, 10)
    yield gw.Row("Largest ratio of the speeds with and without static force, same force added", "",
        2.0, gain[most], DARAIO,
                 f"The source states up to two times. Our largest value has {added[most]:.2g} "
                 f"static forces added; in theory the ratio is two at {twice:.2g} static forces.",
                 theory=faster(added[most]), bound=True)
    # fmt: on


def pictures(runs):
    added, static, speed, gain = measured(runs)
    figure = Figure((6.6, 2.6), layout="constrained")
    fine = np.geomspace(0.7 * added.min(), 1.5 * added.max(), 100)
    left, right = figure.subplots(1, 2)
    left.semilogx(fine, lattice_speed(1 + fine), "0.5", label="travelling waves")
    right.loglog(fine, [faster(f) for f in fine], "0.5")
    for force, mark in zip(np.unique(static), "os^D", strict=True):
        same = static == force
        left.semilogx(added[same], speed[same], mark, markersize=4, label=f"{force:g} N")
        right.loglog(added[same], gain[same], mark, markersize=4)
    right.axhline(2, color="k", linewidth=0.6, linestyle=":")
    left.set(xlabel="Dynamic force / static force", ylabel="Speed / $c_0$")
    right.set(xlabel="Dynamic force / static force", ylabel="Speed / speed without static force")
    left.legend(fontsize=6)
    caption = (
        "Speed of waves under four static forces against their height, divided by c0 and by the "
        "speed without a static force. All points lie on one curve, as measured; the dotted line "
        "is the doubled speed of the second source"
    )
    data = {
        "added_over_static": added,
        "static_N": static,
        "speed_over_c0": speed,
        "speed_over_alone": gain,
    }
    yield gw.Picture("pressed_chains", caption, figure, data)
