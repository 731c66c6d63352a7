"""Spheres with sensors in a chain on a load cell.

An impact acts on a chain with a load cell at its end: a plate on a spring, whose force is the
reading of the cell. Spheres 6, 11 and 16, singly and together, have the mass of a sphere with a
sensor. The rows give the changes of the first peak of the reading and of its width at half maximum,
compared with identical spheres. The source finds no change of the wave length and no clear trend of
the amplitude in ten impacts each. It states neither the mass nor the stiffness of the cell, nor the
repeatability of impacts. Our mass and stiffness of the cell are assumed; a rigid wall in its place
gives changes of the same size.
"""

import numpy as np
from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import first_peak, width

ENDS = ("load cell", "rigid wall")
SETUP = {"where": "square packing, Experimental Setup"}


class Reading:
    """Time (s), force (N) and first peak of the cell's reading: its spring, or the wall."""

    def __init__(self, run):
        case = run.case
        self.end = ENDS[case.boundary.bottom_support is None]
        self.lighter = [number for one in case.replace for number in one.index]
        self.mass_ratio = (
            min((one.material.density for one in case.replace), default=0) / case.material.density
        )
        self.spheres = named(self.lighter)
        wall = run.walls[run.walls.wall == "bottom"]
        self.time = wall.time.to_numpy()
        self.force = wall["ground_force" if self.end == ENDS[0] else "force"].to_numpy()
        self.when, self.peak = first_peak(self.time, self.force, floor=0.5)
        felt = self.time[np.argmax(wall.force > 0.01 * wall.force.max())]
        near = self.time < self.when + 2 * (self.when - felt)
        self.width = width(self.time[near], self.force[near])


def named(numbers):
    """``identical spheres``, ``sphere 6``, ``spheres 6, 11 and 16``."""
    if not numbers:
        return "identical spheres"
    *others, last = map(str, numbers)
    return f"spheres {', '.join(others)} and {last}" if others else f"sphere {last}"


def by_end(runs):
    """Readings at each end, identical spheres first."""
    found = sorted(map(Reading, runs), key=lambda one: (len(one.lighter), one.lighter))
    return {end: [one for one in found if one.end == end] for end in ENDS}


def rows(runs):
    for end, (like, *others) in by_end(runs).items():
        yield gw.Row(f"First peak, identical spheres, {end}", "N", ours=like.peak, **SETUP)
        for one in others:
            where = f"{end}, {one.mass_ratio:.3g} of the mass: {one.spheres}"
            higher = 100 * (one.peak / like.peak - 1)
            longer = 100 * (one.width / like.width - 1)
            # fmt: off
            yield gw.Row(f"Change of the first peak, {where}", "%", ours=higher, **SETUP,
                         remark="The source finds no clear trend.")
            yield gw.Row(f"Change of its width, {where}", "%", ours=longer, **SETUP,
                         remark="The source finds no measurable change.")
            # fmt: on


def pictures(runs):
    figure = Figure((7, 3), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    data = {}
    for axes, (end, found) in zip(panels, by_end(runs).items(), strict=True):
        first, last = (
            pick(one.when + s * one.width for one in found) for pick, s in ((min, -1.5), (max, 1.5))
        )
        grid = np.linspace(first, last, 400)
        data[f"{end}_time_s".replace(" ", "_")] = grid
        for one in found:
            axes.plot(1e6 * one.time, one.force, linewidth=0.9, label=one.spheres)
            name = "_".join(
                [end, "spheres", *map(str, one.lighter)] if one.lighter else [end, "like_spheres"]
            )
            data[f"{name}_N".replace(" ", "_")] = np.interp(grid, one.time, one.force)
        axes.set(title=end, xlabel="Time (µs)", xlim=(1e6 * first, 1e6 * last), ylim=(0, None))
    panels[0].set_ylabel("Force (N)")
    figure.legend(
        *axes.get_legend_handles_labels(), loc="outside upper center", ncols=3, fontsize=7
    )
    most = max(
        abs(one.peak / found[0].peak - 1) for found in by_end(runs).values() for one in found
    )
    caption = (
        "Force on a load cell, or a rigid wall, at the end of the chain against time, by the "
        "numbers of the spheres that have the mass of a sensor. With lighter spheres the wave "
        f"arrives slightly earlier; the first peak changes by at most {100 * most:.2g} %"
    )
    yield gw.Picture("", caption, figure, data)
