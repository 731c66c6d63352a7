"""Confined rows: waves and precompression.

Beads of 15 mm in a row, n small spheres around each contact, in a rigid tube whose radius then
shrinks by delta, a = 2 delta/D; bead 10 is struck at 1 m/s. Forces over E* R*^2. Theory: the
equations of symmetric motion, solved apart from LAMMPS with the true geometry. The source's model
differs: a wall softer than any of Hertz's (factor 1.2; inside the tube 1.44 to 1.48), no contacts
in the rings and directions that do not turn. The curves of the source are pictures without numbers:
its axes end at 3e-4, and all four of its statements hold, in either model: rapid decay for n = 7 and 8 that
precompression takes away, hardly any for n = 6 and 9, less force and more speed with a. Contacts
count from 1.
"""

from functools import cached_property

import numpy as np
from confined_rows import FORCE, VELOCITY, WHERE, ConfinedRun, Rows, decay_of, speed_of
from matplotlib.figure import Figure
from symmetric_motion import leading_wave, waves_of

import granwave as gw

CONTACTS = (20, 50, 100, 200)
SLOWEST = {
    6: 0.0348,
    7: 0.0484,
    8: 0.0538,
    9: 0.0672,
}  # speeds of its model at a = 0 in the source's unit
# n, a; thesis model: peaks times 1e4 at contacts 21, 51, 101, 201, speed, decay; right model
PROGRAM = np.array([
    (6, 0.0,    1.872, 1.839, 1.802, 1.778, 306.7, 4.1e-4, 1.601, 1.582, 1.552, 1.535, 302.1, 3.8e-4),
    (6, 5.2e-4, 1.426, 1.417, 1.408, 1.400, 329.9, 1.3e-4, 1.350, 1.335, 1.322, 1.311, 335.3, 2.0e-4),
    (6, 1.3e-3, 0.981, 0.963, 0.958, 0.953, 344.3, 1.1e-4, 0.880, 0.869, 0.864, 0.858, 352.9, 1.3e-4),
    (6, 2.1e-3, 0.834, 0.785, 0.758, 0.729, 357.1, 7.2e-4, 0.663, 0.650, 0.650, 0.650, 368.1, 1e-5),
    (7, 0.0,    2.656, 2.442, 2.123, 1.684, 426.2, 2.8e-3, 2.613, 2.416, 2.121, 1.699, 430.3, 2.6e-3),
    (7, 5.0e-4, 2.538, 2.311, 2.008, 1.579, 462.1, 2.6e-3, 2.408, 2.181, 1.873, 1.416, 471.2, 2.9e-3),
    (7, 1.3e-3, 1.927, 1.890, 1.852, 1.782, 500.4, 3.9e-4, 1.835, 1.758, 1.669, 1.516, 513.0, 9.8e-4),
    (7, 2.0e-3, 1.607, 1.584, 1.583, 1.580, 520.3, 1.7e-5, 1.496, 1.455, 1.432, 1.388, 536.3, 3.1e-4),
    (8, 0.0,    3.259, 2.550, 1.695, 0.749, 472.5, 8.2e-3, 3.208, 2.499, 1.649, 0.717, 475.4, 8.3e-3),
    (8, 4.8e-4, 2.527, 2.292, 1.990, 1.561, 549.8, 2.5e-3, 2.477, 2.227, 1.907, 1.458, 560.6, 2.8e-3),
    (8, 1.2e-3, 1.717, 1.673, 1.642, 1.584, 591.6, 3.6e-4, 1.685, 1.624, 1.578, 1.496, 608.0, 5.4e-4),
    (8, 1.9e-3, 1.394, 1.353, 1.350, 1.343, 619.2, 4.9e-5, 1.316, 1.266, 1.259, 1.247, 637.6, 9.8e-5),
    (9, 0.0,    3.260, 3.235, 3.193, 3.112, 590.4, 2.6e-4, 3.214, 3.202, 3.182, 3.141, 596.7, 1.3e-4),
    (9, 4.6e-4, 2.506, 2.496, 2.492, 2.484, 626.9, 3.4e-5, 2.454, 2.443, 2.438, 2.428, 638.6, 4e-5),
    (9, 1.2e-3, 1.656, 1.620, 1.620, 1.620, 660.6, 1e-6,   1.587, 1.547, 1.547, 1.547, 676.5, 1e-6),
    (9, 1.9e-3, 1.288, 1.222, 1.221, 1.221, 690.1, 1e-6,   1.225, 1.154, 1.153, 1.153, 708.8, 1e-6),
])  # fmt: skip


