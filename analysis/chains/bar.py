"""Elastic bars alone: speed, shape, impedance and energy of a pulse against the closed forms (thesis 3.2.1).

A pulse F(t) that enters a slender bar goes on unchanged at c = sqrt(E/rho); force over velocity is Z = A sqrt(E rho)
and its energy is the integral of F^2/Z. Two-node elements of length h with lumped masses carry a wave number q at the
frequency (2c/h) sin(qh/2) instead of cq, so that what is short beside h lags behind, and a front spreads over a
length of (c t h^2/8)^(1/3) (Airy). Hence the error of the shape falls with h^(2/3) where the pulse has a kink, as a
half-sine has at its ends, and not at all at a step, which overshoots by 27 %. The pulse's centroid moves at c on
every mesh.

What enters the incident bar is the load, what enters the other one is its contact force.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Hashable, Iterator, Sequence
from functools import cached_property

import numpy as np
from matplotlib.ticker import NullLocator
from numpy.typing import NDArray

from granwave.analysis.chains.measures import arrival, power
from granwave.analysis.chains.runs import ChainRun
from granwave.analysis.figure_style import BLUE, GREEN, GREY, ORANGE, PURPLE, Drawing, new_figure
from granwave.analysis.study import Picture, Row, Study
from granwave.lammps_inputs.assembly import INCIDENT_BAR, PlacedBar
from granwave.lammps_inputs.loads import Load

Array = NDArray[np.float64]

_WHERE = "thesis 3.2.1"
_NEAR, _FAR = 0.25, 0.75  # sections, in lengths of the bar from where the pulse enters
_HALF = 0.5  # of a pulse, whose passing is its arrival
_AHEAD = 3.0  # widths of a front, that it is felt before it comes
_THROUGH = 0.02  # of its largest force: a pulse below has passed
_FEWEST_MESHES = 3
_FINER = 20  # times the instants of the history, for integrals of the load
_FEWEST_INSTANTS = 100  # of a history that can be measured
_MILLI, _MICRO, _KILO = 1e3, 1e6, 1e-3


def bars(runs: Sequence[ChainRun]) -> Iterator[Study]:
    """The bars of recorded runs, of like runs the one with the finest mesh, and convergence with the mesh."""
    groups: dict[Hashable, list[Passage]] = {}
    for run in runs:
        if run.recorded and len(run.time) >= _FEWEST_INSTANTS:
            for bar in run.case.assembly.bars:
                groups.setdefault((bar.name, _but_for_the_mesh(run)), []).append(passage(run, bar))
    found = [sorted(group, key=lambda one: one.bar.pitch) for group in groups.values()]
    found = [group for group in found if group[0].peak > 0]
    if not found:
        return
    finest = [group[0] for group in found]
    meshes = [group for group in found if len({one.bar.section.elements for one in group}) >= _FEWEST_MESHES]
    pictures = [Picture("bar_pulse", "Elastic bar: the pulse at two sections, and as it entered", _pulse(finest[0]))]
    rows = [row for one in finest for row in _rows(one)]
    for group in meshes:
        rows += _convergence_rows(group)
    if meshes:
        pictures.append(Picture("bar_convergence", "Elastic bar: errors against element size", _convergence(meshes)))
    yield Study(
        "bar",
        "Elastic bar",
        "What goes through the bars, against the closed forms of a slender bar: it enters as the load or, at the end "
        "of a chain, as the contact force. Sections lie at a quarter and three quarters of the length; only what "
        "comes before the first echo counts. The speed is that of the pulse's centroid where all of it has passed "
        "both sections, else of its rise through half the largest force. A kink of the pulse, as a half-sine has at "
        "its ends, limits the error of the shape to the power 2/3 of the element size; the edges of a rectangle are "
        "shorter than any element and ripple on every mesh. Speed, impedance and energy converge all the same.",
        tuple(rows),
        tuple(pictures),
    )


@dataclasses.dataclass(frozen=True, eq=False)
class Passage:
    """What entered a bar, and what passed two sections of it before anything came back.

    Attributes
    ----------
    time
        Of the history: (n_times,), s.
    entered
        Force at the end where it enters, N, at given times.
    sections
        Distances of two sections from that end, m.
    force, velocity
        At both: (2, n_times), N, m/s away from that end; NaN from the first echo on.
    energy
        In the bar at the end of the run over that of the pulse that entered until then.
    """

    run: ChainRun
    bar: PlacedBar
    time: Array
    entered: Callable[[Array], Array]
    sections: tuple[float, float]
    force: Array
    velocity: Array
    energy: float

    @property
    def impedance(self) -> float:
        """A sqrt(E rho), N s/m."""
        return impedance(self.bar)

    @cached_property
    def peak(self) -> float:
        """Largest force that entered, N."""
        return float(self.entered(self.time).max())

    @property
    def speed(self) -> float:
        """Between the sections: of the centroid of a pulse that passed both, else of its rise through half, m/s.

        NaN where nothing reached one of them.
        """
        forces = [force[np.isfinite(force)] for force in self.force]
        times = [self.time[: len(force)] for force in forces]
        if not all(force.any() for force in forces):
            return math.nan
        if all(abs(force[-1]) < _THROUGH * self.peak for force in forces):
            near, far = (float(t @ force / force.sum()) for t, force in zip(times, forces, strict=True))
        else:
            near, far = (arrival(t, force, _HALF * self.peak) for t, force in zip(times, forces, strict=True))
        return (self.sections[1] - self.sections[0]) / (far - near)

    @property
    def measured_impedance(self) -> float:
        """Force over velocity at the far section, by least squares, N s/m."""
        force, velocity = (values[1][np.isfinite(self.force[1])] for values in (self.force, self.velocity))
        return float(force @ velocity / (velocity @ velocity))

    @property
    def deviation(self) -> float:
        """Largest difference at the far section from the pulse that entered, late by x/c, over the pulse's peak."""
        return float(np.nanmax(np.abs(self.force[1] - self.late(1))) / self.peak)

    @property
    def overshoot(self) -> float:
        """Largest force at the far section over the largest that entered."""
        return float(np.nanmax(self.force[1]) / self.peak)

    def late(self, section: int) -> Array:
        """The pulse that entered, as it would pass a section in a perfect bar: (n_times,), N."""
        return self.entered(self.time - self.sections[section] / self.bar.wave_speed)


