"""Chains of brass and of PTFE: speeds measured with an interferometer.

Olivares and others (Optica Applicata 47, 257, 2017) measured the speed of the wave after the impact
of a ball on a chain of equal balls: 346 ± 40 m/s in brass under 0.8 N, 102 ± 3 m/s in PTFE under
0.4 N. The abstract gives neither the diameter nor the velocity of the striker. Far above the static
force, the ratio of the two speeds is independent of them.
"""

import math
from itertools import groupby

import numpy as np
from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import Chain, first_peak

WHERE = "Olivares et al. 2017, abstract"
MEASURED = {"brass": 346.0, "ptfe": 102.0}
MARGIN = {"brass": 40.0, "ptfe": 3.0}
# contacts
FIRST = 15
LAST = 30


def ball(chain):
    return "ptfe" if chain.case.material.poisson_ratio > 0.4 else "brass"


def stiffness(chain):
    """Effective modulus divided by density, m^2/s^2; speeds far above the static force are
    proportional to its power 2/5.
    """
    return chain.law.effective_modulus / chain.case.material.density


def measured(runs):
    """Impact velocities and speeds by material, and the ratio of modulus to density of each."""
    found = {}
    chains = sorted(map(Chain, runs), key=lambda chain: (ball(chain), chain.load.velocity))
    for key, alike in groupby(chains, key=ball):
        points = []
        for chain in alike:
            added = chain.force - chain.case.precompression.force
            times = [first_peak(chain.time, one, floor=0.5)[0] for one in added.T[FIRST:LAST]]
            speed = chain.case.packing.diameter / np.polyfit(np.arange(len(times)), times, 1)[0]
            points.append((chain.load.velocity, speed))
        found[key] = *np.array(points).T, stiffness(chain)
    return found


def rows(runs):
    (velocity, brass, stiff), (_, ptfe, soft) = (measured(runs)[key] for key in ("brass", "ptfe"))
    source = MEASURED["brass"] / MEASURED["ptfe"]
    strong = (stiff / soft) ** 0.4
    margin = source * math.hypot(*(MARGIN[key] / MEASURED[key] for key in MEASURED))
    for v, ours in zip(velocity, brass / ptfe, strict=True):
        needed = (source / ours) ** -2.5
        remark = (
            f"The measured ratio is {source:.2f} ± {margin:.2f}. The source prints neither the "
            "diameter of the balls nor the velocity of the striker; both are our choice. To "
            "reproduce the measured ratio, the PTFE modulus would have to be smaller. For the "
            f"impact at {v:g} m/s it would have to be {needed:.2f} times our value."
        )
        yield gw.Row(f"Speed in brass / speed in PTFE, impact at {v:g} m/s", "", source, ours, WHERE, remark,
                     theory=strong, digits=4)  # fmt: skip
    yield gw.Row("Speed in brass at the impact that gives the measured speed in PTFE", "m/s", MEASURED["brass"],
                 MEASURED["ptfe"] * strong, WHERE,
                 "The measured value is ± 40 m/s. Our value is the measured speed in PTFE times "
                 "the computed ratio of the speeds of strong waves, since the source prints "
                 "neither beads nor striker.")  # fmt: skip


def pictures(runs):
    figure = Figure((3.6, 2.6), layout="constrained")
    data = {}
    axes = figure.subplots()
    for colour, (key, (velocity, speed, _)) in zip(
        ("C0", "C1"), measured(runs).items(), strict=True
    ):
        axes.loglog(velocity, speed, "o-", color=colour, markersize=4, label=f"{key}, simulation")
        axes.axhspan(
            MEASURED[key] - MARGIN[key],
            MEASURED[key] + MARGIN[key],
            color=colour,
            alpha=0.25,
            linewidth=0,
        )
        data |= {f"{key}_velocity_m_s": velocity, f"{key}_speed_m_s": speed}
    axes.set(xlabel="Impact velocity (m/s)", ylabel="Speed of the wave (m/s)")
    axes.legend(fontsize=6)
    caption = (
        "Speed of the wave in chains of brass and PTFE against the impact velocity, 10 mm beads, "
        "with the measured speeds as bands. At one velocity both marks should lie in their bands; "
        "the marks of PTFE lie too high"
    )
    yield gw.Picture("brass_teflon_chains", caption, figure, data)
