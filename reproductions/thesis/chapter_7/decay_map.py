"""Filter: decay over diameter and length of the cylinders (thesis Figs 7.2 and 7.3).

Short rows of 126 spheres, sphere 20 struck at 1 m/s; cylinders half to twice as long as the spheres
are wide, walls that just touch, and pressed. gamma and eta are the diameter and the length of the
cylinders over the diameter of the spheres, a the approach of the walls over it. The decay is that
of ln(peak force) per contact, through contacts 61 to 111.
"""

import math

import numpy as np
from filter_row import KILO, FilterRow, column
from matplotlib.figure import Figure

import granwave as gw

FIT = (61, 111)  # contacts
RATIO = 10.0  # end of the colours of Fig. 7.3


def select(runs):
    """Decay, 1e-3, by a, eta and gamma, in rising order; none of a scan alone, whose a are all
    alike.
    """
    rows = map(FilterRow, runs)
    found = dict(sorted(((row.a, row.eta, row.gamma), KILO * row.decay(*FIT)) for row in rows))
    return [found] if len({a for a, _, _ in found}) > 1 else []


def rows(decays):
    # fmt: off
    for (a, eta, gamma), decay in decays.items():
        name = f"eta {eta:g}, gamma {gamma:g}, a = {a:g}"
        yield gw.Row(f"Decay per contact, {name}", "1e-3", ours=decay, where="thesis Figs 7.2, 7.3", digits=3,
                     remark="Short row, contacts 61 to 111.")
        if a:
            ratio = decay / decays[0.0, eta, gamma]
            yield gw.Row(f"Decay over that at a = 0, within, {name}", source=math.copysign(RATIO, ratio), ours=ratio,
                         where="thesis Fig. 7.3", remark="By the end of the colours. Short rows.", digits=2, bound=True)
    # fmt: on


def pictures(decays):
    data = {}
    figure = Figure((7, 2.8), layout="constrained")
    approaches, etas = (sorted({key[k] for key in decays}) for k in (0, 1))
    panels = figure.subplots(1, len(approaches), sharey=True)
    for axes, at in zip(panels, approaches, strict=True):
        for length, mark in zip(etas, "os^", strict=True):
            points = [
                (gamma**2 * eta, decay)
                for (a, eta, gamma), decay in decays.items()
                if (a, eta) == (at, length)
            ]
            mass, decay = np.array(points).T
            axes.plot(mass, decay, f"{mark}-", markersize=4, label=rf"$\eta$ = {length:g}")
            name = column(f"a = {at:g} eta {length:g}")
            data |= {f"{name}_mass": mass, f"{name}_decay": 1e-3 * decay}
        axes.set(xlabel=r"$\gamma^2 \eta$, as the mass of a cylinder", title=f"a = {at:g}")
        axes.legend(fontsize=7)
    panels[0].set(ylabel="Decay per contact (1e-3)")
    caption = "Decay against the mass of the cylinders, for three lengths of these: the map of thesis Figs 7.2, 7.3"
    yield gw.Picture("filter_map", caption, figure, data)
