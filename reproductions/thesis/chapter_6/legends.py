"""Scales of figures 6.4, 6.10 and 6.11.

The chains follow the model of the source: a soft wall, no contacts in the rings, and fixed contact
normals. No unit of speed brings all their speeds within the axis of figure 6.4. The legends of
figure 6.10 (0.09, 0.22, 0.36) are values of delta_hat, since the printed equations then stay within
both axes. They have the same ratios as the precompressions a = 4.8e-4, 1.2e-3 and 1.9e-3, but are
four times smaller than delta_hat = 2 delta tan(theta)/A of the waves in these chains. The equality
of the slopes in figure 6.11 therefore depends on the scale of delta_hat and on the choice of A.
Three choices are compared.
"""

import numpy as np
from confined_rows import K_BEADS, VELOCITY, ConfinedRun, decay_of
from light_spheres import LightSpheres, PrintedSpheres, Travelling
from matplotlib.figure import Figure
from source_model import AXIS, SourceRows, SourceWindow
from symmetric_motion import leading_wave

import granwave as gw
from granwave.measures import first_peak, width

LEGENDS = (0.09, 0.22, 0.36)  # of figure 6.10, by rising a
ENDS = {"axial": 4.0, "radial": 0.5}  # of the axes of figure 6.10
NEAR = (-2, 10)  # time axis of figure 6.10
TO_30_MM = 2**0.25  # source's unit of velocity: 15 mm beads / 30 mm beads
LIGHTER = 0.9  # density of lighter small spheres, relative to that of the beads
CONTACT = 100
LAST = 200
ROUNDS = 6  # of the search of A by the force
SLOPE = "Slope of ln(decay of the force) against delta_hat"
FIGURE = "thesis figure 6.11"


class Legends:
    """Precompressed rows of n = 8 by rising a, and the others."""

    def __init__(self, runs):
        self.runs = [run for run in runs if run.n == 8]
        self.all = runs
        self.limit = LightSpheres(self.runs[0].rows)
        self.decay = np.array([run.decay for run in self.runs])
        # change of the tube's radius, towards the axis of the row
        self.pressed = np.array(
            [2 * run.rows.tangent[0] * run.rows.shrinks[0] for run in self.runs]
        )
        self.by_displacement = self.pressed / [moved_by_wave(run) for run in self.runs]
        forces = [run.peaks[CONTACT - 1] for run in self.runs]
        self.by_force = delta_hat_by_force(self.limit, self.pressed, forces)

    def printed(self):
        """Waves by the equations as they are printed, the legends taken as delta_hat."""
        return [Travelling(PrintedSpheres(self.runs[0].rows), one) for one in LEGENDS]

    def corrected(self):
        """Waves by the corrected equations."""
        return [Travelling(self.limit, one) for one in LEGENDS]


def select(runs):
    """The rows; empty without initial normals."""
    confined = [ConfinedRun(run) for run in runs if run.case.contact.normals == "initial"]
    return [Legends(sorted(confined, key=lambda run: (run.n, run.a)))] if confined else []


def moved_by_wave(run):
    """Displacement A of bead 100 by the wave, m: 2 to 6 widths of the wave behind its crest."""
    crest, _ = first_peak(*run.probe(CONTACT, "vz"), floor=0.5)
    length = width(*run.probe(CONTACT, "vz"))
    time, place = run.probe(CONTACT, "uz")
    after = (time > crest + 2 * length) & (time < crest + 6 * length)
    return place[after].mean() - place[0]


def delta_hat_by_force(limit, pressed, forces):
    """delta_hat of the waves in (6.13) that have these peak forces, N: (n_runs,)."""
    found = []
    for change, force in zip(pressed, forces, strict=True):
        delta_hat = 1.0
        for _ in range(ROUNDS):
            wave = Travelling(limit, delta_hat)
            delta_hat = change / (force / K_BEADS / wave.largest_force) ** (2 / 3)
        found.append(delta_hat)
    return np.array(found)


def slope(x, y):
    return np.polyfit(x, np.log(y), 1)[0]


def energy_decays(limit, delta_hat):
    """Theoretical decay of the energy, by the corrected (6.18)."""
    return np.array([Travelling(limit, one).energy_decay for one in delta_hat])


def rows(legends):
    yield of_speeds(legends.all)
    yield from of_velocities(legends)
    yield from of_slopes(legends)


def of_speeds(runs):
    """Row of the range of the speeds."""
    speeds = [run.speed for run in runs]
    least = TO_30_MM * min(speeds) / VELOCITY
    most = TO_30_MM * max(speeds) / VELOCITY
    return gw.Row(
        "Ratio of the largest speed (n = 9, a = 0.0019) to the smallest (n = 6, a = 0), at most",
        source=AXIS[1] / AXIS[0], ours=max(speeds) / min(speeds), where="thesis figure 6.4",
        digits=3, bound=True,
        remark="The bound is the ratio of the ends of the axis. No unit of speed fits all chains. "
        "In the unit of the printed v, which belongs to beads of 30 mm, the smallest speed is "
        f"{least:.4f} and the largest {most:.4f}. Diameter, modulus and density do not change the "
        "ratio.",
    )  # fmt: skip


