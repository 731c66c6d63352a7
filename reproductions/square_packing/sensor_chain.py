"""A lighter sphere in a chain.

The largest contact force of the reflected wave is divided by the force of the incident wave, four
contacts before the sphere, until waves from the far end can arrive. The source states neither the
amplitude nor the position of its measurement.
"""

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import Chain, reflection

BEFORE = 4  # contacts between the lighter sphere and the one at which the reflection is measured
# g, as the source weighed them; % of the incident wave
SOLID = 28.79
SENSOR = 26.52
LIMIT = 1.2
SETUP = {"where": "square packing, Experimental Setup"}


def measured(runs):
    """Mass of the sphere relative to the others, reflected fraction (%), and the recorded times and
    forces, in order of rising mass.
    """
    found = []
    for run in runs:
        chain, (sphere,) = Chain(run), run.case.replace
        place = sphere.index[0] - BEFORE  # the contact of the striker is number 0
        share = 100 * reflection(chain.time, chain.force, place, BEFORE + 2)
        found.append(
            (
                sphere.material.density / run.case.material.density,
                share,
                chain,
                chain.force[:, place],
            )
        )
    return sorted(found, key=lambda one: one[0])


def rows(runs):
    for ratio, share, chain, _ in measured(runs):
        weighed = abs(ratio - SENSOR / SOLID) < 0.005
        # fmt: off
        if weighed:
            yield gw.Row("Mass of a solid sphere", "g", SOLID, 1e3 * chain.mass, **SETUP,
                         remark="The source value was measured by weighing; our value is "
                                "calculated from the density and the diameter of the source.")
            yield gw.Row("Mass of a sphere with a sensor", "g", SENSOR, 1e3 * ratio * chain.mass, **SETUP,
                         remark="The value is the ratio of the weighed masses.")
            yield gw.Row("Their ratio", "%", 92.0, 100 * ratio, **SETUP)
        yield gw.Row(f"Largest reflection of a sphere of {ratio:.3g} of the mass of the others",
            "% of the wave",
                     LIMIT if weighed else None, share, **SETUP, bound=weighed,
                     remark="The source states a reflection of less than 1.2 %." if weighed else "")
        # fmt: on


def pictures(runs):
    found = measured(runs)
    ratios, shares = np.array([one[:2] for one in found]).T
    figure = Figure((7, 2.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.plot(100 * ratios, shares, "o-", markersize=3, label="simulation")
    left.plot(100 * SENSOR / SOLID, LIMIT, "v", color="0.5", label="upper bound of the source")
    left.set(
        xlabel="Mass of the sphere (% of other spheres)",
        ylabel="Reflection (% of the wave)",
        ylim=(0, None),
    )
    left.legend()
    data = {"mass_ratio": ratios, "reflection_percent": shares}
    for n, (ratio, _, chain, force) in enumerate(found):
        scaled = force / force.max()
        colour = colormaps["viridis"](0.9 * n / len(found))
        right.plot(
            1e6 * chain.time,
            100 * scaled,
            color=colour,
            linewidth=0.9,
            label=f"{100 * ratio:.3g} %",
        )
        data |= {
            "time_s": chain.time,
            f"mass_{100 * ratio:.3g}_percent_force_over_incident": scaled,
        }
    right.set(
        xlabel="Time (µs)",
        ylabel="Force (% of the incident wave)",
        ylim=(0, 25),
        xlim=(0, None),
    )
    right.legend(ncols=2, fontsize=7, title="mass")
    caption = (
        f"Largest reflection against the mass of the lighter sphere, and force {BEFORE} contacts "
        "before it against time. The incident wave is cut off; the reflected wave follows, which "
        "is smaller for a mass closer to the other spheres"
    )
    yield gw.Picture("", caption, figure, data)
