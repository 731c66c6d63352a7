"""Static contact of two elastic-perfectly-plastic spheres, the basis of the contact law.

Axisymmetric, large displacement, von Mises plasticity. See `granwave.workflows.finite_elements.sphere_contact.solver`.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from granwave.workflows.finite_elements.sphere_contact.case import SphereContactCase

if TYPE_CHECKING:
    from granwave.workflows.finite_elements.sphere_contact.run import run_sphere_contact

__all__ = ["SphereContactCase", "run_sphere_contact"]


def __getattr__(name: str) -> object:
    """Import the solver, which takes seconds to load, when it is first used."""
    if name != "run_sphere_contact":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module("granwave.workflows.finite_elements.sphere_contact.run"), name)
