"""Independent solver for chains of spheres between walls or elastic bars, in numpy: for tests and
comparison only.

A chain is a row of nodes connected by links: beads by contacts, the nodes of a bar by linear
elements of lumped mass. Displacements point away from the loaded end, overlap of link i is ``u[i] -
u[i + 1] - gap[i]``, compression is positive.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from tests.helpers.twins.twin import LawTwin

NODES, WEIGHTS = np.polynomial.legendre.leggauss(48)
Impulse = Callable[[float], float]  # impulse up to a time, N s


@dataclass(frozen=True)
class Solid:
    """Properties of one body of a contact, SI units; ``strength`` None is elastic, ``radius`` None
    is a plane.
    """

    modulus: float = 115e9
    ratio: float = 0.3
    strength: float | None = None
    radius: float | None = None

    @property
    def compliance(self) -> float:
        """(1 - nu^2) / E, 1/Pa; 0 for a rigid wall."""
        return (1 - self.ratio**2) / self.modulus


@dataclass(frozen=True)
class Bead(Solid):
    """Sphere, of brass by default."""

    strength: float | None = 550e6
    radius: float = 4.76e-3
    density: float = 8500.0

    @property
    def mass(self) -> float:
        """Mass, kg."""
        return self.density * 4 / 3 * np.pi * self.radius**3


@dataclass(frozen=True)
class Bar(Solid):
    """Long elastic bar whose flat end touches a bead."""

    modulus: float = 200e9
    density: float = 8100.0
    area: float = 127e-6
    length: float = 5.0
    elements: int = 1000


RIGID = Solid(modulus=np.inf)
FIXED = "fixed"


def half_sine(peak: float, duration: float) -> Impulse:
    """Half-sine force P sin(pi t / T)."""
    return lambda t: (
        peak * duration / np.pi * (1 - np.cos(np.pi * min(max(t / duration, 0.0), 1.0)))
    )


def rectangle(force: float, duration: float) -> Impulse:
    """Constant force."""
    return lambda t: force * min(max(t, 0.0), duration)


def table(times: Sequence[float], forces: Sequence[float]) -> Impulse:
    """Force given at times (linear interpolation, zero outside)."""
    t = np.asarray(times, float)
    f = np.asarray(forces, float)
    total = np.concatenate([[0.0], np.cumsum(np.diff(t) * (f[1:] + f[:-1]) / 2)])

    def impulse(time: float) -> float:
        time = min(max(time, t[0]), t[-1])
        k = min(int(np.searchsorted(t, time, "right")) - 1, len(t) - 2)
        rest = time - t[k]
        return total[k] + rest * (f[k] + (f[k + 1] - f[k]) / (t[k + 1] - t[k]) * rest / 2)

    return impulse


class Hertz:
    """Elastic spheres."""

    def __init__(
        self, stiffness: np.ndarray, radius: np.ndarray, modulus: np.ndarray, strength: np.ndarray
    ) -> None:
        self.k = stiffness
        self.peak = np.zeros(len(stiffness))

    def force(self, overlap: np.ndarray) -> np.ndarray:
        """Return the forces at these overlaps, which become part of the history."""
        pressed = np.maximum(overlap, 0.0)
        np.maximum(self.peak, pressed, out=self.peak)
        return self.k * pressed * np.sqrt(pressed)

    def stored(self, overlap: np.ndarray) -> np.ndarray:
        """Elastic energy now, J."""
        return 0.4 * self.k * np.maximum(overlap, 0.0) ** 2.5

    def dissipated(self) -> np.ndarray:
        """Dissipated energy, J."""
        return np.zeros(len(self.k))


class Bilinear:
    """Bilinear law of Walton and Braun; ``beta`` is residual / largest overlap."""

    def __init__(
        self, stiffness, radius, modulus, strength, beta: float = 0.8, slope: float = 18.5
    ) -> None:
        self.k = slope * strength * radius
        self.beta = beta
        self.unloading = self.k / (1 - beta)
        self.peak = np.zeros(len(self.k))

    def force(self, overlap):
        """Return the forces at these overlaps, which become part of the history."""
        np.maximum(self.peak, overlap, out=self.peak)
        return self.unloading * np.maximum(overlap - self.beta * self.peak, 0.0)

    def stored(self, overlap):
        """Elastic energy now, J."""
        return 0.5 * self.unloading * np.maximum(overlap - self.beta * self.peak, 0.0) ** 2

    def dissipated(self):
        """Dissipated energy, J."""
        return 0.5 * self.k * self.beta * self.peak**2


class Elastoplastic(Hertz):
    """Hysteretic law, for all contacts at once, with the constants of ``LawTwin``."""

    def __init__(
        self, stiffness, radius, modulus, strength, variant: str = "continuous", factor: float = 1.6
    ) -> None:
        super().__init__(stiffness, radius, modulus, strength)
        self.law = LawTwin(variant, factor)
        self.yield_overlap = np.pi**2 / 4 * (factor * strength / modulus) ** 2 * radius
        with np.errstate(invalid="ignore"):
            self.yield_force = self.k * self.yield_overlap**1.5
        self.highest = np.zeros(len(self.k))  # largest normalized overlap, and derived quantities
        self.top, self.rest, self.exponent = np.zeros((3, len(self.k)))

    def loading(self, a: np.ndarray) -> np.ndarray:
        """Normalized force of plastic loading, a > 1."""
        law = self.law
        area = np.where(a < law.joint, a**law.c3, law.c4 * a - law.c5)
        return law.K * (law.c1 - (law.c1 - law.cy) * np.exp(-law.c2 * (a - 1))) * area

    def work(self, a: np.ndarray) -> np.ndarray:
        """Normalized work of loading, a >= 1, by Gauss quadrature up to and beyond the junction of
        the branches.
        """
        middle = np.minimum(a, self.law.joint)
        total = np.full(len(a), 0.4)
        for low, high in ((np.ones(len(a)), middle), (middle, a)):
            half = (high - low)[:, None] / 2
            points = (high + low)[:, None] / 2 + half * NODES
            total += (half * WEIGHTS * self.loading(points)).sum(axis=1)
        return total

    def _remember(self, k: np.ndarray, a: np.ndarray, force: np.ndarray) -> None:
        law = self.law
        self.highest[k] = a
        self.top[k] = force
        self.exponent[k] = law.n
        self.rest[k] = law.c6 * a - law.c7 + (law.c7 - law.c6) * np.exp(-law.c8 * (a - 1))
        young = k[a < 1.2]
        if law.continuous and len(young):
            a = self.highest[young]
            steep = self.top[young] * (a - self.rest[young]) / self.work(a) - 1
            self.exponent[young] = np.maximum(law.n, steep)

    def force(self, overlap):
        """Return the forces at these overlaps, which become part of the history."""
        force = super().force(overlap)
        (k,) = np.nonzero((self.peak > self.yield_overlap) & (overlap > 0))
        if len(k):
            a = overlap[k] / self.yield_overlap[k]
            new = a > self.highest[k]
            pushed = k[new]
            back = k[~new]
            if len(pushed):
                force[pushed] = self.loading(a[new])
                self._remember(pushed, a[new], force[pushed])
            rest = self.rest[back]
            share = np.maximum(a[~new] - rest, 0.0) / (self.highest[back] - rest)
            force[back] = self.top[back] * share ** self.exponent[back]
            force[k] *= self.yield_force[k]
        return force

    def stored(self, overlap):
        """Elastic energy now, J."""
        energy = super().stored(overlap)
        (k,) = np.nonzero(self.highest)
        width = self.highest[k] - self.rest[k]
        share = np.maximum(overlap[k] / self.yield_overlap[k] - self.rest[k], 0.0) / width
        n = self.exponent[k] + 1
        energy[k] = self.yield_force[k] * self.yield_overlap[k] * self.top[k] * width / n * share**n
        return energy

    def dissipated(self):
        """Dissipated energy, J."""
        energy = np.zeros(len(self.k))
        (k,) = np.nonzero(self.highest)
        back = self.top[k] * (self.highest[k] - self.rest[k]) / (self.exponent[k] + 1)
        energy[k] = (
            self.yield_force[k] * self.yield_overlap[k] * (self.work(self.highest[k]) - back)
        )
        return energy


LAWS = {"hertz": Hertz, "bilinear": Bilinear, "elastoplastic": Elastoplastic}


@dataclass
class Record:
    """Results of a run with ``n`` samples, SI units. Arrays of contacts are ordered along the
    chain.
    """

    times: np.ndarray  # (n,)
    velocities: np.ndarray  # (n, beads)
    forces: np.ndarray  # (n, contacts)
    displacements: np.ndarray  # (n, beads)
    peak_force: np.ndarray  # (contacts,), over every step
    peak_time: np.ndarray  # (contacts,)
    dissipated: np.ndarray  # (contacts,), at the end
    kinetic: np.ndarray  # (n,), of the beads
    stored: np.ndarray  # (n,), of the contacts
    lost: np.ndarray  # (n,)
    work: np.ndarray  # (n,), of the load and of initial velocities
    bar_energy: np.ndarray  # (n, 2), left and right bar
    bar_forces: tuple[np.ndarray, np.ndarray] = field(repr=False)  # (n, elements) each

    @property
    def balance(self) -> np.ndarray:
        """(n,) excess energy, as a fraction of the total input."""
        found = self.kinetic + self.stored + self.lost + self.bar_energy.sum(axis=1)
        return (found - self.work) / self.work[-1]


class Chain:
    """Beads in a row.

    Parameters
    ----------
    beads
        In order; a striker is the first bead.
    law
        "hertz", "bilinear" or "elastoplastic"; further keywords are its parameters.
    left, right
        None (free), "fixed" (the end bead is fixed), ``RIGID`` or a ``Solid`` (wall), or a ``Bar``.
    gap
        (contacts,) or number, m: initial gaps.
    """

    def __init__(
        self, beads: Sequence[Bead], law="hertz", left=None, right=None, gap=0.0, **constants
    ) -> None:
        bars = [end if isinstance(end, Bar) else None for end in (left, right)]
        self.walls = [
            end if isinstance(end, Solid) and not isinstance(end, Bar) else None
            for end in (left, right)
        ]
        sides = [self.walls[0] or bars[0], *beads, self.walls[1] or bars[1]]
        solids = [s for s in sides if s is not None]
        counts = [bar.elements if bar else 0 for bar in bars]
        elements = [
            np.full(n, b.modulus * b.area * n / b.length) if b else np.empty(0)
            for n, b in zip(counts, bars, strict=True)
        ]
        masses = []
        for bar, wall in zip(bars, self.walls, strict=True):
            lump = (
                np.full(bar.elements + 1, bar.density * bar.area * bar.length / bar.elements)
                if bar
                else np.empty(0)
            )
            lump[:1] /= 2
            lump[-1:] /= 2
            masses.append(np.array([np.inf]) if wall else lump)
        bead_mass = np.array([b.mass for b in beads])
        bead_mass[
            [k for k, end in ((0, left), (-1, right)) if isinstance(end, str) and end == FIXED]
        ] = np.inf
        self.mass = np.concatenate([masses[0], bead_mass, masses[1]])
        self.beads = slice(len(masses[0]), len(masses[0]) + len(beads))
        self.contacts = slice(counts[0], counts[0] + len(solids) - 1)
        self.left = slice(0, counts[0])
        self.right = slice(self.contacts.stop, None)
        self.elements = np.concatenate([elements[0], np.zeros(len(solids) - 1), elements[1]])
        self.gap = np.broadcast_to(np.asarray(gap, float), len(solids) - 1)

        pairs = list(pairwise(solids))
        modulus = np.array([1 / (p.compliance + q.compliance) for p, q in pairs])
        radius = np.array([1 / sum(1 / s.radius for s in pair if s.radius) for pair in pairs])
        strength = np.array([min(s.strength or np.inf for s in pair) for pair in pairs])
        self.law = LAWS[law](
            4 / 3 * modulus * np.sqrt(radius), radius, modulus, strength, **constants
        )

    def _forces(self, u: np.ndarray) -> np.ndarray:
        stretch = u[:-1] - u[1:]
        force = self.elements * stretch
        force[self.contacts] = self.law.force(stretch[self.contacts] - self.gap)
        return force

    def run(
        self,
        time: float,
        dt: float,
        load: Impulse | None = None,
        velocity: Mapping[int, float] | None = None,
        every: int | None = None,
        node: int | None = None,
    ) -> Record:
        """Integrate from rest (kick, drift, kick; the load acts with its exact impulse in every
        step).

        Parameters
        ----------
        time, dt
            Duration, s (round(time / dt) steps), and timestep, s.
        load
            Force on ``node`` (by default the first node: the first bead, or the free end of the
            left bar).
        velocity
            Initial velocity by bead, m/s.
        every
            Steps between samples (a thousand samples in all).
        """
        steps = round(time / dt)
        every = every or max(1, steps // 1000)
        u, v = np.zeros((2, len(self.mass)))
        node = node if node is not None else (self.beads.start if self.walls[0] else 0)
        for bead, speed in (velocity or {}).items():
            v[self.beads.start + bead] = speed
        half = dt / 2 / self.mass
        work = 0.5 * float(
            (self.mass[np.isfinite(self.mass)] * v[np.isfinite(self.mass)] ** 2).sum()
        )
        force = self._forces(u)
        peak = force.copy()
        peak_time = np.zeros(len(force))
        push = np.zeros(len(self.mass))
        samples: list[tuple] = [self._sample(0.0, u, v, force, work)]
        given = load(0.0) if load else 0.0
        for step in range(1, steps + 1):
            outer = 0.0
            if load:
                outer = (load(step * dt) - given) / dt
                given = load(step * dt)
            push[0] = -force[0]
            push[-1] = force[-1]
            np.subtract(force[:-1], force[1:], out=push[1:-1])
            push[node] += outer
            v += half * push
            moved = v[node] * dt
            u += dt * v
            force = self._forces(u)
            push[0] = -force[0]
            push[-1] = force[-1]
            np.subtract(force[:-1], force[1:], out=push[1:-1])
            push[node] += outer
            v += half * push
            work += outer * moved
            higher = force > peak
            if higher.any():
                peak[higher] = force[higher]
                peak_time[higher] = step * dt
            if step % every == 0 or step == steps:
                samples.append(self._sample(step * dt, u, v, force, work))
        columns = [np.array(column) for column in zip(*samples, strict=True)]
        (
            times,
            velocities,
            displacements,
            forces,
            kinetic,
            stored,
            lost,
            works,
            bar_energy,
            left,
            right,
        ) = columns
        return Record(
            times=times, velocities=velocities, forces=forces, displacements=displacements,
            peak_force=peak[self.contacts], peak_time=peak_time[self.contacts], dissipated=self.law.dissipated(),
            kinetic=kinetic, stored=stored, lost=lost, work=works, bar_energy=bar_energy, bar_forces=(left, right),
        )  # fmt: skip

    def _sample(self, time, u, v, force, work) -> tuple:
        energy = 0.5 * np.where(np.isfinite(self.mass), self.mass, 0.0) * v**2
        stretch = u[:-1] - u[1:]
        springs = 0.5 * self.elements * stretch**2
        bars = [energy[: self.beads.start].sum() + springs[self.left].sum()]
        bars.append(energy[self.beads.stop :].sum() + springs[self.right].sum())
        stored = self.law.stored(stretch[self.contacts] - self.gap).sum()
        return (
            time, v[self.beads].copy(), u[self.beads].copy(), force[self.contacts].copy(), energy[self.beads].sum(),
            stored, self.law.dissipated().sum(), work, bars, force[self.left].copy(), force[self.right].copy(),
        )  # fmt: skip
