"""Plan of a run before it is run: size, cost and expected overlaps."""

from __future__ import annotations

import contextlib
import dataclasses
import logging
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.run import AUTO_END_TIME
from granwave.lammps_inputs.contact.initial_dents import dents_of_result, earlier_result
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.directories import check_disk
from granwave.lammps_inputs.errors import InputError, raise_all
from granwave.lammps_inputs.files import refuse_too_large
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.planning import cost
from granwave.lammps_inputs.planning import timestep as steps
from granwave.lammps_inputs.planning.blocks import collision_time
from granwave.lammps_inputs.planning.schedule import Schedule, make_schedule
from granwave.lammps_inputs.tables.units import LENGTH_UNITS

_LOG = logging.getLogger("granwave")

# timestep over the longest one that a contact alone would allow: its cause is told
_FAR_SHORTER = 0.1
_LONG = 60.0  # s of wall time above which a warning is printed
# times the automatic timestep: energy error above 1e-4, half of the stability limit
_FAR_TOO_LONG = 20.0


@dataclasses.dataclass(frozen=True)
class Plan:
    """Size and cost of a run; memory, disk space and times are estimates.

    Attributes
    ----------
    n_ranks
        Number of ranks that it is planned for.
    first_rank
        Memory of the first rank, which also writes the LAMMPS input and combines the results,
        bytes.
    other_rank
        Memory of each other rank that makes parts of the results in the analysis, bytes.
    idle_rank
        Memory of each rank that takes no part in the analysis, bytes.
    n_analysing
        Number of ranks that take part in the analysis, the first included.
    disk
        Disk space of the files at the end, bytes.
    disk_reserve
        Space that must stay free during the run, for one more snapshot, a checkpoint and the
        scratch files of the analysis, bytes.
    peak_overlap
        Upper bound on the largest overlap of two spheres, m.
    peak_overlap_yield
        Ratio of this overlap to the overlap at first yield; None if the law does not yield.
    peak_overlap_radius
        Ratio of this overlap to the effective radius; above 0.2 it is outside the range of the law.
    times
        Wall times of the parts of the run.
    zone
        Expected size of the plastic zone; None if nothing yields, or there is no estimate.
    limits
        Bounds on the automatic timestep, the smallest first; empty with a fixed one.
    """

    name: str
    n_spheres: int
    n_contacts: int
    schedule: Schedule
    n_ranks: int
    first_rank: float
    other_rank: float
    idle_rank: float
    n_analysing: int
    disk: float
    disk_reserve: float
    peak_overlap: float
    peak_overlap_yield: float | None
    peak_overlap_radius: float
    times: cost.WallTime
    zone: cost.ExpectedZone | None = None
    limits: tuple[steps.TimestepLimit, ...] = ()

    @property
    def limit(self) -> steps.TimestepLimit | None:
        """Bound that makes the timestep far shorter than required by some contacts; None if there
        is none.
        """
        return (
            self.limits[0]
            if self.limits and self.limits[0].step < _FAR_SHORTER * self.allowed
            else None
        )

    @property
    def slowness(self) -> str:
        """Cause of a timestep that makes the run slow, and the remedy; empty if there is
        none.
        """
        if self.limit is None or self.wall_time < _LONG:
            return ""
        return (
            f"the timestep, {self.schedule.first_timestep:.2g} s, is limited by "
            f"{self.limit.cause}; contacts would allow {self.allowed:.2g} s; use "
            f"{self.limit.remedy} or an earlier run.end_time for a shorter computation"
        )

    @property
    def allowed(self) -> float:
        """Longest first timestep that a single kind of contact of two grains would allow, s; of
        contacts with walls if there are no other contacts.

        The pulse that reaches a wall is weaker in a larger packing, so that contacts with walls
        would allow any timestep.
        """
        of_contacts = [limit for limit in self.limits if limit.of_contact]
        of_grains = [limit.step for limit in of_contacts if not limit.against_wall]
        return max(of_grains or [limit.step for limit in of_contacts], default=math.nan)

    @property
    def memory(self) -> float:
        """Memory of all ranks together, bytes."""
        idle = (self.n_ranks - self.n_analysing) * self.idle_rank
        return self.first_rank + (self.n_analysing - 1) * self.other_rank + idle

    @property
    def wall_time(self) -> float:
        """Wall time of a run of typical length, s."""
        return self.times.total


def plan(assembly: Assembly, *, n_ranks: int = 1, figures: bool = True) -> Plan:
    """Plan a run.

    Parameters
    ----------
    figures
        True if the run draws its figures.

    Raises
    ------
    InputError
        No timestep can be found for these values, or there are too many steps or snapshots.
    """
    case = assembly.case
    _refuse_endless(case)
    steps.check_load_frequency(assembly)
    try:
        schedule = make_schedule(assembly)
        law = sphere_contact(case)
        overlap = steps.expected_peak_overlap(assembly)
    except InputError:
        raise
    except (ArithmeticError, ValueError) as error:
        raise InputError(
            f"{case.name}: run.timestep: no timestep exists for the values of material, contact "
            f"and load ({error}); are they all in SI units (70 GPa is 70e9)?"
        ) from None
    _note_times(assembly, schedule)
    _note_gaps(assembly)
    times = cost.expected_wall_time(assembly, schedule, n_ranks=n_ranks, figures=figures)
    space = cost.expected_space(assembly, schedule, n_ranks, times.most_steps)
    return Plan(
        name=case.name,
        n_spheres=assembly.n_spheres,
        n_contacts=assembly.n_contacts,
        schedule=schedule,
        n_ranks=n_ranks,
        **dataclasses.asdict(space),
        peak_overlap=overlap,
        peak_overlap_yield=overlap / law.yield_overlap if case.contact.yields else None,
        peak_overlap_radius=overlap / law.effective_radius,
        times=times,
        zone=cost.expected_zone(assembly),
        limits=tuple(steps.timestep_limits(assembly, case.run.energy_tolerance))
        if schedule.adaptive
        else (),
    )


