"""The mesh: rectangles of a tensor product, fine under the punch, coarser with distance.

Along each axis the wanted size of an element is

    h(x) = h0 max(1, 1 + s (x - D)/D)                       D: diameter of the punch, s: `COARSENING`

and a line has ``N = integral dx / h(x)`` elements, so ``h0 = sqrt(I_r I_z / elements)`` with ``I = integral h0 dx/h``:
one number, ``elements``, refines the whole mesh without changing its shape. At the rounded edge of the punch, where the
plastic zone begins, elements are ``max(taper/2, h0/2)`` wide and grow by `EDGE_GROWTH` away from it. The edge lies
midway between two nodes: the area that belongs to the nodes under the punch is then that of the punch.

Both were chosen by convergence for 0.1 kg and D = 10 mm with a taper of 0.1 mm: with 62 500 elements the dissipated
fraction is within 1 % and the plastic volume within 4 % of what elements half as wide at the edge give, at 6, 10 and 16
m/s. The contact grows node by node over the rounded edge, so where it is not full the result depends on where nodes
are: edge sizes from 25 to 60 um scatter by 2 % at 10 m/s and, near the onset of yield where 4 % of the input is
dissipated, by 4 % at 6 m/s. With no finer edge at all the fraction at 6 m/s is 4 % off.
A mesh of 250 000 elements gives 4.6 % less there than the default, and 6 % less plastic volume.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

Line = NDArray[np.float64]

COARSENING = 3.0
EDGE_GROWTH = 0.15
EDGE_ASPECT = 2.0  # of the smallest elements, depth over width
_SAMPLES = 20_001  # of a size function


@dataclasses.dataclass(frozen=True, eq=False)
class Mesh:
    """Rectangles between the lines ``r`` and ``z``; z = 0 is the struck top and depth goes along +z.

    Attributes
    ----------
    r, z
        Node lines, (n_r + 1,) and (n_z + 1,), m.
    """

    r: Line
    z: Line

    @property
    def shape(self) -> tuple[int, int]:
        """Rows in depth, columns in radius."""
        return len(self.z) - 1, len(self.r) - 1

    @property
    def n_elements(self) -> int:
        """Elements in all."""
        return self.shape[0] * self.shape[1]

    @property
    def nodes(self) -> NDArray[np.float64]:
        """(n_nodes, 2), m: (r, z), r fastest."""
        r, z = np.meshgrid(self.r, self.z)
        return np.column_stack([r.ravel(), z.ravel()])

    @property
    def elements(self) -> NDArray[np.int64]:
        """(n_elements, 4): nodes of each element in turn around it, elements with r fastest."""
        rows, columns = self.shape
        first = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
        return np.column_stack([first, first + 1, first + columns + 2, first + columns + 1])

    @property
    def centres(self) -> tuple[Line, Line]:
        """Radii (n_r,) and depths (n_z,) of the elements' centres, m."""
        return (self.r[1:] + self.r[:-1]) / 2, (self.z[1:] + self.z[:-1]) / 2


def block_mesh(
    radius: float, height: float, punch_radius: float, elements: int, *, taper: float, edge_size: float | None = None
) -> Mesh:
    """The mesh of a block under a punch.

    Parameters
    ----------
    radius, height
        Of the block, m.
    punch_radius
        m.
    elements
        About how many.
    taper
        Of the punch, m.
    edge_size
        Width of the elements at the punch's edge, m, if smaller than h0; ``max(taper/2, h0/2)`` if not given.
    """
    fine = 2 * punch_radius
    ends = (radius, height)
    corners = (punch_radius, 0.0)
    samples = [
        np.unique(np.concatenate([_samples(end), _near(at, end)])) for end, at in zip(ends, corners, strict=True)
    ]

    def densities(size: float) -> list[Line]:
        sizes = [size * np.maximum(1.0, 1 + COARSENING * (x - fine) / fine) for x in samples]
        edge = max(taper / 2, size / 2) if edge_size is None else edge_size
        for n, (x, at, aspect) in enumerate(zip(samples, corners, (1.0, EDGE_ASPECT), strict=True)):
            sizes[n] = np.minimum(sizes[n], aspect * edge + EDGE_GROWTH * np.abs(x - at))
        return [_cumulated(1 / h, x) for h, x in zip(sizes, samples, strict=True)]

    low, high = min(ends) * 1e-9, 4 * max(ends)
    for _ in range(100):
        size = math.sqrt(low * high)
        count = math.prod(c[-1] for c in densities(size))
        low, high = (size, high) if count > elements else (low, size)
    along_r, along_z = densities(high)
    n_r = max(2, round(along_r[-1]))
    n_z = max(1, round(elements / n_r))
    at_edge = float(np.interp(punch_radius, samples[0], along_r))
    n_edge = min(max(1, round(at_edge + 0.5)), n_r - 1)
    # stretch the counting so that the edge is half an element beyond a node
    counted = np.where(
        samples[0] <= punch_radius,
        along_r * (n_edge - 0.5) / at_edge,
        n_edge - 0.5 + (along_r - at_edge) * (n_r - n_edge + 0.5) / (along_r[-1] - at_edge),
    )
    r = np.interp(np.arange(n_r + 1), counted, samples[0])
    z = np.interp(np.arange(n_z + 1), along_z * n_z / along_z[-1], samples[1])
    r[0], r[-1], z[0], z[-1] = 0.0, radius, 0.0, height
    return Mesh(r, z)


def _samples(end: float) -> Line:
    return np.linspace(0.0, end, _SAMPLES)


def _near(at: float, end: float) -> Line:
    """Places crowded around ``at``, where a refined size function changes fast."""
    away = end * np.geomspace(1e-8, 1.0, 2000)
    both = np.concatenate([at - away, [at], at + away])
    return both[(both >= 0) & (both <= end)]


def _cumulated(values: Line, x: Line) -> Line:
    return np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(x))])
