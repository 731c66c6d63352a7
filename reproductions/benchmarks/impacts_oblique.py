"""Oblique impacts at one speed: test 4 of Chung and Ooi.

A sphere of aluminium oxide or alloy with a diameter of 5 mm hits a rigid plane at 3.9 m/s, at
angles from 4 to 85 degrees from the normal, with friction 0.092 and restitution 0.98. The rebound
angle is the angle of the contact point. Beyond about 33 degrees the sphere slides throughout, and
all programs agree. At smaller angles the result depends on the tangential spring. The tests are
defined for a no-slip spring. Our spring keeps its force, and its force is reduced as the contact
circle shrinks; the spring of the source keeps its elongation. The measurements agree with the
partial slip of the theory of Mindlin and Deresiewicz, which contact.tangential = "partial_slip"
computes.
"""

import itertools
import math

import numpy as np
from impacts_foundation import Rebound
from impacts_printed import MEASURED_REBOUND, MEASURED_RESTITUTION, MEASURED_SPIN, TEST_4
from matplotlib.figure import Figure

import granwave as gw

WHERE = "Chung and Ooi 2011, test 4"
NAMES = {3.8e11: "oxide", 7e10: "alloy"}
KINDS = (("tangential restitution", ""), ("spin", "rad/s"), ("rebound angle", "degrees"))
MODELS = {"mindlin_rescale": "one spring", "partial_slip": "partial slip"}  # contact.tangential
ONE_SPRING = (
    "Both models have a single spring: the spring of the source keeps its elongation, our "
    "spring keeps its force. The theory includes partial slip (Mindlin, Deresiewicz)."
)
EXPERIMENT = "Kharaz et al. 2001, in Chung and Ooi 2011"
MEASURED = {
    "mindlin_rescale": "The value was measured on glass. A single spring has no partial slip "
    "within the contact circle.",
    "partial_slip": "The value was measured on glass.",
}


def three(one, normal, across, spin):
    """Tangential restitution, spin and rebound angle after an impact."""
    return across / one.across, spin, math.degrees(math.atan2(across + one.radius * spin, normal))


def measured(runs):
    """Angle, our three values and the three theoretical values, by rising angle: (7, n) for each
    material and model.
    """
    found = {(name, model): [] for name in NAMES.values() for model in MODELS}
    for one in map(Rebound, runs):
        ours = three(one, one.normal_after, one.across_after, one.spin_after)
        theory = three(one, *one.with_partial_slip())
        key = NAMES[one.case.material.youngs_modulus], one.case.contact.tangential
        found[key].append((one.case.load.angle, *ours, *theory))
    return {key: np.array(sorted(values)).T for key, values in found.items()}


def rows(runs):
    found = measured(runs)
    for angle in (5, 10, 20, 30, 50):
        (printed,) = TEST_4[:, TEST_4[0] == angle].T
        for name, columns in (("oxide", printed[1:4]), ("alloy", printed[4:6])):
            columns_of = found[name, "mindlin_rescale"]
            (values,) = columns_of[:, columns_of[0] == angle].T
            for k, source in enumerate(columns):
                (quantity, unit), remark = KINDS[k], ONE_SPRING if angle < 30 else ""
                yield gw.Row(
                    f"{quantity.capitalize()} at {angle} degrees, {name}",
                    unit,
                    source=source,
                    ours=values[1 + k],
                    theory=values[4 + k],
                    where=WHERE,
                    remark=remark,
                )
    points = (MEASURED_RESTITUTION, MEASURED_SPIN, MEASURED_REBOUND)
    for k, ((quantity, unit), values) in enumerate(zip(KINDS, points, strict=True)):
        for (angle, source), (model, label) in itertools.product(values.T, MODELS.items()):
            columns = found["oxide", model]
            # angles that were both measured and computed
            for at in np.flatnonzero(columns[0] == angle):
                ours, theory = columns[[1 + k, 4 + k], at]
                name = f"{quantity.capitalize()} measured at {angle:g} degrees, oxide, {label}"
                remark = MEASURED[model]
                yield gw.Row(
                    name,
                    unit,
                    source=source,
                    ours=ours,
                    theory=theory,
                    where=EXPERIMENT,
                    remark=remark,
                )


def pictures(runs):
    found = measured(runs)
    data = {}
    figure = Figure((8.2, 2.9), layout="constrained")
    points = (MEASURED_RESTITUTION, MEASURED_SPIN, MEASURED_REBOUND)
    for k, (axes, (quantity, unit)) in enumerate(zip(figure.subplots(1, 3), KINDS, strict=True)):
        axes.plot(*points[k], "ks", markersize=4, label="measured, oxide on glass")
        axes.plot(TEST_4[0], TEST_4[1 + k], "C1o", fillstyle="none", label="Chung and Ooi, oxide")
        for (model, label), style in zip(MODELS.items(), ("C0.-", "C2.-"), strict=True):
            axes.plot(*found["oxide", model][[0, 1 + k]], style, label=f"ours, {label}")
        axes.plot(
            *found["oxide", "partial_slip"][[0, 4 + k]],
            "0.3",
            linestyle=":",
            label="theory of partial slip",
        )
        axes.set(
            xlabel="Angle of incidence (degrees)",
            ylabel=quantity.capitalize() + (f" ({unit})" if unit else ""),
        )
        word = quantity.replace(" ", "_")
        data |= {
            f"{name}_{MODELS[model].replace(' ', '_')}_{word}": v[1 + k]
            for (name, model), v in found.items()
        }
        data |= {
            f"{name}_theory_{word}": found[name, "partial_slip"][4 + k] for name in NAMES.values()
        }
    figure.legend(
        *axes.get_legend_handles_labels(), loc="outside upper center", ncols=4, fontsize=8
    )
    caption = (
        "Oblique impacts of a sphere of aluminium oxide on a plane at 3.9 m/s. Below about 25 "
        "degrees partial slip matters: measurements follow it, and single springs, ours and "
        "others, do not"
    )
    yield gw.Picture(
        "", caption, figure, {"angle_degrees": found["oxide", "partial_slip"][0]} | data
    )
