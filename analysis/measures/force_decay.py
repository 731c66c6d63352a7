"""Decay of the peak force with depth: exponential, and a power of the depth.

Both are least-squares lines through the logarithms of the forces, with equal weights:

    F = F_0 exp(-z/L)          rate 1/L, of waves that lose the same fraction in every layer
    F = F_D (z/D)^-n           exponent n, of waves that spread without a scale

Standard errors are standard errors of the slopes. They measure the scatter of the layers about the
line, which is systematic: forces that follow neither law have a large standard error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.measures.dynamic_force import dynamic_contact_peaks, dynamic_peak_forces
from granwave.analysis.measures.geometry import layers
from granwave.analysis.measures.signals import Array
from granwave.analysis.result.reader import Result

_LEAST_FIT = 4  # layers of a fit of the decay
_TOP = 0.5  # diameters below the impacted sphere, above which layers are left out of the fit
_DEGREES = 2  # number of constants of the fit
BEFORE_END = 1 - 1e-9  # fraction of the run: a force that is largest later may still rise


@dataclass(frozen=True)
class PowerDecay:
    """Decay of the peak force as a power of the depth: ``F = F_D (z/D)^-exponent``.

    Attributes
    ----------
    exponent, error
        The exponent and its standard error.
    force
        Force of the fit at a depth of one diameter, N.
    diameter
        m.
    misfit
        Root mean square of ``ln(F / fit)``.
    first, last
        Depths of the first and the last layer of the fit, m.
    n_layers
        Number of its layers.
    """

    exponent: float
    error: float
    force: float
    diameter: float
    misfit: float
    first: float
    last: float
    n_layers: int

    def __call__(self, depth: Array) -> Array:
        """Return forces at depths, (n,), m: (n,), N."""
        return np.asarray(self.force * (depth / self.diameter) ** -self.exponent)


@dataclass(frozen=True, eq=False)
class ForceDecay:
    """Exponential decay of the peak force with depth: ``F = force * exp(-rate * z)``.

    Attributes
    ----------
    rate, error
        Decay and its standard error, 1/m.
    force
        Force of the fit at depth 0, N.
    misfit
        Root mean square of ``ln(F / fit)``.
    depth
        Depths of the layers of the fit: (n_layers,), m.
    """

    rate: float
    error: float
    force: float
    misfit: float
    depth: Array

    @property
    def first(self) -> float:
        """Depth of the first layer of the fit, m."""
        return float(self.depth[0])

    @property
    def last(self) -> float:
        """Depth of the last layer of the fit, m."""
        return float(self.depth[-1])

    @property
    def n_layers(self) -> int:
        """Number of layers of the fit."""
        return len(self.depth)

    def __call__(self, depth: ArrayLike) -> Array:
        """Return forces at depths, (n,), m: (n,), N."""
        return np.asarray(self.force * np.exp(-self.rate * np.asarray(depth)))


class FittedLine(NamedTuple):
    """Line of least squares: slope with its standard error, value at 0, root mean square of the
    misfit.
    """

    slope: float
    error: float
    start: float
    misfit: float


def power_decay(depth: Array, force: Array, diameter: float) -> PowerDecay | None:
    """Fit forces by a power of the depth, by least squares in their logarithms.

    Layers within half a diameter of the impacted sphere, where the load acts, and the last layer,
    which the bottom loads, are omitted.

    Parameters
    ----------
    depth, force
        Of the layers: (n_layers,), m and N.
    diameter
        Of the spheres, nominal, m.

    Returns
    -------
    PowerDecay or None
        None with fewer than four layers.
    """
    below = np.flatnonzero(depth > _TOP * diameter)[:-1]
    if len(below) < _LEAST_FIT:
        return None
    return _power(depth[below], force[below], diameter)


def _power(depth: Array, force: Array, diameter: float) -> PowerDecay:
    line = _line(np.log(depth / diameter), np.log(force))
    ends = (float(depth[0]), float(depth[-1]))
    at_diameter = math.exp(line.start)
    return PowerDecay(
        -line.slope, line.error, at_diameter, diameter, line.misfit, *ends, len(depth)
    )


def exponential_of_depth(depth: ArrayLike, force: ArrayLike) -> ForceDecay:
    """Fit forces by an exponential of the depth, by least squares in their logarithms.

    Parameters
    ----------
    depth, force
        At least three, depths rising, forces above 0: (n_layers,), m and N.
    """
    depth = np.asarray(depth, dtype=np.float64)
    line = _line(depth, np.log(np.asarray(force, dtype=np.float64)))
    return ForceDecay(-line.slope, line.error, math.exp(line.start), line.misfit, depth)


def force_decay(result: Result) -> ForceDecay | PowerDecay | None:
    """Fit the largest peak force of each layer against depth by an exponential and by a power law;
    return the fit with the smaller misfit, or None for fewer than four layers; see `both_decays`.
    """
    fits = both_decays(result)
    if fits is None:
        return None
    exponential, power = fits
    return exponential if exponential.misfit <= power.misfit else power


def both_decays(result: Result) -> tuple[ForceDecay, PowerDecay] | None:
    """Fit the largest peak force of each layer against depth, by an exponential and by a power.

    Omitted are the impacted layer, which shares its largest contact with the next, the deepest
    layer, which the bottom holds or leaves free, and layers whose force still rises at the end.
    Under a static load the forces are dynamic: above the static force of each contact.

    Parameters
    ----------
    result
        ``run.result`` of a run as `granwave.load` gives it.

    Returns
    -------
    tuple of ForceDecay and PowerDecay, or None
        None for fewer than four layers.
    """
    depth = result["spheres/position"][:, 2] - result.origin[2]
    diameter = result.case.packing.diameter
    mean, layer = layers(depth, result["spheres/radius"], diameter)
    force = np.zeros(len(mean))
    np.maximum.at(force, layer, dynamic_peak_forces(result))
    below = mean > _TOP * diameter
    below[-1] = False
    fitted = below & (force > 0) & ~still_rising(result, layer, force)
    if np.count_nonzero(fitted) < _LEAST_FIT:
        return None
    exponential = exponential_of_depth(mean[fitted], force[fitted])
    return exponential, _power(mean[fitted], force[fitted], diameter)


def _line(x: Array, y: Array) -> FittedLine:
    about = x - x.mean()
    spread = float(about @ about)
    slope = float(about @ y) / spread
    start = float(y.mean() - slope * x.mean())
    residual = y - start - slope * x
    squares = float(residual @ residual)
    error = math.sqrt(squares / (len(x) - _DEGREES) / spread)
    return FittedLine(slope, error, start, math.sqrt(squares / len(x)))


def still_rising(result: Result, layer: NDArray[np.int64], force: Array) -> NDArray[np.bool_]:
    """Return True for layers whose largest force was reached at the end of the run: (n_layers,).

    Parameters
    ----------
    layer
        Layer of each sphere: (n_spheres,).
    force
        Largest force of each layer, dynamic under a static load: (n_layers,), N.
    """
    last = BEFORE_END * float(result["energy/time"][-1])
    rising = np.zeros(len(force), dtype=bool)
    for i, j, peak, when in dynamic_contact_peaks(result):
        for ends in (i, j):
            there = layer[result.rows(ends)]
            rising[there[(peak >= force[there]) & (when >= last)]] = True
    return rising
