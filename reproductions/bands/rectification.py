"""Chain with a light bead: rectification and switching.

A chain under a static force, with a light bead near one end, is driven at its first bead at a
frequency above the cut-off. The mean power absorbed at its end in the last half of each run is
drawn against the amplitude of the drive, with the light bead near the drive and near the other end.
Dashed: the steady response to small motions, with damping in the contacts. Near the amplitude at
which transmission starts, the instability grows or decays so slowly that the mean is taken over a
state that is not yet steady.
"""

import math
from functools import cached_property
from itertools import pairwise

import numpy as np
from matplotlib.figure import Figure
from scipy.linalg import eigvalsh_tridiagonal

import granwave as gw
from granwave.measures import Chain

# A row under a static force does not pass frequencies above its cut-off. A light bead near one end
# has a mode of its own above it. A drive between the two excites it if it is near, the more the
# larger the motion, for Hertz's contacts soften; above some amplitude this motion is not stable,
# and feeds two frequencies that the row passes and whose sum is that of the drive. From the other
# end the drive hardly reaches the light bead, and the row stays shut up to a larger amplitude
# (Boechler, Theocharis, Daraio, Nature Materials 10, 665, 2011).
OPEN = 10.0  # power over the power of small motions, above which the chain has switched
SIDES = ("near the drive", "at the far end")


class Driven:
    """A run of a chain driven by a displacement; small: power of small motions divided by the
    square of the amplitude, W/m^2.
    """

    def __init__(self, run, small):
        load = run.case.load
        self.run = run
        self.small = small
        self.amplitude = load.amplitude
        self.frequency = load.frequency
        self.through = run["absorbed_power_W"]
        self.gain = self.through / (small * self.amplitude**2)

    @cached_property
    def static(self):
        """Static overlap of two identical beads, m, and the cut-off frequency of the chain without
        the light bead, Hz.
        """
        case = self.run.case
        diameter = self.run.case.packing.diameter
        overlap = self.overlap(diameter, diameter)
        return overlap, math.sqrt(
            1.5 * case.precompression.force / overlap / case.sphere_mass
        ) / math.pi

    def overlap(self, *diameters):
        name = self.run.case.material.name
        bodies = [
            {"shape": "sphere", "diameter": diameter, "material": name} for diameter in diameters
        ]
        return gw.contact_overlap("hertz", bodies, self.run.case.precompression.force)

    @cached_property
    def mode(self):
        """Frequency of the mode of the light bead, with the driven and the last bead held, Hz."""
        spheres = self.run.spheres
        force = self.run.case.precompression.force
        spring = [1.5 * force / self.overlap(*pair) for pair in pairwise(2 * spheres["radius"])]
        mass = spheres["mass"].to_numpy()[1:-1]
        beside = -np.array(spring[1:-1]) / np.sqrt(mass[1:] * mass[:-1])
        diagonal = np.add(spring[1:], spring[:-1]) / mass
        return math.sqrt(eigvalsh_tridiagonal(diagonal, beside)[-1]) / (2 * math.pi)

    @cached_property
    def below(self):
        """Fraction of the last bead's motion at frequencies below the cut-off, in the last half of
        the run.
        """
        chain = Chain(self.run)
        last = chain.velocity[chain.time >= chain.time[-1] / 2, -1]
        power = np.abs(np.fft.rfft((last - last.mean()) * np.hanning(len(last)))) ** 2
        frequency = np.fft.rfftfreq(
            len(last), (chain.time[-1] - chain.time[0]) / (len(chain.time) - 1)
        )
        return power[frequency < self.static[1]].sum() / power.sum()


def measured(runs):
    """Runs with the light bead near the drive, and at the far end, in rising order of amplitude."""
    found = {}
    for side, near in zip(SIDES, (True, False), strict=True):
        same = [
            run
            for run in runs
            if (2 * run.case.replace[0].index[0] <= run.case.packing.size[0]) == near
        ]
        same.sort(key=lambda run: run.case.load.amplitude)
        (damper,), frequency = same[0].case.absorb, same[0].case.load.frequency
        ratio = gw.transmission(
            same[0].case, drive=1, sensors=damper.index[0], frequencies=[frequency]
        )
        small = (
            damper.impedance
            * (2 * math.pi * frequency * ratio["amplitude_ratio"].values.item()) ** 2
            / 2
        )
        found[side] = [Driven(run, small) for run in same]
    return found


