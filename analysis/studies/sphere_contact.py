"""The contact law against finite elements of two spheres pressed together.

One base everywhere: finite elements over the law, less 1, at equal overlap.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any

import h5py
import numpy as np

from granwave.analysis.document.cells import percent
from granwave.analysis.document.model import Cell, Column, Table
from granwave.analysis.figures.series import MARKS, label, panels
from granwave.analysis.figures.style import Drawing
from granwave.analysis.measures.signals import Array
from granwave.analysis.studies.runs import SphereContactRun
from granwave.analysis.studies.study import Picture
from granwave.analysis.studies.tables import numeric, table_of
from granwave.lammps_inputs.run_directory import RESULT_FILE

TITLE = "Contact law against finite elements"
TEXT = (
    "Two elastic-perfectly-plastic spheres, pressed together by finite elements. Differences are finite elements over "
    "the contact law, less 1, at equal overlap; alpha_y is the overlap at first yield. The contact grows element by "
    "element, so single values have steps of half a per cent."
)
_SPOTS = (3.0, 10.0)  # alpha_y: where the law is farthest off, and where its plateau begins
_SMOOTH = 0.02  # half-width, in the logarithm of the overlap, over which a spot is averaged


class Contact(SphereContactRun):
    """Loading of two finite-element spheres beside the law."""

    @cached_property
    def _loading(self) -> Mapping[str, Array]:
        with h5py.File(self.directory / RESULT_FILE) as file:
            return {name: np.asarray(values) for name, values in file["loading"].items()}

    @property
    def scaled(self) -> Array:
        """Overlap over that at first yield: (n_entries,)."""
        return self._loading["overlap"] / self.value("yield_overlap_m")

    @property
    def over_law(self) -> Array:
        """Force of finite elements over that of the law, less 1: (n_entries,)."""
        return self._loading["force"] / self._loading["law_force"] - 1

    def near(self, scaled: float) -> float:
        """Mean of `over_law` about an overlap over that at first yield; NaN beyond the largest."""
        chosen = np.abs(np.log(self.scaled / scaled)) < _SMOOTH
        return float(self.over_law[chosen].mean()) if chosen.any() else math.nan

    @property
    def share_of_softer(self) -> float:
        """Share of the energy of yielding that the sphere of the smaller yield strength takes."""
        with h5py.File(self.directory / RESULT_FILE) as file:
            fields = {name: np.asarray(values) for name, values in file["fields"].items()}
        r, z = fields["position"][fields["elements"]].transpose(2, 0, 1)
        area = np.abs((r * np.roll(z, -1, 1) - z * np.roll(r, -1, 1)).sum(axis=1)) / 2
        strain = np.bincount(fields["body"], fields["plastic_strain"] * area * r.mean(axis=1))
        work = [e * s if e else 0.0 for e, s in zip(strain, self.strengths, strict=True)]  # elastic: infinite strength
        return work[int(np.argmin(self.strengths))] / sum(work)

    @property
    def strengths(self) -> tuple[float, float]:
        """Yield strengths of the first and the second sphere, Pa; infinite of an elastic one."""
        own, other = (one.get("yield_strength", math.inf) for one in (self.case["material"], self._other))
        return own, other

    @property
    def ratio(self) -> float:
        """Ratio of the larger radius to the smaller."""
        own, other = (float(self.case[table].get("radius", self.case["sphere"]["radius"])) for table in self._spheres)
        return max(own, other) / min(own, other)

    @property
    def _spheres(self) -> tuple[str, str]:
        return "sphere", "partner" if "partner" in self.case else "sphere"

    @property
    def _other(self) -> Mapping[str, Any]:
        return self.case.get("partner", {}).get("material", self.case["material"])

    @property
    def like(self) -> bool:
        """Both spheres are of one material."""
        return self._other == self.case["material"]

    @property
    def name(self) -> str:
        """Materials and radii in a few words."""
        own = self.case["material"].get("name", "one material")
        materials = own if self.like else f"{own} and {self._other.get('name', 'another')}"
        radii = f", radii {self.ratio:g} to 1" if self.ratio != 1 else ", like radii" if self.like else ""
        return materials + radii


def select(runs: Sequence[SphereContactRun]) -> list[list[Contact]]:
    """All runs whose contacts yield, spheres alike first."""
    found = [run.seen_as(Contact) for run in runs if math.isfinite(run.value("yield_overlap_m"))]
    found = [run for run in found if run.scaled[-1] > _SPOTS[-1]]
    return [sorted(found, key=lambda run: (not run.like, run.ratio, run.name))] if found else []


def tables(found: Sequence[Contact]) -> Iterator[Table]:
    """Differences from the law at two overlaps and over two ranges, unloading exponents, share of the softer sphere."""
    spots = [f"At {spot:g} alpha_y" for spot in _SPOTS]
    spans = [f"{word}, {span}" for span in ("1 to 10 alpha_y", "beyond") for word in ("Least", "Most")]
    others = "Smallest unloading exponent", "Largest unloading exponent", "Energy of yielding in the softer sphere"
    columns = (Column("Spheres", key=True), *numeric(*spots, *spans, *others))
    yield table_of("Finite elements over the contact law, less 1", columns, map(_row, found))


def _row(run: Contact) -> Iterator[Cell | str | float | None]:
    deep = run.scaled > _SPOTS[-1]
    spans = run.over_law[(run.scaled >= 1) & ~deep], run.over_law[deep]
    yield Cell(run.name)
    for over in (*map(run.near, _SPOTS), *(end for span in spans for end in (span.min(), span.max()))):
        yield Cell(percent(100 * over), float(over))
    for key in ("min", "max"):
        exponent = run.value(f"unloading_exponent_{key}")
        yield exponent if math.isfinite(exponent) else None
    yield run.share_of_softer if run.strengths[0] != run.strengths[1] else None


def pictures(found: Sequence[Contact]) -> Iterator[Picture]:
    """Difference from the law against overlap."""
    figure, axes = panels(2.6)
    data = {}
    for run, mark in zip(found, MARKS * 2, strict=False):
        shown = run.scaled > 0.3  # below it the contact has too few elements
        axes.plot(run.scaled[shown], 100 * run.over_law[shown], marker=mark, markersize=2, markevery=40, label=run.name)
        data[f"{run.name}: overlap_normalised"] = run.scaled[shown]
        data[f"{run.name}: finite_elements_over_law"] = run.over_law[shown]
    axes.axhline(0, color="black", linewidth=0.5)
    label(axes, r"Overlap $\alpha/\alpha_\mathrm{y}$", "Finite elements over law (%)", log="x")
    axes.legend(fontsize=6)
    caption = (
        "Force of finite elements over that of the contact law, less 1, against overlap, on loading. At zero they "
        "agree; above it the contact is stiffer than the law, below it softer"
    )
    yield Picture("", caption, Drawing(figure, data))
