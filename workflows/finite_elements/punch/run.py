"""One continuum run, from case to figures: its history, summary and ``result.h5``.

    /nodes, /elements              (r, z) of the nodes; the four nodes of each element
    /element_volume                of each element
    /energy/{time, kinetic, elastic, plastic, viscous, hourglass, contact, punch, input}
    /punch/{time, displacement, velocity, force}
    /plastic_zone/{time, volume, volume_ever}
    /fields/{time, von_mises, plastic_strain, plastic_energy, ever_yielded, displacement}

``von_mises`` is (n_frames, n_elements) at ``time``; the other fields are final values. The root has the attributes
``kind``, ``name``, ``case`` (TOML), ``summary`` and ``versions`` (JSON); every data set has a ``unit``.
"""

from __future__ import annotations

import dataclasses
import logging
import math
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.zone_size import BOTTOM, SIDES, wave_returns, zone_sizes
from granwave.analysis.versions import versions_of
from granwave.lammps_inputs.errors import RunError
from granwave.workflows.finite_elements.material import PLASTIC, STRAIN, Elastoplastic
from granwave.workflows.finite_elements.punch.case import ContinuumCase
from granwave.workflows.finite_elements.punch.mesh import mesh_of, punch_gap
from granwave.workflows.finite_elements.punch.solver import Instant, Solver
from granwave.workflows.finite_elements.runner import ElementRun, Tables, run_elements, write_result

logger = logging.getLogger("granwave")
SAMPLED = 2e-7  # s, longest time between two rows of the ledger
WINDOW, QUIET = 1e-5, 1e-4  # a settled run adds less than QUIET of the input to dissipation in a WINDOW, s
MOST_FRAMES = 64  # snapshots; if there are more, every second one is dropped
TOLERANCE = 0.02  # largest accepted error of the energy balance over the input
_PACKAGES = ("numpy", "numba", "scikit-fem", "h5py", "matplotlib")
_RARE = 0.01  # volume fraction of the plastic zone in which the strain exceeds the reported one
LARGE_STRAIN = 0.1
_ENERGIES = ("kinetic", "elastic", "plastic", "viscous", "hourglass", "contact", "punch")


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


def summarise(case: ContinuumCase, solver: Solver, history: History, wall_time: float) -> dict[str, Any]:
    """Return the values of summary.json.

    Parameters
    ----------
    wall_time
        Wall time of the time integration, s.
    """
    last, given = history.instants[-1], case.punch.energy
    volumes = history.column("plastic_volume")
    peak = int(volumes.argmax())
    rows, columns = np.nonzero(solver.ever)
    return {
        "name": case.name,
        "kind": "continuum",
        "n_elements": solver.mesh.n_elements,
        "timestep_s": solver.timestep,
        "n_steps": solver.n_steps,
        "end_time_s": last.time,
        "end_reason": history.end_reason,
        "energy_input_J": given,
        "energy_kinetic_J": last.kinetic,
        "energy_elastic_J": last.elastic,
        "energy_dissipated_J": last.plastic,
        "energy_punch_J": last.punch,
        "energy_hourglass_J": last.hourglass,
        "energy_viscous_J": last.viscous,
        "energy_contact_J": last.contact,
        "dissipated_fraction": last.plastic / given,
        "energy_balance_error": history.balance_error,
        "energy_input_normalised": given / case.energy_unit,
        "plastic_zone_volume_m3": volumes[peak],
        "plastic_zone_time_s": history.instants[peak].time,
        "plastic_zone_volume_ever_m3": last.plastic_volume_ever,
        "plastic_zone_depth_m": float(solver.mesh.z[rows.max() + 1]) if len(rows) else 0.0,
        "plastic_zone_radius_m": float(solver.mesh.r[columns.max() + 1]) if len(rows) else 0.0,
        "plastic_zone_strain": zone_strain(solver),
        **zone_summary(case, solver, history),
        "largest_strain": float(history.column("largest_strain").max()),
        "peak_force_N": float(history.column("contact_force").max()),
        "punch_peak_displacement_m": float(history.column("punch_displacement").max()),
        "impactor_velocity_m_s": last.punch_velocity,
        "wall_time_s": wall_time,
        "element_steps_per_s": solver.mesh.n_elements * solver.n_steps / wall_time,
        "n_ranks": 1,
        "versions": versions_of(_PACKAGES),
    }


def zone_summary(case: ContinuumCase, solver: Solver, history: History) -> dict[str, Any]:
    """Return the size of the plastic zone, the boundaries that it reaches, and the return of waves from them.

    The fastest wave travels at the longitudinal wave speed from the punch straight to the boundary and back to the zone
    that holds 99 % of the plastic work.
    """
    volume = solver.operators.volume
    r, z = solver.mesh.centres
    depth, radius = np.broadcast_to(z[:, None], volume.shape), np.broadcast_to(r, volume.shape)
    work = solver.state[:, :, PLASTIC] * volume
    sizes = zone_sizes(work.ravel(), volume.ravel(), depth.ravel(), radius.ravel())
    edge, block = case.punch.diameter / 2, case.block
    ways = {
        BOTTOM: 2 * block.height - (sizes["zone_depth_99_m"] or 0.0),
        SIDES: block.diameter - edge - max(sizes["zone_radius_99_m"] or 0.0, edge),
    }
    times = {name: way / solver.material.longitudinal_speed for name, way in ways.items()}
    touched = {BOTTOM: solver.ever[-1].any(), SIDES: solver.ever[:, -1].any()}
    cut = {"zone_cut": [name for name, touches in touched.items() if touches]}
    return sizes | cut | wave_returns(times, history.column("time"), history.column("plastic"))


