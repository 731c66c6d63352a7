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

import math

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.planning.schedule import MOST_STEPS
from granwave.workflows.finite_elements.frame import ElementPlan
from granwave.workflows.finite_elements.sphere_contact.case import SphereContactCase
from granwave.workflows.finite_elements.sphere_contact.mesh import squares_for

STEPS_PER_E_FOLD, STEPS_PER_UNLOADING = 600, 300  # times n, at speed 1
SMOOTHING, DAMPING, MEMORY = 40, 0.1, 20  # times n, over n, times n
_CORE = 3.0  # size of the mesh's finest part over the contact radius at first yield
_FIRST_PEAK = 4.0  # overlap of the first unloading over alpha_y
START = 0.3  # overlap over alpha_y below which the loading rate is about constant
_ELASTIC_UNIT = 1 / 400  # unit in place of alpha_y, if that is not reached, over the largest overlap
_ELEMENT_STEPS_PER_SECOND = 18e6  # measured on one core
_BEGINNING = 2.0  # s, set-up, results and figures
_TURNS = 5.2  # steps of the changes of rate in a cycle over `SMOOTHING`
_DISK_PER_ELEMENT = 100.0  # bytes
_DISK_BASE = 4e6  # bytes, history and figures

LOADING, UNLOADING, RELOADING = range(3)


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
