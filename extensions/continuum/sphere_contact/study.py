"""The contact law against finite elements of two spheres pressed together.

The common quantity is the ratio of finite elements to the law at equal overlap, minus 1.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from typing import Any

import h5py
import numpy as np

from granwave.analysis.document.model import Cell, DocumentTable, TableColumn, percent
from granwave.analysis.figures.series import MARKS, label, panels
from granwave.analysis.figures.style import Drawing
from granwave.analysis.measures.signals import Array
from granwave.analysis.studies.study import Picture, numeric, table_of
from granwave.extensions.continuum.runs import SphereContactRun
from granwave.lammps_inputs.files import regular
from granwave.lammps_inputs.run_directory import RESULT_FILE

TITLE = "Contact law against finite elements"
RUN_TYPE = SphereContactRun
TEXT = (
    "Two elastic-perfectly-plastic spheres are pressed together by finite elements. Differences "
    "are the force of the finite elements divided by the force of the contact law, minus 1, at "
    "equal overlap. alpha_y is the overlap at first yield. The contact grows element by element, "
    "so that single values have steps."
)
_SPOTS = (3.0, 10.0)  # alpha_y: where the law deviates most, and where its plateau begins
NEEDS = f"contacts of two finite-element spheres, pressed beyond {_SPOTS[-1]:g} alpha_y"
_SMOOTH = 0.02  # half-width of an average, in the logarithm of the overlap


@dataclasses.dataclass(frozen=True, eq=False)
class SphereLoading:
    """Loading of two finite-element spheres compared with the law.

    Attributes
    ----------
    name
        Materials and radii in a few words.
    place
        Key to sort by: equal spheres first.
    scaled
        Overlap / overlap at first yield: (n_entries,).
    over_law
        Force of finite elements divided by the force of the law, minus 1: (n_entries,).
    softer
        Fraction of the plastic dissipation in the sphere with the smaller yield strength; None for
        equal strengths.
    """

    run: SphereContactRun
    name: str
    place: tuple[bool, float, str]
    scaled: Array
    over_law: Array
    softer: float | None

    def near(self, scaled: float) -> float:
        """Mean of `over_law` near an overlap relative to first yield; NaN beyond the largest
        overlap.
        """
        chosen = np.abs(np.log(self.scaled / scaled)) < _SMOOTH
        return float(self.over_law[chosen].mean()) if chosen.any() else math.nan


def select(runs: Sequence[SphereContactRun]) -> list[list[SphereLoading]]:
    """All runs whose contacts yield; runs with identical spheres are first."""
    loadings = [_measured(run) for run in runs if math.isfinite(run.value("yield_overlap_m"))]
    loadings = [loading for loading in loadings if loading.scaled[-1] > _SPOTS[-1]]
    return [sorted(loadings, key=lambda loading: loading.place)] if loadings else []


def tables(loadings: Sequence[SphereLoading]) -> Iterator[DocumentTable]:
    """Differences from the law at two overlaps and over two ranges, unloading exponents, and the
    fraction of plastic dissipation in the softer sphere.
    """
    headings = (
        *(f"At {spot:g} alpha_y" for spot in _SPOTS),
        "Smallest, 1 to 10 alpha_y",
        "Largest, 1 to 10 alpha_y",
        "Smallest, beyond",
        "Largest, beyond",
        "Smallest unloading exponent",
        "Largest unloading exponent",
        "Plastic dissipation in the softer sphere",
    )
    columns = (TableColumn("Spheres", key=True), *numeric(*headings))
    yield table_of("Finite elements divided by contact law, minus 1", columns, map(_row, loadings))


def _row(loading: SphereLoading) -> tuple[Any, ...]:
    """Row of the table of differences."""
    deep = loading.scaled > _SPOTS[-1]
    shallow_errors = loading.over_law[(loading.scaled >= 1) & ~deep]
    deep_errors = loading.over_law[deep]
    differences = [
        *map(loading.near, _SPOTS),
        shallow_errors.min(),
        shallow_errors.max(),
        deep_errors.min(),
        deep_errors.max(),
    ]
    exponents = [loading.run.value(f"unloading_exponent_{key}") for key in ("min", "max")]
    return (
        Cell(loading.name),
        *(Cell(percent(100 * value), float(value)) for value in differences),
        *(exponent if math.isfinite(exponent) else None for exponent in exponents),
        loading.softer,
    )


def pictures(loadings: Sequence[SphereLoading]) -> Iterator[Picture]:
    """Difference from the law against overlap."""
    figure, axes = panels(2.6)
    data = {}
    for loading, mark in zip(loadings, MARKS * 2, strict=False):
        shown = loading.scaled > 0.3  # below it the contact has too few elements
        axes.plot(
            loading.scaled[shown],
            100 * loading.over_law[shown],
            marker=mark,
            markersize=2,
            markevery=40,
            label=loading.name,
        )
        data[f"{loading.name}: overlap_normalised"] = loading.scaled[shown]
        data[f"{loading.name}: finite_elements_over_law"] = loading.over_law[shown]
    axes.axhline(0, color="black", linewidth=0.5)
    label(axes, r"Overlap $\alpha/\alpha_\mathrm{y}$", "Finite elements / law (%)", log="x")
    axes.legend(fontsize=6)
    caption = (
        "Force of finite elements divided by the force of the contact law, minus 1, against "
        "overlap, on loading. Zero means agreement; above zero the contact is stiffer than the "
        "law, below zero it is softer"
    )
    yield Picture("", caption, Drawing(figure, data))


def _measured(run: SphereContactRun) -> SphereLoading:
    """Read the curves and values of a run that the study shows."""
    own = run.case["material"]
    partner = run.case.get("partner", {})
    radius = float(run.case["sphere"]["radius"])
    other = partner.get("material", own)
    radii = sorted((radius, float(partner.get("radius", radius))))
    strengths = [material.get("yield_strength", math.inf) for material in (own, other)]
    with h5py.File(regular(run.directory / RESULT_FILE), "r") as file:
        loading = file["loading"]
        overlap = np.asarray(loading["overlap"])
        force = np.asarray(loading["force"])
        law = np.asarray(loading["law_force"])
        softer = None
        if strengths[0] != strengths[1]:
            softer = _share_of_softer(file["fields"], strengths)
    identical = other == own
    ratio = radii[1] / radii[0]
    name = own.get("name", "one material")
    if not identical:
        name += f" and {other.get('name', 'another')}"
    if ratio != 1:
        name += f", radii {ratio:g} to 1"
    elif identical:
        name += ", equal radii"
    return SphereLoading(
        run,
        name,
        (not identical, ratio, name),
        overlap / run.value("yield_overlap_m"),
        force / law - 1,
        softer,
    )


def _share_of_softer(file: h5py.Group, strengths: Sequence[float]) -> float:
    """Return the fraction of plastic dissipation in the sphere with the smaller yield strength, Pa;
    an infinite yield strength is elastic.
    """
    fields = {name: np.asarray(values) for name, values in file.items()}
    r, z = fields["position"][fields["elements"]].transpose(2, 0, 1)
    area = np.abs((r * np.roll(z, -1, 1) - z * np.roll(r, -1, 1)).sum(axis=1)) / 2
    strain = np.bincount(fields["body"], fields["plastic_strain"] * area * r.mean(axis=1))
    work = [e * s if e else 0.0 for e, s in zip(strain, strengths, strict=True)]
    return float(work[int(np.argmin(strengths))] / sum(work))
