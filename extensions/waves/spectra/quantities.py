"""Quantities of ``bands.json``, ``modes.json`` and ``transmission.json``."""

from __future__ import annotations

from granwave.analysis.quantities import Quantity

_OF_ALL = (
    Quantity("name"),
    Quantity("kind", meaning="Kind of result: bands, modes or transmission."),
    Quantity("source", meaning='Source of the static state: "case" or "run".'),
)
_LEFT_OUT = Quantity("n_left_out", "Excluded grains", "Grains that carry no static load.")
_RESIDUAL = Quantity("static_residual", "Net force",
                     "Largest net force on a grain relative to the largest contact force, in the static state; null for a run.")  # fmt: skip

OF_BANDS = (
    *_OF_ALL,
    Quantity("n_grains_in_cell", "Grains of the cell"),
    Quantity("n_contacts_in_cell", "Contacts of the cell"),
    Quantity("n_wall_contacts_in_cell", "Contacts of the cell with walls"),
    _LEFT_OUT,
    Quantity("n_freedoms", "Degrees of freedom", "Displacements and rotations of the grains of the cell."),
    Quantity("n_bands", "Bands", "All bands, or the lowest bands of a large cell."),
    Quantity("static_force_N", "Mean static force",
        "Mean static force of the contacts of the cell."),
    Quantity("contact_stiffness_N_per_m", "Mean contact stiffness", "Mean stiffness of the "
                                                                    "contacts of the cell, along "
        "their normals."),
    Quantity("unit_frequency_Hz", "Unit of frequency", "sqrt(mean stiffness / mean mass) / (2 "
        "pi)."),
    Quantity("highest_frequency_Hz", "Highest frequency", "Highest frequency of the computed bands "
                                                          "along the "
        "path."),
    Quantity("speeds_m_s", "Speeds of long waves", "Speeds along the first stretch of the path, in "
        "ascending order; null without stiffness."),
    Quantity("band_edges_Hz", "Edges of the bands", "Lowest and highest frequency of each band "
        "along the path."),
    Quantity("gaps_Hz", "Gaps", "Frequency intervals between bands, below the first and above the "
        "last band; the upper end of the last is null."),
    Quantity("widest_gap_Hz", "Widest gap", "Widest gap between two bands; null if there is none."),
    Quantity("widest_gap_relative", "Width of the widest gap, relative to its centre"),
    Quantity("attenuation_in_widest_gap", "Largest attenuation, from plane to plane (ln)",
             "Natural logarithm of the amplitude ratio from plane to plane in the widest gap; "
             "null if unknown."),
    Quantity("attenuation_spacing_m", "Distance between these planes"),
    Quantity("n_floppy", "Floppy modes", "Modes without stiffness, at the wave vector with the "
        "most such modes."),
    _RESIDUAL,
    Quantity("state_spread", "Spread of overlaps", "Largest deviation from the mean of the "
        "cells of a run, relative to the largest overlap; 0 for a case."),
)  # fmt: skip
OF_MODES = (
    *_OF_ALL,
    Quantity("n_grains", "Grains"),
    Quantity("n_contacts", "Loaded contacts"),
    Quantity("n_wall_contacts", "Contacts with walls"),
    _LEFT_OUT,
    Quantity("n_freedoms", "Degrees of freedom"),
    Quantity("n_modes", "Modes computed", "All modes, or the lowest modes of a large packing."),
    Quantity("n_floppy", "Floppy modes", "Computed modes without stiffness."),
    Quantity("lowest_frequency_Hz", "Lowest frequency", "Lowest frequency above zero."),
    Quantity(
        "highest_frequency_Hz",
        "Highest frequency",
        "Highest frequency of all modes; null unless all modes are computed.",
    ),
    Quantity("least_participation_ratio", "Smallest participation ratio"),
    _RESIDUAL,
)
OF_TRANSMISSION = (
    *_OF_ALL,
    Quantity("n_grains", "Grains"),
    Quantity("n_contacts", "Loaded contacts"),
    _LEFT_OUT,
    Quantity("drive", meaning="Id of the driven grain."),
    Quantity("driven_together", meaning="Ids of the grains driven in phase with it."),
    Quantity("sensors", meaning="Ids of the sensor grains."),
    Quantity("axis", meaning="Direction of the motions."),
    Quantity("end", meaning="Far end: reflecting, matched, or a layer."),
    Quantity("lowest_frequency_Hz", "Lowest frequency", "Lowest of the requested frequencies."),
    Quantity("highest_frequency_Hz", "Highest frequency", "Highest of the requested frequencies."),
    Quantity("largest_amplitude_ratio", "Largest amplitude of each sensor, relative to the drive"),
)
