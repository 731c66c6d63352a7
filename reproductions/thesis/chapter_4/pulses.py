"""Peak force of elastic pulses.

A constant force acts on the first of 200 elastic beads, with impulses of 0.1 mN s to 0.4 N s. The
value is the peak force of the leading wave, at the last contact that it has passed at the end of
the run. The two largest impulses in the figure of the source would cause overlaps of more than R*,
where no contact law holds. Smaller impulses are equivalent, since the elastic chain has no scale.
"""

import numpy as np
from force_pulses import SECOND, ForcePulse, groups
from matplotlib.figure import Figure

import granwave as gw

# N, of thesis 4.1.3: a train's limit F_peak/A
LOAD = 40.0
PEAK = 92.7
IMPULSE_LIMIT, DISCRETE_LIMIT = (
    (3 / 128) ** 0.6 * c for c in (0.719, 0.7176)
)  # F_peak/I^(6/5): (4.5); discrete chain
CROSSING = IMPULSE_LIMIT / (PEAK / LOAD)


def rows(runs):
    pulses = sorted(map(ForcePulse, runs), key=lambda pulse: pulse.reduced)
    x, y, impulse = np.array(
        [(pulse.reduced, pulse.reduced_peak, pulse.impulse) for pulse in pulses]
    ).T
    short = x > 8 * CROSSING
    long = x < CROSSING / 8
    alike = (x[1:] < 1.001 * x[:-1]) & (np.abs(np.diff(np.log(impulse))) > 1)
    spread = np.expm1(np.abs(np.diff(np.log(y)))[alike].max())
    # fmt: off
    yield gw.Row("Short pulses: F_peak/I^(6/5), normalised", ours=y[short].mean(), theory=DISCRETE_LIMIT,
                 where="thesis Fig. 4.3", remark=f"The value is the mean for A/I^(6/5) > {8 * CROSSING:.2g}. "
                                                 f"Theory: the discrete chain; (4.5) gives {IMPULSE_LIMIT:.4f}.")
    yield gw.Row("Long pulses: peak force at a load of 40 N", "N", PEAK, LOAD * (y / x)[long].mean(), where="thesis 4.1.3",
                 remark=f"The value is the mean for A/I^(6/5) < {CROSSING / 8:.2g}, where the "
                        "force only changes the scale.")
    yield gw.Row("Largest spread of F_peak/I^(6/5) between impulses at equal A/I^(6/5)", "%", ours=100 * spread,
                 theory=0.0, verification=True, where="thesis Fig. 4.3",
                 remark="The power must vanish, since a Hertzian chain has no intrinsic scale.")
    for duration, source, what in ((1e-6, 1.0, "one wave"), (1e-4, None, "a train of waves")):
        for pulse in pulses:
            load = pulse.chain.load
            if np.allclose((load.impulse, load.lasts), (0.4, duration), rtol=1e-3, atol=0):
                count = np.count_nonzero(pulse.waves >= SECOND)
                name = f"Waves above 1 % at contact {pulse.contact}, 0.4 N s within {1e6 * duration:g} us"
                yield gw.Row(name, source=source, ours=count, where="thesis 4.1.1", remark=(
                    f"According to the source there is {what}."))
    # fmt: on


def pictures(runs):
    pulses = sorted(map(ForcePulse, runs), key=lambda pulse: pulse.reduced)
    names = ("amplitude", "duration", "impulse", "peak", "reduced", "reduced_peak")
    table = {name: np.array([getattr(pulse, name) for pulse in pulses]) for name in names}
    x = table["reduced"]
    y = table["reduced_peak"]
    figure = Figure((7, 2.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    for n, group in enumerate(groups(pulses, "impulse")):
        style = {"color": f"C{n}", "label": f"{group[0].impulse:.3g}"}
        left.loglog(
            [p.amplitude for p in group], [p.peak for p in group], "o-", markersize=3, **style
        )
        right.plot(
            [p.reduced for p in group],
            [p.reduced_peak for p in group],
            "o",
            fillstyle="none",
            ms=4 + 2 * n,
        )
    left.set(xlabel=r"Amplitude $A/(E^* R^{*2})$", ylabel=r"Peak force $F/(E^* R^{*2})$")
    left.legend(title=r"Impulse $I/(E^* R^{*2} \tau)$", loc="lower right", fontsize=7)
    fine = np.geomspace(0.5 * x[0], 2 * x[-1], 200)
    right.plot(x, y, ".k", markersize=3, label="simulation")
    right.plot(
        fine,
        np.full_like(fine, IMPULSE_LIMIT),
        "--",
        color="0.5",
        label=f"{IMPULSE_LIMIT:.4f} (thesis 4.5)",
    )
    right.loglog(
        fine, PEAK / LOAD * fine, ":", color="0.5", label=rf"{PEAK / LOAD:.2f} $A/I^{{6/5}}$"
    )
    right.set(xlabel=r"$A/I^{6/5}$, normalised", ylabel=r"Peak force $F/I^{6/5}$, normalised")
    right.set_ylim(0.5 * y.min(), 3 * IMPULSE_LIMIT)
    right.legend(loc="lower right")
    caption = (
        "Peak force against amplitude by impulse. Divided by the power 6/5 of the impulse, all "
        "values lie on one curve (thesis Fig. 4.3). On its flat part pulses are short and the "
        "impulse determines the force; on its slope they are long and the amplitude determines it"
    )
    yield gw.Picture("elastic_master_curve", caption, figure, table)
