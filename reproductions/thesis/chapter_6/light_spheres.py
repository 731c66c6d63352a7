"""Asymptotic theory of confined rows for light small spheres (thesis 6.3), with its equations
corrected.

Units: lengths by the distance of two beads, forces by k_bb, displacements by the amplitude A of the
wave (displacement of a bead by the wave). To order zero the small spheres follow the beads, and the
beads are a chain with a second, precompressed contact:

    k = (2 eta tan(theta)/gamma)^(2/3)
    eta_hat = n eta/[2 (1 + k tan(theta))]^1.5
    delta_hat = 2 delta tan(theta)/A
    w_i'' = F(w_(i-1) - w_i) - F(w_i - w_(i+1))
    F(r) = [r]^1.5 + eta_hat ([r + delta_hat]^1.5 - delta_hat^1.5)                       (6.13)

A travelling wave w(x - c tau) with the difference r(z) = w(z - 1/2) - w(z + 1/2) obeys c^2 r =
Lambda * F(r), with Lambda = sinc^2(k/2) in Fourier space; its integral gives c. To first order the
small spheres are oscillators that the wave drives:

    eps w_1'' + 3 eta sqrt(beta) w_1 = -w_0''
    eps u_1'' + 1.5 gamma sqrt(k beta) (1 + k tan(theta)) u_1 = -u_0''
    beta = (w_i - w_(i+1) + delta_hat)/(2 (1 + k tan(theta)))                      (6.16, 6.17)

The wave loses the energy that keeps oscillating behind it: n eps^3 (w_1'^2 + u_1'^2), divided by
the square of the largest velocity of the beads (6.18).
"""

import numpy as np
from confined_rows import K_BEADS
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares

# beads on either side of the crest, and grid points to a bead
HALF = 16
PER_BEAD = 32
ROUNDS = 3000
SETTLED = 1e-12
# for the series: beads from the crest within which the residual counts; it is negligible beyond
ENDS = 6.0
# beads; multiples of a bead's distance over which spheres are followed behind
REACH = HALF - 1.5
INSTANTS = 6001
TAIL = 30.0


class LightSpheres:
    """A row in the limit of light small spheres, by its parameters (6.8), with the wall of the
    thesis.
    """

    def __init__(self, rows):
        self.n, self.eps, self.eta, self.tangent = (
            getattr(rows, x)[0] for x in ("n", "eps", "eta", "tangent")
        )
        self.gamma = rows.k_thesis_wall[0] / K_BEADS
        self.k = (2 * self.eta * self.tangent / self.gamma) ** (2 / 3)
        self.soft = 1 + self.k * self.tangent
        # eta already contains cos^2.5(theta)
        self.eta_hat = self.n * self.eta / (2 * self.soft) ** 1.5

    def springs(self, r, delta_hat):
        """Axial and radial stiffness of a small sphere to first order, from the differences of the
        beads behind, here and ahead.
        """
        root = np.sqrt((r[1] + delta_hat) / (2 * self.soft))
        return [3 * self.eta * root, 1.5 * self.gamma * np.sqrt(self.k) * self.soft * root]


class PrintedSpheres(LightSpheres):
    """The asymptotic row with (6.13) and (6.17) as they are printed."""

    def __init__(self, rows):
        super().__init__(rows)
        self.eta_hat *= rows.cosine[0] ** 2.5

    def springs(self, r, delta_hat):
        """Axial and radial stiffness; the radial stiffness contains the differences of the small
        spheres.
        """
        axial, _ = super().springs(r, delta_hat)
        root = np.sqrt(((r[0] + r[2]) / 2 + delta_hat) / 2)
        return [axial, 1.5 * self.gamma * np.sqrt(self.k * self.soft) * root]


def series_at(z, coefficients):
    """Displacement / A: 1/(1 + exp(C1 z + C3 z^3 + ...)) (6.14)."""
    exponent = (coefficients * z[:, None] ** (2 * np.arange(len(coefficients)) + 1)).sum(axis=1)
    return 1 / (1 + np.exp(np.clip(exponent, -500.0, 500.0)))


