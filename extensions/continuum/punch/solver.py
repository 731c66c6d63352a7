"""Explicit solver: central differences with lumped masses on an axisymmetric block.

    v(n+1/2) = v(n-1/2) + dt (f_contact - f_internal(n))/m        u(n+1) = u(n) + dt v(n+1/2)

The operators of the one-point quadrilateral and the lumped masses are those of scikit-fem. One
quadrature point does not lock in plastic flow, as it imposes one incompressibility condition per
element. The two hourglass modes, to which it is insensitive, are resisted by `hourglass_stiffness`.
The radius at the centre of an element is never zero, so that the axis needs no special treatment;
for rectangles one point integrates the volume 2 pi r dr dz exactly, and a field of equal radial and
hoop stress is exactly in equilibrium. The mass is lumped with the same point, a quarter of the
element to each node. Because forces are distributed in the same way, a plane wave stays plane up to
the axis.

All energies are computed independently, so that their sum checks the solution: elastic from the
stresses, plastic from stress times plastic strain increment, viscous and contact dissipation from
their work, kinetic at whole steps.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from skfem import Basis, ElementQuad1, LinearForm, MeshQuad

from granwave.extensions.continuum.material import (
    LINEAR_VISCOSITY,
    N_STATE,
    Elastoplastic,
    hourglass_stiffness,
    von_mises,
)
from granwave.extensions.continuum.punch import kernels
from granwave.extensions.continuum.punch.mesh import Mesh

QUADRATIC_VISCOSITY = 1.2
ONE_POINT = (
    np.array([[0.5], [0.5]]),
    np.array([1.0]),
)  # centre of the reference square, and its weight
# elements whose bound is below this fraction of the largest cannot limit the timestep
_NEAR_STIFFEST = 0.7
_SAFETY = 0.98  # timestep over the stability limit

Grid = NDArray[np.float64]
AT_YIELD = 0.99  # von Mises stress over yield strength from which on an element counts as at yield


class Operators:
    """Arrays of the mesh and the material for the inner loops.

    Attributes
    ----------
    br, bz, bt
        |dN/dr| (n_r,), |dN/dz| (n_z,) and N/r (n_r,) at the elements' centres, 1/m.
    area, height
        2 pi r dr (n_r,) in m^2 and dz (n_z,) in m: the volume of an element is their product.
    length
        Shorter side of each element, (n_z, n_r), m.
    hourglass
        Stiffness of the hourglass modes, (n_z, n_r), N/m.
    mass
        Lumped nodal masses, (n_z + 1, n_r + 1), kg.
    """

    def __init__(self, mesh: Mesh, material: Elastoplastic) -> None:
        rows, columns = mesh.shape
        point = library_basis(mesh)
        gradient = np.abs(point.basis[0][0].grad[:, :, 0]).reshape(2, rows, columns)
        value = np.broadcast_to(np.asarray(point.basis[0][0])[..., 0], rows * columns).reshape(
            rows, columns
        )
        radius = np.asarray(point.global_coordinates())[0, :, 0].reshape(rows, columns)
        volume = 2 * math.pi * radius * point.dx[:, 0].reshape(rows, columns)
        mass = LinearForm(lambda v, w: 2 * math.pi * material.density * w.x[0] * v).assemble(point)
        self.br = gradient[0, 0].copy()
        self.bz = gradient[1, :, 0].copy()
        self.bt = (value / radius)[0].copy()
        self.height = 0.5 / gradient[1, :, 0]
        self.area = volume[0] / self.height[0]
        self.length = 0.5 / gradient.max(axis=0)
        self.hourglass = hourglass_stiffness(volume, gradient[0] ** 2 + gradient[1] ** 2, material)
        self.mass = mass.reshape(rows + 1, columns + 1)

    @property
    def volume(self) -> Grid:
        """Volume of each element, (n_z, n_r), m^3."""
        return np.outer(self.height, self.area)


def library_basis(mesh: Mesh) -> Basis:
    """Return scikit-fem's bilinear basis on the mesh, with one quadrature point."""
    return Basis(
        MeshQuad(mesh.nodes.T.copy(), mesh.elements.T.copy()), ElementQuad1(), quadrature=ONE_POINT
    )


