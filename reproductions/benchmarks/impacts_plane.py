"""Spheres that hit a rigid plane at a fixed normal velocity: tests 5 and 6 of Chung and Ooi.

In test 5 the spheres slide along the plane, with friction 0.3 and without damping. Incidence,
rebound and spin refer to the contact point, and are divided by friction times the normal velocity.
In test 6 the spheres spin, with friction 0.4 and restitution 0.5. Where spheres slide throughout,
the theory of rigid bodies holds. At smaller incidence the theory is partial slip after Mindlin and
Deresiewicz. In test 5 finite elements of a steel sphere and runs with contact.tangential =
"partial_slip" agree with it; single springs do not.
"""

import itertools

import numpy as np
from impacts_foundation import Rebound
from impacts_printed import FINITE_ELEMENTS_REBOUND, FINITE_ELEMENTS_SPIN, TEST_5, TEST_6
from matplotlib.figure import Figure
from scipy.interpolate import Akima1DInterpolator

import granwave as gw

NAMES = {2.08e11: "steel", 1e9: "polyethylene", 7e10: "alloy", 2.5e9: "nylon"}
WHERE = "Chung and Ooi 2011, test {}"
REMARKS = {
    5: "The theory is partial slip. The finite elements in the same figure agree with this "
    "theory; a single spring does not.",
    6: "The theory is partial slip. Their tangential motion is damped in the same way as the "
    "normal motion, which explains most of the difference.",
}
FINITE = {
    "one spring": "The finite elements agree with the theory of partial slip; a single spring "
    "does not.",
    "partial slip": "",
}


class Point:
    """Incidence, and two values of the rebound: ours and with partial slip."""

    def __init__(self, run):
        one = Rebound(run)
        self.partial = one.case.contact.tangential == "partial_slip"
        self.name = NAMES[one.case.material.youngs_modulus]
        self.slides = not any(one.case.load.spin)
        scale = one.case.contact.friction if self.slides else 1.0
        first = one.surface[0]
        self.incidence = first / (scale * one.normal)

        def numbers(normal, across, spin):
            surface = across + one.radius * spin
            other = one.radius * spin / (scale * one.normal) if self.slides else -surface / first
            return surface / (scale * normal), other

        self.ours = numbers(one.normal_after, one.across_after, one.spin_after)
        self.theory = numbers(*one.with_partial_slip())


def measured(runs, partial=False):
    """Points by the name of their material, in order of rising incidence: (5, n), with the
    incidence, two values of ours and two of theory.
    """
    points = [point for point in map(Point, runs) if point.partial == partial]
    return {
        name: np.array(
            sorted((p.incidence, *p.ours, *p.theory) for p in points if p.name == name)
        ).T
        for name in NAMES.values()
        if any(p.name == name for p in points)
    }


def rows(runs):
    found = measured(runs)
    tests = (
        (5, TEST_5, ("steel", "polyethylene"), ("rebound", "spin"), (1, 2.01, 3.33, 6)),
        (
            6,
            TEST_6,
            ("alloy", "nylon"),
            ("rebound", "restitution of the surface"),
            (0.268, 1, 1.732, 3.732),
        ),
    )
    for test, printed, names, quantities, chosen in tests:
        for column, name in enumerate(names if names[0] in found else ()):
            values = found[name]
            for k, quantity in enumerate(quantities):
                # columns of test 5: both values of a material; of test 6: rebounds of both,
                # restitutions of both
                source = printed[1 + 2 * column + k] if test == 5 else printed[1 + column + 2 * k]
                for incidence in chosen:
                    at = np.abs(values[0] - incidence).argmin()
                    value = source[np.abs(printed[0] - incidence).argmin()]
                    remark = REMARKS[test] if incidence < (4 if test == 5 else 2) else ""
                    yield gw.Row(
                        f"Test {test}, {quantity} at incidence {incidence:g}, {name}",
                        source=value,
                        ours=values[1 + k, at],
                        theory=values[3 + k, at],
                        where=WHERE.format(test),
                        remark=remark,
                    )
    if "steel" not in found:
        return
    both = {"one spring": found["steel"], "partial slip": measured(runs, partial=True)["steel"]}
    pairs = (("rebound", FINITE_ELEMENTS_REBOUND), ("spin", FINITE_ELEMENTS_SPIN))
    for k, (quantity, points) in enumerate(pairs):
        for (incidence, value), (label, steel) in itertools.product(
            points.T[[3, 6, 9]], both.items()
        ):
            ours, theory = (
                float(Akima1DInterpolator(steel[0], steel[n + k])(incidence)) for n in (1, 3)
            )
            yield gw.Row(
                f"Test 5, {quantity} of finite elements at incidence {incidence:g}, {label}",
                source=value,
                ours=ours,
                theory=theory,
                where=f"finite elements in {WHERE.format(5)}",
                remark=FINITE[label],
            )


def pictures(runs):
    found = measured(runs)
    partial = measured(runs, partial=True).get("steel")
    for test, printed, names in ((5, TEST_5, ("steel",)), (6, TEST_6, ("alloy", "nylon"))):
        if names[0] not in found:
            continue
        figure = Figure((6.8, 2.9), layout="constrained")
        data = {}
        labels = ("Rebound", "Spin" if test == 5 else "Restitution of the surface")
        for k, (axes, label) in enumerate(zip(figure.subplots(1, 2), labels, strict=True)):
            if test == 5:
                points = (FINITE_ELEMENTS_REBOUND, FINITE_ELEMENTS_SPIN)[k]
                axes.plot(*points, "ks", markersize=4, label="finite elements, steel")
                axes.plot(*partial[[0, 1 + k]], "C2.-", label="ours, steel, partial slip")
                data[f"steel_ours_partial_slip_{labels[k].lower()}"] = partial[1 + k]
            single = ", one spring" if test == 5 else ""
            for column, name in enumerate(names):
                colour = f"C{column}"
                source = printed[1 + k] if test == 5 else printed[1 + column + 2 * k]
                axes.plot(
                    printed[0],
                    source,
                    "o",
                    color=colour,
                    fillstyle="none",
                    label=f"Chung and Ooi, {name}",
                )
                axes.plot(
                    found[name][0],
                    found[name][1 + k],
                    ".-",
                    color=colour,
                    label=f"ours, {name}{single}",
                )
                axes.plot(
                    found[name][0], found[name][3 + k], ":", color=colour, label=f"theory, {name}"
                )
                data[f"{name}_incidence"] = found[name][0]
                data[f"{name}_{label.lower().replace(' ', '_')}"] = found[name][1 + k]
                data[f"{name}_partial_slip_{label.lower().replace(' ', '_')}"] = found[name][3 + k]
            axes.set(xlabel="Incidence", ylabel=label, xlim=(0, None))
        figure.legend(
            *axes.get_legend_handles_labels(), loc="outside upper center", ncols=3, fontsize=8
        )
        caption = f"Test {test}: a sphere on a plane, {'sliding' if test == 5 else 'spinning'}. Incidence and rebound "
        caption += "are tangents of the surface" + (
            ", divided by the friction" if test == 5 else ""
        )
        yield gw.Picture("sliding" if test == 5 else "spinning", caption, figure, data)
