"""Solitary wave of an impulse.

The first of 100 elastic beads has an initial velocity. The peak force is at the last contact that
the wave has passed. The speed follows from the peaks of contacts halfway to this contact. The
profile is the velocity of a bead halfway between them, with its time converted into position by the
speed.
"""

import math

import numpy as np
from matplotlib.figure import Figure
from scipy.interpolate import CubicSpline

import granwave as gw
from granwave.measures import Chain, power_law, width
from granwave.theory import discrete_speed

LENGTH = math.pi * math.sqrt(10) / 2  # length of Nesterenko's wave, diameters
SIMILAR = "The elastic chain has no intrinsic scale, so that every correct code gives this value."
DISCRETE = {
    "coefficient": 0.7176,
    "speed": discrete_speed(),
    "width": 1.579,
}  # values of the discrete chain


class Wave:
    """The wave of an impact on the first bead, far along the chain, in the units of the chain."""

    def __init__(self, run):
        chain = Chain(run)
        scales = chain.scales
        last = chain.passed
        first = last // 2
        peak = chain.of_contacts("peak_force")[last - 1]
        crest = [chain.first_peak(contact - 1)[0] for contact in range(first, last + 1)]
        speed = scales.diameter / np.polyfit(np.arange(len(crest)), crest, 1)[0]
        self.v0 = chain.load.velocity / scales.velocity
        self.speed = speed / scales.velocity
        self.force = peak / scales.force
        self.coefficient = peak / scales.impulse_force(chain.impulse)
        self.over_nesterenko = speed / scales.nesterenko(peak)
        time = np.linspace(chain.time[0], chain.time[-1], 10 * len(chain.time))
        velocity = CubicSpline(chain.time, chain.velocity[:, (first + last) // 2])(time)
        self.x = (time - time[velocity.argmax()]) * speed / scales.diameter
        self.velocity = velocity / velocity.max()
        half = slice(len(chain.time) // 2, None)  # in time
        kinetic = 0.5 * chain.mass * (np.maximum(chain.velocity[half], 0) ** 2).sum(axis=1)
        elastic = 0.4 * (chain.force[half] * scales.overlap(chain.force[half])).sum(axis=1)
        self.virial = np.mean(4 * kinetic) / np.mean(5 * elastic)


def measured(runs):
    """Waves by velocity, and their columns."""
    waves = sorted(map(Wave, runs), key=lambda wave: wave.v0)
    names = ("v0", "force", "speed", "coefficient", "over_nesterenko")
    return waves, {name: np.array([getattr(wave, name) for wave in waves]) for name in names}


def spread(values):
    return f"The spread of {len(values)} runs is {100 * (values.max() / values.min() - 1):.1g} %. {SIMILAR}"


def rows(runs):
    waves, t = measured(runs)
    middle = waves[len(waves) // 2]
    force = power_law(t["v0"], t["force"])
    speed = power_law(t["force"], t["speed"])
    half = width(middle.x, middle.velocity)
    foot = width(middle.x, middle.velocity, 1e-3)
    c = t["coefficient"]
    over = t["over_nesterenko"]
    discrete_c = DISCRETE["coefficient"]
    names = (
        "Peak force / (m^3 E*^2 R* v^6)^(1/5)",
        "Speed / Nesterenko's speed at the same peak force",
        "Full width at half maximum of the bead velocity, diameters",
    )
    discrete = "The theory is the discrete chain, by our second solver."
    by_solver = {"where": "our second solver", "verification": True}
    by_similarity = {"where": "thesis 4.1.2", "verification": True}
    # fmt: off
    return [
        gw.Row("Exponent of the peak force against the velocity of the first bead",
               ours=force.exponent, theory=1.2,
               remark=f"{force.interval} {SIMILAR}", **by_similarity),
        gw.Row("Exponent of the wave speed against its peak force",
               ours=speed.exponent, theory=1 / 6,
               remark=f"{speed.interval} {SIMILAR}", **by_similarity),
        gw.Row(names[0], source=0.719, theory=DISCRETE["coefficient"], where="thesis (4.5)", remark=discrete),
        gw.Row(f"{names[0]}, of the runs", ours=c.mean(), theory=discrete_c, remark=spread(c), **by_solver),
        gw.Row(names[1], source=1.0, theory=DISCRETE["speed"], where="composite (4)",
               remark=f"Nesterenko's value is for the continuum. {discrete}"),
        gw.Row(f"{names[1]}, of the runs", ours=over.mean(), theory=discrete_speed(),
               remark=spread(over), **by_solver),
        gw.Row(names[2], ours=half, theory=2 * math.acos(0.5**0.25) / math.pi * LENGTH, where="Nesterenko's cos^4",
               remark="The discrete wave is narrower than the wave of the continuum."),
        gw.Row(f"{names[2]}, discrete chain", ours=half, theory=DISCRETE["width"], remark=SIMILAR, **by_solver),
        gw.Row("Width of the wave at 0.001 of its largest velocity, diameters", source=5.0, ours=foot, theory=LENGTH,
               where="thesis 4.1", remark="The cos^4 profile ends after 4.97 diameters. The "
                                          "discrete wave has no end, and its width depends on the "
                                          "level."),
        gw.Row("Virial 4 K / 5 P of the wave", ours=middle.virial, theory=1.0, where="thesis (4.14)",
               remark="The value is an average over the second half of the run, without the beads "
                      "that rebounded."),
    ]
    # fmt: on


def pictures(runs):
    waves, t = measured(runs)
    place = np.linspace(-3.5, 3.5, 281)
    cos4 = np.where(np.abs(place) < 0.5 * LENGTH, np.cos(2 * place / math.sqrt(10)) ** 4, 0.0)
    figure = Figure((7, 2.5), layout="constrained")
    left, middle, right = figure.subplots(1, 3)
    left.loglog(t["v0"], 0.719 * t["force"] / t["coefficient"], "0.6", label="0.719 (thesis 4.5)")
    left.loglog(t["v0"], t["force"], "o", label="simulation")
    left.set(
        xlabel=r"Velocity of the first bead $v_0 \tau/R^*$", ylabel=r"Peak force $F/(E^* R^{*2})$"
    )
    middle.loglog(t["force"], t["speed"] / t["over_nesterenko"], "0.6", label="Nesterenko")
    middle.loglog(t["force"], t["speed"], "o", label="simulation")
    middle.set(xlabel=r"Peak force $F/(E^* R^{*2})$", ylabel=r"Speed $V \tau/R^*$")
    right.plot(place, cos4, "0.6", label=r"$\cos^4$")
    for wave in waves:
        right.plot(
            wave.x,
            wave.velocity,
            "C0",
            linewidth=0.8,
            label="" if wave is not waves[0] else "simulation",
        )
    right.set(xlabel="Position (from time), diameters", ylabel="Bead velocity / largest")
    right.set(xlim=(-3.5, 3.5), ylim=(0, 1.4))
    for axes in (left, middle, right):
        axes.legend()
    data = {f"{name}_normalised": values for name, values in t.items()} | {
        "place_diameters": place,
        "cos4": cos4,
    }
    data |= {
        f"profile_{n}": np.interp(place, wave.x, wave.velocity)
        for n, wave in enumerate(waves, start=1)
    }
    over = 100 * (t["over_nesterenko"].mean() - 1)
    caption = (
        "Peak force against velocity of the first bead, speed against peak force, and profile; "
        f"grey: Nesterenko's wave. The powers agree; the wave of the discrete chain is {over:.1f} "
        "% faster and narrower"
    )
    yield gw.Picture("elastic_solitary_wave", caption, figure, data)
