"""Resolution of a plastic zone by the parts of a body: values of summaries that are uncertain since
the zone consists of few parts.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from granwave.analysis.formatting.numbers import interval
from granwave.analysis.measures.incomplete_values import DISSIPATED_FRACTION

RESOLVED = "zone_resolved"  # False if the zone has too few parts
ERROR = "dissipated_fraction_error"  # uncertainty of this fraction
_ENERGY = "energy_dissipated_J"
_INPUT = "energy_input_J"
_NOTED = 0.05  # relative uncertainty of a fraction that is printed with it


def is_unresolved(summary: Mapping[str, Any]) -> bool:
    """Return True for a plastic zone of too few parts: its size is that of the parts."""
    return summary.get(RESOLVED) is False


def error_of(name: str, summary: Mapping[str, Any]) -> float | None:
    """Return the uncertainty of the dissipated fraction or energy if it is large, else None."""
    error = summary.get(ERROR)
    fraction = summary.get(DISSIPATED_FRACTION)
    if not error or not fraction or error <= _NOTED * fraction:
        return None
    if name == DISSIPATED_FRACTION:
        return float(error)
    energy = summary.get(_INPUT)
    return float(error * energy) if name == _ENERGY and energy else None


def percent_with_error(fraction: float, error: float) -> str:
    """Return a fraction and its uncertainty in per cent: ``0.32 ± 0.23 %``."""
    return f"{interval(100 * fraction, 100 * error)} %"
