"""Influence of a sphere with a sensor, of another mass, on a wave in a chain: the reflected share."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib import colormaps

from granwave.analysis.figures.series import legend_outside, one_panel
from granwave.analysis.figures.style import BLUE, FORCE_MAP, GREY, Drawing
from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.waves.pulses import reflection
from granwave.analysis.studies.chains.runs import ChainRun
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row


@dataclasses.dataclass(frozen=True, eq=False)
class Reflected:
    """Wave that a lighter sphere sends back.

    Attributes
    ----------
    share
        Its largest force, per cent of that of the incident wave.
    mass
        Of the sphere, and of one of the others, kg.
    time, force
        At the contact before the sphere where it is measured, s and N: (n_times,) each.
    """

    share: float
    mass: tuple[float, float]
    time: Array
    force: Array


Reflections = dict[float, Reflected]  # by mass over the others'

TITLE = "A lighter sphere in a chain"
TEXT = (
    "Largest contact force of what comes back, over that of the incident wave, four contacts before the sphere, "
    "until waves from the far end can arrive. The source does not say which amplitude it took, nor where."
)
_BEFORE = 4  # contacts between the lighter sphere and the one at which the reflection is measured
_MASSES = (26.52, 28.79)  # g, of a sphere with a sensor and of a solid one, as weighed
_SENSOR_MASS, _LIMIT = _MASSES[0] / _MASSES[1], 1.2  # over the others'; per cent of the incident wave
_WHERE = "square packing, Experimental Setup"
_CUT = 0.25  # of the incident wave: how much of it is drawn
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
                mass = ratio * run.case.sphere_mass, run.case.sphere_mass
                found.setdefault(round(ratio, 6), Reflected(100 * share, mass, chain.time, chain.force[:, place]))
    return [dict(sorted(found.items()))] if found else []


def rows(found: Reflections) -> Iterator[Row]:
    """The masses, and a row for each of them."""
    for ratio, one in found.items():
        of_source = abs(ratio - _SENSOR_MASS) < _SAME
        if of_source:
            sensor, solid = (1e3 * mass for mass in one.mass)
            remark = "Weighed; the density and the diameter of the source give ours."
            yield Row("Mass of a solid sphere", "g", _MASSES[1], solid, _WHERE, remark)
            yield Row("Mass of a sphere with a sensor", "g", _MASSES[0], sensor, _WHERE, "In the ratio of the weighed.")
            yield Row("Their ratio", "%", 92.0, 100 * ratio, _WHERE)
        source, remark = (_LIMIT, "The source: less than 1.2 %.") if of_source else (None, "")
        quantity = f"Largest reflection of a sphere of {ratio:.3g} of the others' mass"
        yield Row(quantity, "% of the wave", source, one.share, _WHERE, remark, bound=of_source)


def pictures(found: Reflections) -> Iterator[Picture]:
    """Reflection against mass, and the waves, of two masses and more."""
    if len(found) < 2:
        return
    ratios, reflected = np.array(list(found)), np.array([one.share for one in found.values()])
    figure, axes = one_panel(2.3, "Mass of the sphere (% of the others')", "Reflection (% of the wave)")
    axes.plot(100 * ratios, reflected, "o-", color=BLUE, markersize=3, label="ours")
    axes.plot(100 * _SENSOR_MASS, _LIMIT, "v", color=GREY, label="source: less than this")
    axes.set_ylim(0)
    axes.legend()
    drawing = Drawing(figure, {"mass_ratio": ratios, "reflection_percent": reflected})
    yield Picture("", "Reflection of a lighter sphere in a chain", drawing)
    yield Picture("_waves", f"Waves {_BEFORE} contacts before the lighter sphere, by its mass", _waves(found))


def _waves(found: Reflections) -> Drawing:
    """Force in time over the peak of the incident wave, cut so that what comes back shows."""
    figure, axes = one_panel(2.6, "Time (µs)", "Force over the incident wave's (%)")
    columns: dict[str, Array] = {}
    shades = colormaps[FORCE_MAP](np.linspace(0.0, 0.9, len(found)))
    for (ratio, one), colour in zip(found.items(), shades, strict=True):
        scaled = 100 * one.force / one.force.max()
        axes.plot(1e6 * one.time, scaled, color=colour, linewidth=0.9, label=f"{100 * ratio:.3g} %")
        columns |= {"time_s": one.time, f"mass_{100 * ratio:.3g}_percent_force_over_incident": scaled / 100}
    axes.set(ylim=(0, 100 * _CUT), xlim=(0, None))
    legend_outside(figure, 4, fontsize=7)
    return Drawing(figure, columns)


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
