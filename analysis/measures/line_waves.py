"""Waves along lines of grains: velocities, pulses, crests, and the space-time transform.

A line is the beads of a chain, or the layers or columns of a packing. Snapshots are taken at whole
timesteps, so that their times are not exactly uniform; velocities are interpolated between them at
even times (cubic splines).

Waves under a static force are compared with `granwave.analysis.measures.hertz_lattices`: in the
units of the static state (speeds divided by c0, forces by F0, velocities by omega alpha0) results
of all lines of identical Hertz contacts lie on one curve.

The space-time transform shows the distribution of the energy of a line in (k, omega): the
velocities v(x_n, t) of grains at even positions x_n = n h are tapered in space and time (Hann) and
transformed,

    V(k, omega) = sum_n sum_t v(x_n, t) exp(i (omega t - k x_n))

so that a wave that travels to larger x is at k > 0 for omega > 0. |V| has ridges along the bands of
the packing. Short records smear them: by 4 pi/(n h) in k and by 4 pi/T in omega, the widths of the
taper.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq, least_squares
from scipy.signal import czt

from granwave.analysis.errors import MissingDataError
from granwave.analysis.measures.hertz_lattices import PrecompressedLine, crest_times
from granwave.analysis.measures.signals import Array, first_peak, width
from granwave.analysis.result.reader import Result

LENGTH = (
    math.pi * math.sqrt(10) / 2
)  # length of the solitary wave in the long-wave approximation (4.97), diameters
MEASURES = (
    "fit of acceleration",
    "fit of velocity",
    "half maximum of acceleration",
    "half maximum of velocity",
)
_FINE = 4  # interpolated points between two snapshots
_GONE = 1e-3  # fraction of its peak below which the incident wave has passed
_BACK = 0.8  # fraction of the wave's way to the far end and back
_LARGEST = 3 * math.sqrt(3) / 16  # largest value of cos^3 sin
_FIRST_LAYER = 3  # first layer in which crests are followed
_FEWEST = 3  # layers
_BEFORE_END = 3  # layers left out at the bottom
# depth over half the width to which a wave is followed in a packing with free sides
_BEFORE_SIDES = 0.8
_FINE_CRESTS = 10  # interpolated points between two snapshots
_EVEN_STEPS = 1e-6  # tolerance of positions and times on an even grid, over the step


def velocities_along(result: Result, axis: int = 2) -> tuple[Array, Array, Array]:
    """Return even times (n_times,), s, positions at the start (n,), m, and velocities (n_times, n),
    m/s, along an axis.

    Motion of the beads of a chain, or of the layers of a packing (axis 2) or its columns across x
    (axis 0): the means of their spheres.

    Raises
    ------
    MissingDataError
        The run of a chain has no history.
    """
    if "chain" in result:
        time, place, velocity = (
            result[f"chain/{name}"] for name in ("time", "position", "velocity")
        )
    elif result.case.packing.rule.is_chain:
        raise MissingDataError(
            f"{result.path}: has no history of a chain; set output.history and run the case again"
        )
    else:
        time = result.frame_times
        place, velocity = _means(result, axis)
    even = np.linspace(time[0], time[-1], len(time))
    return even, place, np.asarray(CubicSpline(time, velocity)(even))


def _means(result: Result, axis: int) -> tuple[Array, Array]:
    """Mean positions and velocities along z of layers, or along x of columns: (n,), m, and
    (n_frames, n), m/s.

    Strikers are omitted.
    """
    nx, ny, _ = result.assembly.lattice.shape
    ids = result["spheres/id"]
    own = ids <= result.assembly.lattice.n_spheres
    group = (ids[own] - 1) // (nx * ny) if axis == 2 else (ids[own] - 1) % nx
    frames = (result.frame(frame, "velocity")[own, axis] for frame in range(result.n_frames))
    place, *velocity = (
        np.bincount(group, one) for one in (result["spheres/position"][own, axis], *frames)
    )
    return place / np.bincount(group), np.stack(velocity) / np.bincount(group)


@dataclasses.dataclass(frozen=True, eq=False)
class Peaks:
    """The pulse at the spheres of a chain, impacted sphere first; every array (n_spheres,), NaN if
    it did not pass.

    Attributes
    ----------
    velocity
        Largest velocity, m/s.
    time
        Of it, s.
    speed
        Of the wave, from the peaks of the two neighbours, m/s.
    """

    velocity: Array
    time: Array
    speed: Array


def line_velocity(result: Result, ids: ArrayLike) -> Array:
    """Velocities along a straight line of spheres, away from the first of them: (n_frames,
    n_spheres), m/s.

    Parameters
    ----------
    result
        ``run.result`` of a run as `granwave.load` gives it.
    ids
        Of the spheres, in their order along the line.
    """
    rows = result.rows(np.asarray(ids))
    way = np.subtract(*result["spheres/position"][rows[[-1, 0]]])
    return np.stack([result.frame(k, "velocity")[rows] for k in range(result.n_frames)]) @ (
        way / np.linalg.norm(way)
    )


def peaks(time: ArrayLike, velocity: ArrayLike, diameter: float) -> Peaks:
    """Times at which the pulse passes each sphere of a chain.

    Parameters
    ----------
    time
        (n_times,), s.
    velocity
        Along the chain: (n_times, n_spheres), m/s.
    """
    time = np.asarray(time, dtype=np.float64)
    velocity = np.asarray(velocity, dtype=np.float64)
    found = [first_peak(time, one, floor=0.5) for one in velocity.T]
    when, largest = (np.array([pair[k] for pair in found]) for k in (0, 1))
    largest[when >= time[-2]] = np.nan
    when[~np.isfinite(largest)] = np.nan
    speed = np.full(len(largest), np.nan)
    speed[1:-1] = 2 * diameter / (when[2:] - when[:-2])
    speed[speed <= 0] = np.nan
    return Peaks(largest, when, speed)


def lengths(time: ArrayLike, velocity: ArrayLike, diameter: float) -> dict[str, Array]:
    """Length of the pulse at each sphere: its duration by each of `MEASURES` times the speed;
    (n_spheres,), diameters.

    See `peaks` for the parameters.
    """
    time = np.asarray(time, dtype=np.float64)
    velocity = np.asarray(velocity, dtype=np.float64)
    found = peaks(time, velocity, diameter)
    fine = np.linspace(time[0], time[-1], _FINE * (len(time) - 1) + 1)
    known = np.where(np.isfinite(found.speed), found.time, np.nan)
    durations = [
        _durations(fine, CubicSpline(time, one), t)
        for one, t in zip(velocity.T, known, strict=True)
    ]
    return {
        name: np.array(durations)[:, k] * found.speed / diameter for k, name in enumerate(MEASURES)
    }


def _durations(
    time: Array, velocity: CubicSpline, centre: float
) -> tuple[float, float, float, float]:
    """Duration of a pulse by the four measures, s."""
    if not np.isfinite(centre):
        return (np.nan,) * 4
    v = velocity(time)
    a = velocity(time, 1)
    k = int(np.searchsorted(time, centre))
    before = a[: k + 1]
    half_a = width(time[: k + 1], before)
    half_v = width(time, v)
    if not np.isfinite(half_v):
        return np.nan, np.nan, half_a, half_v
    near = np.abs(time - centre) < 2 * half_v  # the pulse alone, not what follows

    def fit(values: Array, shape: Callable[[Array], Array]) -> float:
        start = (centre, 2.75 * half_v)

        def misses(x: Array) -> Array:
            return (
                shape(np.clip(math.pi * (time[near] - x[0]) / x[1], -math.pi / 2, math.pi / 2))
                - values[near]
            )

        found = least_squares(misses, start, x_scale=(half_v, half_v))
        return float(found.x[1])

    scaled_a = -a / np.abs(a[near]).max() * _LARGEST
    return (
        fit(scaled_a, lambda x: np.cos(x) ** 3 * np.sin(x)),
        fit(v / v[near].max(), lambda x: np.cos(x) ** 4),
        half_a,
        half_v,
    )


def speed_between(found: Peaks, first: int, second: int, diameter: float) -> tuple[float, float]:
    """Mean of the largest velocities at two spheres of a line, and speed of the wave between them,
    m/s.

    Parameters
    ----------
    found
        From `peaks`.
    first, second
        Positions of the spheres along the line, from 1.
    diameter
        Distance between neighbours, m.

    Returns
    -------
    tuple
        (NaN, NaN) where the wave did not pass from the first to the second.
    """
    ends = [first - 1, second - 1]
    if second > len(found.time) or not np.diff(found.time[ends])[0] > 0:
        return np.nan, np.nan
    return float(found.velocity[ends].mean()), float(
        (second - first) * diameter / np.diff(found.time[ends])[0]
    )


@cache
def solitary_lengths() -> dict[str, float]:
    """Lengths of Nesterenko's solitary wave by the four measures of a pulse's length, by name, in
    diameters.
    """
    half_v = 2 * math.acos(0.5**0.25) / math.pi * LENGTH
    ends = [
        brentq(lambda x: math.cos(x) ** 3 * math.sin(x) - _LARGEST / 2, *span)
        for span in ((0.0, math.pi / 6), (math.pi / 6, math.pi / 2))
    ]
    return dict(
        zip(MEASURES, (LENGTH, LENGTH, (ends[1] - ends[0]) / math.pi * LENGTH, half_v), strict=True)
    )


def reflection(time: ArrayLike, force: ArrayLike, place: int, beyond: int) -> float:
    """Peak force of the wave reflected to a contact of a chain, divided by the peak force of the
    incident wave.

    The search ends when waves from the far end can arrive; NaN if the record ends sooner, or if the
    contact is too near an end.

    Parameters
    ----------
    time, force
        (n_times,), s, and of the contacts, (n_times, n_contacts), N.
    place
        Index of the contact, from 0.
    beyond
        Contacts that there must be beyond it.
    """
    time = np.asarray(time, dtype=np.float64)
    force = np.asarray(force, dtype=np.float64)
    n = force.shape[1]
    if place < 2 or place + beyond > n:
        return np.nan
    (here, peak), (early, _), (far, _) = (
        first_peak(time, force[:, k], floor=0.5) for k in (place, 1, n - 1)
    )
    period = (here - early) / (place - 1)  # time from contact to contact
    gone = np.flatnonzero((time > here) & (force[:, place] < _GONE * peak))
    until = far + _BACK * (n - place) * period
    if not len(gone) or time[-1] < until:
        return np.nan
    after = force[int(gone[0]) :, place][time[int(gone[0]) :] < until]
    return float(after.max(initial=0.0) / peak)


def speed_along_layers(result: Result, line: PrecompressedLine) -> float:
    """c0 along the stacking of a packing, m/s; NaN if the run has too few layers, or is too short.

    The mean velocity of a layer of a periodic packing obeys the linear chain of layers exactly as
    long as the motion is linear, for any choice of impacted spheres in the top layer; in a packing
    with free sides until the reflection from the sides arrives. The times of its crests then give
    omega, and the speed of long waves.

    Parameters
    ----------
    line
        The line that the layers are.
    """
    case = result.case
    time = result.frame_times
    _, mean = _means(result, 2)
    nx, ny, nz = case.packing.size
    deepest = nz - _BEFORE_END
    if not case.boundary.periodic:
        half = min(nx, ny * np.sqrt(3) / 2) / 2
        deepest = min(deepest, int(_BEFORE_SIDES * half / case.packing.rule.layer_spacing))
    numbers, times = _crests(time, mean[:, :deepest])
    return long_wave_speed(line, numbers, times) if len(numbers) >= _FEWEST else np.nan


def _crests(time: Array, mean: Array) -> tuple[NDArray[np.int64], Array]:
    """Layers, from 1, that the crest of their velocities (n_times, n_layers) has passed, and the
    times.
    """
    fine = np.linspace(time[0], time[-1], _FINE_CRESTS * (len(time) - 1) + 1)
    times = np.array(
        [first_peak(fine, CubicSpline(time, one)(fine), floor=0.5)[0] for one in mean.T]
    )
    numbers = np.arange(1, len(times) + 1)
    good = (numbers >= _FIRST_LAYER) & np.isfinite(times) & (times < time[-2])
    return numbers[good], times[good]


def long_wave_speed(line: PrecompressedLine, numbers: NDArray[np.int64], times: ArrayLike) -> float:
    """c0 from the times of the velocity crests in a linear chain, after an impact on its first
    body, m/s.

    Parameters
    ----------
    line
        The line, for its spacing.
    numbers, times
        Bodies, from 1, and the time of the first crest of each, s: (n_bodies,).
    """
    times = np.asarray(times, dtype=np.float64)
    return line.spacing / (2 * float(np.polyfit(crest_times(numbers), times, 1)[0]))


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
        """Frequency of the largest amplitude at each k: (n_k,), Hz, by a parabola; NaN if it is
        below the floor.
        """
        top = np.argmax(self.amplitude, axis=0)
        inner = np.clip(top, 1, len(self.frequency) - 2)
        left, middle, right = (
            np.log(self.amplitude[inner + step, np.arange(len(self.k))] + 1e-300)
            for step in (-1, 0, 1)
        )
        curve = left - 2 * middle + right
        shift = np.where(curve < 0, 0.5 * (left - right) / np.where(curve < 0, curve, 1.0), 0.0)
        found = self.frequency[inner] + np.clip(shift, -1, 1) * (
            self.frequency[1] - self.frequency[0]
        )
        strong = self.amplitude.max(axis=0) > floor
        return np.where(strong & (top == inner), found, np.nan)


def space_time_transform(
    time: ArrayLike,
    place: ArrayLike,
    velocity: ArrayLike,
    k: ArrayLike,
    frequency: ArrayLike,
    *,
    taper_space: bool = True,
) -> SpaceTime:
    """Transform velocities along a line of grains.

    Parameters
    ----------
    time
        Even instants: (n_times,), s.
    place
        Uniform positions along the line: (n_places,), m.
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
        Times or positions are not uniform.
    """
    time = np.asarray(time, dtype=np.float64)
    place = np.asarray(place, dtype=np.float64)
    velocity = np.asarray(velocity, dtype=np.float64)
    k = np.asarray(k, dtype=np.float64)
    frequency = np.asarray(frequency, dtype=np.float64)
    for name, values in (("times", time), ("places", place)):
        steps = np.diff(values)
        if not len(steps) or np.abs(steps - steps.mean()).max() > max(_EVEN_STEPS, 1e-3) * abs(
            steps.mean()
        ):
            raise ValueError(f"found {name} with non-uniform steps, expected uniform steps")
    step = float(np.diff(time).mean())
    spacing = float(np.diff(place).mean())
    window = np.hanning(len(time) + 2)[1:-1, None]
    across = np.hanning(len(place) + 2)[1:-1] if taper_space else np.ones(len(place))
    values = velocity * window * across
    dw = 2 * np.pi * float(np.diff(frequency).mean())
    dk = float(np.diff(k).mean())
    in_time = czt(
        values,
        len(frequency),
        w=np.exp(1j * dw * step),
        a=np.exp(-2j * np.pi * float(frequency[0]) * step),
        axis=0,
    )
    found = np.abs(
        czt(
            in_time,
            len(k),
            w=np.exp(-1j * dk * spacing),
            a=np.exp(1j * float(k[0]) * spacing),
            axis=1,
        )
    )
    return SpaceTime(k, frequency, found / found.max())
