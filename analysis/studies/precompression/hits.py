"""A packing hit several times: each run starts from the dents that the one before left (its result.h5).

The runs tell by themselves: ``contact.initial_overlap`` of a second hit is the path of the first one's result.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from granwave.analysis.document.model import Table
from granwave.analysis.figures.style import BLUE, GREEN, Drawing, new_figure
from granwave.analysis.studies.precompression.runs import (
    ARRIVAL,
    DISSIPATED,
    GREW,
    IMPACT,
    PEAK_FORCE,
    TRANSMITTED,
    DentedRun,
    past_runs,
    released_energy_note,
)  # fmt: skip
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture
from granwave.analysis.studies.tables import Quantity, columns_of, values_table
from granwave.analysis.studies.titles import packing_title

Series = list[DentedRun]


def select(runs: Sequence[FinishedRun]) -> list[Series]:
    """Runs by hit; where several start from the same one, each series is one of its own."""
    chosen = past_runs(runs)
    at = {run.directory.resolve(): run for run in chosen}
    before = {run: at.get(where) for run in chosen if (where := _left_by(run)) is not None}
    found = []
    for run in chosen:
        if before.get(run) is None or run in before.values():
            continue  # a first hit, or one that others go on from
        series = [run]
        while (earlier := before.get(series[0])) is not None and earlier not in series:
            series.insert(0, earlier)
        found.append(series)
    return found


def title(series: Series) -> str:
    """By number of hits and packing."""
    return f"Hit {len(series)} times: {packing_title(series[0].case)}"


def text(series: Series) -> str:
    """Where each run starts."""
    return (
        "Each run starts with the spheres in their first places and with the dents that the run before left."
        + released_energy_note(series)
    )


def tables(series: Series) -> list[Table]:
    """Hit by hit."""
    return [values_table("Hit by hit", series, _quantities(series))]


def verdict(series: Series) -> list[str]:
    """The first hit beside the last."""
    first, last = series[0], series[-1]
    return [
        f"Hit {len(series)} times, the packing dissipates {100 * last.dissipated:.3g} % of the last impact "
        f"({100 * first.dissipated:.3g} % of the first) and hands on {last.transmitted:.4g} N "
        f"({first.transmitted:.4g} N)." + released_energy_note((first, last))
    ]


def pictures(series: Series) -> Iterator[Picture]:
    """Dissipation and transmitted force."""
    figure = new_figure(2.3, 5.6)
    hit = list(range(1, len(series) + 1))
    shown = ((DISSIPATED, GREEN, "Dissipated (% of input)"), (TRANSMITTED, BLUE, "Force at the bottom (N)"))
    for axes, (quantity, colour, label) in zip(figure.subplots(1, 2), shown, strict=True):
        values = quantity.per_unit * np.array([quantity.value(run) for run in series])
        axes.bar(hit, values, color=colour, width=0.6)
        axes.set(xlabel="Hit", ylabel=label, xticks=hit)
    drawing = Drawing(figure, columns_of(series, _quantities(series)))
    yield Picture("", "Dissipation and transmitted force by number of the hit", drawing)


def _quantities(series: Series) -> tuple[Quantity, ...]:
    hit = Quantity("hit", "Hit", "", lambda run: series.index(run) + 1)
    return hit, IMPACT, DISSIPATED, GREW, PEAK_FORCE, TRANSMITTED, ARRIVAL


def _left_by(run: DentedRun) -> Path | None:
    """Directory of the run whose dents a run starts from."""
    given = run.case.contact.initial_overlap
    if not isinstance(given, str):
        return None
    path = Path(given).resolve()
    return path.parent if path.suffix else path
