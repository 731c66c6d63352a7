"""The ways in which a packing can be imperfect: their names, units, and how a setting is told in words."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from granwave.analysis.studies.tolerance.runs import IDEAL, Packing, Setting


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
    """

    name: str
    words: str
    unit: str
    scale: float
    column: str

    def of(self, setting: Setting) -> float:
        """Its value in a setting, in `unit`."""
        return float(f"{getattr(setting, self.name) / self.scale:.12g}")

    @property
    def title(self) -> str:
        """For an axis of a figure or the head of a column."""
        words = self.words[:1].upper() + self.words[1:]
        return f"{words} ({self.unit})" if self.unit else words

    def show(self, value: float) -> str:
        """A value with its unit."""
        return f"{value:.3g} {self.unit}".rstrip()

    def along(self, packing: Packing, base: Setting = IDEAL) -> list[Setting]:
        """Settings that differ from ``base`` in this alone, in rising order."""
        here = base._replace(**{self.name: 0.0})
        return [setting for setting in packing.settings if setting._replace(**{self.name: 0.0}) == here]

    def bases(self, packing: Packing) -> list[Setting]:
        """Settings of the others along which there is more than one value of this."""
        found = dict.fromkeys(setting._replace(**{self.name: 0.0}) for setting in packing.settings)
        return sorted(base for base in found if len(self.along(packing, base)) > 1)

    def tried(self, packing: Packing) -> list[Setting]:
        """All settings along which there is more than one value of this."""
        return [setting for base in self.bases(packing) for setting in self.along(packing, base)]


SCATTER = Axis("scatter", "diameter scatter", "µm", 1e-6, "diameter_scatter_m")
RUBBING = Axis("friction", "friction coefficient", "", 1.0, "friction")
VACANCIES = Axis("vacancies", "vacancies", "%", 0.01, "vacancies")
AXES = (SCATTER, RUBBING, VACANCIES)


def axes_of(packing: Packing) -> list[Axis]:
    """Axes in which its settings differ, or are imperfect."""
    return [axis for axis in AXES if any(packing.values(axis.name))]


def told(setting: Setting, axes: Sequence[Axis] = AXES) -> str:
    """A setting in words, such as ``diameter scatter 5 µm, friction coefficient 0.1``."""
    parts = [f"{axis.words} {axis.show(axis.of(setting))}" for axis in axes if axis.of(setting)]
    return ", ".join(parts) or "ideal"
