"""Name of the grains of finished runs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from granwave.lammps_inputs.packing.cylinders import GRAINS, SPHERES, grains_called


def grains_called_in(summaries: Iterable[Mapping[str, Any]]) -> str:
    """Return ``spheres``, ``cylinders``, or ``grains`` where runs have both."""
    found = {
        grains_called(summary.get("n_spheres") or 0, summary.get("n_cylinders") or 0)
        for summary in summaries
        if summary.get("n_spheres")
    }
    return found.pop() if len(found) == 1 else GRAINS if found else SPHERES
