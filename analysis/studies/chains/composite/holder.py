"""Friction of the holder in composite chains: what it takes from the output pulse.

The source (section 4) sees lambda fall with the section's length, ever more below that of its elastic finite elements,
and blames friction between beads and holder, of which it gives no coefficient.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.figures.chains import holder as holder_figures
from granwave.analysis.measures.chains.composite_section import Composite, composite_of
from granwave.analysis.studies.chains.runs import chain_runs
from granwave.analysis.studies.runs import FinishedRun, rising
from granwave.analysis.studies.study import Picture, Row
from granwave.lammps_inputs.deck.motion import GRAVITY

TITLE = "Friction of the holder in composite chains"
TEXT = (
    "Elastic composite chains whose beads lie in a level holder, press on it with their weight, and slide in it. V and "
    "lambda as in the study of composite chains: only friction takes energy."
)
_PLACE = "composite chain, section 4"


@dataclasses.dataclass(frozen=True)
class Series:
    """Chains of one section's material, by friction of the holder, then by rising length of the section."""

    light: str
    chains: dict[float, list[Composite]]


def select(runs: Sequence[FinishedRun]) -> list[list[Series]]:
    """Elastic composite chains of two coefficients of friction and more, by the section's material."""
    elastic = [run for run in chain_runs(runs) if not (run.case.contact.yields or run.case.has_loss)]
    found = [chain for run in elastic if (chain := composite_of(run)) is not None]
    series = []
    for light in dict.fromkeys(chain.light.name or "section" for chain in found):
        chosen = (chain for chain in found if (chain.light.name or "section") == light)  # of equal ones the last
        alike = list({(chain.n, _friction(chain)): chain for chain in chosen}.values())
        frictions = sorted({_friction(chain) for chain in alike})
        chains = {
            friction: rising((one for one in alike if _friction(one) == friction), lambda one: one.n)
            for friction in frictions
        }
        if len(frictions) > 1:
            series.append(Series(light, chains))
    return [series] if series else []


def rows(found: list[Series]) -> Iterator[Row]:
    """Changes by friction, and the energy that it took against the path of the beads."""
    for series in found:
        least, *others = series.chains
        for friction in others:
            pairs = _of_one_length(series.chains[least], series.chains[friction])
            for smooth, rough in (pairs[:1] + pairs[-1:])[: len(pairs)]:
                change = 100 * (rough.ratio / smooth.ratio - 1)
                what = f"Change of lambda by friction {friction:g} instead of {least:g}, {series.light}, N2 = {rough.n}"
                yield Row(what, "%", None, change, _PLACE, f"lambda: {rough.ratio:.4f}; V: {rough.speed:.1f} m/s, "
                          f"changed by {100 * (rough.speed / smooth.speed - 1):.2f} %.")  # fmt: skip
            rough = series.chains[friction][-1]
            yield Row(f"Energy taken by the holder, friction {friction:g}, {series.light}, N2 = {rough.n}", "J", None,
                      float(rough.run.array("energy/holder")[-1]), "friction times weight times the path of every bead",
                      "", _friction_work(rough), verification=True)  # fmt: skip


def pictures(found: list[Series]) -> Iterator[Picture]:
    """Speed and lambda against the section's length, for each friction."""
    caption = "Speed and height of the output pulse against the section's length, by friction of the holder"
    yield Picture("composite_holder", caption, holder_figures.against_length({one.light: one.chains for one in found}))


def verdict(found: list[Series]) -> Iterator[str]:
    """Tell whether friction of the beads' weight can be what the source blames it for."""
    for series in found:
        least, friction = min(series.chains), max(series.chains)
        pairs = _of_one_length(series.chains[least], series.chains[friction])
        if pairs:
            smooth, rough = pairs[-1]
            yield (
                f"Friction {friction:g} under the weight of the beads lowers the output pulse behind {rough.n} beads "
                f"of {series.light} by {100 * (1 - rough.ratio / smooth.ratio):.2g} %."
            )


def _friction(chain: Composite) -> float:
    """Coefficient of friction of the holder."""
    return chain.run.case.boundary.holder_friction or 0.0


def _of_one_length(first: Sequence[Composite], second: Sequence[Composite]) -> list[tuple[Composite, Composite]]:
    """Pairs of chains with sections of one length."""
    by_length = {chain.n: chain for chain in first}
    return [(by_length[chain.n], chain) for chain in second if chain.n in by_length]


def _friction_work(chain: Composite) -> float:
    """Friction times weight times the path of every bead, by its recorded velocity, J."""
    run = chain.run
    paths = np.trapezoid(np.abs(run.velocity), run.time, axis=0)
    masses = np.array([run.assembly.mass_of(int(one)) for one in run.array("chain/id")])
    return float(_friction(chain) * GRAVITY * (masses * paths).sum())
