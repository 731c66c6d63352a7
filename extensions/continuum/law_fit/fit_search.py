"""Least-squares search with Huber's loss and several starts, and uncertainties of its result.

All values are relative to the start of the search.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from granwave.lammps_inputs.case.contact.contact import LAW_CONSTANTS as PUBLISHED

Array = NDArray[np.float64]
Rows = NDArray[np.bool_]
Residuals = Callable[[Array], Array]

_WIDTHS = (0.05, 1e-3)  # residual above which the loss is linear: initial and smallest width
_OUTLIER = 3.0  # the same in standard deviations
_STEP = 1e-5  # relative step of derivatives
_SINGULAR = 1e-10  # relative size of singular values that count as zero
_ROUGH = 1e-5  # tolerance of the first search
_FINE = 1e-9  # tolerance of the last search
_FIRST_JOINT = 20.0  # smallest value of area_switch in the search
_JOINTS = 10  # number of values of area_switch in the search
_RELEASED = 3  # number of them that are refined
_NEAR = 25.0  # largest excess cost of other fits that affect the uncertainties, variances
_OF_UNLOADING = ("residual_", "unloading_")


class Search:
    """Least-squares search over some of the values and some of the rows.

    Parameters
    ----------
    residuals
        Function of the values that returns the residuals, (n_rows,).
    bounds
        Bounds of the values, (n_values, 2).
    names
        Names of the values.
    loading
        True for residuals on loading, (n_rows,).
    largest
        Largest overlap of the curve / overlap at first yield.

    Attributes
    ----------
    width
        Residual from which on the loss is linear.
    """

    def __init__(
        self,
        residuals: Residuals,
        bounds: Array,
        names: Sequence[str],
        loading: Rows,
        largest: float,
    ) -> None:
        self.residuals = residuals
        self.bounds = bounds
        self.names = names
        self.loading = loading
        self.width = _WIDTHS[0]
        self.joint = names.index("area_switch") if "area_switch" in names else None
        self.joints = _joints(names, largest) if self.joint is not None else []

    def best(self) -> Array:
        """Find the best values: first for loading, then for unloading, then all together."""
        every = np.arange(len(self.names))
        dents = np.array([name.startswith(_OF_UNLOADING) for name in self.names])
        tried = [(0.0, np.ones(every.size))]
        if (
            self.joint is not None
        ):  # each row that changes branch gives a local minimum: try several positions
            others = every[~dents & (every != self.joint)]
            tried = sorted(
                (self.solve(x, others, self.loading, rough=True) for x in self.joints),
                key=itemgetter(0),
            )
        released = [self.solve(x, every[~dents], self.loading) for _, x in tried[:_RELEASED]]
        _, x = self.solve(min(released, key=itemgetter(0))[1], every[dents], ~self.loading)
        for _ in range(3):
            _, x = self.solve(x, every)
            scatter = 1.4826 * float(
                np.median(np.abs(self.residuals(x)))
            )  # standard deviation from the median
            self.width = max(_OUTLIER * scatter, _WIDTHS[1])
        return x

    def alternatives(self, x: Array) -> list[tuple[float, Array]]:
        """Return cost and values of the best fits with the joint held at other positions."""
        if self.joint is None:
            return []
        others = np.flatnonzero(np.arange(x.size) != self.joint)
        return [
            self.solve(_replaced(x, [self.joint], start[self.joint]), others, rough=True)
            for start in self.joints
        ]

    def solve(
        self,
        x: Array,
        moving: NDArray[np.int_],
        rows: Rows | slice = slice(None),
        *,
        rough: bool = False,
    ) -> tuple[float, Array]:
        """Fit some of the values to some of the rows; return the cost and all values."""
        if moving.size == 0:
            return 0.0, x
        tolerance = _ROUGH if rough else _FINE
        solution = least_squares(
            lambda y: self.residuals(_replaced(x, moving, y))[rows], x[moving], bounds=self.bounds[moving].T,
            loss="huber", f_scale=self.width, x_scale="jac", diff_step=_STEP,
            ftol=tolerance, xtol=tolerance, gtol=1e-14, max_nfev=60 if rough else 200,
        )  # fmt: skip
        return float(solution.cost), _replaced(x, moving, solution.x)

    def cost(self, x: Array) -> float:
        """Return the cost of values, as in `solve`."""
        r = np.abs(self.residuals(x))
        return float(
            np.sum(np.where(r < self.width, 0.5 * r**2, self.width * (r - 0.5 * self.width)))
        )


def _replaced(x: Array, which: Sequence[int] | NDArray[np.int_], values: Array | float) -> Array:
    changed = x.copy()
    changed[which] = values
    return changed


def _joints(names: Sequence[str], largest: float) -> list[Array]:
    """Return starts of the search: published values, with several positions of the joint of the two
    area curves.
    """
    moves_with_joint = np.array([name in ("area_switch", "area_offset") for name in names])
    joints = np.geomspace(_FIRST_JOINT, max(largest, 2 * _FIRST_JOINT), _JOINTS)
    relative = joints / PUBLISHED["area_switch"]
    return [np.where(moves_with_joint, joint, 1.0) for joint in relative]


def uncertainties(search: Search, x: Array, at_bound: Rows) -> Array:
    """Return the standard uncertainties of the values, infinite for undetermined values and for
    values at a bound: (n_values,).

    A fit with another joint whose sum of squares is larger by d variances, and which differs by e
    in a value, implies that the uncertainty of this value is at least e/sqrt(d).
    """
    residuals = search.residuals
    bounds = search.bounds
    r = residuals(x)
    weight = np.minimum(1.0, search.width / np.maximum(np.abs(r), 1e-300))
    jacobian = np.empty((r.size, x.size))
    for k in range(x.size):
        step = _STEP * max(abs(x[k]), 1e-3)
        high = _replaced(x, [k], min(x[k] + step, bounds[k, 1]))
        low = _replaced(x, [k], max(x[k] - step, bounds[k, 0]))
        jacobian[:, k] = (residuals(high) - residuals(low)) / (high[k] - low[k])
    spread = np.full(x.size, np.inf)
    inner = np.flatnonzero(~at_bound)
    variance = float(np.sum(weight * r**2)) / max(r.size - inner.size, 1)
    _, singular, rows = np.linalg.svd(
        np.sqrt(weight)[:, None] * jacobian[:, inner], full_matrices=False
    )
    determined = singular > _SINGULAR * singular.max(initial=0.0)
    covariance = (rows[determined].T / singular[determined] ** 2) @ rows[determined]
    spread[inner] = np.sqrt(variance * np.diag(covariance))
    spread[inner[np.any(np.abs(rows[~determined]) > 1e-3, axis=0)]] = np.inf
    least = search.cost(x)
    for cost, other in search.alternatives(x):
        excess = 2 * (cost - least) / variance if variance > 0 else np.inf
        if excess < _NEAR:
            spread = np.maximum(spread, np.abs(other - x) / math.sqrt(max(excess, 1.0)))
    return spread
