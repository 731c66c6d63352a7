"""Strikers and elastic bars in their positions.

A striker touches given spheres, outside of the packing, all at once. With a diameter scatter there
may be no such position: it then rests on as many of these spheres as necessary to support it. A
misaligned striker is shifted perpendicular to its direction and moved along it until it touches the
first of its spheres; gaps to the others remain.

A bar at an end of a chain is a row of point masses, half a mass at either end, joined by springs E
A / (element length). The node at the chain's end is its face: a particle without radius, which is a
flat for the contact law.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.bodies import Bar, Striker
from granwave.lammps_inputs.case.boundary import Backing
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.packing.disorder import striker_shift
from granwave.lammps_inputs.packing.sites import Sites

# diameters; largest gap or overlap between a striker and the spheres that it touches
_TOLERANCE = 1e-9
# size across a row or layer of spheres, over that along it, that scatter of their diameters may
# cause
_FLAT = 0.05
_TELLING = 1e-6  # relative size below which a direction or a singular value counts as zero
_OVERLAP = 1e-6  # diameters; largest overlap with other spheres


def place_strikers(case: Case, sites: Sites) -> list[NDArray[np.float64]]:
    """Return the centres of the strikers of a case: (3,) each, m.

    If there are several positions in contact, a moving striker is placed on the side from which it
    arrives, a striker at rest away from the centre of the packing, or above it if both sides are
    equal.

    Raises
    ------
    ValueError
        No position of a striker touches its spheres, a shifted striker misses them, or a striker
        overlaps another sphere.
    """
    if not case.striker:
        return []
    every = sites.positions(1, len(sites.present))
    lattice = sites.lattice
    scattered = case.packing.diameter_scatter > 0
    middle = every.mean(axis=0)
    ids = 1 + np.flatnonzero(sites.present)
    centres = every[ids - 1]
    radii = sites.diameter[ids - 1] / 2
    placed = []
    for number, striker in enumerate(case.striker, start=1):
        radius = (striker.diameter or lattice.diameter) / 2
        touched = np.searchsorted(ids, sorted(set(striker.touches)))
        at = centres[touched]
        reach = radii[touched] + radius
        side = _side(striker, at, middle, _FLAT * lattice.diameter if scattered else 0.0)
        centre = _touching(at, reach, side)
        if np.abs(_gaps(centre, at, reach)).max() > _TOLERANCE:
            rested = _resting(at, reach, side) if scattered else None
            if rested is None:
                what = list(striker.touches)
                raise ValueError(
                    f"striker {number}: found no position in which it touches {what} at the same "
                    "time"
                )
            centre = rested
        shift = striker_shift(
            case.packing.seed, striker, number
        )  # only the part across its direction counts
        if shift.any():
            way = np.array(striker.velocity) if any(striker.velocity) else -side
            way = way / np.linalg.norm(way)
            if np.linalg.norm(np.cross(shift, way)) <= _TELLING * np.linalg.norm(shift):
                raise ValueError(
                    f"striker {number}: its shift along its direction of motion has no effect; "
                    "add a component perpendicular to it"
                )
            centre = _brought_up(number, striker, centre + shift, at, reach, way)
        gap = np.linalg.norm(centres - centre, axis=1) - radii - radius
        if gap.min() < -_OVERLAP * 2 * radius:
            other = ids[gap.argmin()]
            raise ValueError(
                f"striker {number}: its position overlaps sphere {other} by {-gap.min():.3g} m"
            )
        placed.append(centre)
        centres = np.vstack([centres, centre])
        radii = np.append(radii, radius)
        ids = np.append(ids, lattice.n_spheres + number)
    return placed


def _gaps(
    centre: NDArray[np.float64], at: NDArray[np.float64], reach: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the gaps of a striker at ``centre`` to spheres, divided by the distances at which it
    touches them: (n,).
    """
    return np.asarray(np.linalg.norm(at - centre, axis=1) / reach - 1)


