"""Continuum reference: impact of a rigid punch on an elastic-perfectly-plastic block (thesis 5.1.2, 5.4).

Axisymmetric, small strains, von Mises plasticity, explicit dynamics; see
`granwave.workflows.finite_elements.punch.solver`.
"""

from __future__ import annotations

from granwave.workflows.finite_elements.punch.case import ContinuumCase

__all__ = ["ContinuumCase"]
