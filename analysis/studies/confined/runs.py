"""Finished runs of confined rows: beads on the axis of a tube, and a ring of small spheres around each contact."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.confined.geometry import Row
from granwave.analysis.measures.confined.symmetric import Wave, leading_wave
from granwave.analysis.measures.signals import Array
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.runs import FinishedRun
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.packing.assembly import assemble

CONTACTS = (20, 50, 100, 200)  # whose peak forces are compared
SPEED_BETWEEN = (40, 190)  # contacts; a run that ends sooner, to the last one that the wave has passed
DECAY_BETWEEN = (60, 200)
FORCE = 1e4  # over E* R*^2, for tables
_FEWEST = 20  # beads, for waves with a leading pulse of their own
_ON_AXIS = 1e-6  # of a diameter
_TOUCHING = 1e-6  # gap over the diameter of a bead, of spheres that touch
_LEAST_SPAN = 20  # contacts, for a decay


def row_of(case: Case) -> Row | None:
    """Geometry and materials of a case, if it is such a row, with rings that just touch beads and tube; else None."""
    grains, tube = case.packing.grains, case.boundary.sides_tube
    if grains is None or tube is None or case.boundary.sides_material is not None:
        return None
    beads = beads_of(case)
    others = np.setdiff1d(np.arange(len(grains)), beads)
    if len(beads) < _FEWEST or not len(others):
        return None
    diameters = [np.unique(grains.diameter[one]) for one in (beads, others)]
    place = grains.position[others]
    rings = np.unique(np.round(place[:, 2] / grains.diameter[beads[0]], 6), return_counts=True)[1]
    fits = [len(one) == 1 for one in diameters] + [len(set(rings)) == 1 and len(rings) == len(beads) - 1]
    if not all(fits):
        return None
    big, small_one = (float(one[0]) for one in diameters)
    ring = np.hypot(place[:, 0], place[:, 1])
    gaps = [ring + small_one / 2 - tube, np.hypot(ring, big / 2) - (big + small_one) / 2,
            np.diff(grains.position[beads, 2]) - big]  # fmt: skip
    if max(float(np.abs(gap).max()) for gap in gaps) > _TOUCHING * big:
        return None
    assembly = assemble(case)
    bead, small = (assembly.material_of(int(one[0]) + 1) for one in (beads, others))
    shrinks = case.precompression.tube if case.precompression is not None else 0.0
    values = (float(rings[0]), diameters[0][0], diameters[1][0], tube, shrinks or 0.0, _modulus(bead), _modulus(small),
              bead.density, small.density)  # fmt: skip
    names = [field.name for field in dataclasses.fields(Row)]
    return Row(**{name: np.array([value], dtype=float) for name, value in zip(names, values, strict=True)})


def beads_of(case: Case) -> NDArray[np.intp]:
    """Rows of the grains on the axis, along it."""
    grains = case.packing.grains
    assert grains is not None
    beads = np.flatnonzero(np.hypot(*grains.position[:, :2].T) < _ON_AXIS * case.packing.diameter)
    return beads[np.argsort(grains.position[beads, 2])]


def _modulus(material: Material) -> float:
    return material.youngs_modulus / (1 - material.poisson_ratio**2)


class ConfinedRun(FinishedRun):
    """A finished run of a confined row; contacts and beads count from 1, contact k is that of beads k and k + 1."""

    @cached_property
    def row(self) -> Row:
        """Geometry and materials."""
        found = row_of(self.case)
        assert found is not None
        return found

    @cached_property
    def beads(self) -> NDArray[np.intp]:
        """Rows of the beads among the grains."""
        return beads_of(self.case)

    @property
    def n(self) -> int:
        """Small spheres of a ring."""
        return int(self.row.n[0])

    @property
    def a(self) -> float:
        """Precompression of the thesis, change of the tube's diameter over that of a bead."""
        return float(self.row.a[0])

    @property
    def velocity(self) -> float:
        """Velocity of the struck bead, m/s."""
        return self.case.load.velocity

    @property
    def struck(self) -> int:
        """Number of the struck bead."""
        (index,) = self.case.load.index or (1,)
        return int(np.flatnonzero(self.beads == index - 1)[0]) + 1

    @property
    def label_of_row(self) -> str:
        """``n = 8, a = 1.9e-3``."""
        return f"n = {self.n}, a = {self.a:.3g}"

    @cached_property
    def _contacts(self) -> tuple[Array, Array]:
        place = {int(bead) + 1: k for k, bead in enumerate(self.beads)}
        force, time = np.full((2, len(self.beads) - 1), np.nan)
        with Result(self.directory) as result:
            columns = [result[f"contacts/{name}"] for name in ("i", "j", "peak_force", "time_peak")]
        for i, j, peak, when in zip(*columns, strict=True):
            ends = sorted((place.get(int(i), -1), place.get(int(j), -1)))
            if ends[0] >= 0 and ends[1] == ends[0] + 1:
                force[ends[0]], time[ends[0]] = peak, when
        return force, time

    @cached_property
    def passed(self) -> int:
        """The last contact from which the crest of the leading wave has gone on."""
        force, time = self._contacts
        done = (time[:-1] < time[1:]) & (time[1:] < self.value("end_time_s") * (1 - 1e-6)) & (force[:-1] > 0)
        after = np.flatnonzero(~done[self.struck :])
        return self.struck + (int(after[0]) if len(after) else len(done) - self.struck)

    def peak(self, contact: int) -> float:
        """Largest force of a contact of beads, N; NaN where the wave has not passed."""
        return float(self._contacts[0][contact - 1]) if contact <= self.passed else math.nan

    @property
    def profile(self) -> tuple[Array, Array]:
        """Contacts that the wave has passed, and their largest forces over E* R*^2."""
        contacts = np.arange(self.struck, self.passed + 1)
        return contacts.astype(float), self._contacts[0][contacts - 1] / self.row.force_unit[0]

    @property
    def speed(self) -> float:
        """Speed between two contacts far behind the struck bead, m/s."""
        return speed_of(self._contacts[1][: self.passed], float(self.row.bead[0]))

    @property
    def decay(self) -> float:
        """Minus the slope of ln(peak force), per contact."""
        return decay_of(self._contacts[0][: self.passed])

    @property
    def inward(self) -> float:
        """Mean distance by which the small spheres have moved in at the start, m."""
        with Result(self.directory) as result:
            place = result["spheres/position"]
            moved = result.frame(0, "displacement")
        others = np.setdiff1d(np.arange(len(place)), self.beads)
        across = place[others, :2] / np.linalg.norm(place[others, :2], axis=1)[:, None]
        return -float(np.einsum("ij,ij->i", moved[others, :2], across).mean())

    def probe(self, bead: int, quantity: str) -> tuple[Array, Array] | None:
        """Time (s) and a quantity of a bead, such as ``vz``; None if it was not recorded."""
        name = f"probes/sphere_{int(self.beads[bead - 1]) + 1}_{quantity}"
        with Result(self.directory) as result:
            return (result["probes/time"], result[name]) if name in result else None


