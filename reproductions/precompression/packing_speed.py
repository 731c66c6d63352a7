"""Precompressed packings: speed of small waves.

Small impacts act on packings under static pressure, along the stacking direction. c0 follows from
the times of the crests of the mean velocities of the layers, at the positions of the layers before
the load. Theory: c0 = h sqrt((2 k - f/D)/m), with layers h = D sqrt(2/3) apart, k = 3/2 f/alpha and
a contact force f = p D^2/(2 sqrt 2), which follows from the balance of a layer (uniaxial) and from
the virial (uniform).
"""

from itertools import groupby

import numpy as np
from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import power_law, speed_along_layers
from granwave.theory import precompressed_line

MARKS = {"fcc, uniaxial": "oC0", "hcp, uniaxial": "sC1", "fcc, uniform": "xC2"}
UNEVEN = "With free sides the static forces are not uniform."


def measured(runs):
    """Packing and load in words; pressure, Pa, speed and theoretical speed, m/s."""
    points = []
    for run in runs:
        case = run.case
        line = precompressed_line(run.case)
        name = f"{case.packing.kind}, {case.precompression.kind}"
        points.append(
            (name, case.precompression.pressure, speed_along_layers(run.result, line), line.speed)
        )
    for name, found in groupby(sorted(points), key=lambda point: point[0]):
        yield name, *np.array([point[1:] for point in found]).T


def rows(runs):
    # fmt: off
    for name, pressure, speed, theory in measured(runs):
        yield gw.Row(f"Exponent of the speed against the pressure, {name}", ours=power_law(pressure, speed).exponent,
                     theory=1 / 6, verification=True, where="Hertz lattice", remark=(
                         "This value follows from similarity."))
        for p, ours, expected in zip(pressure, speed, theory, strict=True):
            yield gw.Row(f"Speed of small waves, {name}, {p:.4g} Pa", "m/s", ours=ours, theory=expected,
                         where="Hertz lattice", remark=UNEVEN if abs(ours / expected - 1) > 0.01 else "")
    # fmt: on


def pictures(runs):
    figure = Figure((3.4, 2.6), layout="constrained")
    data = {}
    axes = figure.subplots()
    for name, pressure, speed, theory in measured(runs):
        axes.loglog(pressure, theory, "0.5", label="theory" if not data else "")
        axes.loglog(pressure, speed, MARKS[name], fillstyle="none", markersize=6, label=name)
        word = name.replace(", ", "_")
        data |= {
            f"{word}_pressure_Pa": pressure,
            f"{word}_speed_m_s": speed,
            f"{word}_theory_m_s": theory,
        }
    axes.set(xlabel="Pressure (Pa)", ylabel="Speed of small waves (m/s)")
    axes.legend(loc="upper left")
    caption = (
        "Speed of small waves against pressure, by packing and kind of pressure. The theory, a "
        "power of 1/6, is not fitted: marks on its line show that the loaded packing is a lattice "
        "of linear springs"
    )
    yield gw.Picture("precompressed_packing_speed", caption, figure, data)
