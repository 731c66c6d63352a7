"""What a run would be, before it is run: its size, its cost and how hard its contacts are pressed."""

from __future__ import annotations

import dataclasses
import os
from pathlib import Path
from typing import TYPE_CHECKING

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.laws import sphere_contact
from granwave.lammps_inputs.schedule import Schedule, make_schedule
from granwave.lammps_inputs.timestep import expected_peak_overlap

if TYPE_CHECKING:
    from granwave.lammps_inputs.case import Case

# Measured on fcc packings of 1.5e5 spheres (whole runs) and 1e7 spheres (set-up and first steps), rounded up.
_MEMORY_BASE = 300e6  # bytes; the interpreter with LAMMPS, or with matplotlib, loaded
_MEMORY_PER_SPHERE = 450.0
_MEMORY_PER_CONTACT = 100.0
_DISK_DATA_PER_SPHERE = 75.0
_DISK_FRAME_PER_SPHERE = 130.0  # the text dump and its copy in result.h5
_DISK_PER_CONTACT = 110.0
_DISK_PER_ROW = 400.0
_SPHERE_STEPS_PER_SECOND = 16e6  # of one core, output included


@dataclasses.dataclass(frozen=True)
class Plan:
    """The size and cost of a run; memory, disk and time are estimates.

    Attributes
    ----------
    memory, disk
        Bytes, of all ranks together.
    peak_overlap
        A bound on the largest overlap of two spheres, m.
    peak_overlap_yield
        The same over the overlap at first yield; None if the law does not yield.
    peak_overlap_radius
        The same over the effective radius; beyond 0.2 it is outside the fitted law.
    wall_time
        s.
    """

    name: str
    n_spheres: int
    n_contacts: int
    schedule: Schedule
    memory: float
    disk: float
    peak_overlap: float
    peak_overlap_yield: float | None
    peak_overlap_radius: float
    wall_time: float


def plan(case: Case, *, n_ranks: int = 1, sphere_steps_per_second: float = _SPHERE_STEPS_PER_SECOND) -> Plan:
    """What the run of a case would be.

    Parameters
    ----------
    sphere_steps_per_second
        Of one rank.
    """
    schedule, law, lattice = make_schedule(case), sphere_contact(case), case.lattice
    overlap = expected_peak_overlap(case)
    rows = schedule.n_steps / schedule.ledger_every + schedule.n_steps / schedule.probe_every
    return Plan(
        name=case.name,
        n_spheres=lattice.n_spheres,
        n_contacts=lattice.n_contacts,
        schedule=schedule,
        memory=n_ranks * _MEMORY_BASE
        + lattice.n_spheres * _MEMORY_PER_SPHERE
        + lattice.n_contacts * _MEMORY_PER_CONTACT,
        disk=lattice.n_spheres * (_DISK_DATA_PER_SPHERE + schedule.n_frames * _DISK_FRAME_PER_SPHERE)
        + lattice.n_contacts * _DISK_PER_CONTACT
        + rows * _DISK_PER_ROW,
        peak_overlap=overlap,
        peak_overlap_yield=overlap / law.yield_overlap if case.contact.yields else None,
        peak_overlap_radius=overlap / law.effective_radius,
        wall_time=lattice.n_spheres * schedule.n_steps / sphere_steps_per_second / n_ranks,
    )


def check_memory(plan: Plan, available: float | None = None) -> None:
    """Refuse a run that does not fit into memory.

    Parameters
    ----------
    available
        Bytes; by default what this machine has free now.

    Raises
    ------
    InputError
        The run needs more than there is.
    """
    available = available_memory() if available is None else available
    if plan.memory > available:
        raise InputError(
            f"{plan.name}: packing.size: {plan.n_spheres} spheres need about {plan.memory / 2**30:.1f} GiB "
            f"of memory, there is {available / 2**30:.1f} GiB; make the packing smaller or change machine"
        )


def available_memory() -> float:
    """Bytes of memory that this machine could still give to a program."""
    try:
        for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return float(line.split()[1]) * 1024
    except OSError:
        pass  # not Linux: fall back on the memory that the machine has
    return float(os.sysconf("SC_PAGE_SIZE")) * os.sysconf("SC_PHYS_PAGES")
