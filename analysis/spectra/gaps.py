"""Edges of bands and gaps between them."""

from __future__ import annotations

import dataclasses

import numpy as np

from granwave.analysis.spectra.bands import Bands
from granwave.analysis.spectra.network import Array

_LEAST = 1e-6  # of the highest frequency: bands that only touch leave no gap


@dataclasses.dataclass(frozen=True)
class Gap:
    """Frequencies at which no wave travels along the path.

    Attributes
    ----------
    low, high
        Its edges, Hz; ``high`` is infinite above the highest band, ``low`` zero below the lowest.
    below
        Number of bands below it.
    """

    low: float
    high: float
    below: int

    @property
    def middle(self) -> float:
        """Middle of the gap, Hz."""
        return (self.low + self.high) / 2

    @property
    def relative_width(self) -> float:
        """Width over the middle."""
        return (self.high - self.low) / self.middle if np.isfinite(self.high) else np.inf


def band_edges(bands: Bands) -> Array:
    """Return the lowest and highest frequency of each band along the path: (n_bands, 2), Hz; NaN without any."""
    frequency = bands.frequency
    low = np.where(np.isnan(frequency), np.inf, frequency).min(axis=0)
    high = np.where(np.isnan(frequency), -np.inf, frequency).max(axis=0)
    there = np.isfinite(low)
    return np.stack([np.where(there, low, np.nan), np.where(there, high, np.nan)], axis=1)


def gaps(bands: Bands) -> list[Gap]:
    """Return the gaps between the bands of a path, and those below the first and above the last, by rising frequency.

    Of a large cell the last one is left out where only the lowest bands were sought.
    """
    edges = band_edges(bands)
    order = np.argsort(edges[:, 0])
    found: list[Gap] = []
    top, least = 0.0, _LEAST * float(np.nanmax(edges, initial=0.0))
    for n, (low, high) in enumerate(edges[order].tolist()):
        if np.isnan(low):
            continue
        if low > top + least:
            found.append(Gap(top, low, n))
        top = max(top, high)
    if bands.complete:
        found.append(Gap(top, np.inf, len(edges)))
    return found
