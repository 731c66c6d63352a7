"""The square packing at the source's two impacts: energies by region, maps of speed, and lengths of the pulses."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.colors import Normalize
from numpy.typing import NDArray

from granwave.analysis.figures.style import (
    BLUE,
    FORCE_MAP,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    WIDTH,
    Drawing,
    new_figure,
)
from granwave.analysis.studies.square.pulses import MEASURES, lengths, theory
from granwave.analysis.studies.square.regions import groups, regions, settled
from granwave.analysis.studies.square.runs import Array, PackingRun, squares
from granwave.analysis.studies.study import Picture, Row, Study

Measured = dict[str, Array]  # by name of `MEASURES`

_SHOWN = (0.15e-3, 0.30e-3)  # s, of the maps of speed
_SETTLED = 0.02  # of a length
_LEAST_PASSED = 6  # spheres for a length of the pulse
_AT_WALL = 2  # spheres that feel the wall while the pulse passes
_WHERE = "square packing, Wave Propagation Path"
_PULSE = "square packing, Pulse Length"
_COLOURS = {
    "central chains": BLUE,
    "edge chains": SKY,
    "struck spheres": ORANGE,
    "strikers": PURPLE,
    "other spheres": "black",
    "walls": GREY,
    "dissipated": GREEN,
}
#: Per cent of the input that the source found.
_ENERGIES = {
    "in-plane": {"central chains": 71.5, "edge chains": 24.5, "strikers and struck spheres": 4.0},
    "out-of-plane": {"central chains": 44.3, "strikers": 8.0, "struck spheres": 47.7},
}


def square_impacts(runs: Sequence[PackingRun]) -> Iterator[Study]:
    """One study for each way of impact: the source's own run if it is there, else the slowest elastic one."""
    for way in ("in-plane", "out-of-plane"):
        elastic = squares(runs, way, "hertz")
        chosen = [run for run in elastic if run.is_source_impact] or elastic
        if chosen:
            yield _study(chosen[0])


def _study(run: PackingRun) -> Study:
    nx, ny = run.case.packing.size
    through = "through a sphere at rest" if any(not one.moves for one in run.case.striker) else "directly"
    measured = {name: _measure(run, name) for name in groups(run) if groups(run)[name]}
    slug = run.way.replace("-", "_")
    pictures = [
        Picture(f"square_{slug}_energies", f"Energy by region, {run.way} impact", _energies(run)),
        Picture(f"square_{slug}_speeds", f"Speed of the spheres, {run.way} impact (source Figs 3 and 6)", _maps(run)),
    ]
    measured = {name: found for name, found in measured.items() if _last(found) > 1}
    if measured:
        drawing = _lengths(measured)
        pictures.append(
            Picture(f"square_{slug}_pulses", f"Length of the pulse, {run.way} impact (source Fig. 11)", drawing)
        )
    return Study(
        f"square-{run.way}",
        f"Square packing, {run.way} impact",
        f"{nx} x {ny} elastic spheres of {1e3 * run.case.packing.diameter:.4g} mm, {len(run.struck)} of them struck "
        f"{through} at {run.speed:g} m/s. Energies are kinetic and elastic, over "
        "the input: in chains the most they ever held, without the struck spheres; in strikers and struck spheres what "
        "they hold when they have rebounded.",
        tuple(_energy_rows(run)) + tuple(_length_rows(run, measured)),
        tuple(pictures),
    )


def _measure(run: PackingRun, group: str) -> Measured:
    """Lengths in the first chain of a group; all of a group are alike by symmetry."""
    chain = groups(run)[group][0]
    return lengths(run.time, chain.speeds(run), run.case.packing.diameter)


def _energy_rows(run: PackingRun) -> Iterator[Row]:
    ours = {name: 100 * share for name, share in settled(run).items()}
    ours["strikers and struck spheres"] = ours["strikers"] + ours["struck spheres"]
    for name, printed in _ENERGIES[run.way].items():
        source = printed if run.is_source_impact else None
        remark = "the source's: the rest" if name == "strikers and struck spheres" and source is not None else ""
        yield Row(f"Energy in {name}, {run.way}", "% of input", source, ours[name], _WHERE, remark)


def _length_rows(run: PackingRun, measured: dict[str, Measured]) -> Iterator[Row]:
    printed = (13.0, 5.0) if run.is_source_impact else (None, None)
    for group, found in measured.items():
        last = _last(found)
        if last < _LEAST_PASSED:
            continue
        expected = theory()
        for name in MEASURES:
            remark = "expected: Nesterenko's wave" if name == MEASURES[0] else ""
            ours = float(found[name][last])
            yield Row(
                f"Pulse length, {name}, {group}, {run.way}", "diameters", None, ours, _PULSE, remark, expected[name]
            )
        half = found[MEASURES[3]]
        below = 100 * (1 - half[last] / expected[MEASURES[3]])
        yield Row(f"Half-maximum length below Nesterenko's, {group}, {run.way}", "%", printed[0], float(below), _PULSE)
        off = np.flatnonzero(np.abs(half[1 : last + 1] / half[last] - 1) > _SETTLED)
        passed = float(off[-1] + 3 if len(off) else 1)  # the struck sphere is the first
        remark = "printed: roughly five or six; ours is within 2 % of its last length from there on"
        yield Row(
            f"Sphere from which on the pulse is settled, {group}, {run.way}", "", printed[1], passed, _PULSE, remark
        )


