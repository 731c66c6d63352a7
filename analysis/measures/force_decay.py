"""Decay of the peak force with depth: exponential, and a power of the depth.

Both are least-squares lines through the logarithms of the forces, with equal weights:

    F = F_0 exp(-z/L)          rate 1/L, of waves that lose the same fraction in every layer
    F = F_D (z/D)^-n           exponent n, of waves that spread without a scale

Standard errors are standard errors of the slopes. They measure the scatter of the layers about the
line, which is systematic: forces that follow neither law have a large standard error.

A decay is reported only if it describes the forces. It is refused

* where the material or the diameter changes along the depth;
* where the force is constant within 2 % in the deeper half of the layers, as in a uniform elastic
  chain behind its first beads;
* where the misfit of both laws, the root mean square of ln(F / fit), is 10 % or more: the forces
  leave the law systematically, and the standard error of its constant is no uncertainty;
* where the law explains less than 85 % of the variance of ln(F).

Damped chains and 8 layers of fcc are within 5 % of the better law. Lattices of 12 and 24 layers in
3-D are 3 to 23 % from it, layers in a plane up to 22 %; the law explains more than 96 % of the
variance, and many have a constant force behind a decay. Chains with a step of the material were 50
to 55 % from the law, which explained 74 to 76 %, and 440 % where layers ahead of the wave were
included. A poured bed of 201 grains was 40 % from the law, which explained 54 %.

Forces are those of the first wave, see `granwave.analysis.measures.layer_peaks`. Layers whose force
is not known are not fitted.

The misfit of fcc and hcp is geometric. Up to some 7 diameters the largest force is that of the
contacts along the preferred directions, which decays exponentially; farther away it is that of the
wave behind, which decays more slowly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from granwave.analysis.measures.beads import beads_on_axis
from granwave.analysis.measures.layer_peaks import LayerPeaks, layer_peaks, layers_of
from granwave.analysis.measures.signals import Array
from granwave.analysis.result.reader import Result

_LEAST_FIT = 4  # layers of a fit of the decay
_TOP = 0.5  # diameters below the impacted sphere, above which layers are left out of the fit
_DEGREES = 2  # number of constants of the fit
_MOST_MISFIT = 0.1  # root mean square of ln(F / fit) from which on a law does not describe forces
_LEAST_EXPLAINED = 0.85  # fraction of the variance of ln(F) that a law explains
_CONSTANT = 0.02  # largest over smallest force of the deeper half of a fit, minus 1
_LEAST_PERCENT = 0.1  # smallest change that is named, per cent
_SAME_DEPTH = 1e-6  # difference of equal depths, diameters
_SAME_SIZE = 1.2  # largest over smallest median diameter of layers with one decay


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
    explained
        Fraction of the variance of ``ln(F)`` that the fit explains (R²).
    late_change
        Largest over smallest force of the deeper half of the layers of the fit, minus 1.
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
    explained: float
    late_change: float
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
    explained
        Fraction of the variance of ``ln(F)`` that the fit explains (R²).
    late_change
        Largest over smallest force of the deeper half of the layers of the fit, minus 1.
    depth
        Depths of the layers of the fit: (n_layers,), m.
    """

    rate: float
    error: float
    force: float
    misfit: float
    explained: float
    late_change: float
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


Decay = ForceDecay | PowerDecay


class FittedLine(NamedTuple):
    """Line of least squares: slope with its standard error, value at 0, root mean square of the
    misfit, and the fraction of the variance that it explains.
    """

    slope: float
    error: float
    start: float
    misfit: float
    explained: float


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
    return PowerDecay(
        exponent=-line.slope,
        error=line.error,
        force=math.exp(line.start),
        diameter=diameter,
        misfit=line.misfit,
        explained=line.explained,
        late_change=_late_change(force),
        first=float(depth[0]),
        last=float(depth[-1]),
        n_layers=len(depth),
    )


