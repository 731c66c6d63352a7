"""Work of loading a contact, for bounds on the energy that it absorbs."""

from __future__ import annotations

from granwave._contact_laws import ContactLaw
from granwave.lammps_inputs.roots import brentq

# upper limit of searches, in effective radii, far beyond the range of all laws
LARGEST_OVERLAP = 2.0


def work_to_force(law: ContactLaw, force: float) -> float:
    """Return the work of loading a contact up to a force (N), J."""
    low = 0.0
    high = LARGEST_OVERLAP * law.effective_radius
    if law.loading_force(high) <= force:
        return float(law.loading_work(high))
    overlap = brentq(
        lambda overlap: law.loading_force(overlap) - force, low, high, xtol=1e-16, rtol=1e-10
    )
    return float(law.loading_work(overlap))
