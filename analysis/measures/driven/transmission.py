"""Transmission of a load that oscillates: amplitudes along it at one frequency, or against frequency.

A harmonic load: the velocity of every sphere is fitted by a constant and a sine and cosine of its frequency over the
last whole periods, at most half of the run; what the fit leaves tells how far from steady the motion is.

A burst, a sweep or noise: the ratio of spectra of the velocities of two spheres over the whole run, where the
spectrum of the first holds more than a share of its largest value. With noise it is the cross spectrum over the power
spectrum, averaged over neighbouring frequencies (Bendat and Piersol, Random Data, 1986).
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.case.load import Load
from granwave.lammps_inputs.checks.loads import LEAST_PER_PERIOD, LEAST_PERIODS
from granwave.lammps_inputs.contact.travel_time import MeasuredRow, measured_row

Array = NDArray[np.float64]

STEADY = 0.02  # part of the motion that a steady fit may leave
_DENSE = 8  # instants in a period from which on its second and third harmonic are fitted too
_HEARD = 0.05  # of the largest value of the spectrum, below which a frequency does not count
_FADING = 0.1  # part of the record, its end, that is tapered
_AVERAGED = 9  # frequencies over which spectra of noise are averaged


@dataclasses.dataclass(frozen=True, eq=False)
class SteadyMotion:
    """Amplitudes along a row under a harmonic load.

    Attributes
    ----------
    frequency
        Hz.
    velocity
        Complex amplitudes of the spheres, in their order: (n_spheres,), m/s.
    left
        Root mean square of what the fit leaves over that of the whole: (n_spheres,).
    row
        The spheres.
    """

    frequency: float
    velocity: NDArray[np.complex128]
    left: Array
    row: MeasuredRow

    @property
    def first(self) -> int:
        """Id of the loaded sphere."""
        return self.row.ends[0]

    @property
    def last(self) -> int:
        """Id of the last sphere before those that absorb."""
        return self.row.ends[1]

    @property
    def driven(self) -> float:
        """Amplitude of the loaded sphere, m/s."""
        return float(abs(self.velocity[self.row.first]))

    @property
    def unsteady(self) -> float:
        """Part of the motion of both ends that is not of the frequency; the larger."""
        return float(self.left[[self.row.first, self.row.last]].max())

    @property
    def ratio(self) -> float | None:
        """Amplitude of the last sphere over that of the loaded one; None of a single one, or if one is not steady."""
        if not self.driven or self.unsteady > STEADY or self.first == self.last:
            return None
        return float(abs(self.velocity[self.row.last])) / self.driven


@dataclasses.dataclass(frozen=True, eq=False)
class Spectrum:
    """Transmission from the loaded sphere to the last one against frequency.

    Attributes
    ----------
    frequency
        Those that the load holds: (n,), Hz.
    ratio
        Complex ratio of the velocities: (n,).
    first, last
        Ids of both spheres.
    """

    frequency: Array
    ratio: NDArray[np.complex128]
    first: int
    last: int


def steady_amplitudes(time: Array, signals: Array, frequency: float) -> tuple[NDArray[np.complex128], Array] | None:
    """Fit sines of one frequency over the last whole periods, at most half of the time.

    Parameters
    ----------
    time
        (n_times,), s.
    signals
        (n_times, n_signals).
    frequency
        Hz.

    Returns
    -------
    tuple
        Complex amplitudes a of Re(a exp(i omega t)), and what the fit leaves over the whole, both (n_signals,); None
        if there are fewer than three periods. The second and third harmonic, which a nonlinear row has in its steady
        motion, are fitted too where the records are dense enough.
    """
    periods = math.floor((time[-1] - time[0]) / 2 * frequency * (1 + 1e-12))
    if periods < LEAST_PERIODS:
        return None
    inside = time >= time[-1] - periods / frequency * (1 + 1e-9)
    angle = 2 * np.pi * frequency * time[inside]
    dense = np.count_nonzero(inside) >= periods * _DENSE
    parts = [part(n * angle) for n in ((1, 2, 3) if dense else (1,)) for part in (np.cos, np.sin)]
    terms = np.stack([np.ones_like(angle), *parts], axis=1)
    values = signals[inside]
    fit, *_ = np.linalg.lstsq(terms, values, rcond=None)
    moving = values - values.mean(axis=0)
    whole = np.sqrt((moving**2).mean(axis=0))
    left = np.sqrt(((values - terms @ fit) ** 2).mean(axis=0))
    return fit[1] - 1j * fit[2], np.divide(left, whole, out=np.ones_like(left), where=whole > 0)


def transfer(time: Array, drive: Array, answer: Array, *, averaged: int = 1) -> tuple[Array, NDArray[np.complex128]]:
    """Ratio of the spectra of two signals, where that of the first is not weak; both are tapered at their end.

    Parameters
    ----------
    time
        Evenly spaced: (n_times,), s.
    averaged
        Number of neighbouring frequencies over which cross and power spectrum are averaged.

    Returns
    -------
    tuple
        Frequencies, Hz, and complex ratios, both (n,).
    """
    taper = np.ones(len(time))
    fading = max(1, int(_FADING * len(time)))
    taper[-fading:] = np.cos(np.linspace(0, np.pi / 2, fading)) ** 2
    one, two = (np.fft.rfft(signal * taper) for signal in (drive, answer))
    frequency = np.fft.rfftfreq(len(time), (time[-1] - time[0]) / (len(time) - 1))
    window = np.ones(averaged) / averaged
    cross, power = (np.convolve(values, window, mode="same") for values in (two * one.conj(), np.abs(one) ** 2))
    heard = power > _HEARD**2 * power.max(initial=0.0)
    heard[0] = False
    return frequency[heard], cross[heard] / power[heard]


def motion_of(result: Result) -> tuple[MeasuredRow, Array, Array] | None:
    """Return the measured row of a load that oscillates, times (n_times,), s, and velocities (n_times, n_spheres), m/s.

    Velocities are along z. None for other runs, or where too few instants were recorded.
    """
    load = result.case.load
    if not load.driven or not load.oscillates:
        return None
    row = measured_row(result.assembly)
    if row is None or f"{row.group}/velocity" not in result:
        return None
    time, velocity = result[f"{row.group}/time"], result[f"{row.group}/velocity"]
    if len(time) < 2 or not sampled(load, float(time[-1] - time[0]) / (len(time) - 1)):
        return None
    return row, time, velocity[..., 2] if velocity.ndim > 2 else velocity


def transmission_of(result: Result) -> SteadyMotion | Spectrum | None:
    """Transmission of a row whose load oscillates; None for other runs, or where too few instants were recorded."""
    found = motion_of(result)
    if found is None:
        return None
    load, (row, time, velocity) = result.case.load, found
    if load.shape == "up-and-down":
        return None
    if load.shape == "harmonic":
        fit = steady_amplitudes(time, velocity, load.frequencies[1])
        return None if fit is None else SteadyMotion(load.frequencies[1], *fit, row)
    averaged = _AVERAGED if load.shape == "noise" else 1
    ratios = transfer(time, velocity[:, row.first], velocity[:, row.last], averaged=averaged)
    return Spectrum(*ratios, *row.ends) if len(ratios[0]) else None


def sampled(load: Load, interval: float) -> bool:
    """Return True if records at an interval, s, resolve the load."""
    return load.frequencies[1] * interval * LEAST_PER_PERIOD <= 1 + 1e-9