def passage(run: ChainRun, bar: PlacedBar) -> Passage:
    """What went through a bar of a recorded run."""
    time = run.time
    place, force, velocity = (run.array(f"{bar.name}/{name}") for name in ("position", "force", "velocity"))
    velocity = 0.5 * (velocity[:, 1:] + velocity[:, :-1])  # of elements
    depth = 0.5 * (place[1:] + place[:-1]) - place[0]
    if bar.name == INCIDENT_BAR:
        energy = run.summary["energy_input_J"]
        instants = np.linspace(0, time[-1], _FINER * len(time))
        values = applied(run.load, instants)
    else:
        energy = run.transmitted
        instants, values = (run.array(f"walls/{bar.name}/{name}") for name in ("time", "force"))

    def entered(at: Array) -> Array:
        if bar.name == INCIDENT_BAR:
            return applied(run.load, at)
        return np.interp(at, instants, values, left=0.0)

    elements = [int(np.abs(depth - share * bar.section.length).argmin()) for share in (_NEAR, _FAR)]
    sections = depth[elements]
    start = instants[max(0, int((values != 0).argmax()) - 1)]
    length = bar.section.length
    ahead = _AHEAD * (2 * length * bar.pitch**2 / 8) ** (1 / 3)
    clear = np.stack([time < start + (2 * length - ahead - x) / bar.wave_speed for x in sections])
    closed = float(np.trapezoid(values**2, instants)) / impedance(bar)
    return Passage(
        run, bar, time, entered, (float(sections[0]), float(sections[1])),
        np.where(clear, force[:, elements].T, np.nan), np.where(clear, velocity[:, elements].T, np.nan),
        float(energy or 0.0) / closed if closed else np.nan,
    )  # fmt: skip


def impedance(bar: PlacedBar) -> float:
    """A sqrt(E rho), N s/m."""
    return bar.section.area * float(np.sqrt(bar.material.youngs_modulus * bar.material.density))


def applied(load: Load, time: Array) -> Array:
    """The force of a load at given times, N."""
    if load.table:
        points, values = np.array(load.table).T
        return np.interp(time, points, values, left=0.0, right=0.0)
    amplitude, duration = load.amplitude or 0.0, load.duration or np.inf
    if load.shape == "harmonic":
        return amplitude * np.sin(2 * np.pi * (load.frequency or 0.0) * time)
    shape = np.sin(np.pi * time / duration) if load.shape == "half-sine" else np.ones_like(time)
    return amplitude * np.where((time > 0) & (time <= duration), shape, 0.0)


def _but_for_the_mesh(run: ChainRun) -> Hashable:
    def meshless(bar):
        return bar and dataclasses.replace(bar, elements=1)

    case = run.case
    return (case.packing, case.material, case.replace, case.load, case.contact,
            meshless(case.bar), meshless(case.incident_bar))  # fmt: skip


def _title(one: Passage) -> str:
    shape = f"{one.run.load.shape} " if one.bar.name == INCIDENT_BAR else ""
    name = one.bar.name.replace("_", " ")
    return f"{one.run.case.name}, {shape}{name} in elements of {one.bar.pitch * _MILLI:.3g} mm"


