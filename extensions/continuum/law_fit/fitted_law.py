"""A contact law whose constants were fitted to measurements, the result of all fits."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

from pandas import DataFrame

from granwave._contact_laws import ContactLaw
from granwave.lammps_inputs.case.material import Material

YIELD = "yield_strength"


def place_of_softer(materials: Sequence[Material]) -> int:
    """Return the index of the material that yields first. A material without a yield strength
    yields last; of equal materials the first is taken.
    """
    strengths = [material.yield_strength or math.inf for material in materials]
    return strengths.index(min(strengths))


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class FittedLaw:
    """Result of a fit.

    Attributes
    ----------
    source
        Name of the measurements, for messages.
    n_rows
        Number of their rows.
    law, published
        Law with the fitted constants, and with the published ones.
    constants
        All constants of the law, by name.
    uncertainty
        Standard uncertainty of each fitted constant, in its own unit; infinite if the measurements
        do not determine it.
    at_bound
        Names of the constants that ended at a bound of the search.
    materials, radii
        Materials of the two bodies, with the fitted yield strength, and radii, m.
    softer
        Index of the softer material in ``materials``: the lower yield strength before the fit.
    correlation
        Correlation of the residuals of neighbouring rows.
    misfit
        Deviations by part of the measurements, in columns ``part``, ``rows``, number of rows, and
        ``rms_percent``, ``largest_percent``, ``published_rms_percent``,
        ``published_largest_percent``, of both laws.
    """

    source: str
    n_rows: int
    law: ContactLaw
    published: ContactLaw
    constants: dict[str, float]
    uncertainty: dict[str, float]
    at_bound: tuple[str, ...]
    materials: tuple[Material, ...]
    radii: tuple[float, ...]
    correlation: float
    misfit: DataFrame
    softer: int = 0

    @property
    def softer_material(self) -> Material:
        """Softer of the materials, with the fitted yield strength."""
        return self.materials[self.softer]

    def value(self, name: str) -> float:
        """Return the value of a constant, or of the yield strength, Pa."""
        return self.law.yield_strength if name == YIELD else self.constants[name]

    def published_value(self, name: str) -> float:
        """Return the published value of a constant, or the yield strength before the fit, Pa."""
        if name == YIELD:
            return self.published.yield_strength
        return self.published.constants[name]

    def undetermined(self, name: str) -> bool:
        """Return True if the uncertainty of a constant exceeds its value, or if it ended at a
        bound.
        """
        return name in self.at_bound or not self.uncertainty[name] <= abs(self.value(name))

    def state(self, name: str) -> str:
        """Describe how a value was obtained: fitted, held, or not determined and why."""
        if name not in self.uncertainty:
            return "held"
        if name in self.at_bound:
            return "not determined: at the limit of the search"
        return "not determined: uncertainty exceeds it" if self.undetermined(name) else "fitted"

    @property
    def notes(self) -> list[str]:
        """Sentences on the measurements for the head of fit.toml."""
        return []

    @property
    def scale(self) -> str:
        """Sentence on first yield, which divides the measurements into parts."""
        return f"overlaps in units of the overlap at first yield, {self.law.yield_overlap:.4g} m"
