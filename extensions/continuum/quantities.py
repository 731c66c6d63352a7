"""Values of ``summary.json`` that only finite-element runs have, and the rows of these runs in the
terminal.
"""

from __future__ import annotations

import dataclasses
from typing import Any

from granwave.analysis.quantities import ENTRIES, Quantity

QUANTITIES = (
    Quantity("kind", note="Kind of finite-element run: continuum or sphere-contact."),
    Quantity("n_elements", "Elements", note="Number of elements of the mesh.", after="n_spheres"),
    Quantity("n_bodies", "Bodies",
             note="For the contact of two spheres: 1 for identical spheres, where one sphere on "
                 "the plane of symmetry is sufficient."),
    Quantity("element_steps_per_s", short="speed", digits=".3g", phrase="{} element-steps/s",
             note="Elements times steps, divided by wall time."),
    Quantity("energy_punch_J", "Energy of the punch", note="Kinetic energy of the punch at the "
        "end, in addition to that of the block (energy_kinetic_J); the kinetic energy in figures "
        "of comparisons is the sum."),
    Quantity("dissipated_fraction_error", "Uncertainty of the dissipated fraction",
             short="uncertainty", digits=".2g", phrase="{} of the input",
             note="For a block: the dissipated fraction divided by the root of zone_elements_90, "
                  "and the error of the energy balance, added in quadrature.",
             after="dissipated_fraction"),
    Quantity("zone_elements_90", "Elements of the plastic zone", short="zone, elements", digits="d",
             phrase="{} with 90 % of the plastic dissipation",
             note="Number of elements that contain 90 % of the plastic dissipation, added in "
                  "descending order of energy per volume."),
    Quantity("zone_resolved", "Plastic zone resolved",
             note="True if zone_elements_90 is at least 16: then the mesh resolves the energy of "
                  "the plastic zone to 25 % or better. None if nothing yielded."),
    Quantity("artificial_viscosity_fraction", "Fraction dissipated by artificial viscosity",
             short="artificial viscosity", digits=".3g", phrase="{} of the input",
             note="Energy dissipated by the artificial viscosity of the elements of a block until "
                  "the end, relative to the energy input. The viscosity damps radiated waves, so "
                  "that the fraction grows as long as the run continues.",
             after="dissipated_fraction_error"),
    Quantity("energy_viscous_J", "Viscous energy", note="Energy dissipated by the artificial "
                                                        "viscosity "
        "of the elements."),
    Quantity("energy_hourglass_J", "Hourglass energy", note="Energy of the hourglass control of "
        "the elements."),
    Quantity("energy_contact_J", "Energy of the contact",
             note="Energy dissipated by the contact of the punch; for two spheres, energy of the "
                  "penalty "
                 "springs of their contact."),
    Quantity("energy_damping_J", "Energy dissipated by damping",
             note="Energy dissipated by the damping that keeps the compression of two spheres "
                 "quasi-static."),
    Quantity("hourglass_share", "Hourglass energy relative to the work",
             note="Energy of the hourglass control relative to the work done."),
    Quantity("kinetic_share_max", "Largest kinetic energy, relative to the internal energy",
             short="kinetic energy", digits=".1e", phrase="at most {} of the "
        "internal energy",
             note="Largest ratio of kinetic to internal energy after first yield; small if the "
                 "contact is quasi-static."),
    Quantity("plastic_zone_time_s", "Time of the largest plastic zone",
             note="Time of the largest yielding volume, in the continuum."),
    Quantity("plastic_zone_volume_ever_m3", "Volume that ever yielded", short="plastic zone",
             digits=".4g",
             phrase="{} m3 that ever yielded", note="Volume of all elements that yielded at any "
                 "time, in the continuum.",
             after="plastic_zone_volume_m3"),
    Quantity("plastic_zone_strain", "Strain of the plastic zone",
             note=("Equivalent strain that is exceeded in 1 % of the volume that yielded at any "
                   "time, in the continuum.")),
    Quantity("largest_strain", note="Largest equivalent strain of all elements; it depends on the "
        "element size at the edge of the punch."),
    Quantity("punch_peak_displacement_m", "Largest displacement of the punch", note="Largest "
        "displacement into the block."),
    # static contact of two spheres
    Quantity("effective_radius_m", note="R*, 1/R* = 1/R1 + 1/R2."),
    Quantity("effective_modulus_Pa", note="E*, 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2."),
    Quantity("yield_overlap_m", "Overlap at first yield"),
    Quantity("yield_force_N", "Force at first yield"),
    Quantity("max_overlap_m", "Largest overlap", digits=".4g"),
    Quantity("max_force_N", "Largest force", short="largest force", digits=".5g",
             axis="Force at the largest overlap",
             note="Largest force during the run.", scan_column=True, scan_figure="max_force"),
    Quantity("contact_radius_m", "Largest contact radius", digits=".4g",
             note="Largest value during the run."),
    Quantity("mean_pressure_Pa", note="Force divided by contact area at the end of the first "
        "loading."),
    Quantity("force_deviation_max_percent", "Largest deviation of the force from the law, %",
             short="force - law", digits="+.1f", phrase="{} % at "
        "most",
             note="Largest deviation of the force from the law during first loading."),
    Quantity("force_deviation_rms_percent", "Deviation of the force from the law, rms, %",
             short="minus the law (%, "
        "rms)", digits=".2f", phrase="{} % rms",
             axis="Force - law (%, rms)", note="Root mean square deviation of the force from the "
                                               "law during first loading.", scan_column=True,
             scan_figure="force_deviation"),
    Quantity("*_deviation_*max_percent", note="Largest deviation from the law of force, "
                                              "contact_radius or "
        "mean_pressure, optionally within a range of overlaps normalised by the overlap at first "
        "yield: elastic, 1_to_10, 10_to_50, 50_to_178, beyond_178."),
    Quantity("*_deviation_*rms_percent", note="Root mean square of the same deviations."),
    Quantity("n_unloadings", "Unloadings", note="Number of cycles of unloading and reloading."),
    Quantity("unloading_exponent_min", "Smallest unloading exponent", short="unloading exponents",
             digits=".2f", phrase="from {}",
             note="Smallest n of F/F_max = ((alpha - alpha_R)/(alpha_max - alpha_R))^n, fitted to "
                  "each unloading."),
    Quantity("unloading_exponent_max", "Largest unloading exponent", short="unloading exponents",
             digits=".2f", phrase="to {}",
             note="Largest exponent n of the fits to each unloading."),
    Quantity("unloading_misfit_percent", "Deviation of unloading branches from their fit, %",
             note="Largest deviation of an unloading branch from its fit, relative to its largest "
                 "force."),
    Quantity("unloading_law_difference_percent", "Deviation of unloading branches from the law, %",
             note="Largest deviation of an unloading branch from the law, relative to the peak "
                 "force of the law."),
    Quantity("unloading_plastic_share", "Plastic work in cycles of unloading and reloading",
             note="Largest ratio of the plastic work of a cycle to the "
        "elastic energy released."),
    Quantity("residual_overlap_deviation_percent_of_peak",
             "Deviation of the residual overlap from the law, %",
             note="Deviation of the residual overlap from the law, relative to the largest "
                 "overlap of the cycle."),
    Quantity("reloading_difference_percent", "Difference between reloading and unloading, %",
             note="Largest difference between reloading and unloading, relative to the largest "
                 "force."),
    Quantity("face_force_difference_max_percent",
             "Largest difference between face force and contact force, %",
             note="Largest difference between the force at the loaded face and in the contact; "
                  "small if "
                 "quasi-static."),
    Quantity("face_force_difference_rms_percent",
             "Difference between face force and contact force, rms, %",
             note="Root mean square of this difference of "
                                                       "forces."),
    Quantity("face_force_difference_mean_percent",
             "Difference between face force and contact force, mean, %",
             note="Mean of this difference of forces."),
    Quantity("penetration_share_max", "Largest penetration, relative to the overlap",
             note="Largest penetration of the penalty springs of the "
        "contact, relative to the overlap."),
)  # fmt: skip

