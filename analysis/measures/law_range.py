"""Values of a run that its contacts beyond the range of the law determine: forces, overlaps and
dissipation, which the law extrapolates at overlaps above 0.2 R*.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

#: Mark of a value in a table, and its meaning.
BEYOND_LAW = "‡"
BEYOND_LAW_MEANING = "with contacts beyond the range of the law (0.2 R*)"
_CONTACTS = "contacts_beyond_law"
_OF_CONTACTS = (
    "peak_force_N", "peak_force_with_walls_N", "max_force_N", "peak_overlap_m",
    "dissipated_fraction", "plastic_fraction", "energy_dissipated_J",
    "energy_dissipated_plastic_J", "restitution",
)  # fmt: skip


def contacts_beyond_law(summary: Mapping[str, Any]) -> int:
    """Return the number of contacts of a run beyond the range of the law; 0 if it is unknown."""
    value = summary.get(_CONTACTS)
    return int(value) if isinstance(value, int | float) else 0


def is_beyond_law(name: str, summary: Mapping[str, Any]) -> bool:
    """Return True for a value of a run that contacts beyond the range of the law determine."""
    return name in _OF_CONTACTS and contacts_beyond_law(summary) > 0
