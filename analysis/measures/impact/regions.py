"""Energy of a struck square packing by region: the chains that start at struck spheres, these, and the strikers."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.waves.directions import energy_of_spheres, struck_rows

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
    position
        At the start: (n_spheres, 3), m.
    velocity
        (n_frames, n_spheres, 3), m/s.
    energy
        Kinetic, and elastic halved between spheres, over the input: (n_frames, n_spheres).
    walls, dissipated
        Elastic energy in walls and floor, and what is lost, over the input: (n_frames,).
    struck
        Rows of the spheres that a striker touches.
    size
        Spheres along x and y.
    axis
        Along which the fastest striker comes: 0, 1, 2.
    """

    time: Array
    position: Array
    velocity: Array
    energy: Array
    walls: Array
    dissipated: Array
    struck: NDArray[np.int64]
    size: tuple[int, int]
    axis: int

    @classmethod
    def of(cls, result: Result) -> Snapshots:
        """Regions of a result."""
        frames, time = range(result.n_frames), result.frame_times

        def share(name: str) -> Array:
            return np.interp(time, result["energy/time"], result[f"energy/{name}"] / result["energy/input"][-1])

        nx, ny = result.case.packing.size
        return cls(
            time,
            result["spheres/position"],
            np.stack([result.frame(frame, "velocity") for frame in frames]),
            np.stack([energy_of_spheres(result, frame) for frame in frames]) / result.energy_input,
            share("elastic_wall"),
            share("dissipated"),
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


def regions(of: Snapshots) -> dict[str, Array]:
    """Share of the input in each region, the struck spheres apart from their chains: (n_frames,) by name.

    ``walls`` is the elastic energy in walls and floor, ``dissipated`` what is lost; all together are the input.
    """
    n = of.size[0] * of.size[1]
    rest = np.ones(of.energy.shape[1], dtype=bool)
    found: dict[str, Array] = {}
    for name, members in groups(of).items():
        rows = np.unique(np.concatenate([chain.rows[1:] for chain in members])) if members else np.empty(0, dtype=int)
        found[name] = of.energy[:, rows].sum(axis=1)
        rest[rows] = False
    found["struck spheres"] = of.energy[:, of.struck].sum(axis=1)
    found["strikers"] = of.energy[:, n:].sum(axis=1)
    rest[of.struck] = rest[n:] = False
    found["other spheres"] = of.energy[:, rest].sum(axis=1)
    return found | {"walls": of.walls, "dissipated": of.dissipated}


def settled(of: Snapshots) -> dict[str, float]:
    """Energy of each region over the input.

    The chains at most; the struck spheres and the strikers when the struck ones hold most after they held least, which
    is when they have rebounded; losses at the end.
    """
    found = regions(of)
    struck = found["struck spheres"]
    least = int(struck[struck.argmax() :].argmin() + struck.argmax())
    rebounded = least + int(struck[least:].argmax())
    when = {"struck spheres": rebounded, "strikers": rebounded}
    return {
        name: float(share.max() if name.endswith("chains") else share[when.get(name, -1)])
        for name, share in found.items()
    }
