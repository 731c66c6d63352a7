"""Two spheres of unlike radii, materials or yield strengths: force against overlap (thesis 2.1.3, 3.1).

Each run is an impact of two spheres with a probe of their contact; the law's curve stands beside what the run recorded.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

from granwave.analysis.figures.chains.probed_pairs import contact_curves, loading_curves
from granwave.analysis.measures.chains.probed_pair import Pair, probed_name
from granwave.analysis.studies.chains.runs import chain_runs, elastic_constants
from granwave.analysis.studies.runs import FinishedRun, rising
from granwave.analysis.studies.study import Picture, Row
from granwave.lammps_inputs.case.material import material

TITLE = "Unlike spheres"
_MILLI, _MEGA, _KILO = 1e-3, 1e6, 1e3
_NEARLY = 0.95  # of the largest overlap
_BAND = (500e6, 600e6)  # Pa: sigma_y of the quasi-static experiment, 550 +- 50 MPa (thesis 2.1.2)
_SHALLOW = 0.4e-3  # m: an overlap of Figs. 2.9 and 3.3
_ALLOYS = {
    "aluminium-2017": "The thesis does not print the alloy's values: E 72.4 GPa, 276 MPa are the handbook's.",
    "aluminium": "Pure aluminium of 150 MPa, the thesis' intruder; its Fig. 3.3 is of the stronger alloy 2017.",
}


@dataclasses.dataclass(frozen=True)
class Pairs:
    """All runs of two spheres.

    Attributes
    ----------
    radii
        Spheres of one material that differ in the ratio of their radii, in its rising order.
    unlike
        Of unlike materials.
    band
        Like spheres that differ in nothing but the yield strength, in its rising order.
    """

    every: list[Pair]
    radii: list[Pair]
    unlike: list[Pair]
    band: list[Pair]


def select(runs: Sequence[FinishedRun]) -> list[Pairs]:
    """Runs of two spheres with a probed contact, of unlike radii, materials or yield strengths."""
    found = [run for run in chain_runs(runs) if run.assembly.n_particles == 2]
    found = [run for run in found if run.case.contact.law == "elastoplastic" and probed_name(run.case)]
    every = sorted((Pair(run) for run in found), key=_label)
    unequal = [pair for pair in every if pair.like and pair.ratio > 1]
    radii = rising((p for p in every if unequal and p.materials == unequal[0].materials), lambda p: p.ratio)
    equal = [pair for pair in every if pair.like and pair.ratio == 1]
    band = rising((p for p in equal if _but_strength(p) == _but_strength(equal[0])), lambda p: p.strength)
    unlike = [pair for pair in every if not pair.like]
    return [Pairs(every, radii, unlike, band)] if len(radii) > 1 or unlike or len(band) > 1 else []


def text(pairs: Pairs) -> str:
    """Describe the runs."""
    return (
        f"{len(pairs.every)} impacts of two spheres, their contact probed: loading, and unloading to separation, "
        "beside the law's curve. The thesis prints curves, no values; its finite elements are the static contact of "
        "two spheres."
    )


def rows(pairs: Pairs) -> Iterator[Row]:
    """Distance from the law, and forces at some overlaps: verifications, for the law is looked up through itself.

    What the law is worth for unlike radii, finite elements tell: `granwave.analysis.studies.sphere_contact`.
    """
    yield Row(f"Largest distance of {len(pairs.every)} recorded curves from the law's, over the largest force", "%",
              None, 100 * max(pair.deviation for pair in pairs.every), "thesis 2.14-2.17",
              "Loading and unloading, from the coupled motion of two spheres.", 0.0, True)  # fmt: skip
    for pair in pairs.unlike:
        overlap = _SHALLOW if pair.deepest >= _SHALLOW else _NEARLY * pair.deepest
        alloys = [_ALLOYS[name] for name in _ALLOYS if name in {one.name for one in pair.materials}]
        yield _at(pair, overlap, f"{overlap / _MILLI:.3g} mm, {_names(pair)}", "thesis Fig. 3.3", *alloys[:1])
    band = [pair for pair in pairs.band if pair.deepest >= _SHALLOW]
    for pair in band if len(band) > 1 else ():
        edge = pair.strength in _BAND and pair.materials[0].youngs_modulus == material("brass").youngs_modulus
        remark = "An edge of the range that the thesis gives for the experiment." if edge else ""
        what = f"{_SHALLOW / _MILLI:g} mm, sigma_y {pair.strength / _MEGA:.0f} MPa"
        yield _at(pair, _SHALLOW, what, "thesis Fig. 2.9", remark)


def pictures(pairs: Pairs) -> Iterator[Picture]:
    """All pairs normalised, unlike radii, unlike materials, and the band of yield strengths."""
    if len(pairs.every) > 1:
        names = {f"{n}": _label(pair) for n, pair in enumerate(pairs.every, start=1)}
        drawing = loading_curves(
            pairs.every, names, "yield_overlap", "overlap_normalised", r"\alpha_\mathrm{y}", log=True
        )
        yield Picture("unlike_normalised", "Force against overlap, normalised by first yield; all pairs", drawing)
    if len(pairs.radii) > 1:
        names = {f"{pair.ratio:g}": f"$R_2/R_1$ = {pair.ratio:g}" for pair in pairs.radii}
        drawing = loading_curves(pairs.radii, names, "effective_radius", "overlap_over_radius", "R^*")
        yield Picture("unlike_radii", "Force against overlap for unlike radii (thesis Fig. 2.10)", drawing)
    if pairs.unlike:
        drawing = contact_curves(pairs.unlike, [_names(pair) for pair in pairs.unlike])
        yield Picture("unlike_materials", "Force against overlap of unlike materials (thesis Fig. 3.3)", drawing)
    if len(pairs.band) > 1:
        drawing = contact_curves(pairs.band, [f"{pair.strength / _MEGA:.0f} MPa" for pair in pairs.band])
        yield Picture("unlike_yield_strengths", "Range of the yield strength (thesis Fig. 2.9)", drawing)


def _at(pair: Pair, overlap: float, what: str, where: str, remark: str = "") -> Row:
    forces = pair.at(overlap) / _KILO, pair.expected(overlap) / _KILO
    return Row(f"Force at {what}", "kN", None, forces[0], where, remark, forces[1], True)


def _but_strength(pair: Pair) -> tuple[float, ...]:
    return *elastic_constants(pair.materials[0]), pair.diameters[0]


def _names(pair: Pair) -> str:
    return " on ".join(one.name or "?" for one in pair.materials)


def _label(pair: Pair) -> str:
    own = pair.materials[0].name or "material" if pair.like else _names(pair)
    ratio = f", ratio {pair.ratio:g}" if pair.ratio != 1 else ""
    return own + ratio + (f", {pair.strength / _MEGA:.0f} MPa" if pair.like else "")
