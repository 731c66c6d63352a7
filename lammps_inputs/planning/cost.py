"""Estimates before a run: memory, disk space, wall time, and the plastic zone against the size of
the packing.

The constants of memory and disk space were measured on fcc packings of 2e5 to 2e6 spheres on two
ranks, with and without friction and static stage, and are rounded up. The analysis of a larger
packing processes parts of it, and holds a part and the layers next to it in memory. The writer of
the deck processes the same parts; only the sites of dissimilar spheres and of strikers are all
stored at once.

Wall times are correct within a factor of two. Their constants are processor times on one core of a
2-core virtual machine (AMD EPYC, Zen 4) with the other core busy, as in a scan; a run alone on the
machine is up to 1.6 times as fast. Each is the difference between runs that differ in one property:
fcc packings of 600 to 7000 brass spheres impacted at 1 to 20 m/s, with and without yielding,
friction and precompression, and chains of 1 to 510 beads and 20 beads on bars.

For equal spheres the size of the plastic zone in diameters depends only on e = energy input / (F_y
alpha_y), for any material and size. Power laws were fitted to impacts on brass spheres in packings
that were larger than the zone; all data lie within the factor `spread`:

    kind       depth / D     radius / D    spread   fitted to
    fcc, hcp   1.30 e^0.255  1.0 e^0.265   1.5      13 impacts, e from 13 to 1.35e5, one of them
                                                    on 7 spheres
    bcc        1.30 e^0.32   2.2 e^0.26    1.4      4 impacts, e from 13 to 1.4e3
    sc, chain  75            0             -        6 impacts, e from 3.4 to 5.4e5

Along a line of contacts a pulse with a force just above F_y is not attenuated: 75 spheres or more
yield, 240 to 350 of 600 within 8 ms. Below e = 3 hardly any contacts except the impacted contacts
yield. Friction, disorder and precompression are not considered. There is no estimate for a packing
of one layer.
"""

from __future__ import annotations

import dataclasses
import math

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.lattices import Lattice
from granwave.lammps_inputs.packing.assembly import Assembly, kept_by_assembly
from granwave.lammps_inputs.packing.disorder import has_gaps
from granwave.lammps_inputs.packing.motion import struck_site, written_in_parts
from granwave.lammps_inputs.planning.arrival import expected_arrival
from granwave.lammps_inputs.planning.encounters import expected_energy
from granwave.lammps_inputs.planning.ranks import wave_of
from granwave.lammps_inputs.planning.schedule import Schedule

ANALYSED_AT_ONCE = 2**18  # largest number of spheres of a packing that is analysed as a whole
# spheres of a part of a larger packing, which are held at once, in addition to a few layers of them
_PART = 2**17
# ranks up to which all help in the analysis, even if there are fewer parts
_ALWAYS_HELPING = 8
MOST_DRAWN = 1_000_000  # largest number of spheres of a packing that is drawn by default

# bytes
_PROGRAM = 130e6  # the interpreter with LAMMPS, or with the libraries of the analysis, loaded
# a sphere in LAMMPS and in the sorted snapshot
_SPHERE = 750.0
_PAIR = 155.0  # 135 measured, and 16 of the front of the wave since
_ROUGH_PAIR = 60.0
_SLIPPING_PAIR = 1500.0  # additional memory with partial slip, all in contact
_STATIC_STAGE = 2.0  # times the memory of a run without one
# a sphere in the analysis of a part, with all contacts indented
_ANALYSED_SPHERE = 550.0
_ANALYSED_PAIR = 310.0
_FASTEST = 2.0  # speed of the wave near the load, over its mean speed to the bottom
_LAYERS = 4  # next to a part, with spheres that may touch it
_LEAST_OF_RANK = 0.8e9  # memory that the analysis may take for each rank of the run
_SITE = 170.0  # a site of a lattice with dissimilar or missing spheres, while the script is written
_PLACED_SITE = 120.0  # a site of a lattice against which strikers are placed
_DRAWN = 2 * 600.0  # a sphere, in two processes that draw
_DATA = 75.0  # a sphere in the data file
_VALUE = 8.0  # a number in a binary snapshot
# numbers of a sphere in a snapshot; in addition with friction, losses, and contact forces
_NUMBERS = 17
_NUMBERS_OF_FRICTION = 2
_NUMBERS_OF_LOSS = 1
_NUMBERS_OF_FORCES = 9
_TEXT_FRAME = 200.0  # a sphere in a snapshot as text
_STORED = 30.0  # a sphere in result.h5; where it has moved, a snapshot of it in addition
_STORED_FRAME = 90.0
_DENT = 110.0  # a pair that has touched, among the contacts at the end
_FRAME_FORCE = 160.0  # a pair that has touched, among the contact forces of a snapshot
# a pair among the forces after the static stage: in scratch files and result.h5
_INITIAL_FORCE = 70.0
# bytes in scratch files of an analysis in parts
_SCRATCH_SPHERE = 56.0
_SCRATCH_PAIR = 150.0
# a sphere in a checkpoint: 264 measured without walls, 328 with a wall that it does not touch
_CHECKPOINT_SPHERE = 330.0
# a pair that has touched, the records of both spheres: 160, 240 with friction
_CHECKPOINT_PAIR = 170.0
_CHECKPOINT_ROUGH_PAIR = 80.0
_CHECKPOINT_SLIPPING_PAIR = 630.0  # additional bytes with partial slip
# Memory of the records that remain after a checkpoint, relative to their size in it: 1.2 measured
_RECORDS = 1.2
# time of the steps, s, from which a run is expected to write a checkpoint: half of the usual 60 s
_CHECKPOINT_AFTER = 30.0
_ROW = 400.0  # a row of the ledger
# disk space of a particle at an instant of a chain's history, in rows of the ledger
_ROWS_PER_PARTICLE = 0.25


