"""Mesh of a half-sphere, squares at the contact point surrounded by rings that grow with distance,
and a run's cost.

A block of ``n`` by ``n`` equal squares covers the initial contact. Around it are rings of ``2 n``
elements, each ring thicker by the same factor, so that elements stay about square and the contact
radius is resolved by the same number of elements (``4 n/pi``) at any size. The last ring ends at
the flat face.

Coordinates: r from the axis, z from the contact point (0) to the flat face (R). With ``phi`` the
arc from the contact point divided by R and ``theta`` the angle from the surface (0) to the axis
(pi/2),

    r = R sin(phi) c      z = S + (A - S) s      S = R (1 - cos phi)      A = R (phi + k phi^2),  A(pi/2) = R

where ``c, s`` change from cos, sin near the contact to linear functions at the face; theta = 0 is
exactly the sphere.
"""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
from numpy.typing import NDArray

from granwave.extensions.continuum.frame import ElementPlan
from granwave.extensions.continuum.sphere_contact.case import SphereContactCase
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.planning.schedule import MOST_STEPS

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

# times n, at speed 1
STEPS_PER_E_FOLD = 600
STEPS_PER_UNLOADING = 300
# times n, over n, times n
SMOOTHING = 40
DAMPING = 0.1
MEMORY = 20
_CORE = 3.0  # size of the mesh's finest part / contact radius at first yield
START = 0.3  # overlap over alpha_y below which the loading rate is about constant
_ELEMENT_STEPS_PER_SECOND = 18e6  # measured on one core
_BEGINNING = 2.0  # duration of set-up, results and figures, s
_TURNS = 5.2  # steps of the changes of rate in a cycle / `SMOOTHING`
_DISK_PER_ELEMENT = 100.0  # size of results, bytes
_DISK_BASE = 4e6  # size of history and figures, bytes
_QUARTER = math.pi / 2
_CLOSING = (1 - _QUARTER) / _QUARTER**2  # k above
_ROUNDING = math.log(4.0)  # rings turn from squares to circles within a factor of 4 of the distance
_FAR = 1.0  # distance over R beyond which rings grow faster than the width of their elements
_SAMPLES = 4000


@dataclasses.dataclass(frozen=True, eq=False)
class HalfSphere:
    """Quadrilaterals of a half-sphere, in the (r, z) plane.

    Attributes
    ----------
    radius
        Radius of the sphere, m.
    nodes
        Coordinates (r, z) of the nodes: (n_nodes, 2), m.
    elements
        Nodes of the elements in anticlockwise order: (n_elements, 4).
    surface
        Nodes of the curved surface, from the contact point to the rim.
    axis, face
        Nodes with r = 0, and with z = R.
    """

    radius: float
    nodes: Array
    elements: Indices
    surface: Indices
    axis: Indices
    face: Indices


def half_sphere(radius: float, core: float, n: int) -> HalfSphere:
    """Make the mesh with ``n`` squares on the length ``core`` (m) at the contact point."""
    ticks = np.arange(n + 1)
    x, y = np.meshgrid(ticks * core / n, ticks * core / n, indexing="ij")
    nodes = [_place(radius, x.ravel(), y.ravel())]
    around = np.arange(2 * n + 1)
    right = around <= n
    square = np.where(
        right, [np.ones_like(around), around / n], [(2 * n - around) / n, np.ones_like(around)]
    )
    angle = around * _QUARTER / (2 * n)
    circle = np.array([np.cos(angle), np.sin(angle)])
    circle[1, 0] = circle[0, -1] = 0.0
    distances = _rings(radius, core, n)
    rings = [np.where(right, n * (n + 1) + around, (2 * n - around) * (n + 1) + n)]
    for distance in distances[1:]:
        share = np.clip(math.log(distance / core) / _ROUNDING, 0, 1)
        share = share * share * (3 - 2 * share)
        ring = distance * ((1 - share) * square + share * circle)
        rings.append(sum(len(part) for part in nodes) + around)
        nodes.append(_place(radius, *ring))
    corner = (ticks[:-1, None] * (n + 1) + ticks[:-1]).ravel()
    elements = [np.column_stack([corner, corner + n + 1, corner + n + 2, corner + 1])]
    for inner, outer in itertools.pairwise(rings):
        elements.append(np.column_stack([inner[:-1], outer[:-1], outer[1:], inner[1:]]))
    return HalfSphere(
        radius=radius,
        nodes=np.concatenate(nodes),
        elements=np.concatenate(elements),
        surface=np.concatenate([ticks * (n + 1), [ring[0] for ring in rings[1:]]]),
        axis=np.concatenate([ticks, [ring[-1] for ring in rings[1:]]]),
        face=rings[-1],
    )


