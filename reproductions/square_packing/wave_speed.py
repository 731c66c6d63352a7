"""Square packing: wave speed.

The wave speed between two sensors of a chain follows from the times of the velocity peaks. It is
shown against the mean of the peaks, for a scan of the velocity of the striker.
"""

import math

import numpy as np
from matplotlib.figure import Figure
from packing import Packing

import granwave as gw

SENSORS = {
    "in-plane": {"central chains": (6, 10), "edge chains": (5, 8)},
    "out-of-plane": {"central chains": (6, 8)},
}
SIMILAR = "Every correct elastic code gives this value, because of similarity."
WHERE = "square packing, equation 3, Figs 8 to 10"


def measured(runs):
    """Largest particle velocities and wave speeds, m/s, by chain: (n_runs,) each, in order of
    rising velocity of the striker.
    """
    packings = sorted(
        (Packing(run) for run in runs if run.case.contact.law == "hertz"), key=lambda one: one.speed
    )
    found = {}
    for way, places in SENSORS.items():
        for group, ends in places.items():
            chosen = [one for one in packings if one.way == way]
            points = [
                gw.measures.speed_between(one.peaks[group], *ends, one.diameter) for one in chosen
            ]
            if points:
                found[f"{group}, {way}"] = np.array(points).T
    return found


def nesterenko(material, velocity):
    """Speed of the solitary wave with a largest particle velocity, m/s (equation 3)."""
    c2 = (
        2 * material.youngs_modulus / (math.pi * material.density * (1 - material.poisson_ratio**2))
    )
    return (16 / 25) ** 0.2 * c2**0.4 * velocity**0.2


def rows(runs):
    for chain, (velocity, speed) in measured(runs).items():
        fit = gw.measures.power_law(velocity, speed)
        middle = len(speed) // 2
        # fmt: off
        yield gw.Row(f"Exponent of wave speed against particle velocity, {chain}", ours=fit.exponent, theory=0.2,
                     where=WHERE, verification=True, remark=(
                         f"The 95 % confidence interval is ± {fit.margin:.1g}. {SIMILAR}"))
        yield gw.Row(f"Wave speed at {velocity[middle]:.3g} m/s, {chain}", "m/s", ours=speed[middle], where=WHERE,
                     theory=nesterenko(runs[0].case.material, velocity[middle]), remark="Theory: Nesterenko's formula.")
        # fmt: on


def pictures(runs):
    found = measured(runs)
    data = {}
    axes = Figure((3.5, 2.8), layout="constrained").subplots()
    for n, (chain, (velocity, speed)) in enumerate(found.items()):
        fit = gw.measures.power_law(velocity, speed)
        word = chain.replace(", ", "_").replace(" ", "_").replace("-", "_")
        axes.loglog(
            velocity,
            speed,
            "osd"[n] + f"C{n}",
            markersize=4,
            fillstyle="none",
            label=f"{chain}: {fit.exponent:.4f}",
        )
        axes.loglog(velocity, fit(velocity), f"C{n}", linewidth=0.8)
        data |= {f"{word}_peak_velocity_m_s": velocity, f"{word}_speed_m_s": speed}
    every = np.concatenate([velocity for velocity, _ in found.values()])
    line = np.geomspace(every.min(), every.max(), 20)
    axes.loglog(line, nesterenko(runs[0].case.material, line), ":k", label="Nesterenko: 1/5")
    axes.set(xlabel="Largest particle velocity (m/s)", ylabel="Wave speed (m/s)", ylim=(None, 1500))
    axes.legend(loc="upper left")
    caption = (
        "Wave speed against largest particle velocity, with fitted powers (source Figs 8 to 10). "
        "Identical elastic spheres have no scale of their own, which forces the power 1/5; only "
        "the height of the marks above Nesterenko's line is a comparison"
    )
    yield gw.Picture("", caption, axes.figure, data)
