"""FCC packing with grains in its octahedral holes.

An impact on the whole top layer of a loaded fcc packing with periodic sides makes a plane pulse.
The holes between six spheres are empty, or contain spheres of 0.414 times the diameter, which touch
all six spheres. Speed and decay refer to the mean velocity of the layers, between the 11th and the
41st; the decay is the decay of its peak per layer. The force on the bottom is the largest dynamic
force.
"""

from itertools import groupby

import numpy as np
from filter_row import column
from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import pulse_peaks

# layers, from 0
FIRST = 10
LAST = 40
SAME_LAYER = 0.1  # diameters
EMPTY = "empty holes"


class LayeredPacking:
    """A plane pulse in layers of large spheres, with or without grains between them."""

    def __init__(self, run):
        self.case = run.case
        self.velocity = run.case.load.velocity
        grains = run.case.packing.grains
        self.small = (
            run.case.named_material(grains.material[grains.diameter.argmin()]).name
            if grains
            else EMPTY
        )
        result = run.result
        depth = result["spheres/position"][:, 2]
        radius = result["spheres/radius"]
        large = np.flatnonzero(radius > 0.9 * radius.max())
        order = large[np.argsort(depth[large], kind="stable")]
        steps = np.diff(depth[order], prepend=depth[order[0]])
        number = np.cumsum(steps > SAME_LAYER * self.case.packing.diameter)
        count = np.bincount(number)
        self.depth = np.bincount(number, depth[order]) / count
        speeds = [
            np.bincount(number, result.frame(k, "velocity")[order, 2]) / count
            for k in range(result.n_frames)
        ]
        self.pulse = pulse_peaks(result.frame_times, np.array(speeds), np.diff(self.depth).mean())
        self.speed = (self.depth[LAST] - self.depth[FIRST]) / (
            self.pulse.time[LAST] - self.pulse.time[FIRST]
        )
        self.decay = np.log(self.pulse.velocity[FIRST] / self.pulse.velocity[LAST]) / (LAST - FIRST)
        self.time = result["walls/bottom/time"]
        force = result["walls/bottom/force"]
        self.at_bottom = force - force[0]


def measured(runs):
    """Packings by the velocity of the top layer; packings with empty holes first."""
    found = sorted(map(LayeredPacking, runs), key=lambda one: (one.velocity, one.small != EMPTY))
    return [
        (velocity, list(group)) for velocity, group in groupby(found, key=lambda one: one.velocity)
    ]


def rows(runs):
    where = {"where": "not in the source"}
    # fmt: off
    for velocity, (empty, *filled) in measured(runs):
        for one in (empty, *filled):
            name = f"{one.small}, {velocity:g} m/s"
            yield gw.Row(f"Speed of the pulse, {name}", "m/s", ours=one.speed, **where)
            yield gw.Row(f"Decay of its peak per layer, {name}", ours=one.decay, digits=3, **where)
            if one is not empty:
                yield gw.Row(f"Peak at the bottom, filled / empty holes, {name}",
                             ours=one.at_bottom.max() / empty.at_bottom.max(), **where)
    # fmt: on


def pictures(runs):
    for velocity, packings in measured(runs):
        figure = Figure((7, 2.8), layout="constrained")
        data = {}
        left, right = figure.subplots(1, 2)
        for one, mark in zip(packings, "os^D", strict=False):
            depth = one.depth / one.case.packing.diameter
            peak = one.pulse.velocity / velocity
            left.plot(depth, peak, mark, markersize=2.5, label=one.small)
            right.plot(1e3 * one.time, one.at_bottom)
            name = column(one.small)
            data |= {f"{name}_depth_diameters": depth, f"{name}_peak_over_v": peak}
            data |= {f"{name}_time_s": one.time, f"{name}_bottom_N": one.at_bottom}
        left.set(
            xlabel="Depth (diameters)",
            ylabel="Peak velocity / peak velocity of the top",
            yscale="log",
        )
        right.set(xlabel="Time (ms)", ylabel="Dynamic force on the bottom (N)")
        figure.legend(loc="outside upper center", ncols=4, fontsize=7)
        caption = f"Plane pulse in an fcc packing, top layer at {velocity:g} m/s, by the spheres in its octahedral holes: "
        caption += (
            "spheres of aluminium and steel hardly change it, and soft spheres of PTFE "
            "attenuate it along its whole path"
        )
        yield gw.Picture(f"interstitial_fcc_{column(f'{velocity:g}')}_m_s", caption, figure, data)
