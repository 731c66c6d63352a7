"""Intruder in brass, by position.

A chain of 19 brass beads and one bead of aluminium or steel ends on an elastic bar; 10 kN act on
the first bead for 100 µs. Chains of 20 beads of one material are the comparison. Except in the
chain of steel, contacts are compressed beyond 0.2 R*, where the fit of the contact law ends; the
law is extrapolated there, as in the source.
"""

import numpy as np
from matplotlib.figure import Figure
from odd_bead import OddBead

import granwave as gw

QUANTITIES = (
    ("Transmitted energy", "J", "energy"),
    ("Peak transmitted force / load", "", "peak"),
)
BRASS = "brass"
INTRUDERS = ("aluminium", "steel")


def measured(runs):
    """Chains of one material, by its name; and positions of the intruder with energies and peak
    forces, by the name of its material.
    """
    chains = sorted(map(OddBead, runs), key=lambda chain: chain.place)
    alike = {chain.base.name: chain for chain in chains if chain.alike}
    curves = {name: [one for one in chains if one.base.name == BRASS and one.material.name == name]
              for name in INTRUDERS}  # fmt: skip
    return alike, {
        name: {
            key: np.array([getattr(one, key) for one in curve])
            for key in ("place", "energy", "peak")
        }
        for name, curve in curves.items()
    }


def rows(runs):
    alike, curves = measured(runs)
    where = "thesis Fig. 3.7"
    # fmt: off
    for name in (BRASS, *INTRUDERS):
        for what, unit, key in QUANTITIES:
            yield gw.Row(f"{what}, all {name}", unit, ours=getattr(alike[name], key), where=where)
    for name, curve in curves.items():
        for what, unit, key in QUANTITIES:
            values = curve[key]
            of = f"{what}, {name}"
            for which, k in (("smallest", values.argmin()), ("largest", values.argmax())):
                yield gw.Row(f"{of}: {which}, at position {curve['place'][k]}",
                             unit, ours=values[k], where=where)
            change = np.abs(values / getattr(alike[BRASS], key) - 1).max()
            yield gw.Row(f"{of}: largest change relative to the brass chain",
                         ours=change, where=where)
    # fmt: on


def verdict(runs):
    alike, curves = measured(runs)
    parts = []
    for name, curve in curves.items():
        least, most = (
            f"{curve['energy'][k]:.3g} J for position {curve['place'][k]}"
            for k in (curve["energy"].argmin(), curve["energy"].argmax())
        )
        parts.append(f"of {name} from {least} to {most}")
    yield (
        f"Energy in the bar with one intruder in brass: {'; '.join(parts)}. Without an intruder it "
        f"is {alike[BRASS].energy:.3g} J."
    )


def pictures(runs):
    alike, curves = measured(runs)
    figure = Figure((3.4, 4.2), layout="constrained")
    data = {}
    upper, lower = figure.subplots(2, sharex=True)
    for (name, curve), style in zip(curves.items(), ("C0o", "C1s"), strict=True):
        upper.plot(
            curve["place"], curve["energy"], f"{style}-", markersize=3, label=f"one of {name}"
        )
        lower.plot(curve["place"], curve["peak"], f"{style}--", markersize=3)
        data |= {f"place_of_{name}": curve["place"], f"{name}_energy_J": curve["energy"]}
        data[f"{name}_peak_force_over_load"] = curve["peak"]
    for name, colour in ((BRASS, "0.5"), *zip(INTRUDERS, ("C0", "C1"), strict=True)):
        upper.axhline(alike[name].energy, color=colour, linestyle=":", label=f"all {name}")
        lower.axhline(alike[name].peak, color=colour, linestyle=":")
        data |= {
            f"all_{name}_energy_J": [alike[name].energy],
            f"all_{name}_peak_force_over_load": [alike[name].peak],
        }
    upper.set(ylabel="Energy in the bar (J)", ylim=(1.1, 2.3))
    upper.legend(ncols=2)
    lower.set(
        xlabel="Position of the intruder, from the impacted end",
        ylabel="Peak transmitted force / load",
    )
    changes = {(name, place): energy / alike[BRASS].energy - 1 for name, curve in curves.items()
               for place, energy in zip(curve["place"], curve["energy"], strict=True)}  # fmt: skip
    name, place = max(changes, key=lambda one: abs(changes[one]))
    caption = (
        "Energy and peak force at the bar against the position of the intruder (thesis Fig. 3.7); "
        f"dotted: chains of one material. The largest effect is {100 * changes[name, place]:+.0f} "
        f"% of the energy, by {name} at position {place:g}"
    )
    yield gw.Picture("intruder_place", caption, figure, data)
