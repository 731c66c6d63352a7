"""Values of a summary that are due to rounding, and are zero."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_ROUNDING = 1e-12  # value / scale that is due to rounding
_FRACTION = "_fraction"  # end of the names of fractions of the input energy
_KINDS = ("_J", "_N")  # ends of the names of energies and forces


def without_rounding(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return a summary with 0 in place of energies and forces below 1e-12 of the largest value of
    their kind, and in place of fractions below 1e-12.
    """
    limits = {kind: _ROUNDING * _largest(summary, kind) for kind in _KINDS}
    limits[_FRACTION] = _ROUNDING
    values: dict[str, Any] = {}
    for name, value in summary.items():
        limit = max((limits[kind] for kind in limits if name.endswith(kind)), default=0.0)
        is_rounding = _is_number(value) and abs(value) < limit
        values[name] = 0.0 if is_rounding and value else value
    return values


def _largest(summary: Mapping[str, Any], kind: str) -> float:
    """Return the largest finite magnitude of the values of a kind."""
    sizes = [
        abs(value) for name, value in summary.items() if name.endswith(kind) and _is_number(value)
    ]
    return max((size for size in sizes if size < float("inf")), default=0.0)


def _is_number(value: Any) -> bool:
    """Return True for a number."""
    return isinstance(value, int | float) and not isinstance(value, bool)