def stable_timestep(operators: Operators, material: Elastoplastic) -> float:
    """Return a timestep below the stability limit of central differences, s.

    ``dt = (2/omega) (sqrt(1 + xi^2) - xi)`` with xi the fraction of critical damping that the
    linear bulk viscosity adds and omega the highest frequency of any single element, which bounds
    the highest frequency of the mesh.
    """
    br, bz = np.meshgrid(operators.br, operators.bz)
    bt = np.broadcast_to(operators.bt, br.shape)
    near = br**2 + bz**2 >= _NEAR_STIFFEST**2 * (br**2 + bz**2).max()
    near[:, 0] |= br[:, 0] >= 0.5 * _NEAR_STIFFEST * br.max()
    on_axis = np.zeros_like(near)
    on_axis[:, 0] = True
    axis = on_axis[near]
    br = br[near]
    bz = bz[near]
    bt = bt[near]
    volume = operators.volume[near]
    hourglass = operators.hourglass[near]
    sr = np.array([-1, 1, 1, -1.0])
    sz = np.array([-1, -1, 1, 1.0])
    h = np.array([1, -1, 1, -1.0])
    strain = np.zeros((len(br), 4, 8))
    strain[:, 0, :4] = strain[:, 3, 4:] = br[:, None] * sr
    strain[:, 1, 4:] = strain[:, 3, :4] = bz[:, None] * sz
    strain[:, 2, :4] = bt[:, None]
    stiffness = volume[:, None, None] * np.einsum(
        "eki,kl,elj->eij", strain, material.stiffness, strain, optimize=True
    )
    mode = np.outer(h, h) / 16 * hourglass[:, None, None]
    stiffness[:, :4, :4] += mode
    stiffness[:, 4:, 4:] += mode
    scale = np.repeat(
        2 / np.sqrt(material.density * volume)[:, None], 8, axis=1
    )  # a quarter of the mass
    scale[np.ix_(axis, [0, 3])] = 0.0  # no radial motion on the axis
    scaled = stiffness * scale[:, :, None] * scale[:, None, :]
    omega = math.sqrt(np.linalg.eigvalsh(scaled)[:, -1].max())
    damping = math.sqrt(2) * LINEAR_VISCOSITY
    return _SAFETY * 2 / omega * (math.sqrt(1 + damping**2) - damping)


class PunchSolver:
    """Block impacted by a rigid punch.

    Parameters
    ----------
    gap
        Gaps between the nodes of the top, from the axis outwards, and the punch, m; only nodes that
        it can touch.
    punch_mass, punch_velocity
        Mass of the punch, kg, and initial velocity along +z, into the block, m/s.
    sides
        ``free``, or ``roller`` for no radial motion.
    bottom
        ``fixed`` or ``free``.
    timestep
        Timestep, s; by default the stable timestep.
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
        self.mesh = mesh
        self.material = material
        self.operators = Operators(mesh, material)
        self.timestep = stable_timestep(self.operators, material) if timestep is None else timestep
        self.n_steps = 0
        self._recorded = (0.0, 0.0)  # time, s, and impulse of the punch, N s, of the last instant
        rows, columns = mesh.shape
        self.state = np.zeros((rows, columns, N_STATE))
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
        of = self.operators
        self._tables = (of.br, of.bz, of.bt, of.area, of.height)
        self._fields = (of.length, of.hourglass)
        lam, mu = material.lame
        damping = LINEAR_VISCOSITY * material.density * material.longitudinal_speed
        quadratic = QUADRATIC_VISCOSITY**2 * material.density
        self._constants = (lam, mu, material.yield_strength, damping, quadratic)

    @property
    def n_elements(self) -> int:
        """Number of elements."""
        return self.mesh.n_elements

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
        return von_mises(self.state)

    def set_velocity(self, radial: NDArray[np.float64], axial: NDArray[np.float64]) -> None:
        """Set the velocities of the nodes, (n_z + 1, n_r + 1), m/s; fixed nodes stay at rest."""
        self.motion[2] = np.where(self._mobility[0] > 0, radial, 0.0)
        self.motion[3] = np.where(self._mobility[1] > 0, axial, 0.0)

    def advance(self, n_steps: int) -> dict[str, float]:
        """Take ``n_steps`` (one or more); return the instant before them.

        Returns
        -------
        dict
            Time (s), energies and their ``total`` (J), volumes (m^3), largest strain and state of
            the punch, by name.
        """
        elastic, plastic, now, ever, strain = kernels.measure(
            self.state, self._tables, self._constants, AT_YIELD, self.ever
        )
        time = self.time
        tally = self._tally
        viscous = tally[kernels.VISCOUS]
        hourglass = tally[kernels.HOURGLASS]
        place = tally[kernels.PUNCH_Z]
        speed = tally[kernels.PUNCH_V]
        force = self._mean_force()
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
        energies = {
            "kinetic": tally[kernels.KINETIC],
            "elastic": elastic,
            "hourglass": hourglass,
            "punch": tally[kernels.PUNCH_KINETIC],
            "plastic": plastic,
            "viscous": viscous,
            "contact": tally[kernels.CONTACT_NOW],
        }
        return energies | {
            "time": time,
            "total": sum(energies.values()),
            "plastic_volume": now,
            "plastic_volume_ever": ever,
            "largest_strain": strain,
            "punch_displacement": place,
            "punch_velocity": speed,
            "contact_force": force,
        }

    def _mean_force(self) -> float:
        """Return the mean force on the punch since the last instant, N; 0 at the first.

        The force of a single step is an impulse of the nodes that the punch reaches in this step,
        and depends on the mesh.
        """
        before, given = self._recorded
        impulse = float(self._tally[kernels.IMPULSE])
        self._recorded = (self.time, impulse)
        return (impulse - given) / (self.time - before) if self.time > before else 0.0

    def look(self) -> dict[str, float]:
        """Return the present instant, without advancing."""
        kept = [part.copy() for part in (self.motion, self.state, self._tally)]
        instant = self.advance(1)
        self.n_steps -= 1
        self.motion[:], self.state[:], self._tally[:] = kept
        return instant

    def every(self, interval: float) -> int:
        """Return the largest number of steps in ``interval`` (s), at least one."""
        return max(1, math.floor(interval / self.timestep))
