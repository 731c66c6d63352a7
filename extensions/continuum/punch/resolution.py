"""Resolution of the plastic zone of a block by the mesh, and the energy that artificial viscosity
dissipates.

The stress is singular at the edge of the punch, where yielding begins: a small zone consists of the
few elements there, and its energy depends on where their nodes are. Difference between the largest
and the smallest dissipated fraction if the nodes at the edge are shifted by -3/8, -1/8, 1/8 and
3/8 of an element (brass, D = 10 mm, taper 0.1 mm), relative to their mean; N elements hold 90 % of
the plastic dissipation:

    kg, m/s         4000 elements     8000 elements     16 000 elements
                    N     difference  N     difference  N     difference
    0.00445, 12     1     1.46        2     0.09        3     0.77
    0.1,      3     1     1.42        2     0.80        4     0.31
    0.1,      4     4     0.59        5     0.52        9     0.40
    0.00445, 20     5     0.37        9     0.33        16    0.23
    0.1,      6     13    0.13        23    0.13        42    0.15
    0.1,      8     45    0.18        86    0.13        167   0.066
    0.1,     12     166   0.040       330   0.032       646   0.016
    0.00445, 40     217   0.033       440   0.021       873   0.012

Half of every difference is below ``1/sqrt(N)``, which is the uncertainty of the dissipated fraction
here, together with the error of the energy balance.

The viscosity damps the waves that the impact radiates, at their front and, in a run that continues,
in the coarse elements far from the punch: half of the input of a light punch within 0.5 ms.
Without viscosity this energy remains in the waves; force, rebound and plastic dissipation of the
block do not change (`tests/extensions/continuum/test_block_elastic.py`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.incomplete_values import DISSIPATED_FRACTION
from granwave.analysis.measures.zone_resolution import ERROR, RESOLVED, is_unresolved

ELEMENTS = "zone_elements_90"
VISCOUS = "artificial_viscosity_fraction"

_HELD = 0.9  # fraction of the plastic dissipation in the counted elements
FEWEST = 16  # elements of a zone whose size and energy are resolved, to 25 % and better
LARGE_LOSS = 0.05  # viscous fraction that is mentioned
LARGE_STRAIN = 0.1
_ROUNDING = 1e-12


def zone_elements(work: NDArray[np.float64], volume: NDArray[np.float64]) -> int:
    """Return the number of elements that hold 90 % of the plastic dissipation, those of the highest
    energy per volume first; 0 without dissipation.

    Parameters
    ----------
    work, volume
        Plastic dissipation, J, and volume, m^3, of the elements, (n_elements,).
    """
    held = np.cumsum(work[np.lexsort((volume, -work / volume))])
    if held[-1] <= 0:
        return 0
    return int(np.searchsorted(held, (1 - _ROUNDING) * _HELD * held[-1])) + 1


def resolution(fraction: float, n_elements: int, balance_error: float) -> dict[str, Any]:
    """Return the part of the summary on the resolution of the zone.

    Parameters
    ----------
    fraction
        Dissipated fraction of the input.
    n_elements
        As of `zone_elements`.
    balance_error
        Error of the energy balance / input.
    """
    of_mesh = fraction / math.sqrt(n_elements) if n_elements else 0.0
    return {
        ERROR: math.hypot(of_mesh, balance_error),
        ELEMENTS: n_elements,
        RESOLVED: n_elements >= FEWEST if n_elements else None,
    }


def doubts(summary: Mapping[str, Any]) -> list[str]:
    """Return sentences without full stop on doubtful results of a block."""
    found = (_strain(summary), _zone(summary), _viscosity(summary))
    return [text for text in found if text]


def _strain(summary: Mapping[str, Any]) -> str:
    """Return a sentence on large strains."""
    if summary.get("plastic_zone_strain", 0.0) <= LARGE_STRAIN:
        return ""
    return (
        "strains are not small: 1 % of the plastic zone exceeds "
        f"{summary['plastic_zone_strain']:.2f}, the largest is "
        f"{summary['largest_strain']:.2f}; expected below {LARGE_STRAIN:g}. The solution "
        "assumes small strains: use a lower punch.velocity or punch.mass"
    )


def _zone(summary: Mapping[str, Any]) -> str:
    """Return a sentence on a plastic zone that the mesh does not resolve."""
    if not is_unresolved(summary):
        return ""
    count = summary[ELEMENTS]
    held = "1 element holds" if count == 1 else f"{count} elements hold"
    fraction = 100 * summary[DISSIPATED_FRACTION]
    error = 100 * summary[ERROR]
    return (
        f"the plastic zone is not resolved: {held} 90 % of the plastic dissipation, expected at "
        f"least {FEWEST}. Its size is that of the elements, and the dissipated fraction is "
        f"{fraction:.2g} ± {error:.2g} %. Use more run.elements or a smaller run.edge_size, or a "
        "higher punch.velocity"
    )


def _viscosity(summary: Mapping[str, Any]) -> str:
    """Return a sentence on a large loss to artificial viscosity."""
    loss = summary.get(VISCOUS)
    if loss is None or loss <= LARGE_LOSS:
        return ""
    return (
        f"artificial viscosity dissipates {100 * loss:.2g} % of the input: it damps the waves that "
        "leave the punch. Kinetic and elastic energies at the end depend on it; force, rebound and "
        "plastic dissipation do not"
    )
