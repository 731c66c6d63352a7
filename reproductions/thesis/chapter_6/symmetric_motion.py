"""Symmetric motion of confined rows: beads move along the axis; all small spheres of a ring have
the same motion, along the axis and outward.

    m_b w''   = forces of the neighbouring beads
                + n (axial components of the contact forces with the rings on either side)
    m_s w_s'' = axial components of the contact forces with two beads
    m_s u''   = lateral components of these forces - k_w [u + shrinks]^1.5
                + 2 k_ss [-2 u sin(pi/n)]^1.5 sin(pi/n)

The overlaps are those of the moving geometry, and forces act along the lines of centres. Equations (6.7) of
the thesis follow with fixed contact directions, without contacts in the ring, and with its constant
of the wall.

The integration is velocity Verlet on a window of cells that follows the front. Motion behind the
wave is slower than the front and never reaches it, so that cells far behind are dropped. Many rows
are computed at once.
"""

import numpy as np
from confined_rows import BEAD, K_BEADS, MASS, together

# cells of the window, at least in front of the crest, and of a shift
WINDOW = 72
AHEAD = 22
SHIFT = 16
STEP = 0.012  # fraction of the time of a collision (m^2/(k^2 v))^(1/5)
OF_PERIOD = 0.2  # factor of the inverse of the highest frequency of a small sphere
CHECKS = 16  # steps between checks of the front
FRONT = 1e-3  # fraction of the largest force


def waves_of(runs):
    """Peak forces and their times for the rows of runs, up to the longest row."""
    last = min(max(run.passed for run in runs), 200)
    return leading_wave(
        together(runs), np.array([run.impact for run in runs]), runs[0].struck, last
    )


def leading_wave(rows, velocity, struck, last, motion=None):
    """Largest force of each contact between beads, N, and its time, s: (n_rows, last); bead
    ``struck`` has an initial velocity, m/s. ``motion``: class of the window, `Window` by default.
    """
    motion = motion or Window
    given = np.broadcast_to(np.asarray(velocity, dtype=float), rows.n.shape)
    force, time = np.full((2, len(given), last), np.nan)
    overlap = (MASS * given**2 / K_BEADS) ** 0.4 + rows.inward
    stiffness = 1.5 * np.sqrt(overlap) * (2 * rows.k_side + rows.k_wall)
    collision = (MASS**2 / (K_BEADS**2 * given)) ** 0.2
    step = np.minimum(STEP * collision, OF_PERIOD * np.sqrt(rows.mass / stiffness))
    order = np.argsort(step)
    while len(order):  # rows whose timesteps are within a factor of 1.5 are followed together
        alike = step[order] <= 1.5 * step[order[0]]
        group = order[alike]
        order = order[~alike]
        window = motion(rows.part(group), given[group], struck, last, step[group].min())
        window.follow()
        force[group], time[group] = window.force, window.time
    return force, time


