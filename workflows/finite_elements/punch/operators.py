"""Operators of the one-point quadrilateral and lumped masses, from scikit-fem, and the stable timestep.

One quadrature point does not lock in plastic flow, as it imposes one incompressibility condition per element. The two
hourglass modes, which it does not see, are resisted by `hourglass_stiffness`. The radius at the centre of an element is
never zero, so that the axis needs no special treatment; for rectangles one point integrates the volume 2 pi r dr dz
exactly, and a field of equal radial and hoop stress is exactly in equilibrium. The mass is lumped with the same point,
a quarter of the element to each node; as forces are distributed alike, a plane wave stays plane up to the axis.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray
from skfem import Basis, ElementQuad1, LinearForm, MeshQuad

from granwave.workflows.finite_elements.punch.material import Elastoplastic
from granwave.workflows.finite_elements.punch.mesh import Line, Mesh

LINEAR_VISCOSITY, QUADRATIC_VISCOSITY = 0.06, 1.2
ONE_POINT = (np.array([[0.5], [0.5]]), np.array([1.0]))  # centre of the reference square, and its weight
HOURGLASS = 0.1  # fraction of the stiffness in `hourglass_stiffness`
_NEAR_STIFFEST = 0.7  # elements whose bound is below this fraction of the largest cannot limit the timestep
_SAFETY = 0.98  # timestep over the stability limit

Grid = NDArray[np.float64]


@dataclasses.dataclass(frozen=True, eq=False)
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

    br: Line
    bz: Line
    bt: Line
    area: Line
    height: Line
    length: Grid
    hourglass: Grid
    mass: Grid

    @property
    def volume(self) -> Grid:
        """Volume of each element, (n_z, n_r), m^3."""
        return np.outer(self.height, self.area)


def library_basis(mesh: Mesh) -> Basis:
    """Return scikit-fem's bilinear basis on the mesh, with one quadrature point."""
    return Basis(MeshQuad(mesh.nodes.T.copy(), mesh.elements.T.copy()), ElementQuad1(), quadrature=ONE_POINT)


def make_operators(mesh: Mesh, material: Elastoplastic) -> Operators:
    """Make the operators for a mesh and a material."""
    rows, columns = mesh.shape
    point = library_basis(mesh)
    gradient = np.abs(point.basis[0][0].grad[:, :, 0]).reshape(2, rows, columns)
    value = np.broadcast_to(np.asarray(point.basis[0][0])[..., 0], rows * columns).reshape(rows, columns)
    radius = np.asarray(point.global_coordinates())[0, :, 0].reshape(rows, columns)
    plane = point.dx[:, 0].reshape(rows, columns)
    height = 0.5 / gradient[1, :, 0]
    mass = LinearForm(lambda v, w: 2 * math.pi * material.density * w.x[0] * v).assemble(point)
    volume = 2 * math.pi * radius * plane
    squares = gradient[0] ** 2 + gradient[1] ** 2
    return Operators(
        br=gradient[0, 0].copy(),
        bz=gradient[1, :, 0].copy(),
        bt=(value / radius)[0].copy(),
        area=volume[0] / height[0],
        height=height,
        length=0.5 / gradient.max(axis=0),
        hourglass=hourglass_stiffness(volume, squares, material),
        mass=mass.reshape(rows + 1, columns + 1),
    )


def hourglass_stiffness(volume: Grid, squares: Grid, material: Elastoplastic) -> Grid:
    """Return the stiffness (N/m) for the amplitude q of an hourglass mode, u = q xi eta.

    Full integration would give ``(4/3) V [(lambda + 2 mu)/dr^2 + mu/dz^2]`` (r mode); the control takes the fraction
    `HOURGLASS` of ``(16/3) V (lambda + 2 mu) (br^2 + bz^2)`` (Flanagan and Belytschko 1981, stiffness form).
    """
    return HOURGLASS * 16 / 3 * volume * material.longitudinal_modulus * squares


def stable_timestep(operators: Operators, material: Elastoplastic) -> float:
    """Return a timestep below the stability limit of central differences, s.

    ``dt = (2/omega) (sqrt(1 + xi^2) - xi)`` with xi the share of critical damping that the linear bulk viscosity adds
    and omega the highest frequency of any single element, which bounds that of the mesh.
    """
    br, bz = np.meshgrid(operators.br, operators.bz)
    bt = np.broadcast_to(operators.bt, br.shape)
    near = br**2 + bz**2 >= _NEAR_STIFFEST**2 * (br**2 + bz**2).max()
    near[:, 0] |= br[:, 0] >= 0.5 * _NEAR_STIFFEST * br.max()
    on_axis = np.zeros_like(near)
    on_axis[:, 0] = True
    axis = on_axis[near]
    br, bz, bt = br[near], bz[near], bt[near]
    volume, hourglass = operators.volume[near], operators.hourglass[near]
    sr, sz, h = np.array([-1, 1, 1, -1.0]), np.array([-1, -1, 1, 1.0]), np.array([1, -1, 1, -1.0])
    strain = np.zeros((len(br), 4, 8))
    strain[:, 0, :4] = strain[:, 3, 4:] = br[:, None] * sr
    strain[:, 1, 4:] = strain[:, 3, :4] = bz[:, None] * sz
    strain[:, 2, :4] = bt[:, None]
    stiffness = volume[:, None, None] * np.einsum("eki,kl,elj->eij", strain, material.stiffness, strain, optimize=True)
    mode = np.outer(h, h) / 16 * hourglass[:, None, None]
    stiffness[:, :4, :4] += mode
    stiffness[:, 4:, 4:] += mode
    scale = np.repeat(2 / np.sqrt(material.density * volume)[:, None], 8, axis=1)  # for a quarter of the mass
    scale[np.ix_(axis, [0, 3])] = 0.0  # no radial motion on the axis
    scaled = stiffness * scale[:, :, None] * scale[:, None, :]
    omega = math.sqrt(np.linalg.eigvalsh(scaled)[:, -1].max())
    damping = math.sqrt(2) * LINEAR_VISCOSITY
    return _SAFETY * 2 / omega * (math.sqrt(1 + damping**2) - damping)
