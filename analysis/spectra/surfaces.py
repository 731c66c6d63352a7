"""Slowness of long waves, and frequencies over a plane of wave vectors."""

from __future__ import annotations

import dataclasses

import numpy as np

from granwave.analysis.spectra.network import Array
from granwave.analysis.spectra.stiffness import DENSE_UP_TO, Stiffness

PLANES = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
_LONG = 1e-3  # |k| times the largest period: long waves, whose dispersion is 1e-7
_ANGLES, _GRID = 180, 61
_MOST_FREEDOMS = 48  # of a cell whose whole spectrum is found at all points of the grid
_RIGID = 1e-9  # (c k)^2 over the largest omega^2 times (k a)^2


@dataclasses.dataclass(frozen=True, eq=False)
class Surface:
    """Waves in a plane.

    Attributes
    ----------
    plane
        Name of the plane, such as ``xz``.
    angle
        Directions, from the first axis to the second: (n_angles,), rad.
    speed
        Phase velocities of long waves, rising: (n_angles, n_waves), m/s; NaN where nothing resists.
    k
        Components of wave vectors along each axis: (n,), rad/m.
    frequency
        Of the lowest bands: (n, n, n_bands), Hz; rows along the second axis; NaN where nothing resists.
    """

    plane: str
    angle: Array
    speed: Array
    k: Array
    frequency: Array

    @property
    def slowness(self) -> Array:
        """Slowness, 1/c: (n_angles, n_waves), s/m."""
        return np.asarray(1 / self.speed)


def long_wave_speeds(stiffness: Stiffness, directions: Array) -> Array:
    """Return the speeds of long waves along unit vectors (n, 3), rising: (n, n_waves), m/s; NaN where nothing resists.

    As many as there are directions in which the grains can be displaced together.
    """
    network = stiffness.network
    n_waves = int(network.moves[:, :3].all(axis=0).sum()) if network.n_grains else 0
    if network.supports.grain.size:
        held = (np.abs(network.supports.normal).max(axis=0) > 0) | (network.supports.tangential.max() > 0)
        n_waves = int((network.moves[:, :3].all(axis=0) & ~held).sum())
    size = float(np.linalg.norm(network.periods, axis=1).max())
    k = directions * (_LONG / size)
    if network.n_freedoms <= DENSE_UP_TO:
        square = np.linalg.eigvalsh(stiffness.dense(k))[:, :n_waves]
        largest = float(np.abs(stiffness.dense(k[:1])).sum(axis=2).max())
    else:
        from granwave.analysis.spectra.bands import _bound, lowest

        largest = _bound(stiffness)
        square = np.array([lowest(stiffness.matrix(one), n_waves, largest)[0] for one in k])
    there = square > _RIGID * largest * _LONG**2
    return np.where(there, np.sqrt(np.where(there, square, 0.0)) / (_LONG / size), np.nan)


def surface(stiffness: Stiffness, plane: str, n_bands: int = 3) -> Surface | None:
    """Return slowness and frequencies over a plane; None for large cells, and if the packing does not repeat there."""
    network, (a, b) = stiffness.network, PLANES[plane]
    if network.n_freedoms > _MOST_FREEDOMS or len(network.periods) < 2:
        return None
    inside = network.periods.T @ np.linalg.pinv(network.periods.T)
    if not np.allclose(inside[[a, b]][:, [a, b]], np.eye(2), atol=1e-9):
        return None
    angle = np.linspace(0, 2 * np.pi, _ANGLES, endpoint=False)
    directions = np.zeros((_ANGLES, 3))
    directions[:, a], directions[:, b] = np.cos(angle), np.sin(angle)
    reciprocal = 2 * np.pi * np.linalg.pinv(network.periods)
    reach = float(np.abs(reciprocal).max()) * 0.75
    k = np.linspace(-reach, reach, _GRID)
    grid = np.zeros((_GRID * _GRID, 3))
    grid[:, a], grid[:, b] = (one.ravel() for one in np.meshgrid(k, k))
    square = np.concatenate([np.linalg.eigvalsh(stiffness.dense(part)) for part in np.array_split(grid, 16)])
    with np.errstate(invalid="ignore"):
        frequency = np.sqrt(square[:, :n_bands]) / (2 * np.pi)
    centre = np.argmin(np.abs(grid).sum(axis=1))
    frequency[centre] = np.nan_to_num(frequency[centre])
    return Surface(plane, angle, long_wave_speeds(stiffness, directions), k, frequency.reshape(_GRID, _GRID, -1))
