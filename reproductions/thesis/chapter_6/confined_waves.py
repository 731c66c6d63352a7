"""Confined chains: waves and precompression.

Chains of 15 mm beads with n small spheres around each contact lie in a rigid tube, whose radius
then shrinks by delta, with a = 2 delta/D. The impact on bead 10 is at 1 m/s. Forces are divided by
E* R*^2. The theory is the equations of symmetric motion, solved without LAMMPS in the true
geometry. The model of the source differs: its wall is softer than Hertz's contact with any wall
(factor 1.2; inside the tube 1.44 to 1.48), its rings have no contacts, and its contact directions
do not turn. The curves of the source are pictures without numbers, and its axes end at 3e-4. All
four of its statements hold in either model: rapid decay for n = 7 and 8, which precompression
removes; hardly any decay for n = 6 and 9; smaller forces and higher speeds with increasing a.
Contacts are numbered from 1.
"""

from functools import cached_property

import numpy as np
from confined_rows import FORCE, VELOCITY, WHERE, ConfinedRun, Rows, decay_of, speed_of
from matplotlib.figure import Figure
from symmetric_motion import leading_wave, waves_of

import granwave as gw

CONTACTS = (20, 50, 100, 200)
NUMBERS = (6, 7, 8, 9)  # numbers of small spheres in a ring


class Waves:
    """Rows impacted at 1 m/s by n and a, and the same rows in symmetric motion."""

    def __init__(self, runs):
        found = (run for run in map(ConfinedRun, runs) if run.impact == 1)
        self.runs = sorted(found, key=lambda run: (run.n, run.a))
        self.by_n = {n: [run for run in self.runs if run.n == n] for n in NUMBERS}
        self.force, self.time = waves_of(self.runs)

    @cached_property
    def fractions(self):
        """Integer and fractional values of n, and the decay of the equations without
        precompression.
        """
        n = np.arange(5.5, 10.01, 0.125)
        force, _ = leading_wave(
            Rows.fitting(n), 1.0, self.runs[0].struck, 110
        )  # uniform decay from contact 60 on
        return n, np.array([decay_of(one) for one in force])


def select(runs):
    return [Waves(runs)]


def rows(waves):
    n, decay = waves.fractions
    # fmt: off
    for peak in (7, 8):
        near = np.abs(n - peak - 0.15) < 0.5
        yield gw.Row(f"n of the largest decay near {peak}, a = 0", source=peak, theory=n[near][decay[near].argmax()],
                     where="thesis figure 6.6", remark=f"The theory has a decay of {decay[near].max():.3g} "
                                                       "per contact. Fractional n have a meaning "
                                                       "only in the equations.")
    for found in waves.by_n.values():
        for run in (found[0], found[-1]):
            yield gw.Row(f"Speed in the source's unit, {run.label}", ours=run.speed / VELOCITY,
                         where="thesis figure 6.4", remark=(
                             "The axis of the source extends from 0.04 to 0.085."), digits=3)
    for run, force, time in zip(waves.runs, waves.force, waves.time, strict=True):
        if run.a:
            yield gw.Row(f"Inward displacement of small spheres, {run.label}", "µm", ours=1e6 * run.inward, verification=True,
                         theory=1e6 * run.rows.inward[0], where="balance of a small sphere: wall = ring + two beads")
        for contact in CONTACTS:
            yield gw.Row(f"Peak force times 1e4 at contact {contact}, {run.label}", where=WHERE, verification=True,
                         ours=1e4 * run.peaks[contact - 1] / FORCE, theory=1e4 * force[contact - 1] / FORCE)
        yield gw.Row(f"Speed, {run.label}", "m/s", ours=run.speed, theory=speed_of(time), where=WHERE,
                     verification=True)
        theory = decay_of(force)
        told = theory > 1e-5  # peaks with an accuracy of 1e-4 do not resolve smaller changes
        yield gw.Row(f"Decay per contact, {run.label}", ours=run.decay, theory=theory, where=WHERE, digits=3,
                     remark="" if told else "The decay is smaller than the errors of the peaks.", verification=told)
    # fmt: on


def verdict(waves):
    for n, runs in waves.by_n.items():
        first = runs[0]
        last = runs[-1]
        kept = "hardly decays" if last.decay < 2e-4 else "decays"
        yield (
            f"n = {n}: the wave {kept} at a = {last.a:.2g} ({last.decay:.3g} per contact; {first.decay:.3g} "
            f"at a = {first.a:.2g}), and its speed rises from {first.speed:.0f} to {last.speed:.0f} "
            "m/s."
        )


def pictures(waves):
    figure = Figure((7, 4.8), layout="constrained")
    data = {}
    for axes, (n, runs) in zip(figure.subplots(2, 2).flat, waves.by_n.items(), strict=True):
        for run in runs:
            contact, force = run.profile
            axes.plot(contact, 1e4 * force, label=f"a = {run.a:.3g}")
            data |= {f"contact_n_{n}_a_{run.a:.3g}": contact, f"force_n_{n}_a_{run.a:.3g}": force}
        axes.set(
            xlabel="Contact", ylabel=r"Peak force $F/(E^* R^{*2}) \times 10^4$", title=f"n = {n}"
        )
        axes.set(ylim=(0, 1.5 * axes.get_ylim()[1]))
        axes.legend(ncols=2, loc="upper right")
    caption = (
        "Peak forces of the contacts of beads. Precompression reduces the force, and "
        "removes the decay for n = 7 and 8 "
    )
    yield gw.Picture("confined_peaks", f"{caption}(thesis figures 6.2 and 6.3)", figure, data)
    figure = Figure((7, 2.7), layout="constrained")
    data = {}
    left, right = figure.subplots(1, 2)
    for mark, (n, runs) in zip("os^D", waves.by_n.items(), strict=True):
        a, speed = (np.array([getattr(run, name) for run in runs]) for name in ("a", "speed"))
        left.plot(1e3 * a, speed, f"{mark}-", label=f"n = {n}", markersize=4)
        data |= {f"a_n_{n}": a, f"speed_n_{n}_m_s": speed}
    left.set(xlabel=r"Precompression $a \times 10^3$", ylabel="Speed of the wave (m/s)")
    unit = left.secondary_yaxis("right", functions=(lambda v: v / VELOCITY, lambda v: v * VELOCITY))
    unit.set_ylabel("in the source's unit")
    left.legend(ncols=2)
    n, decay = waves.fractions
    free = np.array([runs[0].decay for runs in waves.by_n.values()])
    right.plot(n, 1e3 * decay, "0.6", label="equations, any n")
    right.plot(list(waves.by_n), 1e3 * free, "o", label="simulation", markersize=4)
    right.set(
        xlabel="Small spheres around a contact, n", ylabel=r"Decay per contact $\times 10^3$, a = 0"
    )
    right.legend()
    data |= {"n_equations": n, "decay_equations": decay, "n": list(waves.by_n), "decay": free}
    caption = "Speed against precompression (thesis figure 6.4), and decay without it, largest near n = 7 and 8.25 "
    yield gw.Picture("confined_speed_and_decay", f"{caption}(thesis figure 6.6)", figure, data)
