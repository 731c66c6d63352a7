"""Filter: decay of the wave against the diameter of the cylinders and the approach of the walls
(thesis Fig. 7.5).

Rows of 216 steel spheres with aluminium cylinders as long as the spheres are wide, sphere 20 struck
at 1 m/s. gamma is the diameter of the cylinders over that of the spheres, a the approach of the
walls over it. The decay is that of ln(peak force) per contact, by a line through contacts 71 to
201. The second solver is one of symmetric motion.
"""

import numpy as np
from filter_row import KILO, SOLVER, FilterRow, column
from matplotlib.figure import Figure

import granwave as gw

GAMMAS = (0.26, 0.34, 0.38, 0.42, 0.46, 0.50, 0.54, 0.58, 0.62, 0.66, 0.70, 0.74, 0.78, 0.82, 0.90)
#: Decay per contact, 1e-3, of the second solver: of Fig. 7.5a by a, for all gamma; of Fig. 7.5b by gamma and a.
OVER_GAMMA = {
    0.0: (1.8, 0.13, 0.67, 4.2, 5.9, 2.1, 0.04, 0.92, 2.5, 0.25, 0.20, 1.0, 0.04, 0.23, 1.1),
    4e-4: (0.31, 0.49, 0.10, 2.0, 5.1, 7.9, 9.0, 3.4, 0.09, 0.61, 2.0, 2.1, 0.48, 0.02, 0.57),
    8e-4: (0.05, 0.55, 0.02, 0.68, 2.8, 5.1, 7.2, 8.2, 4.1, 0.32, 0.22, 1.2, 1.8, 1.1, 0.07),
    12e-4: (0.01, 0.44, 0.15, 0.16, 1.5, 3.5, 5.4, 7.1, 7.3, 3.1, 0.24, 0.18, 0.98, 1.5, 0.21),
}
OVER_A = {
    0.45: {0.0: 6.2, 3e-3: 0.0},
    0.54: {5e-4: 8.9, 3e-3: 2.0},
    0.67: {0.0: 0.05, 2.5e-4: 2.1, 7.5e-4: 0.02, 2.4e-3: 6.3},
}
FASTEST = {0.0: 0.46, 4e-4: 0.53, 8e-4: 0.57, 12e-4: 0.60}  # gamma of the fastest decay, by a
COLOURS_END = {0.0: 7.0, 8e-4: 9.0}  # 1e-3 a contact, of Fig. 7.2, by a


def select(runs):
    """Decay, 1e-3, and name by gamma and a, in rising order; none of a scan alone, which has some
    of them.
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


def rows(decays):
    known = {
        (gamma, a): (decay, "a")
        for a, of in OVER_GAMMA.items()
        for gamma, decay in zip(GAMMAS, of, strict=True)
    }
    known |= {(gamma, a): (decay, "b") for gamma, of in OVER_A.items() for a, decay in of.items()}
    # fmt: off
    for key, (theory, part) in known.items():
        decay, name = decays[key]
        yield gw.Row(f"Decay per contact, {name}", "1e-3", ours=decay, theory=theory, verification=True, digits=3,
                     where=f"thesis Fig. 7.5{part}", remark=f"{SOLVER} Printed there with two digits.")
    for a, theory in FASTEST.items():
        gamma, decay = curve(decays, a)
        k = decay.argmax()
        second, first, _ = np.polyfit(gamma[k - 1 : k + 2], decay[k - 1 : k + 2], 2)
        yield gw.Row(f"gamma of the fastest decay, a = {a:g}", ours=-first / (2 * second), theory=theory, digits=2,
                     verification=True, where="thesis Fig. 7.5a",
                     remark="It moves to larger cylinders as the walls press, as the source says.")
        end = COLOURS_END.get(a)
        yield gw.Row(f"Decay there, a = {a:g}{', at most' if end else ''}", "1e-3", end, decay[k], "thesis Fig. 7.2",
                     "By the end of the colours." if end else "", digits=3, bound=bool(end))
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
        xlabel=r"Diameter of the cylinders over that of the spheres, $\gamma$",
        ylabel="Decay per contact (1e-3)",
    )
    right.set(xlabel="Approach of the walls over the diameter, a (1e-3)")
    for axes in (left, right):
        axes.legend(fontsize=7)
    caption = "Decay of the peak force per contact against the diameter of the cylinders, and against the approach of "
    caption += "the walls (thesis Fig. 7.5): pressed, waves decay fastest beside larger cylinders"
    yield gw.Picture("filter_decay", caption, figure, data)
