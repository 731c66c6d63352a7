"""Values of ``summary.json`` of runs of finite elements that no run of spheres has, and the rows of
both at the terminal.
"""

from __future__ import annotations

import dataclasses
from typing import Any

from granwave.analysis.quantities import ENTRIES, Quantity

QUANTITIES = (
    Quantity("kind", note="Of finite-element runs: continuum or sphere-contact."),
    Quantity("n_elements", "Elements", note="Of the finite-element mesh.", after="n_spheres"),
    Quantity("n_bodies", "Bodies",
             note="Of the contact of two spheres: 1 where both are equal, and one on the plane of symmetry is enough."),
    Quantity("element_steps_per_s", short="speed", digits=".3g", phrase="{} element-steps/s",
             note="Elements times steps over wall time."),
    Quantity("energy_punch_J", "Energy of the punch", note="At the end: what is left of the punch's kinetic energy."),
    Quantity("energy_viscous_J", "Viscous energy", note="That the artificial viscosity of the elements took."),
    Quantity("energy_hourglass_J", "Hourglass energy", note="In the hourglass control of the elements."),
    Quantity("energy_contact_J", "Energy of the contact",
             note="That the contact of the punch took; of two spheres: in the penalty springs of their contact."),
    Quantity("energy_damping_J", "Energy taken by damping",
             note="That damping took, which keeps the pressing of two spheres static."),
    Quantity("hourglass_share", note="Energy of the hourglass control over the work done."),
    Quantity("kinetic_share_max", short="kinetic energy", digits=".1e", phrase="{} of the internal, at most",
             note="Largest kinetic over internal energy from first yield on: small if the contact is static."),
    Quantity("plastic_zone_time_s", "Time of the largest plastic zone",
             note="When the volume at yield was largest, in the continuum."),
    Quantity("plastic_zone_volume_ever_m3", "Volume that ever yielded", short="plastic zone", digits=".4g",
             phrase="{} m3 that ever yielded", note="Of the elements that yielded at any time, in the continuum.",
             after="plastic_zone_volume_m3"),
    Quantity("plastic_zone_strain", "Strain of the plastic zone",
             note="Equivalent strain that 1 % of the volume that ever yielded exceeds, in the continuum."),
    Quantity("largest_strain", note="Of any element; it depends on the size of the elements at the punch's edge."),
    Quantity("punch_peak_displacement_m", "Largest displacement of the punch", note="Into the block."),
    # static contact of two spheres
    Quantity("effective_radius_m", note="R*, 1/R* = 1/R1 + 1/R2."),
    Quantity("effective_modulus_Pa", note="E*, 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2."),
    Quantity("yield_overlap_m", "Overlap at first yield"),
    Quantity("yield_force_N", "Force at first yield"),
    Quantity("max_overlap_m", "Largest overlap", digits=".4g"),
    Quantity("max_force_N", "Largest force", short="largest force", digits=".5g", axis="Force at the largest overlap",
             note="Of the run.", scan_column=True, scan_figure="max_force"),
    Quantity("contact_radius_m", digits=".4g", note="Largest of the run."),
    Quantity("mean_pressure_Pa", note="At the end of the first loading: force over the area of contact."),
    Quantity("force_deviation_max_percent", short="force less the law", digits="+.1f", phrase="{} % at most",
             note="Largest deviation of the force of first loading from the law's."),
    Quantity("force_deviation_rms_percent", short="less the law (%, rms)", digits=".2f", phrase="{} % rms",
             axis="Force less the law (%, rms)", note="The same, root mean square.", scan_column=True,
             scan_figure="force_deviation"),
    Quantity("*_deviation_*max_percent", note="The same of force, contact_radius or mean_pressure, perhaps within a "
             "range of overlaps over that at first yield: elastic, 1_to_10, 10_to_50, 50_to_178, beyond_178."),
    Quantity("*_deviation_*rms_percent", note="The same, root mean square."),
    Quantity("n_unloadings", "Unloadings", note="Cycles of unloading and reloading."),
    Quantity("unloading_exponent_min", short="unloading exponents", digits=".2f", phrase="from {}",
             note="n of F/F_max = ((alpha - alpha_R)/(alpha_max - alpha_R))^n, fitted to each unloading."),
    Quantity("unloading_exponent_max", short="unloading exponents", digits=".2f", phrase="to {}",
             note="The same, the largest."),
    Quantity("unloading_misfit_percent",
             note="Largest deviation of an unloading from its fit, over its largest force."),
    Quantity("unloading_law_difference_percent",
             note="Largest deviation of an unloading from the law's, over the law's peak."),
    Quantity("unloading_plastic_share", note="Plastic work of a cycle over the elastic energy released, at most."),
    Quantity("residual_overlap_deviation_percent_of_peak",
             note="Residual overlap less the law's, over the cycle's largest overlap."),
    Quantity("reloading_difference_percent",
             note="Largest difference between reloading and unloading, over the largest force."),
    Quantity("face_force_difference_max_percent",
             note="Force at the pressed face against that in the contact: small if static."),
    Quantity("face_force_difference_rms_percent", note="The same, root mean square."),
    Quantity("face_force_difference_mean_percent", note="The same, mean."),
    Quantity("penetration_share_max", note="Largest penetration of the contact's penalty springs over the overlap."),
)  # fmt: skip

_BY_NAME = {entry.name: entry for entry in (*ENTRIES, *QUANTITIES)}


def _changed(name: str, **changes: Any) -> Quantity:
    """Return an entry that the terminal shows in another way."""
    return dataclasses.replace(_BY_NAME[name], **changes)


def _quantities(*names: str | Quantity) -> tuple[Quantity, ...]:
    return tuple(_BY_NAME[name] if isinstance(name, str) else name for name in names)


#: Rows at the terminal at the end of a run.
CONTINUUM_ROWS = _quantities(
    "n_elements", _changed("end_time_s", digits=".4g"), "end_reason", "n_steps", "energy_input_J",
    "energy_input_normalised", _changed("dissipated_fraction", phrase="{} of it, plastically"), "energy_balance_error",
    "plastic_zone_volume_m3", "plastic_zone_volume_ever_m3", "plastic_zone_depth_m", "plastic_zone_radius_m",
    "max_overlap_m", _changed("max_force_N", short="force there"), "contact_radius_m", "force_deviation_max_percent",
    _changed("force_deviation_rms_percent", short="force less the law", digits=".1f"),
    "unloading_exponent_min", "unloading_exponent_max", "kinetic_share_max", "wall_time_s", "element_steps_per_s",
)  # fmt: skip
