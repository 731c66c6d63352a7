"""Values of the spheres at the instants of a page: the snapshots of a run, or the more frequent
records of a complete chain.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.result.reader import Result

_MOST_OF_A_CHAIN = 120  # most instants of up to a thousand


@dataclass(frozen=True, eq=False)
class Instants:
    """Values of the spheres at rising times.

    Attributes
    ----------
    times
        Times, s: (n_instants,).
    quantities
        Names that `values` knows, as of a snapshot.
    values
        Function of the number of an instant and a quantity: (n_spheres,) or (n_spheres, 3), SI
        units.
    """

    times: NDArray[np.float64]
    quantities: tuple[str, ...]
    values: Callable[[int, str], NDArray[np.float64]]

    def at(self, numbers: Sequence[int]) -> Instants:
        """Return the instants with these numbers."""
        return Instants(
            self.times[list(numbers)],
            self.quantities,
            lambda n, name: self.values(numbers[n], name),
        )


def instants_of(result: Result) -> Instants:
    """Return the instants of a run: its snapshots, with 0 for missing records, or the record of a
    chain.
    """
    if "chain" in result and len(result["chain/time"]) > result.n_frames:
        return _of_chain(result)
    return Instants(
        result.frame_times,
        result.quantities,
        lambda number, name: np.nan_to_num(result.frame(number, name)),
    )


def _of_chain(result: Result) -> Instants:
    """Return velocity and displacement, which point along the chain, and the largest force of each
    bead's contacts.
    """
    time = result["chain/time"]
    n = result.n_spheres
    rows = np.unique(
        np.linspace(0, len(time) - 1, min(_MOST_OF_A_CHAIN, len(time))).round().astype(int)
    )
    beads = result.rows(result["chain/id"])
    force = np.zeros((len(time), n))
    row = dict(zip(result["chain/id"].tolist(), beads.tolist(), strict=True))
    for end in ("chain/contact_i", "chain/contact_j"):
        for contact, sphere in enumerate(result[end].tolist()):
            if sphere in row:  # else the face of a bar
                np.maximum(
                    force[:, row[sphere]],
                    result["chain/contact_force"][:, contact],
                    out=force[:, row[sphere]],
                )
    scalars = {"contact_force": force, "peak_force": np.maximum.accumulate(force, axis=0)}
    along = {name: result[f"chain/{name}"] for name in ("velocity", "displacement")}

    def values(number: int, quantity: str) -> NDArray[np.float64]:
        if quantity in scalars:
            return np.asarray(scalars[quantity][rows[number]])
        found = np.zeros((n, 3))
        found[beads, 2] = along[quantity][rows[number]]
        return found

    return Instants(time[rows], (*along, *scalars), values)