class Waves:
    """Rows struck at 1 m/s by n and a, and the same in symmetric motion."""

    def __init__(self, runs):
        found = (run for run in map(ConfinedRun, runs) if run.impact == 1)
        self.runs = sorted(found, key=lambda run: (run.n, run.a))
        self.by_n = {n: [run for run in self.runs if run.n == n] for n in SLOWEST}
        self.force, self.time = waves_of(self.runs)

    @cached_property
    def fractions(self):
        """Values of n, whole and not, and the decay of the equations without precompression."""
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
                     where="thesis figure 6.6", remark=f"Theory: {decay[near].max():.3g} per contact. A fraction of n "
                     "has meaning in the equations only.")
    for n, found in waves.by_n.items():
        for run in (found[0], found[-1]):
            known = f" The source's model in a program that is not kept: {SLOWEST[n]:g}."
            known = "" if run.a else known
            yield gw.Row(f"Speed in the source's unit, {run.label}", ours=run.speed / VELOCITY,
                         where="thesis figure 6.4", remark=f"The axis is 0.04 to 0.085.{known}", digits=3)
    for run, force, time in zip(waves.runs, waves.force, waves.time, strict=True):
        if run.a:
            yield gw.Row(f"Small spheres moved in, {run.label}", "µm", ours=1e6 * run.inward, verification=True,
                         theory=1e6 * run.rows.inward[0], where="balance of a small sphere: wall = ring + two beads")
        for contact in CONTACTS:
            yield gw.Row(f"Peak force times 1e4 at contact {contact}, {run.label}", where=WHERE, verification=True,
                         ours=1e4 * run.peaks[contact - 1] / FORCE, theory=1e4 * force[contact - 1] / FORCE)
        yield gw.Row(f"Speed, {run.label}", "m/s", ours=run.speed, theory=speed_of(time), where=WHERE,
                     verification=True)
        theory = decay_of(force)
        told = theory > 1e-5  # peaks that are good to 1e-4 say nothing about less
        yield gw.Row(f"Decay per contact, {run.label}", ours=run.decay, theory=theory, where=WHERE, digits=3,
                     remark="" if told else "No decay that could be told from errors of the peaks.", verification=told)
    # fmt: on


def tables(waves):
    known = [
        next(run for run in waves.runs if (run.n, round(run.a, 7)) == (n, a))
        for n, a in PROGRAM[:, :2]
    ]
    ours = np.array(
        [[*(1e4 * run.peaks[np.array(CONTACTS)] / FORCE), run.speed, run.decay] for run in known]
    )
    columns = {"n": PROGRAM[:, 0], "a": PROGRAM[:, 1]}
    values = {"ours": ours, "program": PROGRAM[:, 8:], "thesis model": PROGRAM[:, 2:8]}
    for k, contact in enumerate(CONTACTS):
        columns |= {f"{who} at {contact + 1}": table[:, k] for who, table in values.items()}
    columns |= {f"speed, {who} (m/s)": table[:, 4] for who, table in values.items()}
    columns |= {f"decay, {who}": table[:, 5] for who, table in values.items()}
    yield (
        "Peak forces times 1e4, speed and decay beside a program that is not kept, for the same "
        "rows and for the source's model. Its run stopped at some 6 ms: for n = 6, and n = 7 with a = 0, its last force is that of the contact "
        "where the wave was then (129, 142, 154, and 185).",
        columns,
    )


def verdict(waves):
    for n, runs in waves.by_n.items():
        first = runs[0]
        last = runs[-1]
        kept = "hardly decays" if last.decay < 2e-4 else "decays"
        yield (
            f"n = {n}: the wave {kept} ({last.decay:.3g} per contact) at a = {last.a:.2g}, {first.decay:.3g} at a = "
            f"{first.a:.2g}; its speed rises from {first.speed:.0f} to {last.speed:.0f} m/s."
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
    caption = "Peak forces of the contacts of beads: precompression takes away force, and the decay for n = 7 and 8 "
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
