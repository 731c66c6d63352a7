"""One continuum run, from case to figures: its history, summary and ``result.h5``.

    /nodes, /elements              (r, z) of the nodes; the four nodes of each element
    /element_volume                of each element
    /energy/{time, kinetic, elastic, plastic, viscous, hourglass, contact, punch, input}
    /punch/{time, displacement, velocity, force}
    /plastic_zone/{time, volume, volume_ever}
    /fields/{time, von_mises, plastic_strain, plastic_energy, ever_yielded, displacement}

``von_mises`` is (n_frames, n_elements) at ``time``, at equal intervals and more densely while the
punch touches the block or elements yield; the other fields are final values. The root has
the attributes ``kind``, ``name``, ``case`` (TOML), ``summary`` and ``versions`` (JSON); every data
set has a ``unit``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from granwave.analysis.measures.zone_size import BOTTOM, SIDES, wave_returns, zone_sizes
from granwave.extensions.continuum.material import PLASTIC, STRAIN, Elastoplastic
from granwave.extensions.continuum.punch.case import ContinuumCase
from granwave.extensions.continuum.punch.mesh import mesh_of, punch_gap
from granwave.extensions.continuum.punch.resolution import (
    VISCOUS,
    doubts,
    resolution,
    zone_elements,
)
from granwave.extensions.continuum.punch.snapshots import Snapshot, StressSnapshots
from granwave.extensions.continuum.punch.solver import PunchSolver
from granwave.extensions.continuum.runner import (
    SUMMARY_NAMES,
    ElementRun,
    Tables,
    run_elements,
)

SAMPLED = 2e-7  # s, longest time between two rows of the ledger
# a settled run adds less than QUIET of the input to dissipation in a WINDOW, s
WINDOW = 1e-5
QUIET = 1e-4
TOLERANCE = 0.02  # largest accepted error of the energy balance / input
_RARE = 0.01  # volume fraction of the plastic zone in which the strain exceeds the reported value
_ENERGIES = ("kinetic", "elastic", "plastic", "viscous", "hourglass", "contact", "punch")
_IN_SUMMARY = ("kinetic", "elastic", "plastic", "punch", "hourglass", "viscous", "contact")


class BlockRun(ElementRun):
    """Run of a punch on a block; rows of its history as of `PunchSolver.advance`.

    Attributes
    ----------
    snapshots
        Von Mises stresses at instants of the run.
    balance_error
        Largest error of the energy balance so far / input.
    """

    KIND = "continuum"
    FINISHED = ("end_time", "settled", "longest")  # the last two are used with end_time = "auto"
    UNIT = "µs"
    PACKAGES = ("numpy", "numba", "scikit-fem", "h5py", "matplotlib")

    def __init__(self, case: ContinuumCase) -> None:
        super().__init__(case)
        mesh = mesh_of(case)
        punch = case.punch
        run = case.run
        self.solver = PunchSolver(
            mesh,
            Elastoplastic.of(case.material),
            gap=punch_gap(mesh, punch.diameter / 2, punch.taper),
            punch_mass=punch.mass,
            punch_velocity=punch.velocity,
            timestep=None if isinstance(run.timestep, str) else run.timestep,
        )
        self.snapshots = StressSnapshots(run.frame_interval)
        self.balance_error = 0.0
        self.total = None if isinstance(run.end_time, str) else round(1e6 * run.end_time, 2)

    def integrate(self, report: Callable[[], None] = lambda: None) -> None:
        solver = self.solver
        run = self.case.run
        steps = solver.every(SAMPLED)
        automatic = isinstance(run.end_time, str)
        back = math.ceil(WINDOW / (steps * solver.timestep))
        while True:
            left = math.ceil((run.longest - solver.time) / solver.timestep - 1e-9)
            self._add_with_snapshot(min(steps, max(left, 0)))
            report()
            if not self.balance_error <= TOLERANCE:
                self.end_reason = "refused"
            elif left <= 0:
                self.end_reason = "longest" if automatic else "end_time"
            elif automatic and self._settled(back):
                self.end_reason = "settled"
            else:
                continue
            if left > 0:  # the solver has advanced since the last instant
                self.add(0)
            self.snapshots.end(self._snapshot())
            return

    def _add_with_snapshot(self, n_steps: int) -> None:
        """Do as `add`, and keep a snapshot if it is due, or within the event."""
        is_event = self._is_event
        is_due = self.snapshots.is_due(self.solver.time)
        snapshot = self._snapshot() if is_event or is_due else None
        self.add(n_steps)
        if snapshot is None:
            return
        if is_due:
            self.snapshots.add(snapshot)
        if is_event:
            self.snapshots.add_to_event(snapshot, self.rows[-1]["plastic_volume"])

    @property
    def _is_event(self) -> bool:
        """True while the punch touches the block or elements are at yield."""
        if not self.rows:
            return True
        last = self.rows[-1]
        return self.solver.touches > last["touches"] or last["plastic_volume"] > 0

    def add(self, n_steps: int) -> None:
        """Add the present instant to the history, and advance by some steps."""
        touches = self.solver.touches
        row = self.solver.advance(n_steps) if n_steps else self.solver.look()
        self.rows.append({**row, "touches": touches})
        error = abs(row["total"] / self.case.punch.energy - 1)
        self.balance_error = error if math.isnan(error) else max(self.balance_error, error)

    def _settled(self, back: int) -> bool:
        if len(self.rows) <= back:
            return False
        then = self.rows[-1 - back]
        now = self.rows[-1]
        left = 0 < now["touches"] == then["touches"]
        return left and now["plastic"] - then["plastic"] < QUIET * self.case.punch.energy

    def _snapshot(self) -> Snapshot:
        """Return the present stresses."""
        return Snapshot(self.solver.time, self.solver.von_mises.astype(np.float32))

    def progress(self) -> tuple[float, str]:
        """Time done, us."""
        last = self.rows[-1]
        energy_input = self.case.punch.energy
        return 1e6 * last[
            "time"
        ], f"dissipated {last['plastic'] / energy_input:.3f}, balance {self.balance_error:.1e}"

    def values(self) -> dict[str, Any]:
        solver = self.solver
        last = self.rows[-1]
        energy_input = self.case.punch.energy
        volumes = self.column("plastic_volume")
        peak = int(volumes.argmax())
        rows, columns = np.nonzero(solver.ever)
        return {
            "n_elements": solver.n_elements,
            "timestep_s": solver.timestep,
            "n_steps": solver.n_steps,
            "end_time_s": last["time"],
            "end_reason": self.end_reason,
            "energy_input_J": energy_input,
            **{f"energy_{SUMMARY_NAMES.get(name, name)}_J": last[name] for name in _IN_SUMMARY},
            "dissipated_fraction": last["plastic"] / energy_input,
            **self._resolution(),
            VISCOUS: last["viscous"] / energy_input,
            "energy_balance_error": self.balance_error,
            "energy_balance_accepted": TOLERANCE,
            "energy_input_normalised": energy_input / self.case.energy_unit,
            "plastic_zone_volume_m3": volumes[peak],
            "plastic_zone_time_s": self.rows[peak]["time"],
            "plastic_zone_volume_ever_m3": last["plastic_volume_ever"],
            "plastic_zone_depth_m": float(solver.mesh.z[rows.max() + 1]) if len(rows) else 0.0,
            "plastic_zone_radius_m": float(solver.mesh.r[columns.max() + 1]) if len(rows) else 0.0,
            "plastic_zone_strain": self._zone_strain(),
            **self.zone_summary(),
            "largest_strain": float(self.column("largest_strain").max()),
            "peak_force_N": float(self.column("contact_force").max()),
            "punch_peak_displacement_m": float(self.column("punch_displacement").max()),
            "impactor_velocity_m_s": last["punch_velocity"],
        }

    def _resolution(self) -> dict[str, Any]:
        """Return the resolution of the plastic zone, and the uncertainty of its energy."""
        solver = self.solver
        volume = solver.operators.volume
        work = solver.state[:, :, PLASTIC] * volume
        fraction = self.rows[-1]["plastic"] / self.case.punch.energy
        count = zone_elements(work.ravel(), volume.ravel())
        return resolution(fraction, count, self.balance_error)

    def zone_summary(self) -> dict[str, Any]:
        """Return the size of the plastic zone, the boundaries that it reaches, and whether waves
        returned to it from them.

        The fastest wave travels at the longitudinal wave speed from the punch straight to the
        boundary and back to the zone that contains 99 % of the plastic work.
        """
        solver = self.solver
        edge = self.case.punch.diameter / 2
        block = self.case.block
        volume = solver.operators.volume
        radius, depth = np.meshgrid(*solver.mesh.centres)
        work = solver.state[:, :, PLASTIC] * volume
        sizes = zone_sizes(work.ravel(), volume.ravel(), depth.ravel(), radius.ravel())
        ways = {
            BOTTOM: 2 * block.height - (sizes["zone_depth_99_m"] or 0.0),
            SIDES: block.diameter - edge - max(sizes["zone_radius_99_m"] or 0.0, edge),
        }
        times = {
            name: distance / solver.material.longitudinal_speed for name, distance in ways.items()
        }
        touched = {BOTTOM: solver.ever[-1].any(), SIDES: solver.ever[:, -1].any()}
        cut = {"zone_cut": [name for name, touches in touched.items() if touches]}
        return sizes | cut | wave_returns(times, self.column("time"), self.column("plastic"))

    def _zone_strain(self) -> float:
        """Return the equivalent strain, elastic plus plastic, that is exceeded in 1 % of the volume
        that yielded; 0 if no element yielded. The largest strain occurs in one element at the
        punch's edge and depends on the element size.
        """
        solver = self.solver
        elastic = solver.von_mises / solver.material.youngs_modulus
        strain = (elastic + solver.state[:, :, STRAIN])[solver.ever]
        volume = solver.operators.volume[solver.ever]
        if not len(strain):
            return 0.0
        order = np.argsort(strain)[::-1]
        reached = np.cumsum(volume[order]) >= _RARE * volume.sum()
        return float(strain[order][reached.argmax()])

    def tables(self) -> Tables:
        solver = self.solver
        column = self.column
        state = self.solver.state
        time = column("time")
        snapshots = self.snapshots.in_order
        frames = [snapshot.stress.ravel() for snapshot in snapshots]
        return {
            "nodes": (solver.mesh.nodes, "m"),
            "elements": (solver.mesh.elements.astype(np.int32), "1"),
            "element_volume": (solver.operators.volume.ravel(), "m3"),
            "energy/time": (time, "s"),
            **{f"energy/{name}": (column(name), "J") for name in _ENERGIES},
            "energy/input": (np.full(len(time), self.case.punch.energy), "J"),
            "punch/time": (time, "s"),
            "punch/displacement": (column("punch_displacement"), "m"),
            "punch/velocity": (column("punch_velocity"), "m s-1"),
            "punch/force": (column("contact_force"), "N"),
            "plastic_zone/time": (time, "s"),
            "plastic_zone/volume": (column("plastic_volume"), "m3"),
            "plastic_zone/volume_ever": (column("plastic_volume_ever"), "m3"),
            "fields/time": ([snapshot.time for snapshot in snapshots], "s"),
            "fields/von_mises": (np.stack(frames), "Pa"),
            "fields/plastic_strain": (state[:, :, STRAIN].ravel(), "1"),
            "fields/plastic_energy": (state[:, :, PLASTIC].ravel(), "J m-3"),
            "fields/ever_yielded": (solver.ever.ravel().astype(np.uint8), "1"),
            "fields/displacement": (
                np.column_stack([part.ravel() for part in solver.motion[:2]]),
                "m",
            ),
        }

    def warnings(self, summary: Mapping[str, Any]) -> list[str]:
        return doubts(summary)

    def refusal(self) -> tuple[str, str]:
        return (
            f"{100 * self.balance_error:.3g} % of the input at {1e6 * self.rows[-1]['time']:.4g} "
            f"µs, at most {100 * TOLERANCE:g} %",
            'Use run.timestep = "auto" or a smaller value, or more run.elements',
        )


#: Run a continuum case, as `run_elements` does.
run_continuum = partial(run_elements, BlockRun)
