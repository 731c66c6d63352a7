"""Attenuation in plane crystals whose diameters scatter, and as a camera sees it.

The source prints a slightly higher attenuation in the hexagonal crystal (HCP), along its diagonal,
than in the centred-square crystal (BCC), along the vertical. In perfect crystals the order is the
opposite. The source prints no tolerance of its cylinders. Here diameters lie between the nominal
diameter and a value smaller by up to 1 %, with three samples of each. Rates are fitted to the
largest speeds of grains that no signal of the sides has reached. Scatter lowers the rate of BCC,
and the spread between samples is larger than the printed difference of the two crystals.
"""

import numpy as np
from crystal import NAMES, SOURCE, Crystal
from matplotlib.figure import Figure
from scipy.spatial import cKDTree

import granwave as gw

PRINTED = {"BCC": 1.6, "HCP": 1.8}  # 1/m
# of the printed rates: line from the vertical, degrees; its name; pitch, D
ANGLE = {"BCC": 0.0, "HCP": 30.0}
LINE = {"BCC": "along the vertical", "HCP": "along the diagonal"}
PITCH = {"BCC": np.sqrt(2), "HCP": 1.0}
FRAMES = 8000.0  # per second, of the camera
PHASES = 8  # of the frames, between which the means are taken
NEAR = 0.01  # diameters


class Attenuation:
    """Decay rates of a crystal along the two mirrored lines of the printed rate, 1/m."""

    def __init__(self, run):
        crystal = Crystal(run)
        self.name = crystal.name
        packing = crystal.case.packing
        self.scatter = packing.diameter_scatter / packing.diameter
        self.diameter = packing.diameter
        self.time, self.position, self.velocity, self.displacement = (
            run.result[f"lines/all/{name}"]
            for name in ("time", "position", "velocity", "displacement")
        )
        self.top, *_, self.last = run.result["lines/down/position"]
        reached = crystal.meeting if self.name == "BCC" else crystal.count / 2
        steps = np.arange(1, int(reached / PITCH[self.name]) + 1)
        self.distance = PITCH[self.name] * self.diameter * steps
        self.lines = [self.grains(side) for side in (1, -1)]
        largest = np.linalg.norm(self.velocity, axis=2).max(axis=0)
        self.rate = self.mean_rate([largest[grains] for grains in self.lines])
        self.seen = self.mean_rate([self.seen_speeds(grains) for grains in self.lines])

    def grains(self, side):
        """Indices of the grains of a line, to one side of the vertical."""
        angle = side * np.radians(ANGLE[self.name])
        down = np.sign(self.last[2] - self.top[2])
        way = np.array([np.sin(angle), 0.0, down * np.cos(angle)])
        places = self.top + self.distance[:, None] * way
        apart, grains = cKDTree(self.position).query(places)
        if apart.max() > NEAR * self.diameter:
            raise ValueError(f"{self.name}: no grains at an angle of {ANGLE[self.name]:g} degrees")
        return grains

    def seen_speeds(self, grains):
        """Largest speeds of grains from the displacements between frames, averaged over the phase
        of the frames, m/s.
        """
        moved = self.displacement[:, grains][:, :, ::2]
        largest = []
        for phase in np.arange(PHASES) / PHASES:
            frames = np.arange((phase - 1) / FRAMES, self.time[-1], 1 / FRAMES)
            places = np.array([self.at_frames(grain, frames) for grain in moved.transpose(1, 2, 0)])
            speeds = np.linalg.norm(np.diff(places, axis=2) * FRAMES, axis=1)
            largest.append(speeds.max(axis=1))
        return np.mean(largest, axis=0)

    def at_frames(self, grain, frames):
        """Displacements of a grain, sideways and down, at the times of frames: (2, n_frames), m."""
        return [np.interp(frames, self.time, part) for part in grain]

    def mean_rate(self, speeds):
        """Mean rate of the exponentials that are fitted to lines of speeds, 1/m."""
        return np.mean([-np.polyfit(self.distance, np.log(line), 1)[0] for line in speeds])


def by_scatter(runs):
    """Crystals by their name and the scatter of their diameters."""
    found = {}
    for crystal in map(Attenuation, runs):
        found.setdefault((crystal.name, crystal.scatter), []).append(crystal)
    return dict(sorted(found.items()))


def scatters(crystals):
    return sorted({scatter for _, scatter in crystals})


def rates(samples):
    """Rates of the samples, 1/m."""
    return np.array([one.rate for one in samples])


def spread(samples):
    """Text on the rates of the samples, and on rates seen by a camera."""
    found = rates(samples)
    seen = np.mean([one.seen for one in samples])
    words = f"At {FRAMES:.0f} frames/s the rate would be {seen:.2f}."
    if len(found) == 1:
        return words
    return f"{len(found)} samples have {found.min():.2f} to {found.max():.2f}. {words}"


def order_of(crystals, scatter):
    """Words on the order of the two rates."""
    samples = {name: rates(crystals[name, scatter]) for name in NAMES.values()}
    if min(map(len, samples.values())) == 1:
        return "In perfect crystals the rate is higher in BCC."
    apart = abs(PRINTED["HCP"] - PRINTED["BCC"])
    most = max(np.ptp(found) for found in samples.values())
    return (
        f"The rates of the samples of one crystal differ by up to {most:.2f}/m, and the printed "
        f"rates by {apart:.2g}/m, so that the printed order may be due to chance."
    )


def rows(runs):
    crystals = by_scatter(runs)
    for (name, scatter), samples in crystals.items():
        yield gw.Row(
            f"Decay of the peak speed in region 1, {LINE[name]}, scatter of {100 * scatter:g} %, "
            f"{name}", "1/m",
            PRINTED[name], rates(samples).mean(), f"{SOURCE}, Fig. 7", digits=3,
            remark=f"The scatter is our choice; the source prints no tolerance. {spread(samples)}",
        )  # fmt: skip
    for scatter in scatters(crystals):
        means = {name: rates(crystals[name, scatter]).mean() for name in NAMES.values()}
        yield gw.Row(
            f"Decay of HCP / BCC, scatter of {100 * scatter:g} %", "",
            PRINTED["HCP"] / PRINTED["BCC"],
            means["HCP"] / means["BCC"], f"{SOURCE}, Fig. 7", digits=3,
            remark=order_of(crystals, scatter),
        )  # fmt: skip


def pictures(runs):
    crystals = by_scatter(runs)
    figure = Figure((3.5, 2.8), layout="constrained")
    axes = figure.subplots()
    data = {}
    for colour, name in enumerate(NAMES.values()):
        widths = scatters(crystals)
        samples = [rates(crystals[name, scatter]) for scatter in widths]
        means = [found.mean() for found in samples]
        percent = 100 * np.array(widths)
        for place, found in zip(percent, samples, strict=True):
            axes.plot(np.full(len(found), place), found, f".C{colour}", markersize=4, alpha=0.5)
        axes.plot(percent, means, f"oC{colour}-", markersize=4, label=f"{name}, {LINE[name]}")
        axes.axhline(PRINTED[name], color=f"C{colour}", linestyle=":")
        data |= {f"{name}_scatter_percent": percent, f"{name}_decay_per_m": means}
    axes.set(
        xlabel="Scatter of the diameters (%)",
        ylabel="Decay of the peak speed (1/m)",
        ylim=(0, None),
    )
    axes.legend(fontsize=7)
    caption = (
        "Decay of the peak speed in region 1 against the scatter of the diameters, mean of three "
        "samples (small points); dotted: the source"
    )
    yield gw.Picture("lateral_attenuation", caption, figure, data)
