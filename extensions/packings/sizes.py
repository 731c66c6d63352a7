"""Distributions of diameters: ``packing.diameter`` of poured and compressed packings."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case import schema

_NORMAL_FORM = "[mean, standard deviation] in m, the mean above 0"
_UNIFORM_FORM = "[smallest, largest] in m, above 0"
_LARGEST_RATIO = 20.0  # largest ratio of diameters in a packing


@dataclasses.dataclass(frozen=True, kw_only=True)
class SizeDistribution:
    """Distribution of the diameters of a packing."""

    normal: tuple[float, float] | None = schema.typed(
        "mean and standard deviation of a normal distribution",
        schema.vector_type(2, _NORMAL_FORM, lambda mean, spread: mean > 0 and spread >= 0),
        unit="m",
        default=None,
    )
    uniform: tuple[float, float] | None = schema.typed(
        "smallest and largest diameter of a uniform distribution",
        schema.vector_type(2, _UNIFORM_FORM, lambda low, high: 0 < low <= high),
        unit="m",
        default=None,
    )
    cut: float = schema.number(
        "standard deviations at which a normal distribution is cut off", above=0, default=2.0
    )

    @property
    def mean(self) -> float:
        """Mean diameter, m."""
        if self.normal is not None:
            return self.normal[0]
        assert self.uniform is not None
        return sum(self.uniform) / 2

    @property
    def bounds(self) -> tuple[float, float]:
        """Smallest and largest diameter, m."""
        if self.normal is None:
            assert self.uniform is not None
            return self.uniform
        mean, spread = self.normal
        return mean - self.cut * spread, mean + self.cut * spread

    def checked(self) -> SizeDistribution:
        """Return the distribution; raise `ValidationError` unless it is valid and not too wide."""
        both = (self.normal is None) == (self.uniform is None)
        schema.refuse_if(both, f"{SIZES_FORM}: one of normal and uniform")
        low, high = self.bounds
        wide = low <= 0 or high > _LARGEST_RATIO * low
        schema.refuse_if(wide, f"diameters above 0, the largest at most {_LARGEST_RATIO:g} times the smallest; use a smaller standard deviation, or a smaller cut")  # fmt: skip
        return self

    def draw(self, n: int, random: np.random.Generator) -> NDArray[np.float64]:
        """Draw diameters: (n,), m."""
        low, high = self.bounds
        if self.normal is None:
            return random.uniform(low, high, n)
        mean, spread = self.normal
        if not spread:
            return np.full(n, mean)
        # by the inverse of the distribution, so that a diameter takes one random number
        from scipy.special import ndtr, ndtri

        share = ndtr(self.cut)
        level = random.uniform(1 - share, share, n)
        return np.asarray(mean + spread * ndtri(level), dtype=np.float64)


SIZES_FORM = "a diameter in m, {normal = [0.01, 0.0005]} or {uniform = [0.008, 0.012]}"


def _same(diameter: Any) -> SizeDistribution:
    return SizeDistribution(uniform=(diameter, diameter))


@dataclasses.dataclass(frozen=True)
class _DiameterType(schema.NumberType):
    """Type of the diameter of equal grains."""

    def read(self, value: Any) -> Any:
        """Return the distribution of equal grains."""
        return _same(super().read(value))


DIAMETERS = schema.EitherType(
    types=(
        schema.TableType(section=SizeDistribution, expected=SIZES_FORM,
                         finish=SizeDistribution.checked),
        _DiameterType(above=0, form=SIZES_FORM),
    ),
    form=SIZES_FORM,
)  # fmt: skip


def volume(diameters: NDArray[np.float64]) -> float:
    """Return the volume of spheres of these diameters, m^3."""
    return float((math.pi / 6 * diameters**3).sum())
