"""The quantities of the ``summary.json`` of an inference; numbers of several instants are lists."""

from __future__ import annotations

from granwave.analysis.quantities import Quantity

ENTRIES = (
    Quantity("name"),
    Quantity("kind"),
    Quantity("measurement", meaning="File of the measured grains, or directory of the run."),
    Quantity("state", meaning="How strains give stresses."),
    Quantity("n_instants", "Instants"),
    Quantity("time_s", "Instant", "Null for a table without times."),
    Quantity("n_grains", "Grains"),
    Quantity("n_contacts", "Candidate contacts", "Pairs, and grains at walls, that lie within the tolerance."),
    Quantity("n_loaded_contacts", "Contacts that bear a force"),
    Quantity("n_significant_contacts", "Contacts with a force above two standard errors",
             "Normal force; noise gives most candidates some force. Null without standard errors."),
    Quantity("n_equations", "Equations"),
    Quantity("n_unknowns", "Components of forces"),
    Quantity("condition_number", meaning="Ratio of the extreme singular values of the equations."),
    Quantity("weights", meaning="How the equations are weighed: equal, white or correlated."),
    Quantity("friction", "Coefficient of friction"),
    Quantity("largest_force_N", "Largest contact force"),
    Quantity("mean_normal_force_N", "Mean normal force", "Of the contacts that bear a force."),
    Quantity("n_sliding_contacts", "Sliding contacts", "Tangential force within 0.1 % of friction times normal force."),
    Quantity("residual_fraction", "Residuals", "Root of the sum of squares of the residuals over that of the data."),
    Quantity("chi2_per_equation", "chi^2 over free equations",
             "Weighted squares of the residuals over the number of equations without that of the forces: near 1 if "
             "noise and friction are right; null without known noise."),
    Quantity("standard_error_fraction", "Standard error of the forces",
             "Root of the sum of squares of the standard errors over that of the forces, from repeated noise."),
    Quantity("repetitions", meaning="Number of repetitions with noise."),
    Quantity("youngs_modulus_Pa", "Young's modulus", "Given or found; of the first grain. Null for measured stresses."),
    Quantity("youngs_modulus_error_Pa", "Standard error of Young's modulus", "Null if it was given."),
    Quantity("true_force_error", "Error of the forces",
             "Of measurements made of a run: root of the sum of squares of the errors over that of the true forces; "
             "mean of all repetitions."),
    Quantity("noise", meaning="Of measurements made of a run: noise over the root mean square, or a list."),
    Quantity("frame_rate_Hz", meaning="Of measurements made of a run: frames per second of the camera."),
    Quantity("position_noise_m", meaning="Of measurements made of a run: error of measured places."),
    Quantity("acceleration_error", "Error of the accelerations",
             "Of measurements made of a run: as that of the forces; by frames and errors of places."),
    Quantity("notes", meaning="Assumptions where something was not measured."),
    Quantity("versions"),
)  # fmt: skip
QUANTITIES = {entry.name: entry for entry in ENTRIES}
