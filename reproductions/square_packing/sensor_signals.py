"""Signals of the sensors in a square packing, elastic impacts.

The rows give the acceleration along the chains at the sensors, the speed of the wave between two
sensors, and the length of the pulse at the sensors.
"""

import math
from itertools import pairwise

import numpy as np
from matplotlib.figure import Figure
from packing import source_impacts

import granwave as gw
from granwave.theory import discrete_speed, solitary_lengths

#: Sensors: group of chains, and sphere of the chain with the struck one as 1.
PLACES = {
    "in-plane": {"1A": ("central chains", 6), "1B": ("central chains", 6), "1C": ("central chains", 10),
                 "1D": ("central chains", 15), "2A": ("edge chains", 5), "2B": ("edge chains", 5),
                 "2C": ("edge chains", 8)},
    "out-of-plane": {"3A": ("central chains", 6), "3B": ("central chains", 6), "3C": ("central chains", 8)},
}  # fmt: skip
QUIET = {"in-plane": "2D", "out-of-plane": "3D"}
BETWEEN = {
    "in-plane": (("1B", "1C"), ("2B", "2C")),
    "out-of-plane": (("3B", "3C"),),
}  # for the speed, Figs 8 to 10
DRAWN = {"in-plane": ("1C", "1D", "2B", "2C"), "out-of-plane": ("3B", "3C")}  # lengths of Fig. 11
# s between two samples of the source; m, of its diameters
SAMPLING = 2e-6
TOLERANCE = 1e-5
STEEPEST = 3 * math.sqrt(3) / 16  # largest value of cos^3 sin
DOTTED = "The dotted line is the theory, Nesterenko's wave."
ERROR_BAR = (
    "The value follows from the formula of the source, with 2 µs and 0.01 mm. The "
    "formula neglects gaps, which cause much larger errors."
)


def select(runs):
    return source_impacts(runs)


def name(one):
    return f"square-{one.way}-signals"


def title(one):
    return f"Square packing, {one.way} impact: sensors"


def signals(one):
    """Acceleration of the sensors along their chains and across, in the plane: (n_times,),
    (n_times, 2), m/s^2.
    """
    found = gw.measures.sensor_accelerations(one.run.result)
    place = one.run.result["spheres/position"]
    struck = place[np.array(one.struck) - 1]
    for sensor in one.case.sensor:
        if sensor.name in PLACES[one.way]:
            away = place[sensor.id - 1] - struck
            away = away[np.linalg.norm(away, axis=1).argmin()]
            away /= np.linalg.norm(away)
            along = found[sensor.name] @ away
            yield sensor.name, along, found[sensor.name][:, :2] - np.outer(along, away[:2])


def rows(one):
    run = one.run
    diameter = one.diameter
    material = one.case.material
    time = run.result["probes/time"]
    found = gw.measures.sensor_accelerations(run.result)
    across = 0.0
    largest = max(np.linalg.norm(values, axis=1).max() for values in found.values())
    paths, scaling = (
        {"where": f"square packing, {part}"}
        for part in ("Wave Propagation Path", "Particle Velocity - Wave Speed")
    )
    # fmt: off
    for sensor, along, sideways in signals(one):
        group, place = PLACES[one.way][sensor]
        when, peak = gw.measures.first_peak(time, along, floor=0.5)
        across = max(across, np.abs(sideways).max())
        velocity, speed = (values[place - 1] for values in (one.peaks[group].velocity, one.peaks[group].speed))
        yield gw.Row(f"Peak acceleration at sensor {sensor} ({group}, sphere {place})", "m/s²", ours=peak, **paths,
                     theory=4 * velocity * speed * math.sqrt(10) / (5 * diameter) * STEEPEST,
                     remark="Theory: Nesterenko's wave of the same peak velocity; the wave of the "
                            "discrete chain is shorter.")
        yield gw.Row(f"Time of this peak after the impact, sensor {sensor}", "µs", ours=1e6 * when, **paths)
    yield gw.Row(f"Acceleration across the chains, {one.way}", "% of the largest", 0.0, 100 * across / largest, **paths,
                 remark="The source value is from its simulations.")
    quiet = QUIET[one.way]
    yield gw.Row(f"Largest acceleration at sensor {quiet}, apart from the chains", "% of the largest", theory=0.0,
                 ours=100 * np.linalg.norm(found[quiet], axis=1).max() / largest, **paths,
                 remark="According to the source this sphere is not measurably excited. The "
                        "theory value is due to symmetry.")
    scale = material.youngs_modulus / (diameter / 2 * material.density**1.5 * (1 - material.poisson_ratio**2))
    for pair in BETWEEN[one.way]:
        (group, first), (_, second) = (PLACES[one.way][sensor] for sensor in pair)
        _, speed = gw.measures.speed_between(one.peaks[group], first, second, diameter)
        force = peak_force(run, one.chains[group][0][first - 1 : second + 1])
        way = (second - first) * diameter
        yield gw.Row(f"Factor of the speed against the peak force (equation 3), {group}, {one.way}", "", 0.68,
                     speed / (scale ** (1 / 3) * force ** (1 / 6)), theory=0.6802 * discrete_speed(), **scaling,
                     remark="Theory: the wave of the discrete chain, not of the continuum.")
        yield gw.Row(f"Error bar of the speed, {group}, {one.way}", "%", remark=ERROR_BAR, **scaling,
                     ours=100 * (SAMPLING * speed / way + TOLERANCE / way))
    for sensor in DRAWN[one.way]:
        group, place = PLACES[one.way][sensor]
        for panel, (measure, theory) in zip("abcd", solitary_lengths().items(), strict=True):
            yield gw.Row(f"Pulse length, {measure}, sensor {sensor} ({group}, sphere {place})", "diameters",
                         ours=one.lengths[group][measure][place - 1], theory=theory,
                         where=f"square packing, Fig. 11({panel})", remark=DOTTED)
    # fmt: on


def peak_force(run, ids):
    """Mean of the peak forces of the contacts between neighbours of a chain, N."""
    force = run.contacts.set_index(["i", "j"]).peak_force
    return np.mean([force[min(pair), max(pair)] for pair in pairwise(ids)])


def pictures(one):
    time = one.run.result["probes/time"]
    figure = Figure((4.2, 1.0 + 1.3 * len(BETWEEN[one.way])), layout="constrained")
    panels = dict(
        zip(
            one.chains,
            figure.subplots(len(one.chains), sharex=True, squeeze=False).flat,
            strict=True,
        )
    )
    data = {"time_s": time}
    for n, (sensor, along, _) in enumerate(signals(one)):
        axes = panels[PLACES[one.way][sensor][0]]
        axes.plot(1e6 * time, along, "--" if n % 2 else "-", linewidth=0.9, label=sensor)
        data[f"{sensor}_along_m_s2"] = along
    for group, axes in panels.items():
        axes.set(title=group.capitalize(), xlim=(0, 1e6 * time[-1]))
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    axes.set_xlabel("Time (µs)")
    figure.supylabel("Acceleration (m/s²)", fontsize="medium")
    caption = (
        f"Acceleration of the sensors along the chains against time, {one.way} impact (source Figs "
        "4, 5 and 7). A and B are at symmetric positions, so that their curves coincide; the "
        "delay between sensors gives the speed"
    )
    yield gw.Picture("", caption, figure, data)
