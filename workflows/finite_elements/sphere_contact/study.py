"""Loading programme of a sphere contact, exponential loading with unload-reload cycles, and its cost.

On loading the overlap grows by the same fraction in every step, so that every decade of overlap takes the same time.
Unloading continues until the contact force vanishes, at a rate chosen from the elastic stiffness 2 E* a. Changes of
rate are smooth. All this is slow compared with the transit time of waves through the mesh, which is proportional to its
number of elements in a row; hence the numbers of steps below are multiples of ``n``, the elements along a side of the
mesh's core.

The overlap is that of the flat faces; Hertz's is that of remote points in half-spaces. A half-sphere is therefore
stiffer: the elastic force at a given overlap exceeds Hertz's by 0.3 a/R to 0.45 a/R (1 % at a = 0.03 R, 3.5 % at
a = 0.08 R; a: contact radius). At yield of brass, a = 0.011 R, the difference is 0.4 %.

The constants were chosen by convergence for brass up to 0.2 R*. The contact grows by one element at a time, so that the
force has small steps: +-0.5 % with 6000 elements beyond 50 alpha_y. Averaged over a few of them the force changes by at
most 0.2 % if the speed is halved, and by at most 0.2 % from 6000 to 12 000 elements (0.4 % from 1500 to 6000, but 1 %
below alpha_y); single values beyond 50 alpha_y differ by up to 1.2 % and 2 %, as the steps shift.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.planning.schedule import MOST_STEPS
from granwave.workflows.finite_elements.frame import ElementPlan
from granwave.workflows.finite_elements.material import STRAIN, Elastoplastic
from granwave.workflows.finite_elements.sphere_contact.case import SphereContactCase
from granwave.workflows.finite_elements.sphere_contact.mesh import half_sphere, squares_for
from granwave.workflows.finite_elements.sphere_contact.solver import Contact, Ledger, Solver

STEPS_PER_E_FOLD, STEPS_PER_UNLOADING = 600, 300  # times n, at speed 1
SMOOTHING, DAMPING, MEMORY = 40, 0.1, 20  # times n, over n, times n
TOLERANCE = 0.02  # largest accepted error of the energy balance over the work of the faces
PROFILES = (2e-3, 6e-3, 1e-2, 1.4e-2, 1.8e-2, 4e-2, 8e-2, 0.12, 0.16, 0.20)  # overlaps over R*
_CORE = 3.0  # size of the mesh's finest part over the contact radius at first yield
_FIRST_PEAK = 4.0  # overlap of the first unloading over alpha_y
START = 0.3  # overlap over alpha_y below which the loading rate is about constant
_ELASTIC_UNIT = 1 / 400  # unit in place of alpha_y, if that is not reached, over the largest overlap
_ENTRIES = 200, 100  # entries of the history in an e-fold of loading and in an unloading
_AT_REST = 1e-3  # rate over the loading rate at which the faces count as at rest
_ELEMENT_STEPS_PER_SECOND = 18e6  # measured on one core
_BEGINNING = 2.0  # s, set-up, results and figures
_TURNS = 5.2  # steps of the changes of rate in a cycle over `SMOOTHING`
_DISK_PER_ELEMENT = 100.0  # bytes
_DISK_BASE = 4e6  # bytes, history and figures

LOADING, UNLOADING, RELOADING = range(3)


@dataclasses.dataclass(frozen=True, eq=False)
class Field:
    """Fields of the bodies at one instant.

    Attributes
    ----------
    overlap
        Overlap, m.
    position
        Positions of the nodes, each body in its own frame, (n_nodes, 2), m.
    von_mises, plastic_strain
        Von Mises stresses, Pa, and equivalent plastic strains of the elements, (n_elements,).
    """

    overlap: float
    position: NDArray[np.float64]
    von_mises: NDArray[np.float64]
    plastic_strain: NDArray[np.float64]


@dataclasses.dataclass
class History:
    """History of a sphere contact, filled by `integrate`.

    Attributes
    ----------
    end_reason
        Why it ended: ``done``, ``refused`` (energy balance) or ``interrupted``.
    branches, cycles
        `LOADING`, `UNLOADING` or `RELOADING`, and number of the cycle (from 1; 0: loading) of each entry.
    ledgers, contact_radii, penetrations
        Ledger, contact radius (m) and penetration (m) of each entry.
    profiles
        Overlap (m) and contact at which loading passes `PROFILES`.
    field
        Fields at the largest overlap.
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
        """Return one quantity of the ledgers, (n_entries,)."""
        return np.array([getattr(ledger, name) for ledger in self.ledgers])

    def rows(self, branch: int, cycle: int = 0) -> NDArray[np.int64]:
        """Return the indices of the entries of one branch, in the order of time."""
        return np.flatnonzero((np.array(self.branches) == branch) & (np.array(self.cycles) == cycle))


