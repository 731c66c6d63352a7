"""Answer of a row against the amplitude of its load, which rises and falls at one frequency.

The signals are fitted, in windows of whole periods of the load, by sines of its frequency and of twice, three times
and half of it. A linear row answers in proportion, in the load's frequency alone. Where the branches of rising and of
falling amplitude part, there are two states at one load; where half of the frequency appears, the period has doubled.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.driven.transmission import motion_of
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.checks.loads import LEAST_WINDOWS, WINDOW_PERIODS

Array = NDArray[np.float64]

MULTIPLES = (1.0, 2.0, 3.0, 0.5)  # of the load's frequency
_COMPARED = 33  # loads at which the branches are compared


@dataclasses.dataclass(frozen=True, eq=False)
class AmplitudeSweep:
    """Velocities of two spheres against the load.

    Attributes
    ----------
    load
        Amplitude in the middle of each window, N or m: (n,).
    rising
        True where it rises: (n,).
    first, last
        Amplitudes of the loaded sphere and of the last one before those that absorb, at each of `MULTIPLES` of the
        frequency: (n_multiples, n), m/s.
    """

    load: Array
    rising: NDArray[np.bool_]
    first: Array
    last: Array

    @property
    def apart(self) -> float:
        """Largest difference of the last sphere's branches at one load, over its largest amplitude."""
        answer = self.last[0]
        both = [(self.load[chosen], answer[chosen]) for chosen in (self.rising, ~self.rising)]
        there = np.linspace(max(load.min() for load, _ in both), min(load.max() for load, _ in both), _COMPARED)
        branches = []
        for load, size in both:
            order = np.argsort(load)
            branches.append(np.interp(there, load[order], size[order]))
        return float(np.abs(branches[0] - branches[1]).max() / answer.max())


def fitted_amplitudes(time: Array, signals: Array, frequency: float) -> Array:
    """Fit sines at `MULTIPLES` of a frequency: (n_multiples, n_signals), from (n_times,) and (n_times, n_signals).

    Their amplitudes may change linearly in time; those in the middle are returned.
    """
    angles = [2 * np.pi * factor * frequency * time for factor in MULTIPLES]
    sines = [part(angle) for angle in angles for part in (np.cos, np.sin)]
    since = (time - time.mean()) / (time[-1] - time[0])
    fit, *_ = np.linalg.lstsq(
        np.stack([*sines, *(since * one for one in sines), since**0], axis=1), signals, rcond=None
    )
    return np.hypot(fit[0 : len(sines) : 2], fit[1 : len(sines) : 2])


def amplitude_sweep_of(result: Result) -> AmplitudeSweep | None:
    """Answer of a row whose load rises and falls; None for other runs, or where too few instants were recorded.

    Parameters
    ----------
    result
        ``run.result`` of a run as `granwave.load` gives it.
    """
    load, found = result.case.load, motion_of(result)
    if found is None or load.shape != "up-and-down":
        return None
    row, time, velocity = found
    frequency, whole = load.frequencies[1], load.lasts
    length = WINDOW_PERIODS / frequency
    n = int(min(whole, time[-1]) / length * (1 + 1e-9))
    if n < LEAST_WINDOWS or n * length < 0.75 * whole:  # of a run that was ended before the load fell
        return None
    middles = (np.arange(n) + 0.5) * length
    fits = []
    for middle in middles:
        inside = np.abs(time - middle) <= length / 2
        fits.append(fitted_amplitudes(time[inside], velocity[inside][:, [row.first, row.last]], frequency))
    amplitudes = np.stack(fits, axis=2)
    size = (load.amplitude or 0.0) * (1 - np.abs(2 * middles / whole - 1))
    return AmplitudeSweep(size, middles < whole / 2, amplitudes[:, 0], amplitudes[:, 1])