def speed_of(time: Array, spacing: float) -> float:
    """Speed of a wave of which the time at each contact is known, m/s; NaN if too few are passed."""
    last = min(SPEED_BETWEEN[1], len(time))
    if last < SPEED_BETWEEN[0] + _LEAST_SPAN:
        return math.nan
    return float((last - SPEED_BETWEEN[0]) * spacing / (time[last - 1] - time[SPEED_BETWEEN[0] - 1]))


def decay_of(force: Array) -> float:
    """Decay per contact, by a straight line through the logarithms; NaN if too few contacts are passed."""
    contacts = np.arange(DECAY_BETWEEN[0], min(DECAY_BETWEEN[1], len(force)) + 1)
    if len(contacts) < _LEAST_SPAN:
        return math.nan
    return -float(np.polyfit(contacts, np.log(force[contacts - 1]), 1)[0])


def confined_runs(runs: Iterable[FinishedRun], *, elastic: bool = True) -> list[ConfinedRun]:
    """Runs of confined rows in which one bead is struck."""
    found = []
    for run in runs:
        case = run.case
        alone = case.load.kind == "impact" and case.load.index is not None and len(case.load.index) == 1
        if alone and (case.contact.law == "hertz") is elastic and row_of(case) is not None:
            found.append(run.seen_as(ConfinedRun))
    return found


def from_thesis(run: ConfinedRun) -> bool:
    """Beads and materials are those of the source, and the tenth is struck."""
    return of_source(run) and math.isclose(run.row.small_density[0], 8500.0, rel_tol=1e-6)


def of_source(run: ConfinedRun) -> bool:
    """Beads and materials are those of the source but for the density of small spheres, and the tenth is struck."""
    row = run.row
    ours = (row.bead[0], row.density[0], row.modulus[0], row.small_modulus[0], run.struck)
    theirs = (0.015, 8500.0, 115e9 / 0.91, 115e9 / 0.91, 10)
    return all(math.isclose(a, b, rel_tol=1e-6) for a, b in zip(ours, theirs, strict=True))


def together(rows: Sequence[Row]) -> Row:
    """One record of several rows."""
    names = [field.name for field in dataclasses.fields(Row)]
    return Row(**{name: np.concatenate([getattr(one, name) for one in rows]) for name in names})


def symmetric_waves(runs: Sequence[ConfinedRun]) -> Wave:
    """The same rows in symmetric motion, as far as the longest run goes."""
    last = min(max(run.passed for run in runs), max(DECAY_BETWEEN[1], *CONTACTS))
    velocity = np.array([run.velocity for run in runs])
    return leading_wave(together([run.row for run in runs]), velocity, runs[0].struck, last)
