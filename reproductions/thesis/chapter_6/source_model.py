"""Confined chains by the model of the source.

The runs have the equations (6.7) as the source uses them: a wall with the constant (6.4), softer
than Hertz's contact with any wall, no contacts in the rings, and initial directions of forces. The
theory is the same equations, solved without LAMMPS. The other sections have the correct model.
"""

import numpy as np
from confined_rows import BEAD, FORCE, VELOCITY, ConfinedRun, Rows
from matplotlib.figure import Figure
from symmetric_motion import Window, leading_wave

import granwave as gw

CONTACTS = (20, 50, 100, 200)
AXIS = (0.04, 0.085)  # axis of the speeds of Fig. 6.4, in the source's units
WHERE = "thesis (6.7)"


class SourceRows(Rows):
    """Rows of the model of the source."""

    def __post_init__(self):
        """Use the constants of the source, which differ for the wall and the rings."""
        super().__post_init__()
        self.k_wall = self.k_thesis_wall
        self.k_ring = np.zeros_like(self.k_ring)
        self.sine = np.sqrt(1 - self.cosine**2)

    def part(self, which):
        """Some of the rows."""
        whole = super().part(which)
        return SourceRows(whole.n, whole.small, whole.tube, whole.shrinks, whole.density)

    def outward(self, inward):
        """Force on small spheres that are displaced inwards, in an undisturbed row, N."""
        wall = self.k_wall * np.maximum(self.shrinks - inward, 0.0) ** 1.5
        return 2 * self.k_side * (self.sine * inward) ** 1.5 * self.sine - wall


class SourceWindow(Window):
    """Motion with the initial contact directions."""

    def take(self, rows):
        """Set the properties of the followed rows."""
        super().take(rows)
        self.cosine = rows.cosine[:, None]
        self.sine = rows.sine[:, None]

    def side_forces(self, along):
        """Force of a bead on small spheres along the row and outward, N."""
        sign = np.sign(along)
        apart = self.cosine * (np.abs(along) - BEAD / 2) + self.sine * self.u
        overlap = np.maximum(-apart, 0.0)
        force = self.k_side * overlap * np.sqrt(overlap)
        return sign * self.cosine * force, self.sine * force


def select(runs):
    """The rows by n and a; empty without initial normals."""
    confined = [ConfinedRun(run) for run in runs if run.case.contact.normals == "initial"]
    return [sorted(confined, key=lambda run: (run.n, run.a))] if confined else []


def solved(runs):
    """Peak forces of the contacts by the equations, N: (n_runs, last)."""
    rows = [run.rows for run in runs]
    columns = [(one.n, one.small, one.tube, one.shrinks, one.density) for one in rows]
    joined = SourceRows(*(np.concatenate(parts) for parts in zip(*columns, strict=True)))
    force, _ = leading_wave(joined, 1.0, runs[0].struck, CONTACTS[-1], SourceWindow)
    return force


def rows(runs):
    for run, force in zip(runs, solved(runs), strict=True):
        for contact in [one for one in CONTACTS if one <= len(run.peaks)]:
            yield gw.Row(
                f"Peak force / (E* R*^2), contact {contact}, {run.label}", "1e-4",
                ours=1e4 * run.peaks[contact - 1] / FORCE, theory=1e4 * force[contact - 1] / FORCE,
                verification=True, where=WHERE, digits=4,
            )  # fmt: skip
    for name, end, pick in (("Smallest", AXIS[0], min), ("Largest", AXIS[1], max)):
        run = pick(runs, key=lambda one: one.speed)
        words = "at least" if pick is min else "at most"
        yield gw.Row(
            f"{name} speed of these rows in the source's unit, {run.label}, {words}", source=end,
            ours=run.speed / VELOCITY, where="thesis Fig. 6.4", remark=(
                "The bound is the end of the axis."),
            digits=3, bound=True,
        )  # fmt: skip


def pictures(runs):
    figure = Figure((7, 2.8), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    data = {}
    for axes, pressed in zip(panels, (False, True), strict=True):
        for run in runs:
            if bool(run.a) != pressed:
                continue
            contact, force = run.profile
            axes.plot(contact, 1e4 * force, label=run.label)
            name = f"n_{run.n}_{'pressed' if pressed else 'touching'}"
            data |= {f"{name}_contact": contact, f"{name}_force": force}
        axes.set(xlabel="Contact", ylim=(0, None))
        axes.legend(fontsize=7)
    panels[0].set(ylabel="Peak force / ($E^* R^{*2}$) ($10^{-4}$)")
    caption = (
        "Peak forces along chains with 6 to 9 small spheres per ring by the model of the source, "
    )
    caption += "touching and pressed"
    yield gw.Picture("confined_source_model", caption, figure, data)
