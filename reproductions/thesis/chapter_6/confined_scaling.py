"""Confined chains: similar waves.

Hertz's law has no length scale. If velocities scale as v, displacements and the precompression a as
v^(4/5), forces as v^(6/5) and speeds as v^(1/5), the motion is the same (6.11). The source has
impacts at 2 m/s with the same a and with a scaled value of a. The moving geometry has a length
scale, which breaks the similarity slightly.
"""

import math

from confined_rows import FORCE, VELOCITY, ConfinedRun
from matplotlib.figure import Figure

import granwave as gw


def measured(runs):
    """Runs of n = 8: at 1 m/s, at 2 m/s with the same a, and at 2 m/s with a scaled a."""
    found = sorted(
        (run for run in map(ConfinedRun, runs) if run.n == 8), key=lambda run: (run.impact, run.a)
    )
    same, similar = found[-2:]
    return next(run for run in found if math.isclose(run.a, same.a)), same, similar


def rows(runs):
    first, same, similar = measured(runs)
    figure = {"where": "thesis figure 6.8"}
    where = {"where": "thesis 6.11"}
    # fmt: off
    yield gw.Row("Velocity v of the smaller impact in the legend", source=2.56e-8, theory=1 / VELOCITY, **figure,
                 remark="The printed value is v D sqrt(m_b/k_bb) of 1 m/s in place of v/D "
                        "sqrt(m_b/k_bb).")
    yield gw.Row("a scaled with 2 m/s", source=8.4e-4, ours=similar.a, theory=2**0.8 * 4.8e-4,
        **figure,
                 remark="Theory: 2^0.8 times 4.8e-4.")
    for contact in (100, 200):
        yield gw.Row(f"Exponent of peak force against velocity, contact {contact}, n = 8", source=1.2, theory=6 / 5,
                     ours=math.log2(similar.peaks[contact - 1] / first.peaks[contact - 1]), **where)
    yield gw.Row("Exponent of speed against velocity, n = 8", source=0.2, ours=math.log2(similar.speed / first.speed),
                 theory=1 / 5, **where)
    yield gw.Row("Decrease of F/v^1.2 at contact 200, same a", "%", **figure,
                 ours=100 * (1 - same.peaks[199] / first.peaks[199] / 2**1.2),
                 remark="In the source the curves do not coincide. For the faster wave, the "
                        "same a is smaller relative to the overlaps.")
    # fmt: on


def pictures(runs):
    figure = Figure((5, 2.6), layout="constrained")
    data = {}
    axes = figure.subplots()
    for run, look in zip(measured(runs), ("-", "-.", "--"), strict=True):
        contact, force = run.profile
        scaled = force * FORCE / run.impact**1.2
        axes.plot(contact, scaled, look, label=f"{run.impact:g} m/s, a = {run.a:.3g}")
        name = f"{run.impact:g}_m_s_a_{run.a:.3g}"
        data |= {f"contact_{name}": contact, f"force_{name}": scaled}
    axes.set(xlabel="Contact", ylabel=r"$F/v^{6/5}$ (N (m/s)$^{-1.2}$)", ylim=(0, None))
    axes.legend()
    caption = (
        "Peak force divided by the power 6/5 of the velocity: the curves coincide if a is "
        "scaled with the velocity (thesis figure 6.8)"
    )
    yield gw.Picture("confined_scaling", caption, figure, data)
