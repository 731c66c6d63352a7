"""An independent solver for plane crystals of discs, in numpy: it shares no code with the package
or the plugin.

All values are per metre of the cylinders. It has line contacts in plane strain (Johnson, 1985, eq.
5.57), a relaxation time, Coulomb friction with a tangential spring, plane motion with rotation,
rigid walls left, right and below, and a rigid plate on the top that moves along z. z points down,
as in the package. The integration is velocity Verlet with a fixed timestep.
"""

from __future__ import annotations

import dataclasses

import numpy as np

# Stiffness / E* at P = 0.01 E* R, of two grains and on a plane: that of a tangential spring that
# stays the same.
_TYPICAL = 0.539
_TYPICAL_ON_PLANE = 1.078


def crystal(kind: str, n: int, layers: int, short_first: bool) -> np.ndarray:
    """Centres in diameters, row by row from the top: (n_grains, 2)."""
    across, down = (
        (np.sqrt(2), 1 / np.sqrt(2)) if kind == "centred-square" else (1.0, np.sqrt(3) / 2)
    )
    rows = []
    for k in range(layers):
        short = (k % 2 == 0) == short_first
        count = n - 1 if short else n
        rows += [((i + 0.5 * short) * across, k * down) for i in range(count)]
    return np.array(rows)


@dataclasses.dataclass
class LineLaw:
    """Force per length of a line contact: overlap = P/(pi E) (ln(scale/P) - 1)."""

    modulus: float
    scale: float

    def force(self, overlap: np.ndarray, guess: np.ndarray) -> np.ndarray:
        """Solve for P by Newton's method in ln P."""
        p = np.where(guess > 0, guess, overlap * self.modulus / 2)
        p = np.minimum(p, 0.5 * self.scale / np.e**2)
        for _ in range(30):
            log = np.log(self.scale / p)
            found = p / (np.pi * self.modulus) * (log - 1)
            step = (overlap - found) / (p / (np.pi * self.modulus) * (log - 2))
            p = p * np.exp(np.clip(step, -2, 2))
            if np.max(np.abs(step), initial=0.0) < 1e-13:
                break
        return p

    def stiffness(self, p: np.ndarray) -> np.ndarray:
        """Return dP/d overlap."""
        return np.pi * self.modulus / (np.log(self.scale / p) - 2)


