"""Motion of all grains of a plane crystal: rotations, rows that move out and in, symmetry, and what a camera sees."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.studies.lateral.runs import LateralRun

_ALL = "lines/all"
_IN_ROW = 0.01  # diameters
_QUIET = 0.25  # of the peak: a second pulse begins where the speed has been below it
_SMALL = 0.05  # of the first peak: least prominence of the second
_SAME = 1e-6  # diameters


def turned(run: LateralRun) -> tuple[float, float]:
    """Return the largest rotations of the grains at side walls, and of the others, degrees."""
    with_all = f"{_ALL}/angular_velocity"
    time, rate = run.array(f"{_ALL}/time"), run.array(with_all)[:, :, 1]
    angle = np.concatenate(
        [np.zeros((1, rate.shape[1])), np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(time)[:, None], axis=0)]
    )
    largest = np.degrees(np.abs(angle).max(axis=0))
    x = run.array(f"{_ALL}/position")[:, 0]
    at_walls = (x < x.min() + _SAME) | (x > x.max() - _SAME)
    return float(largest[at_walls].max()), float(largest[~at_walls].max())


def row_shift(run: LateralRun, when: float) -> float:
    """Return how far the left half of the second row has moved outwards at a time (s), um."""
    time, position = run.array(f"{_ALL}/time"), run.array(f"{_ALL}/position")
    aside = -run.array(f"{_ALL}/displacement")[:, :, 0]
    rows = np.unique(np.round(position[:, 2] / run.case.packing.diameter, 3))
    middle = 0.5 * (position[:, 0].min() + position[:, 0].max())
    second = np.abs(position[:, 2] / run.case.packing.diameter - rows[1]) < _IN_ROW
    left = second & (position[:, 0] < middle - _SAME)
    return float(np.interp(when, time, 1e6 * aside[:, left].mean(axis=1)))


def mirrored(run: LateralRun) -> float:
    """Return the largest difference of displacements of grains that mirror each other, over a diameter."""
    position, moved = run.array(f"{_ALL}/position"), run.array(f"{_ALL}/displacement")
    diameter = run.case.packing.diameter
    middle = 0.5 * (position[:, 0].min() + position[:, 0].max())
    image = position.copy()
    image[:, 0] = 2 * middle - image[:, 0]
    from scipy.spatial import cKDTree  # takes longer to load than most commands need

    _, partner = cKDTree(position).query(image)
    apart = np.abs(moved[:, :, 0] + moved[:, partner, 0]).max(), np.abs(moved[:, :, 2] - moved[:, partner, 2]).max()
    return float(max(apart) / diameter)


def seen_by_camera(run: LateralRun, rate: float) -> tuple[float, float]:
    """Return the least and the largest ratio of the largest speeds that frames show to the true ones, of the line.

    A camera sees displacements: between two frames the mean velocity.

    Parameters
    ----------
    rate
        Frames a second.
    """
    time, moved = run.array("lines/down/time"), run.array("lines/down/displacement")
    true = run.down.largest_speed
    frames = np.arange(0.0, time[-1], 1 / rate)
    places = np.stack(
        [[np.interp(frames, time, moved[:, n, axis]) for n in range(moved.shape[1])] for axis in (0, 2)], axis=2
    )
    shown = np.linalg.norm(np.diff(places, axis=1) * rate, axis=2).max(axis=1)
    ratio = shown / true
    return float(ratio.min()), float(ratio.max())


def later_peak(run: LateralRun) -> float | None:
    """Return when the second pulse has its peak in the deepest grains that the floor does not hold, s; None: none."""
    time = run.array("lines/down/time")
    speed = np.linalg.norm(run.array("lines/down/velocity"), axis=2)
    deep = slice(len(run.depth) // 2, run.down.fitted.stop)
    found = [_second(time, one) for one in speed.T[deep]]
    known = [one for one in found if one is not None]
    return float(np.median(known)) if known else None


def _second(time: NDArray[np.float64], speed: NDArray[np.float64]) -> float | None:
    first = int(speed.argmax())
    low = np.flatnonzero(speed[first:] < _QUIET * speed[first])
    if not low.size:
        return None
    rest = first + int(low[0])
    from scipy.signal import find_peaks  # takes longer to load than most commands need

    peaks, _ = find_peaks(speed[rest:], prominence=_SMALL * float(speed[first]))
    return float(time[rest + int(peaks[np.argmax(speed[rest + peaks])])]) if len(peaks) else None
