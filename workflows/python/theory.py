"""Closed forms: Hertz's chain and its solitary wave, Hertz's impact; ``granwave.theory``."""

from granwave.analysis.measures.chains.hertz_chain import ChainScales, discrete_speed, discrete_width
from granwave.analysis.measures.precompressed.loaded_line import crest_force, crest_speed, crest_times, lattice_speed
from granwave.analysis.measures.precompressed.loaded_line import line_of as precompressed_line
from granwave.analysis.measures.target.hertz_impact import HertzImpact

__all__ = [
    "ChainScales",
    "HertzImpact",
    "crest_force",
    "crest_speed",
    "crest_times",
    "discrete_speed",
    "discrete_width",
    "lattice_speed",
    "precompressed_line",
]
