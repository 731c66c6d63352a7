"""Precompressed chain: waves on 20 N.

Impacts at 1 mm/s to 100 m/s act on a chain under a static force of 20 N. F_m, which includes F0,
and the speed of the crest are measured at three quarters of the path to the far end. Theory: the
travelling wave of the lattice, slightly faster than equation 3, which holds for a continuum. The
equation is right in the limits: its last factors approach 1 as f_r = F_m/F0 approaches 1, and
0.9314 sqrt(8/15) = 0.6802 turns it into equation 4 for large f_r.
"""

import numpy as np
from matplotlib.figure import Figure
from struck_chain import SMALL, WHERE, Wave, solitary_speed

import granwave as gw
from granwave.theory import lattice_speed

IMPULSE = (
    0.7176 * (9 / 16 * 1.5**3) ** 0.2
)  # thesis (4.5), of the lattice, in units of the static state
SPREADS = (
    "The crest still spreads and decreases: the pulse is not yet a solitary wave, and is slower."
)


def measured(runs):
    return sorted(map(Wave, runs), key=lambda wave: wave.velocity)


def rows(runs):
    waves = measured(runs)
    first = waves[0]
    last = waves[-1]
    for wave in waves:
        remarks = [f"Equation 3 gives {wave.printed:.5g} m/s.", "" if wave.steady else SPREADS]
        small = wave.ratio < 1 + SMALL
        remarks.append("Theory: speed of the crest in the linear chain." if small else "")
        yield gw.Row(
            f"Speed of the wave, F_m/F0 = {wave.ratio:.4g}, impact at {wave.velocity:g} m/s", "m/s", ours=wave.speed,
            theory=wave.linear_speed if small else wave.of_lattice, where=WHERE, remark=" ".join(filter(None, remarks)),
        )  # fmt: skip
    # fmt: off
    yield gw.Row(f"F_m/F0 at {first.velocity:g} m/s", ours=first.ratio, where="ours",
                 theory=1 + first.linear_height(first.reduced_velocity),
                 remark=f"Theory: the linear chain at contact {first.middle + 1}.")
    yield gw.Row(f"F_m/F0 at {last.velocity:g} m/s", ours=last.ratio, where="thesis 4.5",
                 theory=1 + IMPULSE * last.reduced_velocity**1.2,
                 remark="Theory: the value of the uncompressed chain after the same impact, plus "
                        "1, which is the limit for small F0.")
    # fmt: on


def pictures(runs):
    waves = measured(runs)
    x, ratio, speed = np.array(
        [(wave.reduced_velocity, wave.ratio, wave.speed / wave.c0) for wave in waves]
    ).T
    steady = np.array([wave.steady for wave in waves])
    figure = Figure((6.6, 2.7), layout="constrained")
    left, right = figure.subplots(1, 2)
    line = np.geomspace(1, 1.5 * ratio.max(), 200)
    fine = np.geomspace(x.min(), x.max(), 50)
    left.semilogx(line, solitary_speed(line), "0.5", label="composite (3)")
    left.semilogx(line, lattice_speed(line), ":k", label="lattice")
    right.loglog(fine, waves[0].linear_height(fine), "C2:", label="linear chain")
    right.loglog(fine, IMPULSE * fine**1.2, "C1--", label="uncompressed: power 6/5")
    for axes, places, values in ((left, ratio, speed), (right, x, ratio - 1)):
        axes.plot(places[steady], values[steady], "oC0", markersize=4, label="simulation")
        axes.plot(
            places[~steady], values[~steady], "oC0", mfc="w", markersize=4, label="still spreading"
        )
        axes.legend(loc="upper left")
    left.set(xlabel=r"$f_r = F_m/F_0$", ylabel=r"Speed / $c_0$")
    right.set(xlabel=r"Impact velocity / $\omega\alpha_0$", ylabel=r"Crest $F_m/F_0 - 1$")
    data = {
        "static_force_N": [w.static for w in waves],
        "impact_velocity_m_s": [w.velocity for w in waves],
    }
    data |= {
        "reduced_velocity": x,
        "force_ratio": ratio,
        "speed_over_c0": speed,
        "steady": steady.astype(int),
    }
    data |= {"solitary_over_c0": solitary_speed(ratio), "lattice_over_c0": lattice_speed(ratio)}
    caption = (
        "Speed against the height of the wave, and height against impact velocity, in a "
        "precompressed chain. Steady waves (full marks) lie on the line of the lattice; on the "
        "right they pass from the weak to the strong limit"
    )
    yield gw.Picture("precompressed_chain_waves_20_N", caption, figure, data)
