"""Instants of a run that a page shows: its snapshots, or those at which a whole chain was recorded, which are more."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.result.reader import Result

_MOST_OF_A_CHAIN = 120  # instants of up to a thousand


class Instants(ABC):
    """Values of the spheres at rising times.

    Attributes
    ----------
    times
        Times, s: (n_instants,).
    quantities
        Names that `values` knows, as of a snapshot.
    """

    times: NDArray[np.float64]
    quantities: tuple[str, ...]

    @abstractmethod
    def values(self, number: int, quantity: str) -> NDArray[np.float64]:
        """Return a quantity of all spheres at an instant: (n_spheres,) or (n_spheres, 3), SI units."""


def instants_of(result: Result) -> Instants:
    """Return the instants of a run."""
    if "chain" in result and len(result["chain/time"]) > result.n_frames:
        return _History(result)
    return _Snapshots(result)


class _Snapshots(Instants):
    def __init__(self, result: Result) -> None:
        self.times, self.quantities, self._result = result.frame_times, result.quantities, result

    def values(self, number: int, quantity: str) -> NDArray[np.float64]:
        """Read a snapshot, with 0 for what was not recorded."""
        return np.nan_to_num(self._result.frame(number, quantity))


class _History(Instants):
    """Record of a chain: velocity and displacement along it, and the largest force of each bead's contacts."""

    quantities = ("velocity", "displacement", "contact_force", "peak_force")

    def __init__(self, result: Result) -> None:
        time = result["chain/time"]
        self._rows = np.unique(np.linspace(0, len(time) - 1, min(_MOST_OF_A_CHAIN, len(time))).round().astype(int))
        self.times, self._n = time[self._rows], result.n_spheres
        self._beads = result.rows(result["chain/id"])
        force = result["chain/contact_force"]
        self._force = np.zeros((len(time), self._n))
        row = dict(zip(result["chain/id"].tolist(), self._beads.tolist(), strict=True))
        for end in ("chain/contact_i", "chain/contact_j"):
            for contact, sphere in enumerate(result[end].tolist()):
                if sphere in row:  # else the face of a bar
                    bead = self._force[:, row[sphere]]
                    np.maximum(bead, force[:, contact], out=bead)
        self._peak = np.maximum.accumulate(self._force, axis=0)
        self._along = {name: result[f"chain/{name}"] for name in ("velocity", "displacement")}

    def values(self, number: int, quantity: str) -> NDArray[np.float64]:
        """Return what was recorded; vectors point along the chain."""
        row = self._rows[number]
        if quantity == "contact_force":
            return self._force[row]
        if quantity == "peak_force":
            return self._peak[row]
        found = np.zeros((self._n, 3))
        found[self._beads, 2] = self._along[quantity][row]
        return found
