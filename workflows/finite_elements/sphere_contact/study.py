"""The study: loading in steps of a share of the overlap, with unloadings and reloadings between.

In loading the overlap grows by the same share in every step, so that small overlaps get as much time as large ones;
unloading goes on until the contact is free of force, at a rate chosen from the elastic stiffness 2 E* a. Changes of
rate are smooth. All of it is slow beside the time that a wave takes through the mesh, which is counted in elements,
hence the numbers of steps below are multiples of ``n``, the elements along a side of the mesh's core.

The overlap is that of the flat faces, and Hertz's that of points far away in half-spaces. What lies between makes a
half-sphere the stiffer: elastic, the force at a given overlap exceeds Hertz's by 0.3 a/R to 0.45 a/R (1 % at
a = 0.03 R, 3.5 % at a = 0.08 R; a: contact radius). At yield of brass, a = 0.011 R, that is 0.4 %.

Chosen by convergence for brass up to 0.2 R*. The contact grows an element at a time, so that the force climbs in small
stairs: with 6000 elements by +-0.5 % beyond 50 alpha_y. Averaged over a few stairs the force changes by at most 0.2 %
when the speed is halved and by at most 0.2 % from 6000 to 12 000 elements (0.4 % from 1500 to 6000, but 1 % below
alpha_y); single entries beyond 50 alpha_y differ by up to 1.2 % and 2 %, as stairs shift.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from granwave.workflows.finite_elements.punch.kernels import STRAIN
from granwave.workflows.finite_elements.punch.material import Elastoplastic
from granwave.workflows.finite_elements.sphere_contact.case import SphereContactCase
from granwave.workflows.finite_elements.sphere_contact.mesh import half_sphere, squares_for
from granwave.workflows.finite_elements.sphere_contact.solver import Contact, Ledger, Solver

STEPS_PER_E_FOLD, STEPS_PER_UNLOADING = 600, 300  # times n, at speed 1
SMOOTHING, DAMPING, MEMORY = 40, 0.1, 20  # times n, over n, times n
TOLERANCE = 0.02  # of the work of the faces, largest error of the energy balance that is accepted
PROFILES = (2e-3, 6e-3, 1e-2, 1.4e-2, 1.8e-2, 4e-2, 8e-2, 0.12, 0.16, 0.20)  # overlaps over R*, thesis 2.3
_CORE = 3.0  # size of the mesh's finest part over the contact radius at first yield
_FIRST_PEAK = 4.0  # alpha_y, of the first unloading
START = 0.3  # alpha_y: below, the rate of loading is about constant
_ELASTIC_UNIT = 1 / 400  # of the largest overlap: stands for alpha_y where that is not reached
_ENTRIES = 200, 100  # of the record, in an e-fold of loading and in an unloading

_AT_REST = 1e-3  # of the rate of loading

LOADING, UNLOADING, RELOADING = range(3)


@dataclasses.dataclass(frozen=True, eq=False)
class Field:
    """The bodies at one instant.

    Attributes
    ----------
    overlap
        m.
    position
        Of the nodes, each body in its own frame, (n_nodes, 2), m.
    von_mises, plastic_strain
        (n_elements,), Pa and 1.
    """

    overlap: float
    position: NDArray[np.float64]
    von_mises: NDArray[np.float64]
    plastic_strain: NDArray[np.float64]


@dataclasses.dataclass
class History:
    """History so far.

    Attributes
    ----------
    end_reason
        ``done``, ``refused`` (energy balance) or ``interrupted``.
    branches, cycles
        `LOADING`, `UNLOADING` or `RELOADING`, and which cycle (from 1; 0: loading) each entry is of.
    ledgers, contact_radii, penetrations
        One for each entry; the last two in m.
    profiles
        Overlap and contact where loading passes `PROFILES`.
    field
        At the largest overlap.
    """

    end_reason: str = "interrupted"
    branches: list[int] = dataclasses.field(default_factory=list)
    cycles: list[int] = dataclasses.field(default_factory=list)
    ledgers: list[Ledger] = dataclasses.field(default_factory=list)
    contact_radii: list[float] = dataclasses.field(default_factory=list)
    penetrations: list[float] = dataclasses.field(default_factory=list)
    profiles: list[tuple[float, Contact]] = dataclasses.field(default_factory=list)
    field: Field | None = None

    def column(self, name: str) -> NDArray[np.float64]:
        """One quantity of the ledgers, (n_entries,)."""
        return np.array([getattr(ledger, name) for ledger in self.ledgers])

    def rows(self, branch: int, cycle: int = 0) -> NDArray[np.int64]:
        """Entries of one branch, in the order of time."""
        return np.flatnonzero((np.array(self.branches) == branch) & (np.array(self.cycles) == cycle))


def yield_unit(case: SphereContactCase) -> float:
    """alpha_y, m; a part of the largest overlap where that does not reach it."""
    unit = case.law.yield_overlap
    return unit if unit < case.max_overlap else case.max_overlap * _ELASTIC_UNIT


def peaks(case: SphereContactCase) -> NDArray[np.float64]:
    """Overlaps from which to unload, m: spread evenly over their logarithm, the last the largest overlap."""
    number, largest = case.run.unloadings, case.max_overlap
    first = min(_FIRST_PEAK * yield_unit(case), 0.5 * largest)
    return np.geomspace(first, largest, number) if number > 1 else np.full(number, largest)


def core_size(case: SphereContactCase) -> float:
    """Size of the finest part of the mesh, m."""
    law = case.law
    radius = math.sqrt(law.effective_radius * min(yield_unit(case), case.max_overlap / 4))
    return min(_CORE * radius, 0.2 * min(case.radii))


def squares(case: SphereContactCase) -> int:
    """The ``n`` of the mesh."""
    radii = case.radii[:1] if case.identical else case.radii
    return squares_for(case.run.elements, radii, core_size(case))


def make_solver(case: SphereContactCase) -> Solver:
    """The solver of a case, at its start."""
    n, core = squares(case), core_size(case)
    number = 1 if case.identical else 2
    return Solver(
        tuple(half_sphere(radius, core, n) for radius in case.radii[:number]),
        tuple(Elastoplastic.of(material) for material in case.materials[:number]),
        smoothing=SMOOTHING * n / case.run.speed,
        damping=DAMPING / n,
        memory=MEMORY * n,
    )


def integrate(
    case: SphereContactCase, solver: Solver, history: History, report: Callable[[History], None] | None = None
) -> None:
    """Run ``solver`` through the case, filling ``history``; ``report`` is called after each entry."""
    _Course(case, solver, history, report).run()


class _Refused(Exception):
    """The energy balance is off."""


class _Course:
    def __init__(
        self, case: SphereContactCase, solver: Solver, history: History, report: Callable[[History], None] | None
    ) -> None:
        self._solver, self._history, self._report = solver, history, report
        n, speed = squares(case), case.run.speed
        self._peaks, self._largest = peaks(case), case.max_overlap
        self._fold = STEPS_PER_E_FOLD * n / speed
        self._way = STEPS_PER_UNLOADING * n / speed
        unit = yield_unit(case)
        self._start = START * min(unit, case.max_overlap)
        self._significant = min(unit, 0.1 * case.max_overlap)
        self._stiffness = 2 * case.law.effective_modulus  # times the contact radius
        self._profiles = [share * case.law.effective_radius for share in PROFILES]

    def run(self) -> None:
        history = self._history
        try:
            self._enter(LOADING, 0)
            for cycle, peak in enumerate(self._peaks, start=1):
                self._load(peak)
                self._cycle(cycle)
            if not len(self._peaks):
                self._load(self._largest, turns=False)
                self._stop()
                self._keep_field()
        except _Refused:
            history.end_reason = "refused"
            return
        history.end_reason = "done"

    def _load(self, peak: float, *, turns: bool = True) -> None:
        """Up to where the overlap will not exceed ``peak`` if the faces turn, or stop, from there on."""
        solver = self._solver
        every = max(1, round(self._fold / _ENTRIES[0]))
        while True:
            back = self._unloading_rate() if turns and solver.force > 0 else 0.0
            left = peak - solver.overlap - _overrun(solver.rate, solver.wish, back, solver.smoothing)
            steps = every if solver.rate <= 0 else min(every, math.ceil(left / solver.rate))
            if steps <= 0:
                return
            solver.advance(steps, self._start / self._fold, 1 / self._fold)
            self._enter(LOADING, 0)

    def _stop(self) -> None:
        solver = self._solver
        still = _AT_REST * solver.rate
        while solver.rate > still:
            solver.advance(max(1, round(self._fold / _ENTRIES[0])), 0.0)
            self._enter(LOADING, 0)

    def _cycle(self, cycle: int) -> None:
        """Unload until the contact is free of force, and reload to where unloading began."""
        solver = self._solver
        rate = self._unloading_rate()
        every = max(1, round(self._way / _ENTRIES[1]))
        small = max(1, every // 5)
        while solver.rate > 0:
            solver.advance(small, -rate)
            self._enter(LOADING, 0)
        peak = solver.overlap
        if cycle == len(self._peaks):
            self._keep_field()
        while solver.force > 0:
            solver.advance(every, -rate)
            self._enter(UNLOADING, cycle)
        while solver.rate < 0:
            solver.advance(small, rate)
            self._enter(UNLOADING, cycle)
        while solver.overlap < peak:
            solver.advance(every, rate)
            self._enter(RELOADING, cycle)

    def _unloading_rate(self) -> float:
        """Change of the overlap in a step that frees the contact in about the time set for it, m."""
        radius = max(self._solver.contact().contact_radius, 1e-12)
        return 1.5 * self._solver.force / (self._stiffness * radius) / self._way

    def _keep_field(self) -> None:
        solver = self._solver
        self._history.field = Field(
            solver.overlap, solver.motion[0].copy(), solver.von_mises, solver.state[:, STRAIN].copy()
        )

    def _enter(self, branch: int, cycle: int) -> None:
        history, ledger, contact = self._history, self._solver.ledger(), self._solver.contact()
        history.branches.append(branch)
        history.cycles.append(cycle)
        history.ledgers.append(ledger)
        history.contact_radii.append(contact.contact_radius if ledger.force > 0 else 0.0)
        history.penetrations.append(contact.penetration)
        if branch == LOADING and self._profiles and ledger.overlap >= 0.999 * self._profiles[0]:
            history.profiles.append((ledger.overlap, contact))
            self._profiles = [overlap for overlap in self._profiles if 0.999 * overlap > ledger.overlap]
        if self._report is not None:
            self._report(history)
        balanced = abs(ledger.balance) <= TOLERANCE * abs(ledger.work)
        if not balanced and not ledger.overlap < self._significant:
            raise _Refused


def _overrun(rate: float, wish: float, back: float, smoothing: float) -> float:
    """How far the overlap still grows, m, when ``-back`` is asked for from now on (`kernels.advance`).

    The rate is then ``(rate + back + (wish + back) t) exp(-t) - back``, t in units of ``smoothing``.
    """
    if rate <= 0:
        return 0.0
    here, there = rate + back, wish + back
    low, high = 0.0, 50.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if (here + there * middle) * math.exp(-middle) > back else (low, middle)
    return smoothing * (here * (1 - math.exp(-low)) + there * (1 - (1 + low) * math.exp(-low)) - back * low)