def switch(same):
    """Amplitudes, m, between which the ratio of the power to the power of small motions increases
    most; None if it is constant.
    """
    if max(one.gain for one in same) < OPEN:
        return None
    size, gain = np.log([(one.amplitude, max(one.gain, 1e-300)) for one in same]).T
    place = np.argmax(np.diff(gain) / np.diff(size))
    return same[place].amplitude, same[place + 1].amplitude


def ratios(found):
    """Ratio of the power with the light bead near the drive to the power with it at the far end,
    for each amplitude.
    """
    return np.array([near.through / far.through for near, far in zip(*found.values(), strict=True)])


def rows(runs):
    found = measured(runs)
    # fmt: off
    for side, (least, *_) in found.items():
        yield gw.Row(f"Light bead {side}, {least.amplitude:g} m: transmitted power / square of the amplitude",
                     "W/m^2", ours=least.through / least.amplitude**2, theory=least.small, verification=True,
                     where="last half of the run")
        yield gw.Row(f"Light bead {side}: drive frequency / frequency of its mode", where="modes of the static "
                     "state", ours=least.frequency / least.mode,
                     remark=f"The mode is at {least.mode:.0f} Hz, the cut-off of the chain at {least.static[1]:.0f} "
                            "Hz.")
    for side, same in found.items():
        if between := switch(same):
            yield gw.Row(f"Light bead {side}: drive amplitude at which transmission starts", "m", digits=2,
                         ours=math.sqrt(math.prod(between)), remark="Between {:g} and {:g} m; static overlap {:.3g} "
                         "m.".format(*between, same[0].static[0]))
    near = found[SIDES[0]]
    ratio = ratios(found)
    best = ratio.argmax()
    for place, which in ((0, "smallest amplitude"), (best, "amplitude where it is largest")):
        yield gw.Row(f"Transmitted power, light bead near the drive / at the far end, {which}", ours=ratio[place],
                     remark=f"At {near[place].amplitude:g} m.", digits=3)
    for side, same in found.items():
        yield gw.Row(f"Light bead {side}, {near[best].amplitude:g} m: share of the last bead's motion below the row's "
                     "cut-off", ours=same[best].below, where="power spectrum, last half of the run", digits=3)
    # fmt: on


def pictures(runs):
    found = measured(runs)
    figure = Figure((7, 2.9), layout="constrained")
    data = {}
    left, right = figure.subplots(1, 2)
    for n, (side, same) in enumerate(found.items()):
        size, through, small, given = np.array(
            [
                (d.amplitude, d.through, d.small * d.amplitude**2, d.run["load_power_W"])
                for d in same
            ]
        ).T
        left.loglog(
            1e6 * size,
            through,
            "os"[n] + "-",
            markersize=3,
            color=f"C{n}",
            label=f"light bead {side}",
        )
        left.loglog(1e6 * size, small, "--", color=f"C{n}", linewidth=0.8)
        if between := switch(same):
            left.axvspan(*(1e6 * one for one in between), color=f"C{n}", alpha=0.15, linewidth=0)
        word = ("near", "far")[n]
        data |= {f"amplitude_m_{word}": size, f"power_W_{word}": through, f"small_W_{word}": small}
        data[f"load_power_W_{word}"] = given
    left.set(xlabel="Amplitude of the drive (µm)", ylabel="Transmitted power (W)")
    left.legend()
    right.axhline(1.0, color="k", linewidth=0.6)
    right.loglog(1e6 * size, ratios(found), "o-", markersize=3, color="C2")
    right.set(xlabel="Amplitude of the drive (µm)", ylabel="Power ratio, near / far")
    data |= {"amplitude_m": size, "near_over_far": ratios(found)}
    caption = (
        "Power transmitted through a chain against the amplitude of its drive in the gap "
        "(dashed: small motions; shaded: where "
    )
    caption += (
        "transmission starts), and ratio of the powers for the two positions of the light bead"
    )
    yield gw.Picture("rectification_power", caption, figure, data)
