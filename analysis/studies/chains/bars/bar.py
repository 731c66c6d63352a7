"""Elastic bars against the closed forms of a slender bar, and convergence with the mesh (thesis 3.2.1)."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Hashable, Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike

from granwave.analysis.figures.series import MARKS, label, panels
from granwave.analysis.figures.style import BLUE, GREY, ORANGE, Drawing
from granwave.analysis.measures.chains.bar_pulse import Passage, passage
from granwave.analysis.measures.signals import power
from granwave.analysis.studies.chains.runs import ChainRun, chain_runs
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row
from granwave.lammps_inputs.packing.bars import INCIDENT_BAR, echoes

TITLE = "Elastic bar"
_WHERE = "thesis 3.2.1"
_FEWEST_MESHES = 3
_FEWEST_INSTANTS = 100  # of a history that can be measured
_MILLI, _MICRO, _KILO = 1e3, 1e6, 1e-3
Meshes = list[Passage]


def select(runs: Sequence[FinishedRun]) -> list[list[Meshes]]:
    """The bars of recorded runs; those that differ in the mesh alone together, the finest first."""
    groups: dict[Hashable, Meshes] = {}
    for run in chain_runs(runs):
        if run.recorded and len(run.time) >= _FEWEST_INSTANTS:
            for bar in run.assembly.bars:
                groups.setdefault((bar.name, _but_for_the_mesh(run)), []).append(passage(run, bar))
    found = [sorted(group, key=lambda one: one.bar.pitch) for group in groups.values()]
    found = [group for group in found if group[0].peak > 0]
    return [found] if found else []


def text(found: list[Meshes]) -> str:
    """Describe the measurements."""
    return (
        "What goes through the bars, against the closed forms of a slender bar: it enters as the load or, at the end "
        "of a chain, as the contact force. Sections lie at a quarter and three quarters of the length; only what "
        "comes before the first echo counts. The speed is that of the pulse's centroid where all of it has passed "
        "both sections, else of its rise through half the largest force. A kink of the pulse, as a half-sine has at "
        "its ends, limits the error of the shape to the power 2/3 of the element size; the edges of a rectangle are "
        "shorter than any element and ripple on every mesh. Speed, impedance and energy converge all the same."
    )


def rows(found: list[Meshes]) -> Iterator[Row]:
    """Compare, of like runs, the one with the finest mesh, and the order of the errors."""
    for group in found:
        yield from (row for row in _rows(group[0]) if row.ours is not None and np.isfinite(row.ours))
    for group in _with_meshes(found):
        load = group[0].run.case.load
        if load.shape == "half-sine" and group[0].bar.name == INCIDENT_BAR:  # which has kinks at its ends
            fit = power(np.array([one.bar.pitch for one in group]), np.array([one.deviation for one in group]))
            what = f"Order of the error of the shape in the element size, {load.shape}"
            remark = f"Fitted to {len(group)} meshes; 2/3 is what the kinks at its ends allow."
            yield Row(what, "", None, fit.exponent, _WHERE, remark, 2 / 3, True)


def pictures(found: list[Meshes]) -> Iterator[Picture]:
    """The pulse, and errors against element size."""
    yield Picture("bar_pulse", "Elastic bar: the pulse at two sections, and as it entered", _pulse(found[0][0]))
    if meshes := _with_meshes(found):
        yield Picture("bar_convergence", "Elastic bar: errors against element size", _convergence(meshes))


def _with_meshes(found: list[Meshes]) -> list[Meshes]:
    return [group for group in found if len({one.bar.section.elements for one in group}) >= _FEWEST_MESHES]


def _but_for_the_mesh(run: ChainRun) -> Hashable:
    case = run.case
    meshless = [bar and dataclasses.replace(bar, elements=1) for bar in (case.bar, case.incident_bar)]
    return case.packing, case.material, case.replace, case.load, case.contact, *meshless


def _rows(one: Passage) -> Iterator[Row]:
    case, incident = one.run.case, one.bar.name == INCIDENT_BAR
    shape = f"{case.load.shape} " if incident else ""
    of = f"{case.name}, {shape}{one.bar.name.replace('_', ' ')} in elements of {one.bar.pitch * _MILLI:.3g} mm"
    sharp = case.load.shape == "rectangle" and incident
    edge = "An edge is shorter than any element: it ripples, and overshoots by up to 27 %." if sharp else ""
    echo, lasts = echoes(one.run.assembly.bars)[one.bar.name], float(one.run.time[-1])
    back = f"An echo may reach the chain from {echo * _MICRO:.4g} µs on" if lasts > echo else "No echo within the run"
    remark = f"{back}, which takes {lasts * _MICRO:.4g} µs."
    for what, unit, ours, closed, note in (
        ("Speed", "m/s", one.speed, one.bar.wave_speed, remark),
        ("Impedance", "N s/m", one.measured_impedance, one.impedance, ""),
        ("Peak at a section over that which entered", "", one.overshoot, 1.0, edge),
        ("Largest deviation from the pulse's shape", "of its peak", one.deviation, 0.0, edge),
        ("Energy over the integral of F²/Z", "", one.energy, 1.0, ""),
    ):
        if what.startswith("Energy") or math.isfinite(one.speed):  # else the pulse has not passed both sections
            yield Row(f"{what}, {of}", unit, None, ours, "closed form", note, closed, True)


def _pulse(one: Passage) -> Drawing:
    """The pulse as it entered and at two sections."""
    figure, axes = panels(2.4)
    time, pulse = one.time * _MICRO, one.entered(one.time)
    axes.plot(time, pulse * _KILO, color=GREY, label="entered")
    data: dict[str, ArrayLike] = {"time_s": one.time, "entered_N": pulse}
    for n, (x, colour) in enumerate(zip(one.sections, (BLUE, ORANGE), strict=True)):
        axes.plot(time, one.force[n] * _KILO, color=colour, label=f"at {x:.3g} m")
        axes.plot(time, one.late(n) * _KILO, "k:", linewidth=0.8, label="closed form" if n else None)
        data |= {f"at_{x:.4g}_m_N": one.force[n], f"closed_form_at_{x:.4g}_m_N": one.late(n)}
    label(axes, "Time (µs)", "Section force (kN)", xlim=(0, time[-1]), ylim=(None, 1.45 * axes.get_ylim()[1]))
    axes.legend(ncols=2)
    return Drawing(figure, data)


def _convergence(groups: list[Meshes]) -> Drawing:
    """Errors against element size, each load by itself."""
    figure, *row = panels(2.7, len(groups), sharey=True)
    data: dict[str, ArrayLike] = {}
    for axes, group in zip(row, groups, strict=True):
        size = np.array([one.bar.pitch for one in group])
        title = f"{group[0].run.case.load.shape}, {group[0].bar.name.replace('_', ' ')}"
        data[f"{title}: element_m"] = size
        for what, mark in zip(group[0].errors, MARKS, strict=False):
            data[f"{title}: error_of_{what}"] = values = [one.errors[what] for one in group]
            axes.plot(size * _MILLI, values, marker=mark, markersize=4, label=what)
        for order, line, what in ((2 / 3, "--", "order 2/3"), (2, ":", "order 2")):
            axes.plot(size * _MILLI, 0.2 * (size / size.max()) ** order, color=GREY, linestyle=line, label=what)
        label(axes, "Element (mm)", log="xy", title=title)
    label(row[0], y="Error against the closed form", ylim=(1e-7, 2))
    row[-1].legend(fontsize=7, loc="lower left", ncols=2)
    return Drawing(figure, data)
