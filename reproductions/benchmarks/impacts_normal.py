"""Normal impacts: tests 1 to 3 of Chung and Ooi.

Tests 1 and 2 are impacts of two elastic spheres, and of a sphere on a rigid plane. Test 3 compares
the specified restitution with the result. The largest force and overlap are calculated from Hertz's
law and the energy.
"""

import numpy as np
from matplotlib.figure import Figure

import granwave as gw

WHERE = "Chung and Ooi 2011, test {}"
NAMES = {4.8e10: "glass", 2e10: "limestone", 7e10: "aluminium alloy", 4e10: "magnesium alloy"}
CURVES = {
    "glass": (265.2e-6, 10176),
    "aluminium alloy": (49.99e-6, 11326),
}  # a point each of printed curves, m, N


class Impact:
    """An elastic impact: largest force and overlap, and Hertz's values from the energy."""

    def __init__(self, run):
        self.run = run
        self.case = run.case
        material = run.case.material
        self.pair = run.case.packing.size[-1] == 2
        self.name, self.test = NAMES[material.youngs_modulus], 1 if self.pair else 2
        names = ("youngs_modulus", "poisson_ratio", "density")
        constants = {name: getattr(material, name) for name in names}
        sphere = {"shape": "sphere", "diameter": run.case.packing.diameter, "material": constants}
        self.bodies = [sphere, sphere if self.pair else "plane"]
        mass = run.case.sphere_mass / (2 if self.pair else 1)
        hertz = self.force(1e-6) / 1e-9  # F = hertz overlap^1.5
        self.overlap = (1.25 * mass * run.case.load.velocity**2 / hertz) ** 0.4
        self.largest = hertz * self.overlap**1.5

    def force(self, overlap):
        return gw.contact_force("hertz", self.bodies, overlap)

    def measured(self):
        """Largest force of the run, N."""
        return self.run["peak_force_N"] if self.pair else self.run["wall_peak_force_N"]


def measured(runs):
    """Elastic impacts, and specified and computed restitutions, (2, n)."""
    asked = [run for run in runs if run.case.material.youngs_modulus not in NAMES]
    losses = sorted(
        (
            run.case.contact.loss.dashpot.restitution if run.case.contact.loss else 1.0,
            run["restitution"],
        )
        for run in asked
    )
    return [Impact(run) for run in runs if run not in asked], np.array(losses).T


def rows(runs):
    impacts, (asked, found) = measured(runs)
    for one in impacts:
        yield gw.Row(
            f"Largest force, {one.name}",
            "N",
            ours=one.measured(),
            theory=one.largest,
            where=f"{WHERE.format(one.test)}, Hertz",
            verification=True,
        )
        if one.name in CURVES:
            overlap, force = CURVES[one.name]
            yield gw.Row(
                f"Force at an overlap of {1e6 * overlap:.4g} um, {one.name}",
                "N",
                source=force,
                ours=one.force(overlap),
                where=WHERE.format(one.test),
            )
    for restitution, ours in zip(asked, found, strict=True):
        yield gw.Row(
            f"Restitution, specified as {restitution:g}",
            source=restitution,
            ours=ours,
            where=WHERE.format(3),
        )


def pictures(runs):
    impacts, losses = measured(runs)
    figure = Figure((6.4, 2.8), layout="constrained")
    data = {}
    left, right = figure.subplots(1, 2)
    for k, one in enumerate(impacts):
        overlap = np.linspace(0, one.overlap, 60)
        left.plot(1e6 * overlap, one.force(overlap) / 1e3, f"C{k}", label=one.name)
        left.plot(1e6 * one.overlap, one.measured() / 1e3, f"C{k}.")
        if one.name in CURVES:
            left.plot(
                1e6 * CURVES[one.name][0], CURVES[one.name][1] / 1e3, f"C{k}o", fillstyle="none"
            )
        word = one.name.replace(" ", "_")
        data |= {f"{word}_overlap_m": overlap, f"{word}_force_N": one.force(overlap)}
    right.plot(*losses, "C0.", label="ours")
    right.plot([0, 1], [0, 1], "0.5", linewidth=0.9)
    left.set(xlabel="Overlap (um)", ylabel="Force (kN)")
    right.set(xlabel="Specified restitution", ylabel="Restitution of the run")
    left.legend(fontsize=8)
    caption = "Tests 1 and 2, force against overlap with the largest force of the runs and printed points; and test 3"
    yield gw.Picture("", caption, figure, data | {"asked": losses[0], "found": losses[1]})
