"""Bilinear chain under a long load.

A force of 8000 N acts on the first bead for 2.5 ms, with beta 0.8. Plateaus are medians over their
inner six tenths at three instants: under load, after it, and after the trailing front has reached
the leading front. The theory is thesis 4.36 to 4.39 with the stated constants.
"""

import numpy as np
from bilinear_chain import FORCE, VELOCITY, BilinearChain
from matplotlib.figure import Figure

import granwave as gw


class LongLoad:
    """The run, and the closed forms; in 4.38 the second c_u is read as c, without which 4.39 does
    not follow.
    """

    def __init__(self, run):
        self.chain = chain = BilinearChain(run)
        share = chain.share
        rate = chain.rate
        lasts = chain.load.lasts
        self.load = chain.load.largest
        self.v1 = self.load / (chain.mass * rate)
        self.vt = self.v1 * (1 - share)
        self.v2 = self.vt / (1 + share)
        self.f2 = chain.mass * self.v2 * rate
        # when the fronts meet
        met = lasts / (1 - share)
        diameter = chain.scales.diameter
        self.xt = diameter * rate * met
        times = 0.8 * lasts, 1.2 * lasts, 1.15 * met
        first = 0, 0, rate * met - rate / share * (times[2] - met)
        last = rate * times[0], rate / share * (times[1] - lasts), rate * times[2]
        self.rows = [int(np.abs(chain.time - time).argmin()) for time in times]
        inner = [
            slice(int(a + 0.2 * (b - a)), int(a + 0.8 * (b - a)))
            for a, b in zip(first, last, strict=True)
        ]
        places = list(zip(self.rows, inner, strict=True))
        self.velocity, self.force = (
            [np.median(array[at]) for at in places] for array in (chain.velocity, chain.force)
        )
        half = (self.force[0] + self.force[2]) / 2
        k = np.flatnonzero(chain.largest < half)[0]
        self.meeting = np.interp(-half, -chain.largest[k - 1 : k + 1], chain.place[k - 1 : k + 1])


def rows(runs):
    one = LongLoad(runs[0])
    v2 = (
        "The source prints 14.5 to 15, near vt. Only about 10 m/s agree with the printed F2, "
        "since F2 D = m v2 c."
    )
    fronts = "The printed value is ten times too small"
    apart = f"{fronts}. At 3 ms, in Fig. 4.9, the fronts are still separate, one near 2.3 m."
    axis = (
        "The axis of Fig. 4.9(a) extends to 0.14 E*R*^2, six times the load, and is not compared."
    )
    # fmt: off
    table = (  # quantity, unit, numerical and predicted as printed, ours, theory, remarks on both
        ("v1, velocity behind the leading front", "m/s", 26.4, 26.18, one.velocity[0], one.v1, "", ""),
        ("vt, velocity behind the trailing front", "m/s", 14.6, 14.47, one.velocity[1], one.vt, "", ""),
        ("v2, velocity once the fronts have met; source: lowest of its 14.5 to 15", "m/s", 14.5, 14.84, one.velocity[2],
         one.v2, v2, "4.39 as printed gives the theory value, not 14.84 m/s."),
        ("F2, force once the fronts have met", "N", 3060, 3056, one.force[2], one.f2, "", ""),
        ("xt, where the fronts meet", "m", 0.333, 0.342, one.meeting, one.xt, apart, f"{fronts}."),
    )
    table_4_1 = {"where": "thesis 4.2.2, table 4.1"}
    for what, unit, printed, _, ours, theory, remark, _ in table:
        yield gw.Row(what, unit, printed, ours, theory=theory, remark=remark, **table_4_1)
    for what, unit, _, printed, _, theory, _, remark in table:
        name = f"{what.split(',')[0]} as predicted by 4.36 to 4.39"
        yield gw.Row(name, unit, printed, theory=theory, remark=remark, **table_4_1)
    yield gw.Row("F1, force behind the leading front under load", "N", ours=one.force[0], theory=one.load,
                 where="balance of forces")
    yield gw.Row("Largest force anywhere / load", ours=one.chain.largest.max() / one.load, where="thesis 4.2.2",
                 remark=f"The force of the first contacts overshoots by inertia. {axis}")
    # fmt: on


def pictures(runs):
    one = LongLoad(runs[0])
    chain = one.chain
    scales = one.chain.scales
    beads = np.arange(1, chain.velocity.shape[1] + 1)
    shown = int(1.15 * chain.rate * chain.time[one.rows[-1]])
    data = {
        "bead": beads,
        "contact": beads[:-1],
        "largest_force_normalised": chain.largest / scales.force,
    }
    figure = Figure((7, 2.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.plot(beads[:-1], chain.largest / scales.force, "k", label="largest ever")
    for row in one.rows:
        force = chain.force[row] / scales.force
        velocity = chain.velocity[row] / scales.velocity
        left.plot(beads[:-1], force, label=f"{chain.time[row] * 1e3:.3g} ms")
        right.plot(beads, velocity, label=f"{chain.time[row] * 1e3:.3g} ms")
        at = f"at_{chain.time[row]:.4g}_s_normalised"
        data |= {f"force_{at}": force, f"velocity_{at}": velocity}
    forces = {"$F_1$": one.load, "$F_2$": one.f2}
    velocities = {"$v_1$": one.v1, "$v_t$": one.vt, "$v_2$": one.v2}
    for axes, lines, unit in ((left, forces, scales.force), (right, velocities, scales.velocity)):
        for name, value in lines.items():
            axes.axhline(value / unit, color="black", linestyle=":", linewidth=0.8)
            axes.text(0.995 * shown, value / unit, name, ha="right", va="bottom")
    left.set(
        xlabel="Contact",
        ylabel=FORCE,
        xlim=(0, shown),
        ylim=(0, 1.7 * chain.largest.max() / scales.force),
    )
    right.set(
        xlabel="Bead", ylabel=VELOCITY, xlim=(0, shown), ylim=(0, 1.7 * one.v1 / scales.velocity)
    )
    for axes in (left, right):
        axes.legend(ncols=2, loc="upper right")
    caption = (
        "Contact forces and bead velocities along the chain at three instants; dotted: closed "
        "forms (thesis Fig. 4.9). Plateaus on the dotted lines confirm the model; the last "
        "instant is after the trailing front has met the leading front"
    )
    yield gw.Picture("bilinear_long_load", caption, figure, data)
