"""Static contact of two elastic-perfectly-plastic spheres, the basis of the contact law (thesis 2.1, 3.1).

Axisymmetric, large displacement, von Mises plasticity. See `granwave.workflows.finite_elements.sphere_contact.solver`.
"""

from granwave.workflows.finite_elements.sphere_contact.case import SphereContactCase
from granwave.workflows.finite_elements.sphere_contact.run import run_sphere_contact

__all__ = ["SphereContactCase", "run_sphere_contact"]
