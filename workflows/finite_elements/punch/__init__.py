"""Continuum reference: impact of a rigid punch on an elastic-perfectly-plastic block.

Axisymmetric, small strains, von Mises plasticity, explicit dynamics; see
`granwave.workflows.finite_elements.punch.solver`.
"""

from __future__ import annotations

from granwave.workflows.finite_elements.punch.case import ContinuumCase

__all__ = ["ContinuumCase"]
