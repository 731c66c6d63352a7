"""Beads in a row with a ring of n small spheres around each contact, in a tube (thesis 6.1): sizes,
balance, runs.

    d = 2 D tan^2(pi/n)            diameter of the small spheres, which touch two beads and both
                                   neighbours in the ring (6.2)
    rho = sqrt(d^2 + 2 d D)/2      radius of the ring
    Rc = rho + d/2                 radius of the tube
    tan(theta) = 2 rho/D           theta: angle between the axis and the line from a bead to a
    cos(theta) = D/(D + d)         small sphere
    eps = m_s/m_b,  eta = k_sb cos^2.5(theta)/k_bb,  gamma = k_w/k_bb                      (6.8)

All contacts follow Hertz's law, F = k alpha^1.5. The thesis uses k_w = 1.2 E sqrt(d/2)/(1 - nu^2)
(6.4), which is softer than a flat wall (4/3) and than the inside of the tube, whose contact is an
ellipse. It neglects the contacts in the ring, which push a sphere that has moved inwards by u back
outwards with the force 2 k_ss [2 u sin(pi/n)]^1.5 sin(pi/n).
"""

import dataclasses
from functools import cached_property

import numpy as np
from scipy.optimize import brentq

from granwave.measures import GrainRow, decay_rate
from granwave.theory import elliptic_radius

# m, kg/m^3, and E/(1 - nu^2) of brass, Pa
BEAD = 0.015
DENSITY = 8500.0
MODULUS = 115e9 / (1 - 0.30**2)
MASS = DENSITY * np.pi / 6 * BEAD**3
K_BEADS = 4 / 3 * MODULUS / 2 * np.sqrt(BEAD / 4)  # N/m^1.5
FORCE = MODULUS / 2 * (BEAD / 4) ** 2  # E* R*^2, N
TIME = np.sqrt(
    MASS / K_BEADS
)  # factor by which the thesis divides times in SI, s; its dimension is s m^(-1/4)
VELOCITY = BEAD / TIME  # factor by which it divides velocities
WHERE = "equations of symmetric motion"


@dataclasses.dataclass(eq=False)
class Rows:
    """Rows in which all bodies just touch: number of small spheres per ring, their diameter, radius
    of the tube, and its reduction.

    Arrays have one value per row, in SI units; rows with a fractional ``n`` exist only in the
    equations.
    """

    n: np.ndarray
    small: np.ndarray
    tube: np.ndarray
    shrinks: np.ndarray
    density: np.ndarray  # density of the small spheres

    @classmethod
    def fitting(cls, n, a=0.0):
        """Rows of one material in which all touch, and their precompressions a = 2 delta/D."""
        n, a = np.broadcast_arrays(np.atleast_1d(np.asarray(n, dtype=float)), a)
        small = 2 * BEAD * np.tan(np.pi / n) ** 2
        tube = np.sqrt(small**2 + 2 * small * BEAD) / 2 + small / 2
        return cls(n, small, tube, a * BEAD / 2, np.full(n.shape, DENSITY))

    def part(self, which):
        """Some of the rows."""
        return Rows(*(getattr(self, field.name)[which] for field in dataclasses.fields(self)))

    def __post_init__(self):
        """Compute sizes, masses and constants of the contacts, N/m^1.5."""
        self.ring = self.tube - self.small / 2
        self.tangent, self.cosine = 2 * self.ring / BEAD, BEAD / (BEAD + self.small)
        self.chord = np.sin(np.pi / self.n)
        self.mass = self.density * np.pi / 6 * self.small**3
        self.k_side = 4 / 3 * MODULUS / 2 * np.sqrt(BEAD * self.small / 2 / (BEAD + self.small))
        self.k_ring = 4 / 3 * MODULUS / 2 * np.sqrt(self.small / 4)
        radius = elliptic_radius(2 / self.small, 2 / self.small - 1 / (self.tube - self.shrinks))
        self.k_wall, self.k_thesis_wall = (
            4 / 3 * MODULUS * np.sqrt(radius),
            1.2 * MODULUS * np.sqrt(self.small / 2),
        )
        self.eps, self.eta = self.mass / MASS, self.k_side * self.cosine**2.5 / K_BEADS

    def from_ring(self, inward):
        """Force on a small sphere that is displaced inwards by its neighbours in the ring, N."""
        return 2 * self.k_ring * (2 * inward * self.chord) ** 1.5 * self.chord

    def outward(self, inward):
        """Force on small spheres that are displaced inwards, in an undisturbed row, N."""
        across = self.ring - inward
        apart = np.hypot(across, BEAD / 2)
        overlap = np.maximum((BEAD + self.small) / 2 - apart, 0.0)
        wall = self.k_wall * np.maximum(self.shrinks - inward, 0.0) ** 1.5
        return 2 * self.k_side * overlap**1.5 * across / apart + self.from_ring(inward) - wall

    @cached_property
    def inward(self):
        """Inward displacement of the small spheres at equilibrium, m."""
        one = [self.part([k]) for k in range(len(self.n))]
        return np.array([
            brentq(lambda u, row: row.outward(u)[0], 0.0, row.shrinks[0], args=(row,), xtol=1e-18)
            if row.shrinks[0] else 0.0 for row in one
        ])  # fmt: skip


class ConfinedRun(GrainRow):
    """A run of a confined row with an impacted bead."""

    def __init__(self, run):
        super().__init__(run)
        one = int(self.beside[0])
        stage = self.case.precompression
        values = (
            len(self.beside) / (len(self.ids) - 1), self.assembly.diameter_of(one), self.case.boundary.sides_tube,
            stage.tube if stage else 0.0, self.assembly.material_of(one).density,
        )  # fmt: skip
        self.rows = Rows(*(np.array([value]) for value in values))
        self.n, self.a, self.impact = int(values[0]), 2 * values[3] / BEAD, self.load.velocity
        self.label = f"n = {self.n}, a = {self.a:.3g}"
        self.peaks, self.times = (
            self.of_contacts(name)[: self.passed] for name in ("peak_force", "time_peak")
        )
        self.speed, self.decay = speed_of(self.times), decay_of(self.peaks)

    @property
    def profile(self):
        """Contacts that the wave has passed, and their largest forces / (E* R*^2)."""
        return np.arange(self.struck, self.passed + 1.0), self.peaks[self.struck - 1 :] / FORCE

    def probe(self, bead, quantity):
        """Time (s) and a recorded quantity of a bead, such as ``vz``."""
        return self.array("probes/time"), self.array(
            f"probes/sphere_{self.ids[bead - 1]}_{quantity}"
        )


def speed_of(times):
    """Speed of a wave from contact 40 to 190, or to the last contact that it has passed, m/s."""
    last = min(190, len(times))
    return (last - 40) * BEAD / (times[last - 1] - times[39]) if last >= 60 else np.nan


def decay_of(peaks):
    """Decay per contact between 60 and 200, or the last contact that the wave has passed."""
    contacts = np.arange(60, min(200, len(peaks)) + 1)
    return decay_rate(contacts, peaks[contacts - 1]) if len(contacts) else np.nan


def together(runs):
    """Rows of several runs."""
    return Rows(
        *(
            np.concatenate([getattr(run.rows, one.name) for run in runs])
            for one in dataclasses.fields(Rows)
        )
    )
