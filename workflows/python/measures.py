"""Measures of signals and waves: arrays in SI units in, numbers out; ``granwave.measures``."""

from granwave.analysis.measures.chains.grain_row import GrainRow
from granwave.analysis.measures.chains.record import Chain
from granwave.analysis.measures.driven.amplitude_sweep import amplitude_sweep_of as amplitude_sweep
from granwave.analysis.measures.driven.two_pushes import largest_of_pulses, push_starts
from granwave.analysis.measures.impact.dissipation import rays
from granwave.analysis.measures.impact.energies import energy_by_region
from granwave.analysis.measures.impact.involved import spheres_involved
from granwave.analysis.measures.impact.quadratic_law import quadratic_law
from granwave.analysis.measures.lines.decay import fit_decay as two_region_decay
from granwave.analysis.measures.lines.decay import parted_at
from granwave.analysis.measures.lines.record import LineRecord, lines_of
from granwave.analysis.measures.precompressed.line_waves import long_wave_speed, speed_along_layers
from granwave.analysis.measures.sensors import sensor_accelerations, sensor_velocities
from granwave.analysis.measures.signals import arrival, at_time, decay_rate, first_peak, maxima, width
from granwave.analysis.measures.signals import decay as exponential_decay
from granwave.analysis.measures.signals import power as power_law
from granwave.analysis.measures.waves.directions import directions, travelling_frame
from granwave.analysis.measures.waves.directions import energy_of_spheres as sphere_energies
from granwave.analysis.measures.waves.directions import spread as directional_spread
from granwave.analysis.measures.waves.pulses import lengths as pulse_lengths
from granwave.analysis.measures.waves.pulses import line_velocity, reflection, speed_between
from granwave.analysis.measures.waves.pulses import peaks as pulse_peaks
from granwave.analysis.measures.waves.space_time import space_time_transform
from granwave.analysis.statistics import differ_significantly, estimate

__all__ = [
    "Chain",
    "GrainRow",
    "LineRecord",
    "amplitude_sweep",
    "arrival",
    "at_time",
    "decay_rate",
    "differ_significantly",
    "directional_spread",
    "directions",
    "energy_by_region",
    "estimate",
    "exponential_decay",
    "first_peak",
    "largest_of_pulses",
    "line_velocity",
    "lines_of",
    "long_wave_speed",
    "maxima",
    "parted_at",
    "power_law",
    "pulse_lengths",
    "pulse_peaks",
    "push_starts",
    "quadratic_law",
    "rays",
    "reflection",
    "sensor_accelerations",
    "sensor_velocities",
    "space_time_transform",
    "speed_along_layers",
    "speed_between",
    "sphere_energies",
    "spheres_involved",
    "travelling_frame",
    "two_region_decay",
    "width",
]
