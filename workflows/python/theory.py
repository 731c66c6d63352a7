"""Closed forms: elliptic contacts, Hertz's chain, precompressed lines, Hertz's impact; ``granwave.theory``."""

from granwave._contact_laws import elliptic_radius
from granwave.analysis.measures.chains.hertz_chain import ChainScales, discrete_speed, discrete_width
from granwave.analysis.measures.precompressed.loaded_line import crest_force, crest_speed, crest_times, lattice_speed
from granwave.analysis.measures.precompressed.loaded_line import line_of as precompressed_line
from granwave.analysis.measures.target.hertz_impact import HertzImpact
from granwave.analysis.measures.waves.pulses import theory as solitary_lengths
from granwave.lammps_inputs.case.contact import hertz_von_mises_yield_factor

__all__ = [
    "ChainScales",
    "HertzImpact",
    "crest_force",
    "crest_speed",
    "crest_times",
    "discrete_speed",
    "discrete_width",
    "elliptic_radius",
    "hertz_von_mises_yield_factor",
    "lattice_speed",
    "precompressed_line",
    "solitary_lengths",
]
