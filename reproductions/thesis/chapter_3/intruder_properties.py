"""Intruder in steel at position 10, by its properties.

A chain of 20 steel beads ends on an elastic bar; one property of the bead at position 10 differs.
Ratios e_T/e_0T are relative to the chain of identical beads. In most runs contacts are compressed
beyond 0.2 R*, where the fit of the contact law ends; the law is extrapolated there, as in the
source. A bead of mass m, whose contacts have the slope k ~ sigma_y R*, has the characteristic time
tau* = D sqrt(rho/sigma_y) if R* is proportional to its radius. Next to beads of another radius R*
varies less, and sqrt(m/sigma_y) ~ R^1.5 is closer.
"""

import math

import numpy as np
from matplotlib.figure import Figure
from odd_bead import OddBead

import granwave as gw

WHERE = "thesis Fig. 3.8"
RATIO = 3.0  # ratio of the normalised times at which the collapse is evaluated
#: Powers of the ratio of each property in tau* = D sqrt(rho/sigma_y), and in sqrt(m/sigma_y).
POWERS = {
    "yield strength": (-0.5, -0.5),
    "density": (0.5, 0.5),
    "radius": (1.0, 1.5),
    "modulus": (0.0, 0.0),
}
STRONGER = "The weaker bead of a contact yields, so that a stronger intruder has no effect."
SLIGHT = "The effect is very small, as in the source."
KEPT = (
    "Contacts of a large bead keep the R* of the neighbours, so that the curves do not fully "
    "collapse."
)
CLOSER = "With R^1.5 in place of R the curves for different radii are closer."


def measured(runs):
    """Ratios of each property (in rising order) and of the transmitted energy to the values of the
    chain of identical beads.
    """
    chains = list(map(OddBead, runs))
    (base,) = [one for one in chains if one.alike]
    found = {}
    for key in POWERS:
        same = [
            one
            for one in chains
            if all(one.properties[k] == base.properties[k] for k in POWERS if k != key)
        ]
        ratios = [
            (one.properties[key] / base.properties[key], one.energy / base.energy) for one in same
        ]
        found[key] = np.array(sorted(ratios)).T
    return found


def rows(runs):
    found = measured(runs)
    for key, curve in found.items():
        for ratio, energy in curve[:, [0, -1]].T:
            remark = (
                STRONGER
                if key == "yield strength" and ratio > 1
                else SLIGHT
                if key == "modulus"
                else ""
            )
            yield gw.Row(
                f"e_T/e_0T at {ratio:.3g} times the {key}", ours=energy, where=WHERE, remark=remark
            )
    for k, (what, remark) in enumerate(
        (("D sqrt(rho/sigma_y)", KEPT), ("sqrt(m/sigma_y)", CLOSER))
    ):
        energies = []
        for key in ("yield strength", "density", "radius"):
            x, y = found[key]
            order = np.argsort(x ** POWERS[key][k])
            energies.append(np.interp(math.log(RATIO), np.log(x[order]) * POWERS[key][k], y[order]))
        name = f"Spread of e_T/e_0T at {RATIO:g} times {what}"
        yield gw.Row(name, ours=max(energies) - min(energies), where=WHERE, remark=remark)


def pictures(runs):
    figure = Figure((6.8, 2.8), layout="constrained")
    data = {}
    left, right = figure.subplots(1, 2, sharey=True)
    for (key, (x, y)), style in zip(
        measured(runs).items(), ("C0o-", "C1s-", "C2^-", "C3D:"), strict=True
    ):
        to_time, to_mass = POWERS[key]
        left.plot(x ** (to_time or 1.0), y, style, markersize=4, label=key)
        if to_mass:
            right.plot(x**to_mass, y, style, markersize=4)
        slug = key.replace(" ", "_")
        data |= {f"{slug}_ratio": x, f"energy_ratio_by_{slug}": y}
    for axes in (left, right):
        axes.axvline(1, color="black", linewidth=0.5)
        axes.set(xscale="log")
    left.set(xlabel=r"$\tau^*_i/\tau^*_0$,  $\tau^* = D\sqrt{\rho/\sigma_y}$;  modulus: $E_i/E_0$")
    left.set(ylabel="Transmitted energy $e_T/e_{0T}$")
    right.set(xlabel=r"$\sqrt{m_i\sigma_0/(m_0\sigma_i)}$")
    left.legend(loc="lower left")
    caption = (
        "Transmitted energy relative to identical beads, against the properties of one bead: by "
        "its time (thesis Fig. 3.8), and by mass / strength. Curves coincide for the governing "
        "property; the modulus has hardly any effect"
    )
    yield gw.Picture("intruder_properties", caption, figure, data)
