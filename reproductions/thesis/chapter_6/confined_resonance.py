"""Confined chain: resonances in the density of 6 small spheres.

For n = 6 and a = 0 only the density of the small spheres varies. The wave loses energy to small
spheres that still oscillate after it has passed. There are resonances with rapid decay, and
anti-resonances between them where the wave is nearly solitary. The source shows (1/F) dF/dx, which
is the negative decay, between -7e-3 and 1e-3, with several peaks and troughs. The theory is the
equations of symmetric motion, over the same contacts.
"""

import numpy as np
from confined_rows import DENSITY, WHERE, ConfinedRun, decay_of
from matplotlib.figure import Figure
from symmetric_motion import waves_of

import granwave as gw
from granwave.measures import maxima

RESONANCES = (0.10, 0.24, 5.0)  # density ratios of the source's model
ANTI_RESONANCES = (0.056, 0.18, 0.42, 0.75, 2.0)
SETTLED = 2.0  # density ratio up to which the wave decays uniformly from contact 60 on
FORGETS = "With heavy small spheres the decay is not yet uniform near the impacted bead."


class Densities:
    """Rows by rising density of the small spheres: ratio to the density of the beads, decays of
    runs and equations.
    """

    def __init__(self, runs):
        found = sorted(map(ConfinedRun, runs), key=lambda run: run.rows.density[0])
        self.ratio = np.array([run.rows.density[0] / DENSITY for run in found])
        self.decay = np.array([run.decay for run in found])
        forces, _ = waves_of(found)
        self.theory = np.array(
            [decay_of(force[: run.passed]) for run, force in zip(found, forces, strict=True)]
        )


def select(runs):
    return [Densities(runs)]


def remark(ratio):
    """Return the statement of the source's model for this density."""
    words = FORGETS if ratio > SETTLED else ""
    if round(ratio, 6) in RESONANCES:
        words += " The model of the source has a resonance here."
    elif round(ratio, 6) in ANTI_RESONANCES:
        words += " The model of the source has an anti-resonance here."
    return words.strip()


def rows(found):
    # fmt: off
    for ratio, decay, theory in zip(found.ratio, found.decay, found.theory, strict=True):
        yield gw.Row(f"Decay per contact, density ratio {ratio:.3g}", ours=decay, theory=theory, where=WHERE,
                     remark=remark(ratio), verification=True, digits=3)
    worst = found.decay[found.ratio <= SETTLED].argmax()
    yield gw.Row("Density ratio of the most rapid decay", ours=found.ratio[worst], where="thesis figure 6.7", digits=3,
                 remark="The value is one of the densities of the runs.")
    yield gw.Row("Largest decay per contact", ours=found.decay[worst], where="thesis figure 6.7", digits=3)
    # fmt: on


def verdict(found):
    high, low = (
        ", ".join(f"{one:g}" for one in found.ratio[maxima(sign * found.decay, -1)])
        for sign in (1, -1)
    )
    yield (
        f"The decay has maxima at density ratios near {high}; the wave is nearly solitary near {low}."
    )


def pictures(found):
    axes = Figure((5, 2.6), layout="constrained").subplots()
    axes.semilogx(found.ratio, 1e3 * found.theory, "0.6", label="equations")
    axes.plot(found.ratio, 1e3 * found.decay, "o", label="simulation", markersize=4)
    axes.set(
        xlabel="Density ratio, small spheres / beads",
        ylabel=r"Decay per contact $\times 10^3$",
    )
    axes.legend()
    data = {"density_ratio": found.ratio, "decay_theory": found.theory, "decay": found.decay}
    caption = (
        "Decay of the wave against the density of the small spheres: maxima at the "
        "resonances, hardly any decay between "
    )
    caption += "them (thesis figure 6.7)"
    yield gw.Picture("confined_resonance", caption, axes.figure, data)
