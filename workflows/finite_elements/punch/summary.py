"""Summary of a continuum run for ``summary.json``, in SI units."""

from __future__ import annotations

from typing import Any

import numpy as np

from granwave.analysis.measures.zone.size import BOTTOM, SIDES, wave_returns, zone_sizes
from granwave.analysis.versions import versions_of
from granwave.workflows.finite_elements.punch import kernels
from granwave.workflows.finite_elements.punch.case import ContinuumCase
from granwave.workflows.finite_elements.punch.history import History, equivalent_strain
from granwave.workflows.finite_elements.punch.solver import Solver

_PACKAGES = ("numpy", "numba", "scikit-fem", "h5py", "matplotlib")
_RARE = 0.01  # volume fraction of the plastic zone in which the strain exceeds the reported one
LARGE_STRAIN = 0.1


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
    depth, radius = _extent(solver)
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
        "plastic_zone_depth_m": depth,
        "plastic_zone_radius_m": radius,
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
    work = solver.state[:, :, kernels.PLASTIC] * volume
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

    The largest strain occurs in one element at the punch's edge and depends on the element size.
    """
    strain, volume = equivalent_strain(solver)[solver.ever], solver.operators.volume[solver.ever]
    if not len(strain):
        return 0.0
    order = np.argsort(strain)[::-1]
    reached = np.cumsum(volume[order]) >= _RARE * volume.sum()
    return float(strain[order][reached.argmax()])


def _extent(solver: Solver) -> tuple[float, float]:
    """Return the largest depth and radius of elements that ever yielded, m."""
    if not solver.ever.any():
        return 0.0, 0.0
    rows, columns = np.nonzero(solver.ever)
    return float(solver.mesh.z[rows.max() + 1]), float(solver.mesh.r[columns.max() + 1])
