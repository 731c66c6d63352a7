"""Two half-spheres pressed together slowly: explicit steps with updated geometry and scaled masses.

The flat faces are displaced towards each other and may move radially; the curved surfaces are free
of traction except for the frictionless contact. Each body is solved in the frame of its flat face,
where the face is at rest and the overlap enters only in the contact,

    gap(r) = z_1(r) + z_2(r) - overlap z: height of the surface above the contact point, into its
    body

so that moving the faces causes no inertia forces. Equal spheres are symmetric about the contact
plane: one of them against a rigid frictionless plane that advances by half the overlap is exactly
the same problem.

The contact is a penalty on the gap at two points of each surface segment of both bodies, with
`PENALTY` times the stiffness of an element; mass added to the surface nodes keeps it stable. The
remaining penetration is reported.

The overlap is measured between the flat faces, not between remote points as in Hertz's theory: a
half-sphere between its face and its contact is somewhat stiffer than a half-space, by the amount
given in `sphere_contact.run`.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from granwave.extensions.continuum.material import (
    LINEAR_VISCOSITY,
    N_STATE,
    Elastoplastic,
    hourglass_stiffness,
    von_mises,
)
from granwave.extensions.continuum.sphere_contact import kernels
from granwave.extensions.continuum.sphere_contact.mesh import HalfSphere

PENALTY = 20.0  # stiffness of the contact / stiffness of the elements at it
_REFRESH = 500  # steps between updates of the masses
_STEEPEST = 1.2  # rad; the surface beyond this angle from the contact point never touches

Array = NDArray[np.float64]


@dataclasses.dataclass(frozen=True)
class SurfaceContact:
    """Contact along the surface of the first sphere.

    Attributes
    ----------
    radius, pressure
        Radii, m, and pressures, Pa, of the surface nodes except the ends, (n_nodes - 2,).
    contact_radius
        Radius at which the pressure drops to zero, m.
    penetration
        Largest penetration of the surfaces, m.
    """

    radius: Array
    pressure: Array
    contact_radius: float
    penetration: float


class SphereContactSolver:
    """One half-sphere on the plane of symmetry, or two against each other.

    Parameters
    ----------
    bodies
        One or two meshes.
    materials
        Material of each body.
    smoothing, damping, memory, velocity
        As in `kernels.advance`.
    """

    def __init__(
        self,
        bodies: tuple[HalfSphere, ...],
        materials: tuple[Elastoplastic, ...],
        *,
        smoothing: float,
        damping: float,
        memory: float,
        velocity: float = 0.0,
    ) -> None:
        self.bodies = bodies
        self.materials = materials
        self.damping = damping
        self.smoothing = smoothing
        self.memory = memory
        self.velocity = velocity
        self.n_steps = 0
        self._halves = 1.0 if len(bodies) == 2 else 0.5
        self.offsets = np.cumsum([0, *(len(body.nodes) for body in bodies)])
        first = bodies[0]
        plane = np.array([[0.0, 0.0], [100 * first.radius, 0.0]])
        nodes = np.concatenate(
            [*(body.nodes for body in bodies), *([plane] if len(bodies) == 1 else [])]
        )
        self.elements = np.concatenate(
            [body.elements + at for body, at in zip(bodies, self.offsets, strict=False)]
        )
        self.kind = np.repeat(np.arange(len(bodies)), [len(body.elements) for body in bodies])
        viscosities = [
            LINEAR_VISCOSITY * material.longitudinal_modulus * kernels.STABLE
            for material in materials
        ]
        self._constants = np.array(
            [
                (
                    *material.lame,
                    material.yield_strength,
                    drag,
                    material.hardening_modulus,
                    material.rate_sensitivity,
                    material.reference_rate,
                )
                for material, drag in zip(materials, viscosities, strict=True)
            ]
        )
        self.motion = np.zeros((4, *nodes.shape))
        self.motion[0] = nodes
        self._free = np.ones(nodes.shape)
        for body, at in zip(bodies, self.offsets, strict=False):
            self._free[body.axis + at, 0] = 0.0
            self._free[body.face + at, 1] = 0.0
        if len(bodies) == 1:
            self._free[-2:] = 0.0
        self.state = np.zeros((len(self.elements), N_STATE))
        self.tally = np.zeros(kernels.N_TALLY)
        self._mesh = (self.elements, self.kind, self._constants, self._hourglass(), self.state)
        self._surfaces = [
            self._surface(body, at) for body, at in zip(bodies, self.offsets, strict=False)
        ]
        if len(bodies) == 1:
            none = np.zeros((0, 2))
            last = len(nodes) - 1
            no_segments = np.zeros((0, 4), dtype=np.int64), np.zeros((0, 2, 4))
            self._surfaces.append(_Surface(np.array([last - 1, last]), *no_segments, none, none))
        self._extra = np.zeros(len(nodes))
        for surface in self._surfaces:
            on_segment = len(bodies) * surface.stiffness.sum(axis=1)
            np.add.at(self._extra, surface.around[:, 1], on_segment / 2)
            np.add.at(self._extra, surface.around[:, 2], on_segment / 2)
        if len(bodies) == 1:
            self._extra[-2:] = 1.0  # fixed nodes of the plane
        self._contact = tuple(map(tuple, self._surfaces))
        self.mass = np.zeros(len(nodes))
        self._set_masses()

    @property
    def n_elements(self) -> int:
        """Number of elements."""
        return len(self.elements)

    @property
    def overlap(self) -> float:
        """Present overlap of the flat faces, m."""
        return float(self.tally[kernels.OVERLAP])

    @property
    def force(self) -> float:
        """Present contact force, N."""
        return float(self.tally[kernels.FORCE])

    @property
    def rate(self) -> float:
        """Present change of the overlap in a step, m."""
        return float(self.tally[kernels.RATE])

    @property
    def target_rate(self) -> float:
        """Change of the overlap in a step that the rate approaches, m."""
        return float(self.tally[kernels.TARGET_RATE])

    @property
    def von_mises(self) -> Array:
        """Von Mises stresses, (n_elements,), Pa."""
        return von_mises(self.state)

    def advance(self, n_steps: int, target: float, growth: float = 0.0) -> None:
        """Take ``n_steps`` with the target ``target + growth * overlap`` (m) for the change of
        overlap in a step.
        """
        while n_steps > 0:
            part = min(n_steps, _REFRESH - self.n_steps % _REFRESH)
            kernels.advance(
                part,
                target,
                growth,
                self.smoothing,
                self.damping,
                self.memory,
                self._halves,
                self.velocity,
                self.tally,
                self.motion,
                self.mass,
                self._free,
                self._mesh,
                self._contact,
            )
            self.n_steps += part
            n_steps -= part
            if self.n_steps % _REFRESH == 0:
                self._set_masses()

    def ledger(self) -> dict[str, float]:
        """Return the present overlap (m), forces (N), energies and work (J) of both spheres
        together, by name.

        ``balance`` is the sum of all energies minus the work of the faces.
        """
        elastic, plastic = kernels.stored(
            self.motion[0], self.elements, self.kind, self._constants, self.state
        )
        both_halves = 1 / self._halves
        tally = self.tally
        energies = {
            "kinetic": both_halves * tally[kernels.KINETIC],
            "elastic": both_halves * elastic,
            "penalty": both_halves * tally[kernels.PENALTY],
            "hourglass": both_halves * tally[kernels.HOURGLASS],
            "plastic": both_halves * plastic,
            "viscous": both_halves * tally[kernels.VISCOUS],
            "damping": both_halves * tally[kernels.DAMPING],
        }
        work = both_halves * tally[kernels.WORK]
        return energies | {
            "overlap": self.overlap,
            "force": self.force,
            "face_force": -float(self.motion[2, self.bodies[0].face, 1].sum()),
            "work": work,
            "balance": sum(energies.values()) - work,
        }

    def contact(self) -> SurfaceContact:
        """Return the present contact."""
        line = self.motion[0, self._surfaces[0].line]
        r = line[:, 0]
        force = np.zeros(len(line))
        places = []
        gaps = []
        for surface in self._surfaces:
            at = _gauss_points(self.motion[0, surface.line, 0])[: len(surface.gaps)].ravel()
            push = (surface.stiffness * np.maximum(0.0, -surface.gaps)).ravel()
            segment = np.clip(np.searchsorted(r, at) - 1, 0, len(r) - 2)
            share = (at - r[segment]) / (r[segment + 1] - r[segment])
            np.add.at(force, segment, push * (1 - share))
            np.add.at(force, segment + 1, push * share)
            places.append(at)
            gaps.append(surface.gaps.ravel())
        middle = 0.5 * (r[1:] + r[:-1])
        pressure = force[1:-1] / (math.pi * np.diff(middle**2))
        edge = max(_edge(at, gap) for at, gap in zip(places, gaps, strict=True) if len(gap))
        return SurfaceContact(
            r[1:-1], pressure, edge, float(max(0.0, -min(gap.min() for gap in gaps if len(gap))))
        )

    def _set_masses(self) -> None:
        kernels.masses(
            self.motion[0], self.elements, self.kind, self._constants, self._extra, self.mass
        )

    def _hourglass(self) -> Array:
        r, z = self.motion[0, self.elements].transpose(2, 0, 1)
        p = np.array([r[:, 0] - r[:, 2], z[:, 0] - z[:, 2]])  # diagonals of the elements
        q = np.array([r[:, 1] - r[:, 3], z[:, 1] - z[:, 3]])
        area = 0.5 * (p[0] * q[1] - q[0] * p[1])
        squares = ((p**2).sum(axis=0) + (q**2).sum(axis=0)) / (8 * area**2)
        volume = 2 * math.pi * r.mean(axis=1) * area
        stiffness = np.empty(len(area))
        for n, material in enumerate(self.materials):
            own = self.kind == n
            stiffness[own] = hourglass_stiffness(volume[own], squares[own], material)
        return stiffness

    def _surface(self, body: HalfSphere, at: int) -> _Surface:
        modulus = min(material.longitudinal_modulus for material in self.materials)
        r, z = body.nodes[body.surface].T
        line = body.surface[
            np.arctan2(r, body.radius - z) <= _STEEPEST
        ]  # nodes that may touch, from the axis outwards
        r, z = body.nodes[line].T
        length = np.hypot(np.diff(r), np.diff(z))
        stiffness = (
            PENALTY * modulus * math.pi * _gauss_points(r) / len(self.bodies)
        )  # over length, times length
        line = line + at
        arc = np.concatenate([[0.0], np.cumsum(length)])
        return _Surface(line, *_curve(line, arc), stiffness, np.ones_like(stiffness))


class _Surface(NamedTuple):
    """Arguments of `kernels.press` for one surface."""

    line: NDArray[np.int64]
    around: NDArray[np.int64]
    weights: Array
    stiffness: Array
    gaps: Array


def _edge(radius: Array, gap: Array) -> float:
    """Return the contact radius, m, from the gaps (m) at the Gauss points.

    Beyond the edge the gap opens as ``(r - a)^(3/2)``: a line through its power 2/3 at the first
    two open points gives a, which is limited to the interval between the last closed and the first
    open point.
    """
    pressed = np.flatnonzero(gap < 0)
    if not len(pressed):
        return 0.0
    last = int(pressed[-1])
    if last + 2 >= len(gap):
        return float(radius[last])
    near = radius[last + 1]
    far = radius[last + 2]
    low = gap[last + 1] ** (2 / 3)
    high = gap[last + 2] ** (2 / 3)
    edge = near - low * (far - near) / (high - low) if high > low else near
    return float(np.clip(edge, radius[last], near))


def _gauss_points(values: Array) -> Array:
    """Interpolate nodal values of a line to the Gauss points of its segments, (n_segments, 2)."""
    return values[:-1, None] + np.diff(values)[:, None] * np.array(
        [kernels.NEAR_END, kernels.FAR_END]
    )


def _curve(line: NDArray[np.int64], arc: Array) -> tuple[NDArray[np.int64], Array]:
    """Return ``around`` and ``weights`` of a surface, which interpolate it by the mean of two
    parabolas.

    Each parabola passes through three of the four nodes around a segment. Straight segments would
    come into contact one at a time, and the force would grow in steps.
    """
    n = len(line) - 1
    around = np.column_stack(
        [np.append(line[1], line[: n - 1]), line[:-1], line[1:], np.append(line[2:], line[-1])]
    )
    places = np.column_stack(
        [np.append(-arc[1], arc[: n - 1]), arc[:-1], arc[1:], np.append(arc[2:], arc[-1])]
    )
    x = _gauss_points(arc)
    weights = np.zeros((n, 2, 4))
    for first, m in itertools.product((0, 1), range(3)):
        at = places[:-1, None, first : first + 3]
        others = np.delete(at, m, axis=2)
        weights[:-1, :, first + m] += 0.5 * np.prod(
            (x[:-1, :, None] - others) / (at[..., m : m + 1] - others), axis=2
        )
    share = (x[-1] - places[-1, 1]) / (places[-1, 2] - places[-1, 1])
    weights[-1, :, 1:3] = np.column_stack([1 - share, share])
    return around, weights
