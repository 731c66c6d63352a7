"""Rows of grains under a load that oscillates, or that pushes them once or twice.

Transmission of a harmonic load: the velocity of every sphere is fitted by a constant and a sine and
cosine of its frequency over the last whole periods, at most half of the run; the residual of the
fit measures the deviation from a steady motion.

Transmission of a burst, a sweep or noise: the ratio of spectra of the velocities of two spheres
over the whole run, at frequencies where the spectrum of the first exceeds a fraction of its largest
value. With noise it is the cross spectrum divided by the power spectrum, averaged over neighbouring
frequencies (Bendat and Piersol, Random Data, 1986).

Response to an amplitude that rises and falls at one frequency: the signals are fitted, in windows
of whole periods of the load, by sines at once, twice, three times and half its frequency. A
linear chain responds proportionally, at the load's frequency only. If the branches of rising and
falling amplitude separate, there are two states at one load; if half the frequency appears, the
period has doubled.

Mean power input of a harmonic load, and mean power absorbed at absorbing ends: slopes of the
recorded energies against time, by least squares over the last half of the run, so that energy
exchanged within a period does not count.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.measures.signals import Array, arrival
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.case.loads.driven import DrivenLoad
from granwave.lammps_inputs.checks.loads import (
    LEAST_PER_PERIOD,
    LEAST_PERIODS,
    LEAST_WINDOWS,
    WINDOW_PERIODS,
)
from granwave.lammps_inputs.contact.travel_time import MeasuredRow, measured_row

STEADY = 0.02  # fraction of the motion that a steady fit may leave
_DENSE = 8  # instants per period above which the second and third harmonics are fitted too
# fraction of the largest value of the spectrum, below which a frequency does not count
_HEARD = 0.05
_FADING = 0.1  # fraction of the record, at its end, that is tapered
_AVERAGED = 9  # frequencies over which spectra of noise are averaged

MULTIPLES = (1.0, 2.0, 3.0, 0.5)  # multiples of the load's frequency
_COMPARED = 33  # loads at which the branches are compared
_FEWEST_INSTANTS = 8  # instants of a fit of a slope
_ENDS = ("energy/absorbed", "energy/support_lost")
_ARRIVED = 0.2  # fraction of the largest force
# fraction of the time between the pushes, after the first arrival: later signals belong to the
# second pulse
_SHARE = 0.75


@dataclasses.dataclass(frozen=True, eq=False)
class SteadyMotion:
    """Amplitudes along a row under a harmonic load."""

    frequency: float  # Hz
    velocity: NDArray[np.complex128]  # complex amplitudes of the spheres: (n_spheres,), m/s
    left: Array  # residual of the fit over the signal, both as root mean squares: (n_spheres,)
    row: MeasuredRow  # the spheres

    @property
    def first(self) -> int:
        """Id of the loaded sphere."""
        return self.row.ends[0]

    @property
    def last(self) -> int:
        """Id of the last sphere before the absorbing spheres."""
        return self.row.ends[1]

    @property
    def driven(self) -> float:
        """Amplitude of the loaded sphere, m/s."""
        return float(abs(self.velocity[self.row.first]))

    @property
    def unsteady(self) -> float:
        """Fraction of the motion that is not at the frequency; the larger fraction of both ends."""
        return float(self.left[[self.row.first, self.row.last]].max())

    @property
    def ratio(self) -> float | None:
        """Amplitude of the last sphere divided by the amplitude of the loaded sphere; None for a
        single sphere, or if either is not steady.
        """
        if not self.driven or self.unsteady > STEADY or self.first == self.last:
            return None
        return float(abs(self.velocity[self.row.last])) / self.driven


@dataclasses.dataclass(frozen=True, eq=False)
class Spectrum:
    """Transmission from the loaded sphere to the last sphere against frequency."""

    frequency: Array  # frequencies of the load: (n,), Hz
    ratio: NDArray[np.complex128]  # ratio of the velocities: (n,)
    first: int  # ids of both spheres
    last: int


def steady_amplitudes(
    time: Array, signals: Array, frequency: float
) -> tuple[NDArray[np.complex128], Array] | None:
    """Fit sines of one frequency over the last whole periods, at most half of the time.

    The second and third harmonic, which occur in the steady motion of a nonlinear row, are fitted
    too if the records are dense enough.

    Parameters
    ----------
    time, signals
        (n_times,), s, and (n_times, n_signals).
    frequency
        Hz.

    Returns
    -------
    tuple
        Complex amplitudes a of Re(a exp(i omega t)), and the residual of the fit relative to the
        signal, both (n_signals,); None if there are fewer than three periods.
    """
    periods = math.floor((time[-1] - time[0]) / 2 * frequency * (1 + 1e-12))
    if periods < LEAST_PERIODS:
        return None
    inside = time >= time[-1] - periods / frequency * (1 + 1e-9)
    angle = 2 * np.pi * frequency * time[inside]
    is_dense = np.count_nonzero(inside) >= periods * _DENSE
    multiples = (1, 2, 3) if is_dense else (1,)
    terms = np.stack([np.ones_like(angle), *_sines(angle, multiples)], axis=1)
    values = signals[inside]
    fit, *_ = np.linalg.lstsq(terms, values, rcond=None)
    amplitude = fit[1] - 1j * fit[2]
    whole = _root_mean_square(values - values.mean(axis=0))
    left = _root_mean_square(values - terms @ fit)
    residual = np.divide(left, whole, out=np.ones_like(left), where=whole > 0)
    return amplitude, residual


def _root_mean_square(signals: Array) -> Array:
    """Return the root mean square of each signal over time: (n_signals,)."""
    return np.asarray(np.sqrt((signals**2).mean(axis=0)))


def _sines(angle: Array, multiples: Sequence[float]) -> list[Array]:
    """Cosine and sine of multiples of an angle."""
    sines = list[Array]()
    for factor in multiples:
        sines += [np.cos(factor * angle), np.sin(factor * angle)]
    return sines


def transfer(
    time: Array, drive: Array, answer: Array, *, averaged: int = 1
) -> tuple[Array, NDArray[np.complex128]]:
    """Ratio of the spectra of two signals at frequencies where the first spectrum is not weak; both
    signals are tapered at their end.

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
    cross, power = (
        np.convolve(values, window, mode="same") for values in (two * one.conj(), np.abs(one) ** 2)
    )
    heard = power > _HEARD**2 * power.max(initial=0.0)
    heard[0] = False
    return frequency[heard], cross[heard] / power[heard]