def _late_change(force: Array) -> float:
    """Return the largest over the smallest force of the deeper half, minus 1."""
    late = force[len(force) // 2 :]
    return float(late.max() / late.min()) - 1


def exponential_of_depth(depth: ArrayLike, force: ArrayLike) -> ForceDecay:
    """Fit forces by an exponential of the depth, by least squares in their logarithms.

    Parameters
    ----------
    depth, force
        At least three, depths rising, forces above 0: (n_layers,), m and N.
    """
    depth = np.asarray(depth, dtype=np.float64)
    force = np.asarray(force, dtype=np.float64)
    line = _line(depth, np.log(force))
    return ForceDecay(
        rate=-line.slope,
        error=line.error,
        force=math.exp(line.start),
        misfit=line.misfit,
        explained=line.explained,
        late_change=_late_change(force),
        depth=depth,
    )


def force_decay(result: Result) -> Decay | None:
    """Fit the largest peak force of each layer against depth by an exponential and by a power law;
    return the fit with the smaller misfit, or None if there is no decay; see `no_decay_reason`.
    """
    return accepted(both_decays(result))


def no_decay_reason(result: Result) -> str:
    """Return the reason why `force_decay` returns no decay; empty if it returns one."""
    return reason_against(both_decays(result))


def accepted(fits: tuple[ForceDecay, PowerDecay] | str) -> Decay | None:
    """Return the fit with the smaller misfit; None without fits, and if it is no description of the
    forces.
    """
    if isinstance(fits, str) or objection(better_of(fits)):
        return None
    return better_of(fits)


def reason_against(fits: tuple[ForceDecay, PowerDecay] | str) -> str:
    """Return the reason why no fit is `accepted`; empty if one is."""
    return fits if isinstance(fits, str) else objection(better_of(fits))


def better_of(fits: tuple[ForceDecay, PowerDecay]) -> Decay:
    """Return the fit with the smaller misfit."""
    exponential, power = fits
    return exponential if exponential.misfit <= power.misfit else power


def objection(decay: Decay) -> str:
    """Return the reason why the better fit is no description of the forces; empty if it is one."""
    if decay.misfit >= _MOST_MISFIT:
        return f"neither law describes the decay, rms {100 * decay.misfit:.2g} %"
    if decay.late_change <= _CONSTANT:
        change = max(100 * decay.late_change, _LEAST_PERCENT)
        return f"the peak force is constant within {change:.1g} % in the deeper half"
    if decay.explained < _LEAST_EXPLAINED:
        explained = 100 * max(decay.explained, 0.0)
        return f"no decay fits: the law explains {explained:.2g} % of the variance of ln F"
    return ""


def both_decays(
    result: Result, peaks: LayerPeaks | None = None
) -> tuple[ForceDecay, PowerDecay] | str:
    """Fit the largest peak force of each layer in the first wave against depth, by an exponential
    and by a power.

    Omitted are the impacted layer, which shares its largest contact with the next, the deepest
    layer, which the bottom holds or leaves free, and layers whose peak is not known, see
    `LayerPeaks`. Under a static load the forces are dynamic: above the static force of each
    contact.

    Parameters
    ----------
    result
        ``run.result`` of a run as `granwave.load` gives it.
    peaks
        Forces of the layers, if they are known.

    Returns
    -------
    tuple of ForceDecay and PowerDecay, or str
        The reason for fewer than four layers, and where grains differ along the depth.
    """
    peaks = layer_peaks(result) if peaks is None else peaks
    diameter = result.case.packing.diameter
    below = peaks.depth > _TOP * diameter
    below[-1] = False
    fitted = below & peaks.is_known
    n_fitted = int(np.count_nonzero(fitted))
    if n_fitted < _LEAST_FIT:
        is_cut = bool(np.any(below & peaks.is_later))
        before = " before the reflection" if is_cut else ""
        return f"{_only(n_fitted)}{before}"
    if _differs_along_depth(result, peaks.depth[below]):
        return "the material or the diameter changes with depth"
    depth = peaks.depth[fitted]
    force = peaks.largest[fitted]
    return exponential_of_depth(depth, force), _power(depth, force, diameter)


def decays_within(
    fits: tuple[ForceDecay, PowerDecay], depth: Array, force: Array, limits: tuple[float, float]
) -> tuple[ForceDecay, PowerDecay] | str:
    """Repeat fits with the layers of a smaller range of depths.

    Parameters
    ----------
    fits
        Fits to all layers that can be fitted.
    depth, force
        Of all layers: (n_layers,), m and N.
    limits
        Smallest and largest depth, in diameters.

    Returns
    -------
    tuple of ForceDecay and PowerDecay, or str
        The fits themselves if the range has all their layers; the reason for fewer than four
        layers.
    """
    exponential, power = fits
    first = (limits[0] - _SAME_DEPTH) * power.diameter
    last = (limits[1] + _SAME_DEPTH) * power.diameter
    if first <= power.first and power.last <= last:
        return fits
    fitted = np.isin(depth, exponential.depth) & (depth >= first) & (depth <= last)
    n_fitted = int(np.count_nonzero(fitted))
    if n_fitted < _LEAST_FIT:
        return f"{_only(n_fitted)} at the depths that all fitted runs have"
    exponential = exponential_of_depth(depth[fitted], force[fitted])
    return exponential, _power(depth[fitted], force[fitted], power.diameter)


def _only(n_layers: int) -> str:
    """Return the number of layers, too few for a fit."""
    if not n_layers:
        return "no layers"
    return f"only {n_layers} {'layer' if n_layers == 1 else 'layers'}"


def _differs_along_depth(result: Result, shown: Array) -> bool:
    """Return True if most grains of the layers do not have the same material at all depths, or if
    the median diameter changes.

    Parameters
    ----------
    shown
        Depths of the layers that count: (n,), m.
    """
    radius = result["spheres/radius"]
    mean, layer = layers_of(result, beads_on_axis(result))
    body = result.assembly.body[result["spheres/id"] - 1]
    kinds = np.zeros((len(mean), int(body.max()) + 1), dtype=np.int64)
    is_in_layer = layer >= 0
    np.add.at(kinds, (layer[is_in_layer], body[is_in_layer]), 1)
    is_shown = np.isin(mean, shown)
    most = kinds[is_shown].argmax(axis=1)
    size = np.array([np.median(radius[layer == n]) for n in np.flatnonzero(is_shown)])
    return bool(np.any(most != most[0]) or size.max() > _SAME_SIZE * size.min())


def _line(x: Array, y: Array) -> FittedLine:
    about = x - x.mean()
    spread = float(about @ about)
    slope = float(about @ y) / spread
    start = float(y.mean() - slope * x.mean())
    residual = y - start - slope * x
    squares = float(residual @ residual)
    error = math.sqrt(squares / (len(x) - _DEGREES) / spread)
    variance = float(np.var(y)) * len(y)
    explained = 1 - squares / variance if variance else 0.0
    return FittedLine(slope, error, start, math.sqrt(squares / len(x)), explained)
