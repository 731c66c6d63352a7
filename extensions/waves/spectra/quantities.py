"""Quantities of ``bands.json``, ``modes.json`` and ``transmission.json``."""

from __future__ import annotations

from granwave.analysis.quantities import Quantity

_OF_ALL = (
    Quantity("name"),
    Quantity("kind", meaning="What it is: bands, modes or transmission."),
    Quantity("source", meaning='"case", or "run": where the static state comes from.'),
)
_LEFT_OUT = Quantity("n_left_out", "Grains left out", "Grains that bear no static load.")
_RESIDUAL = Quantity("static_residual", "Net force",
                     "Largest net force on a grain over the largest contact force, in the static state; null of a "
                     "run.")  # fmt: skip

OF_BANDS = (
    *_OF_ALL,
    Quantity("n_grains_in_cell", "Grains of the cell"),
    Quantity("n_contacts_in_cell", "Contacts of the cell"),
    Quantity("n_wall_contacts_in_cell", "Contacts of the cell with walls"),
    _LEFT_OUT,
    Quantity("n_freedoms", "Degrees of freedom", "Displacements and rotations of the grains of the cell."),
    Quantity("n_bands", "Bands", "All, or the lowest of a large cell."),
    Quantity("static_force_N", "Mean static force", "Of the contacts."),
    Quantity("contact_stiffness_N_per_m", "Mean contact stiffness", "Of the contacts, along their normals."),
    Quantity("unit_frequency_Hz", "Unit of frequency", "Root of mean stiffness over mean mass, over 2 pi."),
    Quantity("highest_frequency_Hz", "Highest frequency", "Of the bands found, along the path."),
    Quantity("speeds_m_s", "Speeds of long waves", "Along the first stretch of the path, rising; null where nothing "
             "resists."),
    Quantity("band_edges_Hz", "Edges of the bands", "Lowest and highest frequency of each along the path."),
    Quantity("gaps_Hz", "Gaps", "Frequencies between bands, below the first and above the last; the end of the last "
             "is null."),
    Quantity("widest_gap_Hz", "Widest gap", "Between two bands; null without any."),
    Quantity("widest_gap_relative", "Width of the widest gap, of its middle"),
    Quantity("attenuation_in_widest_gap", "Largest attenuation, from plane to plane (ln)",
             "In the widest gap, natural logarithm of the amplitude from plane to plane; null where it is not known."),
    Quantity("attenuation_spacing_m", "Distance of these planes"),
    Quantity("n_floppy", "Floppy modes", "Without resistance, at the wave vector that has most of them."),
    _RESIDUAL,
    Quantity("state_spread", "Spread of overlaps", "Largest difference from their means over the cells of a run, over "
             "the largest overlap; 0 of a case."),
)  # fmt: skip
OF_MODES = (
    *_OF_ALL,
    Quantity("n_grains", "Grains"),
    Quantity("n_contacts", "Contacts that bear a force"),
    Quantity("n_wall_contacts", "Contacts with walls"),
    _LEFT_OUT,
    Quantity("n_freedoms", "Degrees of freedom"),
    Quantity("n_modes", "Modes found", "All, or the lowest of a large packing."),
    Quantity("n_floppy", "Floppy modes", "Modes found that meet no resistance."),
    Quantity("lowest_frequency_Hz", "Lowest frequency", "Above zero."),
    Quantity("highest_frequency_Hz", "Highest frequency", "Null unless all modes are found."),
    Quantity("least_participation_ratio", "Smallest participation ratio"),
    _RESIDUAL,
)
OF_TRANSMISSION = (
    *_OF_ALL,
    Quantity("n_grains", "Grains"),
    Quantity("n_contacts", "Contacts that bear a force"),
    _LEFT_OUT,
    Quantity("drive", meaning="Id of the grain that is moved."),
    Quantity("driven_together", meaning="Ids of the grains that are moved as it is."),
    Quantity("sensors", meaning="Ids of the grains that are watched."),
    Quantity("axis", meaning="Direction of the motions."),
    Quantity("end", meaning="Far end: reflecting, matched, or a layer."),
    Quantity("lowest_frequency_Hz", "Lowest frequency", "Of those asked for."),
    Quantity("highest_frequency_Hz", "Highest frequency", "Of those asked for."),
    Quantity("largest_amplitude_ratio", "Largest amplitude of each sensor, over the drive's"),
)
