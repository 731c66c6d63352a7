"""Dissimilar spheres.

The contact of two spheres is recorded in 12 impacts: loading, and unloading to separation, compared
with the curve of the law. The thesis prints curves, but no values; its finite elements are the
static contact of two spheres. Forces at one overlap are compared with the printed formulas,
evaluated here. This tests the code, whose law is these formulas.
"""

import math

import numpy as np
from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import Chain

SHALLOW = 0.4e-3  # m: an overlap of Figs. 2.9 and 3.3
# c1, c2, 1.07 and p_y/sigma_y of 2.4 to 2.8; of the area far beyond yield, 2.10
PRESSURE = 2.48
APPROACH = 0.098
AT_YIELD = 1.07
FIRST_YIELD = 1.60
AREA = (2.37, -59.96)
LINEAR_FROM = 177.6  # overlaps at first yield
ALLOYS = {
    "aluminium-2017": "The thesis does not print the values of the alloy; E = 72.4 GPa and 276 "
    "MPa are from a handbook.",
    "aluminium": "This is pure aluminium of 150 MPa, the intruder of the thesis; Fig. 3.3 has the "
    "stronger alloy 2017.",
}


class Pair:
    """The contact of two spheres as recorded in a run, and the contact law of these spheres."""

    def __init__(self, run):
        chain = Chain(run)
        self.materials = [chain.assembly.material_of(n) for n in (1, 2)]
        diameters = [chain.assembly.diameter_of(n) for n in (1, 2)]
        constants = [
            {
                name: getattr(one, name)
                for name in ("youngs_modulus", "poisson_ratio", "density", "yield_strength")
            }
            for one in self.materials
        ]
        self.bodies = [
            {"shape": "sphere", "diameter": d, "material": m}
            for d, m in zip(diameters, constants, strict=True)
        ]
        self.names = " on ".join(one.name for one in self.materials)
        self.ratio = max(diameters) / min(diameters)
        self.strength = min(one.yield_strength for one in self.materials)
        self.like = self.materials[0] == self.materials[1]
        self.radius = 0.5 / sum(1 / d for d in diameters)
        self.yield_overlap, self.yield_force = gw.contact_yield("elastoplastic", self.bodies)
        self.overlap = run.result["probes/contact_1_2_overlap"]
        self.force = run.result["probes/contact_1_2_force"]
        self.deepest = max(self.overlap.max(), run.result["contacts/peak_overlap"].max())
        self.turn = self.overlap.argmax()
        self.loading = slice(0, self.turn + 1)

    def law(self, overlap, peak=None):
        """Force at overlaps, on first loading or after a larger overlap."""
        return gw.contact_force("elastoplastic", self.bodies, overlap, peak_overlap=peak)

    @property
    def deviation(self):
        """Largest |force - law| for overlaps above 1 % of the largest, divided by the largest
        force.
        """
        peak = np.maximum.accumulate(self.overlap)
        peak[self.turn + 1 :] = self.deepest
        chosen = self.overlap > 1e-2 * self.deepest
        return (
            np.abs(self.law(self.overlap, peak) - self.force)[chosen].max()
            / self.force[chosen].max()
        )

    def printed_force(self, overlap):
        """Force at an overlap far beyond yield, by 2.3 to 2.10 as they are printed, N."""
        softness = sum((1 - one.poisson_ratio**2) / one.youngs_modulus for one in self.materials)
        at_yield = (math.pi * FIRST_YIELD * self.strength * softness / 2) ** 2 * self.radius
        reduced = overlap / at_yield
        if reduced < LINEAR_FROM:
            raise ValueError(
                f"found {reduced:g} overlaps at yield, expected {LINEAR_FROM:g} or more"
            )
        drop = (PRESSURE - AT_YIELD) * math.exp(-APPROACH * (reduced - 1))
        area = math.pi * self.radius * at_yield * (AREA[0] * reduced + AREA[1])
        return self.strength * (PRESSURE - drop) * area

    def row(self, overlap, what, where, remark=""):
        """Force at an overlap, recorded and by the printed formulas."""
        ours = np.interp(overlap, self.overlap[self.loading], self.force[self.loading])
        return gw.Row(f"Force at {what}", "kN", ours=ours / 1e3, theory=self.printed_force(overlap) / 1e3,
                      where=where, remark=remark, verification=True)  # fmt: skip


def groups(runs):
    """All pairs; brass pairs by the ratio of radii, pairs of dissimilar materials, and equal
    spheres by yield strength.
    """
    pairs = [Pair(run) for run in runs]
    like = [pair for pair in pairs if pair.like]
    unlike = [pair for pair in pairs if not pair.like]
    radii = sorted((pair for pair in like if pair.strength == 550e6), key=lambda pair: pair.ratio)
    return (
        pairs,
        radii,
        unlike,
        sorted((p for p in like if p.ratio == 1), key=lambda pair: pair.strength),
    )


