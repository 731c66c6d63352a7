"""The ways in which a packing can be imperfect: their names, units, and how a setting is told in words."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, NamedTuple

from granwave.lammps_inputs.case.case import Case

_DIGITS = 12  # in which settings are the same


class Setting(NamedTuple):
    """Imperfections of a packing.

    Attributes
    ----------
    scatter
        Of the diameters, m.
    friction
        Coefficient of Coulomb friction.
    vacancies
        Share of the spheres that are left out at random.
    """

    scatter: float = 0.0
    friction: float = 0.0
    vacancies: float = 0.0


IDEAL = Setting()


@dataclasses.dataclass(frozen=True)
class Axis:
    """One field of `Setting`.

    Attributes
    ----------
    name
        Of the field.
    words
        In the middle of a sentence.
    unit, scale
        As shown, and its size in SI.
    column
        Of a CSV file, in SI.
    key
        Of a case file.
    """

    name: str
    words: str
    unit: str
    scale: float
    column: str
    key: str

    @property
    def title(self) -> str:
        """For an axis of a figure."""
        return f"{self.words.capitalize()} ({self.unit})" if self.unit else self.words.capitalize()

    def of(self, setting: Setting) -> float:
        """Its value in a setting, in `unit`."""
        return float(f"{getattr(setting, self.name) / self.scale:.{_DIGITS}g}")

    def show(self, value: float) -> str:
        """A value with its unit."""
        return f"{value:.3g} {self.unit}".rstrip()

    def without(self, setting: Setting) -> Setting:
        """The setting with this at zero."""
        return setting._replace(**{self.name: 0.0})


SCATTER = Axis("scatter", "diameter scatter", "µm", 1e-6, "diameter_scatter_m", "packing.diameter_scatter")
RUBBING = Axis("friction", "friction coefficient", "", 1.0, "friction", "contact.friction")
VACANCIES = Axis("vacancies", "vacancies", "%", 0.01, "vacancies", "packing.vacancies")
AXES = (SCATTER, RUBBING, VACANCIES)


def setting_of(case: Case) -> Setting:
    """Imperfections of the packing of a case."""
    packing, left_out = case.packing, case.packing.vacancies
    values = packing.diameter_scatter, case.contact.friction, left_out if isinstance(left_out, float) else 0.0
    return Setting(*(float(f"{value:.{_DIGITS}g}") for value in values))


def is_ideal(labels: Mapping[str, Any], case: Case) -> bool:
    """A point of a scan is an ideal packing, where what does not vary in the scan is that of a case.

    Parameters
    ----------
    labels
        Values of the keys that vary.
    """
    fixed = setting_of(case)
    return not any(labels.get(axis.key, getattr(fixed, axis.name)) for axis in AXES)


def told(setting: Setting) -> str:
    """A setting in words, such as ``diameter scatter 5 µm, friction coefficient 0.1``."""
    parts = [f"{axis.words} {axis.show(axis.of(setting))}" for axis in AXES if axis.of(setting)]
    return ", ".join(parts) or "ideal"
