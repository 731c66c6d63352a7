"""What a run would be, before it is run: its size, its cost and how hard its contacts are pressed."""

from __future__ import annotations

import dataclasses
import os
from pathlib import Path
from typing import TYPE_CHECKING

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.laws import sphere_contact
from granwave.lammps_inputs.schedule import Schedule, make_schedule
from granwave.lammps_inputs.timestep import expected_energy, expected_peak_overlap

if TYPE_CHECKING:
    from granwave._contact_laws import ContactLaw
    from granwave.lammps_inputs.case import Case

# Measured on fcc packings of 1.5e5 spheres (whole runs) and 1e7 spheres (set-up and first steps), rounded up.
_MEMORY_BASE = 300e6  # bytes; the interpreter with LAMMPS, or with matplotlib, loaded
_MEMORY_PER_SPHERE = 450.0
_MEMORY_PER_CONTACT = 100.0
_DISK_DATA_PER_SPHERE = 75.0
_DISK_FRAME_PER_SPHERE = 130.0  # the text dump and its copy in result.h5
_DISK_PER_CONTACT = 110.0
_DISK_PER_ROW = 400.0
_ROWS_PER_PARTICLE = 0.25  # what a particle costs at an instant of a chain's history
_SECONDS_PER_SPHERE_STEP = 50e-9  # on one core, output included, as long as contacts are elastic
_SECONDS_PER_STEP = 4e-6  # of LAMMPS itself, whatever the number of spheres
# With a share y of the contacts yielded a step takes 1 + 2.5 y times as long; y = 1/(1 + (e/20)^-0.55) for an input of
# e F_y alpha_y a contact. Both measured over 24 impacts on fcc, e from 2e-3 to 350; within a quarter.
_YIELDED_COST = 2.5
_ENERGY_OF_HALF, _ENERGY_POWER = 20.0, 0.55


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


def plan(case: Case, *, n_ranks: int = 1) -> Plan:
    """What the run of a case would be."""
    schedule, law, assembly = make_schedule(case), sphere_contact(case), case.assembly
    overlap = expected_peak_overlap(case)
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
        wall_time=seconds_per_step(case) * schedule.n_steps * _yielding(case, law) / n_ranks,
    )


def seconds_per_step(case: Case) -> float:
    """Time of a step on one core as long as contacts are elastic, s; a node of a bar takes twice that of a sphere."""
    assembly = case.assembly
    bodies = 2 * assembly.n_particles - assembly.n_spheres
    return _SECONDS_PER_STEP + bodies * _SECONDS_PER_SPHERE_STEP


def _yielding(case: Case, law: ContactLaw) -> float:
    """How much longer a step takes on the average of the run because contacts yield."""
    if not case.contact.yields:
        return 1.0
    energy = expected_energy(case)
    each = energy / (law.yield_force * law.yield_overlap) / max(case.assembly.n_neighbours, 1)
    return 1 + _YIELDED_COST / (1 + (each / _ENERGY_OF_HALF) ** -_ENERGY_POWER) if each > 0 else 1.0


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