def yield_unit(case: SphereContactCase) -> float:
    """Return alpha_y, m, or a fraction of the largest overlap if that does not reach it."""
    unit = case.law.yield_overlap
    return unit if unit < case.max_overlap else case.max_overlap * _ELASTIC_UNIT


def peaks(case: SphereContactCase) -> NDArray[np.float64]:
    """Return the overlaps at which to unload, m: evenly spaced in their logarithm up to the largest overlap."""
    number, largest = case.run.unloadings, case.max_overlap
    first = min(_FIRST_PEAK * yield_unit(case), 0.5 * largest)
    return np.geomspace(first, largest, number) if number > 1 else np.full(number, largest)


def core_size(case: SphereContactCase) -> float:
    """Return the size of the finest part of the mesh, m."""
    law = case.law
    radius = math.sqrt(law.effective_radius * min(yield_unit(case), case.max_overlap / 4))
    return min(_CORE * radius, 0.2 * min(case.radii))


def squares(case: SphereContactCase) -> int:
    """Return the ``n`` of the mesh."""
    radii = case.radii[:1] if case.identical else case.radii
    return squares_for(case.run.elements, radii, core_size(case))


def make_solver(case: SphereContactCase) -> Solver:
    """Make the solver of a case, at its start."""
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
    """Run ``solver`` through the case and fill ``history``; call ``report`` after each entry."""
    _LoadingProgramme(case, solver, history, report).run()


class _Refused(Exception):
    """Error of an energy balance that does not close."""


class _LoadingProgramme:
    """Run of a solver through loading and all cycles."""

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
        """Load until turning, or stopping, would just not exceed the overlap ``peak``."""
        solver = self._solver
        every = max(1, round(self._fold / _ENTRIES[0]))
        while True:
            back = self._unloading_rate() if turns and solver.force > 0 else 0.0
            left = peak - solver.overlap - _overrun(solver.rate, solver.target_rate, back, solver.smoothing)
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
        """Unload until the contact force vanishes, and reload to the overlap at which unloading began."""
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
        """Return the change of overlap in a step that unloads the contact in about the set time, m."""
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


def _overrun(rate: float, target_rate: float, back: float, smoothing: float) -> float:
    """Return the further growth of the overlap, m, if the target is ``-back`` from now on (`kernels.advance`).

    The rate is then ``(rate + back + (target_rate + back) t) exp(-t) - back``, with t in units of ``smoothing``.
    """
    if rate <= 0:
        return 0.0
    here, there = rate + back, target_rate + back
    low, high = 0.0, 50.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if (here + there * middle) * math.exp(-middle) > back else (low, middle)
    return smoothing * (here * (1 - math.exp(-low)) + there * (1 - (1 + low) * math.exp(-low)) - back * low)


def plan(case: SphereContactCase) -> ElementPlan:
    """Plan the run of a case; raise InputError if it has too many steps."""
    n, start = squares(case), START * yield_unit(case)
    loading = STEPS_PER_E_FOLD * math.log1p(case.max_overlap / start)
    cycle = 2 * STEPS_PER_UNLOADING + _TURNS * SMOOTHING
    n_steps = n / case.run.speed * (loading + case.run.unloadings * cycle)
    if not n_steps <= MOST_STEPS:
        raise InputError(
            f"{case.name}: run.speed: found {case.run.speed:g}, which takes {n_steps:.3g} steps, expected at most "
            f"{MOST_STEPS:g}; make it faster"
        )
    return ElementPlan(
        name=case.name,
        n_elements=case.run.elements,
        memory=case.memory,
        disk=_DISK_BASE + _DISK_PER_ELEMENT * case.run.elements,
        wall_time=_BEGINNING + n_steps * case.run.elements / _ELEMENT_STEPS_PER_SECOND,
    )
