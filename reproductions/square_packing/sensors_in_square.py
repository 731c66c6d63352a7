"""Sensor spheres in a square packing.

Spheres with sensors are lighter. Their effect on the peak velocity and its time at the sensors is
compared with equal spheres. In the experiments of the source with a chain, no trend was found.
"""

import numpy as np
from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import first_peak, sensor_velocities

FELT = 0.01  # fraction of the largest velocity that marks the passage of the wave at a sensor
SETUP = {"where": "square packing, Experimental Setup"}


def measured(runs):
    """Time (s), and speed (m/s) of every sensor, by the mass of the spheres with sensors relative
    to the other spheres.
    """
    found = {}
    for run in runs:
        sensor = run.case.sensor[0].id
        speeds = sensor_velocities(run.result)
        speeds = {name: np.linalg.norm(velocity, axis=1) for name, velocity in speeds.items()}
        found[run.spheres.mass[sensor] / run.case.sphere_mass] = run.result["probes/time"], speeds
    return dict(sorted(found.items(), reverse=True))


def rows(runs):
    (_, (like_time, like)), *others = measured(runs).items()
    largest = max(speed.max() for speed in like.values())
    for mass, (time, speeds) in others:
        for name, speed in speeds.items():
            (early, theirs), (late, ours) = (
                first_peak(*signal, floor=0.5)
                for signal in ((like_time, like[name]), (time, speed))
            )
            if theirs > FELT * largest:
                where = f"sensor {name}, {mass:.3g} of the mass of other spheres"
                yield gw.Row(
                    f"Change of peak velocity, {where}",
                    "%",
                    ours=100 * (ours / theirs - 1),
                    **SETUP,
                )
                yield gw.Row(
                    f"Delay of the peak, {where}", "µs", ours=1e6 * (late - early), **SETUP
                )


def pictures(runs):
    found = measured(runs)
    names = ("1B", "1C", "1D", "2B", "2C")
    figure = Figure((7, 2.6), layout="constrained")
    panels = figure.subplots(1, len(names), sharey=True)
    data = {}
    for axes, name in zip(panels, names, strict=True):
        for mass, (time, speeds) in found.items():
            axes.plot(1e6 * time, speeds[name], linewidth=0.9, label=f"{100 * mass:.3g} %")
            data |= {"time_s": time, f"{name}_mass_{100 * mass:.3g}_percent_m_s": speeds[name]}
        axes.set(title=name, xlabel="Time (µs)", ylim=(0, None), xlim=(0, 1e6 * time[-1]))
    panels[0].set_ylabel("Speed of the sensor (m/s)")
    figure.legend(
        *axes.get_legend_handles_labels(),
        loc="outside upper center",
        ncols=3,
        title="mass of the spheres",
    )
    caption = (
        "Speed of the spheres with sensors against time, by their mass relative to the other "
        "spheres. Lighter spheres move slightly faster, and the wave arrives slightly earlier: "
        "the distance from the curve of 100 % is the error due to the sensor"
    )
    yield gw.Picture("", caption, figure, data)
