"""Speed of composite chains whose brass yields.

According to the source the brass of its section yields; no yield strength is given. Here the
strength is chosen to give the measured speed with the longest section, and the result for the
shortest section is compared with the measurement. Yielding slows waves more in a longer section.
"""

import numpy as np
from matplotlib.figure import Figure
from section import SPEEDS, by, sections

import granwave as gw

WHERE = "composite chain, section 4, measured"
MEGA = 1e6
MEASURED = SPEEDS["brass-composite"]


def speeds_of(runs):
    """Yield strengths, MPa, and the speeds V for each strength, m/s, by the number of beads in the
    section.
    """
    found = {}
    for n, group in by(sections(runs), lambda section: section.n).items():
        points = sorted((one.material.yield_strength / MEGA, one.speed) for one in group)
        found[n] = np.array(points).T
    return found


def rows(runs):
    found = speeds_of(runs)
    for n, (strengths, speeds) in found.items():
        for strength, speed in zip(strengths, speeds, strict=True):
            yield gw.Row(
                f"V, N2 = {n}, brass yielding at {strength:g} MPa", "m/s", ours=speed, where=WHERE,
                digits=4,
            )  # fmt: skip
    shortest = min(found)
    longest = max(found)
    strengths, speeds = found[longest]
    strength = np.interp(MEASURED[longest], speeds, strengths)
    yield gw.Row(
        f"V, N2 = {shortest}, with the yield strength that gives V of N2 = {longest}", "m/s",
        MEASURED[shortest], np.interp(strength, *found[shortest]), WHERE, digits=4,
        remark=f"The strength is {strength:.0f} MPa. No yield strength gives both speeds, so that "
               "yielding alone does not explain the measured speeds.",
    )  # fmt: skip


def pictures(runs):
    figure = Figure((3.5, 2.8), layout="constrained")
    axes = figure.subplots()
    data = {}
    for colour, (n, (strengths, speeds)) in enumerate(speeds_of(runs).items()):
        axes.plot(strengths, speeds, f"oC{colour}-", markersize=4, label=f"{n} beads of brass")
        axes.axhline(MEASURED[n], color=f"C{colour}", linestyle=":", label=f"{n} beads, measured")
        data |= {f"{n}_yield_strength_MPa": strengths, f"{n}_speed_m_s": speeds}
    axes.set(xlabel="Yield strength (MPa)", ylabel="Speed $V$ (m/s)")
    axes.legend(fontsize=7)
    caption = (
        "Speed V against the yield strength of the brass: the measured speeds (dotted) of 3 and "
    )
    caption += "24 beads require different strengths"
    yield gw.Picture("composite_brass_yield", caption, figure, data)
