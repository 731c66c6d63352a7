"""Confined chains: velocities of beads.

Velocities of beads 100 and 150 are compared for a = 0 and for the largest precompression of the
figure, in the units of the source. The unit of time, sqrt(m_b/k_bb) in SI units, is 1.7063e-6 s for
its beads; 1 m/s is 1.1375e-4. The axes end at 4.5e-5, and bead 100 moves between 1300 and 1700,
which implies beads of 15 mm. Without precompression the beads continue to oscillate behind the
wave; with precompression they hardly move.
"""

import math

import numpy as np
from confined_rows import BEAD, TIME, VELOCITY, ConfinedRun
from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import first_peak, width
from granwave.theory import solitary_lengths

WHERE = "thesis figure 6.5"
# of the figure
PRECOMPRESSIONS = (0.0, 1.9e-3)
BEADS = (100, 150)
SHIFT = 1200  # shift of the curves with precompression in the figure
LENGTH = math.pi * math.sqrt(10) / 2  # length of a solitary wave, diameters
BEHIND = 60, 200  # units of time behind the crest; later, waves come back from the held first bead


def curves(runs):
    """Run, bead, time and velocity in the source's units, of n = 8."""
    found = {
        round(run.a, 6): run for run in map(ConfinedRun, runs) if run.n == 8 and run.impact == 1
    }
    for a in PRECOMPRESSIONS:
        for bead in BEADS:
            time, velocity = found[a].probe(bead, "vz")
            yield found[a], bead, time / TIME, velocity / VELOCITY


def rows(runs):
    # fmt: off
    for run, bead, time, velocity in curves(runs):
        when, largest = first_peak(time, velocity, floor=0.5)
        names = (f"Largest velocity times 1e5, bead {bead}",
                 f"Time of the largest velocity, bead {bead}")
        for name, ours in zip(names, (1e5 * largest, when), strict=True):
            yield gw.Row(f"{name}, {run.label}", ours=ours, where=WHERE)
        behind = (time > when + BEHIND[0]) & (time < when + BEHIND[1])
        yield gw.Row(f"Largest velocity times 1e5, {BEHIND[0]} to {BEHIND[1]} units behind the "
                     f"crest, bead {bead}, {run.label}",
                     ours=1e5 * np.abs(velocity[behind]).max(), where=WHERE, digits=3)
    half = width(*run.probe(100, "vz")) * run.speed / BEAD
    yield gw.Row(f"Length of the wave, {run.label}", "D", 5.0, where="thesis 6.2",
                 ours=half * LENGTH / solitary_lengths()["half maximum of velocity"],
                 remark='The source states "about five". The length is calculated from the width at '
                        'half the velocity, for the shape of a solitary wave of 4.97 D. It is '
                        'larger under precompression.')
    # fmt: on


def pictures(runs):
    figure = Figure((6, 2.6), layout="constrained")
    data = {}
    axes = figure.subplots()
    for run, bead, time, velocity in curves(runs):
        shift = SHIFT if run.a else 0
        axes.plot(
            time - shift, 1e5 * velocity, label=f"bead {bead}, a = {run.a:.2g}", linewidth=0.9
        )
        data |= {f"time_{bead}_a_{run.a:.2g}": time, f"velocity_{bead}_a_{run.a:.2g}": velocity}
    axes.set(
        xlabel=r"Time $\tau$ minus the shift", ylabel=r"Velocity $\times 10^5$", xlim=(-100, None)
    )
    figure.legend(loc="outside right upper")
    caption = (
        "Velocities of beads 100 and 150: with precompression there is little motion "
        "behind the wave (thesis figure 6.5). "
    )
    yield gw.Picture(
        "confined_velocities",
        f"{caption}Its curves are moved {SHIFT} units to the left",
        figure,
        data,
    )
