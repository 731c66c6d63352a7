"""Symmetric motion of confined rows: beads along the axis, the small spheres of a ring alike, along it and outward.

    m_b w''   = forces of neighbouring beads + n (axial parts of the contacts with the rings on either side)
    m_s w_s'' = axial parts of the contacts with two beads
    m_s u''   = lateral parts of these - k_w [u + shrinks]^1.5 + 2 k_ss [-2 u sin(pi/n)]^1.5 sin(pi/n)

with overlaps of the true, moving geometry and forces along the lines of centres. (6.7) of the thesis are these with
directions that do not turn, without contacts in the ring, and with its constant of the wall.

Velocity Verlet on a window of cells that follows the front. What the wave leaves behind is slower than its front and
never comes back to it, so that the cells behind can be let go. Many rows are followed at once.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.confined.geometry import Row
from granwave.analysis.measures.signals import Array

_WINDOW, _AHEAD, _SHIFT = 72, 22, 16  # cells: of the window, in front of the crest at least, and of a move
_STEP = 0.012  # of the time of a collision (m^2/(k^2 v))^(1/5)
_OF_PERIOD = 0.2  # over the highest frequency of a small sphere
_CHECKS = 16  # steps between looks at the front
_FRONT = 1e-3  # of the largest force
_SLOWEST = 60.0  # times of a collision that a wave takes from bead to bead at most


@dataclasses.dataclass(frozen=True)
class Wave:
    """The leading wave at the contacts of beads, which count from 1: contact k of beads k and k + 1.

    Attributes
    ----------
    force, time
        Largest force (N) and when (s); NaN where the wave did not come: (n_rows, n_contacts).
    """

    force: Array
    time: Array


def leading_wave(row: Row, velocity: Array | float, struck: int, last: int) -> Wave:
    """Strike a bead of each row, and follow the wave to contact ``last``.

    Parameters
    ----------
    velocity
        Of the struck bead, m/s: one for all rows, or (n_rows,).
    struck
        Number of that bead, from 1; the first bead is held.
    """
    n_rows = len(row.n)
    given = np.broadcast_to(np.asarray(velocity, dtype=float), (n_rows,))
    force, time = np.full((n_rows, last), np.nan), np.full((n_rows, last), np.nan)
    for group in _alike(row, given):
        run = _Run(row.part(group), given[group], struck, last)
        run.follow()
        force[group], time[group] = run.force, run.time
    return Wave(force, time)


def _times(row: Row, velocity: Array) -> tuple[Array, Array]:
    """Timestep for each row, and time of a collision, s."""
    collision = (row.bead_mass**2 / (row.k_beads**2 * velocity)) ** 0.2
    overlap = (row.bead_mass * velocity**2 / row.k_beads) ** 0.4 + row.inward
    stiffness = 1.5 * np.sqrt(overlap) * (2 * row.k_side + row.k_wall)
    return np.minimum(_STEP * collision, _OF_PERIOD * np.sqrt(row.small_mass / stiffness)), collision


def _alike(row: Row, velocity: Array) -> list[NDArray[np.intp]]:
    """Numbers of rows whose timesteps are within a factor of 1.5, which are followed together."""
    step, _ = _times(row, velocity)
    order, groups = np.argsort(step), []
    while len(order):
        together = step[order] <= 1.5 * step[order[0]]
        groups.append(order[together])
        order = order[~together]
    return groups


class _Run:
    """Window of cells of each row; arrays (n_rows, n_cells), of cells from the bead ``first`` on."""

    def __init__(self, row: Row, velocity: Array, struck: int, last: int) -> None:
        self.struck, self.last = struck, last
        n_rows = len(row.n)
        steps, collision = _times(row, velocity)
        self.step, self.longest = float(steps.min()), _SLOWEST * float(collision.max())
        self.force, self.time = np.full((n_rows, last), np.nan), np.full((n_rows, last), np.nan)
        self.rows = np.arange(n_rows)  # of self.force, of what is still followed
        self._take(row)
        self.first = np.zeros(n_rows, dtype=np.intp)
        self.z, self.vz = np.zeros((2, n_rows, _WINDOW))
        self.w, self.vw, self.vu = np.zeros((3, n_rows, _WINDOW - 1))
        self.u = np.repeat(-row.inward[:, None], _WINDOW - 1, axis=1)
        self.vz[:, struck - 1] = velocity
        self.peak, self.when = np.zeros((2, n_rows, _WINDOW - 1))

    def _take(self, row: Row) -> None:
        self.row = row

        def column(values: Array) -> Array:
            return np.ascontiguousarray(np.asarray(values, dtype=float)[:, None])

        self.ring, self.half, self.reach = column(row.ring), column(row.bead / 2), column((row.bead + row.small) / 2)
        self.shrinks, self.inward, self.n = column(row.shrinks), column(row.inward), column(row.n)
        self.k_beads, self.k_side, self.k_wall = column(row.k_beads), column(row.k_side), column(row.k_wall)
        self.chord = column(np.sin(np.pi / row.n))
        self.k_ring = column(2 * row.k_ring) * self.chord
        self.of_bead, self.of_small = column(1 / row.bead_mass), column(1 / row.small_mass)

    def follow(self) -> None:
        """Go on until the front of every row has passed the last contact."""
        count, now = 0, 0.0
        rates = self._accelerations(now)
        half, until = 0.5 * self.step, self.longest * (self.last + 2 * _AHEAD)
        while len(self.rows) and now < until:
            for velocity, rate in zip((self.vz, self.vw, self.vu), rates, strict=True):
                velocity += half * rate
            for place, velocity in zip((self.z, self.w, self.u), (self.vz, self.vw, self.vu), strict=True):
                place += self.step * velocity
            count += 1
            now = count * self.step
            rates = self._accelerations(now)
            for velocity, rate in zip((self.vz, self.vw, self.vu), rates, strict=True):
                velocity += half * rate
            if count % _CHECKS == 0 and self._move_on():
                rates = self._accelerations(now)

    def _accelerations(self, now: float) -> tuple[Array, Array, Array]:
        z, w, u = self.z, self.w, self.u
        overlap = np.maximum(z[:, :-1] - z[:, 1:], 0.0)
        push = self.k_beads * overlap * np.sqrt(overlap)
        higher = push > self.peak
        self.peak[higher], self.when[higher] = push[higher], now
        across = self.ring + u
        square = across * across
        on_bead = np.zeros_like(z)
        on_bead[:, :-1] -= push
        on_bead[:, 1:] += push
        axial, outward = np.zeros((2, *u.shape))
        for offset, place, beads in ((self.half, z[:, :-1], slice(0, -1)), (-self.half, z[:, 1:], slice(1, None))):
            along = w - place
            along += offset
            apart = np.sqrt(along * along + square)
            overlap = np.maximum(self.reach - apart, 0.0)
            force = self.k_side * overlap * np.sqrt(overlap) / apart
            along *= force
            force *= across
            axial, outward = axial + along, outward + force
            on_bead[:, beads] -= self.n * along
        overlap = np.maximum(u + self.shrinks, 0.0)
        outward -= self.k_wall * overlap * np.sqrt(overlap)
        overlap = np.maximum(-2 * self.chord * u, 0.0)
        outward += self.k_ring * overlap * np.sqrt(overlap)
        on_bead[:, 0] = on_bead[:, -1] = 0.0
        return on_bead * self.of_bead, axial * self.of_small, outward * self.of_small

    def _move_on(self) -> bool:
        """Move windows whose crest comes near the end, and let rows go that are done; True if anything changed."""
        started = self.peak.max(axis=1) > 0
        rising = self.peak > _FRONT * self.peak.max(axis=1, keepdims=True)
        crest = np.where(started, (rising * np.arange(1, rising.shape[1] + 1)).max(axis=1), 0)
        done = self.first + crest - _AHEAD // 2 > self.last
        moving = ~done & (crest > _WINDOW - _AHEAD)
        for k in np.flatnonzero(done).tolist():
            self._keep(k, _WINDOW - 1)
        for k in np.flatnonzero(moving).tolist():
            self._keep(k, _SHIFT)
            self.first[k] += _SHIFT
            for values, rest in self._fields(k):
                values[:-_SHIFT] = values[_SHIFT:].copy()
                values[-_SHIFT:] = rest
            self.vz[k, 0] = 0.0
        if done.any():
            left = ~done
            self._take(self.row.part(left))
            for name in ("rows", "first", "z", "vz", "w", "vw", "u", "vu", "peak", "when"):
                setattr(self, name, getattr(self, name)[left])
        return bool(done.any() or moving.any())

    def _fields(self, k: int) -> list[tuple[Array, float]]:
        """Arrays of a row along the window, and their values in the undisturbed row."""
        at_rest = [(one[k], 0.0) for one in (self.z, self.vz, self.w, self.vw, self.vu, self.peak, self.when)]
        return [*at_rest, (self.u[k], -float(self.inward[k, 0]))]

    def _keep(self, k: int, n: int) -> None:
        """Keep the peaks of the first ``n`` contacts of a window."""
        start = int(self.first[k])
        stop = min(start + n, self.last)
        chosen = self.peak[k, : max(stop - start, 0)]
        known = chosen > 0
        places = np.arange(start, start + len(chosen))[known]
        self.force[self.rows[k], places] = chosen[known]
        self.time[self.rows[k], places] = self.when[k, : len(chosen)][known]
