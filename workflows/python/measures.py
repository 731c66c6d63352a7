"""Measures of signals and waves: arrays in SI units in, numbers out; ``granwave.measures``."""

from granwave.analysis.measures.chains.record import Chain
from granwave.analysis.measures.lines.decay import fit_decay as two_region_decay
from granwave.analysis.measures.precompressed.line_waves import long_wave_speed, speed_along_layers
from granwave.analysis.measures.signals import arrival, at_time, first_peak, maxima, width
from granwave.analysis.measures.signals import decay as exponential_decay
from granwave.analysis.measures.signals import power as power_law
from granwave.analysis.measures.waves.pulses import lengths as pulse_lengths
from granwave.analysis.measures.waves.pulses import peaks as pulse_peaks
from granwave.analysis.measures.waves.pulses import reflection
from granwave.analysis.measures.waves.space_time import space_time_transform
from granwave.analysis.statistics import differ_significantly, estimate

__all__ = [
    "Chain",
    "arrival",
    "at_time",
    "differ_significantly",
    "estimate",
    "exponential_decay",
    "first_peak",
    "long_wave_speed",
    "maxima",
    "power_law",
    "pulse_lengths",
    "pulse_peaks",
    "reflection",
    "space_time_transform",
    "speed_along_layers",
    "two_region_decay",
    "width",
]
