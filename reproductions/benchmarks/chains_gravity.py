"""A vertical chain under gravity: powers of the depth in the speed and amplitude of a weak wave.

The force of a contact grows with the depth h, so a weak wave speeds up and spreads on its way down.
Hong, Ji and Kim (arXiv:cond-mat/9812137) find the powers of h for contacts with force ~ overlap^p.
The power is (1 - 1/p)/2 for the speed and -(1/3 + 1/p)/4 for the largest velocity of the grains;
here p = 3/2.
"""

import numpy as np
from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import Chain, first_peak, power_law

WHERE = "Hong, Ji and Kim 1998, abstract"
POWER = 1.5
SPEED = (1 - 1 / POWER) / 2
VELOCITY = -(1 / 3 + 1 / POWER) / 4
STRETCHES = ((10, 30), (30, 90), (60, 180))  # ranges of beads
FAR = (
    "The powers hold at great depth. Our powers approach these values as the range of the fit "
    "moves down."
)


def measured(runs):
    """Depth, time and height of the first peak of each bead's velocity, and its speed there."""
    (chain,) = map(Chain, runs)
    peaks = [first_peak(chain.time, velocity, floor=0.5) for velocity in chain.velocity.T]
    time, height = np.array(peaks).T
    depth = chain.case.packing.diameter * (np.arange(len(time)) + 0.5)
    return depth, time, height, np.gradient(depth, time)


def rows(runs):
    depth, _, height, speed = measured(runs)
    for first, last in STRETCHES:
        part = slice(first - 1, last)
        at = f"beads {first} to {last}"
        fits = (power_law(depth[part], height[part]), power_law(depth[part], speed[part]))
        for what, fit, printed in zip(
            ("largest velocity", "speed"), fits, (VELOCITY, SPEED), strict=True
        ):
            yield gw.Row(
                f"Exponent of the {what} against the depth, {at}",
                "",
                printed,
                fit.exponent,
                WHERE,
                FAR,
                digits=4,
            )


def pictures(runs):
    depth, _, height, speed = measured(runs)
    figure = Figure((6.6, 2.6), layout="constrained")
    shown = slice(2, -12)
    deep = 150
    left, right = figure.subplots(1, 2)
    for axes, values, power in ((left, height, VELOCITY), (right, speed, SPEED)):
        axes.loglog(
            depth[shown],
            values[deep] * (depth[shown] / depth[deep]) ** power,
            "0.5",
            label=f"power {power:.3g}",
        )
        axes.loglog(depth[shown], values[shown], "C0.", markersize=3, label="simulation")
        axes.set_xlabel("Depth (m)")
        axes.legend()
    left.set_ylabel("Largest velocity (m/s)")
    right.set_ylabel("Speed of the crest (m/s)")
    caption = (
        "Largest velocity of the beads and speed of the wave against the depth in a chain under "
        "gravity. Lines have the powers of the source and pass through the value of one deep "
        "bead. The points approach them as the wave moves down"
    )
    yield gw.Picture(
        "gravity_chain",
        caption,
        figure,
        {"depth_m": depth, "velocity_m_s": height, "speed_m_s": speed},
    )