@dataclasses.dataclass(frozen=True)
class RunSpace:
    """Memory and disk space of a run; see `granwave.lammps_inputs.planning.plan.Plan`."""

    first_rank: float
    other_rank: float
    idle_rank: float
    n_analysing: int
    disk: float
    disk_reserve: float


def expected_deck(assembly: Assembly) -> float:
    """Estimate the size of the LAMMPS deck of a case, bytes."""
    return assembly.n_particles * _DATA


def spheres_of_part(n_spheres: int) -> int:
    """Return the largest number of spheres in a part of a packing in the analysis."""
    return ANALYSED_AT_ONCE if n_spheres <= ANALYSED_AT_ONCE else _PART


def analysing_ranks(assembly: Assembly, n_ranks: int) -> int:
    """Return the number of ranks that take part in the analysis.

    Each rank holds a part of the packing; the size of a part does not depend on the number of
    ranks. Together they may need as much memory as the steps, or `_LEAST_OF_RANK` for each rank.
    The number of ranks is at most the number of parts; the first rank collects the results.
    """
    space = max(_of_steps(assembly), n_ranks * _LEAST_OF_RANK)
    n = assembly.n_particles
    n_parts = math.ceil(n / spheres_of_part(n))
    most = min(n_ranks, max(_ALWAYS_HELPING, n_parts + 1))
    return max(1, min(most, int(space / _of_part(assembly))))


def _of_steps(assembly: Assembly) -> float:
    """Estimate the memory of all ranks for the packing during the steps, bytes."""
    case = assembly.case
    pair = _PAIR + case.has_friction * _ROUGH_PAIR + case.has_partial_slip * _SLIPPING_PAIR
    stages = _STATIC_STAGE if case.precompression else 1.0
    return (assembly.n_particles * _SPHERE + assembly.n_neighbours * pair) * stages


def _of_part(assembly: Assembly) -> float:
    """Estimate the memory of a rank for its part of the packing in the analysis, bytes."""
    n = assembly.n_particles
    if n <= ANALYSED_AT_ONCE:  # only snapshots of a small packing
        return n * _ANALYSED_SPHERE
    nx, ny, _ = assembly.lattice.shape
    at_once = min(n, spheres_of_part(n) + _LAYERS * nx * ny)
    return at_once * (_ANALYSED_SPHERE + assembly.n_neighbours / n * _ANALYSED_PAIR)