def _resting(
    at: NDArray[np.float64], reach: NDArray[np.float64], side: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    """Return the deepest position at rest on the spheres without an overlap; None without one.

    The number of touched spheres is one more than the dimension of their arrangement: two of a row,
    three of a layer.
    """
    spans = np.linalg.svd(at - at.mean(axis=0), compute_uv=False)
    enough = 1 + int(np.count_nonzero(spans > _FLAT * spans[0]))
    resting = []
    for supports in combinations(range(len(at)), min(enough, len(at))):
        rows = list(supports)
        centre = _touching(at[rows], reach[rows], side)
        gaps = _gaps(centre, at, reach)
        if gaps.min() >= -_TOLERANCE and np.abs(gaps[rows]).max() <= _TOLERANCE:
            resting.append(centre)
    return min(resting, key=lambda centre: float(side @ centre), default=None)


def _brought_up(
    number: int,
    striker: Striker,
    start: NDArray[np.float64],
    at: NDArray[np.float64],
    reach: NDArray[np.float64],
    way: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Move a striker along the unit vector ``way`` until it touches the first of its spheres."""
    apart = start - at
    along = apart @ way
    square = along**2 - (np.einsum("ij,ij->i", apart, apart) - reach**2)
    if square.max() <= 0:
        raise ValueError(
            f"striker {number}: shifted by "
            f"{np.linalg.norm(start - at.mean(axis=0) - way * along.mean()):.3g} m perpendicular "
            f"to its direction of motion, it misses {list(striker.touches)}; use a smaller offset "
            "or misalignment"
        )
    met = square > 0
    return np.asarray(start + way * float(np.min(-along[met] - np.sqrt(square[met]))))


def _side(
    striker: Striker, at: NDArray[np.float64], middle: NDArray[np.float64], uncertain: float
) -> NDArray[np.float64]:
    """Return the unit vector from the spheres at ``at`` to the side of the striker: (3,).

    Parameters
    ----------
    uncertain
        Distance from ``middle`` that scattered diameters may cause, m; 0: the spheres are at their
        sites.
    """
    away = at.mean(axis=0) - middle
    if np.linalg.norm(away) < uncertain:
        away = np.zeros(3)
    above = np.array([0.0, 0.0, -1.0])
    span = at[1:] - at[0]
    telling = _FLAT if uncertain else _TELLING
    for guess in (-np.array(striker.velocity), away, above):
        across = guess - np.linalg.pinv(span, rcond=_FLAT) @ (span @ guess) if len(span) else guess
        # only the component across the line or plane of the spheres distinguishes the possible
        # positions
        size = np.linalg.norm(across)
        if size > telling * np.linalg.norm(guess) and size > _TOLERANCE * np.abs(at).max(
            initial=0.0
        ):
            return across / size
    return above


def _touching(
    at: NDArray[np.float64], reach: NDArray[np.float64], side: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Find the point at distances ``reach`` from the points ``at``, in the space spanned by these
    and ``side``.
    """
    middle = at.mean(axis=0)
    if len(at) == 1:
        return middle + reach[0] * side
    from scipy.optimize import least_squares  # imported on demand: slow to load

    _, sizes, directions = np.linalg.svd(at - middle)
    spanned = directions[: len(sizes)][sizes > _TELLING * sizes[0]]
    axes = np.vstack([spanned, side])
    start = np.append(np.zeros(len(spanned)), reach.mean())

    def misses(place: NDArray[np.float64]) -> NDArray[np.float64]:
        return _gaps(place @ axes, at - middle, reach)

    found = least_squares(
        misses, start, x_scale=float(reach.mean()), xtol=1e-15, ftol=1e-15, gtol=1e-15
    )
    return middle + found.x @ axes


# names as in the case
INCIDENT_BAR = "incident_bar"
BAR = "bar"


@dataclasses.dataclass(frozen=True)
class PlacedBar:
    """A bar in its position.

    Attributes
    ----------
    name
        ``incident_bar`` or ``bar``.
    first, last
        Ids of its nodes; z rises with the id.
    face
        Id of the node that touches the chain.
    touches
        Id of the sphere that the face touches.
    position
        Of the nodes along z: (n_nodes,), m.
    mass
        Of the nodes: (n_nodes,), kg.
    """

    name: str
    section: Bar
    material: Material
    first: int
    face: int
    touches: int
    position: NDArray[np.float64]
    mass: NDArray[np.float64]

    @property
    def last(self) -> int:
        """Id of the last node."""
        return self.first + len(self.position) - 1

    @property
    def far(self) -> int:
        """Id of the node at the end away from the chain."""
        return self.first if self.face == self.last else self.last

    @property
    def pitch(self) -> float:
        """Length of an element, m."""
        return self.section.length / self.section.elements

    @property
    def stiffness(self) -> float:
        """Stiffness of an element, N/m."""
        return self.material.youngs_modulus * self.section.area / self.pitch

    @property
    def backing(self) -> Backing:
        """The bar as a body behind a plane."""
        return Backing(float(self.mass.sum()), self.stiffness, elements=self.section.elements)

    @property
    def wave_speed(self) -> float:
        """sqrt(E/rho), m/s."""
        return math.sqrt(self.material.youngs_modulus / self.material.density)


def place_bar(case: Case, name: str, first: int, face: float, touches: int) -> PlacedBar:
    """Place the nodes of a bar from its face at z = ``face`` (m), which touches a sphere; ``first``
    is the id of the first node.
    """
    section = case.bar if name == BAR else case.incident_bar
    assert section is not None
    n = section.elements
    ahead = name == INCIDENT_BAR
    material = section.material or case.material
    position = face + np.linspace(
        -section.length if ahead else 0.0, 0.0 if ahead else section.length, n + 1
    )
    mass = np.full(n + 1, material.density * section.area * section.length / n)
    mass[[0, -1]] /= 2
    return PlacedBar(
        name, section, material, first, first + n if ahead else first, touches, position, mass
    )


def echoes(bars: Iterable[PlacedBar]) -> dict[str, float]:
    """Return the earliest time at which an echo from the far end of each bar reaches the chain, by
    name, s.
    """
    crossing = {bar.name: bar.section.length / bar.wave_speed for bar in bars}
    arrival = crossing.get(INCIDENT_BAR, 0.0)  # arrival of the load at the chain
    return {name: arrival + 2 * time for name, time in crossing.items()}