@dataclasses.dataclass
class Discs:
    """Crystal of equal discs under a plate; see `run`.

    Attributes
    ----------
    centres
        In diameters: (n_grains, 2), across and down.
    plate_mass
        Per length, kg/m.
    constant_spring
        True for a tangential spring whose stiffness does not follow the contact.
    reach
        Distance within which grains may touch later, in radii.
    """

    centres: np.ndarray
    radius: float
    youngs_modulus: float
    poisson_ratio: float
    density: float
    friction: float
    loss_time: float
    plate_mass: float
    plate_velocity: float
    walls: bool = True
    constant_spring: bool = False
    reach: float = 2.2

    def __post_init__(self) -> None:
        """Find contacts and laws."""
        r = self.radius
        n = len(self.centres)
        self.x = self.centres * 2 * r
        plain = self.youngs_modulus / (1 - self.poisson_ratio**2)
        pairs = LineLaw(plain / 2, 8 * np.pi * plain / 2 * r)
        planes = LineLaw(plain, 4 * np.pi * plain * r)
        apart = np.linalg.norm(self.x[:, None] - self.x[None], axis=2)
        i, j = np.nonzero(np.triu(apart < self.reach * r, 1))
        self.i = i
        self.j = j
        every = np.arange(n)
        # left, right, bottom, plate
        self.planes = [
            np.array([1.0, 0.0]),
            np.array([-1.0, 0.0]),
            np.array([0.0, -1.0]),
            np.array([0.0, 1.0]),
        ]
        low = self.x.min(axis=0) - r
        high = self.x.max(axis=0) + r
        self.places = [low[0], -high[0], -high[1], low[1]]
        self.used = [0, 1, 2, 3] if self.walls else [2, 3]
        self.grain = np.concatenate([np.concatenate([i]), *[every for _ in self.used]]).astype(int)
        self.n_pairs = len(i)
        self.n = n
        self.mass = self.density * np.pi * r**2
        self.inertia = 0.5 * self.density * np.pi * r**4
        self.laws = (pairs, planes)
        count = self.n_pairs + n * len(self.used)
        self.p = np.zeros(count)
        self.spring = np.zeros(count)
        self.k_before = np.zeros(count)
        self.v = np.zeros((n, 2))
        self.omega = np.zeros(n)
        self.u = 0.0
        self.speed = self.plate_velocity  # of the plate, down
        self.viscous = self.rubbed = 0.0
        self.dt = 0.02 / np.sqrt(8 * 1.2 * plain / 2 / self.mass)

    def forces(self, dt: float) -> tuple[np.ndarray, np.ndarray, float]:
        """Return forces, torques and the force on the plate; with ``dt`` springs advance and
        dissipated energies are summed.
        """
        r = self.radius
        n = self.n
        used = self.used
        delta = self.x[self.i] - self.x[self.j]
        distance = np.linalg.norm(delta, axis=1)
        normal = [delta / distance[:, None]]
        overlap = [2 * r - distance]
        relative = [self.v[self.i] - self.v[self.j]]
        spin = [(r - overlap[0] / 2) * (self.omega[self.i] + self.omega[self.j])]
        for which in used:
            across = self.planes[which]
            depth = r - (self.x @ across - self.places[which])
            moving = np.array([0.0, self.speed]) if which == 3 else np.zeros(2)
            if which == 3:
                depth = depth + self.u
            normal.append(np.tile(across, (n, 1)))
            overlap.append(depth)
            relative.append(self.v - moving)
            spin.append((r - depth) * self.omega)
        normal = np.concatenate(normal)
        overlap = np.concatenate(overlap)
        relative = np.concatenate(relative)
        spin = np.concatenate(spin)
        touch = overlap > 1e-15
        pair = np.arange(len(overlap)) < self.n_pairs
        p = np.zeros(len(overlap))
        k = np.zeros(len(overlap))
        for law, where in ((self.laws[0], touch & pair), (self.laws[1], touch & ~pair)):
            if where.any():
                p[where] = law.force(overlap[where], self.p[where])
                k[where] = law.stiffness(p[where])
        rate = -np.einsum("ij,ij->i", relative, normal)
        total = np.where(touch, np.maximum(p + self.loss_time * k * rate, 0.0), 0.0)
        tangent = np.stack([-normal[:, 1], normal[:, 0]], axis=1)
        slip = (
            np.einsum("ij,ij->i", relative, tangent) - spin
        )  # n x w in the plane, with the lever arms
        ratio = 2 * (1 - self.poisson_ratio) / (2 - self.poisson_ratio)
        if self.constant_spring:
            k_t = ratio * np.where(pair, _TYPICAL, _TYPICAL_ON_PLANE) * self.laws[0].modulus
        else:
            k_t = ratio * k
        if dt:
            self.viscous += float(np.sum((total - p) * rate)) * dt
            old = self.spring
            if not self.constant_spring:
                shrinks = (self.k_before > 0) & (k_t < self.k_before)
                old = old * np.where(shrinks, k_t / np.where(shrinks, self.k_before, 1.0), 1.0)
            new = np.where(touch, old - k_t * slip * dt, 0.0)
            limit = self.friction * total
            new = np.clip(new, -limit, limit)
            self.spring = new
            self.k_before = np.where(touch, k_t, 0.0)
        self.p = p
        force = total[:, None] * normal + self.spring[:, None] * tangent
        self.contact_forces = force
        self.normals = normal
        self.touching = touch
        f = np.zeros((n, 2))
        torque = np.zeros(n)
        np.add.at(f, self.i, force[pair])
        np.add.at(f, self.j, -force[pair])
        arm = r - np.where(pair, overlap / 2, overlap)  # up to a plane itself
        turn = -arm * self.spring
        np.add.at(torque, self.i, turn[pair])
        np.add.at(torque, self.j, turn[pair])
        on_plate = 0.0
        for m, which in enumerate(used):
            rows = slice(self.n_pairs + m * n, self.n_pairs + (m + 1) * n)
            f += force[rows]
            torque += turn[rows]
            if which == 3:
                on_plate = float(total[rows].sum())
        return f, torque, on_plate

    def run(self, end: float, every: int = 4) -> tuple[np.ndarray, np.ndarray]:
        """Advance to a time; return times (n_times,) and velocities (n_times, n, 2)."""
        f, torque, on_plate = self.forces(0.0)
        times = [0.0]
        speeds = [self.v.copy()]
        for step in range(1, round(end / self.dt) + 1):
            self.v += 0.5 * self.dt * f / self.mass
            self.omega += 0.5 * self.dt * torque / self.inertia
            self.speed -= 0.5 * self.dt * on_plate / self.plate_mass
            self.x = self.x + self.dt * self.v
            self.u += self.dt * self.speed
            f, torque, on_plate = self.forces(self.dt)
            self.v += 0.5 * self.dt * f / self.mass
            self.omega += 0.5 * self.dt * torque / self.inertia
            self.speed -= 0.5 * self.dt * on_plate / self.plate_mass
            if step % every == 0:
                times.append(step * self.dt)
                speeds.append(self.v.copy())
        return np.array(times), np.array(speeds)
