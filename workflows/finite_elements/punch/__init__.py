"""Continuum reference: impact of a rigid punch on an elastic-perfectly-plastic block.

Axisymmetric, small strains, von Mises plasticity, explicit dynamics; see
`granwave.workflows.finite_elements.punch.solver`.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from granwave.workflows.finite_elements.punch.case import ContinuumCase

if TYPE_CHECKING:
    from granwave.workflows.finite_elements.punch.run import run_continuum

__all__ = ["ContinuumCase", "run_continuum"]


def __getattr__(name: str) -> object:
    """Import the solver, which takes seconds to load, when it is first used."""
    if name != "run_continuum":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module("granwave.workflows.finite_elements.punch.run"), name)