def core_size(case: SphereContactCase) -> float:
    """Return the size of the finest part of the mesh, m."""
    radius = math.sqrt(case.law.effective_radius * min(case.yield_unit, case.max_overlap / 4))
    return min(_CORE * radius, 0.2 * min(case.radii))


def squares(case: SphereContactCase) -> int:
    """Return the ``n`` of the mesh, at least 4."""
    radii = case.radii[:1] if case.identical else case.radii
    core = core_size(case)
    n = 4
    while (
        sum((n + 1) ** 2 + 2 * (n + 1) * _n_rings(radius, core, n + 1) for radius in radii)
        <= case.run.elements
    ):
        n += 1
    return n


def _place(radius: float, x: Array, y: Array) -> Array:
    """Map points at distance x along a flat surface and depth y to (r, z) in the half-sphere."""
    phi = np.hypot(x, y) / radius
    theta = np.arctan2(y, x)
    straight = (phi / _QUARTER) ** 2
    part = theta / _QUARTER
    across = (1 - straight) * np.cos(theta) + straight * (1 - part)
    inward = (1 - straight) * np.sin(theta) + straight * part
    surface = 1 - np.cos(phi)
    r = np.where(x == 0, 0.0, np.sin(phi) * across)
    return radius * np.column_stack([r, surface + (phi + _CLOSING * phi**2 - surface) * inward])


def _counted(radius: float, core: float, n: int) -> tuple[Array, Array]:
    """Return distances along the surface from the core to the rim, and the number of rings up to
    each distance.
    """
    distance = np.geomspace(core, _QUARTER * radius, _SAMPLES)
    # rings per unit of ln(distance)
    density = 2 * n / _QUARTER / (1 + (distance / (_FAR * radius)) ** 2)
    steps = 0.5 * (density[1:] + density[:-1]) * np.diff(np.log(distance))
    return distance, np.concatenate([[0.0], np.cumsum(steps)])


def _n_rings(radius: float, core: float, n: int) -> int:
    return max(1, round(_counted(radius, core, n)[1][-1]))


def _rings(radius: float, core: float, n: int) -> Array:
    distance, count = _counted(radius, core, n)
    number = _n_rings(radius, core, n)
    rings = np.interp(np.arange(number + 1) * count[-1] / number, count, distance)
    rings[0] = core
    rings[-1] = _QUARTER * radius
    return rings


def plan(case: SphereContactCase) -> ElementPlan:
    """Plan the run of a case; raise InputError if it has too many steps."""
    n = squares(case)
    start = START * case.yield_unit
    loading = STEPS_PER_E_FOLD * math.log1p(case.max_overlap / start)
    cycle = 2 * STEPS_PER_UNLOADING + _TURNS * SMOOTHING
    n_steps = n / case.run.speed * (loading + case.run.unloadings * cycle)
    if not n_steps <= MOST_STEPS:
        raise InputError(
            f"{case.name}: run.speed: found {case.run.speed:g}, which takes {n_steps:.3g} steps, "
            f"expected at most {MOST_STEPS:g}; use a higher speed"
        )
    return ElementPlan(
        name=case.name,
        n_elements=case.run.elements,
        memory=case.memory,
        disk=_DISK_BASE + _DISK_PER_ELEMENT * case.run.elements,
        wall_time=_BEGINNING + n_steps * case.run.elements / _ELEMENT_STEPS_PER_SECOND,
    )
