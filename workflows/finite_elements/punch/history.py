"""Time history of a run: ledger, snapshots, and end of the run."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from granwave.workflows.finite_elements.punch import kernels
from granwave.workflows.finite_elements.punch.case import ContinuumCase
from granwave.workflows.finite_elements.punch.contact import contact_end, punch_gap
from granwave.workflows.finite_elements.punch.material import Elastoplastic
from granwave.workflows.finite_elements.punch.mesh import Mesh, block_mesh
from granwave.workflows.finite_elements.punch.solver import Instant, Solver

SAMPLED = 2e-7  # s, longest time between two rows of the ledger
WINDOW, QUIET = 1e-5, 1e-4  # a settled run adds less than QUIET of the input to dissipation in a WINDOW, s
MOST_FRAMES = 64  # snapshots; if there are more, every second one is dropped
TOLERANCE = 0.02  # largest accepted error of the energy balance over the input


@dataclasses.dataclass
class History:
    """Time history of a run, filled by `integrate`.

    Attributes
    ----------
    end_reason
        Why the run ended: ``end_time``; ``settled`` or ``longest`` (end_time = "auto"); ``refused`` (energy balance);
        ``interrupted``.
    instants
        Rows of the ledger.
    touches
        Numbers of steps with contact so far, at the same instants.
    frame_times, von_mises
        Times (s) and von Mises stresses ((n_z, n_r), Pa) of the snapshots.
    balance_error
        Largest error of the energy balance so far, over the input.
    """

    end_reason: str = "interrupted"
    instants: list[Instant] = dataclasses.field(default_factory=list)
    touches: list[int] = dataclasses.field(default_factory=list)
    frame_times: list[float] = dataclasses.field(default_factory=list)
    von_mises: list[NDArray[np.float32]] = dataclasses.field(default_factory=list)
    balance_error: float = 0.0

    def add(self, touches: int, instant: Instant, given: float) -> None:
        """Add one instant; ``given`` is the energy input, J."""
        self.touches.append(touches)
        self.instants.append(instant)
        error = abs(instant.total / given - 1)
        self.balance_error = error if math.isnan(error) else max(self.balance_error, error)

    def column(self, name: str) -> NDArray[np.float64]:
        """Return one quantity of the ledger, (n_instants,)."""
        return np.array([getattr(instant, name) for instant in self.instants])


def mesh_of(case: ContinuumCase) -> Mesh:
    """Make the mesh of a case."""
    punch, run = case.punch, case.run
    edge = None if isinstance(run.edge_size, str) else run.edge_size
    material = Elastoplastic.of(case.material)
    end = contact_end(punch.diameter / 2, punch.taper, material.yield_strength / material.youngs_modulus)
    return block_mesh(case.block.diameter / 2, case.block.height, end, run.elements, edge_size=edge)


def make_solver(case: ContinuumCase) -> Solver:
    """Make the solver of a case, at its start."""
    mesh, punch, run = mesh_of(case), case.punch, case.run
    return Solver(
        mesh,
        Elastoplastic.of(case.material),
        gap=punch_gap(mesh, punch.diameter / 2, punch.taper),
        punch_mass=punch.mass,
        punch_velocity=punch.velocity,
        timestep=None if isinstance(run.timestep, str) else run.timestep,
    )


def integrate(
    case: ContinuumCase, solver: Solver, history: History, report: Callable[[History], None] | None = None
) -> None:
    """Run ``solver`` to the end of the case and fill ``history``; call ``report`` after each instant."""
    given, steps = case.punch.energy, solver.every(SAMPLED)
    back = math.ceil(WINDOW / (steps * solver.timestep))
    longest = case.run.longest
    interval, due = case.run.frame_interval, 0.0
    while True:
        if solver.time >= due:
            if len(history.frame_times) >= MOST_FRAMES:
                del history.frame_times[1::2], history.von_mises[1::2]
                interval *= 2
            _snapshot(solver, history)
            due = (math.floor(solver.time / interval) + 1) * interval
        left = math.ceil((longest - solver.time) / solver.timestep - 1e-9)
        history.add(solver.touches, solver.advance(min(steps, left)) if left > 0 else solver.look(), given)
        if report is not None:
            report(history)
        if not history.balance_error <= TOLERANCE:
            history.end_reason = "refused"
        elif left <= 0:
            history.end_reason = "longest" if isinstance(case.run.end_time, str) else "end_time"
        elif isinstance(case.run.end_time, str) and _settled(history, back, given):
            history.end_reason = "settled"
        else:
            continue
        if left > 0:  # the solver has advanced since the last instant
            history.add(solver.touches, solver.look(), given)
        _snapshot(solver, history)
        return


def _settled(history: History, back: int, given: float) -> bool:
    if len(history.instants) <= back:
        return False
    then, now = history.instants[-1 - back], history.instants[-1]
    left = 0 < history.touches[-1] == history.touches[-1 - back]
    return left and now.plastic - then.plastic < QUIET * given


def _snapshot(solver: Solver, history: History) -> None:
    history.frame_times.append(solver.time)
    history.von_mises.append(solver.von_mises.astype(np.float32))


def equivalent_strain(solver: Solver) -> NDArray[np.float64]:
    """Return the sum of elastic and plastic equivalent strain of the elements, (n_z, n_r)."""
    return solver.von_mises / solver.material.youngs_modulus + solver.state[:, :, kernels.STRAIN]
