"""A gap tuned by walls: spheres between cylinders (thesis 7.2).

The chain is infinite: brass spheres of 9.525 mm under 1 N, with a pair of brass cylinders of 4.76
mm in each gap, between two rigid walls that approach by a times the diameter. The cylinders are as
long as the spheres are wide. The bands follow from the springs of the static state. Frequencies are
angular: the axes of the source are labelled Hz, but show rad/s.
"""

import math

import numpy as np
from matplotlib.figure import Figure
from tunnel import DIAMETER, PAIR, Tunnel

import granwave as gw

THESIS = "thesis 7.2"
FIGURE = "thesis Fig. 7.8"
APPROACHES = (-1.8e-5, 0.0, 3e-5)
RATIOS = (0.3, 0.5, 0.65)
# position and duration of the source's record, s
SPHERE = 75
TIME = 5e-3
PRINTED = 5.6e3  # Hz, the source's cut-off of the row
DIGITS = 5.6e4  # rad/s, according to its digits
RADIUS_FOR_DIAMETER = 2 ** (-1 / 6)  # factor of a frequency, with sqrt(R) for sqrt(D) in k_bb
# rad/s: of Fig. 7.7a, and the source's third band
TOP_OF_AXIS = 7e4
THIRD = 3e5
# spheres, cylinders: top of the axis of Fig. 7.8, rad/s, and the source's statement on the width of
# the gap
PAIRS = {
    ("brass", "brass"): (9e4, ""), ("steel", "aluminium"): (14e4, "small"), ("aluminium", "steel"): (11e4, "large"),
}  # fmt: skip
BOTTOM = 2e4  # rad/s: of the axis
END_OF_AXIS = "The source value is the end of the axis of Fig. 7.7a, an upper bound."
IN_RADIANS = (
    "The source states the range of 0.3 MHz; its unit is rad/s, so that the third band is at "
    "3.6e5 rad/s or 58 kHz."
)


def rows(runs):
    plain = Tunnel(0.0)
    top = gw.bands(runs[0].case)["edges"].values[0, 1]
    slowest = (
        (SPHERE - 1) / TIME / plain.row_frequency
    )  # group velocity in spheres/s over sqrt(K/m)
    yield gw.Row(
        "Cut-off of the chain",
        "Hz",
        ours=top,
        theory=2 * plain.row_frequency / (2 * math.pi),
        where="2 sqrt(K/m)",
        verification=True,
    )
    yield gw.Row(
        "Cut-off of the chain",
        "Hz",
        PRINTED,
        top,
        THESIS,
        "The digits fit a value in rad/s in two ways (next rows). Nothing in the source decides "
        "between them.",
    )
    yield gw.Row(
        "Cut-off of the chain, with sqrt(R) for sqrt(D) in the constant of two spheres",
        "rad/s",
        DIGITS,
        where=THESIS,
        theory=2 * plain.row_frequency * RADIUS_FOR_DIAMETER,
        digits=4,
        remark="One possible origin of the digits of 5.6 kHz, found by trial.",
    )
    yield gw.Row(
        "Highest frequency whose waves reach sphere 75 within 5 ms",
        "rad/s",
        DIGITS,
        where=THESIS,
        digits=4,
        theory=2 * plain.row_frequency * math.sqrt(1 - slowest**2),
        remark="The group velocity is sqrt(K/m) sqrt(1 - (w/2)^2 m/K) spheres per second. This is "
        "the other possible origin of the digits, found by trial.",
    )
    for a in APPROACHES:
        edges = Tunnel(a).edges
        axis = TOP_OF_AXIS if a <= 0 else None
        yield gw.Row(
            f"Top of the acoustic band, a = {a:g}", "rad/s", ours=edges[0, 1], where=THESIS
        )
        yield gw.Row(
            f"Bottom of the optical band, a = {a:g}", "rad/s", ours=edges[1, 0], where=THESIS
        )
        yield gw.Row(
            f"Top of the optical band, a = {a:g}",
            "rad/s",
            axis,
            edges[1, 1],
            THESIS,
            bound=a <= 0,
            remark=END_OF_AXIS if axis else "",
        )
        third = "" if a else IN_RADIANS
        yield gw.Row(
            f"Top of the third band, a = {a:g}",
            "rad/s",
            None if a else THIRD,
            edges[2, 1],
            THESIS,
            third,
        )
    yield from single_cylinder()
    for pair, (highest, said) in PAIRS.items():
        places = [[Tunnel(a, ratio, *pair) for a in (-2e-5, 0.0, 3e-5)] for ratio in RATIOS]
        gap = np.array([[one.edges[[0, 1], [1, 0]] for one in row] for row in places])
        (low, high), name = gap[1, 1], "spheres of {}, {} cylinders".format(*pair)
        lowest = gap[..., 0].min()
        remark = "The bound is the end of the axis."
        if lowest < BOTTOM:
            remark += " With the density of 2100 kg/m3 that section 7.1 prints instead of 2700, "
            remark += " and ".join(f"{word} {edge:.3g}" for word, edge in lighter_edges().items())
            remark += (
                ". This density brings the lowest edge within the axis, but moves the "
                "highest edge outside."
            )
        yield gw.Row(
            f"Lower edge of the gap (source: at least this value): {name}",
            "rad/s",
            BOTTOM,
            lowest,
            FIGURE,
            remark,
            digits=3,
            bound=True,
        )
        yield gw.Row(
            f"Upper edge of the gap (source: at most this value): {name}",
            "rad/s",
            highest,
            gap[..., 1].max(),
            FIGURE,
            "The bound is the end of the axis.",
            digits=3,
            bound=True,
        )
        yield gw.Row(
            f"Width of the gap / its mid-frequency, cylinders of 0.5 D, a = 0: {name}",
            digits=3,
            where=FIGURE,
            ours=2 * (high - low) / (high + low),
            remark=f"The source calls the gap {said}." if said else "",
        )
    for ratio in RATIOS:
        low, high = (Tunnel(a, ratio).edges[0, 1] for a in (-2e-5, 3e-5))
        yield gw.Row(
            f"Shift of the acoustic top from a = -2e-5 to 3e-5, cylinders of {ratio:g} diameters",
            "rad/s",
            ours=high - low,
            where=THESIS,
            digits=3,
        )


