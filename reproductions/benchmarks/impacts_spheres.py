"""Impacts of two spinning spheres: tests 7 and 8 of Chung and Ooi.

In test 7 two equal spheres with opposite spins hit each other. Their surfaces do not slip, so that
the spins do not change and there is no sideways motion. In test 8 a spinning sphere hits a sphere
that is five times as large and 125 000 times as heavy, stiffer (case A) or of the same stiffness
(case B). The result must equal the result of test 6 with a plane, from which the printed values are
taken.
"""

import numpy as np
from impacts_foundation import Rebound
from impacts_printed import TEST_6
from matplotlib.figure import Figure

import granwave as gw

WHERE = "Chung and Ooi 2011, test {}"
DAMPED = (
    "The theory is partial slip on a plane. Their tangential motion is damped in the same "
    "way as the normal motion."
)


class Pair:
    """Two spheres; for dissimilar spheres incidence and rebound, and the rebound with partial slip
    on a plane.
    """

    def __init__(self, run):
        self.run = run
        self.alike = bool(run.case.striker)
        if self.alike:
            self.spin = run.case.load.spin[1]
            self.sideways = np.abs(run.fields.velocity.values[-1, :, 0]).max()
            return
        one = Rebound(run)
        self.case = "A" if run.case.replace[0].material.youngs_modulus > 1e12 else "B"
        first, last = one.surface
        self.incidence = first / one.normal
        self.rebound = last / one.normal_after
        normal, across, spin = one.with_partial_slip()
        self.theory = (across + one.radius * spin) / normal


def measured(runs):
    """Pairs of equal spheres, and of dissimilar spheres by case and incidence."""
    pairs = list(map(Pair, runs))
    unlike = sorted(
        (one for one in pairs if not one.alike), key=lambda one: (one.case, one.incidence)
    )
    return [one for one in pairs if one.alike], unlike


def rows(runs):
    alike, unlike = measured(runs)
    for one in alike:
        yield gw.Row(
            f"Test 7, largest velocity across at spins of {abs(one.spin):g} rad/s",
            "m/s",
            ours=one.sideways,
            theory=0.0,
            where=WHERE.format(7),
            verification=True,
        )
        inertia = 0.4 * one.run.case.sphere_mass * 0.1**2
        yield gw.Row(
            f"Test 7, spin after {abs(one.spin):g} rad/s",
            "rad/s",
            ours=np.sqrt(one.run["energy_rotational_J"] / inertia),
            theory=abs(one.spin),
            where=WHERE.format(7),
            verification=True,
        )
    for one in unlike:
        source = np.interp(one.incidence, *TEST_6[:2])
        yield gw.Row(
            f"Test 8, case {one.case}, rebound at incidence {one.incidence:.3g}",
            source=source,
            ours=one.rebound,
            theory=one.theory,
            where=WHERE.format("6 and 8"),
            remark=DAMPED if one.incidence < 2 else "",
        )


def pictures(runs):
    _, unlike = measured(runs)
    figure = Figure((4.2, 2.9), layout="constrained")
    data = {}
    axes = figure.subplots()
    axes.plot(*TEST_6[:2], "ko", fillstyle="none", label="Chung and Ooi, test 6")
    for case, mark in (("A", "C0.-"), ("B", "C1x")):
        values = np.array([(one.incidence, one.rebound) for one in unlike if one.case == case]).T
        axes.plot(*values, mark, label=f"ours, case {case}")
        data |= {f"case_{case}_incidence": values[0], f"case_{case}_rebound": values[1]}
    axes.set(xlabel="Tangent of incidence", ylabel="Tangent of rebound")
    axes.legend()
    caption = (
        "Test 8: a spinning sphere rebounds from a large sphere of equal or higher "
        "stiffness as from a plane"
    )
    yield gw.Picture("", caption, figure, data)
