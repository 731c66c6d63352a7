"""Closed forms: elliptic contacts, Hertz's chain, precompressed lines, Hertz's impact."""

from granwave._contact_laws import elliptic_radius
from granwave.analysis.measures.hertz_lattices import (
    ChainScales,
    crest_force,
    crest_speed,
    crest_times,
    discrete_speed,
    discrete_width,
    lattice_speed,
    solitary_wave,
)
from granwave.analysis.measures.hertz_lattices import line_of as precompressed_line
from granwave.analysis.measures.line_waves import solitary_lengths
from granwave.analysis.measures.target_theory import HertzImpact
from granwave.lammps_inputs.case.contact.contact import hertz_von_mises_yield_factor

__all__ = [
    "ChainScales", "HertzImpact", "crest_force", "crest_speed", "crest_times", "discrete_speed", "discrete_width",
    "elliptic_radius", "hertz_von_mises_yield_factor", "lattice_speed", "precompressed_line", "solitary_lengths",
    "solitary_wave",
]  # fmt: skip
