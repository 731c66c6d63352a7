"""Bilinear chain far from a short pulse.

An impulse of 0.1 N s acts on the first of 400 beads with the bilinear law, beta = 0.7, 0.8, 0.9.
Behind the front all beads soon have the same velocity, and the peak force falls with the inverse of
the distance.
"""

import numpy as np
from bilinear_chain import PEAK_FORCE, VELOCITY
from bilinear_waves import measured
from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import power_law

# contacts of the fit
FIRST = 30
LAST = 300
FRONTS = (119.1, 238.2, 357.4)  # sqrt(k/m) t of Fig. 4.8: 1.5, 3 and 4.5 ms


def power(one):
    """Power law of the largest force against the distance."""
    return power_law(np.arange(FIRST, LAST + 1.0), one.largest[FIRST - 1 : LAST])


def instants(one):
    """Indices of the recorded times, bead velocities at these times (m/s), the front, and I/m
    divided by the number of moving beads.
    """
    for phase in FRONTS:
        row = np.abs(one.far.rate * one.far.time - phase).argmin()
        velocity = one.far.velocity[row]
        front = np.flatnonzero(velocity > 0.5 * velocity[: len(velocity) // 10 + 2].mean())[-1] + 1
        yield row, velocity, front, one.velocity_unit / front


def rows(runs):
    pulses = measured(runs)
    last = pulses[-1]
    # fmt: off
    for one in pulses:
        yield gw.Row(f"Exponent of the peak force against distance, contacts from {FIRST} on, beta {one.beta:g} (4.35)",
                     source=-(1 + one.beta) / 2, ours=power(one).exponent, theory=-1.0, where="thesis 4.2.1", digits=2,
                     remark="The power of the source follows from an energy balance. Beads of the "
                            "same velocity conserve the momentum I only if the power is -1, which "
                            "is the theory value.")
    for row, velocity, front, theory in instants(last):
        at = last.far.time[row]
        scale = last.far.scales.velocity
        behind = velocity[: int(0.9 * front)]
        yield gw.Row(f"Mean velocity behind the front at {1e3 * at:.2f} ms, beta {last.beta:g}, in R*/tau",
                     ours=behind.mean() / scale, theory=theory / scale, where="thesis 4.2.1, Fig. 4.8",
                     remark=f"The standard deviation is {behind.std() / behind.mean():.1%}. "
                            "Theory: the impulse divided by the mass of all beads up to the "
                            "front.")
    # fmt: on


def pictures(runs):
    pulses = measured(runs)
    last = pulses[-1]
    scales = pulses[-1].far.scales
    beads = np.arange(1.0, last.far.velocity.shape[1] + 1)
    rate = last.far.rate
    end = last.far.time[-1]
    figure = Figure((7, 2.7), layout="constrained")
    left, right = figure.subplots(1, 2)
    data = {"contact": beads[:-1], "bead": beads}
    reached = beads[:-1] < 0.95 * rate * end
    for one in pulses:
        data[f"largest_force_beta_{one.beta:g}"] = force = one.largest / scales.force
        name = rf"$\beta$ = {one.beta:g}, power {power(one).exponent:.2f}"
        left.loglog(beads[:-1][reached], force[reached], label=name)
    guide = np.array([20.0, 320.0])
    left.loglog(guide, 100 * force[49] / guide, "--k", label="power -1")
    left.set(xlabel="Contact", ylabel=PEAK_FORCE)
    left.legend()
    for n, (row, velocity, _, shared) in enumerate(instants(last)):
        time = last.far.time[row]
        data[f"velocity_at_{time:.4g}_s"] = velocity / scales.velocity
        right.plot(beads, velocity / scales.velocity, f"C{n}", label=f"{1e3 * time:.3g} ms")
        right.axhline(shared / scales.velocity, color=f"C{n}", linestyle=":")
    right.set(xlabel="Bead", ylabel=VELOCITY, ylim=(0, 1.6 * right.get_ylim()[1]))
    right.legend(title=rf"$\beta$ = {last.beta:g}; dotted: $I/nm$")
    caption = (
        "Peak force against distance; far down the chain it approaches the power -1. Right: "
        "velocities at three instants (thesis Fig. 4.8). The impulse is distributed over the "
        "beads behind the front, I/nm (dotted)"
    )
    yield gw.Picture("bilinear_far", caption, figure, data)
