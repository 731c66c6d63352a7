"""Continuum reference: impact of a rigid punch on an elastic-perfectly-plastic block.

Axisymmetric, small strains, von Mises plasticity, explicit dynamics; see
`granwave.extensions.continuum.punch.solver`.
"""

from __future__ import annotations

from granwave.extensions.continuum.punch.case import ContinuumCase

__all__ = ["ContinuumCase"]
