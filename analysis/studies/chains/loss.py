"""Viscous losses of elastic contacts: restitution against velocity, and waves that decay along a chain.

A loss time A gives two equal spheres with Hertz's law F = K alpha^(3/2) the restitution (Schwager and Poeschel, Phys.
Rev. E 78, 2008, 051304)

    e = 1 - 1.153449 b + 0.798267 b^2 + 0.266666 b^(5/2) + ...      b = (3/2) A (K/m*)^(2/5) v^(1/5)

and Tsuji's dashpot one that does not depend on v. A wave whose largest force F falls slowly has the shape of the
solitary wave of F at each contact, whose duration goes with F^(-1/6) and whose energy with F^(5/3). So

    F^(-1/6) rises linearly along the chain with a loss time,   ln F falls linearly with a dashpot.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from granwave.analysis.figures.chains import losses as figures
from granwave.analysis.figures.chains.losses import Curve
from granwave.analysis.studies.chains.runs import ChainRun, uniform
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row
from granwave.lammps_inputs.case.loss import DashpotRestitution, Loss
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.contact.loss import Viscous, viscous_loss

TITLE = "Losses in contacts: restitution, and waves that decay"
TEXT = (
    "Two equal elastic spheres that collide, and elastic chains whose first bead is struck, with the three kinds of "
    "loss: a loss time, the loss time of a restitution at a velocity, and Tsuji's dashpot."
)
_SERIES = (-1.153449, 0.798267, 0.266666)  # coefficients of b, b^2, b^(5/2)
_IN_SERIES = 0.2  # largest b: what is left out is some b^3
_FIRST = 8  # contact from which on a wave has its shape
_FEWEST = 12  # contacts that a fit takes
_END = 6  # contacts at the end of a chain that are left out


@dataclasses.dataclass(frozen=True, eq=False)
class Wave:
    """Wave along a chain, by the largest force of each contact."""

    run: ChainRun

    @cached_property
    def force(self) -> Curve:
        """Number of the contact from the struck end, from 0, and its largest force, N."""
        peaks = self.run.force.max(axis=0)
        contacts = np.arange(len(peaks))[_FIRST : len(peaks) - _END]
        return contacts.astype(float), peaks[contacts]

    @property
    def kind(self) -> str:
        """Kind of the loss in the plugin: time or dashpot."""
        found = viscous_of(self.run)
        assert found is not None
        return found[0]

    @cached_property
    def fit(self) -> tuple[float, float]:
        """Slope and largest misfit of F^(-1/6), or of ln F, over that of the first contact shown."""
        contacts, force = self.force
        share = force / force[0]
        scaled = share ** (-1 / 6) if self.kind == "time" else np.log(share)
        slope, start = np.polyfit(contacts, scaled, 1)
        return float(slope), float(np.abs(np.polyval((slope, start), contacts) - scaled).max() / np.ptp(scaled))

    @cached_property
    def fitted(self) -> Curve:
        """The same curve by the law of its kind of loss."""
        contacts, _ = self.force
        slope = self.fit[0] * (contacts - contacts[0])
        return contacts, (1 + slope) ** -6.0 if self.kind == "time" else np.exp(slope)


@dataclasses.dataclass(frozen=True, eq=False)
class Losses:
    """Collisions and waves by the label of their loss, collisions by rising velocity."""

    collisions: dict[str, list[FinishedRun]]
    waves: dict[str, Wave]


def viscous_of(run: FinishedRun) -> Viscous | None:
    """Loss time or factor of the contacts of a run."""
    own = run.case.material
    return viscous_loss(run.assembly, run.case.contact, own, own)


def label_of(loss: Loss) -> str:
    """Label of a loss."""
    if loss.time is not None:
        return f"time {1e6 * loss.time:g} µs"
    if loss.restitution is not None:
        return f"restitution {loss.restitution:g} at {loss.velocity:g} m/s"
    if isinstance(loss.dashpot, DashpotRestitution):
        return f"dashpot of restitution {loss.dashpot.restitution:g}"
    return f"dashpot {loss.dashpot:g}"


def select(runs: Sequence[FinishedRun]) -> list[Losses]:
    """Collisions of two like elastic spheres, and recorded chains of which the first bead is struck, with losses."""
    lossy = [run for run in runs if run.case.contact.loss is not None and run.case.contact.law == "hertz"]
    lossy = [run for run in lossy if viscous_of(run) is not None]
    collisions: dict[str, list[FinishedRun]] = {}
    for run in sorted(lossy, key=lambda one: one.case.load.velocity):
        if run.assembly.n_spheres == 2 and not math.isnan(run.value("restitution")):
            collisions.setdefault(label_of(_loss(run)), []).append(run)
    waves: dict[str, Wave] = {}
    for run in uniform(lossy, "hertz"):
        if run.load.kind == "impact" and run.assembly.n_spheres >= _FIRST + _FEWEST + _END:
            waves.setdefault(label_of(_loss(run)), Wave(run))
    return [Losses(collisions, waves)] if collisions or waves else []


def rows(found: Losses) -> Iterator[Row]:
    """Restitution beside formulas, and the decay of waves beside its law."""
    for label, runs in found.collisions.items():
        for run in (runs[0], runs[-1])[: len(runs)]:
            formula = _restitution(run)
            if formula is not None:
                speed = run.case.load.velocity
                yield Row(f"Restitution at {speed:g} m/s, {label}", "", None, run.value("restitution"),
                          "series of viscoelastic spheres" if _time(run) else "collision by Runge and Kutta", "",
                          formula, True)  # fmt: skip
        loss = _loss(runs[0])
        asked = [run for run in runs if loss.velocity and math.isclose(run.case.load.velocity, loss.velocity)]
        for run in asked:
            yield Row(f"Restitution at {run.case.load.velocity:g} m/s, that was asked for", "", None,
                      run.value("restitution"), "case", "", loss.restitution, True)  # fmt: skip
        if _time(runs[0]) is None and len(runs) > 1:
            values = [run.value("restitution") for run in runs]
            yield Row(f"Restitution at the largest velocity over that at the smallest, {label}", "", None,
                      values[-1] / values[0], "similarity", "", 1.0, True)  # fmt: skip
    for label, wave in found.waves.items():
        contacts, force = wave.force
        shown = "F^(-1/6)" if wave.kind == "time" else "ln F"
        yield Row(f"Largest force at contact {contacts[-1]:.0f} over that at {contacts[0]:.0f}, {label}", "", None,
                  float(force[-1] / force[0]), "", f"{shown} over the contacts is a straight line to "
                  f"{100 * wave.fit[1]:.2g} % of its rise.")  # fmt: skip


def pictures(found: Losses) -> Iterator[Picture]:
    """Restitution against velocity, and the largest force along the chains."""
    collisions = {label: _curve(runs) for label, runs in found.collisions.items()}
    theory = {}
    for label, runs in found.collisions.items():
        known = [(run.case.load.velocity, formula) for run in runs if (formula := _restitution(run)) is not None]
        if known:
            theory[label] = (np.array([one[0] for one in known]), np.array([one[1] for one in known]))
    waves = {label: (wave.force[0], wave.force[1] / wave.force[1][0]) for label, wave in found.waves.items()}
    drawing = figures.of_collisions_and_waves(
        collisions, theory, waves, {label: wave.fitted for label, wave in found.waves.items()}
    )
    yield Picture(
        "losses", "Restitution against velocity, and waves along chains, by kind of loss; grey: theory", drawing
    )


def _loss(run: FinishedRun) -> Loss:
    assert run.case.contact.loss is not None
    return run.case.contact.loss


def _curve(runs: Sequence[FinishedRun]) -> Curve:
    return (
        np.array([run.case.load.velocity for run in runs]),
        np.array([run.value("restitution") for run in runs]),
    )


def _time(run: FinishedRun) -> float | None:
    """Loss time, s; None of a dashpot."""
    found = viscous_of(run)
    return found[1] if found is not None and found[0] == "time" else None


def _restitution(run: FinishedRun) -> float | None:
    """Restitution by a formula: by the series where it holds, of a dashpot by the collision of the law."""
    law, mass, speed = sphere_contact(run.case), run.case.sphere_mass / 2, run.case.load.velocity
    time = _time(run)
    if time is None:
        factor = viscous_of(run)
        return float(law.collide(mass, speed, loss_dashpot=factor[1], steps=4000)["restitution"]) if factor else None
    constant = 4 / 3 * law.effective_modulus * math.sqrt(law.effective_radius)
    b = 1.5 * time * (constant / mass) ** 0.4 * speed**0.2
    if b > _IN_SERIES:
        return None
    return 1 + sum(c * b**power for c, power in zip(_SERIES, (1.0, 2.0, 2.5), strict=True))
