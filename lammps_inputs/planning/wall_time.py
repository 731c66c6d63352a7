"""How long a run takes, before it is run: within a factor of two, from few constants.

The constants are processor times on one core of a 2-core virtual machine (AMD EPYC, Zen 4) whose other core was busy
too, as in a scan; a run that has the machine for itself is up to 1.6 times as fast. Each is the difference of runs that
differ in one thing: fcc packings of 600 to 7000 brass spheres struck at 1 to 20 m/s, with and without yielding,
friction and precompression, and chains of 1 to 510 beads and 20 beads on bars.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.disorder import has_gaps
from granwave.lammps_inputs.planning.timestep import expected_energy

if TYPE_CHECKING:
    from granwave.lammps_inputs.case.case import Case
    from granwave.lammps_inputs.planning.schedule import Schedule

# s of a step
_STEP = 1.2e-6  # of LAMMPS itself: one bead on a wall
_PARTICLE = 20e-9  # of each sphere and each node of a bar, the ledger and wall forces included
_PAIR = 2e-9  # of each touching pair
_LOADED = 12.5e-9  # more where it bears a force: fcc under 1 MPa
_FRICTION = (
    25e-9  # more where it bears a force with friction: 1.6 times a step of an impact, twice one under precompression
)
_YIELDED = 30e-9  # more where it bears a force and has yielded
_SHARE_LOADED = 0.3  # of the pairs, over an impact on a packing at rest; all under precompression
# The share of contacts that have yielded is 1/(1 + (e/20)^-0.55) for an input of e F_y alpha_y a contact: 24 impacts on
# fcc, e from 2e-3 to 350.
_ENERGY_OF_HALF, _ENERGY_POWER = 20.0, 0.55

# of the static stage
_ITERATION = 3.0  # steps under load: 2 with periodic sides, 3 to 7 under uniform pressure
_ITERATIONS = 1e3  # of a lattice of like spheres: 330 to 2300 in chains of 100 and 150 and 20 packings
_ITERATIONS_OF_DISORDER = 1e4  # with gaps to close: 1200 to 46 000 in 20 packings of 144 to 1152, by no plain rule
_MOST_ITERATIONS_OF_DISORDER = 1e5

# s beside the steps
_START = 0.3  # of set-up and analysis, whatever the size
_SNAPSHOT = 12e-6  # of a particle in a snapshot: written, read, kept in result.h5, analysed
_HISTORY = 3e-6  # of a particle at an instant of a chain's history
_FIGURES_OF_CHAIN, _FIGURES = 4.0, 12.0  # all figures of a run, the drawing library and the program loaded

# first timesteps that an automatic one makes up for over a run: 1 to 1.5 in elastic packings and chains, else 2 to 7
_GAIN, _ELASTIC_GAIN = 3.0, 1.2

_USUAL_BLOCKS = 8  # of ``end_time = "auto"``: 2 in single collisions and layers, 7 to 15 in small packings


@dataclasses.dataclass(frozen=True)
class WallTime:
    """Time of a run, s.

    Attributes
    ----------
    static
        Of the static stage; where its length cannot be known, of one of middle length.
    most_static
        Of a long one.
    steps
        Of the time integration; with ``end_time = "auto"`` until it usually ends.
    most_steps
        Of as many steps as there can be.
    rest
        Set-up and analysis.
    figures
        0 where none are drawn.
    """

    static: float
    most_static: float
    steps: float
    most_steps: float
    rest: float
    figures: float

    @property
    def total(self) -> float:
        """All of it, s."""
        return self.static + self.steps + self.rest + self.figures

    @property
    def longest(self) -> float:
        """With a long static stage and as many steps as there can be, s."""
        return self.most_static + self.most_steps + self.rest + self.figures


def expected_wall_time(assembly: Assembly, schedule: Schedule, *, n_ranks: int = 1, figures: bool = True) -> WallTime:
    """Estimate the time of the run of a case.

    Parameters
    ----------
    figures
        They are drawn too.
    """
    case = assembly.case
    n, part = assembly.n_particles, _usual_part(case, schedule)
    most_steps = schedule.n_steps / schedule.first_step
    gain = (_GAIN if case.contact.yields or case.has_friction else _ELASTIC_GAIN) if schedule.adaptive else 1.0
    each = (seconds_per_step(assembly) + _of_yielding(assembly)) / n_ranks
    records = _SNAPSHOT * max(2.0, part * schedule.n_frames)
    records += _HISTORY * part * schedule.n_steps / schedule.history_every if schedule.history_every else 0.0
    an_iteration = _ITERATION * _seconds(assembly, loaded=1.0, has_friction=False) / n_ranks
    usual, most = _iterations(case)
    return WallTime(
        static=usual * an_iteration,
        most_static=most * an_iteration,
        steps=part * most_steps / gain * each,
        most_steps=most_steps * each,
        rest=_START + n * records,
        figures=(_FIGURES_OF_CHAIN if case.packing.kind == "chain" else _FIGURES) if figures else 0.0,
    )


def seconds_per_step(assembly: Assembly) -> float:
    """Time of a step on one core, while contacts are elastic, s."""
    case = assembly.case
    return _seconds(assembly, loaded=_share_loaded(case), has_friction=case.has_friction)


def _seconds(assembly: Assembly, *, loaded: float, has_friction: bool) -> float:
    a_pair = _PAIR + loaded * (_LOADED + has_friction * _FRICTION)
    return _STEP + _PARTICLE * assembly.n_particles + a_pair * assembly.n_neighbours


def _share_loaded(case: Case) -> float:
    return _SHARE_LOADED if case.precompression is None else 1.0


def _of_yielding(assembly: Assembly) -> float:
    """Estimate the additional time of a step, averaged over the run, because contacts yield, s."""
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
    """Iterations of the static stage, usually and at most."""
    if case.precompression is None:
        return 0.0, 0.0
    return (_ITERATIONS_OF_DISORDER, _MOST_ITERATIONS_OF_DISORDER) if has_gaps(case) else (_ITERATIONS, _ITERATIONS)