def single_cylinder():
    """Rows of the band gap with one cylinder in each gap, as printed in 7.12, and with two."""
    for words, cylinders in (("two cylinders in a gap", PAIR), ("one, as 7.12 is printed", 1)):
        low, high = Tunnel(0.0, cylinders=cylinders).edges[[0, 1], [1, 0]]
        remark = f"{low:.5g} to {high:.5g} rad/s."
        if cylinders == 1:
            remark += " The static state follows from equation 7.5, which has two cylinders."
        yield gw.Row(
            f"Width of the gap / its mid-frequency, a = 0: {words}",
            "%",
            ours=200 * (high - low) / (high + low),
            where="thesis 7.12",
            remark=remark,
            digits=3,
        )


def lighter_edges():
    """Lowest and highest edge of the band gap, rad/s, for steel spheres and aluminium cylinders
    with the density printed in 7.1.
    """
    lighter = []
    for a in (-2e-5, 0.0, 3e-5):
        for ratio in RATIOS:
            tunnel = Tunnel(a, ratio, "steel", "light aluminium")
            lighter.append(tunnel.edges[[0, 1], [1, 0]])
    return {
        "the lowest edge is": min(low for low, _ in lighter),
        "the highest": max(high for _, high in lighter),
    }


def verdict(runs):
    low, high = (
        Tunnel(a).edges[[0, 1], [1, 0]] / 2e3 / math.pi for a in (APPROACHES[0], APPROACHES[-1])
    )
    way = 1e6 * (APPROACHES[-1] - APPROACHES[0]) * DIAMETER
    yield (
        f"If the walls approach by {way:.2g} µm, the gap of the tunnel moves from {low[0]:.3g}-{low[1]:.3g} "
        f"kHz to {high[0]:.3g}-{high[1]:.3g} kHz."
    )


def pictures(runs):
    figure = Figure((3.5, 2.6), layout="constrained")
    axes = figure.subplots()
    data = {}
    for n, a in enumerate(APPROACHES):
        tunnel = Tunnel(a)
        hertz, data["phase_rad"] = tunnel.omega / (2 * math.pi), tunnel.k * DIAMETER
        for band in (0, 1):
            label = "" if band else f"a = {a:g}"
            axes.plot(
                data["phase_rad"] / math.pi, 1e-3 * hertz[:, band], color=f"C{n}", label=label
            )
            data[f"f{band + 1}_at_{a:g}_Hz"] = hertz[:, band]
    axes.set(xlabel="Phase per cell (π)", ylabel="Frequency (kHz)", xlim=(0, 1), ylim=(0, None))
    axes.legend()
    caption = (
        "The two lowest bands of the chain at three positions of the walls. No wave passes "
        "between the two curves of a "
    )
    caption += "colour; as the walls approach, this gap moves up"
    yield gw.Picture("tunable_gap_bands", caption, figure, data)
    figure = Figure((3.5, 2.6), layout="constrained")
    axes = figure.subplots()
    places = np.linspace(-2e-5, 3e-5, 21)
    data = {"approach": places}
    for n, ratio in enumerate(RATIOS):
        top, bottom = np.array([Tunnel(a, ratio).edges[[0, 1], [1, 0]] for a in places]).T / (
            2 * math.pi
        )
        label = f"cylinders {ratio:g} D"
        axes.fill_between(
            1e5 * places, 1e-3 * top, 1e-3 * bottom, color=f"C{n}", alpha=0.35, lw=0, label=label
        )
        data |= {f"top_{ratio:g}_Hz": top, f"bottom_{ratio:g}_Hz": bottom}
    axes.set(xlabel="Approach of the walls (1e-5 diameters)", ylabel="Gap (kHz)", xlim=(-2, 3))
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, fontsize=7)
    caption = (
        "The lowest gap (shaded) against the position of the walls, for cylinders of three "
        "lengths. An approach of 5e-5 diameters moves "
    )
    caption += "it by at least its own width; shorter cylinders have a higher gap"
    yield gw.Picture("tunable_gap_gaps", caption, figure, data)
