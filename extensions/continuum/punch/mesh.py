"""Mesh of a block under a punch, and the cost of a run on it.

Its rectangles, a tensor product, grow in proportion to the distance from the punch's edge,

    h_r = s (L + |r - a|)        h_z = s (k L + z)        s = sqrt(I_r I_z / elements)

with L = `NEAR` times the radius a, k = `ASPECT` and ``I`` the integrals of ``s dx/h``: the number
``elements`` refines the whole mesh without changing its grading. The plastic zone begins at the
edge and grows from there, and the wavelength scales with the contact time, so every length scale
has the same fraction of elements. If an edge size is given, L follows from it.

The radius a of the contact area (`contact_end`) lies midway between two nodes, as the contact of a
mesh ends half an element beyond the last touching node. On the rounded edge it grows with the load,
on fine meshes by 26 µm at 4 m/s and 60 µm at 8 m/s (0.1 kg, taper 0.1 mm), on coarse ones node by
node. The stress under the edge needs finer elements, not another contact formulation: with forces
distributed over the segments between nodes (penalty, 1 to 8 points each) the scatter is the same.
Scatter of the dissipated fraction when nodes are shifted by fractions of an element:

    elements at the edge (um)      37      25      18
    0.1 kg, 8 m/s, scatter (%)     3.3     2.3     1.5
    0.1 kg, 4 m/s                  19      14      7

By default the elements there are 32 µm wide; finer ones reduce the timestep. Brass, D = 10 mm,
taper 0.1 mm, compared with 62 500 elements and 8 µm at the edge:

    kg, m/s     input    fraction dissipated        plastic volume (mm^3)
                         default  finer             default  finer
    0.1,  4      0.30    0.0142   0.0151  -6 %          5.2     5.0    5 %
    0.1,  6      0.68    0.0425   0.0421  0.9 %       30.8    30.2    2 %
    0.1,  8      1.22    0.0982   0.1003  -2 %          157     157    0 %
    0.2,  6      1.37    0.142    0.143  -0.9 %         247     245  0.5 %
    0.1, 12      2.74    0.296    0.298  -0.6 %         580     577  0.6 %
    0.1, 20      7.60    0.532    0.533  -0.2 %        1550    1505    3 %

With 16 000 elements, half and twice the hourglass stiffness change the fraction by 1 and -1.5 % and
the volume by -2 and 3 %; half and twice the bulk viscosity change the fraction by up to 1.4 and
-0.4 % and the volume by -3 and 0.6 %.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from granwave.extensions.continuum.frame import ElementPlan
from granwave.extensions.continuum.material import Elastoplastic
from granwave.extensions.continuum.punch.case import AUTO_END_TIME, ContinuumCase
from granwave.lammps_inputs.planning.schedule import check_steps

Line = NDArray[np.float64]

_ELEMENT_STEPS_PER_SECOND = 25e6  # measured on one core
_START = 1.0  # duration of set-up and results, s
_STEP_OVER_CROSSING = 0.95  # stable timestep / time of a wave through the thinnest element
_DISK_PER_ELEMENT = 400.0  # size of results with some 20 compressed snapshots, bytes
_DISK_BASE = 1e6  # size of results without elements, with figures, bytes
NEAR = 0.455  # L / contact radius
ASPECT = 2.5  # depth / width of the smallest elements
SPREAD = 3.25  # factor of the contact width on the rounded edge, see `contact_end`


@dataclasses.dataclass(frozen=True, eq=False)
class Mesh:
    """Rectangles between the lines ``r`` and ``z``; the impacted top is at z = 0, depth along +z.

    Attributes
    ----------
    r, z
        Node lines, (n_r + 1,) and (n_z + 1,), m.
    """

    r: Line
    z: Line

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of elements in depth and in radius."""
        return len(self.z) - 1, len(self.r) - 1

    @property
    def n_elements(self) -> int:
        """Number of elements."""
        return self.shape[0] * self.shape[1]

    @property
    def nodes(self) -> NDArray[np.float64]:
        """Coordinates (r, z) of the nodes, r fastest: (n_nodes, 2), m."""
        r, z = np.meshgrid(self.r, self.z)
        return np.column_stack([r.ravel(), z.ravel()])

    @property
    def elements(self) -> NDArray[np.int64]:
        """Nodes of the elements in cyclic order, elements with r fastest: (n_elements, 4)."""
        rows, columns = self.shape
        first = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
        return np.column_stack([first, first + 1, first + columns + 2, first + columns + 1])

    @property
    def centres(self) -> tuple[Line, Line]:
        """Radii (n_r,) and depths (n_z,) of the elements' centres, m."""
        return (self.r[1:] + self.r[:-1]) / 2, (self.z[1:] + self.z[:-1]) / 2


