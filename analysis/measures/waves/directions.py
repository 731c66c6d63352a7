"""Directionality of a wave: shares of energy and dissipation by direction from the impact point, for any packing.

The direction of a sphere is that from the nearest struck sphere. In a layer it is an angle; in a packing of several
layers a point of the half sphere below, cut into cells of equal solid angle.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.geometry.nearest import nearest
from granwave.analysis.measures.geometry.planes import preferred_directions
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.motion import struck_of

Array = NDArray[np.float64]

AXIS_ANGLE = 15.0  # degrees around a direction of contacts that count as along it
LAYER_BINS = 72  # of 5 degrees
RINGS, PER_RING = 8, 24  # of the half sphere: cells in the angle to the impact axis, and around it
_ONE_LAYER = 0.1  # diameters that the spheres of a layer may lie above each other
_REACHED = 0.02  # share of the energy at the outermost spheres from which on the wave has reached them


@dataclasses.dataclass(frozen=True, eq=False)
class Spread:
    """Distribution of a quantity of the spheres over the directions from the impact point.

    Attributes
    ----------
    cells
        Share of the total in each cell: (LAYER_BINS,) from -180 degrees on, or (RINGS, PER_RING).
    along
        Share within `AXIS_ANGLE` of the directions of contacts, to which an even spread would give ``even``.
    even
        Part of all directions within that angle.
    """

    cells: Array
    along: float
    even: float

    @property
    def relative(self) -> Array:
        """Cells over their mean: 1 everywhere if nothing is directional."""
        return self.cells / (self.cells.mean() or 1.0)


def struck_rows(result: Result) -> NDArray[np.int64]:
    """Rows of the spheres of the packing that are struck: by strikers, or by the load."""
    case = result.case
    n = assemble(case).lattice.n_spheres
    if case.striker:
        return result.rows(np.array(sorted({one for striker in case.striker for one in striker.touches if one <= n})))
    return result.rows(np.array(struck_of(assemble(case))))


def directions(result: Result) -> Array:
    """Unit vectors from the nearest struck sphere to each sphere: (n_spheres, 3); NaN for struck ones and strikers.

    Parameters
    ----------
    result
        Of a run, ``run.result``.
    """
    struck, positions = struck_rows(result), result["spheres/position"]
    _, row = nearest(positions, positions[struck])
    offset = positions - positions[struck][row]
    offset[struck] = np.nan
    offset[~result.in_packing] = np.nan
    return offset / np.linalg.norm(offset, axis=1, keepdims=True)


def spread(result: Result, values: Array) -> Spread | None:
    """Spread of what spheres hold over the directions from the nearest struck sphere; strikers are left out.

    Parameters
    ----------
    result
        ``run.result`` of a run as `granwave.load` gives it.
    values
        Not negative: (n_spheres,).

    Returns
    -------
    Spread or None
        Shares ``along`` the directions of contacts, within 15 degrees, and ``even``, that of an even spread; ``cells``
        by direction. None if struck spheres hold all.
    """
    vectors = directions(result)
    known = np.isfinite(vectors[:, 0])
    vectors, weights = vectors[known], values[known]
    total = float(weights.sum())
    if not total > 0:
        return None
    axes = preferred_directions(result.case.packing.kind)
    cosine = (vectors @ axes.T).max(axis=1)
    along = float(weights[cosine >= np.cos(np.deg2rad(AXIS_ANGLE)) - 1e-9].sum()) / total
    if is_layer(result):
        angle = np.rad2deg(np.arctan2(vectors[:, 1], vectors[:, 0]))
        width = 360 / LAYER_BINS  # a bin lies around each multiple of it
        place = np.floor((angle + 180) / width + 0.5 + 1e-9).astype(int) % LAYER_BINS
        cells = np.bincount(place, weights, minlength=LAYER_BINS)
        return Spread(cells / total, along, len(axes) * 2 * AXIS_ANGLE / 360)
    depth = np.clip(vectors[:, 2], 0, 1)
    ring = np.minimum(((1 - depth) * RINGS).astype(int), RINGS - 1)
    around = np.floor((np.rad2deg(np.arctan2(vectors[:, 1], vectors[:, 0])) + 180) / 360 * PER_RING + 0.5 + 1e-9)
    cells = np.bincount(ring * PER_RING + around.astype(int) % PER_RING, weights, minlength=RINGS * PER_RING)
    even = len(axes) * (1 - np.cos(np.deg2rad(AXIS_ANGLE)))  # caps apart from each other, of a half sphere
    return Spread(cells.reshape(RINGS, PER_RING) / total, along, float(even))


def is_layer(result: Result) -> bool:
    """The packing has one layer."""
    return bool(np.ptp(result["spheres/position"][result.in_packing, 2]) < _ONE_LAYER * result.case.packing.diameter)


def energy_of_spheres(result: Result, frame: int) -> Array:
    """Kinetic energy of each sphere and half the elastic energy of its contacts: (n_spheres,), J.

    Parameters
    ----------
    result
        ``run.result`` of a run as `granwave.load` gives it.
    frame
        Number of the snapshot, from 0.
    """
    energy = 0.5 * result["spheres/mass"] * np.sum(result.frame(frame, "velocity") ** 2, axis=1)
    if "elastic_energy" in result.quantities:
        stored = result.frame(frame, "elastic_energy")
        energy = energy + np.where(np.isfinite(stored), stored, 0.0)
    return energy


def travelling_frame(result: Result) -> int:
    """Number of the last snapshot before the wave reaches sides or bottom, or else of the first after the start.

    Parameters
    ----------
    result
        ``run.result`` of a run as `granwave.load` gives it.
    """
    outer = _outermost(result)
    struck = struck_rows(result)
    inner = result.in_packing
    inner[struck] = False
    chosen = min(1, result.n_frames - 1)
    for frame in range(chosen, result.n_frames):
        energy = energy_of_spheres(result, frame)
        moving = float(energy[inner].sum())
        if moving > 0 and float(energy[outer & inner].sum()) > _REACHED * moving:
            break
        chosen = frame
    return chosen


def _outermost(result: Result) -> NDArray[np.bool_]:
    """Spheres at the sides and the bottom, those apart that are as near to an impact on that side."""
    inside = result.in_packing
    positions = result["spheres/position"]
    packing, struck = positions[inside], positions[struck_rows(result)]
    edge = 0.6 * result.case.packing.diameter
    found = np.zeros(len(positions), dtype=bool)
    for axis in (0, 1) if is_layer(result) else (0, 1, 2):
        for sign in (-1, 1):
            limit = (sign * packing[:, axis]).max()
            if (sign * struck[:, axis]).max() < limit - edge:  # the struck side is no end of the wave's way
                found |= inside & (sign * positions[:, axis] > limit - edge)
    return found
