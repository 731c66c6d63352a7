"""Explicit solver: central differences with lumped masses on an axisymmetric block.

    v(n+1/2) = v(n-1/2) + dt (f_contact - f_internal(n))/m        u(n+1) = u(n) + dt v(n+1/2)

All energies are computed independently, so that their sum checks the solution: elastic from the stresses, plastic from
stress times plastic strain increment, viscous and contact losses from their work, kinetic at whole steps.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from granwave.workflows.finite_elements.punch import kernels
from granwave.workflows.finite_elements.punch.material import Elastoplastic
from granwave.workflows.finite_elements.punch.mesh import Mesh
from granwave.workflows.finite_elements.punch.operators import (
    LINEAR_VISCOSITY,
    QUADRATIC_VISCOSITY,
    make_operators,
    stable_timestep,
)

AT_YIELD = 0.99  # von Mises stress over yield strength from which on an element counts as at yield


@dataclasses.dataclass(frozen=True)
class Instant:
    """Energies (J), volumes (m^3) and state of the punch at one time (s)."""

    time: float
    kinetic: float
    elastic: float
    plastic: float
    viscous: float
    hourglass: float
    contact: float
    punch: float
    plastic_volume: float
    plastic_volume_ever: float
    largest_strain: float
    punch_displacement: float
    punch_velocity: float
    contact_force: float

    @property
    def total(self) -> float:
        """Sum of all energies, J."""
        stored = self.kinetic + self.elastic + self.hourglass + self.punch
        return stored + self.plastic + self.viscous + self.contact


class Solver:
    """Block struck by a rigid punch.

    Parameters
    ----------
    gap
        Gaps between the nodes of the top, from the axis outwards, and the punch, m; only nodes that it can touch.
    punch_mass, punch_velocity
        Mass of the punch, kg, and initial velocity along +z, into the block, m/s.
    sides
        ``free``, or ``roller`` for no radial motion.
    bottom
        ``fixed`` or ``free``.
    timestep
        Timestep, s; by default the stable one.
    """

    def __init__(
        self,
        mesh: Mesh,
        material: Elastoplastic,
        *,
        gap: NDArray[np.float64] | None = None,
        punch_mass: float = 1.0,
        punch_velocity: float = 0.0,
        sides: str = "free",
        bottom: str = "fixed",
        timestep: float | None = None,
    ) -> None:
        self.mesh, self.material = mesh, material
        self.operators = make_operators(mesh, material)
        self.timestep = stable_timestep(self.operators, material) if timestep is None else timestep
        self.n_steps = 0
        rows, columns = mesh.shape
        self.state = np.zeros((rows, columns, kernels.N_STATE))
        self.motion = np.zeros((6, rows + 1, columns + 1))
        self.ever = np.zeros((rows, columns), dtype=bool)
        self._gap = np.zeros(0) if gap is None else gap
        self._punch_mass = punch_mass
        self._tally = np.zeros(kernels.N_TALLY)
        self._tally[kernels.PUNCH_V] = punch_velocity
        self._mobility = np.stack([1 / self.operators.mass] * 2)
        self._mobility[0, :, 0] = 0.0
        if bottom == "fixed":
            self._mobility[:, -1] = 0.0
        if sides == "roller":
            self._mobility[0, :, -1] = 0.0
        self._tables = tuple(getattr(self.operators, name) for name in ("br", "bz", "bt", "area", "height"))
        self._fields = (self.operators.length, self.operators.hourglass)
        lam, mu = material.lame
        damping = LINEAR_VISCOSITY * material.density * material.longitudinal_speed
        quadratic = QUADRATIC_VISCOSITY**2 * material.density
        self._constants = (lam, mu, material.yield_strength, damping, quadratic)

    @property
    def time(self) -> float:
        """Time, s."""
        return self.n_steps * self.timestep

    @property
    def touches(self) -> int:
        """Number of steps so far in which the punch touched the block."""
        return int(self._tally[kernels.TOUCHED])

    @property
    def von_mises(self) -> NDArray[np.float64]:
        """Von Mises stresses, (n_z, n_r), Pa."""
        rr, zz, tt, rz = np.moveaxis(self.state[:, :, :4], 2, 0)
        return np.sqrt(0.5 * ((rr - zz) ** 2 + (zz - tt) ** 2 + (tt - rr) ** 2) + 3 * rz**2)

    def set_velocity(self, radial: NDArray[np.float64], axial: NDArray[np.float64]) -> None:
        """Set the velocities of the nodes, (n_z + 1, n_r + 1), m/s; fixed nodes stay at rest."""
        self.motion[2] = np.where(self._mobility[0] > 0, radial, 0.0)
        self.motion[3] = np.where(self._mobility[1] > 0, axial, 0.0)

    def advance(self, n_steps: int) -> Instant:
        """Take ``n_steps`` (one or more); return the instant before them."""
        elastic, plastic, now, ever, strain = kernels.measure(
            self.state, self._tables, self._constants, AT_YIELD, self.ever
        )
        time, tally = self.time, self._tally
        viscous, hourglass = tally[kernels.VISCOUS], tally[kernels.HOURGLASS]
        place, speed, force = tally[kernels.PUNCH_Z], tally[kernels.PUNCH_V], tally[kernels.FORCE]
        kernels.advance(
            n_steps,
            self.motion,
            self.operators.mass,
            self._mobility,
            self._gap,
            self._punch_mass,
            tally,
            self.state,
            self._tables,
            self._fields,
            self._constants,
            self.timestep,
        )
        self.n_steps += n_steps
        return Instant(
            time=time,
            kinetic=tally[kernels.KINETIC],
            elastic=elastic,
            plastic=plastic,
            viscous=viscous,
            hourglass=hourglass,
            contact=tally[kernels.CONTACT_NOW],
            punch=tally[kernels.PUNCH_KINETIC],
            plastic_volume=now,
            plastic_volume_ever=ever,
            largest_strain=strain,
            punch_displacement=place,
            punch_velocity=speed,
            contact_force=force,
        )

    def look(self) -> Instant:
        """Return the present instant, without advancing."""
        kept = [part.copy() for part in (self.motion, self.state, self._tally)]
        instant = self.advance(1)
        self.n_steps -= 1
        self.motion[:], self.state[:], self._tally[:] = kept
        return instant

    def every(self, interval: float) -> int:
        """Return the largest number of steps in ``interval`` (s), at least one."""
        return max(1, math.floor(interval / self.timestep))
