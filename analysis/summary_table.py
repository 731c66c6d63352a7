"""Main values of a run, as the terminal and notebooks show them, and sentences on values of ``summary.json``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from granwave.analysis.formatting.values import grains_called_in
from granwave.analysis.measures.zone_size import bounds_in_words
from granwave.analysis.quantities import CONTINUUM_ROWS, FRICTION_SHARES, RUN_ROWS, SHARES, Quantity, quantity
from granwave.lammps_inputs.packing.cylinders import GRAINS, in_grains

_ZONE_AFTER = "plastic_zone_radius_m"  # the row that the size of the plastic zone follows
_GROWING = {"plastic_zone_depth_m": "depth", "plastic_zone_radius_m": "radius"}  # as `zone_growing` calls them


class Row(NamedTuple):
    """A row: label (empty: that of the row before), value as text, and the keys of summary.json that it shows."""

    label: str
    text: str
    keys: tuple[str, ...]


def lines(rows: Sequence[tuple[str, str]]) -> str:
    """Labels and values under each other."""
    width = max(len(label) for label, _ in rows)
    return "\n".join(f"{label:<{width}}  {text}" for label, text in rows)


def summary_rows(summary: Mapping[str, Any], *, continuum: bool = False) -> list[Row]:
    """Rows of the main values of a summary, as far as there are values.

    Parameters
    ----------
    summary
        Content of summary.json.
    continuum
        True for a run of finite elements.
    """
    left_out = () if continuum or summary.get("friction_fraction") else FRICTION_SHARES
    shown = [entry for entry in (CONTINUUM_ROWS if continuum else RUN_ROWS) if entry.name not in left_out]
    return _rows(shown, summary)


def summary_table(summary: Mapping[str, Any]) -> str:
    """The main values of a summary."""
    return _text(summary_rows(summary))


def continuum_table(summary: Mapping[str, Any]) -> str:
    """The main values of the summary of a continuum run."""
    return _text(summary_rows(summary, continuum=True))


def explanation(key: str) -> str:
    """Return what a key of summary.json stands for: label, unit and meaning."""
    entry = quantity(key)
    unit = f" ({entry.unit})" if entry.unit else ""
    meaning = meaning_of(key)
    return f"{key}: {entry.label}{unit}" + (f". {meaning}" if meaning else "")


def _text(rows: Sequence[Row]) -> str:
    return lines([(row.label, row.text) for row in rows])


def _rows(shown: Sequence[Quantity], summary: Mapping[str, Any]) -> list[Row]:
    rows, before = [Row("case", str(summary["name"]), ("name",))], ""
    called = grains_called_in([summary])
    for entry in shown:
        value = summary.get(entry.name)
        if value is not None:
            growing = _GROWING.get(entry.name) in (summary.get("zone_growing") or ())
            text = entry.text(value) + (", still moving out at the end" if growing else "")
            if entry.name == "n_cylinders" and called != GRAINS:
                continue  # all grains are
            label = entry.short if entry.name == "n_cylinders" else in_grains(entry.short, called)
            rows.append(Row("" if entry.short == before else label, in_grains(text, called), (entry.name,)))
            before = entry.short
        if entry.name == _ZONE_AFTER:
            rows += _zone_rows(summary)
    return rows


def _zone_rows(summary: Mapping[str, Any]) -> list[Row]:
    """Size of the plastic zone, as far as it applies, and the bounds that it reaches."""
    rows = []
    label = f"{', '.join(map(str, SHARES))} % of yielding"
    for what, unit in (("depth", "m"), ("radius", "m"), ("volume", "m3")):
        keys = tuple(f"zone_{what}_{percent}_{unit}" for percent in SHARES)
        found = [f"{summary[key]:.4g}" for key in keys if summary.get(key) is not None]
        if found:
            rows.append(Row(label, f"{what} {', '.join(found)} {unit}", keys))
            label = ""
    if summary.get("zone_cut") is not None:
        rows.append(Row("bounds that it reaches", bounds_in_words(summary["zone_cut"]), ("zone_cut",)))
    return rows


#: Sentences for the reference, on values whose label is enough in a report.
NOTES = {
    "name": "Name of the case.",
    "kind": "Of finite-element runs: continuum or sphere-contact.",
    "n_spheres": "With strikers, and cylinders where there are any.",
    "n_cylinders": "Only of packings that hold any.",
    "n_elements": "Of the finite-element mesh.",
    "n_bodies": "Of the contact of two spheres: 1 where both are equal, and one on the plane of symmetry is enough.",
    "n_wall_contacts": "Pairs of a sphere and a wall in result.h5.",
    "end_time_s": "When the run ended.",
    "end_reason": "Why the run ended, such as end_time or settled.",
    "timestep_smallest_s": "Of the steps that were taken.",
    "timestep_largest_s": "Of the steps that were taken.",
    "n_steps": "Steps that were taken.",
    "wall_time_s": "Of the time integration.",
    "sphere_steps_per_s": "Spheres times steps over wall time.",
    "element_steps_per_s": "Elements times steps over wall time.",
    "n_ranks": "That the run had.",
    "versions": "Of the programs that the result depends on.",
    "energy_input_J": "Kinetic energy of what strikes, or work of a force or a moved end up to the end.",
    "energy_input_normalised": "Of a packing: over F_y alpha_y of two of its spheres. In the continuum: over "
    "sigma_y^2 D^3/E with the diameter of the punch. Not to be compared with each other.",
    "velocity_normalised": "(2/sqrt 3) (2/(1.6 pi))^2 E*^2 sqrt(rho) sigma_y^-2.5 v: units in which materials fall "
    "on one curve.",
    "dissipated_fraction": "Dissipated energy over the input.",
    "energy_balance_error": "Largest misfit of kinetic + elastic + dissipated - input at any time, over the largest "
    "input up to the end; of a prescribed displacement without the kinetic energy of the moved grains.",
    "energy_kinetic_J": "At the end, with rotation.",
    "energy_elastic_J": "At the end: what contacts, springs and bars would give back.",
    "energy_dissipated_J": "Up to the end, by yielding, friction, viscous losses and dampers.",
    "energy_dissipated_wall_J": "Part of the dissipated energy.",
    "energy_dissipated_plastic_J": "Part of the dissipated energy.",
    "energy_dissipated_friction_J": "Part of the dissipated energy.",
    "energy_dissipated_viscous_J": "Part of the dissipated energy; null without contact.loss.",
    "energy_dissipated_holder_J": "Part of the dissipated energy.",
    "energy_absorbed_J": "Part of the dissipated energy.",
    "energy_bar_J": "At the end, kinetic and elastic.",
    "energy_incident_bar_J": "At the end, kinetic and elastic.",
    "energy_punch_J": "At the end: what is left of the punch's kinetic energy.",
    "energy_viscous_J": "That the artificial viscosity of the elements took.",
    "energy_hourglass_J": "In the hourglass control of the elements.",
    "energy_contact_J": "That the contact of the punch took; of two spheres: in the penalty springs of their contact.",
    "energy_damping_J": "That damping took, which keeps the pressing of two spheres static.",
    "hourglass_share": "Energy of the hourglass control over the work done.",
    "kinetic_share_max": "Largest kinetic over internal energy from first yield on: small if the contact is static.",
    "peak_force_N": "Of any contact at any time; in the continuum of the punch.",
    "peak_overlap_m": "Of any contact at any time.",
    "contacts_beyond_law": "Contacts that were pressed beyond 0.2 R*, where the fit of the law ends.",
    "contacts_beyond_half_law": "Contacts that were pressed beyond 0.1 R*.",
    "n_plastic_spheres": "Spheres with a contact that yielded.",
    "plastic_zone_time_s": "When the volume at yield was largest, in the continuum.",
    "plastic_zone_volume_ever_m3": "Of the elements that yielded at any time, in the continuum.",
    "plastic_zone_strain": "Equivalent strain that 1 % of the volume that ever yielded exceeds, in the continuum.",
    "largest_strain": "Of any element; it depends on the size of the elements at the punch's edge.",
    "zone_depth_50_m": "As zone_depth_90_m.",
    "zone_depth_99_m": "As zone_depth_90_m.",
    "zone_radius_50_m": "As zone_radius_90_m.",
    "zone_radius_99_m": "As zone_radius_90_m.",
    "zone_volume_50_m3": "As zone_volume_90_m3.",
    "zone_volume_99_m3": "As zone_volume_90_m3.",
    "wall_peak_force_N": "Largest force of the packing on the bottom.",
    "wall_impulse_Ns": "Of the force on the bottom up to the end.",
    "target_peak_displacement_m": "Outward, from its place before the impact.",
    "unprotected_ground_peak_force_N": "The same impact directly on the bottom.",
    "peak_reduction_per_kg": "Peak reduction over the mass of the packing.",
    "peak_reduction_per_m": "Peak reduction over the height of the packing.",
    "wave_speed_m_s": "Of the first arrival in the deeper half of the packing; it takes nine layers. Null of cylinders "
    "beside each other.",
    "impactor_velocity_m_s": "Along the impact; negative: it moves back.",
    "punch_peak_displacement_m": "Into the block.",
    "restitution": "Of a single sphere on a rigid wall, or of two spheres of which one is struck.",
    "sensor_*_peak_force_N": "Of a chain: largest mean of the two contact forces of the bead.",
    "sensor_*_peak_acceleration_m_s2": "Of other packings.",
    "sensor_*_peak_velocity_m_s": "Of other packings.",
    "effective_radius_m": "R*, 1/R* = 1/R1 + 1/R2.",
    "effective_modulus_Pa": "E*, 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2.",
    "max_force_N": "Of the run.",
    "contact_radius_m": "Largest of the run.",
    "mean_pressure_Pa": "At the end of the first loading: force over the area of contact.",
    "force_deviation_max_percent": "Largest deviation of the force of first loading from the law's.",
    "force_deviation_rms_percent": "The same, root mean square.",
    "*_deviation_*max_percent": "The same of force, contact_radius or mean_pressure, perhaps within a range of "
    "overlaps over that at first yield: elastic, 1_to_10, 10_to_50, 50_to_178, beyond_178.",
    "*_deviation_*rms_percent": "The same, root mean square.",
    "n_unloadings": "Cycles of unloading and reloading.",
    "unloading_exponent_min": "n of F/F_max = ((alpha - alpha_R)/(alpha_max - alpha_R))^n, fitted to each unloading.",
    "unloading_exponent_max": "The same, the largest.",
    "unloading_misfit_percent": "Largest deviation of an unloading from its fit, over its largest force.",
    "unloading_law_difference_percent": "Largest deviation of an unloading from the law's, over the law's peak.",
    "unloading_plastic_share": "Plastic work of a cycle over the elastic energy released, at most.",
    "residual_overlap_deviation_percent_of_peak": "Residual overlap less the law's, over the cycle's largest overlap.",
    "reloading_difference_percent": "Largest difference between reloading and unloading, over the largest force.",
    "face_force_difference_max_percent": "Force at the pressed face against that in the contact: small if static.",
    "face_force_difference_rms_percent": "The same, root mean square.",
    "face_force_difference_mean_percent": "The same, mean.",
    "penetration_share_max": "Largest penetration of the contact's penalty springs over the overlap.",
}


def meaning_of(name: str) -> str:
    """Return the sentences that explain a value of a summary; empty if there are none."""
    return quantity(name).meaning or NOTES.get(name, "")