def of_velocities(legends):
    """Rows of the largest velocities of the small spheres, the legends taken as delta_hat."""
    printed = legends.printed()[0].largest
    corrected = legends.corrected()[0].largest
    for (way, end), largest, other in zip(ENDS.items(), printed, corrected, strict=True):
        yield gw.Row(
            f"Largest {way} first-order velocity, delta_hat = {LEGENDS[0]:g}, at most",
            source=end, ours=largest, bound=True, digits=3, where="thesis figure 6.10",
            remark="The bound is the end of the axis. Our value uses (6.13) and (6.17) as printed; "
            f"with their corrections it is {other:.3g}.",
        )  # fmt: skip
    delta_hat = legends.by_displacement[0]
    axial, _ = Travelling(legends.limit, delta_hat).largest
    yield gw.Row(
        f"Largest axial first-order velocity, delta_hat = {delta_hat:.3g} of the run, relative to "
        "the end of the axis",
        ours=axial / ENDS["axial"], digits=2, where="thesis figure 6.10",
        remark="With the delta_hat of the wave at this a the curves fill half of the axis.",
    )  # fmt: skip


def of_slopes(legends):
    """Rows of both slopes of figure 6.11, by the meaning of delta_hat."""
    choices = {
        "A by the displacement of bead 100": legends.by_displacement,
        "A by the peak force of contact 100": legends.by_force,
    }
    for words, delta_hat in choices.items():
        yield gw.Row(
            f"{SLOPE}, model of the source, {words}", ours=slope(delta_hat, legends.decay),
            theory=slope(delta_hat, energy_decays(legends.limit, delta_hat)), where=FIGURE,
            digits=3,
            remark="Theory: decay of the energy by (6.18). According to the source the slopes are "
            "equal. With A from the displacement the force falls less steeply than the energy, "
            "with A from the force more steeply.",
        )  # fmt: skip
    energy = np.array([wave.printed_decay for wave in legends.printed()])
    yield gw.Row(
        f"{SLOPE}, model of the source, on the scale of the legends",
        ours=slope(LEGENDS, legends.decay),
        theory=slope(LEGENDS, energy), where=FIGURE, digits=3,
        remark="Theory: (6.13) to (6.18) as printed. On the scale of the source the slopes are "
        "not equal.",
    )  # fmt: skip
    yield of_lighter(legends)


def of_lighter(legends):
    """Row of the slopes with lighter small spheres, by the equations of the model of the source."""
    rows = [run.rows for run in legends.runs]
    columns = [(one.n, one.small, one.tube, one.shrinks, LIGHTER * one.density) for one in rows]
    joined = SourceRows(*(np.concatenate(parts) for parts in zip(*columns, strict=True)))
    force, _ = leading_wave(joined, 1.0, legends.runs[0].struck, LAST, SourceWindow)
    decay = np.array([decay_of(peaks) for peaks in force])
    lighter = LightSpheres(joined.part([0]))
    delta_hat = delta_hat_by_force(lighter, legends.pressed, force[:, CONTACT - 1])
    return gw.Row(
        f"{SLOPE}, by (6.7), A by the peak force, small spheres of {LIGHTER:g} times the density",
        ours=slope(delta_hat, decay), theory=slope(delta_hat, energy_decays(lighter, delta_hat)),
        where=FIGURE,
        digits=3,
        remark="The theory is for light small spheres, but with lighter spheres the slopes differ "
        "more. Below 0.9 the decay at a = 0.0019 is too small to measure.",
    )  # fmt: skip


def pictures(legends):
    figure = Figure((7, 2.4), layout="constrained")
    data = {}
    panels = figure.subplots(1, 2)
    for delta_hat, wave in zip(LEGENDS, legends.printed(), strict=True):
        near = (wave.time > NEAR[0]) & (wave.time < NEAR[1])
        for axes, (way, end), velocity in zip(
            panels, ENDS.items(), (wave.axial, wave.radial), strict=True
        ):
            axes.plot(wave.time[near], velocity[near], label=f"{delta_hat:g}", linewidth=0.9)
            axes.set(
                xlabel=r"Time $\tau$", ylabel=f"{way.capitalize()}, first order", ylim=(-end, end)
            )
            data |= {f"time_{delta_hat:g}": wave.time[near], f"{way}_{delta_hat:g}": velocity[near]}
    panels[1].legend(title=r"$\hat\delta$", fontsize=7)
    caption = "First-order velocities of the small spheres by the printed equations, with the "
    caption += "legends of thesis figure 6.10 as delta_hat, on the axes of the figure"
    yield gw.Picture("confined_legends", caption, figure, data)
