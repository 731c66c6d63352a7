"""Wall time of a run, estimated within a factor of two.

The constants are processor times on one core of a 2-core virtual machine (AMD EPYC, Zen 4) with the other core busy, as
in a scan; a run alone on the machine is up to 1.6 times as fast. Each constant is the difference between runs that
differ in one property: fcc packings of 600 to 7000 brass spheres struck at 1 to 20 m/s, with and without yielding,
friction and precompression, and chains of 1 to 510 beads and 20 beads on bars.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.disorder import has_gaps
from granwave.lammps_inputs.planning.energy_input import expected_energy

if TYPE_CHECKING:
    from granwave.lammps_inputs.case.case import Case
    from granwave.lammps_inputs.planning.schedule import Schedule

# s per step
_STEP = 1.2e-6  # LAMMPS itself: one bead on a wall
_PARTICLE = 20e-9  # each sphere and each node of a bar, with ledger and wall forces
_PAIR = 2e-9  # each touching pair
_LOADED = 12.5e-9  # added for a loaded contact: fcc under 1 MPa
_FRICTION = 25e-9  # added for a loaded contact with friction: 1.6 times a step of an impact, 2 under precompression
_YIELDED = 30e-9  # added for a loaded contact that has yielded
_SHARE_LOADED = 0.3  # mean share of loaded pairs during an impact on a packing at rest; 1 under precompression
# The share of contacts that have yielded is 1/(1 + (e/20)^-0.55) for an energy input of e F_y alpha_y per contact:
# 24 impacts on fcc, e from 2e-3 to 350.
_ENERGY_OF_HALF, _ENERGY_POWER = 20.0, 0.55

# static stage
_ITERATION = 3.0  # steps under load: 2 with periodic sides, 3 to 7 under uniform pressure
_ITERATIONS = 1e3  # lattices of equal spheres: 330 to 2300 in chains of 100 and 150 and 20 packings
_ITERATIONS_OF_DISORDER = 1e4  # with gaps: 1200 to 46 000 in 20 packings of 144 to 1152 spheres, without a clear trend
_MOST_ITERATIONS_OF_DISORDER = 1e5

# s in addition to the steps
_START = 0.3  # set-up and analysis, independent of size
_SNAPSHOT, _TEXT_SNAPSHOT = 1.5e-6, 6e-6  # a particle in a snapshot: writing, reading, storing in result.h5, analysis
_HISTORY = 3e-6  # a particle at an instant of a chain's history
_FIGURES_OF_CHAIN, _FIGURES = 1.7, 3.8  # all figures of a run as PNG, including the start of program and library
_FORMAT = 0.45  # of that time for each further format

# first timesteps that an automatic one makes up for over a run: 1 to 1.5 in elastic packings and chains, else 2 to 7
_GAIN, _ELASTIC_GAIN = 3.0, 1.2

_USUAL_BLOCKS = 8  # blocks of ``end_time = "auto"``: 2 in single collisions and layers, 7 to 15 in small packings


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


def _figures(case: Case) -> float:
    """Return the time of drawing the figures of a run, s."""
    as_png = _FIGURES_OF_CHAIN if case.packing.kind == "chain" else _FIGURES
    return as_png * (1 + _FORMAT * len(case.figures.formats))


def expected_wall_time(assembly: Assembly, schedule: Schedule, *, n_ranks: int = 1, figures: bool = True) -> WallTime:
    """Estimate the wall time of the run of a case.

    Parameters
    ----------
    figures
        True if figures are drawn.
    """
    case = assembly.case
    n, part = assembly.n_particles, _usual_part(case, schedule)
    most_steps = schedule.n_steps / schedule.first_step
    gain = (_GAIN if case.contact.yields or case.has_friction else _ELASTIC_GAIN) if schedule.adaptive else 1.0
    each = (seconds_per_step(assembly) + _of_yielding(assembly)) / n_ranks
    snapshot = _TEXT_SNAPSHOT if case.output.dump_format == "text" else _SNAPSHOT
    records = snapshot * max(2.0, part * schedule.n_frames)
    records += _HISTORY * part * schedule.n_steps / schedule.history_every if schedule.history_every else 0.0
    an_iteration = _ITERATION * _seconds(assembly, loaded=1.0, has_friction=False) / n_ranks
    usual, most = _iterations(case)
    return WallTime(
        static=usual * an_iteration,
        most_static=most * an_iteration,
        steps=part * most_steps / gain * each,
        most_steps=most_steps * each,
        rest=_START + n * records,
        figures=_figures(case) if figures else 0.0,
    )


def seconds_per_step(assembly: Assembly) -> float:
    """Estimate the time of a step on one core while contacts are elastic, s."""
    case = assembly.case
    return _seconds(assembly, loaded=_share_loaded(case), has_friction=case.has_friction)


def _seconds(assembly: Assembly, *, loaded: float, has_friction: bool) -> float:
    a_pair = _PAIR + loaded * (_LOADED + has_friction * _FRICTION)
    return _STEP + _PARTICLE * assembly.n_particles + a_pair * assembly.n_neighbours


def _share_loaded(case: Case) -> float:
    return _SHARE_LOADED if case.precompression is None else 1.0


def _of_yielding(assembly: Assembly) -> float:
    """Estimate the additional time of a step due to yielding, averaged over the run, s."""
    case = assembly.case
    if not case.contact.yields:
        return 0.0
    law, n = sphere_contact(case), max(assembly.n_neighbours, 1)
    each = expected_energy(assembly) / (law.yield_force * law.yield_overlap) / n
    share = 1 / (1 + (each / _ENERGY_OF_HALF) ** -_ENERGY_POWER) if each > 0 else 0.0
    return _YIELDED * n * _share_loaded(case) * share


def _usual_part(case: Case, schedule: Schedule) -> float:
    """Share of the longest possible run that a run usually takes."""
    if not schedule.block_steps:
        return 1.0
    blocks = _USUAL_BLOCKS if case.contact.yields or case.has_friction else 1
    return min(1.0, (blocks * schedule.block_steps + case.load.lasts / schedule.timestep) / schedule.n_steps)


def _iterations(case: Case) -> tuple[float, float]:
    """Return the typical and the largest number of iterations of the static stage."""
    if case.precompression is None:
        return 0.0, 0.0
    return (_ITERATIONS_OF_DISORDER, _MOST_ITERATIONS_OF_DISORDER) if has_gaps(case) else (_ITERATIONS, _ITERATIONS)
