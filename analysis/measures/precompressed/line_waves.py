"""Waves along lines of like bodies under a static force, a struck chain or the layers of a packing.

The waves found are compared with `granwave.analysis.measures.precompressed.loaded_line`: in the units of the static
state (speeds over c0, forces over F0, velocities over omega alpha0) every line of like Hertz contacts is one curve.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from granwave.analysis.measures.precompressed import loaded_line as theory
from granwave.analysis.measures.signals import Array, first_peak

if TYPE_CHECKING:
    from granwave.analysis.result.reader import Result

_FIRST_LAYER = 3  # from which on crests are followed
_FEWEST = 3  # layers
_BEFORE_END = 3  # layers left out at the bottom
_BEFORE_SIDES = 0.8  # of half the width: how deep a wave is followed in a packing with free sides
_FINE = 10  # points put between two snapshots


def speed_along_layers(result: Result, line: theory.Line) -> float:
    """c0 along the stacking of a packing, m/s; NaN where the run has too few layers, or is too short.

    The mean velocity of a layer of a periodic packing obeys the line of layers exactly as long as everything is linear,
    whichever spheres of the top layer were struck; in a packing with free sides until the wave is back from them. The
    times of its crests then give omega, and the speed of long waves.

    Parameters
    ----------
    line
        The line that the layers are.
    """
    case, time = result.case, result.frame_times
    nx, ny, nz = case.packing.size
    layer = (result["spheres/id"] - 1) // (nx * ny)
    frames = (result.frame(frame, "velocity")[:, 2] for frame in range(result.n_frames))
    mean = np.stack([np.bincount(layer, frame, nz) / (nx * ny) for frame in frames])
    deepest = nz - _BEFORE_END
    if case.boundary.sides != "periodic":
        half = min(nx, ny * np.sqrt(3) / 2) / 2
        deepest = min(deepest, int(_BEFORE_SIDES * half / theory.SPACING[case.packing.kind]))
    numbers, times = _crests(time, mean[:, :deepest])
    return long_wave_speed(line, numbers, times) if len(numbers) >= _FEWEST else np.nan


def _crests(time: Array, mean: Array) -> tuple[NDArray[np.int64], Array]:
    """Layers, from 1, that the crest of their velocities (n_times, n_layers) has passed, and when."""
    fine = np.linspace(time[0], time[-1], _FINE * (len(time) - 1) + 1)
    times = np.array([first_peak(fine, CubicSpline(time, one)(fine), floor=0.5)[0] for one in mean.T])
    numbers = np.arange(1, len(times) + 1)
    good = (numbers >= _FIRST_LAYER) & np.isfinite(times) & (times < time[-2])
    return numbers[good], times[good]


def long_wave_speed(line: theory.Line, numbers: NDArray[np.int64], times: Array) -> float:
    """c0 by the times of the crests of the velocities in a linear line whose first body is struck, m/s.

    Parameters
    ----------
    line
        The line, for its spacing.
    numbers, times
        Bodies, from 1, and the time of the first crest of each, s: (n_bodies,).
    """
    return line.spacing / (2 * float(np.polyfit(theory.crest_times(numbers), times, 1)[0]))
