"""Plane pulses in an fcc packing with small grains in its octahedral holes, beside the same without them."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from granwave.analysis.figures.series import COLOURS, MARKS, column_name, legend_outside, panels
from granwave.analysis.figures.style import Drawing
from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.waves.pulses import Peaks, peaks
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.runs import FinishedRun, grouped
from granwave.analysis.studies.study import Picture, Row

TITLE = "FCC packing with grains in its octahedral holes"
TEXT = (
    "A loaded fcc packing without ends at its sides, whose whole top layer is struck: a plane pulse. The holes between "
    "six spheres are empty, or hold spheres of 0.414 of the diameter, which touch all six. Speed and decay are of the "
    "mean velocity of the layers, between the 11th and the 41st; the decay is that of its peak, per layer. What "
    "reaches the bottom is the largest force on it beyond the static one."
)
_WHERE = "not in the source"
_LAYERS = (10, 40)  # from 0; in packings of fewer layers the last quarter is left out
_SAME_LAYER = 0.1  # diameters


class LayeredRun(FinishedRun):
    """A finished run of a plane pulse in a packing of layers, with or without grains between them."""

    @property
    def small(self) -> str:
        """Grains in the holes."""
        grains = self.case.packing.grains
        if grains is None or len(np.unique(grains.diameter)) == 1:
            return "empty holes"
        row = int(np.argmin(grains.diameter))
        material = self.case.named_material(grains.material[row])
        return str(material.name)

    @property
    def speed_of_striker(self) -> float:
        """Velocity of the top layer, m/s."""
        return self.case.load.velocity

    @cached_property
    def layers(self) -> tuple[Array, Array, Array]:
        """Depth of the layers of large spheres, m, instants, s, and velocities (n_times, n_layers) along z, m/s."""
        with Result(self.directory) as result:
            depth, radius = result["spheres/position"][:, 2], result["spheres/radius"]
            large = np.flatnonzero(radius > 0.9 * radius.max())
            order = large[np.argsort(depth[large], kind="stable")]
            number = np.cumsum(
                np.diff(depth[order], prepend=depth[order[0]]) > _SAME_LAYER * self.case.packing.diameter
            )
            count = np.bincount(number)
            frames = range(result.n_frames)
            speeds = [np.bincount(number, result.frame(k, "velocity")[order, 2]) / count for k in frames]
            return np.bincount(number, depth[order]) / count, result.frame_times, np.array(speeds)

    @cached_property
    def pulse(self) -> Peaks:
        """Peaks of the mean velocity of the layers."""
        depth, time, speed = self.layers
        return peaks(time, speed, float(np.diff(depth).mean()))

    @property
    def between(self) -> tuple[int, int]:
        """Layers between which the pulse is measured, from 0."""
        n = len(self.layers[0])
        return min(_LAYERS[0], n // 4), min(_LAYERS[1], 3 * n // 4)

    @property
    def wave_speed(self) -> float:
        """Speed of the pulse, m/s; NaN where it did not pass."""
        first, last = self.between
        return float(np.diff(self.layers[0][[first, last]])[0] / np.diff(self.pulse.time[[first, last]])[0])

    @property
    def decay(self) -> float:
        """Decay of its peak per layer; NaN where it did not pass."""
        first, last = self.between
        return float(np.log(self.pulse.velocity[first] / self.pulse.velocity[last]) / (last - first))

    @cached_property
    def at_bottom(self) -> tuple[Array, Array]:
        """Instants, s, and the force on the bottom beyond the static one, N."""
        with Result(self.directory) as result:
            time, force = result["walls/bottom/time"], result["walls/bottom/force"]
        return time, force - force[0]


@dataclasses.dataclass(frozen=True, eq=False)
class Group:
    """Packings that differ in what is in their holes, and in the velocity of the top layer."""

    runs: tuple[LayeredRun, ...]

    @property
    def by_velocity(self) -> dict[float, list[LayeredRun]]:
        """Runs by the velocity of the top layer; those with empty holes first."""
        found: dict[float, list[LayeredRun]] = {}
        for run in sorted(self.runs, key=lambda run: (run.speed_of_striker, run.small != "empty holes")):
            found.setdefault(run.speed_of_striker, []).append(run)
        return found


def select(runs: Sequence[FinishedRun]) -> list[Group]:
    """Groups of runs of a plane pulse that differ in the grains of the packing, some of them without small ones."""
    plane = [run.seen_as(LayeredRun) for run in runs if _is_plane(run)]
    groups = [Group(tuple(one)) for one in grouped(plane, "packing", "load", "materials")]
    return [group for group in groups if len({run.small for run in group.runs}) > 1
            and any(run.small == "empty holes" for run in group.runs)]  # fmt: skip


def _is_plane(run: FinishedRun) -> bool:
    """Return True for a run whose whole top layer is struck, between periodic sides."""
    struck = run.case.load.index
    if struck is None or run.case.boundary.sides != "periodic" or run.case.load.kind != "impact":
        return False
    return set(struck) == set(run.assembly.lattice.top_layer.tolist())


def rows(group: Group) -> Iterator[Row]:
    """Speed, decay and what reaches the bottom, of each packing, and over those of the one with empty holes."""
    for velocity, runs in group.by_velocity.items():
        empty = runs[0] if runs[0].small == "empty holes" else None
        for run in runs:
            name = f"{run.small}, {velocity:g} m/s"
            yield Row(f"Speed of the pulse, {name}", "m/s", None, run.wave_speed, _WHERE)
            yield Row(f"Decay of its peak per layer, {name}", "", None, run.decay, _WHERE, digits=3)
            if empty is None or run is empty:
                continue
            ratio = float(run.at_bottom[1].max() / empty.at_bottom[1].max())
            yield Row(f"Peak at the bottom over that with empty holes, {name}", "", None, ratio, _WHERE)


def pictures(group: Group) -> Iterator[Picture]:
    """Peak of the layers' velocity along the packing, and the force on the bottom."""
    for velocity, runs in group.by_velocity.items():
        figure, left, right = panels(2.8, 2)
        data: dict[str, Array] = {}
        for run, colour, mark in zip(runs, COLOURS, MARKS * 2, strict=False):
            depth, peak = run.layers[0] / run.case.packing.diameter, run.pulse.velocity / velocity
            time, force = run.at_bottom
            left.plot(depth, peak, mark, color=colour, markersize=2.5, label=run.small)
            right.plot(1e3 * time, force, color=colour)
            name = column_name(run.small)
            data |= {f"{name}_depth_diameters": depth, f"{name}_peak_over_v": peak}
            data |= {f"{name}_time_s": time, f"{name}_bottom_N": force}
        left.set(xlabel="Depth (diameters)", ylabel="Peak velocity over that of the top", yscale="log")
        right.set(xlabel="Time (ms)", ylabel="Force on the bottom, less the static one (N)")
        legend_outside(figure, 3, fontsize=7)
        caption = f"Plane pulse in an fcc packing by what is in its octahedral holes, top layer at {velocity:g} m/s"
        yield Picture(f"_{velocity:g}_m_s".replace(".", "_"), caption, Drawing(figure, data))
