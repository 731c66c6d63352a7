"""The continuum reference: a rigid punch hits an elastic-perfectly-plastic block (thesis 5.1.2, 5.4).

Axisymmetric, small strains, von Mises plasticity, explicit dynamics. See `granwave.analysis.continuum.solver`.
"""

from granwave.analysis.continuum.case import ContinuumCase
from granwave.analysis.continuum.run import run_continuum

__all__ = ["ContinuumCase", "run_continuum"]
