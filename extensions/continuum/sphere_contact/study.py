"""The contact law against finite elements of two spheres pressed together.

One base everywhere: finite elements over the law, less 1, at equal overlap.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence

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
    "Two elastic-perfectly-plastic spheres, pressed together by finite elements. Differences are finite elements over "
    "the contact law, less 1, at equal overlap; alpha_y is the overlap at first yield. The contact grows element by "
    "element, so single values have steps."
)
_SPOTS = (3.0, 10.0)  # alpha_y: where the law is farthest off, and where its plateau begins
_SMOOTH = 0.02  # half-width, in the logarithm of the overlap, over which a spot is averaged


@dataclasses.dataclass(frozen=True, eq=False)
class SphereLoading:
    """Loading of two finite-element spheres beside the law.

    Attributes
    ----------
    name
        Materials and radii in a few words.
    place
        Key to sort by: spheres alike first.
    scaled
        Overlap over that at first yield: (n_entries,).
    over_law
        Force of finite elements over that of the law, less 1: (n_entries,).
    softer
        Share of the energy of yielding that the sphere of the smaller yield strength takes; None of
        equal strengths.
    """

    run: SphereContactRun
    name: str
    place: tuple[bool, float, str]
    scaled: Array
    over_law: Array
    softer: float | None

    def near(self, scaled: float) -> float:
        """Mean of `over_law` about an overlap over that at first yield; NaN beyond the largest."""
        chosen = np.abs(np.log(self.scaled / scaled)) < _SMOOTH
        return float(self.over_law[chosen].mean()) if chosen.any() else math.nan


def select(runs: Sequence[SphereContactRun]) -> list[list[SphereLoading]]:
    """All runs whose contacts yield, spheres alike first."""
    found = [_measured(run) for run in runs if math.isfinite(run.value("yield_overlap_m"))]
    found = [one for one in found if one.scaled[-1] > _SPOTS[-1]]
    return [sorted(found, key=lambda one: one.place)] if found else []


def tables(found: Sequence[SphereLoading]) -> Iterator[DocumentTable]:
    """Differences from the law at two overlaps and over two ranges, unloading exponents, share of
    the softer sphere.
    """
    spots = [f"At {spot:g} alpha_y" for spot in _SPOTS]
    spans = [
        f"{word}, {span}" for span in ("1 to 10 alpha_y", "beyond") for word in ("Least", "Most")
    ]
    others = (
        "Smallest unloading exponent",
        "Largest unloading exponent",
        "Energy of yielding in the softer sphere",
    )
    columns = (TableColumn("Spheres", key=True), *numeric(*spots, *spans, *others))
    rows = []
    for one in found:
        deep = one.scaled > _SPOTS[-1]
        spans_of = one.over_law[(one.scaled >= 1) & ~deep], one.over_law[deep]
        ends = [end for span in spans_of for end in (span.min(), span.max())]
        exponents = [one.run.value(f"unloading_exponent_{key}") for key in ("min", "max")]
        over = [
            Cell(percent(100 * value), float(value)) for value in (*map(one.near, _SPOTS), *ends)
        ]
        rows.append(
            (
                Cell(one.name),
                *over,
                *(x if math.isfinite(x) else None for x in exponents),
                one.softer,
            )
        )
    yield table_of("Finite elements over the contact law, less 1", columns, rows)


def pictures(found: Sequence[SphereLoading]) -> Iterator[Picture]:
    """Difference from the law against overlap."""
    figure, axes = panels(2.6)
    data = {}
    for one, mark in zip(found, MARKS * 2, strict=False):
        shown = one.scaled > 0.3  # below it the contact has too few elements
        axes.plot(
            one.scaled[shown],
            100 * one.over_law[shown],
            marker=mark,
            markersize=2,
            markevery=40,
            label=one.name,
        )
        data[f"{one.name}: overlap_normalised"] = one.scaled[shown]
        data[f"{one.name}: finite_elements_over_law"] = one.over_law[shown]
    axes.axhline(0, color="black", linewidth=0.5)
    label(axes, r"Overlap $\alpha/\alpha_\mathrm{y}$", "Finite elements over law (%)", log="x")
    axes.legend(fontsize=6)
    caption = (
        "Force of finite elements over that of the contact law, less 1, against overlap, on loading. At zero they "
        "agree; above it the contact is stiffer than the law, below it softer"
    )
    yield Picture("", caption, Drawing(figure, data))


def _measured(run: SphereContactRun) -> SphereLoading:
    """Read what the study shows of a run."""
    own = run.case["material"]
    partner = run.case.get("partner", {})
    radius = float(run.case["sphere"]["radius"])
    other = partner.get("material", own)
    radii = sorted((radius, float(partner.get("radius", radius))))
    strengths = [one.get("yield_strength", math.inf) for one in (own, other)]
    with h5py.File(regular(run.directory / RESULT_FILE), "r") as file:
        overlap, force, law = (
            np.asarray(file["loading"][name]) for name in ("overlap", "force", "law_force")
        )
        softer = (
            _share_of_softer(file["fields"], strengths) if strengths[0] != strengths[1] else None
        )
    like = other == own
    ratio = radii[1] / radii[0]
    first = own.get("name", "one material")
    materials = first if like else f"{first} and {other.get('name', 'another')}"
    name = materials + (f", radii {ratio:g} to 1" if ratio != 1 else ", like radii" if like else "")
    return SphereLoading(
        run,
        name,
        (not like, ratio, name),
        overlap / run.value("yield_overlap_m"),
        force / law - 1,
        softer,
    )


def _share_of_softer(file: h5py.Group, strengths: Sequence[float]) -> float:
    """Return the share of the energy of yielding in the sphere of the smaller yield strength, Pa;
    infinite: elastic.
    """
    fields = {name: np.asarray(values) for name, values in file.items()}
    r, z = fields["position"][fields["elements"]].transpose(2, 0, 1)
    area = np.abs((r * np.roll(z, -1, 1) - z * np.roll(r, -1, 1)).sum(axis=1)) / 2
    strain = np.bincount(fields["body"], fields["plastic_strain"] * area * r.mean(axis=1))
    work = [e * s if e else 0.0 for e, s in zip(strain, strengths, strict=True)]
    return float(work[int(np.argmin(strengths))] / sum(work))
