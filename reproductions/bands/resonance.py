"""Resonance of a bead on a plane.

A bead under a static force is driven at frequencies near its natural frequency. The frequency of
the largest velocity falls with the square of the amplitude. Where damping is small, the amplitude
jumps while the load rises and falls.
"""

import math
from itertools import groupby

import numpy as np
from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import amplitude_sweep

# A static force F0 makes the overlap a0; with the motion x = a0 xi of the bead of mass m
#     m x'' = F0 - F0 (1 + xi)^(3/2) = -k x (1 + a2 xi + a3 xi^2 + ...),   k = 3 F0/(2 a0),   a2 = 1/4, a3 = -1/24
# and by perturbation (Landau and Lifshitz, Mechanics, 28) the frequency of vibrations of the
# amplitude xi is
#     omega = omega0 (1 + (3/8 a3 - 5/12 a2^2) xi^2) = omega0 (1 - xi^2/24)
# on which the velocity of a weakly damped bead has its largest values. Above some force the answer
# has three branches, two of which are stable: the bead jumps.
SHIFT = -1 / 24  # relative change of the frequency, for an amplitude of the static overlap


class Shaken:
    """A run of a driven bead; frequencies divided by the frequency of small vibrations, amplitudes
    by the static overlap.
    """

    def __init__(self, run):
        case = run.case
        static = run.case.precompression.force
        bodies = [
            {"shape": "sphere", "diameter": case.packing.diameter, "material": case.material.name},
            "plane",
        ]
        overlap = gw.contact_overlap("hertz", bodies, static)
        self.own = math.sqrt(1.5 * static / overlap / case.sphere_mass) / (2 * math.pi)  # Hz
        self.force = case.load.amplitude
        self.hertz = case.load.frequency
        self.frequency, self.unit = (
            self.hertz / self.own,
            2 * math.pi * self.hertz * overlap,
        )  # amplitude of its velocity, m/s
        self.sweep = amplitude_sweep(run.result)
        self.velocity = 0.0 if self.sweep else run["driven_velocity_m_s"]
        self.overlap = overlap


def measured(runs):
    """Runs under a steady load by its force, in rising order of frequency; and runs under a load
    that rises and falls.
    """
    beads = sorted(map(Shaken, runs), key=lambda one: (one.force, one.hertz))
    steady = [one for one in beads if not one.sweep]
    swept = [one for one in beads if one.sweep]
    return {force: list(same) for force, same in groupby(steady, key=lambda one: one.force)}, swept


def peaks(steady):
    """Force, frequency and amplitude at the largest velocity for each force: a parabola through
    three points.
    """
    for force, same in steady.items():
        frequency, velocity = np.array([(one.hertz, one.velocity) for one in same]).T
        top = velocity.argmax()
        near = slice(top - 1, top + 2)
        curve = np.polyfit(frequency[near] - frequency[top], velocity[near], 2)
        shift = -curve[1] / (2 * curve[0])
        at = frequency[top] + shift
        yield (
            force,
            at / same[0].own,
            np.polyval(curve, shift) / (2 * math.pi * at * same[0].overlap),
        )


def rows(runs):
    steady, swept = measured(runs)
    found = np.array(list(peaks(steady))).reshape(-1, 3)
    for force, frequency, amplitude in found:
        own = steady[force][0].own
        yield gw.Row(
            f"Bead on a plane, {force:g} N: frequency of the largest velocity", "Hz", ours=frequency * own,
            theory=own * (1 + SHIFT * amplitude**2), where=f"amplitude {amplitude:.3f} of the static overlap",
            verification=True,
        )  # fmt: skip
    if steady:
        yield gw.Row(
            "Bead on a plane: shift of the resonance / square of the amplitude", theory=SHIFT, verification=True,
            ours=np.polyfit(found[:, 2] ** 2, found[:, 1] - 1, 1)[0], where="amplitudes divided by the static overlap",
        )  # fmt: skip
    for one in swept:
        quantity = f"Bead on a plane, driven at {one.frequency:.3f} of its frequency: hysteresis of its amplitude"
        yield gw.Row(
            quantity,
            ours=one.sweep.apart,
            remark="Compared with a load that rises and falls slowly.",
        )


def pictures(runs):
    steady, swept = measured(runs)
    if steady:
        yield answers(steady)
    if swept:
        yield jumps(swept)


def answers(steady):
    figure = Figure((3.5, 2.7), layout="constrained")
    data = {}
    largest = 0.0
    axes = figure.subplots()
    for force, same in steady.items():
        x, y = np.array([(one.frequency, one.velocity / one.unit) for one in same]).T
        axes.plot(x, y, ".-", label=f"{force:g} N", linewidth=0.8)
        data |= {f"frequency_{force:g}N": x, f"amplitude_{force:g}N": y}
        largest = max(largest, y.max())
    size = np.linspace(0, largest, 50)
    axes.plot(1 + SHIFT * size**2, size, "k--", linewidth=0.8, label="theory")
    data |= {"theory_frequency": 1 + SHIFT * size**2, "theory_amplitude": size}
    axes.set(
        xlabel="Frequency / frequency of small vibrations", ylabel="Amplitude / static overlap"
    )
    axes.legend()
    caption = (
        "Amplitude of a bead on a plane under a harmonic force. The larger the amplitude, "
        "the lower is the frequency of its largest "
    )
    caption += "value, which lies on the line of perturbation theory (dashed)"
    return gw.Picture("resonance_resonance", caption, figure, data)


def jumps(swept):
    figure = Figure((3.5, 2.7), layout="constrained")
    data = {}
    axes = figure.subplots()
    for n, one in enumerate(swept):
        x = one.sweep.load
        y = one.sweep.first[0] / one.unit
        name = f"{one.frequency:.3f}"
        for chosen, line, label in (
            (one.sweep.rising, "-", f"f/f0 = {name}"),
            (~one.sweep.rising, "--", ""),
        ):
            axes.plot(x[chosen], y[chosen], line, color=f"C{n}", linewidth=0.9, label=label)
        data |= {
            f"force_N_{name}": x,
            f"amplitude_{name}": y,
            f"rising_{name}": one.sweep.rising.astype(int),
        }
    axes.set(
        xlabel="Amplitude of the force (N), dashed: falling",
        ylabel="Amplitude / static overlap",
    )
    axes.legend()
    caption = (
        "Amplitude while the force rises (solid) and falls (dashed). Where the two differ, "
        "the bead has two steady "
    )
    caption += "motions, and jumps from one to the other at the ends"
    return gw.Picture("resonance_jumps", caption, figure, data)
