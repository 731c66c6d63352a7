"""Kind of a packing: its sites in diameters, and the properties that follow from its contacts."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

TOUCHING = 1e-6  # spheres touch if the gap between them is at most this many diameters
# differences in (i, j, k) of touching spheres are at most this
_REACH = (
    range(-3, 4),
    range(-2, 3),
    range(-1, 2),
)
_FAR = 6  # a multiple of all periods, large enough to keep stepped indices positive
_IN_HEXAGONAL_LAYER = 6  # neighbours
_CLOSE_PACKED_COORDINATION = 12
_ALONG = 1e-9  # component of a contact direction that counts as non-zero

Site = Callable[[NDArray, NDArray, NDArray], tuple[NDArray, NDArray, NDArray]]
Offset = tuple[int, int, int]
Vector = tuple[float, float, float]


@dataclasses.dataclass(frozen=True)
class SectionPlane:
    """Plane of a section through the impacted sphere.

    Attributes
    ----------
    across
        Unit vector to the right.
    down
        Unit vector downwards, or along y for a packing of one layer.
    tolerance
        Largest distance of a centre from the plane, diameters; the nearest parallel plane of
        spheres is usually half a diameter away.
    down_label
        Label of the coordinate along ``down``.
    """

    across: Vector
    down: Vector
    tolerance: float = 0.2
    down_label: str = "Depth"


@dataclasses.dataclass(frozen=True)
class PowerLaw:
    """A length proportional to a power of the energy input: factor, diameters, and power."""

    factor: float
    power: float

    def __call__(self, energy: float) -> float:
        """Return the length at an energy divided by F_y alpha_y, diameters."""
        return self.factor * energy**self.power


@dataclasses.dataclass(frozen=True)
class ZoneEstimate:
    """Growth of the plastic zone under an impact.

    Attributes
    ----------
    depth, radius
        Depth below the impacted sphere, and radius from the impact axis.
    spread
        Factor of uncertainty of both.
    """

    depth: PowerLaw
    radius: PowerLaw
    spread: float


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class PackingKind:
    """One kind of packing, given by its sites in diameters; all other properties follow from its
    axes and contacts.

    Nothing outside compares names of kinds: differences between kinds are attributes here.

    Attributes
    ----------
    label
        Name of the kind in titles.
    layers
        Description of its layers, in the table of the manual.
    axes
        The lattice directions that ``packing.size`` counts, of "xyz"; empty for grains that are on
        no lattice.
    layer_period
        Number of layers after which the stacking repeats.
    row_period
        Number of rows after which a layer repeats; periodic packings have a multiple of it.
    pitch
        Period along x and spacing of rows along y.
    site
        Function that gives the centre of sphere (i, j, k).
    planes
        Principal and orthogonal plane of sections; None: vertical planes along and across the first
        preferred direction.
    zone_growth
        Growth of the plastic zone, as runs have shown it; None: not known.
    """

    label: str
    layers: str
    axes: str
    layer_period: int = 1
    row_period: int = 1
    pitch: tuple[float, float]
    site: Site
    planes: tuple[SectionPlane, ...] | None = None
    zone_growth: ZoneEstimate | None = None

    @property
    def is_lattice(self) -> bool:
        """True for lattices; False for grains of a file."""
        return bool(self.axes)

    @property
    def is_chain(self) -> bool:
        """True for a single column of grains along z."""
        return self.axes == "z"

    @property
    def is_layer(self) -> bool:
        """True for a single layer in x-y, across the impact of the other kinds."""
        return self.axes == "xy"

    @property
    def is_plane_crystal(self) -> bool:
        """True for a crystal in x-z, whose straight rows are its layers."""
        return self.axes == "xz"

    @property
    def has_faces(self) -> bool:
        """True if layers extend along x and y, so that they have an area and surround the impact.

        False for chains, crystals in x-z and grains of a file.
        """
        return "y" in self.axes

    @property
    def size_form(self) -> str:
        """Form of ``packing.size``: ``[nx, ny, nz]``, ``[nx, nz]``, or ``n`` of a chain."""
        counts = ", ".join(f"n{axis}" for axis in self.axes)
        return "n" if self.is_chain else f"[{counts}]"

    @property
    def title(self) -> str:
        """Name in titles: ``Chain``, ``FCC packing``."""
        return self.label if self.is_chain else f"{self.label} packing"

    @property
    def noun(self) -> str:
        """Name of a packing without faces in sentences: ``a chain``, ``a crystal in the plane``."""
        return "a chain" if self.is_chain else "a plane crystal"

    @property
    def is_close_packed(self) -> bool:
        """True if each sphere has twelve contacts: the densest packings, with holes of two
        kinds.
        """
        return self.coordination == _CLOSE_PACKED_COORDINATION

    @cached_property
    def cylinder_axis(self) -> Vector:
        """Axis of cylinders by default: y, or z where contacts are along y."""
        _, y, _ = self.contact_directions.T
        along_y = np.abs(y) > _ALONG
        return (0.0, 0.0, 1.0) if along_y.any() else (0.0, 1.0, 0.0)

    @cached_property
    def contact_directions(self) -> NDArray[np.float64]:
        """Unit vectors from an interior sphere of row 0 and layer 0 to its neighbours: (n_contacts,
        3).
        """
        if not self.axes:
            return np.empty((0, 3))
        movable = tuple(axis in self.axes for axis in "xyz")
        offsets = np.array(offsets_of(self, 0, 0, movable), dtype=np.int64)
        origin = np.zeros((3, 1), dtype=np.int64)
        neighbours = np.stack(self.site(*offsets.T), axis=1)
        return neighbours - np.stack(self.site(*origin), axis=1)

    @property
    def coordination(self) -> int:
        """Coordination number of an interior sphere."""
        return len(self.contact_directions)

    @cached_property
    def dimension(self) -> int:
        """Dimension of the space that the contact directions span."""
        return int(np.linalg.matrix_rank(self.contact_directions, tol=TOUCHING))

    @cached_property
    def hexagonal(self) -> bool:
        """True if a sphere has six neighbours in its layer."""
        _, _, z = self.contact_directions.T
        return int(np.count_nonzero(np.abs(z) < TOUCHING)) == _IN_HEXAGONAL_LAYER

    @cached_property
    def supports(self) -> NDArray[np.float64]:
        """Unit vectors from a sphere to its neighbours in the next layer, by angle about z:
        (n_supports, 3).
        """
        _, _, z = self.contact_directions.T
        return _by_angle(self.contact_directions[z > TOUCHING])

    @property
    def preferred_directions(self) -> NDArray[np.float64]:
        """Directions of the largest forces: the `supports`, or in a single layer all contact
        directions.
        """
        return self.supports if len(self.supports) else _by_angle(self.contact_directions)

    @cached_property
    def layer_spacing(self) -> float:
        """Spacing of layers, diameters; 1 for a single layer."""
        if "z" not in self.axes:
            return 1.0
        zero = np.zeros(1, dtype=np.int64)
        _, _, z = self.site(zero, zero, zero + 1)
        return float(z[0])

    @property
    def carried(self) -> float:
        """Force along z that a sphere transmits to the next layer if each of its contacts there
        carries 1.
        """
        return max(len(self.supports), 1) * self.layer_spacing

    @property
    def set_back(self) -> bool:
        """True if the spheres of a layer lie in the hollows of the next layer."""
        return len(self.supports) > 1

    @property
    def solid_fraction(self) -> float:
        """Volume of the spheres divided by the volume of the packing."""
        along_x, along_y = self.pitch
        return math.pi / 6 / (along_x * along_y * self.layer_spacing)


def hexagonal_site(period: int) -> Site:
    """Return the sites of hexagonal layers, stacked with a period: 3 for fcc, 2 for hcp."""

    def site(i: NDArray, j: NDArray, k: NDArray) -> tuple[NDArray, NDArray, NDArray]:
        s = k % period
        x = i + (j % 2) / 2 + s / 2
        y = j * math.sqrt(3) / 2 + s * math.sqrt(3) / 6
        return x, y, k * math.sqrt(2 / 3)

    return site


def body_centred_site(i: NDArray, j: NDArray, k: NDArray) -> tuple[NDArray, NDArray, NDArray]:
    """Centres of a body-centred cubic lattice."""
    a = 2 / math.sqrt(3)
    return a * (i + (k % 2) / 2), a * (j + (k % 2) / 2), a / 2 * k


def simple_site(i: NDArray, j: NDArray, k: NDArray) -> tuple[NDArray, NDArray, NDArray]:
    """Centres of a simple cubic lattice."""
    return i * 1.0, j * 1.0, k * 1.0


def hexagonal_plane_site(i: NDArray, j: NDArray, k: NDArray) -> tuple[NDArray, NDArray, NDArray]:
    """Centres of a hexagonal crystal in x-z."""
    return i + (k % 2) / 2, j * 1.0, k * math.sqrt(3) / 2


def centred_square_site(i: NDArray, j: NDArray, k: NDArray) -> tuple[NDArray, NDArray, NDArray]:
    """Centres of a centred square crystal in x-z."""
    return math.sqrt(2) * (i + (k % 2) / 2), j * 1.0, k / math.sqrt(2)


def no_site(i: NDArray, j: NDArray, k: NDArray) -> tuple[NDArray, NDArray, NDArray]:
    """Raise LookupError: grains of a file have no lattice site."""
    raise LookupError("grains of a file are on no lattice")


@cache
def offsets_of(rule: PackingKind, j: int, k: int, movable: tuple[bool, ...]) -> list[Offset]:
    """Return the steps in (i, j, k) from a sphere of row j and layer k to its neighbours.

    Parameters
    ----------
    movable
        True for each axis along which there is more than one sphere.
    """
    reach = [steps if free else (0,) for steps, free in zip(_REACH, movable, strict=True)]
    base = (_FAR, _FAR + j, _FAR + k)
    centre = np.array(rule.site(*map(np.asarray, base)))
    offsets: list[Offset] = []
    for step in itertools.product(reach[0], reach[1], reach[2]):
        neighbour = rule.site(*map(np.asarray, np.add(base, step)))
        if any(step) and abs(math.dist(centre, neighbour) - 1.0) <= TOUCHING:
            offsets.append(step)
    return offsets


def _by_angle(directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sort unit vectors by their angle about z, from x."""
    x, y, z = directions.T
    angle = np.round(np.arctan2(y, x) % (2 * np.pi), 9)
    return directions[np.lexsort((z, angle))]
