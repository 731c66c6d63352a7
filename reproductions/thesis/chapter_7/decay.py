"""Filter: decay of the wave against the diameter of the cylinders and the approach of the walls
(thesis Fig. 7.5).

Chains of 216 steel spheres have aluminium cylinders that are as long as the spheres are wide; the
impact on sphere 20 is at 1 m/s. gamma is the diameter of the cylinders, and a the approach of the
walls, both divided by the diameter of the spheres. The decay is the slope of ln(peak force) per
contact, by a line through contacts 71 to 201. The second solver computes symmetric motion.
"""

import numpy as np
from filter_row import DENSITY, KILO, SOLVER, FilterRow, column, second_solver
from matplotlib.figure import Figure

import granwave as gw

GAMMAS = (0.26, 0.34, 0.38, 0.42, 0.46, 0.50, 0.54, 0.58, 0.62, 0.66, 0.70, 0.74, 0.78, 0.82, 0.90)
#: Approaches of the walls of Fig. 7.5a, and those of Fig. 7.5b by gamma.
OVER_GAMMA = (0.0, 4e-4, 8e-4, 12e-4)
OVER_A = {0.45: (0.0, 3e-3), 0.54: (5e-4, 3e-3), 0.67: (0.0, 2.5e-4, 7.5e-4, 2.4e-3)}
COLOURS_END = {0.0: 7.0, 8e-4: 9.0}  # 1e-3 per contact, of Fig. 7.2, by a


def select(runs):
    """Decay, 1e-3, and name by gamma and a, in rising order; empty for a single scan, which has
    only some of the runs.
    """
    found = {(row.gamma, row.a): (KILO * row.decay(), row.name) for row in map(FilterRow, runs)}
    return (
        [dict(sorted(found.items()))]
        if found.keys() >= {(gamma, a) for gamma in GAMMAS for a in OVER_GAMMA}
        else []
    )


def curve(decays, a):
    """Gamma and decay at one a."""
    return np.array([(gamma, decay) for (gamma, at), (decay, _) in decays.items() if at == a]).T


def fastest(decays, a):
    """Gamma of the fastest decay at one a, from a parabola, and the largest decay."""
    gamma, decay = curve(decays, a)
    k = decay.argmax()
    second, first, _ = np.polyfit(gamma[k - 1 : k + 2], decay[k - 1 : k + 2], 2)
    return -first / (2 * second), decay[k]


def solved_decays():
    """Decay, 1e-3, of the second solver, in the form of `select`."""
    return {
        (gamma, a): (KILO * row["decay_per_contact"], "")
        for (density, gamma, a), row in sorted(second_solver().items())
        if density == DENSITY
    }


def rows(decays):
    parts = {(gamma, a): "a" for a in OVER_GAMMA for gamma in GAMMAS}
    parts |= {(gamma, a): "b" for gamma, moved in OVER_A.items() for a in moved}
    solved = solved_decays()
    # fmt: off
    for key, part in parts.items():
        decay, name = decays[key]
        yield gw.Row(f"Decay per contact, {name}", "1e-3", ours=decay, theory=solved[key][0], verification=True,
                     digits=3, where=f"thesis Fig. 7.5{part}", remark=SOLVER)
    for a in OVER_GAMMA:
        gamma, largest = fastest(decays, a)
        yield gw.Row(f"gamma of the fastest decay, a = {a:g}", ours=gamma, theory=fastest(solved, a)[0], digits=2,
                     verification=True, where="thesis Fig. 7.5a",
                     remark="The maximum moves to larger cylinders as the walls press more, as in "
                            "the source.")
        end = COLOURS_END.get(a)
        yield gw.Row(f"Largest decay, a = {a:g}{', at most' if end else ''}", "1e-3", end, largest, "thesis Fig. 7.2",
                     "The bound is the end of the colour scale." if end else "", digits=3, bound=bool(end))
    # fmt: on


def pictures(decays):
    data = {}
    figure = Figure((7, 2.8), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    for a, mark in zip(OVER_GAMMA, "os^D", strict=True):
        gamma, decay = curve(decays, a)
        left.plot(gamma, decay, f"{mark}-", markersize=3, label=f"a = {a:g}")
        data |= {
            f"{column(f'a = {a:g}')}_gamma": gamma,
            f"{column(f'a = {a:g}')}_decay": 1e-3 * decay,
        }
    for gamma, mark in zip(OVER_A, "os^", strict=True):
        a, decay = np.array([(a, decay) for (at, a), (decay, _) in decays.items() if at == gamma]).T
        right.plot(KILO * a, decay, f"{mark}-", markersize=3, label=rf"$\gamma$ = {gamma:g}")
        name = column(f"gamma {gamma:g}")
        data |= {f"{name}_a": a, f"{name}_decay": 1e-3 * decay}
    left.set(
        xlabel=r"Diameter of the cylinders / spheres, $\gamma$",
        ylabel="Decay per contact (1e-3)",
    )
    right.set(xlabel="Approach of the walls / diameter, a (1e-3)")
    for axes in (left, right):
        axes.legend(fontsize=7)
    caption = (
        "Decay of the peak force per contact against the diameter of the cylinders and "
        "against the approach of "
    )
    caption += (
        "the walls (thesis Fig. 7.5). If the cylinders are pressed, waves decay fastest "
        "at larger diameters"
    )
    yield gw.Picture("filter_decay", caption, figure, data)
