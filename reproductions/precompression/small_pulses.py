"""Precompressed chain: small pulses.

An impact on the first bead of a precompressed chain keeps F_m/F0 below 1.05, at six static forces.
Such a pulse spreads, and its crest is slower than long waves. Therefore c0 follows from the times
of the crests from bead 10 on, whose delay in a linear chain is known. The source prints the
formula.
"""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import ScalarFormatter
from struck_chain import EXACT_FACTOR, PRINTED_FACTOR, WHERE, Wave

import granwave as gw
from granwave.measures import power_law


def measured(runs):
    """Waves by static force; the force, our speed, and the speed printed in the source."""
    waves = sorted(map(Wave, runs), key=lambda wave: wave.static)
    return waves, *np.array(
        [(wave.static, wave.long_wave_speed, wave.printed_c0) for wave in waves]
    ).T


def rows(runs):
    waves, force, speed, printed = measured(runs)
    # fmt: off
    yield gw.Row("Exponent of the speed of small pulses against the static force", ours=power_law(force, speed).exponent,
                 theory=1 / 6, verification=True, where=WHERE, remark=(
                     "Every correct code gives this value, because of similarity."))
    yield gw.Row("Factor of c0 in (4 E^2 F0/(a^2 rho^3 (1-nu^2)^2))^(1/6)", source=PRINTED_FACTOR, theory=EXACT_FACTOR,
                 ours=PRINTED_FACTOR * np.mean(speed / printed), where=WHERE,
                 remark="Theory: long waves of the lattice, sqrt(9/pi) 3^(-1/3) 4^(-1/6), with a the diameter.")
    for wave, ours in zip(waves, speed, strict=True):
        yield gw.Row(f"Speed of small pulses, F0 = {wave.static:g} N", "m/s", ours=ours, theory=wave.c0,
                     where="Hertz lattice")
    # fmt: on


def pictures(runs):
    _, force, speed, printed = measured(runs)
    axes = Figure((3.4, 2.4), layout="constrained").subplots()
    axes.loglog(force, printed, "0.5", label="c0 (composite 3)")
    axes.loglog(
        force,
        speed,
        "o",
        markersize=4,
        label=f"simulation: power {power_law(force, speed).exponent:.4f}",
    )
    axes.yaxis.set_minor_formatter(ScalarFormatter())
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set(xlabel="Static force F0 (N)", ylabel="Speed of small pulses (m/s)")
    axes.legend(loc="upper left")
    caption = (
        "Speed of small pulses against static force. The line is the formula of the source "
        "(composite 3), not fitted. "
    )
    caption += (
        "Hertz's law forces its power, 1/6, so that only the height of the marks is a comparison"
    )
    data = {"static_force_N": force, "speed_m_s": speed, "printed_m_s": printed}
    yield gw.Picture("precompressed_chain_small_pulses", caption, axes.figure, data)
