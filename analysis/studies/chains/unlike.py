"""Two spheres of unlike radii, materials or yield strengths: force against overlap (thesis 2.1.3, 3.1).

Each run is an impact of two spheres with a probe of their contact; the law's curve stands beside what the run recorded.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.figures.style import BLUE, GREEN, ORANGE, PURPLE, SKY, Drawing, new_figure
from granwave.analysis.studies.chains.runs import ChainRun, by
from granwave.analysis.studies.study import Picture, Row, Study
from granwave.lammps_inputs.case.material import Material, material
from granwave.lammps_inputs.contact.law import pair_contact

if TYPE_CHECKING:
    from granwave._contact_laws import ContactLaw

_MILLI, _MEGA, _KILO = 1e-3, 1e6, 1e3
_COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY)
_LEGIBLE = 1e-2  # of the largest overlap: from where on forces are compared
_DEEP = 0.2  # of R*: the end of Fig. 2.10, and of the law's fit
_NEARLY = 0.95  # of that overlap: a run that comes this far is compared there
_BAND = (500e6, 600e6)  # Pa: sigma_y of the quasi-static experiment, 550 +- 50 MPa (thesis 2.1.2)
_OF_BAND = 0.4e-3  # m: an overlap of Fig. 2.9
_MARKS = 25  # points of a run in a figure


@dataclasses.dataclass(frozen=True, eq=False)
class Pair:
    """The contact of two spheres in one run."""

    run: ChainRun

    @property
    def materials(self) -> tuple[Material, Material]:
        """Of both spheres."""
        assembly = self.run.assembly
        return assembly.material_of(1), assembly.material_of(2)

    @property
    def diameters(self) -> tuple[float, float]:
        """Of both spheres, m."""
        assembly = self.run.assembly
        return assembly.diameter_of(1), assembly.diameter_of(2)

    @property
    def ratio(self) -> float:
        """Of the larger radius to the smaller."""
        return max(self.diameters) / min(self.diameters)

    @property
    def like(self) -> bool:
        """Both are of one material."""
        return self.materials[0] == self.materials[1]

    @cached_property
    def law(self) -> ContactLaw:
        """Between the two."""
        return pair_contact(self.run.case, 1, 2)

    @property
    def overlap(self) -> NDArray[np.float64]:
        """At all recorded instants: (n_times,), m."""
        return self._recorded("overlap")

    @property
    def force(self) -> NDArray[np.float64]:
        """At all recorded instants: (n_times,), N."""
        return self._recorded("force")

    @property
    def deepest(self) -> float:
        """Largest overlap, m; between records it is known as a peak."""
        return max(float(self.overlap.max()), float(self.run.array("contacts/peak_overlap").max()))

    @property
    def loading(self) -> slice:
        """Records before the largest overlap."""
        return slice(0, int(self.overlap.argmax()) + 1)

    def at(self, overlap: float) -> float:
        """Recorded force of loading at an overlap, by a straight line between records, N; NaN beyond the largest."""
        x, force = self.overlap[self.loading], self.force[self.loading]
        return float(np.interp(overlap, x, force)) if overlap <= x[-1] else np.nan

    @property
    def deviation(self) -> float:
        """Largest |force - law| while the overlap is above 1 % of the largest, over the largest force."""
        chosen = self.overlap > _LEGIBLE * self.deepest
        overlap, force = self.overlap[chosen], self.force[chosen]
        so_far = np.maximum.accumulate(self.overlap)[chosen]
        turned = np.arange(len(self.overlap))[chosen] > int(self.overlap.argmax())
        largest = np.where(turned, self.deepest, so_far)
        return float(np.abs(self.law.force(overlap, largest) - force).max() / force.max())

    def _recorded(self, what: str) -> NDArray[np.float64]:
        name = next(f"probes/contact_{i}_{j}_{what}" for i, j in ((1, 2), (2, 1)) if _probed(self.run, i, j))
        return self.run.array(name)


def unlike_spheres(runs: Sequence[ChainRun]) -> Iterator[Study]:
    """Runs of two spheres with a probed contact, of unlike radii, materials or yield strengths."""
    pairs = sorted((Pair(run) for run in runs if _is_pair(run)), key=_label)
    radii = _radii(pairs)
    unlike = [pair for pair in pairs if not pair.like]
    band = _band(pairs)
    if len(radii) < 2 and not unlike and len(band) < 2:
        return
    pictures = []
    if len(pairs) > 1:
        pictures.append(
            Picture(
                "unlike_normalised", "Force against overlap, normalised by first yield; all pairs", _normalised(pairs)
            )
        )
    if len(radii) > 1:
        pictures.append(
            Picture("unlike_radii", "Force against overlap for unlike radii (thesis Fig. 2.10)", _of_radii(radii))
        )
    if unlike:
        pictures.append(
            Picture(
                "unlike_materials",
                "Force against overlap of unlike materials (thesis Fig. 3.3)",
                _physical(unlike, _names(unlike)),
            )
        )
    if len(band) > 1:
        names = [f"{_strength(pair) / _MEGA:.0f} MPa" for pair in band]
        pictures.append(
            Picture("unlike_yield_strengths", "Range of the yield strength (thesis Fig. 2.9)", _physical(band, names))
        )
    yield Study(
        "unlike-spheres",
        "Unlike spheres",
        f"{len(pairs)} impacts of two spheres, their contact probed: loading, and unloading to separation, beside the "
        "law's curve. The thesis prints curves, no values; its finite elements are the static contact of two spheres.",
        tuple([*_rows_of_all(pairs), *_rows_of_radii(radii), *_rows_of_materials(unlike), *_rows_of_band(band)]),
        tuple(pictures),
    )


def _is_pair(run: ChainRun) -> bool:
    assembly = run.assembly
    return (
        assembly.n_particles == 2
        and run.case.contact.law == "elastoplastic"
        and (_probed(run, 1, 2) or _probed(run, 2, 1))
    )


def _probed(run: ChainRun, i: int, j: int) -> bool:
    return any(probe.contact == (i, j) for probe in run.case.output.probes)


def _radii(pairs: Sequence[Pair]) -> list[Pair]:
    """Spheres of one material that differ in the ratio of their radii, in its rising order."""
    unequal = [pair for pair in pairs if pair.like and pair.ratio > 1]
    if not unequal:
        return []
    alike = [pair.run for pair in pairs if pair.materials == unequal[0].materials]
    return [Pair(run) for run in by(alike, lambda run: Pair(run).ratio)]


def _band(pairs: Sequence[Pair]) -> list[Pair]:
    """Like spheres that differ in nothing but the yield strength, in its rising order."""
    alike = [pair for pair in pairs if pair.like and pair.ratio == 1]
    if not alike:
        return []
    first = _but_strength(alike[0])
    found = by([pair.run for pair in alike if _but_strength(pair) == first], lambda run: _strength(Pair(run)))
    return [Pair(run) for run in found]


def _but_strength(pair: Pair) -> tuple[float, ...]:
    one = pair.materials[0]
    return one.youngs_modulus, one.poisson_ratio, one.density, pair.diameters[0]


def _strength(pair: Pair) -> float:
    return min(one.yield_strength or np.inf for one in pair.materials)


# ---------------------------------------------------------------------- rows


def _rows_of_all(pairs: Sequence[Pair]) -> Iterator[Row]:
    yield Row(
        f"Largest distance of {len(pairs)} recorded curves from the law's, over the largest force",
        "%",
        None,
        100 * max(pair.deviation for pair in pairs),
        "thesis 2.14-2.17",
        "Loading and unloading, from the coupled motion of two spheres.",
        0.0,
    )


def _rows_of_radii(radii: Sequence[Pair]) -> Iterator[Row]:
    deep = [pair for pair in radii if pair.deepest >= _NEARLY * _DEEP * pair.law.effective_radius]
    if len(radii) < 2 or len(deep) < 2:
        return
    share = _NEARLY * _DEEP
    forces = [pair.at(share * pair.law.effective_radius) / pair.law.yield_force for pair in deep]
    law = deep[0].law
    expected = float(law.loading_force(np.array([share * law.effective_radius]))[0]) / law.yield_force
    yield Row(
        f"Force/F_y at {share:.2f} R*, radii in the ratio {deep[-1].ratio:g}",
        "",
        None,
        forces[-1],
        "thesis Fig. 2.10",
        "The finite-element curves of Fig. 2.10 fall below the law here: the smaller sphere yields as a whole, "
        "which the law does not know.",
        expected,
    )
    yield Row(
        f"Spread of that force over the ratios {', '.join(f'{pair.ratio:g}' for pair in deep)}",
        "%",
        None,
        100 * (max(forces) / min(forces) - 1),
        "thesis 2.1.3",
        "One normalised curve.",
        0.0,
    )


def _rows_of_materials(unlike: Sequence[Pair]) -> Iterator[Row]:
    for pair, name in zip(unlike, _names(unlike), strict=True):
        overlap = 0.4e-3 if pair.deepest >= 0.4e-3 else _NEARLY * pair.deepest
        yield Row(
            f"Force at {overlap / _MILLI:.3g} mm, {name}",
            "kN",
            None,
            pair.at(overlap) / _KILO,
            "thesis Fig. 3.3",
            _of_alloys(pair),
            float(pair.law.loading_force(np.array([overlap]))[0]) / _KILO,
        )


def _of_alloys(pair: Pair) -> str:
    names = {one.name for one in pair.materials}
    if "aluminium-2017" in names:
        return "The thesis does not print the alloy's values: E 72.4 GPa, 276 MPa are the handbook's."
    if "aluminium" in names:
        return "Pure aluminium of 150 MPa, the thesis' intruder; its Fig. 3.3 is of the stronger alloy 2017."
    return ""


def _rows_of_band(band: Sequence[Pair]) -> Iterator[Row]:
    chosen = [pair for pair in band if pair.deepest >= _OF_BAND]
    if len(chosen) < 2:
        return
    for pair in chosen:
        at_edge = _strength(pair) in _BAND
        yield Row(
            f"Force at {_OF_BAND / _MILLI:g} mm, sigma_y {_strength(pair) / _MEGA:.0f} MPa",
            "kN",
            None,
            pair.at(_OF_BAND) / _KILO,
            "thesis Fig. 2.9",
            "An edge of the range that the thesis gives for the experiment." if at_edge and _thesis_brass(pair) else "",
            float(pair.law.loading_force(np.array([_OF_BAND]))[0]) / _KILO,
        )


def _thesis_brass(pair: Pair) -> bool:
    return pair.materials[0].youngs_modulus == material("brass").youngs_modulus


# ---------------------------------------------------------------------- figures


def _names(pairs: Sequence[Pair]) -> list[str]:
    return [" on ".join(one.name or "?" for one in pair.materials) for pair in pairs]


def _label(pair: Pair) -> str:
    name = pair.materials[0].name or "material" if pair.like else _names([pair])[0]
    ratio = f", ratio {pair.ratio:g}" if pair.ratio != 1 else ""
    strength = f", {_strength(pair) / _MEGA:.0f} MPa" if pair.like else ""
    return name + ratio + strength


def _normalised(pairs: Sequence[Pair]) -> Drawing:
    figure = new_figure(3.0, 5.2)
    axes = figure.subplots()
    columns: dict[str, NDArray[np.float64]] = {}
    deepest = 1.0
    for n, pair in enumerate(pairs):
        overlap = pair.overlap[pair.loading] / pair.law.yield_overlap
        force = pair.force[pair.loading] / pair.law.yield_force
        shown = _spread(overlap, np.geomspace(0.3, overlap[-1], _MARKS))
        marker = "osD^v<>ph*Xd"[n % 12]
        axes.plot(
            overlap[shown],
            force[shown],
            marker,
            color=_COLOURS[n % 5],
            markersize=3.5,
            markerfacecolor="none",
            markeredgewidth=0.7,
            label=_label(pair),
        )
        columns |= {f"overlap_normalised_{n + 1}": overlap, f"force_normalised_{n + 1}": force}
        deepest = max(deepest, float(overlap[-1]))
    law = pairs[0].law
    grid = np.geomspace(0.3, deepest, 400)
    curve = law.loading_force(grid * law.yield_overlap) / law.yield_force
    axes.plot(grid, curve, color="black", linewidth=0.8, label="law (thesis 2.14)")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel(r"Overlap $\alpha/\alpha_\mathrm{y}$")
    axes.set_ylabel(r"Force $F/F_\mathrm{y}$")
    figure.legend(loc="outside right center", fontsize=6.5)
    return Drawing(figure, columns | {"law_overlap_normalised": grid, "law_force_normalised": curve})


def _of_radii(radii: Sequence[Pair]) -> Drawing:
    figure = new_figure(2.7)
    axes = figure.subplots()
    columns: dict[str, NDArray[np.float64]] = {}
    law, deepest = radii[0].law, 0.0
    for n, pair in enumerate(radii):
        overlap = pair.overlap[pair.loading] / pair.law.effective_radius
        force = pair.force[pair.loading] / pair.law.yield_force
        shown = _spread(overlap, np.linspace(0, overlap[-1], 9) + 0.004 * n)
        axes.plot(
            overlap[shown],
            force[shown],
            "os^Dv"[n % 5],
            color=_COLOURS[n % 5],
            markersize=4,
            label=rf"$R_2/R_1$ = {pair.ratio:g}",
        )
        columns |= {f"overlap_over_radius_{pair.ratio:g}": overlap, f"force_normalised_{pair.ratio:g}": force}
        deepest = max(deepest, float(overlap[-1]))
    grid = np.linspace(0, deepest, 300)
    curve = law.loading_force(grid * law.effective_radius) / law.yield_force
    axes.plot(grid, curve, color="black", linewidth=0.8, zorder=0, label="law")
    axes.set_xlim(0, 1.03 * deepest)
    axes.set_ylim(bottom=0)
    axes.set_xlabel(r"Overlap $\alpha/R^*$")
    axes.set_ylabel(r"Force $F/F_\mathrm{y}$")
    axes.legend()
    return Drawing(figure, columns | {"law_overlap_over_radius": grid, "law_force_normalised": curve})


def _physical(pairs: Sequence[Pair], names: Sequence[str]) -> Drawing:
    """Loading and unloading in kN and mm: the law's curve as a line, the run's records as marks."""
    figure = new_figure(2.7)
    axes = figure.subplots()
    columns: dict[str, NDArray[np.float64]] = {}
    for n, (pair, name) in enumerate(zip(pairs, names, strict=True)):
        together = pair.force > 0
        overlap, force = pair.overlap[together], pair.force[together]
        peak, slug = pair.deepest, name.replace(" ", "_")
        colour = _COLOURS[n % 5]
        up = np.linspace(0, peak, 200)
        down = np.linspace(peak, float(pair.law.residual_overlap(np.array([peak]))[0]), 100)
        law = np.concatenate([pair.law.loading_force(up), pair.law.force(down, np.full_like(down, peak))])
        axes.plot(np.concatenate([up, down]) / _MILLI, law / _KILO, color=colour, linewidth=0.9, label=name)
        shown = _spread(np.arange(len(overlap)), np.linspace(0, len(overlap) - 1, _MARKS))
        axes.plot(
            overlap[shown] / _MILLI,
            force[shown] / _KILO,
            "o",
            color=colour,
            markersize=2.5,
            markerfacecolor="white",
            markeredgewidth=0.7,
        )
        columns |= {f"{slug}_overlap_m": overlap, f"{slug}_force_N": force}
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)
    axes.set_xlabel("Overlap (mm)")
    axes.set_ylabel("Force (kN)")
    axes.legend(fontsize=7, title="lines: law; marks: run", title_fontsize=7)
    return Drawing(figure, columns)


def _spread(x: NDArray, wanted: NDArray) -> NDArray[np.int64]:
    """Places of rising values next to those wanted, each once."""
    return np.unique(np.clip(np.searchsorted(x, wanted), 0, len(x) - 1))
