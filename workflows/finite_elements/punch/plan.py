"""Estimated cost of a continuum run before it is run."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from granwave.lammps_inputs.planning.schedule import check_steps
from granwave.workflows.finite_elements.punch.case import AUTO_END_TIME, ContinuumCase
from granwave.workflows.finite_elements.punch.history import mesh_of
from granwave.workflows.finite_elements.punch.material import Elastoplastic

_ELEMENT_STEPS_PER_SECOND = 25e6  # measured on one core
_START = 1.0  # s, set-up and results
_STEP_OVER_CROSSING = 0.95  # stable timestep over the time that a wave takes through the thinnest element
_DISK_PER_ELEMENT = 400.0  # bytes, with some 20 compressed snapshots
_DISK_BASE = 1e6  # bytes, including figures


@dataclasses.dataclass(frozen=True)
class ContinuumPlan:
    """Size and cost of a continuum run.

    Attributes
    ----------
    memory, disk, disk_reserve
        Estimates in bytes; files are written at the end, so that no reserve is needed.
    wall_time
        Estimated wall time, s.
    """

    name: str
    n_elements: int
    memory: float
    disk: float
    wall_time: float
    disk_reserve: float = 0.0


def plan(case: ContinuumCase) -> ContinuumPlan:
    """Plan the run of a case; raise InputError if it has too many steps."""
    mesh = mesh_of(case)
    material = Elastoplastic.of(case.material)
    thinnest = min(np.diff(mesh.r).min(), np.diff(mesh.z).min())
    speed = math.sqrt(material.longitudinal_modulus / material.density)
    step = _STEP_OVER_CROSSING * thinnest / speed if isinstance(case.run.timestep, str) else case.run.timestep
    check_steps(case.name, case.run.longest, step)
    n_steps = _expected_end(case) / step
    return ContinuumPlan(
        name=case.name,
        n_elements=mesh.n_elements,
        memory=case.memory,
        disk=_DISK_BASE + _DISK_PER_ELEMENT * mesh.n_elements,
        wall_time=_START + n_steps * mesh.n_elements / _ELEMENT_STEPS_PER_SECOND,
    )


def _expected_end(case: ContinuumCase) -> float:
    """Estimate the end time, s: rebound of a mass on an elastic half-space under a flat punch, with a margin."""
    if not isinstance(case.run.end_time, str):
        return case.run.end_time
    material = case.material
    stiffness = material.youngs_modulus / (1 - material.poisson_ratio**2) * case.punch.diameter
    return min(AUTO_END_TIME, 1e-5 + 1.3 * math.pi * math.sqrt(case.punch.mass / stiffness))
