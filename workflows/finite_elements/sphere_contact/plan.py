"""Estimated cost of a sphere contact before it is run."""

from __future__ import annotations

import math

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.planning.schedule import MOST_STEPS
from granwave.workflows.finite_elements.frame import ElementPlan
from granwave.workflows.finite_elements.sphere_contact.case import SphereContactCase
from granwave.workflows.finite_elements.sphere_contact.study import (
    SMOOTHING,
    START,
    STEPS_PER_E_FOLD,
    STEPS_PER_UNLOADING,
    squares,
    yield_unit,
)

_ELEMENT_STEPS_PER_SECOND = 18e6  # measured on one core
_BEGINNING = 2.0  # s, set-up, results and figures
_TURNS = 5.2  # steps of the changes of rate in a cycle over `SMOOTHING`
_DISK_PER_ELEMENT = 100.0  # bytes
_DISK_BASE = 4e6  # bytes, history and figures


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
