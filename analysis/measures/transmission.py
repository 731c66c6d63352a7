"""What a row passes on of a load that oscillates: amplitudes along it at one frequency, or against frequency.

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
from granwave.lammps_inputs.contact.absorbing import absorbing_ids
from granwave.lammps_inputs.packing.assembly import struck_of

Array = NDArray[np.float64]

LEAST_PER_PERIOD = 6  # recorded instants in the shortest period
STEADY = 0.02  # part of the motion that a steady fit may leave
_LEAST_PERIODS = 3
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
    first, last
        Ids of the loaded sphere, and of the last one before those that absorb.
    """

    frequency: float
    velocity: NDArray[np.complex128]
    left: Array
    first: int
    last: int

    @property
    def ratio(self) -> float | None:
        """Amplitude of the last sphere over that of the loaded one; None if the motion of either is not steady."""
        ends = [self.first - 1, self.last - 1]
        if not self.velocity[ends[0]] or max(self.left[ends]) > STEADY:
            return None
        return float(abs(self.velocity[ends[1]] / self.velocity[ends[0]]))


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
        if there are fewer than three periods.
    """
    periods = math.floor((time[-1] - time[0]) / 2 * frequency * (1 + 1e-12))
    if periods < _LEAST_PERIODS:
        return None
    inside = time >= time[-1] - periods / frequency * (1 + 1e-9)
    angle = 2 * np.pi * frequency * time[inside]
    terms = np.stack([np.ones_like(angle), np.cos(angle), np.sin(angle)], axis=1)
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


def transmission_of(result: Result) -> SteadyMotion | Spectrum | None:
    """Transmission of a chain whose load oscillates; None for other runs, or where too few instants were recorded."""
    load = result.case.load
    if "chain/velocity" not in result or not load.driven or not load.oscillates:
        return None
    time, velocity = result["chain/time"], result["chain/velocity"]
    if len(time) < 2 or not sampled(load, float(time[-1] - time[0]) / (len(time) - 1)):
        return None
    first, last = ends_of(result)
    if load.shape == "up-and-down":
        return None
    if load.shape == "harmonic":
        fit = steady_amplitudes(time, velocity, load.frequencies[1])
        return None if fit is None else SteadyMotion(load.frequencies[1], *fit, first, last)
    averaged = _AVERAGED if load.shape == "noise" else 1
    found = transfer(time, velocity[:, first - 1], velocity[:, last - 1], averaged=averaged)
    return Spectrum(*found, first, last) if len(found[0]) else None


def sampled(load: Load, interval: float) -> bool:
    """Return True if records at an interval, s, resolve the load."""
    return load.frequencies[1] * interval * LEAST_PER_PERIOD <= 1 + 1e-9


def ends_of(result: Result) -> tuple[int, int]:
    """Ids of the loaded sphere, and of the last one before those that absorb."""
    assembly = result.assembly
    absorbing = {one for entry in assembly.case.absorb for one in absorbing_ids(assembly, entry)}
    rest = [one for one in range(1, assembly.lattice.n_spheres + 1) if one not in absorbing]
    first = struck_of(assembly)[0]
    return first, rest[-1] if rest and rest[-1] != first else assembly.lattice.n_spheres
