"""Elasto-plastic chain after a pulse: dissipation.

The energy dissipated in three chains up to each contact is compared with the model of the source: a
contact of peak force F dissipates d0 + d1 F + d2 F^2 (2.28), with the law of the source for the
peak force.
"""

import numpy as np
from matplotlib.figure import Figure
from plastic_waves import DECAY, INVERSE, PLACE, SPACING, START, SWITCH, groups, peak_force, usual
from scipy.interpolate import PchipInterpolator

import granwave as gw

QUADRATIC = (1.23e-4, -3.63e-7, 1.86e-8)  # d0, d1, d2 in J, J/N, J/N^2, for brass of R = 4.76 mm
FITTED_TO = 1e3  # N: upper end of our fit of the law with the same form
LAST = 87  # contact: x/R* = 348, where Fig. 2.16 ends


def dissipated(wave):
    """Energy dissipated up to each contact, J."""
    return np.cumsum(wave.of_contacts("dissipated_energy"))[: wave.contacts]


def summed(contacts, peak):
    """The model up to each contact, J, with the peak force in units of `peak` = E* R*^2 I (N)."""
    return np.cumsum(
        np.polynomial.polynomial.polyval(peak * peak_force(np.arange(1.0, contacts + 1)), QUADRATIC)
    )


def integrated(contacts, peak):
    """Energy with the integral over distance instead of the sum, from contact 1 on (2.31)."""
    n = np.arange(1.0, contacts + 1)
    d0, d1, d2 = QUADRATIC
    early = np.minimum(n, SWITCH)
    late = np.maximum(n, SWITCH)
    f = START * peak
    c = INVERSE / SPACING * peak
    linear = f / DECAY * (1 - np.exp(-DECAY * (early - 1))) + c * np.log(late / SWITCH)
    square = f**2 / (2 * DECAY) * (1 - np.exp(-2 * DECAY * (early - 1))) + c**2 * (
        1 / SWITCH - 1 / late
    )
    return d0 * (n - 1) + d1 * linear + d2 * square


def by_law(law, force):
    """Energy dissipated in a contact with this peak force (N) by the law of the runs, J."""
    overlap = np.geomspace(law.yield_overlap, law.effective_radius, 4000)
    return PchipInterpolator(law.loading_force(overlap), law.dissipated_energy(overlap))(force)


def rows(runs):
    waves = list(map(usual, groups(runs)))
    law = waves[0].law
    unit = law.yield_force * law.yield_overlap
    # fmt: off
    for wave in waves:
        own = dissipated(wave)
        ours = own[LAST - 1]
        model = summed(LAST, wave.unit)[-1]
        integral = integrated(LAST, wave.unit)[-1]
        remark = ("Theory: the sum of 2.28, which the source calls accurate for small impulses "
                  "and within 6 % for others. The integral of the source in place of the sum "
                  f"gives {integral / unit:.4g} ({ours / integral - 1:+.0%}): it omits half of "
                  f"contact 1, which dissipates {own[0] / ours:.0%}.")
        if (constant := LAST * QUADRATIC[0] / model) > 0.1:
            remark += (f" The constant d0, counted at every contact, contributes {constant:.0%} of "
                       "the sum.")
        yield gw.Row(f"Dissipated up to contact {LAST} / (F_y alpha_y), {wave.tag}",
                     ours=ours / unit, theory=model / unit, where="thesis Fig. 2.16", remark=remark)
    forces = np.array([1e3, 5e3])
    fitted_at = np.linspace(law.yield_force, FITTED_TO, 500)
    compared = "; ".join(f"{np.polynomial.polynomial.polyval(force, QUADRATIC):.4g} J at {force:g} "
                         f"N (law: {lost:.4g} J)" for force, lost in zip(forces, by_law(law, forces), strict=True))
    remarks = ("It depends on the range of the fit. With the printed constants a contact "
               f"dissipates {compared}.",
               "It depends on the range of the fit, and even changes sign.",
                   "It is fitted to the law.")
    fit = np.polynomial.Polynomial.fit(fitted_at, by_law(law, fitted_at), 2).convert().coef
    table = zip(("J", "J/N", "J/N^2"), QUADRATIC, fit, remarks, strict=True)
    for n, (per, printed, theory, remark) in enumerate(table):
        yield gw.Row(f"d{n} of 2.28, fitted to the law up to {FITTED_TO:g} N", per, printed, theory=theory,
                     where="thesis 2.28", remark="The constant is printed as normalised; it is "
                                                 f"interpreted as {per} for brass contacts of R = "
                                                 f"4.76 mm, where it agrees with the law. {remark}")
    # fmt: on


def pictures(runs):
    figure = Figure((3.5, 2.8), layout="constrained")
    axes = figure.subplots()
    data = {}
    for n, wave in enumerate(map(usual, groups(runs))):
        unit = wave.law.yield_force * wave.law.yield_overlap
        data |= {
            f"place_{wave.name}": wave.x,
            f"dissipated_over_yield_{wave.name}": dissipated(wave) / unit,
        }
        axes.plot(wave.x, dissipated(wave) / unit, f"C{n}", label=wave.label)
        for name, line, model in (("sum", "--", summed), ("integral", ":", integrated)):
            data[f"model_{name}_{wave.name}"] = values = model(wave.contacts, wave.unit) / unit
            axes.plot(wave.x, values, f"{line}C{n}", label=None if n else f"model, {name}")
    axes.set(
        xlabel=PLACE,
        ylabel=r"Dissipated $E/F_\mathrm{y}\alpha_\mathrm{y}$",
        xlim=(0, None),
        ylim=(0, None),
    )
    axes.legend(fontsize=7)
    by_model = [values[-1] for name, values in data.items() if name.startswith("model")]
    total = next(values[-1] for name, values in data.items() if name.startswith("dissipated"))
    ends = " and ".join(f"{100 * (value / total - 1):+.0f} %" for value in by_model[:2])
    caption = (
        "Energy dissipated up to each contact, and the model of the source with its own constants "
        "(thesis Fig. 2.16). The first contacts dissipate most; at the largest impulse the sum "
        f"and the integral of the model end {ends} away"
    )
    yield gw.Picture("elastoplastic_dissipation", caption, figure, data)