def expected_space(
    assembly: Assembly, schedule: Schedule, n_ranks: int, time: float = 0.0
) -> RunSpace:
    """Estimate the space that a run needs, bytes; ``time`` is the longest time of its steps, s.

    A rank collects its part of a checkpoint in memory before it is written.
    """
    case = assembly.case
    n = assembly.n_particles
    pairs = assembly.n_neighbours
    touched = pairs * _reached(assembly)
    of_step = _of_steps(assembly) / n_ranks
    if time > _CHECKPOINT_AFTER:
        records = _RECORDS * touched * _kept_pair(assembly)
        of_step += (_of_checkpoint(assembly, touched) + records) / n_ranks
    part = _of_part(assembly)
    analysis = part
    if n <= ANALYSED_AT_ONCE:  # the first rank holds a complete small packing
        analysis = n * _ANALYSED_SPHERE + pairs * _ANALYSED_PAIR
    if n <= MOST_DRAWN:
        analysis = max(analysis, n * _DRAWN)
    sites = (0.0 if assembly.sites.uniform else _SITE) + (
        _PLACED_SITE if assembly.strikers else 0.0
    )
    contacts = touched * (_DENT + (_INITIAL_FORCE if case.precompression else 0.0))
    frame = _dumped(assembly)
    rows = schedule.n_steps / schedule.ledger_every + schedule.n_steps / schedule.probe_every
    if schedule.history_every:
        rows += _ROWS_PER_PARTICLE * n * schedule.n_steps / schedule.history_every
    return RunSpace(
        first_rank=2 * _PROGRAM + max(of_step, analysis) + assembly.lattice.n_spheres * sites,
        other_rank=_PROGRAM + max(of_step, part),
        idle_rank=_PROGRAM + of_step,
        n_analysing=analysing_ranks(assembly, n_ranks),
        disk=n * (_DATA + _STORED)
        + schedule.n_frames * (frame + _STORED_FRAME * n * _reached(assembly))
        + contacts
        + rows * _ROW,
        disk_reserve=_scratch(assembly, touched) + frame + _of_checkpoint(assembly, pairs),
    )


def _kept_pair(assembly: Assembly) -> float:
    """Estimate the size of a pair that has touched in a checkpoint, bytes."""
    case = assembly.case
    rough = case.has_friction * _CHECKPOINT_ROUGH_PAIR
    return _CHECKPOINT_PAIR + rough + case.has_partial_slip * _CHECKPOINT_SLIPPING_PAIR


def _of_checkpoint(assembly: Assembly, touched: float) -> float:
    """Estimate the size of a checkpoint, bytes; ``touched`` is the number of pairs that have
    touched.
    """
    return assembly.n_particles * _CHECKPOINT_SPHERE + touched * _kept_pair(assembly)


def _scratch(assembly: Assembly, touched: float) -> float:
    """Estimate the scratch files of the analysis, bytes; ``touched`` is the number of pairs that
    have touched.

    Rows of a snapshot in parts are sorted in scratch files, before the rows of the contacts.
    """
    n = assembly.n_particles
    if n <= ANALYSED_AT_ONCE:
        return 0.0
    snapshot = (
        n * _VALUE * numbers_in_snapshot(assembly.case) if written_in_parts(assembly) else 0.0
    )
    return n * _SCRATCH_SPHERE + max(snapshot, touched * _SCRATCH_PAIR)


def numbers_in_snapshot(case: Case) -> int:
    """Return the number of values of a sphere in a snapshot."""
    return (
        _NUMBERS
        + case.has_friction * _NUMBERS_OF_FRICTION
        + case.has_loss * _NUMBERS_OF_LOSS
        + case.output.contact_forces * _NUMBERS_OF_FORCES
    )


def _dumped(assembly: Assembly) -> float:
    """Estimate the size of a snapshot that LAMMPS writes, bytes."""
    case = assembly.case
    sphere = (
        _TEXT_FRAME if case.output.dump_format == "text" else _VALUE * numbers_in_snapshot(case)
    )
    forces = _FRAME_FORCE * assembly.n_neighbours * _reached(assembly)
    return assembly.n_particles * sphere + (forces if case.output.contact_forces else 0.0)


@kept_by_assembly
def _reached(assembly: Assembly) -> float:
    """Estimate the fraction of the packing that the wave of the load reaches until the end of the
    run; 1 if the wave is not known, or if all contacts are loaded from the start.
    """
    case = assembly.case
    arrival = expected_arrival(assembly)
    loaded = case.precompression is not None or case.packing.has_history or case.packing.restart
    if arrival is None or loaded:
        return 1.0
    wave = wave_of(assembly)
    travelled = _FASTEST * (wave.high - wave.last)[2] * case.run.longest / arrival
    return float(wave.shares((1, 1, 1), travelled)[:, 1].prod())


# s per step
_STEP = 1.2e-6  # LAMMPS itself: one bead on a wall
_PARTICLE = 20e-9  # each sphere and each node of a bar, with ledger and wall forces
_TOUCHING_PAIR = 2e-9  # each touching pair
_LOADED = 12.5e-9  # added for a loaded contact: fcc under 1 MPa
# added for a loaded contact with friction: 1.6 times a step of an impact, 2 under precompression
_FRICTION = 25e-9
_PARTIAL_SLIP = 80e-9  # added for a loaded contact with partial slip
_YIELDED = 30e-9  # added for a loaded contact that has yielded
# mean share of loaded pairs during an impact on a packing at rest; 1 under precompression
_SHARE_LOADED = 0.3
# The share of contacts that have yielded is 1/(1 + (e/20)^-0.55) for an energy input of e F_y
# alpha_y per contact: 24 impacts on fcc, e from 2e-3 to 350.
_ENERGY_OF_HALF = 20.0
_ENERGY_POWER = 0.55