class Travelling:
    """A wave of unit amplitude on the zeroth-order chain, and the small spheres of one gap that it
    drives from rest.

    ``time``: from the passage of the crest; ``axial``, ``radial``: velocities of the small spheres,
    in units of A divided by the unit of tau.
    """

    def __init__(self, limit, delta_hat):
        self.limit = limit
        self.delta_hat = delta_hat
        n = 2 * HALF * PER_BEAD
        z = (np.arange(n) - n // 2) / PER_BEAD
        kernel = np.sinc(np.fft.rfftfreq(n, 1 / PER_BEAD)) ** 2
        r = np.exp(-(z**2))
        r /= r.sum() / PER_BEAD
        for _ in range(ROUNDS):
            new = np.maximum(np.fft.irfft(kernel * np.fft.rfft(self.force(r)), n), 0.0)
            square = new.sum() / PER_BEAD
            change = np.abs(new / square - r).max()
            r = new / square
            if change < SETTLED:
                break
        self.speed = np.sqrt(square)
        self.difference = CubicSpline(z, r)
        self._drive()

    def force(self, r):
        """F(r), without the static part."""
        near = np.maximum(r, 0.0)
        loaded = np.maximum(r + self.delta_hat, 0.0)
        return near**1.5 + self.limit.eta_hat * (loaded**1.5 - self.delta_hat**1.5)

    def displacement(self, z):
        """Displacement, in units of A, of a bead at z from the crest in the lattice: the sum of the
        differences of all beads ahead.
        """
        ahead = z[:, None] + 0.5 + np.arange(2 * HALF)
        inside = np.abs(ahead) < HALF - 0.1
        return np.where(inside, self.difference(np.clip(ahead, -HALF, HALF - 0.1)), 0.0).sum(axis=1)

    def series(self):
        """C1, C3, C5 and the speed, by least squares of the residual of (6.13)."""
        z = np.linspace(-ENDS, ENDS, int(2 * ENDS * PER_BEAD) + 1)
        odd = np.array([1, 3, 5])

        def residual(values):
            found = values[:3]
            c = values[3]
            before, w, after = (series_at(one, found) for one in (z - 1, z, z + 1))
            slope = (odd * found * z[:, None] ** (odd - 1)).sum(axis=1)
            bend = (odd * (odd - 1) * found * z[:, None] ** np.maximum(odd - 2, 0)).sum(axis=1)
            second = w * (1 - w) * ((1 - 2 * w) * slope**2 - bend)
            return c * c * second - (self.force(before - w) - self.force(w - after))

        found = least_squares(
            residual, np.array([2.0, 0.1, 0.0, self.speed]), xtol=1e-13, ftol=1e-13
        ).x
        return found[:3], found[3]

    def _drive(self):
        """Integrate the small spheres, as oscillators of unit mass, by velocity Verlet."""
        limit = self.limit
        c = self.speed
        self.time = np.linspace(-(REACH - 1) / c, (REACH - 1 + TAIL) / c, INSTANTS)
        z = [
            shift - c * self.time for shift in (-1.0, 0.0, 1.0)
        ]  # differences of the beads behind, here and ahead
        r = [
            np.where(np.abs(one) < REACH, self.difference(np.clip(one, -REACH, REACH)), 0.0)
            for one in z
        ]
        f = [self.force(one) for one in r]
        drive = [-(f[0] - f[2]) / 2, -limit.k / (2 * limit.soft) * (f[0] - 2 * f[1] + f[2])]
        drive = np.array(drive) / limit.eps
        spring = np.array(limit.springs(r, self.delta_hat)) / limit.eps
        step = self.time[1] - self.time[0]
        found = np.zeros_like(drive)
        place = np.zeros(2)
        velocity = np.zeros(2)
        rate = drive[:, 0]
        for n in range(1, INSTANTS):
            velocity = velocity + 0.5 * step * rate
            place = place + step * velocity
            rate = drive[:, n] - spring[:, n] * place
            velocity = velocity + 0.5 * step * rate
            found[:, n] = velocity
        self.axial, self.radial = found
        self.tails = np.abs(found[:, self.time > REACH / c]).max(
            axis=1
        )  # largest ones behind the wave

    @property
    def largest(self):
        """Largest axial and radial velocity of the small spheres."""
        return np.abs(self.axial).max(), np.abs(self.radial).max()

    @property
    def largest_force(self):
        """Largest force of two beads in the wave."""
        return self.difference(np.linspace(-0.6, 0.6, 121)).max() ** 1.5

    @property
    def printed_decay(self):
        """Decay of the energy by (6.18) as it is printed."""
        return self.limit.eps**3 * (self.tails**2).sum()

    @property
    def energy_decay(self):
        """Decay of the wave's energy per bead (6.18)."""
        z = np.linspace(-4, 4, 1601)
        fastest = self.speed * np.abs(np.gradient(self.displacement(z), z)).max()
        return self.limit.n * self.limit.eps**3 * (self.tails**2).sum() / fastest**2
