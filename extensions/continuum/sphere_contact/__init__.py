"""Static contact of two elastic-perfectly-plastic spheres, the basis of the contact law.

Axisymmetric, large displacement, von Mises plasticity. See
`granwave.extensions.continuum.sphere_contact.solver`.
"""

from __future__ import annotations

from granwave.extensions.continuum.sphere_contact.case import SphereContactCase

__all__ = ["SphereContactCase"]