_BY_NAME = {entry.name: entry for entry in (*ENTRIES, *QUANTITIES)}


def _changed(name: str, **changes: Any) -> Quantity:
    """Return an entry with another form in the terminal."""
    return dataclasses.replace(_BY_NAME[name], **changes)


def _quantities(*names: str | Quantity) -> tuple[Quantity, ...]:
    return tuple(_BY_NAME[name] if isinstance(name, str) else name for name in names)


#: Rows at the terminal at the end of a run.
CONTINUUM_ROWS = _quantities(
    "n_elements", _changed("end_time_s", digits=".4g"), "end_reason", "n_steps", "energy_input_J",
    "energy_input_normalised", _changed("dissipated_fraction", phrase="{} of the input, "
        "plastically"), "dissipated_fraction_error",
    "artificial_viscosity_fraction", "energy_balance_error", "zone_elements_90",
    "plastic_zone_volume_m3", "plastic_zone_volume_ever_m3", "plastic_zone_depth_m", "plastic_zone_radius_m",
    "max_overlap_m", _changed("max_force_N", short="force at this "
        "overlap"), "contact_radius_m", "force_deviation_max_percent",
    _changed("force_deviation_rms_percent", short="force - law", digits=".1f"),
    "unloading_exponent_min", "unloading_exponent_max", "kinetic_share_max", "wall_time_s", "element_steps_per_s",
)  # fmt: skip