def zone_strain(solver: Solver) -> float:
    """Return the equivalent strain exceeded in 1 % of the volume that ever yielded; 0 if none did.

    It is the sum of the elastic and the plastic one. The largest strain occurs in one element at the punch's edge
    and depends on the element size.
    """
    both = solver.von_mises / solver.material.youngs_modulus + solver.state[:, :, STRAIN]
    strain, volume = both[solver.ever], solver.operators.volume[solver.ever]
    if not len(strain):
        return 0.0
    order = np.argsort(strain)[::-1]
    reached = np.cumsum(volume[order]) >= _RARE * volume.sum()
    return float(strain[order][reached.argmax()])


def _tables(case: ContinuumCase, solver: Solver, history: History) -> Tables:
    """Return the data sets of ``result.h5``."""
    n_frames, column, state = len(history.frame_times), history.column, solver.state
    time = column("time")
    return {
        "nodes": (solver.mesh.nodes, "m"),
        "elements": (solver.mesh.elements.astype(np.int32), "1"),
        "element_volume": (solver.operators.volume.ravel(), "m3"),
        "energy/time": (time, "s"),
        **{f"energy/{name}": (column(name), "J") for name in _ENERGIES},
        "energy/input": (np.full(len(time), case.punch.energy), "J"),
        "punch/time": (time, "s"),
        "punch/displacement": (column("punch_displacement"), "m"),
        "punch/velocity": (column("punch_velocity"), "m s-1"),
        "punch/force": (column("contact_force"), "N"),
        "plastic_zone/time": (time, "s"),
        "plastic_zone/volume": (column("plastic_volume"), "m3"),
        "plastic_zone/volume_ever": (column("plastic_volume_ever"), "m3"),
        "fields/time": (history.frame_times, "s"),
        "fields/von_mises": (np.stack(history.von_mises).reshape(n_frames, -1), "Pa"),
        "fields/plastic_strain": (state[:, :, STRAIN].ravel(), "1"),
        "fields/plastic_energy": (state[:, :, PLASTIC].ravel(), "J m-3"),
        "fields/ever_yielded": (solver.ever.ravel().astype(np.uint8), "1"),
        "fields/displacement": (np.column_stack([part.ravel() for part in solver.motion[:2]]), "m"),
    }


class _Run(ElementRun):
    FINISHED = ("end_time", "settled", "longest")
    UNIT = "us"

    def __init__(self, case: ContinuumCase) -> None:
        self.case, self.solver, self.history = case, make_solver(case), History()
        self.total = None if isinstance(case.run.end_time, str) else round(1e6 * case.run.end_time, 2)

    @staticmethod
    def figures() -> ModuleType:
        from granwave.workflows.finite_elements.punch import figures

        return figures

    def integrate(self, report: Callable[[], None]) -> None:
        integrate(self.case, self.solver, self.history, lambda _: report())

    def progress(self) -> tuple[float, str]:
        """Time done, us."""
        last, given = self.history.instants[-1], self.case.punch.energy
        return 1e6 * last.time, f"dissipated {last.plastic / given:.3f}, balance {self.history.balance_error:.1e}"

    def summarise(self, wall_time: float) -> dict[str, Any] | None:
        return summarise(self.case, self.solver, self.history, wall_time) if self.history.instants else None

    def write(self, directory: Path, summary: dict[str, Any]) -> None:
        tables = _tables(self.case, self.solver, self.history)
        write_result(directory, "continuum", self.case, summary, tables)

    def conclude(self, directory: Path, summary: Mapping[str, Any], draw: Callable[[], None]) -> None:
        if summary["plastic_zone_strain"] > LARGE_STRAIN:
            logger.warning(
                "%s: strains are not small: 1 %% of the plastic zone exceeds %.2f, the largest is %.2f; expected below "
                "%g. The solution is one of small strains: lower punch.velocity or punch.mass to trust it",
                self.case.name,
                summary["plastic_zone_strain"],
                summary["largest_strain"],
                LARGE_STRAIN,
            )
        draw()
        if self.history.end_reason == "refused":
            raise RunError(
                f"{self.case.name}: the energy balance is off by {100 * self.history.balance_error:.3g} % of the input "
                f"at {1e6 * self.history.instants[-1].time:.4g} us, at most {100 * TOLERANCE:g} % is accepted; "
                f'what was computed is kept in {directory}. Take run.timestep = "auto" or a smaller one, or more '
                "run.elements"
            )


#: Run a continuum case, as `run_elements` does.
run_continuum = partial(run_elements, _Run)
