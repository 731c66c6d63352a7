"""Where the energy of a struck square packing is: the chains that start at struck spheres, these, and the strikers."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.studies.square.runs import Array, PackingRun


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

    def speeds(self, run: PackingRun) -> Array:
        """Velocities along the chain, away from the impact: (n_frames, n_spheres of the chain), m/s."""
        return self.sign * run.velocity[:, self.rows, self.axis]


def chains(run: PackingRun) -> list[Chain]:
    """All chains from struck spheres outwards that hold no other struck sphere; none of a single sphere."""
    found, nx = [], run.case.packing.size[0]
    for row in run.struck.tolist():
        for axis in (0, 1):
            for sign in (1, -1):
                rows = run.chain(row, axis, sign)
                if len(rows) > 1 and len(np.intersect1d(rows, run.struck)) == 1:
                    line = f"Y{row // nx + 1}" if axis == 0 else f"X{row % nx + 1}"
                    found.append(Chain(f"{line} {'+' if sign > 0 else '-'}{'xy'[axis]}", rows, axis, sign))
    return found


def groups(run: PackingRun) -> dict[str, list[Chain]]:
    """Chains by what the source calls them: central and edge chains of an impact in the plane, else central ones."""
    every = chains(run)
    if run.way == "out-of-plane":
        return {"central chains": every}
    return {
        "central chains": [chain for chain in every if chain.axis == run.axis],
        "edge chains": [chain for chain in every if chain.axis != run.axis],
    }


def regions(run: PackingRun) -> dict[str, Array]:
    """Share of the input in each region, the struck spheres apart from their chains: (n_frames,) by name.

    ``walls`` is the elastic energy in walls and floor, ``dissipated`` what is lost; all together are the input.
    """
    n = run.assembly.lattice.n_spheres
    rest = np.ones(run.energy.shape[1], dtype=bool)
    found: dict[str, Array] = {}
    for name, members in groups(run).items():
        rows = np.unique(np.concatenate([chain.rows[1:] for chain in members])) if members else np.empty(0, dtype=int)
        found[name] = run.energy[:, rows].sum(axis=1)
        rest[rows] = False
    found["struck spheres"] = run.energy[:, run.struck].sum(axis=1)
    found["strikers"] = run.energy[:, n:].sum(axis=1)
    rest[run.struck] = rest[n:] = False
    found["other spheres"] = run.energy[:, rest].sum(axis=1)
    return found | {"walls": run.of_ledger("elastic_wall"), "dissipated": run.of_ledger("dissipated")}


def settled(run: PackingRun) -> dict[str, float]:
    """What each region got, over the input.

    The chains at most; the struck spheres and the strikers when the struck ones hold most after they held least, which
    is when they have rebounded; losses at the end.
    """
    found = regions(run)
    struck = found["struck spheres"]
    least = int(struck[struck.argmax() :].argmin() + struck.argmax())
    rebounded = least + int(struck[least:].argmax())
    when = {"struck spheres": rebounded, "strikers": rebounded}
    return {
        name: float(share.max() if name.endswith("chains") else share[when.get(name, -1)])
        for name, share in found.items()
    }
