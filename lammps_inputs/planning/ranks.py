"""Time of a step on many ranks, and the grid of ranks with the shortest steps.

LAMMPS divides the box into a grid of equal bricks, one for each rank, and the slowest rank decides:
all wait for it. A sphere at rest takes far less time than a moving sphere. The ranks that the wave
of an impact has reached are therefore busy, and the other ranks wait. The model of a step is

    t = n c_rest + a (c_active - c_rest) + g c_ghost + 2 s t_message + c t_sum log2(ranks)

for n spheres of a brick, of which a are active, and g ghosts: copies of spheres of other bricks
within `_REACH`. There are s axes with more than one brick. A sphere is active if it moves, or is in
a block of 32 consecutive spheres of which one moves: the pair style and the integrator skip blocks
at rest, not spheres. Ids of a lattice count along x first, so that a block is a part of a row: a
small wave keeps two to six times as many spheres active as it moves. The measured work of a step of
an impact with friction is proportional to the active spheres within 4 %.

The distances of the front of a wave from the loaded spheres along y and z add up to the distance
that it has travelled: a diamond. Along x the wave reaches a third of this distance on average, and
half a block beyond. The largest fraction of a brick is the product of the largest fraction along x
and the largest fraction of the cross-section.

LAMMPS's own grid has the smallest surface. For a wave from one point, or from the top layer by
layer, columns along its direction are loaded more evenly, at the cost of more ghosts.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.lattices import Lattice
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.motion import impacted_of

Floats = NDArray[np.float64]
Grid = tuple[int, int, int]

_REACH = 1.2  # width of the ghost layer of a brick, diameters: pair, gap and skin
_LEAST_WIDTH = 1.0  # smallest width of a brick, diameters
_STAGES = 24  # stages of growth of the wave over which times are averaged
_BLOCK = 32  # consecutive spheres that the styles skip together, RestingBlocks::SIZE
_SLICES = 8  # slices of a brick along z, over which the cross-section of the wave is summed
_MEAN_REACH = 1 / 3  # mean reach of a diamond along x, relative to the distance travelled


@dataclasses.dataclass(frozen=True)
class StepCosts:
    """Costs of the parts of a step, s.

    Attributes
    ----------
    rest
        A sphere in a block at rest.
    active
        A sphere in a block with spheres that move, in a wave from some spheres.
    moving
        A sphere where all spheres move, in loaded contacts; also behind a plane wave.
    ghost
        A ghost: packing, sending, and unpacking.
    message
        Latency of a message.
    total
        Latency of a sum over two ranks; over n ranks it takes log2(n) times as long.
    """

    rest: float
    active: float
    moving: float
    ghost: float
    message: float = 2e-6
    total: float = 2e-6


SMOOTH = StepCosts(rest=3.4e-9, active=22e-9, moving=67e-9, ghost=12e-9)
ROUGH = StepCosts(rest=4.2e-9, active=32e-9, moving=96e-9, ghost=20e-9)


@dataclasses.dataclass(frozen=True)
class Wave:
    """Packing on which a wave spreads.

    Attributes
    ----------
    n_spheres
        Number of spheres.
    low, high
        Lowest and highest coordinates of the packing, (3,), m.
    first, last
        Lowest and highest coordinates of the loaded spheres, (3,), m.
    reach
        Distance from a brick within which spheres are ghosts, m.
    periodic
        True for axes along which the packing is periodic, (3,).
    block
        Length of a block of consecutive spheres along x, m; 0: their order is not known.
    """

    n_spheres: int
    low: Floats
    high: Floats
    first: Floats
    last: Floats
    reach: float
    periodic: tuple[bool, bool, bool] = (False, False, False)
    block: float = 0.0

    @property
    def farthest(self) -> float:
        """Distance travelled by the front when all spheres move, m."""
        return float(max((self.first - self.low).max(), (self.high - self.last).max()))

    @property
    def is_plane(self) -> bool:
        """True if the load covers the packing along two axes, so that all spheres behind the front
        are active because they move.
        """
        covered = (self.first - self.low < self.reach) & (self.high - self.last < self.reach)
        return bool(np.count_nonzero(covered) >= 2)

    def shares(self, grid: Grid, travelled: float) -> Floats:
        """Return, along each axis, the fraction of the spheres that move and lie in a layer of
        bricks: for the brick with most of them, and for all bricks together, (3, 2).
        """
        shares = np.empty((3, 2))
        for axis, n_bricks in enumerate(grid):
            length = self.high[axis] - self.low[axis]
            edges = np.linspace(self.low[axis], self.high[axis], n_bricks + 1)
            begin = np.maximum(edges[:-1], self.first[axis] - travelled)
            end = np.minimum(edges[1:], self.last[axis] + travelled)
            inside = np.maximum(end - begin, 0.0) / length
            shares[axis] = inside.max(), inside.sum()
        return shares

    def active(self, grid: Grid, travelled: float) -> tuple[float, float]:
        """Return the fraction of the spheres that are active in the brick with most of them, and in
        all bricks together.
        """
        if self.farthest == 0.0:
            return 1.0 / math.prod(grid), 1.0
        _, n_along_y, n_along_z = grid
        reach = travelled * _MEAN_REACH + self.block / 2
        along = self._covered(0, grid[0], np.array([reach]))
        n_slices = n_along_z * _SLICES
        heights = np.linspace(self.low[2], self.high[2], n_slices + 1)
        middle = (heights[1:] + heights[:-1]) / 2
        above = self.first[2] - middle
        below = middle - self.last[2]
        apart = np.maximum(np.maximum(above, below), 0.0)
        slices = self._covered(1, n_along_y, travelled - apart)
        section = slices.reshape(n_along_y, n_along_z, _SLICES).sum(axis=2) / n_slices
        most = along.max() * section.max()
        total = along.sum() * section.sum()
        return float(most), float(total)

    def _covered(self, axis: int, n_bricks: int, reach: Floats) -> Floats:
        """Return the fraction of the length of an axis that is in each layer of bricks and within
        some distances of the loaded spheres: (n_bricks, n_distances); none is within a negative
        distance.
        """
        edges = np.linspace(self.low[axis], self.high[axis], n_bricks + 1)[:, np.newaxis]
        begin = np.maximum(edges[:-1], self.first[axis] - reach)
        end = np.minimum(edges[1:], self.last[axis] + reach)
        inside = np.where(reach < 0.0, 0.0, np.maximum(end - begin, 0.0))
        return inside / (self.high[axis] - self.low[axis])

    def ghosts(self, grid: Grid) -> float:
        """Return the number of ghosts of the brick with most of them."""
        lengths = self.high - self.low
        widths = lengths / grid
        wider = widths.copy()
        for axis, n_bricks in enumerate(grid):
            sides = 2 if self.periodic[axis] else min(n_bricks - 1, 2)
            wider[axis] += sides * min(self.reach, float(lengths[axis]))
        density = self.n_spheres / lengths.prod()
        return float(density * (wider.prod() - widths.prod()))


@dataclasses.dataclass(frozen=True)
class StepTimes:
    """Times of a step, s.

    Attributes
    ----------
    busiest
        Of the rank with most work, and so of all.
    mean
        Work of a rank, averaged over the ranks, with its ghosts.
    communication
        Ghosts, messages and sums, a part of both.
    """

    busiest: float
    mean: float
    communication: float

    @property
    def efficiency(self) -> float:
        """Fraction of the time in which a rank works on its own spheres."""
        return (self.mean - self.communication) / self.busiest


def step_times(wave: Wave, grid: Grid, costs: StepCosts, travelled: float) -> StepTimes:
    """Return the times of a step when the wave has travelled this far, m."""
    n_ranks = math.prod(grid)
    largest, whole = wave.active(grid, travelled)
    n_messages = 2 * sum(n_bricks > 1 for n_bricks in grid)
    communication = wave.ghosts(grid) * costs.ghost
    if n_ranks > 1:
        communication += n_messages * costs.message + costs.total * math.log2(n_ranks)
    own = wave.n_spheres / n_ranks * costs.rest
    active = costs.moving if wave.is_plane else costs.active
    extra = wave.n_spheres * (active - costs.rest)
    return StepTimes(
        busiest=own + largest * extra + communication,
        mean=own + whole / n_ranks * extra + communication,
        communication=communication,
    )


def mean_times(wave: Wave, grid: Grid, costs: StepCosts) -> StepTimes:
    """Return the times of a step, averaged over the time in which the wave crosses the packing."""
    distances = (np.arange(_STAGES) + 0.5) / _STAGES * wave.farthest
    times = [step_times(wave, grid, costs, float(travelled)) for travelled in distances]
    return StepTimes(
        busiest=sum(time.busiest for time in times) / _STAGES,
        mean=sum(time.mean for time in times) / _STAGES,
        communication=times[0].communication,
    )


def grids(n_ranks: int) -> Iterator[Grid]:
    """Yield all grids of this number of ranks."""
    for nx in _divisors(n_ranks):
        for ny in _divisors(n_ranks // nx):
            yield nx, ny, n_ranks // (nx * ny)


def _divisors(number: int) -> list[int]:
    return [divisor for divisor in range(1, number + 1) if number % divisor == 0]


def best_grid(wave: Wave, n_ranks: int, costs: StepCosts) -> Grid:
    """Return the grid of ranks with the shortest steps; of equal grids, the grid with the fewest
    bricks along z, then along y.
    """
    lengths = wave.high - wave.low
    least = _LEAST_WIDTH / _REACH * wave.reach
    wide = [grid for grid in grids(n_ranks) if (lengths / grid >= least).all()]
    if not wide:  # more ranks than the packing has room for
        wide = list(grids(n_ranks))
    rounded = {grid: float(f"{mean_times(wave, grid, costs).busiest:.6g}") for grid in wide}
    return min(wide, key=lambda grid: (rounded[grid], *reversed(grid)))


def wave_of(assembly: Assembly) -> Wave:
    """Return the wave of the load of a case; it fills the packing from the start if there is no
    load on some spheres, or if a precompression loads all contacts.
    """
    low, high = assembly.faces()
    loaded = impacted_of(assembly)
    first = low
    last = high
    if loaded and assembly.case.precompression is None:
        centres = np.array([assembly.centre_of(sphere) for sphere in loaded])
        radius = assembly.lattice.diameter / 2
        first = np.maximum(centres.min(axis=0) - radius, low)
        last = np.minimum(centres.max(axis=0) + radius, high)
    sides = assembly.lattice.periodic
    reach = _REACH * assembly.case.packing.diameter
    in_order = isinstance(assembly.lattice, Lattice)
    block = (_BLOCK - 1) * assembly.lattice.diameter if in_order else 0.0
    periodic = (sides, sides, False)
    return Wave(assembly.n_particles, low, high, first, last, reach, periodic, block)


def costs_of(assembly: Assembly) -> StepCosts:
    """Return the costs of a step of a case."""
    return ROUGH if assembly.case.has_friction else SMOOTH


def grid_of(assembly: Assembly, n_ranks: int) -> Grid:
    """Return the grid of ranks for a run: the grid of `run.processors`, or the grid chosen by the
    model.
    """
    grid = assembly.case.run.processors
    if not isinstance(grid, str):
        return grid
    return best_grid(wave_of(assembly), n_ranks, costs_of(assembly))
