"""Comparison of imperfect packings with the ideal one: a value of every run, and its estimate by setting."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import Literal

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.measures.target.record import reached
from granwave.analysis.result.reader import Result
from granwave.analysis.statistics import Estimate, estimate, exactly
from granwave.analysis.studies.tolerance.runs import IDEAL, Packing, Replicate, Setting
from granwave.lammps_inputs.packing.disorder import is_random

_LATE = 0.05  # of the run

Better = Literal["more", "less", ""]


@dataclasses.dataclass(frozen=True)
class Quantity:
    """One number of a run.

    Attributes
    ----------
    name
        Of its column, with the unit in SI at the end.
    words
        For people, in the middle of a sentence.
    unit, scale
        As shown, and its size in SI.
    value
        Of a run, SI; NaN where it does not apply.
    better
        Which way protects better; empty where neither does.
    """

    name: str
    words: str
    unit: str
    scale: float
    value: Callable[[Replicate], float]
    better: Better = ""

    @property
    def title(self) -> str:
        """For an axis or the head of a column."""
        words = self.words[:1].upper() + self.words[1:]
        return f"{words} ({self.unit})" if self.unit else words


def _summed_up(name: str) -> Callable[[Replicate], float]:
    return lambda run: run.value(name)


def cut_short(run: Replicate) -> bool:
    """The force on the bottom was largest in the last part of the run, so that it may have grown on."""
    try:
        with Result(run.directory) as result:
            found = reached(result)
    except (MissingOutputError, OutputFormatError):  # only the summary was kept
        return False
    return found is not None and bool(found.time[found.force.argmax()] > (1 - _LATE) * found.time[-1])


FORCE = Quantity("wall_peak_force_N", "peak force on the bottom", "N", 1.0, _summed_up("wall_peak_force_N"), "less")
DISSIPATED = Quantity(
    "dissipated_fraction", "dissipated share of the energy", "", 1.0, _summed_up("dissipated_fraction"), "more"
)
PLASTIC = Quantity("plastic_fraction", "share dissipated by yielding", "", 1.0, _summed_up("plastic_fraction"), "more")
FRICTION = Quantity("friction_fraction", "share dissipated by friction", "", 1.0, _summed_up("friction_fraction"))
REDUCTION = Quantity(
    "peak_reduction", "peak force without the packing over that with it", "", 1.0, _summed_up("peak_reduction"), "more"
)
CONTACTS = Quantity("n_plastic_contacts", "yielded contacts", "", 1.0, _summed_up("n_plastic_contacts"))
SPHERES = Quantity("n_plastic_spheres", "yielded spheres", "", 1.0, _summed_up("n_plastic_spheres"))
VOLUME = Quantity("plastic_zone_volume_m3", "plastic volume", "cm³", 1e-6, _summed_up("plastic_zone_volume_m3"))
DEPTH = Quantity("plastic_zone_depth_m", "plastic depth", "mm", 1e-3, _summed_up("plastic_zone_depth_m"))
ARRIVAL = Quantity("base_arrival_s", "arrival at the bottom", "µs", 1e-6, _summed_up("base_arrival_s"))

QUANTITIES = (
    FORCE, REDUCTION, DISSIPATED, PLASTIC, FRICTION, CONTACTS, SPHERES, VOLUME, DEPTH, ARRIVAL,
)  # fmt: skip
#: What an ideal packing is good for: how much of it is left is told of these.
PERFORMANCE = (FORCE, DISSIPATED, PLASTIC)


@dataclasses.dataclass(frozen=True, eq=False)
class Measured:
    """Estimates of all quantities of a packing, SI.

    Attributes
    ----------
    values
        By quantity and setting, in the order of the seeds; without those that do not apply.
    random
        Settings whose values differ from seed to seed.
    """

    packing: Packing
    values: dict[str, dict[Setting, tuple[float, ...]]]
    random: frozenset[Setting]

    def of(self, quantity: Quantity, setting: Setting) -> Estimate | None:
        """The estimate; None where there is no value."""
        found = self.values.get(quantity.name, {}).get(setting)
        if not found:
            return None
        return estimate(found) if setting in self.random else exactly(found[0])

    def seeds(self, setting: Setting) -> int:
        """How many replicates there are."""
        return len(self.packing.runs[setting])

    def shown(
        self, quantities: tuple[Quantity, ...] = QUANTITIES, settings: Sequence[Setting] | None = None
    ) -> list[Quantity]:
        """The quantities that have a value anywhere; without friction all is dissipated by yielding.

        Parameters
        ----------
        settings
            Those that are shown; None: all of the packing.
        """
        there = [quantity for quantity in quantities if self.values.get(quantity.name)]
        has_friction = any(setting.friction for setting in (self.packing.settings if settings is None else settings))
        return [one for one in there if has_friction or one not in (PLASTIC, FRICTION)]

    @property
    def performance(self) -> list[Quantity]:
        """Quantities of `PERFORMANCE` that are known."""
        return self.shown(PERFORMANCE)

    def left(self, quantity: Quantity, setting: Setting) -> Estimate | None:
        """Ratio to the ideal packing's performance: 1 is all of it, more is better than ideal.

        Of a force that shall be small that is the ideal's over the present one. None where either is not known, or the
        ideal one is random or zero.
        """
        ideal, now = self.of(quantity, IDEAL), self.of(quantity, setting)
        if ideal is None or now is None or not ideal.exact or not ideal.mean:
            return None
        share = now.over(ideal.mean)
        if quantity.better != "less":
            return share
        if not share.mean:
            return None
        return Estimate(share.n, 1 / share.mean, share.deviation / share.mean**2, share.half_width / share.mean**2)


def measure(packing: Packing) -> Measured:
    """All quantities of all runs."""
    random = frozenset(setting for setting, runs in packing.runs.items() if is_random(runs[0].case))
    values: dict[str, dict[Setting, tuple[float, ...]]] = {}
    for quantity in QUANTITIES:
        for setting, runs in packing.runs.items():
            found = tuple(value for run in runs if math.isfinite(value := quantity.value(run)))
            if found:
                values.setdefault(quantity.name, {})[setting] = found
    return Measured(packing, values, random)
