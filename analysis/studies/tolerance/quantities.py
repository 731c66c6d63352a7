"""Imperfections of a packing, and the quantities of a run that they change."""

from __future__ import annotations

import dataclasses
from typing import Literal, NamedTuple


class Setting(NamedTuple):
    """Imperfections of a packing: scatter of the diameters (m), coefficient of friction, fraction
    of omitted spheres.
    """

    scatter: float = 0.0
    friction: float = 0.0
    vacancies: float = 0.0


IDEAL = Setting()


@dataclasses.dataclass(frozen=True)
class ToleranceQuantity:
    """A number of a run, or an imperfection.

    Attributes
    ----------
    name
        In the summary, with the unit in SI at the end; of an imperfection, its field of `Setting`.
    words
        In the middle of a sentence.
    unit, scale
        As shown, and its size in SI.
    better
        Direction that protects better; empty where neither does.
    column, key
        Of an imperfection: column of a CSV file, in SI, and key of a case file.
    """

    name: str
    words: str
    unit: str = ""
    scale: float = 1.0
    better: Literal["more", "less", ""] = ""
    column: str = ""
    key: str = ""

    @property
    def heading(self) -> str:
        """Heading of a column: the words, with a capital."""
        return self.words.capitalize()

    @property
    def title(self) -> str:
        """Title of an axis of a figure."""
        return f"{self.heading} ({self.unit})" if self.unit else self.heading

    def of(self, setting: Setting) -> float:
        """Value of an imperfection in a setting, in `unit`."""
        return float(f"{getattr(setting, self.name) / self.scale:.12g}")

    def show(self, value: float) -> str:
        """A value in `unit`, with it."""
        return f"{value:.3g} {self.unit}".rstrip()


SCATTER = ToleranceQuantity(
    "scatter",
    "diameter scatter",
    unit="µm",
    scale=1e-6,
    column="diameter_scatter_m",
    key="packing.diameter_scatter",
)
FRICTION = ToleranceQuantity(
    "friction",
    "friction coefficient",
    column="friction",
    key="contact.friction",
)
VACANCIES = ToleranceQuantity(
    "vacancies",
    "vacancies",
    unit="%",
    scale=0.01,
    column="vacancies",
    key="packing.vacancies",
)
#: Imperfections, in the order of `Setting`.
AXES = (SCATTER, FRICTION, VACANCIES)

FORCE = ToleranceQuantity("wall_peak_force_N", "peak force on the bottom", "N", better="less")
DISSIPATED = ToleranceQuantity("dissipated_fraction", "dissipated fraction", better="more")
REDUCTION = ToleranceQuantity(
    "peak_reduction", "peak force without packing / with packing", better="more"
)
BY_YIELDING = ToleranceQuantity(
    "plastic_fraction", "fraction dissipated by yielding", better="more"
)
BY_FRICTION = ToleranceQuantity("friction_fraction", "fraction dissipated by friction")
YIELDED_CONTACTS = ToleranceQuantity("n_plastic_contacts", "yielded contacts")
YIELDED_SPHERES = ToleranceQuantity("n_plastic_spheres", "yielded spheres")
PLASTIC_VOLUME = ToleranceQuantity("plastic_zone_volume_m3", "plastic volume", "cm³", 1e-6)
PLASTIC_DEPTH = ToleranceQuantity("plastic_zone_depth_m", "plastic depth", "mm", 1e-3)
ARRIVAL = ToleranceQuantity("base_arrival_s", "arrival at the bottom", "µs", 1e-6)

#: Quantities of the table of means.
TABULATED = (
    FORCE,
    REDUCTION,
    DISSIPATED,
    BY_YIELDING,
    BY_FRICTION,
    YIELDED_CONTACTS,
    YIELDED_SPHERES,
    PLASTIC_VOLUME,
    PLASTIC_DEPTH,
    ARRIVAL,
)
#: Quantities that are compared with the ideal packing's.
PERFORMANCE = (FORCE, DISSIPATED, BY_YIELDING)
#: Quantities of the figures, a panel each.
PANELS = (FORCE, DISSIPATED, BY_YIELDING, BY_FRICTION, YIELDED_SPHERES, ARRIVAL)


def in_words(setting: Setting) -> str:
    """Return a setting in words, such as ``diameter scatter 5 µm, friction coefficient 0.1``."""
    parts = [f"{axis.words} {axis.show(axis.of(setting))}" for axis in AXES if axis.of(setting)]
    return ", ".join(parts) or "ideal"
