"""Continuum reference: impact of a rigid punch on an elastic-perfectly-plastic block (thesis 5.1.2, 5.4).

Axisymmetric, small strains, von Mises plasticity, explicit dynamics; see
`granwave.workflows.finite_elements.punch.solver`.
"""

from granwave.workflows.finite_elements.punch.case import ContinuumCase
from granwave.workflows.finite_elements.punch.run import run_continuum

__all__ = ["ContinuumCase", "run_continuum"]