def _rows(one: Passage) -> list[Row]:
    title, sharp = _title(one), one.run.load.shape == "rectangle" and one.bar.name == INCIDENT_BAR
    edge = "An edge is shorter than any element: it ripples, and overshoots by up to 27 %." if sharp else ""
    rows = [
        Row(f"Speed, {title}", "m/s", None, one.speed, _WHERE, expected=one.bar.wave_speed),
        Row(f"Impedance, {title}", "N s/m", None, one.measured_impedance, _WHERE, expected=one.impedance),
        Row(f"Peak at a section over that which entered, {title}", "", None, one.overshoot, _WHERE, edge, 1.0),
        Row(f"Largest deviation from the pulse's shape, {title}", "of its peak", None, one.deviation, _WHERE, edge),
        Row(f"Energy over the integral of F²/Z, {title}", "", None, one.energy, _WHERE, expected=1.0),
    ]
    echo = one.run.case.assembly.echoes()[one.bar.name]
    lasts = float(one.run.time[-1])
    remark = "The chain feels the end of the bar." if lasts > echo else "Nothing comes back within the run."
    rows.append(Row(f"Echo at the chain not before, {title}; run of {lasts * _MICRO:.4g} µs", "µs", None,
                    echo * _MICRO, _WHERE, remark))  # fmt: skip
    return [row for row in rows if np.isfinite(row.ours)]


_ERRORS = {
    "speed": lambda one: abs(one.speed / one.bar.wave_speed - 1),
    "impedance": lambda one: abs(one.measured_impedance / one.impedance - 1),
    "shape": lambda one: one.deviation,
    "energy": lambda one: abs(one.energy - 1),
}


def _convergence_rows(group: Sequence[Passage]) -> list[Row]:
    """Order of the error of the shape of a half-sine, which has kinks at its ends."""
    if group[0].run.load.shape != "half-sine" or group[0].bar.name != INCIDENT_BAR:
        return []
    size = np.array([one.bar.pitch for one in group])
    fit = power(size, np.array([one.deviation for one in group]))
    name = f"Order of the error of the shape in the element size, {group[0].run.load.shape}"
    remark = f"Fitted to {len(group)} meshes; 2/3 is what the kinks at its ends allow."
    return [Row(name, "", None, fit.exponent, _WHERE, remark, 2 / 3)]


def _pulse(one: Passage) -> Drawing:
    figure = new_figure(2.4)
    axes = figure.subplots()
    time = one.time * _MICRO
    pulse = one.entered(one.time)
    axes.plot(time, pulse * _KILO, color=GREY, label="entered")
    columns: dict[str, Array] = {"time_s": one.time, "entered_N": pulse}
    for n, (x, colour) in enumerate(zip(one.sections, (BLUE, ORANGE), strict=True)):
        late = one.late(n)
        axes.plot(time, one.force[n] * _KILO, color=colour, label=f"at {x:.3g} m")
        axes.plot(time, late * _KILO, color="black", linestyle=":", linewidth=0.8)
        columns |= {f"at_{x:.4g}_m_N": one.force[n], f"closed_form_at_{x:.4g}_m_N": late}
    axes.plot([], [], color="black", linestyle=":", linewidth=0.8, label="closed form")
    axes.set_xlim(0, time[-1])
    axes.set_xlabel("Time (µs)")
    axes.set_ylabel("Section force (kN)")
    axes.set_ylim(top=1.45 * axes.get_ylim()[1])
    axes.legend(ncols=2)
    return Drawing(figure, columns)


def _convergence(groups: Sequence[Sequence[Passage]]) -> Drawing:
    figure = new_figure(2.7, 3.4 if len(groups) == 1 else 6.8)
    row = figure.subplots(1, len(groups), sharey=True, squeeze=False)[0]
    columns: dict[str, Array] = {}
    for axes, group in zip(row, groups, strict=True):
        size = np.array([one.bar.pitch for one in group])
        title = f"{group[0].run.load.shape}, {group[0].bar.name.replace('_', ' ')}"
        columns[f"{title}: element_m"] = size
        for (name, error), colour, mark in zip(_ERRORS.items(), (BLUE, GREEN, ORANGE, PURPLE), "osD^", strict=True):
            values = np.array([error(one) for one in group])
            axes.plot(size * _MILLI, values, marker=mark, markersize=4, color=colour, label=name)
            columns[f"{title}: error_of_{name}"] = values
        for order, line in ((2 / 3, "--"), (2, ":")):
            label = "order 2/3" if order < 1 else "order 2"
            axes.plot(size * _MILLI, 0.2 * (size / size.max()) ** order, color=GREY, linestyle=line, label=label)
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_title(title)
        axes.set_xticks(size * _MILLI, [f"{mm:.3g}" for mm in size * _MILLI])
        axes.xaxis.set_minor_locator(NullLocator())
        axes.set_xlabel("Element (mm)")
    row[0].set_ylabel("Error against the closed form")
    row[-1].legend(fontsize=7, loc="lower left", ncols=2)
    row[0].set_ylim(1e-7, 2)
    return Drawing(figure, columns)
