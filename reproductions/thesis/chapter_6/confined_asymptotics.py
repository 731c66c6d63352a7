"""Confined chains: asymptotic theory.

Light small spheres follow the beads, which then form a chain with a second, precompressed contact
(6.13). Small spheres that continue to oscillate behind the wave take energy from it (6.16 to 6.18).
k_w is the value of the source (factor 1.2). Several misprints are corrected: delta_hat is 2 delta
tan(theta); eta_hat has no further cos^2.5 (0.5286 for n = 8, not 0.2528); the residual keeps its
powers 3/2 and c^2 w''; (6.17) has the difference of beads; (6.18) is n eps^3/A^2 (w_1'^2 + u_1'^2)
with the largest velocity of a bead in place of A. Waves become wider with precompression, not
narrower: C1 falls. The legends of figure 6.10 (0.09, 0.22, 0.36) have the ratio of the
precompressions, but are about a quarter of the delta_hat of the waves in these chains, so that
slopes are compared.
"""

from functools import cached_property

import numpy as np
from confined_rows import BEAD, ConfinedRun, decay_of
from light_spheres import LightSpheres, Travelling, series_at
from matplotlib.figure import Figure
from source_model import SourceRows, SourceWindow
from symmetric_motion import leading_wave

import granwave as gw
from granwave.measures import first_peak, width

SERIES = (0.2, 0.4)  # delta_hat of figure 6.9, where the series of three terms is compared
SMALLEST_TAIL = 1.32
LAST = 200  # contact up to which the equations are followed
LEGENDS = {4.8e-4: 0.09, 1.2e-3: 0.22, 1.9e-3: 0.36}  # values of figure 6.10, by a
ZERO = (-3, 3)  # beads around the crest that are shown


class Theory:
    """Precompressed rows of n = 8 at the a of the legends, with the theory."""

    def __init__(self, runs):
        self.runs = sorted(
            (run for run in map(ConfinedRun, runs) if is_in_legend(run)), key=lambda run: run.a
        )
        self.limit = LightSpheres(self.runs[0].rows)
        self.moved = np.array([moved_by_wave(run) for run in self.runs])
        rows = [run.rows for run in self.runs]
        self.delta_hat = (
            np.array([2 * one.tangent[0] * one.shrinks[0] for one in rows]) / self.moved
        )
        self.decay = np.array([run.decay for run in self.runs])

    def waves(self, *delta_hat):
        return [Travelling(self.limit, one) for one in delta_hat]

    @cached_property
    def shown(self):
        """Waves of figure 6.9, and the wave with the smallest tail, by delta_hat."""
        chosen = (*SERIES, SMALLEST_TAIL)
        return dict(zip(chosen, self.waves(*chosen), strict=True))

    @cached_property
    def curve(self):
        """delta_hat and theoretical decay of the energy, over the range of the runs."""
        x = np.linspace(self.delta_hat[0], self.delta_hat[-1], 12)
        return x, np.array([wave.energy_decay for wave in self.waves(*x)])


def is_in_legend(run):
    return run.n == 8 and run.impact == 1 and round(run.a, 7) in LEGENDS


def moved_by_wave(run):
    """Displacement A of bead 100 by the wave, m: 2 to 6 widths of the wave behind its crest."""
    crest, _ = first_peak(*run.probe(100, "vz"), floor=0.5)
    length, (time, place) = width(*run.probe(100, "vz")), run.probe(100, "uz")
    after = (time > crest + 2 * length) & (time < crest + 6 * length)
    return place[after].mean() - place[0]


def select(runs):
    return [Theory(runs)]