def motion_of(result: Result) -> tuple[MeasuredRow, Array, Array] | None:
    """Return the measured row of a load that oscillates, times (n_times,), s, and velocities
    (n_times, n_spheres), m/s.

    Velocities are along the load, or along z in a chain. None for other runs, or where too few
    instants were recorded.
    """
    load = result.case.load
    if not load.oscillates:
        return None
    row = measured_row(result.assembly)
    if row is None or f"{row.group}/velocity" not in result:
        return None
    time = result[f"{row.group}/time"]
    velocity = result[f"{row.group}/velocity"]
    if len(time) < 2:
        return None
    interval = float(time[-1] - time[0]) / (len(time) - 1)
    if (
        load.highest_frequency * interval * LEAST_PER_PERIOD > 1 + 1e-9
    ):  # the record does not resolve the load
        return None
    if velocity.ndim > 2:
        velocity = velocity @ np.array(load.way) if load.slants else velocity[..., 2]
    elif load.slants:  # a chain is recorded along z
        return None
    return row, time, velocity


def transmission_of(result: Result) -> SteadyMotion | Spectrum | None:
    """Transmission of a row whose load oscillates; None for other runs, or where too few instants
    were recorded.
    """
    found = motion_of(result)
    load = result.case.load
    if found is None or not isinstance(load, DrivenLoad):
        return None
    row, time, velocity = found
    if load.shape == "up-and-down":
        return None
    if load.shape == "harmonic":
        fit = steady_amplitudes(time, velocity, load.highest_frequency)
        return None if fit is None else SteadyMotion(load.highest_frequency, *fit, row)
    averaged = _AVERAGED if load.shape == "noise" else 1
    ratios = transfer(time, velocity[:, row.first], velocity[:, row.last], averaged=averaged)
    return Spectrum(*ratios, *row.ends) if len(ratios[0]) else None


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
        Amplitudes of the loaded sphere and of the last sphere before the absorbing ones, at each of
        `MULTIPLES` of the frequency: (n_multiples, n), m/s.
    """

    load: Array
    rising: NDArray[np.bool_]
    first: Array
    last: Array

    @property
    def apart(self) -> float:
        """Largest difference between the branches of the last sphere at one load, divided by its
        largest amplitude.
        """
        answer = self.last[MULTIPLES.index(1.0)]
        both = [(self.load[chosen], answer[chosen]) for chosen in (self.rising, ~self.rising)]
        there = np.linspace(
            max(load.min() for load, _ in both), min(load.max() for load, _ in both), _COMPARED
        )
        branches = []
        for load, size in both:
            order = np.argsort(load)
            branches.append(np.interp(there, load[order], size[order]))
        return float(np.abs(branches[0] - branches[1]).max() / answer.max())


def fitted_amplitudes(time: Array, signals: Array, frequency: float) -> Array:
    """Fit sines at `MULTIPLES` of a frequency: (n_multiples, n_signals), from (n_times,) and
    (n_times, n_signals).

    Their amplitudes may change linearly in time; the amplitudes in the middle are returned.
    """
    sines = _sines(2 * np.pi * frequency * time, MULTIPLES)
    since = (time - time.mean()) / (time[-1] - time[0])
    fit, *_ = np.linalg.lstsq(
        np.stack([*sines, *(since * one for one in sines), since**0], axis=1), signals, rcond=None
    )
    return np.hypot(fit[0 : len(sines) : 2], fit[1 : len(sines) : 2])


def amplitude_sweep_of(result: Result) -> AmplitudeSweep | None:
    """Response of a chain whose load rises and falls; None for other runs, or where too few
    instants were recorded.

    Parameters
    ----------
    result
        ``run.result`` of a run as `granwave.load` gives it.
    """
    load = result.case.load
    found = motion_of(result)
    if found is None or not isinstance(load, DrivenLoad) or load.shape != "up-and-down":
        return None
    row, time, velocity = found
    frequency = load.highest_frequency
    whole = load.lasts
    length = WINDOW_PERIODS / frequency
    n = int(min(whole, time[-1]) / length * (1 + 1e-9))
    if n < LEAST_WINDOWS or n * length < 0.75 * whole:  # the run ended before the load fell
        return None
    middles = (np.arange(n) + 0.5) * length
    fits = []
    for middle in middles:
        inside = np.abs(time - middle) <= length / 2
        fits.append(
            fitted_amplitudes(time[inside], velocity[inside][:, [row.first, row.last]], frequency)
        )
    amplitudes = np.stack(fits, axis=2)
    size = (load.amplitude or 0.0) * (1 - np.abs(2 * middles / whole - 1))
    first, last = np.moveaxis(amplitudes, 1, 0)
    return AmplitudeSweep(size, middles < whole / 2, first, last)


def mean_power_of(result: Result) -> tuple[float, float | None] | None:
    """Return mean powers in the last half of a run under a harmonic load, W; None for other runs,
    or too few periods.

    The first is the power of the load, the second the power absorbed by the spheres of
    ``[[absorb]]`` and the damper below; None if there is neither.
    """
    load = result.case.load
    time = result["energy/time"]
    if not isinstance(load, DrivenLoad) or load.shape != "harmonic":
        return None
    later = time >= time[-1] / 2
    if (
        np.count_nonzero(later) < _FEWEST_INSTANTS
        or time[-1] / 2 * load.highest_frequency < LEAST_PERIODS
    ):
        return None
    since = time[later] - time[later].mean()

    def slope(name: str) -> float:
        energy = result[name][later]
        return float(since @ (energy - energy.mean()) / (since @ since))

    ends = [slope(name) for name in _ENDS if name in result]
    return slope("energy/input"), sum(ends) if ends else None


def push_starts(table: Sequence[Sequence[float]] | None) -> list[float]:
    """Times at which the force of a table of rows [time, force] begins to rise from zero, s."""
    return [before[0] for before, after in pairwise(table or ()) if before[1] == 0 < after[1]]


def largest_of_pulses(time: ArrayLike, force: ArrayLike, apart: float) -> tuple[float, float]:
    """Largest force of the first and of the second pulse at a contact, N.

    Parameters
    ----------
    time, force
        Instants, s, and force, N: (n_times,).
    apart
        Time between the pushes, s.
    """
    time = np.asarray(time, dtype=np.float64)
    force = np.asarray(force, dtype=np.float64)
    split = arrival(time, force, _ARRIVED * float(force.max())) + _SHARE * apart
    return float(force[time < split].max(initial=0.0)), float(force[time >= split].max(initial=0.0))
