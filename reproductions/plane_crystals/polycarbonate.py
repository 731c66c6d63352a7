"""Crystals of polycarbonate cylinders.

The source mentions these crystals without a number: their trends resemble the soft crystals, with
two regions and a higher rate of decay in the lower region. The peak speed of the grains on the
middle line is fitted by two exponentials.
"""

from crystal import SOURCE, Crystal
from matplotlib.figure import Figure

import granwave as gw

DENSITY = 1200.0  # kg/m3, of polycarbonate


def select(runs):
    """Both crystals of polycarbonate, by name; empty if the runs do not contain them."""
    crystals = {one.name: one for one in map(Crystal, runs) if one.case.material.density == DENSITY}
    return [crystals] if len(crystals) == 2 else []


def rows(crystals):
    for name, one in crystals.items():
        yield gw.Row(
            f"Rate of decay, lower / upper region, polycarbonate, {name}, at least", "",
            1.0, one.decay.second / one.decay.first, f"{SOURCE}, 4",
            "According to the source the trends are the same as in the soft crystals, with the "
            "higher rate in the lower region.",
            digits=2, bound=True,
        )  # fmt: skip
        yield gw.Row(
            f"Front speed along the middle line, polycarbonate, {name}", "m/s",
            ours=one.down.front_speed, where=f"{SOURCE}, 4",
            remark="The source prints no speed.", digits=3,
        )  # fmt: skip


def pictures(crystals):
    figure = Figure((3.5, 2.8), layout="constrained")
    axes = figure.subplots()
    data = {}
    for name, one in crystals.items():
        axes.semilogy(one.depth, one.peak, "o-", markersize=3, label=name)
        data |= {f"{name}_depth_diameters": one.depth, f"{name}_peak_m_s": one.peak}
    axes.set(xlabel="Depth (diameters)", ylabel="Peak speed (m/s)")
    axes.legend(fontsize=7)
    caption = (
        "Peak speed of the grains on the middle line of both crystals of polycarbonate cylinders"
    )
    yield gw.Picture("lateral_polycarbonate", caption, figure, data)
