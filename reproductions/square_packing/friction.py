"""Square packing with friction.

The spheres lie on the floor under their weight. There is friction between the spheres, or with the
walls and the floor, or in all these contacts; each row states its coefficients. The rows give the
decrease of the peak velocity, compared with the same impact without friction, at the positions of
sensors: spheres 6 and 15 of a central chain, and 5 and 8 of an edge chain, counted from the
impacted sphere as 1. The source finds a larger decrease in the edge chains and attributes it to
their second wall, without a number or a coefficient of friction.
"""

import numpy as np
from matplotlib.figure import Figure
from packing import Packing

import granwave as gw

WHERE = "square packing, Wave Propagation Path"
PLACES = [("central chains", 6), ("central chains", 15), ("edge chains", 5), ("edge chains", 8)]
AT_STRUCK = (
    "The striker and the next spheres of the central chains hold the two spheres back as they "
    "separate sideways."
)
ROLLING = (
    "Theory: weight times coefficient times path of every sphere. The energy is smaller if "
    "a sphere begins to roll."
)


class Rubbing(Packing):
    """A packing with coefficients of friction between spheres and with walls."""

    def __init__(self, run):
        super().__init__(run)
        self.frictions = self.case.contact.friction, self.case.boundary.friction
        own, walls = self.frictions
        parts = [f"friction {own:g} between spheres"] * (own > 0) + [f"{walls:g} with walls"] * (
            walls > 0
        )
        self.label = " and ".join(parts)
        self.largest = np.array([self.peaks[group].velocity[place - 1] for group, place in PLACES])

    def lost_at_struck(self):
        """Fraction of the friction between spheres at contacts of the impacted spheres."""
        contacts = self.run.contacts
        at = contacts.i.isin(self.struck) | contacts.j.isin(self.struck)
        return contacts.friction_energy[at].sum() / contacts.friction_energy.sum()

    def floor_work(self):
        """Coefficient of friction of the floor times weight and path, summed over all spheres,
        divided by the input.
        """
        places = self.run.fields.displacement.values[:, : self.size[0] * self.size[1], :2]
        way = np.linalg.norm(np.diff(places, axis=0), axis=2).sum()
        weight = self.case.sphere_mass * self.case.precompression.acceleration
        return self.frictions[1] * weight * way / self.run["energy_input_J"]


def measured(runs):
    """Packings in rising order of friction, and the decreases of their peak velocities, %: (n_runs,
    n_places).
    """
    smooth, *found = sorted(map(Rubbing, runs), key=lambda one: one.frictions)
    return found, np.array([100 * (1 - one.largest / smooth.largest) for one in found])


def rows(runs):
    for one, losses in zip(*measured(runs), strict=True):
        own, walls = one.frictions
        # fmt: off
        for (group, place), loss in zip(PLACES, losses, strict=True):
            yield gw.Row(f"Decrease of peak velocity, {group}, sphere {place}: {one.label}", "%", ours=loss, where=WHERE)
        if own:
            yield gw.Row("Fraction of the friction between spheres at contacts of the two "
                         f"impacted spheres: {one.label}", "%",
                         ours=100 * one.lost_at_struck(), where=WHERE, remark=AT_STRUCK)
        if walls and not own:
            yield gw.Row(f"Dissipated at the floor / input: {one.label}", "% of input", ours=100 * one.run["friction_fraction"],
                         theory=100 * one.floor_work(), where=WHERE, remark=ROLLING)
        # fmt: on


def pictures(runs):
    found, losses = measured(runs)
    own, walls = np.array([one.frictions for one in found]).T
    data = {"contact_friction": own, "boundary_friction": walls}
    axes = Figure((5.2, 2.6), layout="constrained").subplots()
    kinds = (("between spheres", walls == 0, "o-"), ("walls and floor", own == 0, "s--"))
    for (group, place), lost in zip(PLACES, losses.T, strict=True):
        word = group.split()[0]
        colour = "C0" if group == "central chains" else "C1"
        data[f"{word}_sphere_{place}_loss_percent"] = lost
        for kind, chosen, mark in kinds if place in (5, 6) else ():
            x = np.maximum(own, walls)[chosen]
            axes.plot(
                [0, *x],
                [0, *lost[chosen]],
                mark,
                color=colour,
                markersize=3,
                label=f"{word}, {kind}",
            )
    axes.set(
        xlabel="Coefficient of friction",
        ylabel="Decrease of peak velocity (%)",
        xlim=(0, None),
        ylim=(0, None),
    )
    axes.figure.legend(loc="outside right upper")
    worst = losses[np.where(walls, 0, own).argmax()]
    most = {
        group: lost for (group, place), lost in zip(PLACES, worst, strict=True) if place in (5, 6)
    }
    caption = (
        "Decrease of the peak velocity, sphere 6 of a central and 5 of an edge chain, against the "
        f"coefficient of friction. Between spheres, a coefficient of {own.max():g} lowers the peak by {' and by '.join(f'{lost:.2g} % in {one}' for one, lost in most.items())}"
    )
    yield gw.Picture("", caption, axes.figure, data)
