"""Measures of signals and waves: arrays in SI units in, numbers out."""

from granwave.analysis.measures.chains import Chain, GrainRow
from granwave.analysis.measures.driven import amplitude_sweep_of as amplitude_sweep
from granwave.analysis.measures.driven import largest_of_pulses, push_starts
from granwave.analysis.measures.force_decay import force_decay, no_decay_reason
from granwave.analysis.measures.impact import (
    energy_by_region,
    quadratic_law,
    rays,
    spheres_involved,
)
from granwave.analysis.measures.line_waves import lengths as pulse_lengths
from granwave.analysis.measures.line_waves import (
    line_velocity,
    long_wave_speed,
    reflection,
    space_time_transform,
    speed_along_layers,
    speed_between,
)
from granwave.analysis.measures.line_waves import peaks as pulse_peaks
from granwave.analysis.measures.lines import (
    LineRecord,
    lines_of,
    parted_at,
    sensor_accelerations,
    sensor_velocities,
)
from granwave.analysis.measures.lines import fit_decay as two_region_decay
from granwave.analysis.measures.signals import (
    arrival,
    at_time,
    decay_rate,
    first_peak,
    maxima,
    width,
)
from granwave.analysis.measures.signals import decay as exponential_decay
from granwave.analysis.measures.signals import power as power_law
from granwave.analysis.measures.waves import directions, travelling_frame
from granwave.analysis.measures.waves import energy_of_spheres as sphere_energies
from granwave.analysis.measures.waves import spread as directional_spread
from granwave.analysis.statistics import differ_significantly, estimate

__all__ = [
    "Chain", "GrainRow", "LineRecord", "amplitude_sweep", "arrival", "at_time", "decay_rate", "differ_significantly",
    "directional_spread", "directions", "energy_by_region", "estimate", "exponential_decay", "first_peak",
    "force_decay", "largest_of_pulses", "line_velocity", "lines_of", "long_wave_speed", "maxima", "no_decay_reason", "parted_at", "power_law",
    "pulse_lengths", "pulse_peaks", "push_starts", "quadratic_law", "rays", "reflection", "sensor_accelerations",
    "sensor_velocities", "space_time_transform", "speed_along_layers", "speed_between", "sphere_energies",
    "spheres_involved", "travelling_frame", "two_region_decay", "width",
]  # fmt: skip
