"""Space-time transform of motions along a line of grains: where in (k, omega) their energy is.

The velocities v(x_n, t) of grains at even places x_n = n h are tapered in space and time (Hann) and transformed,

    V(k, omega) = sum_n sum_t v(x_n, t) exp(i (omega t - k x_n))

so that a wave that travels to larger x is at k > 0 for omega > 0. |V| has ridges along the bands of the packing.
Short records smear them: by 4 pi/(n h) in k and by 4 pi/T in omega, the widths of the taper.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray
from scipy.signal import czt

Array = NDArray[np.float64]

_EVEN = 1e-6  # of the step, by which places and times may miss an even grid


@dataclasses.dataclass(frozen=True, eq=False)
class SpaceTime:
    """Transform of velocities along a line.

    Attributes
    ----------
    k
        Wave numbers along the line: (n_k,), rad/m.
    frequency
        (n_frequencies,), Hz.
    amplitude
        |V|: (n_frequencies, n_k), over its largest value.
    """

    k: Array
    frequency: Array
    amplitude: Array

    def ridge(self, floor: float = 0.02) -> Array:
        """Frequency of the largest amplitude at each k: (n_k,), Hz, by a parabola; NaN where it is below the floor."""
        top = np.argmax(self.amplitude, axis=0)
        inner = np.clip(top, 1, len(self.frequency) - 2)
        left, middle, right = (
            np.log(self.amplitude[inner + step, np.arange(len(self.k))] + 1e-300) for step in (-1, 0, 1)
        )
        curve = left - 2 * middle + right
        shift = np.where(curve < 0, 0.5 * (left - right) / np.where(curve < 0, curve, 1.0), 0.0)
        found = self.frequency[inner] + np.clip(shift, -1, 1) * (self.frequency[1] - self.frequency[0])
        strong = self.amplitude.max(axis=0) > floor
        return np.where(strong & (top == inner), found, np.nan)


def space_time_transform(
    time: Array, place: Array, velocity: Array, k: Array, frequency: Array, *, taper_space: bool = True
) -> SpaceTime:
    """Transform velocities along a line of grains.

    Parameters
    ----------
    time
        Even instants: (n_times,), s.
    place
        Even places along the line: (n_places,), m.
    velocity
        (n_times, n_places), m/s.
    k
        Even wave numbers: (n_k,), rad/m.
    frequency
        Even frequencies: (n_frequencies,), Hz.
    taper_space
        False where the motion is zero at both ends of the line.

    Raises
    ------
    ValueError
        Times or places are not even.
    """
    for name, values in (("times", time), ("places", place)):
        steps = np.diff(values)
        if not len(steps) or np.abs(steps - steps.mean()).max() > max(_EVEN, 1e-3) * abs(steps.mean()):
            raise ValueError(f"found {name} with uneven steps, expected even ones")
    step, spacing = float(np.diff(time).mean()), float(np.diff(place).mean())
    window = np.hanning(len(time) + 2)[1:-1, None]
    across = np.hanning(len(place) + 2)[1:-1] if taper_space else np.ones(len(place))
    values = velocity * window * across
    dw, dk = 2 * np.pi * float(np.diff(frequency).mean()), float(np.diff(k).mean())
    in_time = czt(
        values, len(frequency), w=np.exp(1j * dw * step), a=np.exp(-2j * np.pi * float(frequency[0]) * step), axis=0
    )
    found = np.abs(czt(in_time, len(k), w=np.exp(-1j * dk * spacing), a=np.exp(1j * float(k[0]) * spacing), axis=1))
    return SpaceTime(k, frequency, found / found.max())
