"""Influence of a sphere with a sensor, of another mass, on a wave in a chain: the reflected share."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.figures.series import one_panel
from granwave.analysis.figures.style import BLUE, GREY, Drawing
from granwave.analysis.measures.pulses import reflection
from granwave.analysis.studies.chains.runs import ChainRun
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row

Reflections = dict[float, float]  # per cent of the wave, by mass over the others'

TITLE = "A lighter sphere in a chain"
TEXT = (
    "Largest contact force of what comes back, over that of the incident wave, four contacts before the sphere, "
    "until waves from the far end can arrive. The source does not say which amplitude it took, nor where."
)
_BEFORE = 4  # contacts between the lighter sphere and the one at which the reflection is measured
_SENSOR_MASS, _LIMIT = 26.52 / 28.79, 1.2  # over the others'; per cent of the incident wave
_SAME = 0.005


def select(runs: Sequence[FinishedRun]) -> list[Reflections]:
    """Chains that a striker hits, with one sphere of another mass and the same diameter: reflection by rising mass."""
    found: Reflections = {}
    for run in runs:
        ratio, chain = _mass_ratio(run), run.seen_as(ChainRun)
        if ratio is not None:
            place = next(iter(run.assembly.materials)) - _BEFORE  # the contact of the striker is number 0
            share = reflection(chain.time, chain.force, place, _BEFORE + 2)
            if np.isfinite(share):
                found.setdefault(round(ratio, 6), 100 * share)
    return [dict(sorted(found.items()))] if found else []


def rows(found: Reflections) -> Iterator[Row]:
    """A row for each mass."""
    for ratio, ours in found.items():
        of_source = abs(ratio - _SENSOR_MASS) < _SAME
        source, remark = (_LIMIT, "The source says less than this.") if of_source else (None, "")
        quantity = f"Largest reflection of a sphere of {ratio:.3g} of the others' mass"
        yield Row(quantity, "% of the wave", source, ours, "square packing, Experimental Setup", remark)


def pictures(found: Reflections) -> Iterator[Picture]:
    """Reflection against mass, of two masses and more."""
    if len(found) < 2:
        return
    ratios, reflected = (np.array(list(part)) for part in (found.keys(), found.values()))
    figure, axes = one_panel(2.3, "Mass of the sphere (% of the others')", "Reflection (% of the wave)")
    axes.plot(100 * ratios, reflected, "o-", color=BLUE, markersize=3, label="ours")
    axes.plot(100 * _SENSOR_MASS, _LIMIT, "v", color=GREY, label="source: less than this")
    axes.set_ylim(0)
    axes.legend()
    drawing = Drawing(figure, {"mass_ratio": ratios, "reflection_percent": reflected})
    yield Picture("", "Reflection of a lighter sphere in a chain", drawing)


def _mass_ratio(run: FinishedRun) -> float | None:
    """Mass of the only other sphere over that of the rest; None of other chains."""
    case, assembly = run.case, run.assembly
    if case.packing.kind != "chain" or len(assembly.materials) != 1 or assembly.diameters:
        return None
    if len(case.striker) != 1 or case.striker[0].touches != (1,) or case.load.kind != "striker" or case.contact.yields:
        return None
    theirs, ours = next(iter(assembly.materials.values())), case.material
    if (theirs.youngs_modulus, theirs.poisson_ratio) != (ours.youngs_modulus, ours.poisson_ratio):
        return None
    return theirs.density / ours.density if run.seen_as(ChainRun).recorded else None
