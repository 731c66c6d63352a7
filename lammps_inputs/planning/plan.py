"""What a run would be, before it is run: its size, its cost and how hard its contacts are pressed."""

from __future__ import annotations

import dataclasses
import os
from pathlib import Path
from typing import TYPE_CHECKING

from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import Assembly, assemble
from granwave.lammps_inputs.planning.schedule import Schedule, make_schedule
from granwave.lammps_inputs.planning.timestep import expected_peak_overlap
from granwave.lammps_inputs.planning.wall_time import WallTime, expected_wall_time

if TYPE_CHECKING:
    from granwave.lammps_inputs.case.case import Case

# Measured on fcc packings of 1.5e5 spheres (whole runs) and 1e7 spheres (set-up and first steps), rounded up.
_MEMORY_BASE = 300e6  # bytes; the interpreter with LAMMPS, or with matplotlib, loaded
_MEMORY_PER_SPHERE = 450.0
_MEMORY_PER_CONTACT = 100.0
_DISK_DATA_PER_SPHERE = 75.0
_DISK_FRAME_PER_SPHERE = 130.0  # the text dump and its copy in result.h5
_DISK_PER_CONTACT = 110.0
_DISK_PER_ROW = 400.0
_ROWS_PER_PARTICLE = 0.25  # what a particle costs at an instant of a chain's history


@dataclasses.dataclass(frozen=True)
class Plan:
    """The size and cost of a run; memory, disk and times are estimates.

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
    times
        What it takes, part by part.
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
    times: WallTime

    @property
    def wall_time(self) -> float:
        """Of a run of usual length, s."""
        return self.times.total


def plan(case: Case | Assembly, *, n_ranks: int = 1, figures: bool = True) -> Plan:
    """What the run of a case would be.

    Parameters
    ----------
    figures
        They are drawn too.
    """
    assembly = assemble(case)
    case = assembly.case
    schedule, law = make_schedule(assembly), sphere_contact(case)
    overlap = expected_peak_overlap(assembly)
    rows = schedule.n_steps / schedule.ledger_every + schedule.n_steps / schedule.probe_every
    if schedule.history_every:
        rows += _ROWS_PER_PARTICLE * assembly.n_particles * schedule.n_steps / schedule.history_every
    return Plan(
        name=case.name,
        n_spheres=assembly.n_spheres,
        n_contacts=assembly.n_contacts,
        schedule=schedule,
        memory=n_ranks * _MEMORY_BASE
        + assembly.n_particles * _MEMORY_PER_SPHERE
        + assembly.n_neighbours * _MEMORY_PER_CONTACT,
        disk=assembly.n_particles * (_DISK_DATA_PER_SPHERE + schedule.n_frames * _DISK_FRAME_PER_SPHERE)
        + assembly.n_neighbours * _DISK_PER_CONTACT
        + rows * _DISK_PER_ROW,
        peak_overlap=overlap,
        peak_overlap_yield=overlap / law.yield_overlap if case.contact.yields else None,
        peak_overlap_radius=overlap / law.effective_radius,
        times=expected_wall_time(assembly, schedule, n_ranks=n_ranks, figures=figures),
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
    what = f"{plan.name}: packing.size: {plan.n_spheres} spheres"
    refuse_too_large(what, plan.memory, "make the packing smaller", available)


def refuse_too_large(what: str, memory: float, remedy: str, available: float | None = None) -> None:
    """Raise InputError where ``what`` needs more ``memory`` than is ``available``, bytes; by default what is free."""
    available = available_memory() if available is None else available
    if memory > available:
        raise InputError(
            f"{what} need about {memory / 2**30:.1f} GiB of memory, there is {available / 2**30:.1f} GiB; "
            f"{remedy} or change machine"
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