def block_mesh(
    radius: float, height: float, edge: float, elements: int, *, edge_size: float | None = None
) -> Mesh:
    """Make the mesh of a block under a punch.

    Parameters
    ----------
    radius, height
        Radius and height of the block, m.
    edge
        Contact radius, m; midway between two nodes.
    elements
        Approximate number of elements.
    edge_size
        Width of the elements at the edge instead of the default, m; too large a width gives equal
        elements.
    """

    def counts(near: float) -> tuple[float, float, float]:
        return (
            math.log1p(edge / near),
            math.log1p((radius - edge) / near),
            math.log1p(height / (ASPECT * near)),
        )

    def growth(near: float) -> float:
        inner, outer, deep = counts(near)
        return math.sqrt((inner + outer) * deep / elements)

    near = NEAR * edge
    if edge_size is not None:
        low = 1e-9 * radius
        high = 1e3 * radius
        for _ in range(100):
            near = math.sqrt(low * high)
            low, high = (low, near) if growth(near) * near > edge_size else (near, high)
    inner, outer, deep = counts(near)
    n_r = max(2, round((inner + outer) / growth(near)))
    n_z = max(1, round(elements / n_r))
    n_edge = min(max(1, round(inner / growth(near) + 0.5)), n_r - 1)
    inside = np.arange(n_edge) / (n_edge - 0.5)
    outside = np.arange(n_edge, n_r + 1) - n_edge + 0.5
    r = np.concatenate(
        [
            edge - near * np.expm1(inner * (1 - inside)),
            edge + near * np.expm1(outer * outside / outside[-1]),
        ]
    )
    z = ASPECT * near * np.expm1(deep * np.arange(n_z + 1) / n_z)
    r[0] = 0.0
    r[-1] = radius
    z[-1] = height
    return Mesh(r, z)


def punch_gap(mesh: Mesh, radius: float, taper: float) -> NDArray[np.float64]:
    """Return the gaps between punch and nodes of the top surface when the flat part is at the
    surface.

    The punch is flat up to ``radius - taper``, with an edge of radius ``taper`` beyond; only nodes
    below the punch, (n_nodes_below,), m.
    """
    r = mesh.r[mesh.r < radius]
    into = np.clip(r - (radius - taper), 0.0, taper)
    return taper - np.sqrt(taper**2 - into**2)


def contact_end(radius: float, taper: float, yield_strain: float) -> float:
    """Estimate the radius of the contact area while the block yields, m.

    Indentations scale with the yield strain ``sigma_y/E``, and the edge is a parabola of curvature
    1/taper, so that the contact extends ``SPREAD (radius (taper sigma_y/E)^2)^(1/3)`` beyond the
    flat part. This is not an effect of the mesh: with the same taper, materials of different
    ``sigma_y/E`` do not collapse on normalised axes near the onset of yield. On meshes with 5 µm at
    the edge (brass, taper 0.1 mm) the dissipated fraction changes by

        normalised input    0.30     1.22     2.74     7.60
        sigma_y/E times 1/4  3.7 %    4.7 %    2.2 %    0.6 %
                        1/2  1.4      2.5      1.2      0.2
                          2 -3.7     -2.7     -0.8     -0.1

    If ``taper sigma_y/E`` and the flat part are kept constant instead, 1/4 and 1/2 differ by less
    than 0.3 % at an input of 1.22.
    """
    beyond = SPREAD * (radius * (taper * yield_strain) ** 2) ** (1 / 3)
    return radius - taper + min(beyond, taper)


def mesh_of(case: ContinuumCase) -> Mesh:
    """Make the mesh of a case."""
    punch = case.punch
    run = case.run
    edge = None if isinstance(run.edge_size, str) else run.edge_size
    material = Elastoplastic.of(case.material)
    end = contact_end(
        punch.diameter / 2, punch.taper, material.yield_strength / material.youngs_modulus
    )
    return block_mesh(case.block.diameter / 2, case.block.height, end, run.elements, edge_size=edge)


def plan(case: ContinuumCase) -> ElementPlan:
    """Plan the run of a case; raise InputError if it has too many steps."""
    mesh = mesh_of(case)
    material = Elastoplastic.of(case.material)
    thinnest = min(np.diff(mesh.r).min(), np.diff(mesh.z).min())
    step = case.run.timestep
    if isinstance(step, str):
        step = _STEP_OVER_CROSSING * thinnest / material.longitudinal_speed
    check_steps(case.name, case.run.longest, step)
    n_steps = _expected_end(case) / step
    return ElementPlan(
        name=case.name,
        n_elements=mesh.n_elements,
        memory=case.memory,
        disk=_DISK_BASE + _DISK_PER_ELEMENT * mesh.n_elements,
        wall_time=_START + n_steps * mesh.n_elements / _ELEMENT_STEPS_PER_SECOND,
    )


def _expected_end(case: ContinuumCase) -> float:
    """Estimate the end time, s: rebound of a mass on an elastic half-space under a flat punch, with
    a margin.
    """
    if not isinstance(case.run.end_time, str):
        return case.run.end_time
    material = case.material
    stiffness = material.youngs_modulus / (1 - material.poisson_ratio**2) * case.punch.diameter
    return min(AUTO_END_TIME, 1e-5 + 1.3 * math.pi * math.sqrt(case.punch.mass / stiffness))
