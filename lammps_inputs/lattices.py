"""Lattices of spheres that just touch: sites and neighbours of sphere (i, j, k).

Centre of sphere (i, j, k) in units of the diameter D; i runs fastest, k counts layers along the
impact direction +z:

    fcc, hcp   x = i + (j mod 2)/2 + s/2, y = j sqrt(3)/2 + s sqrt(3)/6, z = k sqrt(2/3)
               with s = k mod 3 (fcc, impact along [111]) or k mod 2 (hcp)
    bcc        (001) layers of pitch a = 2/sqrt(3), a/2 apart, odd layers shifted by (a/2, a/2)
    sc         x = i, y = j, z = k;     square is its one layer in x-y, chain its one column along z
    hexagonal, centred-square           crystals in x-z, whose straight rows are layers: y = 0

Rows of a crystal in x-z alternate between n and n - 1 grains, so that both sides are straight, or
all have n; long rows begin at x = 0, short rows (or every second row of n) half a pitch further.

No array over the packing is stored, so that a lattice of any size needs no memory.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterator
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.extensions import joined, loaded
from granwave.lammps_inputs.packing_kind import (
    TOUCHING,
    Offset,
    PackingKind,
    PowerLaw,
    SectionPlane,
    ZoneEstimate,
    body_centred_site,
    centred_square_site,
    hexagonal_plane_site,
    hexagonal_site,
    no_site,
    offsets_of,
    simple_site,
)

_MOST_COUNTED = 12  # layers whose contacts are counted one by one
_BATCH = 1_000_000  # sites processed at once
_IMAGE = 8.0  # period along y of a periodic crystal in x-z, diameters: its images do not interact
ROWS = ("long", "short", "equal")  # choices of `packing.top_row`
FILE = "file"  # kind of packings with user-defined positions
RESTART = "restart"  # kind of packings from a restart file of LAMMPS, whose contacts are continued


_X = (1.0, 0.0, 0.0)
_Y = (0.0, 1.0, 0.0)
_Z = (0.0, 0.0, 1.0)
_DIAGONAL = (math.sqrt(0.5), math.sqrt(0.5), 0.0)
_CLOSE_PACKED = (
    0.0,
    1 / 3,
    math.sqrt(8) / 3,
)  # downwards in the plane of fcc that contains two preferred directions
#: Name of the depth along an inclined plane.
INCLINED = "Depth along the plane"
_HCP_ROWS = 0.4  # includes the rows of odd layers, at a distance of sqrt(3)/6 from the plane

_HEXAGONAL_PITCH = (1.0, math.sqrt(3) / 2)
_BODY_CENTRED_PITCH = (2 / math.sqrt(3), 2 / math.sqrt(3))
_SIMPLE_PITCH = (1.0, 1.0)

_OF_CLOSE_PACKED = ZoneEstimate(PowerLaw(1.30, 0.255), PowerLaw(1.0, 0.265), spread=1.5)
_OF_BODY_CENTRED = ZoneEstimate(PowerLaw(1.30, 0.32), PowerLaw(2.2, 0.26), spread=1.4)
_ALONG_A_LINE = ZoneEstimate(PowerLaw(75.0, 0.0), PowerLaw(0.0, 0.0), spread=1.0)

#: Lattices of the core.
KINDS: dict[str, PackingKind] = {
    "fcc": PackingKind(
        label="FCC",
        layers="hexagonal layers in the order ABC; impact along [111]",
        axes="xyz",
        layer_period=3,
        row_period=2,
        pitch=_HEXAGONAL_PITCH,
        site=hexagonal_site(3),
        planes=(
            SectionPlane(_X, _CLOSE_PACKED, down_label=INCLINED),
            SectionPlane(_Y, _Z),
        ),
        zone_growth=_OF_CLOSE_PACKED,
    ),
    "hcp": PackingKind(
        label="HCP",
        layers="hexagonal layers in the order AB",
        axes="xyz",
        layer_period=2,
        row_period=2,
        pitch=_HEXAGONAL_PITCH,
        site=hexagonal_site(2),
        planes=(SectionPlane(_X, _Z, _HCP_ROWS), SectionPlane(_Y, _Z)),
        zone_growth=_OF_CLOSE_PACKED,
    ),
    "bcc": PackingKind(
        label="BCC",
        layers="square layers, every second layer shifted by half a side",
        axes="xyz",
        layer_period=2,
        pitch=_BODY_CENTRED_PITCH,
        site=body_centred_site,
        planes=(SectionPlane(_DIAGONAL, _Z), SectionPlane(_X, _Z)),
        zone_growth=_OF_BODY_CENTRED,
    ),
    "sc": PackingKind(
        label="Simple cubic",
        layers="square layers, directly above each other",
        axes="xyz",
        pitch=_SIMPLE_PITCH,
        site=simple_site,
        planes=(SectionPlane(_X, _Z), SectionPlane(_DIAGONAL, _Z)),
        zone_growth=_ALONG_A_LINE,
    ),
    "square": PackingKind(
        label="Square",
        layers="one layer",
        axes="xy",
        pitch=_SIMPLE_PITCH,
        site=simple_site,
        planes=(SectionPlane(_X, _Y, down_label="y"),),
    ),
    "hexagonal": PackingKind(
        label="Hexagonal",
        layers="alternating rows of n and n - 1 grains in the x-z plane, six neighbours; `top_row` "
        "selects the impacted row",
        axes="xz",
        layer_period=2,
        pitch=_SIMPLE_PITCH,
        site=hexagonal_plane_site,
        planes=(SectionPlane(_X, _Z),),
    ),
    "centred-square": PackingKind(
        label="Centred square",
        layers="as hexagonal, but with four neighbours at 45 degrees",
        axes="xz",
        layer_period=2,
        pitch=(math.sqrt(2), 1.0),
        site=centred_square_site,
        planes=(SectionPlane(_X, _Z),),
    ),
    "chain": PackingKind(
        label="Chain",
        layers="one column along z",
        axes="z",
        pitch=_SIMPLE_PITCH,
        site=simple_site,
        planes=(),
        zone_growth=_ALONG_A_LINE,
    ),
}
_FREE = PackingKind(
    label="Grains of a file",
    layers="none",
    axes="",
    pitch=_SIMPLE_PITCH,
    site=no_site,
    planes=(SectionPlane(_X, _Z, 0.5), SectionPlane(_Y, _Z, 0.5)),
)


@cache
def lattice_kinds() -> dict[str, PackingKind]:
    """Return the lattices by name: lattices of the core, then lattices of extensions.

    Raises
    ------
    InputError
        Two lattices have the same name, or an extension cannot be loaded.
    """
    kinds = joined("packing.kind", KINDS | {FILE: _FREE}, loaded("lattices"))
    return {name: kind for name, kind in kinds.items() if name != FILE}


def kind_names() -> tuple[str, ...]:
    """Return the names of all kinds of packings: lattices, and grains of a file."""
    return (*lattice_kinds(), FILE, RESTART)


def kind_of(name: str) -> PackingKind:
    """Return the kind of packing of this name: a lattice, or grains of a file."""
    return _FREE if name in (FILE, RESTART) else lattice_kinds()[name]


def section_planes(kind: str) -> tuple[SectionPlane, ...]:
    """Return the planes of sections of a kind of packing: principal, then orthogonal; a chain has
    none.
    """
    rule = kind_of(kind)
    if rule.planes is not None:
        return rule.planes
    level = [direction[:2] for direction in (*rule.preferred_directions, *rule.contact_directions)]
    x, y = next(part / np.linalg.norm(part) for part in level if np.linalg.norm(part) > TOUCHING)
    return SectionPlane((float(x), float(y), 0.0), _Z), SectionPlane((-float(y), float(x), 0.0), _Z)


@dataclasses.dataclass(frozen=True)
class Lattice:
    """A finite lattice of identical spheres.

    Attributes
    ----------
    kind
        Name of a lattice, as of `lattice_kinds`.
    size
        Spheres along x, rows along y, layers along z, for the directions that the lattice
        has: (nx, ny, nz), (nx, ny), (nx, nz) or (n,).
    diameter
        Diameter of the spheres, m.
    periodic
        True if the packing is periodic along x and y.
    top_row
        Impacted row of a crystal in x-z: ``long`` (nx grains) or ``short`` (nx - 1); ``equal``: all
        rows have nx.
    overlap
        Overlap of neighbours, m: with cohesion the overlap at zero contact force.
    """

    kind: str
    size: tuple[int, ...]
    diameter: float
    periodic: bool = False
    top_row: str = "equal"
    overlap: float = 0.0

    @property
    def spacing(self) -> float:
        """Distance of the centres of neighbours, m."""
        return self.diameter - self.overlap

    @property
    def rule(self) -> PackingKind:
        """Properties of the kind."""
        return lattice_kinds()[self.kind]

    @property
    def shape(self) -> tuple[int, int, int]:
        """Spheres along x, rows along y, layers along z."""
        counts = dict(zip(self.rule.axes, self.size, strict=True))
        return counts.get("x", 1), counts.get("y", 1), counts.get("z", 1)

    @property
    def n_spheres(self) -> int:
        """Number of spheres."""
        return int(self._before(self.n_layers))

    @property
    def n_layers(self) -> int:
        """Number of layers along z."""
        return self.shape[2]

    @property
    def top_layer(self) -> NDArray[np.int64]:
        """Ids of the spheres of the impacted layer, in rising order."""
        return self.layer(0)

    @cached_property
    def middle_of_top(self) -> int:
        """Id of the sphere of the top layer nearest to the centroid of this layer, see
        `middle_of`.
        """
        ids = self.top_layer
        return middle_of(ids, self.positions(1, len(ids)), self.diameter)

    @property
    def last_layer(self) -> NDArray[np.int64]:
        """Ids of the spheres of the last layer, in rising order."""
        return self.layer(self.n_layers - 1)

    def layer(self, k: int) -> NDArray[np.int64]:
        """Return the ids of the spheres of layer k, from 0 at the top, in rising order."""
        return np.arange(self._before(k) + 1, self._before(k + 1) + 1)

    @property
    def lengths(self) -> tuple[float, float]:
        """Periods of a periodic packing along x and y, or else the width of a crystal in x-z and a
        diameter, m.
        """
        nx, ny, _ = self.shape
        x, y = self.rule.pitch
        if not self.rule.is_plane_crystal:
            return nx * x * self.spacing, ny * y * self.spacing
        width, depth = (nx * x, _IMAGE) if self.periodic else ((nx - 1) * x + 1, 1.0)
        return width * self.spacing, depth * self.spacing

    @cached_property
    def n_contacts(self) -> int:
        """Number of touching pairs, counted without listing them."""
        period = self.rule.layer_period
        # each further period of layers adds the same number
        if self.n_layers > _MOST_COUNTED + 2 * period:
            few = _MOST_COUNTED + (self.n_layers - _MOST_COUNTED) % period
            sizes = ((*self.size[:-1], count) for count in (few, few + period))
            first, second = (dataclasses.replace(self, size=size).n_contacts for size in sizes)
            return first + (second - first) * ((self.n_layers - few) // period)
        _, ny, nz = self.shape
        total = 0
        for k0, j0, offsets in self._places():
            k = np.arange(k0, nz, self.rule.layer_period)
            j = np.arange(j0, ny, self.rule.row_period)
            for di, dj, dk in offsets:
                k_of = k[(k + dk >= 0) & (k + dk < nz)]
                along = self._row(k_of)
                across = int(j.size)
                if not self.periodic:
                    along = np.maximum(
                        np.minimum(along, self._row(k_of + dk) - di) - max(0, -di), 0
                    )
                    across = int(np.count_nonzero((j + dj >= 0) & (j + dj < ny)))
                total += int(across * along.sum())
        return total // 2

    def positions(self, first: int, last: int) -> NDArray[np.float64]:
        """Return the centres of the spheres with ids ``first`` to ``last``, both included: (n, 3),
        m.
        """
        return self._centres(np.arange(first - 1, last))

    def bounds(self) -> NDArray[np.float64]:
        """Return the lowest and highest coordinates of centres along x, y, z: (2, 3), m."""
        _, ny, nz = self.shape
        rows = _ends(ny, self.rule.row_period)
        layers = _ends(nz, self.rule.layer_period)
        corners = []
        for k in layers:
            for j in rows:
                for i in (0, self._row(k) - 1):
                    corners.append(self._before(k) + self._row(k) * j + i)
        sites = self._centres(np.array(corners))
        return np.stack([sites.min(axis=0), sites.max(axis=0)])

    def pairs(self) -> Iterator[NDArray[np.int64]]:
        """Iterate over the touching pairs in batches of ids (n, 2), i < j; every pair once, in no
        particular order.
        """
        nx, ny, nz = self.shape
        i = np.arange(nx)
        layers_at_once = max(1, _BATCH // (nx * ny))
        for k0, j0, offsets in self._places():
            j = np.arange(j0, ny, self.rule.row_period)[:, None]
            layers = np.arange(k0, nz, self.rule.layer_period)
            for start in range(0, layers.size, layers_at_once):
                k = layers[start : start + layers_at_once, None, None]
                own, there = self._shifted(i, j, k, (0, 0, 0))
                for offset in offsets:
                    other, exists = self._shifted(i, j, k, offset)
                    keep = there & exists & (own < other)
                    yield np.stack([own[keep], other[keep]], axis=1)

    def neighbours(self, sphere: int) -> list[int]:
        """Return the ids of the neighbours of a sphere, in rising order."""
        i, j, k = self.indices(sphere)
        here = np.asarray(i), np.asarray(j), np.asarray(k)
        shifted = [self._shifted(*here, offset) for offset in self._offsets(j, k)]
        return sorted(int(other) for other, exists in shifted if exists)

    def at_sides(self, ids: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return True for the spheres at the ends of rows and layers that are not periodic:
        (n,).
        """
        nx, ny, _ = self.shape
        i, j, k = self._indices(ids - 1)
        ends = [
            (place == 0) | (place == n - 1)
            for place, n, most in ((i, self._row(k), nx), (j, ny, ny))
            if most > 1
        ]
        return np.any(ends, axis=0) if ends else np.zeros(ids.shape, dtype=bool)

    def layer_of(self, sphere: int) -> int:
        """Return the layer of the sphere with this id, counted from 0 at the impacted top."""
        return self.indices(sphere)[2]

    def indices(self, sphere: int) -> tuple[int, int, int]:
        """Return (i, j, k) of the sphere with this id."""
        i, j, k = self._indices(sphere - 1)
        return int(i), int(j), int(k)

    @property
    def _start(self) -> int:
        """Impacted layer of the stacking: a layer of short rows is shifted by half a pitch."""
        return int(self.top_row == "short")

    def _row(self, k: Any) -> Any:
        """Return the number of spheres of the rows of layers k."""
        return self.shape[0] - (k + self._start) % 2 * (self.top_row != "equal")

    def _before(self, k: Any) -> Any:
        """Return the number of spheres before layers k."""
        nx, ny, _ = self.shape
        return nx * ny * k - (k + self._start) // 2 * (self.top_row != "equal")

    def _indices(self, index: Any) -> tuple[Any, Any, Any]:
        """Return (i, j, k) of spheres, counted from 0."""
        nx, ny, _ = self.shape
        if self.top_row == "equal":
            return index % nx, index // nx % ny, index // (nx * ny)
        two_rows, i = np.divmod(index + self._start * nx, 2 * nx - 1)
        second = i >= nx
        return i - nx * second, 0 * i, 2 * two_rows + second - self._start

    def _centres(self, index: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the centres of spheres, counted from 0: (n, 3), m."""
        i, j, k = self._indices(index)
        x, y, z = self.rule.site(i, j, k + self._start)
        if self._start:
            z = self.rule.site(i, j, k)[2]
        result = np.empty((index.size, 3))
        for axis, values in enumerate((x, y, z)):
            np.multiply(values, self.spacing, out=result[:, axis])
        return result

    def _shifted(
        self, i: NDArray, j: NDArray, k: NDArray, offset: Offset
    ) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """Return the ids of the spheres an offset away, and whether they exist."""
        _, ny, nz = self.shape
        i = i + offset[0]
        j = j + offset[1]
        k = k + offset[2]
        row = self._row(k)
        exists = (k >= 0) & (k < nz)
        if self.periodic:
            i = i % row
            j = j % ny
            exists = exists & np.ones(np.broadcast(i, j).shape, dtype=bool)
        else:
            exists = exists & (i >= 0) & (i < row) & (j >= 0) & (j < ny)
        return 1 + self._before(k) + i + row * j, exists

    def _places(self) -> list[tuple[int, int, list[Offset]]]:
        """Return the first layer and row of each kind, with the steps to the neighbours there."""
        layers = range(min(self.n_layers, self.rule.layer_period))
        rows = range(self.rule.row_period)
        return [(k, j, self._offsets(j, k)) for k, j in itertools.product(layers, rows)]

    def _offsets(self, j: int, k: int) -> list[Offset]:
        layer = (k + self._start) % self.rule.layer_period
        row = j % self.rule.row_period
        return offsets_of(self.rule, row, layer, tuple(n > 1 for n in self.shape))


def middle_of(ids: NDArray[np.int64], centres: NDArray[np.float64], diameter: float) -> int:
    """Return the id of the sphere nearest to the centroid of a layer; of equal distances, within
    1e-6 D, the lowest id.

    Parameters
    ----------
    ids
        Ids of the spheres of the layer in rising order: (n,).
    centres
        (n, 3), m.
    """
    level = centres[:, :2]
    distance = np.linalg.norm(level - level.mean(axis=0), axis=1)
    nearest = distance <= distance.min() + TOUCHING * diameter
    return int(ids[nearest][0])


def _ends(n: int, period: int) -> NDArray[np.int64]:
    return np.unique(np.clip([*range(period), *range(n - period, n)], 0, n - 1))