def rows(runs):
    pairs, _, unlike, band = groups(runs)
    yield gw.Row(
        f"Largest distance of {len(pairs)} recorded curves from the law / largest force", "%",
        ours=100 * max(pair.deviation for pair in pairs), theory=0.0, verification=True, where="thesis 2.14-2.17",
        remark="The curves of loading and unloading follow from the coupled motion of two spheres.",
    )  # fmt: skip
    for pair in unlike:
        remark = next((ALLOYS[one] for one in ALLOYS if one in pair.names.split()), "")
        yield pair.row(SHALLOW, f"0.4 mm, {pair.names}", "thesis Fig. 3.3", remark)
    for pair in band:
        edge = (
            "The strength is one end of the range that the thesis gives for the experiment."
            if pair.strength != 550e6
            else ""
        )
        yield pair.row(
            SHALLOW, f"0.4 mm, sigma_y {pair.strength / 1e6:.0f} MPa", "thesis Fig. 2.9", edge
        )


def loading(axes, pairs, labels, unit, data):
    """Draw the recorded loading as marks, in units of first yield or of an attribute of the pair,
    and the law as a line.
    """
    for n, (pair, label) in enumerate(zip(pairs, labels, strict=True)):
        overlap = pair.overlap[pair.loading] / getattr(pair, unit)
        force = pair.force[pair.loading] / pair.yield_force
        axes.plot(
            overlap,
            force,
            ls="",
            marker="os^Dv"[n % 5],
            ms=4,
            fillstyle="none",
            markevery=(0.01 * n, 0.06),
        )
        axes.lines[-1].set_label(label)
        data |= {
            f"overlap_over_{unit}_{n + 1}": overlap,
            f"force_of_{unit}_{n + 1}_over_yield_force": force,
        }
    pair = max(pairs, key=lambda pair: pair.deepest / getattr(pair, unit))
    overlap = np.geomspace(1e-4, 1, 400) * pair.deepest
    x = overlap / getattr(pair, unit)
    law = pair.law(overlap) / pair.yield_force
    axes.plot(x, law, "k", linewidth=0.8, zorder=0, label="law (thesis 2.14)")
    data |= {f"law_overlap_over_{unit}": x, f"law_of_{unit}_over_yield_force": law}


def contact(axes, pairs, labels, data):
    """Draw loading and unloading: the law as a line, the records as marks."""
    for pair, label in zip(pairs, labels, strict=True):
        up = np.linspace(0, pair.deepest, 200)
        down = np.linspace(pair.deepest, 0, 300)
        overlap = np.concatenate([up, down])
        law = np.concatenate([pair.law(up), pair.law(down, np.full_like(down, pair.deepest))])
        x = pair.overlap[pair.force > 0]
        force = pair.force[pair.force > 0]
        (line,) = axes.plot(1e3 * overlap[law > 0], law[law > 0] / 1e3, linewidth=0.9, label=label)
        axes.plot(
            1e3 * x,
            force / 1e3,
            "o",
            color=line.get_color(),
            ms=2.5,
            fillstyle="none",
            markevery=0.05,
        )
        data |= {
            f"{label.replace(' ', '_')}_overlap_m": x,
            f"{label.replace(' ', '_')}_force_N": force,
        }
    axes.set(xlabel="Overlap (mm)", ylabel="Force (kN)", xlim=(0, None), ylim=(0, None))
    axes.legend(fontsize=7, title="lines: law; marks: run", title_fontsize=7)


def pictures(runs):
    pairs, radii, unlike, band = groups(runs)
    names = [
        pair.names if not pair.like else f"R2/R1 {pair.ratio:g}, {pair.strength / 1e6:.0f} MPa"
        for pair in pairs
    ]
    figure = Figure((7, 3), layout="constrained")
    data = {}
    left, right = figure.subplots(1, 2)
    loading(left, pairs, names, "yield_overlap", data)
    loading(right, radii, [f"$R_2/R_1$ = {pair.ratio:g}" for pair in radii], "radius", data)
    left.set(
        xlabel=r"Overlap $\alpha/\alpha_\mathrm{y}$",
        ylabel=r"Force $F/F_\mathrm{y}$",
        xscale="log",
        yscale="log",
    )
    right.set(
        xlabel=r"Overlap $\alpha/R^*$",
        ylabel=r"Force $F/F_\mathrm{y}$",
        xlim=(0, None),
        ylim=(0, None),
    )
    left.set(xlim=(0.2, None))
    left.legend(fontsize=5.5, loc="lower right")
    right.legend()
    caption = (
        "Loading force against overlap, in units of first yield: all pairs; and dissimilar radii, "
        "overlap / R* (thesis Fig. 2.10). Marks on the line of the law show that the runs follow "
        "it, and that one curve holds for all"
    )
    yield gw.Picture("unlike_normalised", caption, figure, data)

    figure = Figure((7, 2.7), layout="constrained")
    data = {}
    left, right = figure.subplots(1, 2)
    contact(left, unlike, [pair.names for pair in unlike], data)
    contact(right, band, [f"{pair.strength / 1e6:.0f} MPa" for pair in band], data)
    caption = (
        "Force against overlap, loading and unloading: dissimilar materials (thesis Fig. 3.3), "
        "and yield strengths (Fig. 2.9). The softer sphere determines the curve: pairs with the "
        "same softer sphere nearly coincide"
    )
    yield gw.Picture("unlike_materials", caption, figure, data)