def _last(found: Measured) -> int:
    """The last sphere with a length that no wall touches."""
    good = np.flatnonzero(np.isfinite(found[MEASURES[3]][:-_AT_WALL]))
    return int(good[-1]) if len(good) else 0


def _energies(run: PackingRun) -> Drawing:
    figure = new_figure(2.6)
    axes = figure.subplots()
    shares = regions(run)
    for name, share in shares.items():
        if share.max() > 1e-3:
            axes.plot(1e6 * run.time, 100 * share, color=_COLOURS[name], label=name)
    axes.set_xlabel("Time (µs)")
    axes.set_ylabel("Energy (% of input)")
    axes.set_xlim(0, 1e6 * run.time[-1])
    axes.set_ylim(0, 105)
    axes.legend(loc="upper right")
    columns = {"time_s": run.time}
    columns |= {f"{name.replace(' ', '_')}_over_input": share for name, share in shares.items()}
    for group, members in groups(run).items():
        for chain in members:
            name = chain.name.replace(" ", "_").replace("+", "plus_").replace("-", "minus_")
            columns[f"{group.split()[0]}_{name}_over_input"] = run.energy[:, chain.rows[1:]].sum(axis=1)
    return Drawing(figure, columns)


def _maps(run: PackingRun) -> Drawing:
    n, radius = run.assembly.lattice.n_spheres, 500 * run.case.packing.diameter  # mm
    place = 1e3 * run.position[:, :2]
    frames = [int(np.abs(run.time - time).argmin()) for time in _SHOWN]
    speeds = [np.linalg.norm(run.velocity[frame], axis=1) for frame in frames]
    norm = Normalize(0, max(float(speed[:n].max()) for speed in speeds) or 1.0)
    figure = new_figure(2.6)
    columns: dict[str, NDArray] = {
        "id": np.arange(1, len(place) + 1),
        "x_m": run.position[:, 0],
        "y_m": run.position[:, 1],
    }
    panels: Sequence[Axes] = figure.subplots(1, 2, sharey=True)
    for axes, frame, speed in zip(panels, frames, speeds, strict=True):
        discs = EllipseCollection(
            np.full(n, 2 * radius), np.full(n, 2 * radius), np.zeros(n), units="xy", offsets=place[:n],
            offset_transform=axes.transData, array=speed[:n], cmap=FORCE_MAP, norm=norm,
        )  # fmt: skip
        axes.add_collection(discs)
        low, high = place[:n].min(axis=0) - radius, place[:n].max(axis=0) + radius
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xlabel="x (mm)")
        axes.set_title(f"{1e3 * run.time[frame]:.2f} ms")
        columns[f"speed_at_{1e6 * run.time[frame]:.0f}_us_m_s"] = speed
    panels[0].set_ylabel("y (mm)")
    figure.colorbar(discs, ax=list(panels), label="Speed (m/s)", location="bottom", shrink=0.8)
    return Drawing(figure, columns)


def _lengths(measured: dict[str, Measured]) -> Drawing:
    figure = new_figure(3.4, 1.25 * WIDTH)
    panels = figure.subplots(2, 2, sharex=True).ravel()
    columns: dict[str, NDArray] = {}
    for group, found in measured.items():
        shown = np.arange(1, _last(found) + 1)
        columns[f"{group.split()[0]}_sphere"] = shown + 1
        for axes, name in zip(panels, MEASURES, strict=True):
            values = found[name][shown]
            axes.plot(shown + 1, values, "o-", color=_COLOURS[group], markersize=3, label=group)
            columns[f"{group.split()[0]}_{name.replace(' ', '_')}_diameters"] = values
    for axes, name in zip(panels, MEASURES, strict=True):
        axes.axhline(theory()[name], color="black", linestyle=":", label="Nesterenko")
        axes.set_title(name[0].upper() + name[1:])
        low = min(line.get_ydata().min() for line in axes.lines[:-1])  # type: ignore[union-attr]
        axes.set_ylim(0.95 * low, 1.04 * theory()[name])
    for axes in panels[2:]:
        axes.set_xlabel("Sphere of the chain")
    for axes in panels[::2]:
        axes.set_ylabel("Length (diameters)")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    return Drawing(figure, columns)
