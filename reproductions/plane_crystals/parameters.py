"""Influences on speed and decay in plane crystals.

One property of the two crystals between walls is changed: height, gap at the walls, friction,
damping in contacts, mass of the plate, modulus, or size or scatter of the diameters. Only first
pulses are compared: without friction the centred-square crystal has no shear stiffness, and its
later motion is chaotic.
"""

import math

import numpy as np
from crystal import NAMES, OURS, SOURCE, Crystal
from matplotlib.figure import Figure
from motion import later_peak
from relaxation import is_of_equation

import granwave as gw

SPEED = 125.0  # m/s, printed
DENSITY = 1130.0  # kg/m3, of polyurethane
# value of the crystals in sides.toml, for the height and the number a row over those of these; in
# the order of tests
BASE = {"height": 1.0, "gap": 0.0, "friction": 0.3, "loss": 12e-6, "modulus": 70e6, "diameter": 0.0127, "count": 1.0,
        "scatter": 0.0, "plate": 20.0}  # fmt: skip
ALONE = ("diameter", "count", "scatter")  # parameters changed to only one other value
SIZE = {"BCC": (6, 16), "HCP": (8, 14)}
# values of the changed parameters that have rows
SHOWN = {
    "height": (1.5, 2.0, 3.0),
    "gap": (1e-4, 5e-4, 2e-3),
    "modulus": (150e6, 480e6, 1573e6),
}
# changed parameters whose fit of two regions is uncertain
UNSURE = {"friction": (0.6,), "loss": (0.0, 3e-6, 48e-6), "plate": (40.0, 80.0)}
FEW = (
    "The two regions have only seven or eight grains, and their border jumps from grain to "
    "grain: the fit has another minimum nearby."
)
DECAYS = {
    "friction": ("friction {:g}", 1.0), "loss": ("relaxation time of {:g} us", 1e6), "plate": ("plate of {:g} kg/m", 1.0)
}  # fmt: skip


def values(one):
    """Values of a crystal by the keys of `BASE`."""
    case, (count, layers) = one.case, SIZE[one.name]
    found = (one.layers / layers, case.boundary.gap, case.contact.friction, case.contact.loss.time or 0.0,
             case.material.youngs_modulus, case.packing.diameter, one.count / count, case.packing.diameter_scatter,
             round(case.load.mass / case.packing.length, 3))  # fmt: skip
    return dict(zip(BASE, found, strict=True))


def measured(runs):
    """Values and crystals by the changed parameter and the name of the crystal; and crystals that a
    cylinder impacts.
    """
    crystals = [Crystal(run) for run in runs if not is_of_equation(run.case)]
    series = {}
    for one in crystals:
        if (
            one.case.load.kind != "plate"
            or not one.walls
            or one.case.material.density != DENSITY
            or {"load.mass", "boundary.sides"} <= one.run.labels.keys()
        ):
            continue  # with free sides, of width.toml, or of polycarbonate
        now = values(one)
        changed = [
            what for what, base in BASE.items() if not math.isclose(now[what], base, rel_tol=1e-6)
        ]
        for what in changed[:1] or [
            what for what in BASE if what not in ALONE
        ]:  # larger grains have a heavier plate
            series.setdefault((what, one.name), []).append((now[what], one))
    struck = [one for one in crystals if one.case.load.kind == "striker"]
    return {
        key: sorted(points, key=lambda point: point[0]) for key, points in series.items()
    }, struck


def rows(runs):
    series, struck = measured(runs)
    alone = {"where": OURS}
    # fmt: off
    for name in NAMES.values():
        yield from of_modulus(series["modulus", name], name)
    for one in struck:
        yield gw.Row(f"Decay of the peak speed, first region, a rigid cylinder on the middle grain, {one.name}", "1/m",
                     ours=one.decay.first, digits=2, **alone,
                     remark="The decay differs strongly from the source value, for which the load "
                            "acts on the whole top.")
    for name in NAMES.values():
        for value, one in series["height", name]:
            if value in SHOWN["height"]:
                yield gw.Row(f"Border of the two regions, all grains, {value:g} times as high, {name}", "D", digits=2,
                             ours=one.border, **alone,
                             remark="This fit depends on the last two grains, which the floor "
                                    "supports; it is meaningful only without them.")
        for value, one in series["gap", name]:
            if value in SHOWN["gap"]:
                yield gw.Row(f"Front speed, gap of {1e3 * value:g} mm, {name}", "m/s", ours=one.down.front_speed,
                             digits=3, **alone)
        for what, (words, scale) in DECAYS.items():
            for value, one in series[what, name]:
                unsure = value in UNSURE[what] and (what, name) != ("friction", "HCP")
                kind = alone | {"remark": FEW} if unsure else {"where": SOURCE}
                yield gw.Row(f"Decay of the peak speed, first region, {words.format(value * scale)}, {name}", "1/m",
                             ours=one.decay.first, digits=2, **kind)
        for what, words in (("diameter", "1-inch grains"), ("count", "8 a row")):
            for _, one in series.get((what, name), []):
                yield gw.Row(f"Decay, first region, {words}, {name}", "1/m", ours=one.decay.first,
                             remark=FEW, digits=2, **alone)
        for value, one in series["scatter", name]:
            yield gw.Row(f"Front speed, diameters smaller by up to {1e6 * value:g} um, {name}", "m/s", digits=3,
                         ours=one.down.front_speed, **alone)
    # fmt: on