# static stage
_ITERATION = 3.0  # steps under load: 2 with periodic sides, 3 to 7 under uniform pressure
_ITERATIONS = 1e3  # lattices of equal spheres: 330 to 2300 in chains of 100 and 150 and 20 packings
# with gaps: 1200 to 46 000 in 20 packings of 144 to 1152 spheres, without a clear trend
_ITERATIONS_OF_DISORDER = 1e4
_MOST_ITERATIONS_OF_DISORDER = 1e5

# s in addition to the steps
_START = 0.3  # set-up and analysis, independent of size
# a particle: its part of the tables, which the ranks share; in addition if all its contacts yielded
_TABLES = 3e-6
_YIELDED_TABLES = 14e-6
# a particle: set-up, and what the first rank sums and writes; of each snapshot in addition
_FIRST_RANK = 3.6e-6
_FIRST_RANK_SNAPSHOT = 0.2e-6
# a particle in a snapshot: writing, reading, storing in result.h5, analysis; shared by the ranks
_SNAPSHOT = 1.5e-6
_TEXT_SNAPSHOT = 6e-6
_HISTORY = 3e-6  # a particle at an instant of a chain's history
# all figures of a run as PNG, including the start of program and library
_FIGURES_OF_CHAIN = 1.7
_FIGURES = 3.8
_FORMAT = 0.45  # fraction of that time for each further format

# first timesteps that an automatic one makes up for over a run: 1 to 1.5 in elastic packings and
# chains, else 2 to 7
_GAIN = 3.0
_ELASTIC_GAIN = 1.2

# blocks of ``end_time = "auto"``: 2 in single collisions and layers, 7 to 15 in small packings
_USUAL_BLOCKS = 8


@dataclasses.dataclass(frozen=True)
class WallTime:
    """Wall times of the parts of a run, s.

    Attributes
    ----------
    static
        Static stage; of typical length if the length cannot be predicted.
    most_static
        Static stage of the largest expected length.
    steps
        Time integration; with ``end_time = "auto"`` up to the typical end.
    most_steps
        Time integration of the largest possible number of steps.
    rest
        Set-up and analysis.
    figures
        Figures; 0 if none are drawn.
    """

    static: float
    most_static: float
    steps: float
    most_steps: float
    rest: float
    figures: float

    @property
    def total(self) -> float:
        """Total time, s."""
        return self.static + self.steps + self.rest + self.figures

    @property
    def longest(self) -> float:
        """Total time with the longest static stage and the largest number of steps, s."""
        return self.most_static + self.most_steps + self.rest + self.figures


def expected_wall_time(
    assembly: Assembly, schedule: Schedule, *, n_ranks: int = 1, figures: bool = True
) -> WallTime:
    """Estimate the wall time of the run of a case.

    Parameters
    ----------
    figures
        True if figures are drawn.
    """
    case = assembly.case
    # steps of the longest possible run
    n = assembly.n_particles
    part = 1.0
    if schedule.block_steps:
        blocks = _USUAL_BLOCKS if case.contact.yields or case.has_friction else 1
        part = min(
            1.0,
            (blocks * schedule.block_steps + case.load.lasts / schedule.timestep)
            / schedule.n_steps,
        )
    most_steps = schedule.n_steps / schedule.first_step
    gain = (
        (_GAIN if case.contact.yields or case.has_friction else _ELASTIC_GAIN)
        if schedule.adaptive
        else 1.0
    )
    each = seconds_per_step(assembly) / n_ranks
    yielded = 0.0  # share of the contacts
    if case.contact.yields:  # averaged over the run
        law = sphere_contact(case)
        pairs = max(assembly.n_neighbours, 1)
        energy = expected_energy(assembly) / (law.yield_force * law.yield_overlap) / pairs
        share = 1 / (1 + (energy / _ENERGY_OF_HALF) ** -_ENERGY_POWER) if energy > 0 else 0.0
        loaded = _SHARE_LOADED if case.precompression is None else 1.0
        yielded = loaded * share
        each += _YIELDED * pairs * yielded / n_ranks
    snapshot = _TEXT_SNAPSHOT if case.output.dump_format == "text" else _SNAPSHOT
    snapshots = max(2.0, part * schedule.n_frames)
    records = (_TABLES + _YIELDED_TABLES * yielded + snapshot * snapshots) / n_ranks
    records += _FIRST_RANK + _FIRST_RANK_SNAPSHOT * snapshots
    records += (
        _HISTORY * part * schedule.n_steps / schedule.history_every
        if schedule.history_every
        else 0.0
    )
    an_iteration = _ITERATION * _seconds(assembly, 1.0, has_friction=False) / n_ranks
    usual, most = (
        (_ITERATIONS_OF_DISORDER, _MOST_ITERATIONS_OF_DISORDER)
        if has_gaps(case)
        else 2 * (_ITERATIONS,)
    )
    if case.precompression is None:
        usual = most = 0.0
    as_png = _FIGURES_OF_CHAIN if case.packing.rule.is_chain else _FIGURES
    return WallTime(
        static=usual * an_iteration,
        most_static=most * an_iteration,
        steps=part * most_steps / gain * each,
        most_steps=most_steps * each,
        rest=_START + n * records,
        figures=as_png * (1 + _FORMAT * len(case.figures.formats)) if figures else 0.0,
    )


