"""Chains of a struck square packing that start at struck spheres."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.waves.directions import struck_rows

if TYPE_CHECKING:
    from granwave.analysis.result.reader import Result
    from granwave.lammps_inputs.case.case import Case

Array = NDArray[np.float64]


@dataclasses.dataclass(frozen=True, eq=False)
class Snapshots:
    """Snapshots of a small square packing, as they are needed of every sphere; strikers come last.

    Attributes
    ----------
    time
        (n_frames,), s.
    velocity
        (n_frames, n_spheres, 3), m/s.
    struck
        Rows of the spheres that a striker touches.
    size
        Spheres along x and y.
    axis
        Along which the fastest striker comes: 0, 1, 2.
    """

    time: Array
    velocity: Array
    struck: NDArray[np.int64]
    size: tuple[int, int]
    axis: int

    @classmethod
    def of(cls, result: Result) -> Snapshots:
        """Regions of a result."""
        nx, ny = result.case.packing.size
        return cls(
            result.frame_times,
            np.stack([result.frame(frame, "velocity") for frame in range(result.n_frames)]),
            struck_rows(result),
            (nx, ny),
            int(np.argmax(np.abs(striker_velocity(result.case)))),
        )


def striker_velocity(case: Case) -> Array:
    """Velocity of the fastest striker: (3,), m/s."""
    return np.array(max((striker.velocity for striker in case.striker), key=np.linalg.norm))


@dataclasses.dataclass(frozen=True, eq=False)
class Chain:
    """A chain of spheres that begins at a struck one.

    Attributes
    ----------
    name
        Where it goes, in the source's numbers: ``Y10 +x``.
    rows
        Of its spheres, the struck one first.
    axis, sign
        Its direction.
    """

    name: str
    rows: NDArray[np.int64]
    axis: int
    sign: int

    def speeds(self, of: Snapshots) -> Array:
        """Velocities along the chain, away from the impact: (n_frames, n_spheres of the chain), m/s."""
        return self.sign * of.velocity[:, self.rows, self.axis]


def chains(of: Snapshots) -> list[Chain]:
    """All chains from struck spheres outwards that hold no other struck sphere; none of a single sphere."""
    found, nx = [], of.size[0]
    for row in of.struck.tolist():
        place = row % nx, row // nx
        for axis in (0, 1):
            for sign in (1, -1):
                count = of.size[axis] - place[axis] if sign > 0 else place[axis] + 1
                rows = row + sign * (1, nx)[axis] * np.arange(count)
                if count > 1 and len(np.intersect1d(rows, of.struck)) == 1:
                    line = f"Y{place[1] + 1}" if axis == 0 else f"X{place[0] + 1}"
                    found.append(Chain(f"{line} {'+' if sign > 0 else '-'}{'xy'[axis]}", rows, axis, sign))
    return found


def groups(of: Snapshots) -> dict[str, list[Chain]]:
    """Chains by what the source calls them: central and edge chains of an impact in the plane, else central ones."""
    every = chains(of)
    if of.axis == 2:
        return {"central chains": every}
    return {
        "central chains": [chain for chain in every if chain.axis == of.axis],
        "edge chains": [chain for chain in every if chain.axis != of.axis],
    }