def _refuse_endless(case: Case) -> None:
    """Reject packings that are infinite along z, or with a cell under load: they have bands, and no
    runs.
    """
    stage = case.precompression
    if case.boundary.bottom_rule.repeats:
        raise InputError(
            f'{case.name}: boundary.bottom: found "periodic", expected "wall", "fixed" or "free" '
            "for a run; an infinite crystal can only be used with granwave bands"
        )
    if case.packing.grains is None or stage is None:
        return
    if stage.rule.on_all_faces or (stage.rule.on_top and not case.bears_along_z):
        raise InputError(
            f"{case.name}: precompression.kind: found {stage.kind!r} of grains with packing.cell, "
            'which is for granwave bands; expected "walls" for a run, or a support'
        )


_ROUNDED = 0.1  # largest overlap of grains in the unit of a file, diameters
_FAR = 2.0  # largest distance of the closest grains in the unit of a file, diameters
_NEAREST = 6  # neighbours of a grain that are searched for the closest surface


def _note_gaps(assembly: Assembly) -> None:
    """Log a warning if no two grains of a file touch."""
    case = assembly.case
    if case.packing.grains is None or assembly.n_spheres < 2 or assembly.n_contacts:
        return
    from scipy.spatial import KDTree  # imported on demand: slow to load

    position = case.packing.grains.position
    radius = case.packing.grains.diameter / 2
    n_near = min(_NEAREST + 1, len(position))
    distance, near = KDTree(position).query(position, n_near)
    rows = np.repeat(np.arange(len(position))[:, None], n_near - 1, axis=1)
    pairs = np.stack([rows, near[:, 1:]], axis=2).reshape(-1, 2)
    gaps = distance[:, 1:].ravel() - radius[pairs].sum(axis=1)
    gap = float(gaps[case.packing.grains.of_different_clumps(pairs)].min(initial=math.inf))
    if math.isinf(gap):
        return
    smallest = 2 * float(radius.min())
    _LOG.warning(
        "%s: packing: no two grains touch at the start, the closest are %.3g m apart, %.3g of the "
        "smallest diameter; check for rounded coordinates and mixed units%s",
        case.name,
        gap,
        gap / smallest,
        _remedy_of_units(case, float(distance[:, 1].min()), smallest),
    )


def _remedy_of_units(case: Case, distance: float, diameter: float) -> str:
    """Return the remedy for positions of a file in another unit than the diameter of the case, with
    a semicolon before it; empty if there is none.

    Parameters
    ----------
    distance
        Smallest distance of two centres, m.
    diameter
        Smallest diameter, m.
    """
    grains = case.packing.grains
    if grains is None or grains.reading is None or grains.reading.units:
        return ""
    for unit, power in LENGTH_UNITS.items():
        if power and 1 <= distance * 10.0**power / diameter * (1 + _ROUNDED) <= _FAR:
            return f'; if the positions of the file are in {unit}, set packing.units = "{unit}"'
    return ""


def _note_times(assembly: Assembly, schedule: Schedule) -> None:
    """Log warnings about a timestep that is far too long, a probe interval shorter than the
    timestep, and an automatic end within the first collision.
    """
    case = assembly.case
    given = case.run.timestep
    interval = case.output.probe_interval
    if not isinstance(given, str):
        with contextlib.suppress(ArithmeticError, ValueError):  # no automatic timestep exists
            if given > _FAR_TOO_LONG * (best := steps.auto_timestep(assembly)):
                text = (
                    '%s: run.timestep: found %g s, but "auto" uses %g s; the error of the '
                    "energy balance will probably be too large"
                )
                _LOG.warning(text, case.name, given, best)
    if not isinstance(interval, str) and interval < schedule.first_timestep / 2:
        text = (
            "%s: output.probe_interval: found %g s, but at most one record per timestep (%.3g s) "
            "is written"
        )
        _LOG.warning(text, case.name, interval, schedule.first_timestep)
    if schedule.block_steps and (collision := collision_time(assembly)) > AUTO_END_TIME:
        text = (
            '%s: run.end_time: "auto" ends after %g ms at most, and the first collision lasts '
            "about %.2g ms: set run.end_time (s)"
        )
        _LOG.warning(text, case.name, 1e3 * AUTO_END_TIME, 1e3 * collision)


def check_files(assembly: Assembly) -> None:
    """Check the files that a run reads in addition to its case.

    Raises
    ------
    InputError
        The earlier result with its indentations cannot be read, or is of another packing.
    """
    if earlier_result(assembly.case) is not None:
        dents_of_result(assembly)


def afford(expected: Plan, directory: Path | None = None) -> None:
    """Check that this machine has the memory and the disk space of a run.

    Parameters
    ----------
    directory
        Directory of the results; None: the disk space is not checked.

    Raises
    ------
    InputError
        It has not; the message lists all faults.
    """
    checks: list[Callable[[], object]] = [lambda: check_memory(expected)]
    if directory is not None:
        checks.append(lambda: check_disk(directory, expected.disk, spare=expected.disk_reserve))
    raise_all(checks)


def check_memory(plan: Plan, available: float | None = None) -> None:
    """Raise InputError if a run does not fit into memory.

    Parameters
    ----------
    available
        Available memory, bytes; by default that of this machine.

    Raises
    ------
    InputError
        The run needs more memory than available.
    """
    what = f"{plan.name}: packing.size: {plan.n_spheres} spheres"
    refuse_too_large(what, plan.memory, "use a smaller packing", available)