class Window:
    """Cells of each row that are followed; arrays (n_rows, n_cells), of cells from the bead
    ``first`` on.
    """

    def __init__(self, rows, velocity, struck, last, step):
        self.last = last
        self.step = step
        n = len(velocity)
        self.force, self.time = np.full((2, n, last), np.nan)
        # indices of the rows that are still followed
        self.rows = np.arange(n)
        self.first = np.zeros(n, dtype=int)
        self.take(rows)
        self.z, self.vz = np.zeros((2, n, WINDOW))
        self.w, self.vw, self.vu, self.peak, self.when = np.zeros((5, n, WINDOW - 1))
        self.u = np.repeat(-rows.inward[:, None], WINDOW - 1, axis=1)
        self.vz[:, struck - 1] = velocity

    def take(self, rows):
        """Set the properties of the followed rows, as columns."""
        self.properties = rows
        names = (
            "ring",
            "shrinks",
            "n",
            "k_side",
            "k_wall",
            "chord",
            "mass",
            "k_ring",
            "small",
            "inward",
        )
        for name in names:
            setattr(self, name, np.asarray(getattr(rows, name), dtype=float)[:, None])

    def follow(self):
        """Continue until the front of every row has passed the last contact."""
        count = 0
        half = 0.5 * self.step
        rates = self.accelerations(0.0)
        while len(self.rows):
            for velocity, rate in zip((self.vz, self.vw, self.vu), rates, strict=True):
                velocity += half * rate
            for place, velocity in zip(
                (self.z, self.w, self.u), (self.vz, self.vw, self.vu), strict=True
            ):
                place += self.step * velocity
            count += 1
            rates = self.accelerations(count * self.step)
            for velocity, rate in zip((self.vz, self.vw, self.vu), rates, strict=True):
                velocity += half * rate
            if count % CHECKS == 0 and self.move_on():
                rates = self.accelerations(count * self.step)

    def accelerations(self, now):
        """Return accelerations of beads, and of small spheres along the row and outward; record
        peaks.
        """
        overlap = np.maximum(self.z[:, :-1] - self.z[:, 1:], 0.0)
        push = K_BEADS * overlap * np.sqrt(overlap)
        higher = push > self.peak
        self.peak[higher], self.when[higher] = push[higher], now
        on_bead = np.zeros_like(self.z)
        on_bead[:, :-1] -= push
        on_bead[:, 1:] += push
        axial, outward = np.zeros((2, *self.u.shape))
        for offset, beads in ((BEAD / 2, slice(0, -1)), (-BEAD / 2, slice(1, None))):
            along = self.w - self.z[:, beads] + offset
            push_along, push_outward = self.side_forces(along)
            axial = axial + push_along
            outward = outward + push_outward
            on_bead[:, beads] -= self.n * push_along
        overlap = np.maximum(self.u + self.shrinks, 0.0)
        outward -= self.k_wall * overlap * np.sqrt(overlap)
        overlap = np.maximum(-2 * self.chord * self.u, 0.0)
        outward += 2 * self.k_ring * self.chord * overlap * np.sqrt(overlap)
        on_bead[:, 0] = on_bead[:, -1] = 0.0
        return on_bead / MASS, axial / self.mass, outward / self.mass

    def side_forces(self, along):
        """Force of a bead on small spheres along the row and outward, N."""
        across = self.ring + self.u
        apart = np.sqrt(along * along + across * across)
        overlap = np.maximum((BEAD + self.small) / 2 - apart, 0.0)
        force = self.k_side * overlap * np.sqrt(overlap) / apart
        return force * along, force * across

    def move_on(self):
        """Shift windows whose crest approaches the end, and drop completed rows; True if anything
        changed.
        """
        rising = self.peak > FRONT * self.peak.max(axis=1, keepdims=True)
        crest = (rising * np.arange(1, WINDOW)).max(axis=1)
        done = self.first + crest - AHEAD // 2 > self.last
        moving = ~done & (crest > WINDOW - AHEAD)
        for k in np.flatnonzero(done | moving):
            self.keep(k, WINDOW - 1 if done[k] else SHIFT)
        for k in np.flatnonzero(moving):
            self.first[k] += SHIFT
            for one in (self.z, self.vz, self.w, self.vw, self.vu, self.peak, self.when, self.u):
                one[k, :-SHIFT] = one[k, SHIFT:].copy()
                one[k, -SHIFT:] = -self.inward[k, 0] if one is self.u else 0.0
            self.vz[k, 0] = 0.0
        if done.any():
            self.take(self.properties.part(~done))
            for name in ("rows", "first", "z", "vz", "w", "vw", "u", "vu", "peak", "when"):
                setattr(self, name, getattr(self, name)[~done])
        return done.any() or moving.any()

    def keep(self, k, n):
        """Keep the peaks of the first ``n`` contacts of a window."""
        n = max(min(n, self.last - self.first[k]), 0)
        places = slice(self.first[k], self.first[k] + n)
        self.force[self.rows[k], places], self.time[self.rows[k], places] = (
            self.peak[k, :n],
            self.when[k, :n],
        )
