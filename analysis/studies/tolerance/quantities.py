"""Quantities by which imperfect packings are compared with the ideal one: numbers of a run's summary."""

from __future__ import annotations

import dataclasses
from typing import Literal


@dataclasses.dataclass(frozen=True)
class Quantity:
    """One number of a run.

    Attributes
    ----------
    name
        In the summary, and of a column, with the unit in SI at the end.
    words
        For people, in the middle of a sentence.
    unit, scale
        As shown, and its size in SI.
    better
        Which way protects better; empty where neither does.
    """

    name: str
    words: str
    unit: str = ""
    scale: float = 1.0
    better: Literal["more", "less", ""] = ""

    @property
    def title(self) -> str:
        """For an axis of a figure."""
        return f"{self.words.capitalize()} ({self.unit})" if self.unit else self.words.capitalize()


FORCE = Quantity("wall_peak_force_N", "peak force on the bottom", "N", better="less")
REDUCTION = Quantity("peak_reduction", "peak force without the packing over that with it", better="more")
DISSIPATED = Quantity("dissipated_fraction", "dissipated share of the energy", better="more")
PLASTIC = Quantity("plastic_fraction", "share dissipated by yielding", better="more")
FRICTION = Quantity("friction_fraction", "share dissipated by friction")
CONTACTS = Quantity("n_plastic_contacts", "yielded contacts")
SPHERES = Quantity("n_plastic_spheres", "yielded spheres")
VOLUME = Quantity("plastic_zone_volume_m3", "plastic volume", "cm³", 1e-6)
DEPTH = Quantity("plastic_zone_depth_m", "plastic depth", "mm", 1e-3)
ARRIVAL = Quantity("base_arrival_s", "arrival at the bottom", "µs", 1e-6)

QUANTITIES = (
    FORCE, REDUCTION, DISSIPATED, PLASTIC, FRICTION, CONTACTS, SPHERES, VOLUME, DEPTH, ARRIVAL,
)  # fmt: skip
#: What an ideal packing is good for: how much of it is left is told of these.
PERFORMANCE = (FORCE, DISSIPATED, PLASTIC)
