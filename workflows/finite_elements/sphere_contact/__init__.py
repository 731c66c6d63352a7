"""Static contact of two elastic-perfectly-plastic spheres, the basis of the contact law.

Axisymmetric, large displacement, von Mises plasticity. See
`granwave.workflows.finite_elements.sphere_contact.solver`.
"""

from __future__ import annotations

from granwave.workflows.finite_elements.sphere_contact.case import SphereContactCase

__all__ = ["SphereContactCase"]