def seconds_per_step(assembly: Assembly) -> float:
    """Estimate the time of a step on one core while contacts are elastic, s."""
    loaded = _SHARE_LOADED if assembly.case.precompression is None else 1.0
    return _seconds(assembly, loaded, has_friction=assembly.case.has_friction)


def _seconds(assembly: Assembly, loaded: float, *, has_friction: bool) -> float:
    """Estimate the time of a step with a fraction of ``loaded`` contacts, s."""
    friction = has_friction * (_FRICTION + assembly.case.has_partial_slip * _PARTIAL_SLIP)
    a_pair = _TOUCHING_PAIR + loaded * (_LOADED + friction)
    return _STEP + _PARTICLE * assembly.n_particles + a_pair * assembly.n_neighbours


_LEAST = 3.0  # energy input / F_y alpha_y below which the zone is negligible


@dataclasses.dataclass(frozen=True)
class ExpectedZone:
    """Expected size of the plastic zone, and the space for it.

    Attributes
    ----------
    depth, radius
        Depth below the impacted sphere, and radius from the impact axis, m.
    spread
        Factor of uncertainty of both.
    room
        Distances from the impacted sphere to the bottom and the sides, by name, m.
    periodic
        True if the sides are periodic, so that the distance is half a period.
    """

    depth: float
    radius: float
    spread: float
    room: dict[str, float]
    periodic: bool = False

    @property
    def reaches(self) -> tuple[str, ...]:
        """Names of the boundaries that the zone is expected to reach."""
        extent = {"bottom": self.depth, "sides": self.radius}
        return tuple(name for name, room in self.room.items() if extent[name] >= room)

    @property
    def may_reach(self) -> tuple[str, ...]:
        """Names of further boundaries that it reaches if it is larger than estimated by
        ``spread``.
        """
        larger = dataclasses.replace(
            self, depth=self.spread * self.depth, radius=self.spread * self.radius
        )
        return tuple(name for name in larger.reaches if name not in self.reaches)


def expected_zone(assembly: Assembly) -> ExpectedZone | None:
    """Estimate the plastic zone of a case; None if nothing yields, or there is no estimate."""
    case = assembly.case
    lattice = assembly.lattice
    growth = case.packing.rule.zone_growth
    law = sphere_contact(case)
    if (
        growth is None
        or not case.contact.yields
        or not isinstance(lattice, Lattice)
        or lattice.n_layers == 1
    ):
        return None
    energy = expected_energy(assembly) / (law.yield_force * law.yield_overlap)
    if energy < _LEAST:
        return None
    sphere = struck_site(assembly) or 1
    (centre,), (last,) = (lattice.positions(one, one) for one in (sphere, lattice.n_spheres))
    room = {"bottom": float(last[2] - centre[2])}
    nx, ny, _ = lattice.shape
    i, j, _ = lattice.indices(sphere)
    if case.boundary.periodic:
        room["sides"] = min(lattice.lengths) / 2
    elif nx > 1 or ny > 1:  # number of layers to the nearest end of a row
        ends = [(0, sphere + (end - i)) for end in (0, nx - 1) if nx > 1]
        ends += [(1, sphere + (end - j) * nx) for end in (0, ny - 1) if ny > 1]
        room["sides"] = min(
            abs(float(lattice.positions(one, one)[0, axis] - centre[axis])) for axis, one in ends
        )
    diameter = case.packing.diameter
    depth = growth.depth(energy) * diameter
    radius = growth.radius(energy) * diameter
    return ExpectedZone(depth, radius, growth.spread, room, case.boundary.periodic)
