"""Memory of each rank of a run, and its disk space, estimated.

The constants were measured on fcc packings of 2e5 to 2e6 spheres on two ranks, with and without friction and static
stage, and are rounded up. The analysis of a larger packing goes through parts of it, and holds a part and the layers
next to it. So does the writer of the deck; only the sites of unlike spheres, and of strikers, are held all at once.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

from granwave.lammps_inputs.packing.assembly import Assembly

if TYPE_CHECKING:
    from granwave.lammps_inputs.planning.schedule import Schedule

ANALYSED_AT_ONCE = 2**18  # spheres that the analysis holds at once, beside those of a few layers of them
MOST_DRAWN = 1_000_000  # spheres of a packing that is drawn without being asked for

# bytes
_PROGRAM = 130e6  # the interpreter with LAMMPS, or with the libraries of the analysis, loaded
_SPHERE, _PAIR, _ROUGH_PAIR = (
    750.0,
    135.0,
    60.0,
)  # of LAMMPS, and of the snapshot that is sorted; with friction in addition
_STATIC_STAGE = 2.0  # times the memory of a run without one
_ANALYSED_SPHERE, _ANALYSED_PAIR = 550.0, 310.0  # of the analysis of a part, all contacts dented
_LAYERS = 4  # next to a part: at most so many hold spheres that may touch it
_SITE = 170.0  # a site of a lattice of unlike or missing spheres, while the deck is written
_PLACED_SITE = 120.0  # a site of a lattice against which strikers are placed
_DRAWN = 2 * 600.0  # a sphere, in two processes that draw
_DATA = 75.0  # a sphere in the data file
_FRAME = 230.0  # a sphere in a snapshot: all digits, and the compressed copy in result.h5
_DENT = 110.0  # a pair among the contacts at the end
_INITIAL_FORCE = (
    70.0  # a pair among the forces after the static stage: its row, in scratch files, its value in result.h5
)
_SCRATCH_SPHERE, _SCRATCH_PAIR = 56.0, 150.0  # in scratch files of an analysis in parts
_CHECKPOINT_SPHERE, _CHECKPOINT_PAIR = 250.0, 250.0  # measured with friction, all yielded
_ROW = 400.0  # of the ledger
_ROWS_PER_PARTICLE = 0.25  # disk space of a particle at an instant of a chain's history, in rows of the ledger


@dataclasses.dataclass(frozen=True)
class Space:
    """Memory and disk space of a run, bytes.

    Attributes
    ----------
    first_rank
        Memory of the first rank, which also writes the deck and makes the analysis.
    other_rank
        Memory of each other rank.
    disk
        Disk space.
    disk_reserve
        Space that must stay free during the run, for one more snapshot and checkpoint.
    """

    first_rank: float
    other_rank: float
    disk: float
    disk_reserve: float

    def memory(self, n_ranks: int) -> float:
        """Return the memory of all ranks together, bytes."""
        return self.first_rank + (n_ranks - 1) * self.other_rank


def expected_space(assembly: Assembly, schedule: Schedule, n_ranks: int) -> Space:
    """Estimate the memory and the disk space of a run."""
    case, n, pairs = assembly.case, assembly.n_particles, assembly.n_neighbours
    pair = _PAIR + (_ROUGH_PAIR if case.has_friction else 0.0)
    steps = (n * _SPHERE + pairs * pair) * (_STATIC_STAGE if case.precompression else 1.0)
    nx, ny, _ = assembly.lattice.shape
    at_once = min(n, ANALYSED_AT_ONCE + _LAYERS * nx * ny)
    analysis = at_once * (_ANALYSED_SPHERE + pairs / n * _ANALYSED_PAIR)
    if n <= MOST_DRAWN:
        analysis = max(analysis, n * _DRAWN)
    scratch = n * _SCRATCH_SPHERE + pairs * _SCRATCH_PAIR if n > ANALYSED_AT_ONCE else 0.0
    sites = (_SITE if assembly.sites is not None else 0.0) + (_PLACED_SITE if assembly.strikers else 0.0)
    pair_on_disk = _DENT + (_INITIAL_FORCE if case.precompression else 0.0)
    rows = schedule.n_steps / schedule.ledger_every + schedule.n_steps / schedule.probe_every
    if schedule.history_every:
        rows += _ROWS_PER_PARTICLE * n * schedule.n_steps / schedule.history_every
    return Space(
        first_rank=2 * _PROGRAM + max(steps / n_ranks, analysis) + assembly.lattice.n_spheres * sites,
        other_rank=_PROGRAM + steps / n_ranks,
        disk=n * (_DATA + schedule.n_frames * _FRAME) + pairs * pair_on_disk + rows * _ROW + scratch,
        disk_reserve=n * (_FRAME + _CHECKPOINT_SPHERE) + pairs * _CHECKPOINT_PAIR,
    )
