"""Precompressed to uncompressed chain, 0.1 m/s.

An impact at 0.1 m/s acts on a chain under ten static forces from 3 mN to 100 N. As long as c0 is
far below the speed of the wave, the wave is the wave of an uncompressed chain; for larger static
forces it is a small pulse. The two lines cross at F0 = 1.52 N.
"""

import numpy as np
from matplotlib.figure import Figure
from struck_chain import WHERE, Wave

import granwave as gw


def measured(runs):
    return sorted(map(Wave, runs), key=lambda wave: wave.static)


def rows(runs):
    waves = measured(runs)
    first = waves[0]
    last = waves[-1]
    free = first.uncompressed_speed
    chain = first.chain
    height = 0.7176 * chain.scales.impulse_force(chain.mass * first.velocity)
    spreads = "" if last.steady else " The crest still spreads and is slower than a solitary wave."
    # fmt: off
    return [
        gw.Row(f"Speed at F0 = {first.static:g} N / speed of an uncompressed chain",
            ours=first.speed / free,
               theory=first.of_lattice / free, where="composite (4)",
               remark="The two chains have the same largest dynamic force. Theory: the "
                      "travelling wave of the lattice under F0."),
        gw.Row(f"Largest force at F0 = {first.static:g} N", "N", ours=first.static + first.added,
               theory=height + first.static, where="thesis 4.5",
               remark="Theory: the uncompressed lattice, 0.7176 (m^3 E*^2 R* v^6)^(1/5), and F0."),
        gw.Row(f"Speed at F0 = {last.static:g} N", "m/s", ours=last.speed, theory=last.of_lattice, where=WHERE,
               remark=f"Equation 3 gives {last.printed:.5g} m/s.{spreads}"),
    ]
    # fmt: on


def pictures(runs):
    waves = measured(runs)
    last = waves[-1]
    free = waves[0].uncompressed_speed
    force, speed = np.array([(wave.static, wave.speed) for wave in waves]).T
    line = np.geomspace(force.min(), force.max(), 50)
    axes = Figure((3.4, 2.6), layout="constrained").subplots()
    axes.loglog(line, last.c0 * (line / last.static) ** (1 / 6), "0.5", label="c0")
    axes.axhline(free, color="C1", linestyle="--", label="uncompressed (composite 4)")
    axes.loglog(force, speed, "oC0", markersize=4, label="simulation")
    axes.set(xlabel="Static force F0 (N)", ylabel="Speed of the wave (m/s)")
    axes.set_ylim(top=1.5 * speed.max())
    axes.legend(loc="upper left")
    data = {"static_force_N": force, "speed_m_s": speed}
    data |= {"force_ratio": [wave.ratio for wave in waves], "c0_m_s": [wave.c0 for wave in waves]}
    caption = (
        f"Speed of the wave of an impact at {last.velocity:g} m/s against the static force of the "
        "chain. Far to the left of the intersection it is the speed in an uncompressed chain "
        "(dashed), far to the right the speed c0 of small pulses"
    )
    yield gw.Picture("precompressed_chain_0_1_m_s", caption, axes.figure, data)