def of_modulus(points, name):
    """Rows of the speed at the printed moduli, and of the modulus that gives the printed speed."""
    moduli, speeds = np.array([(value, one.down.front_speed) for value, one in points]).T
    gives = np.exp(np.interp(np.log(SPEED), np.log(speeds), np.log(moduli))) / 1e6
    # fmt: off
    for value, speed in zip(moduli, speeds, strict=True):
        if value in SHOWN["modulus"]:
            yield gw.Row(f"Front speed at {value / 1e6:g} MPa, {name}", "m/s", SPEED, speed, f"{SOURCE}, Fig. 9", digits=3,
                         remark="The modulus and the speed printed in the source contradict each "
                                "other in an ideal crystal.")
    yield gw.Row(f"Modulus that gives 125 m/s, {name}", "MPa", 150.0, gives, f"{SOURCE}, 3", digits=2,
                 remark="The source value is the smallest of the printed effective moduli, 150 to "
                        "740 MPa.")
    value, one = min(points, key=lambda point: abs(point[1].down.front_speed - SPEED))
    yield gw.Row(f"Second, small peak of the speed in deep grains, {value / 1e6:g} MPa, {name}", "ms", 4.0,
                 1e3 * later_peak(one), f"{SOURCE}, Fig. 9", digits=2,
                 remark=f"The front has {one.down.front_speed:.0f} m/s; the source prints about "
                        "125 m/s. The time is measured from the start of the impact; the time "
                        "origin of the camera in the source is not known.")
    # fmt: on


def pictures(runs):
    series, _ = measured(runs)
    figure = Figure((7, 2.8), layout="constrained")
    data = {}
    left, right = figure.subplots(1, 2)
    for name in NAMES.values():
        for axes, what, scale in ((left, "modulus", 1e-6), (right, "gap", 1e3)):
            value, speed = np.array(
                [(value, one.down.front_speed) for value, one in series[what, name]]
            ).T
            axes.plot(value * scale, speed, "-o", markersize=3, label=name)
            data |= {f"{name}_{what}": value * scale, f"{name}_{what}_front_m_s": speed}
    left.axhline(SPEED, color="0.5", linestyle=":", label="source")
    left.set(xlabel="Young's modulus (MPa)", ylabel="Front speed (m/s)", xscale="log", yscale="log")
    right.set(xlabel="Gap at the side walls (mm)", ylabel="Front speed (m/s)", ylim=(0, None))
    left.legend()
    caption = (
        "Front speed of both crystals against the modulus and against the gap at the side "
        "walls. The speed is a power of the "
    )
    caption += (
        "modulus (straight lines); 125 m/s, as in the source (dotted), require smaller moduli "
        "than it prints"
    )
    yield gw.Picture("lateral_parameters", caption, figure, data)


def tables(runs):
    series, _ = measured(runs)
    for (what, name), points in sorted(series.items()):
        if what not in ALONE:
            crystals = [one for _, one in points]
            decays = [one.down.decay for one in crystals]
            columns = {
                "Value": [value for value, _ in points],
                "Front (m/s)": [one.down.front_speed for one in crystals],
                "First peak (m/s)": [one.peak[0] for one in crystals],
                "Decay 1 (1/m)": [decay.first for decay in decays],
                "Decay 2 (1/m)": [decay.second for decay in decays],
                "Border (D)": [
                    decay.border / points[0][1].case.packing.diameter for decay in decays
                ],
            }
            yield f"{name}, {what} (SI units; height relative to the reference)", columns
