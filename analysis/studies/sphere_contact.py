"""The contact law against finite elements of two spheres pressed together (thesis 2.1).

One base everywhere: finite elements over the law, less 1, at equal overlap.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any

import h5py
import numpy as np

from granwave.analysis.figures.series import MARKS, label, panels
from granwave.analysis.figures.style import Drawing
from granwave.analysis.measures.signals import Array
from granwave.analysis.studies.runs import SphereContactRun
from granwave.analysis.studies.study import Picture, Row
from granwave.lammps_inputs.run_directory import RESULT_FILE

TITLE = "Contact law against finite elements"
TEXT = (
    "Two elastic-perfectly-plastic spheres, pressed together by finite elements. Differences are finite elements over "
    "the contact law, less 1, at equal overlap; alpha_y is the overlap at first yield. The contact grows element by "
    "element, so single values have steps of half a per cent."
)
_SPOTS = (3.0, 10.0)  # alpha_y: where the law is farthest off, and where its plateau begins
_DEEP = 0.19  # R*: nearly the end of Fig. 2.10, and of the law's fit
_CLAIMED = 6.0  # per cent: thesis 2.1.2
_FIRST_YIELD = 16 / 15  # mean pressure over the yield strength: Thornton's law keeps it
_PLATEAU = 2.48  # of the law's mean pressure over the yield strength
_EXPONENTS = (1.30, 1.42)  # of unloading: thesis 2.1
_SMOOTH = 0.02  # half-width, in the logarithm of the overlap, over which a spot is averaged
_REMARKS = (
    "The source: about 6 % at most. Its Fig. 2.8, to 800 alpha_y, cannot show this range.",
    "The source: about 6 % at most, the law too strong at large overlaps.",
)


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

    @property
    def depth(self) -> Array:
        """Overlap over R*: (n_entries,)."""
        return self._loading["overlap"] / self.value("effective_radius_m")

    @property
    def largest_pressure(self) -> float:
        """Largest pressure before any unloading over the smaller yield strength, median over the contact."""
        with h5py.File(self.directory / RESULT_FILE) as file:
            pressures = [np.asarray(one["pressure"]) for one in file["pressure"].values()]
        return max(float(np.median(one[one > 0])) for one in pressures) / min(self.strengths)

    @property
    def area(self) -> Array:
        """Area of the contact over Thornton's, pi R* times the overlap: (n_entries,)."""
        return self._loading["contact_radius"] ** 2 / (self._loading["overlap"] * self.value("effective_radius_m"))

    @property
    def force(self) -> Array:
        """Force over Thornton's area times the mean pressure at first yield: (n_entries,)."""
        pressure = _FIRST_YIELD * min(self.strengths)
        area = math.pi * self.value("effective_radius_m") * self._loading["overlap"]
        return self._loading["force"] / (pressure * area)

    def near(self, place: float, along: Array, values: Array | None = None) -> float:
        """Mean of values, `over_law` if none are given, about a place along one of the scales; NaN beyond its end."""
        chosen = np.abs(np.log(along / place)) < _SMOOTH
        return float((self.over_law if values is None else values)[chosen].mean()) if chosen.any() else math.nan

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


def rows(found: Sequence[Contact]) -> Iterator[Row]:
    """Differences from the law by range of overlap, for unlike radii also from like ones, and unloading exponents."""
    for run in found:
        yield from _rows_of_loading(run)
    alike = next((run for run in found if run.like and run.ratio == 1), None)
    for run in found:
        if alike and run.like and run.ratio > 1 and min(run.depth[-1], alike.depth[-1]) > _DEEP:
            ours = (1 + run.near(_DEEP, run.depth)) / (1 + alike.near(_DEEP, alike.depth)) - 1
            what = f"Finite elements at {_DEEP:g} R*, {run.name}, over those of like radii"
            remark = "The caption of the figure says that there the curves begin to deviate."
            yield Row(what, "%", None, 100 * ours, "thesis Fig. 2.10", remark, 0.0, digits=2)
    if alike:
        yield from _rows_of_pressure(alike)
    for run in found:
        if run.strengths[0] != run.strengths[1]:
            yield Row(f"Share of the energy of yielding in the softer sphere, {run.name}", "", None,
                      run.share_of_softer, "thesis 3.1, Fig. 3.1", "The source: almost all.", digits=3)  # fmt: skip
    for run in found:
        for word, key, source in zip(("Smallest", "Largest"), ("min", "max"), _EXPONENTS, strict=True):
            if math.isfinite(ours := run.value(f"unloading_exponent_{key}")):
                yield Row(f"{word} unloading exponent, {run.name}", "", source, ours, "thesis 2.1", digits=3)


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
    yield Picture("", "Force of finite elements over that of the contact law, on loading", Drawing(figure, data))


def _rows_of_pressure(run: Contact) -> Iterator[Row]:
    """Pressure, contact area and force over those of Thornton's law (thesis 2.1.2, on loading)."""
    largest, area, force = run.largest_pressure, *(run.near(_DEEP, run.depth, one) for one in (run.area, run.force))
    law = force / (1 + run.near(_DEEP, run.depth))
    pressure, deep = _PLATEAU / _FIRST_YIELD, f"at {_DEEP:g} R*, {run.name}"
    of_force = "2.31 times 2.1 is 4.85; 4.7 is what a measurement was fitted with. Theory: the contact law."
    for what, source, ours, theory, remark in (
        (
            "Largest pressure over the yield strength",
            2.5,
            largest,
            _PLATEAU,
            "Median over the contact. Theory: the law.",
        ),
        ("Largest pressure over Thornton's", 2.31, largest / _FIRST_YIELD, pressure, "Theory: the contact law."),
        (f"Contact area over Thornton's {deep}", 2.1, area, law / pressure, "Theory: the contact law."),
        (f"Force over that of Thornton's pressure and area {deep}", 4.7, force, law, of_force),
    ):
        yield Row(what, "", source, ours, "thesis 2.1.2", remark, theory, digits=3)


def _rows_of_loading(run: Contact) -> Iterator[Row]:
    where, end = "thesis 2.1.2", f"{run.depth[-1]:.2g} R*"
    for spot in _SPOTS:
        what = f"Finite elements over the law at {spot:g} alpha_y, {run.name}"
        yield Row(what, "%", None, 100 * run.near(spot, run.scaled), "thesis Fig. 2.8", theory=0.0, digits=2)
    near, far = (run.scaled >= 1) & (run.scaled <= _SPOTS[-1]), run.scaled > _SPOTS[-1]
    for chosen, span, remark in zip((near, far), ("1 to 10 alpha_y", f"10 alpha_y to {end}"), _REMARKS, strict=True):
        over = 100 * run.over_law[chosen]
        for word, ours in (("least", over.min()), ("most", over.max())):
            limit = math.copysign(_CLAIMED, ours)
            source = limit if abs(ours) == np.abs(over).max() and run.like else None
            what = f"Finite elements over the law from {span}: {word}, {run.name}"
            yield Row(what, "%", source, float(ours), where, remark if source else "", 0.0, digits=2)