def rows(theory):
    of_theory = {"where": "asymptotic theory"}
    # fmt: off
    yield gw.Row("eta_hat of (6.13), n = 8", ours=theory.limit.eta_hat, digits=4, **of_theory)
    for delta_hat, wave in theory.shown.items():
        at = f"delta_hat = {delta_hat:g}"
        if delta_hat in SERIES:
            found, c = wave.series()
            for k, ours in enumerate(found):
                yield gw.Row(f"C{2 * k + 1} of the series, {at}", ours=ours, digits=3, **of_theory)
            yield gw.Row(f"c of the series, {at}", ours=c, theory=wave.speed, where="lattice", verification=True)
            z = np.linspace(*ZERO, 241)
            yield gw.Row(f"Largest difference of the series from the profile of the lattice, {at}",
                digits=2,
                         ours=np.abs(series_at(z, found) - wave.displacement(z)).max(), where="thesis figure 6.9")
        for way, ours in zip(("Axial", "Radial"), wave.tails, strict=True):
            yield gw.Row(f"{way} first-order velocity behind the wave, {at}", ours=ours, digits=2, **of_theory)
    for run, moved, delta_hat in zip(theory.runs, theory.moved, theory.delta_hat, strict=True):
        yield gw.Row(f"Displacement of a bead by the wave / D, times 1e3, {run.label}", ours=1e3 * moved / BEAD,
                     where="ours", digits=3)
        yield gw.Row(f"delta_hat of the legend, {run.label}", source=LEGENDS[round(run.a, 7)], ours=delta_hat, digits=3,
                     where="thesis figure 6.10", remark="Our values are about four times as "
                                                        "large, and their ratios equal the "
                                                        "ratios of the precompressions a. The "
                                                        "legends are the delta_hat of the drawn "
                                                        "curves.")
    of_energy = slope(*theory.curve)
    yield gw.Row("Slope of ln(decay of the force) against delta_hat", ours=slope(theory.delta_hat, theory.decay), digits=3,
                 where="thesis figure 6.11", theory=of_energy,
                 remark="Theory: decay of the energy by (6.18), with the wall of the source and "
                        "without the rings. The source calls the slopes equal. The two models "
                        "cause more than half of the difference (next row).")
    yield gw.Row("Slope of ln(decay of the force) against delta_hat, by the source's equations (6.7)", digits=3,
                 ours=slope(theory.delta_hat, decay_by_source(theory)), where="thesis figure 6.11", theory=of_energy,
                 remark="The model of the source has a soft wall, no contacts in the rings, and "
                        "fixed normals. Its equations are solved, and runs of that model agree "
                        "with them to four digits. The remaining difference depends on the "
                        "choice of A.")
    # fmt: on


def decay_by_source(theory):
    """Decay per contact of these rows by the equations (6.7) of the source: (n_runs,)."""
    rows = [run.rows for run in theory.runs]
    columns = [(one.n, one.small, one.tube, one.shrinks, one.density) for one in rows]
    joined = SourceRows(*(np.concatenate(parts) for parts in zip(*columns, strict=True)))
    force, _ = leading_wave(joined, 1.0, theory.runs[0].struck, LAST, SourceWindow)
    return np.array([decay_of(peaks) for peaks in force])


def slope(x, y):
    return np.polyfit(x, np.log(y), 1)[0]


def pictures(theory):
    z = np.linspace(*ZERO, 121)
    data = {}
    figure = Figure((7, 2.7), layout="constrained")
    left, right = figure.subplots(1, 2)
    for k, one in enumerate(SERIES):
        wave = theory.shown[one]
        series = series_at(z, wave.series()[0])
        lattice = wave.displacement(z)
        left.plot(z, series, f"C{k}", label=rf"series, $\hat\delta$ = {one:g}")
        left.plot(
            z[::4], lattice[::4], f"oC{k}", markersize=3, label=rf"lattice, $\hat\delta$ = {one:g}"
        )
        data |= {"z": z, f"series_{one:g}": series, f"lattice_{one:g}": lattice}
    left.set(xlabel="Distance from the crest, beads", ylabel="Displacement / A")
    x, decay = theory.curve
    right.semilogy(x, decay, "0.6", label="energy, theory")
    right.semilogy(theory.delta_hat, theory.decay, "o", label="force, simulation")
    right.set(xlabel=r"$\hat\delta = 2\,\delta\tan\theta/A$", ylabel="Decay per contact")
    for axes in (left, right):
        axes.legend()
    data |= {
        "delta_hat_theory": x,
        "decay_theory": decay,
        "delta_hat": theory.delta_hat,
        "decay": theory.decay,
    }
    caption = (
        "Travelling waves, as a series of three terms and in the lattice (thesis figure "
        "6.9); decay of the force in runs "
    )
    caption += (
        "compared with the decay of the energy in theory: compare the slopes (thesis figure 6.11)"
    )
    yield gw.Picture("confined_travelling_waves", caption, figure, data)
    figure = Figure((7, 2.4), layout="constrained")
    data = {}
    left, right = figure.subplots(1, 2)
    for one, wave in zip(theory.delta_hat, theory.waves(*theory.delta_hat), strict=True):
        near = (wave.time > -2) & (wave.time < 10)
        for axes, way, velocity in ((left, "axial", wave.axial), (right, "radial", wave.radial)):
            axes.plot(
                wave.time[near], velocity[near], label=rf"$\hat\delta$ = {one:.2f}", linewidth=0.9
            )
            axes.set(xlabel=r"Time $\tau$", ylabel=f"{way.capitalize()}, first order")
            data |= {f"time_{one:.2f}": wave.time[near], f"{way}_{one:.2f}": velocity[near]}
    right.legend()
    caption = (
        "First-order velocities of the small spheres: the larger the precompression, the "
        "less they oscillate behind "
    )
    yield gw.Picture(
        "confined_small_spheres", f"{caption}the wave (thesis figure 6.10)", figure, data
    )
