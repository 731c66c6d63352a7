"""Material that did the dissipation of an impact, of spheres or of the elements of a block."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.impact.dissipation import cumulated
from granwave.analysis.result.reader import Result


@dataclasses.dataclass(frozen=True, eq=False)
class Involved:
    """Material in descending order of its dissipation, cumulated; arrays (n,).

    Attributes
    ----------
    fraction
        Of the input, dissipated in the material so far.
    volume
        Of the solid, m^3.
    """

    fraction: NDArray[np.float64]
    volume: NDArray[np.float64]

    def part(self, share: float) -> tuple[float, float]:
        """Fraction of the input and volume of the least material that did a share of the dissipation."""
        enough = self.enough(share)
        return float(self.fraction[enough]), float(self.volume[enough])

    def enough(self, share: float) -> int:
        """Last place of the least material that did a share of the dissipation."""
        return int(np.searchsorted(self.fraction, share * self.fraction[-1]))


def spheres_involved(result: Result, energy_input: float) -> Involved:
    """Return the spheres that dissipated; the input is in J."""
    fraction, count = cumulated(result["spheres/dissipated_energy"], energy_input)
    return Involved(fraction, math.pi * result.case.packing.diameter**3 / 6 * count)


def elements_involved(path: Path, energy_input: float) -> Involved:
    """Return the elements of a block that dissipated.

    Parameters
    ----------
    path
        The ``result.h5`` of a continuum run.
    energy_input
        J.

    Raises
    ------
    OSError, KeyError
        It cannot be read, or is another file.
    """
    with h5py.File(path, "r") as file:
        density, volume = file["fields/plastic_energy"][()], file["element_volume"][()]
    order = np.argsort(-density, kind="stable")
    order = order[: np.count_nonzero(density > 0)]
    return Involved(np.cumsum(density[order] * volume[order]) / energy_input, np.cumsum(volume[order]))
