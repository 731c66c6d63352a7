"""Influence of yielding on the waves in a square packing: a scan of the striker's velocity with both laws."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.figures.packings.regions import energies_by_velocity
from granwave.analysis.measures.impact.regions import groups
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.square.runs import WAYS, PackingRun, squares
from granwave.analysis.studies.study import Picture, Row

Series = Sequence[PackingRun]

_PLACES = (2, 6)  # spheres of the chain, from the struck one as 1


def select(runs: Sequence[FinishedRun]) -> list[list[PackingRun]]:
    """The yielding runs of each way of impact."""
    return [series for way in WAYS if (series := squares(runs, way, "elastoplastic"))]


def name(series: Series) -> str:
    """``square-yielding-in-plane``."""
    return f"square-yielding-{series[0].way}"


def title(series: Series) -> str:
    """By way of impact."""
    return f"Square packing with yielding, {series[0].way} impact"


def text(series: Series) -> str:
    """The law and the yield strength."""
    material = series[0].case.material
    size = f"a yield strength of {(material.yield_strength or 0) / 1e6:g} MPa"
    source = f" ({material.name}: {material.source})" if material.name and material.source else ""
    return (
        f"The same impacts with the elasto-plastic law and {size}{source}, which the source did not do. "
        "Harder spheres lose less. In the chains: the most they ever held."
    )


def rows(series: Series) -> Iterator[Row]:
    """Losses, and what is left for the chains, at each velocity."""
    first, second = _PLACES
    for run in series:
        where = f"at {run.speed:g} m/s, {run.way}"
        lost, kept = (100 * run.settled[name] for name in ("dissipated", "central chains"))
        yield Row(f"Dissipated {where}", "% of input", None, lost, "ours alone")
        yield Row(f"Most in central chains {where}", "% of input", None, kept, "ours alone")
        largest = groups(run.snapshots)["central chains"][0].speeds(run.snapshots).max(axis=0)
        if len(largest) >= second:
            quantity = f"Peak velocity at sphere {second} over that at sphere {first}, {run.speed:g} m/s, {run.way}"
            yield Row(quantity, "", None, float(largest[second - 1] / largest[first - 1]), "ours alone")


def pictures(series: Series) -> Iterator[Picture]:
    """Energies by region against velocity."""
    speed = np.array([run.speed for run in series])
    shown = ("dissipated", *groups(series[0].snapshots), "struck spheres", "strikers")
    shares = {region: np.array([run.settled[region] for run in series]) for region in shown}
    yield Picture("", f"Where the energy goes, {series[0].way} impact", energies_by_velocity(speed, shares))
